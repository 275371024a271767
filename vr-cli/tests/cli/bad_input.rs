//! Bad input gets one line, an exit code of 1 or 2, and leaves no file behind.

use std::time::{Duration, Instant};

use crate::harness::{Vr, test_data};

/// Runs `vr render` and expects an error that contains all the words.
#[track_caller]
fn refused(vr: &Vr, arguments: &str, code: i32, words: &[&str]) {
    let before = vr.files();
    let error = vr.run(&format!("render --size 8 --error none {arguments}")).failed(code);
    for word in words {
        assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
    }
    assert_eq!(vr.files(), before, "{arguments}");
}

#[test]
fn flags_that_cannot_be() {
    let vr = Vr::new();
    for (arguments, words) in [
        ("--size 0x8", &["size", "[0, 8]"][..]),
        ("--size big", &["--size", "big", "512x256"]),
        ("--samples 0", &["samples", "0"]),
        ("--eye 0,0,0 --target 0,0,0", &["camera.eye", "differ"]),
        ("--eye 0,0,9 --target 0,0,0 --up 0,0,1", &["camera.up", "parallel"]),
        ("--eye nan,0,0", &["camera.eye", "finite"]),
        ("--fov 180", &["camera.fov", "180"]),
        ("--height 0", &["camera.height", "0"]),
        ("--transfer ct-bones", &["ct-bones", "ct-bone"]),
        ("--phantom teapot", &["teapot", "fog"]),
        ("--phantom fog --phantom-size 1", &["1"]),
        (
            "--renderer raytrace",
            &["raytrace", "raycast", "shearwarp", "texslice", "splat", "march", "project", "physics"],
        ),
        ("--set stop=1", &["stop", "step"]),
        ("--set step=-1", &["step", "-1"]),
        // A ray that would not end.
        ("--set step=1e-9", &["step", "0.000000001", "1.1e11 steps", "1e8"]),
        ("--set step", &["KEY=VALUE"]),
        ("--filter linear", &["linear", "trilinear"]),
        ("--point 1,0,0,0,0.5 --point 0,0,0,0,0.5", &["points[1].value", "sorted"]),
        ("--point 1,0,0,0,1.5", &["points[0].opacity", "1.5", "[0, 1]"]),
        ("--point 1,0,0,0,nan", &["points[0].opacity", "NaN"]),
        ("--point 1,0,0,-1,0.5", &["points[0].color", "-1"]),
        ("--unit-distance 0", &["unit_distance", "0"]),
        // Beyond what arithmetic can keep.
        ("--unit-distance 1e-46", &["unit_distance", "1e-46", "1e-24 to 1e24"]),
        ("--point 0,1e13,0,0,0.5", &["points[0].color", "1e12"]),
        ("--point 0,inf,0,0,0.5", &["points[0].color", "1e12"]),
        ("--diffuse 1e20", &["shading.diffuse", "1e20", "1000"]),
        ("--power 1e9", &["shading.power", "10000"]),
        ("--eye 0,1e200,0", &["camera.eye", "1e200", "1e30"]),
        ("--eye 0,1e25,0 --height 1", &["camera.eye", "1e25", "1e10 heights"]),
        ("--height 1e-40", &["camera", "1e10 heights"]),
        ("--fov 1e-9", &["camera.fov", "1e-9", "1e-6"]),
        ("--crop 1,1,1,0,0,0", &["clip.box"]),
        ("--clip-plane 0,0,0,1", &["clip.planes[0]"]),
        ("--background nan,0,0", &["background"]),
        ("--threshold 3", &["threshold", "first"]),
        ("--compositing first", &["threshold"]),
        ("--compositing accumulate --level 2", &["level", "2"]),
        ("--ambient -1", &["shading.ambient", "-1"]),
        ("--light 0,0,0", &["shading.lights[0]"]),
        ("--max-error 1e-9", &["max-error", "1e-6"]),
        ("--max-error 0.001 --set step=1", &["max-error", "uniform"]),
        ("--renderer texslice --max-error 0.001", &["texslice", "cannot bound"]),
        ("--renderer shearwarp --set slice-distance=16", &["slice-distance", "16", "0.01 to 1 voxel"]),
        ("--renderer splat --set low-pass=-1", &["low-pass", "a number from 0 to 16"]),
        ("--threads 0", &["--threads", "0"]),
        ("--sise 9", &["--sise", "--size"]),
        ("-o x.jpg", &["x.jpg", "png", "exr"]),
        ("-o x", &["png", "exr"]),
        ("a.nrrd --phantom fog", &["--phantom"]),
        ("x.raw --dims 2x2x2", &["--type"]),
        ("--dims 2x2x2 --type u8", &["volume.dims", "phantom"]),
        ("--frame 1", &["volume.frame", "phantom"]),
    ] {
        refused(&vr, arguments, 2, words);
    }
    assert_eq!(vr.run("").code, 2);
    vr.run("draw").failed(2);
}

