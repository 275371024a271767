//! Files of a gigabyte open at once: their voxels are read when they are asked for.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use tempfile::TempDir;
use vr_io::{Loaded, ReadOptions, read};

const GIGABYTE: u64 = 1 << 30;

/// A file that begins with a text and goes on with zeros: sparse, where the system knows such files.
fn sparse(folder: &TempDir, name: &str, head: &[u8], bytes: u64, tail: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    let mut file = File::create(&path).unwrap();
    file.write_all(head).unwrap();
    file.set_len(head.len() as u64 + bytes).unwrap();
    drop(file);
    File::options().append(true).open(&path).unwrap().write_all(tail).unwrap();
    path
}

/// A VTK image with appended raw numbers at a multiple of eight bytes.
fn vti_head(kind: &str, dims: [usize; 3]) -> Vec<u8> {
    let extent = dims.map(|n| format!("0 {}", n - 1)).join(" ");
    let mut head = format!(
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\
         <ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"{extent}\">\
         <PointData><DataArray type=\"{kind}\" Name=\"v\" format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData>\
         <AppendedData encoding=\"raw\">"
    );
    head += &" ".repeat(7 - head.len() % 8);
    let mut head = (head + "_").into_bytes();
    head.extend(GIGABYTE.to_le_bytes());
    head
}

fn opened(path: &PathBuf) -> (Loaded, Duration) {
    let start = Instant::now();
    let loaded = read(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    (loaded, start.elapsed())
}

#[test]
fn opening_reads_no_voxel() {
    let folder = tempfile::tempdir().unwrap();
    let tail = b"</AppendedData></VTKFile>\n";
    let files = [
        sparse(&folder, "x_1024x1024x1024_uint8.raw", b"", GIGABYTE, b""),
        sparse(&folder, "x_1024x1024x256_float32.raw", b"", GIGABYTE, b""),
        sparse(&folder, "u16.vti", &vti_head("UInt16", [1024, 1024, 512]), GIGABYTE, tail),
        sparse(&folder, "f32.vti", &vti_head("Float32", [1024, 1024, 256]), GIGABYTE, tail),
    ];
    for path in files {
        let (loaded, opening) = opened(&path);
        assert!(loaded.info.mapped, "{}", path.display());
        // A pass over all voxels, for comparison: other programs may be at work, and slow both.
        let start = Instant::now();
        assert_eq!(loaded.volume.value_range(), Some((0.0, 0.0)));
        let pass = start.elapsed();
        println!("{}: opened in {opening:?}, all voxels read in {pass:?}", path.display());
        assert!(opening < pass / 4, "{}: {opening:?} of {pass:?}", path.display());
    }
}

#[test]
fn what_is_missing_is_counted_when_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let ends = [f32::NAN, f32::INFINITY, 2.0];
    let head: Vec<u8> = ends.iter().flat_map(|x| x.to_le_bytes()).collect();
    let path = sparse(&folder, "x_256x256x256_float32.raw", &head, 4 * (1 << 24) - 12, b"");
    let (loaded, _) = opened(&path);
    assert!(loaded.info.mapped && !loaded.notes.iter().any(|n| n.contains("NaN")), "{:?}", loaded.notes);
    let grid = loaded.volume.grid().unwrap();
    let stats = grid.value_stats();
    assert_eq!((stats.range, stats.nan, stats.infinite), (Some((0.0, 2.0)), 1, 1));
    // A scene is drawn: its notes tell.
    let scene = folder.path().join("x.toml");
    std::fs::write(&scene, "[volume]\npath = \"x_256x256x256_float32.raw\"\n").unwrap();
    let notes = vr_io::load_scene(&scene).unwrap_or_else(|e| panic!("{e}")).notes.join("; ");
    assert!(
        notes.contains("1 of 16777216 voxels are NaN") && notes.contains("1 of 16777216 voxels are infinite"),
        "{notes}"
    );
}
