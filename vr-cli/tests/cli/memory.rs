//! Limits of memory, and of the time that the program takes to say anything.

use std::time::{Duration, Instant};

use crate::harness::Vr;

#[test]
fn what_is_derived_from_a_volume_is_refused_with_what_it_would_need() {
    let vr = Vr::new();
    let voxels: Vec<u8> = (0..1usize << 23).map(|i| (i / 7 % 251) as u8).collect();
    vr.write("x_256x256x128_uint8.raw", &voxels);
    let visible = "x_256x256x128_uint8.raw --point 0,1,1,1,0.4 --point 255,1,1,1,0.5 --size 8 --error none";
    for (arguments, refusal) in [
        // Eight bytes a voxel; the volume itself stays in its file.
        (
            format!("render {visible} --renderer raycast --filter bspline --memory 50MB"),
            "the coefficients of the B-spline would need 67 MB",
        ),
        (format!("render {visible} --renderer shearwarp --memory 4MB"), "the run-length encoded volume would need "),
        (
            format!("render {visible} --renderer texslice --set format=rgba --memory 4MB"),
            "the texture of light would need ",
        ),
        (
            format!("render {visible} --renderer texslice --set format=compressed --memory 3MB"),
            "the compressed texture would need 4.2 MB",
        ),
        (
            format!("render {visible} --renderer splat --set slice-distance=0.02 --memory 10MB"),
            "the sheets of the tiles would need 2.1 MB",
        ),
        (
            format!("render {visible} --labels x_256x256x128_uint8.raw --memory 4MB"),
            "the ranks of labels would need 17 MB",
        ),
    ] {
        let line = vr.run(&arguments).failed(1);
        assert!(line.contains(refusal) && line.contains("of memory are left"), "{arguments}: {line}");
    }
    // With the memory there, it is drawn.
    vr.run(&format!("render {visible} --renderer shearwarp --memory 2GB -o x.png")).succeeded();
}

/// An adaptive mesh of 8³ blocks of 8³ cells of one level, in as many files.
fn mesh_of_many_blocks(vr: &Vr) {
    const BLOCKS: usize = 8;
    let values = "0.1 0.9 ".repeat(256);
    let mut list = String::new();
    for i in 0..BLOCKS.pow(3) {
        let [x, y, z] = [i % BLOCKS, i / BLOCKS % BLOCKS, i / (BLOCKS * BLOCKS)].map(|k| 8 * k);
        list +=
            &format!("<DataSet index=\"{i}\" amr_box=\"{x} {} {y} {} {z} {}\" file=\"{i}.vti\"/>", x + 7, y + 7, z + 7);
        vr.write(
            &format!("{i}.vti"),
            format!(
                "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 8 0 8 0 8\" Origin=\"{x} {y} {z}\" Spacing=\"1 1 1\">\
                 <Piece Extent=\"0 8 0 8 0 8\"><CellData><DataArray type=\"Float32\" Name=\"s\">{values}</DataArray></CellData></Piece>\
                 </ImageData></VTKFile>"
            ),
        );
    }
    vr.write(
        "m.vthb",
        format!(
            "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\"><vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">\
             <Block level=\"0\" spacing=\"1 1 1\">{list}</Block></vtkOverlappingAMR></VTKFile>"
        ),
    );
}

#[test]
fn lattices_of_adaptive_meshes_are_refused() {
    let vr = Vr::new();
    mesh_of_many_blocks(&vr);
    let shown = "render m.vthb --point 0,1,1,1,0.4 --point 1,1,1,1,0.5 --shading --size 8 --error none -o m.png";
    // 10³ and 12³ floats a block.
    let line = vr.run(&format!("{shown} --memory 6MB")).failed(1);
    assert!(line.contains("the lattices of the adaptive mesh would need 5.6 MB, and "), "{line}");
    vr.run(&format!("{shown} --memory 100MB")).succeeded();
}

/// Peak of the memory that a command has taken, in kilobytes, of Linux.
#[cfg(target_os = "linux")]
fn peak_of(command: &mut std::process::Command) -> u64 {
    use std::io::Read;
    let mut process = command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::null()).spawn().unwrap();
    let (status, mut peak) = (format!("/proc/{}/status", process.id()), 0);
    // The file says nothing more of a process that has ended.
    while process.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        peak = line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(peak);
        std::thread::sleep(Duration::from_millis(2));
    }
    let mut text = String::new();
    process.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    assert!(process.wait().unwrap().success() && !text.is_empty());
    peak
}

#[test]
#[cfg(target_os = "linux")]
fn a_volume_is_told_of_in_little_more_than_its_own_memory() {
    let vr = Vr::new();
    // 128 MiB, of noise and of labels: tables of labels took twice as much again.
    let noise = |i: usize| (i as u32).wrapping_mul(2_654_435_761).to_be_bytes()[0];
    let label = |i: usize| (i >> 20) as u8 % 5;
    for (name, of) in [("noise", &noise as &dyn Fn(usize) -> u8), ("labels", &label)] {
        let voxels: Vec<u8> = (0..1 << 27).map(of).collect();
        vr.write(&format!("{name}_512x512x512_uint8.raw"), voxels);
        let peak = peak_of(&mut vr.command(&["info", &format!("{name}_512x512x512_uint8.raw")]));
        println!("{name}: {peak} kB");
        assert!(peak < (128 << 10) + 100_000, "{name}: {peak} kB");
    }
}

#[test]
fn the_version_is_told_at_once() {
    let vr = Vr::new();
    let once = |_| {
        let start = Instant::now();
        vr.run("--version").succeeded();
        start.elapsed()
    };
    // 20 ms are promised; the best of many runs, since other programs may be at work.
    let best = (0..40).map(once).min().unwrap();
    assert!(best < Duration::from_millis(20), "{best:?}");
}