/// Spacings of 10⁻⁴⁶ are 0 in f32: the ray caster went on for ever.
#[test]
fn spacings_that_arithmetic_cannot_keep() {
    let vr = Vr::new();
    for spacing in ["1e-46", "1e40", "inf"] {
        let scene =
            format!("[volume]\ndims = [2, 2, 2]\ndata = [0, 1, 0, 1, 0, 1, 0, 1]\nspacing = [1.0, {spacing}, 1.0]\n");
        vr.write("scene.toml", scene);
        refused(&vr, "--scene scene.toml", 1, &["scene.toml", "spacing of axis 1", "1e-24 to 1e24"]);
    }
    vr.write("scene.toml", "[volume]\ndims = [2, 2, 2]\ndata = [0, 1, 0, 1, 0, 1, 0, 1]\norigin = [0, 1e15, 0]\n");
    refused(&vr, "--scene scene.toml", 1, &["scene.toml", "origin", "1e12 steps"]);
}

/// Every renderer draws the same picture of a scene that is scaled to the ends of what is allowed.
#[test]
fn the_ends_of_what_is_allowed_are_drawn() {
    let vr = Vr::new();
    let scene = |scale: f64| {
        format!(
            "[volume]\ndims = [3, 3, 3]\ndata = [0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 1, 2, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0]\n\
             spacing = [{scale:e}, {scale:e}, {scale:e}]\n\
             [transfer]\nunit_distance = {scale:e}\n\
             points = [{{ value = 0.0, color = [0.0, 0.0, 1.0], opacity = 0.0 }}, {{ value = 2.0, color = [1.0, 0.5, 0.0], opacity = 0.6 }}]\n\
             [shading]\n[image]\nsize = [16, 16]\n"
        )
    };
    for renderer in ["raycast", "shearwarp", "texslice", "splat", "physics"] {
        vr.write("one.toml", scene(1.0));
        vr.run(&format!("render --scene one.toml --renderer {renderer} --error none -o one.exr")).succeeded();
        for scale in [1e-24, 1e24] {
            vr.write("far.toml", scene(scale));
            vr.run(&format!("render --scene far.toml --renderer {renderer} --error none -o far.exr")).succeeded();
            let diff = vr.run("diff one.exr far.exr --json").succeeded().json();
            let max = diff["error"]["max"].as_f64().or(diff["max"].as_f64());
            assert!(max.is_some_and(|max| max < 1e-4), "{renderer} {scale:e}: {diff}");
        }
    }
}

#[test]
fn places_that_cannot_be_written() {
    let vr = Vr::new();
    std::fs::create_dir(vr.folder().join("folder.png")).unwrap();
    refused(&vr, "-o nowhere/x.png", 1, &["nowhere/x.png", "written"]);
    refused(&vr, "-o folder.png", 1, &["folder.png", "written"]);
    // Nothing can be made in /proc, not even by root.
    if cfg!(target_os = "linux") {
        refused(&vr, "-o /proc/x.png", 1, &["/proc/x.png", "written"]);
    }
}

#[test]
fn volumes_that_cannot_be() {
    let vr = Vr::new();
    refused(&vr, "missing.nrrd", 1, &["missing.nrrd"]);
    vr.write("text.nrrd", "hello");
    refused(&vr, "text.nrrd", 1, &["text.nrrd"]);
    vr.write("short_4x4x4_uint8.raw", [0; 63]);
    refused(&vr, "short_4x4x4_uint8.raw", 1, &["short_4x4x4_uint8.raw", "64", "63"]);
    vr.write("flat_4x4x1_uint8.raw", [0; 16]);
    refused(&vr, "flat_4x4x1_uint8.raw", 1, &["flat_4x4x1_uint8.raw", "2"]);
    refused(&vr, ".", 1, &["."]);
    vr.write("x.bin", [0; 8]);
    refused(&vr, "x.bin --dims 2x2x2 --type u8 --spacing 0,1,1", 1, &["spacing", "0"]);
    refused(&vr, "x.bin --dims 2x2x2 --type quaternion", 2, &["quaternion"]);
    refused(&vr, "x.bin --dims 2x2x2 --type u8 --endian middle", 2, &["middle"]);
}

#[test]
fn scene_files_that_cannot_be() {
    let vr = Vr::new();
    let inline = "[volume]\ndata = [0, 1, 2, 3, 4, 5, 6, 7]\ndims = [2, 2, 2]\n";
    let point = |value: &str, opacity: &str| format!("{{value = {value}, color = [0, 0, 0], opacity = {opacity}}}");
    let points = |a: String, b: String| format!("{inline}[transfer]\npoints = [{a}, {b}]\n");
    let camera =
        |eye: &str, up: &str| format!("{inline}[camera]\neye = [{eye}]\ntarget = [1, 1, 1]\nup = [{up}]\nheight = 3\n");
    let scenes: Vec<(String, &[&str])> = vec![
        ("[volume\n".to_owned(), &["bad.toml"]),
        ("[volum]\n".to_owned(), &["volum", "volume"]),
        (format!("{inline}[image]\nsise = [8, 8]\n"), &["sise", "size"]),
        (format!("{inline}[render]\nstop = 3\n"), &["stop", "step"]),
        (format!("{inline}[render]\nrenderer = \"raytrace\"\n"), &["raytrace", "raycast"]),
        (format!("{inline}[transfer]\npoints = []\n"), &["transfer.points"]),
        (points(point("1.0", "0.5"), point("0.0", "0.5")), &["transfer.points[1].value", "sorted"]),
        (points(point("0.0", "0.5"), point("1.0", "1.5")), &["transfer.points[1].opacity", "1.5"]),
        (points(point("0.0", "-0.5"), point("1.0", "0.5")), &["transfer.points[0].opacity", "-0.5"]),
        (points(point("0.0", "nan"), point("1.0", "0.5")), &["transfer.points[0].opacity", "NaN"]),
        (points(point("nan", "0.0"), point("1.0", "0.5")), &["transfer.points[0].value", "NaN"]),
        (format!("{inline}[transfer]\npreset = \"ct-bones\"\n"), &["ct-bones"]),
        (camera("1, 1, 1", "0, 1, 0"), &["camera.eye", "differ"]),
        (camera("1, 9, 1", "0, 1, 0"), &["camera.up", "parallel"]),
        (camera("1, nan, 1", "0, 1, 0"), &["camera.eye", "finite"]),
        ("[volume]\ndata = [0, 1]\ndims = [2, 2, 2]\n".to_owned(), &["2"]),
        (format!("{inline}spacing = [1, 0, 1]\n"), &["spacing", "0"]),
        (format!("{inline}spacing = [1, nan, 1]\n"), &["spacing", "NaN"]),
        (format!("{inline}direction = [[1, 0, 0], [0, 1, 0], [1, 1, 0]]\n"), &["direction"]),
        (format!("{inline}type = \"u9\"\n"), &["u9", "u8"]),
        ("[volume]\nphantom = \"teapot\"\n".to_owned(), &["teapot"]),
        ("[volume]\npath = \"missing.nrrd\"\n".to_owned(), &["missing.nrrd"]),
    ];
    for (scene, words) in scenes {
        vr.write("bad.toml", &scene);
        let error = vr.run("render --error none --scene bad.toml").failed(1);
        // A volume that cannot be read is named itself.
        let place = if scene.contains("missing.nrrd") { "missing.nrrd" } else { "bad.toml" };
        for word in words.iter().chain(&[place]) {
            assert!(error.contains(word), "{scene}: no {word:?} in {error}");
        }
        assert_eq!(vr.files(), ["bad.toml"]);
    }
    vr.write("bad.toml", format!("{inline}[image]\nsize = [0, 8]\n"));
    vr.run("render --error none --scene bad.toml").failed(1);
    vr.run("render --error none --scene missing.toml").failed(1);
}

/// Files under `bad/` that hold a volume all the same, or one of several.
const VALID: [&str; 10] = [
    "constant.nrrd",
    "nan_inf.nrrd",
    "nan_be_f32.nii",
    "nifti_slope_zero.nii",
    "nan_spacing.nrrd",
    "rgb24.nii.gz",
    "rtdose.dcm",
    "tets_inverted.vtk",
    "tets_degenerate.vtk",
    "tets_nan_scalar.vtk",
];

#[test]
fn broken_files_of_every_kind_are_refused() {
    let Some(data) = test_data() else { return };
    let vr = Vr::new();
    let mut met = 0;
    for entry in std::fs::read_dir(data.join("bad")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let start = Instant::now();
        let run = vr.run_with(&["render", path.to_str().unwrap(), "--size", "16", "--error", "none", "-o", "x.png"]);
        assert!(start.elapsed() < Duration::from_secs(10), "{name} takes {:?}", start.elapsed());
        if name == "tets_no_scalars.vtk" {
            // Without values there are sound points, drawn where a renderer draws points.
            assert!(run.stderr.contains("their points are taken") && run.code <= 2, "{name}: {}", run.stderr);
            let _ = std::fs::remove_file(vr.folder().join("x.png"));
        } else if VALID.contains(&name.as_str()) && run.code == 0 {
            std::fs::remove_file(vr.folder().join("x.png")).unwrap();
        } else {
            let error = run.failed(1);
            assert!(error.contains(&name), "{error}");
            println!("{error}");
        }
        assert!(vr.files().is_empty(), "{name} leaves {:?}", vr.files());
        met += 1;
    }
    assert!(met > 40, "only {met} files");
}

#[test]
fn real_files_render() {
    let Some(data) = test_data() else { return };
    let vr = Vr::new();
    for file in [
        "nrrd/tooth.nhdr",
        "nrrd/stent.nrrd",
        "nrrd/headsq/quarter.nhdr",
        "nifti/FLAIR.nii.gz",
        "nifti/shear.nii.gz",
        "nifti/anatomical_be.nii",
        "metaimage/HeadMRVolume.mhd",
        "metaimage/cthead_256x256x99.mhd",
        "raw/fuel_64x64x64_uint8.raw",
        "raw/engine_256x256x128_uint8.raw.gz",
    ] {
        let path = data.join(file);
        let path = path.to_str().unwrap();
        vr.run_with(&["render", path, "--size", "32", "--error", "none", "-o", "x.png"]).succeeded();
        let lit = vr.picture("x.png").to_rgb8().pixels().filter(|p| p.0.iter().any(|&c| c > 8)).count();
        assert!(lit > 30, "{file}: {lit} pixels show anything");
        vr.run_with(&["info", path]).succeeded();
    }
}
