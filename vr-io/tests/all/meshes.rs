//! Every format and variant of meshes, and what is said of those that are broken.

use glam::DVec3;
use vr_core::TriangleMesh;
use vr_io::{FileError, FileErrorKind, LoadedMesh, is_mesh, read_mesh};

use crate::small_meshes::{CORNERS, FACES, obj, ply_binary, ply_text, stl_binary, stl_text};

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<LoadedMesh, FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_mesh(&path)
}

/// The corners of each triangle, whatever their vertices are called.
fn corners(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles().len()).map(|i| mesh.corners(i)).collect()
}

#[test]
fn all_formats_hold_the_same_tetrahedron() {
    let expected: Vec<[DVec3; 3]> = FACES.iter().map(|f| f.map(|v| CORNERS[v as usize].into())).collect();
    let files: [(&str, Vec<u8>, &str); 7] = [
        ("a.stl", stl_text().into_bytes(), "STL (text)"),
        ("b.stl", stl_binary(b"made by hand"), "STL (binary)"),
        ("c.stl", stl_binary(b"solid, and yet binary"), "STL (binary)"),
        ("d.obj", obj().into_bytes(), "OBJ"),
        ("e.ply", ply_text().into_bytes(), "PLY (text)"),
        ("f.ply", ply_binary(false), "PLY (binary)"),
        ("g.ply", ply_binary(true), "PLY (binary)"),
    ];
    for (name, bytes, format) in files {
        let loaded = read(name, bytes).unwrap();
        assert_eq!((loaded.format, corners(&loaded.mesh)), (format, expected.clone()), "{name}");
        assert_eq!(loaded.mesh.positions().len(), 4, "{name}: shared");
        assert!(loaded.notes.is_empty(), "{name}");
    }
}

#[test]
fn colours_are_made_linear() {
    for bytes in [ply_text().into_bytes(), ply_binary(false), ply_binary(true)] {
        let mesh = read("x.ply", bytes).unwrap().mesh;
        let colors = mesh.colors().unwrap();
        assert_eq!(colors[0], [1.0, 0.0, 0.0]);
        // 188 of 255 is half of the light.
        assert!((colors[1][1] - 0.5).abs() < 3e-3, "{colors:?}");
        assert_eq!(mesh.normals().unwrap()[2], [0.0, 1.0, 0.0]);
    }
    let mesh = read("x.obj", "v 0 0 0 1 0.5 0\nv 1 0 0\nv 0 1 0 0 0 1\nf 1 2 3\n").unwrap().mesh;
    let colors = mesh.colors().unwrap();
    assert_eq!((colors[0][0], colors[1], colors[2]), (1.0, [1.0; 3], [0.0, 0.0, 1.0]));
    assert!((colors[0][1] - 0.214_041).abs() < 1e-6, "{colors:?}");
}

#[test]
fn obj_counts_backwards_continues_lines_and_repeats_vertices_with_two_normals() {
    let text = "# a bent square\nmtllib x.mtl\no bent\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvt 0 0\nvn 0 0 2\nvn 0 1 0\n\
                usemtl red\nf -4//1 2/1/1 \\\n 3//1\nf 1//2 3//2 4\nl 1 2\n";
    let mesh = read("x.obj", text).unwrap().mesh;
    let corner = |i: usize, p: [f64; 3]| assert_eq!(mesh.positions()[i], DVec3::from(p));
    assert_eq!(mesh.triangles(), [[0, 1, 2], [3, 4, 5]]);
    corner(0, [0.0; 3]);
    corner(3, [0.0; 3]);
    assert_eq!(
        mesh.normals().unwrap()[..],
        [[0.0, 0.0, 2.0], [0.0, 0.0, 2.0], [0.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]
    );
}

#[test]
fn polygons_are_cut_and_that_is_said() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let loaded = read("x.obj", text).unwrap();
    assert_eq!(loaded.mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
    assert!(loaded.notes[0].starts_with("1 polygons"), "{:?}", loaded.notes);
}

#[test]
fn texts_of_several_solids_are_read_whole() {
    let two = stl_text().to_uppercase() + &stl_text();
    assert_eq!(read("x.stl", two).unwrap().mesh.triangles().len(), 8);
}

#[test]
fn a_mesh_is_told_from_a_volume() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, expected) in
        [("a.stl", "", true), ("b", "ply\nformat ascii 1.0\n", true), ("c.nrrd", "NRRD0004\n", false)]
    {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(is_mesh(&path), expected, "{name}");
    }
    assert!(!is_mesh(folder.path().join("none.stl")));
    let error = vr_io::read(folder.path().join("a.stl"), &vr_io::ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("a surface, not a volume"), "{error}");
}

/// Checks that the error is one line with all of these words.
#[track_caller]
fn refused(name: &str, bytes: impl AsRef<[u8]>, words: &[&str]) {
    let error = read(name, bytes).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    for word in words.iter().chain([&name]) {
        assert!(error.contains(word), "no {word:?} in {error}");
    }
}

#[test]
fn broken_files_are_refused_with_reasons() {
    let binary = stl_binary(b"");
    refused("x.stl", &binary[..100], &["length", "100 bytes", "4 triangles", "284"]);
    refused("x.stl", &binary[..83], &["83 bytes", "at least 84"]);
    let mut huge = binary.clone();
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    refused("x.stl", &huge, &["4294967295 triangles", "214748364834"]);
    let mut nan = binary.clone();
    nan[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
    refused("x.stl", &nan, &["vertex 0", "NaN", "finite"]);
    refused("x.stl", stl_binary(b"").split_at(84).0, &["length"]);

    let text = stl_text();
    refused("x.stl", text.rsplit_once("endsolid").unwrap().0, &["end of the file", "endsolid"]);
    refused("x.stl", text.split_at(text.len() / 2).0, &[]);
    refused("x.stl", text.replacen("vertex", "vortex", 1), &["line 4", "vortex", "vertex"]);
    refused(
        "x.stl",
        text.replacen("vertex", "endloop\nvertex", 1).replacen("vertex", "endfacet\nvertex", 1),
        &["0 of them", "three"],
    );
    refused("x.stl", text.replacen("vertex 0", "vertex nine", 1), &["line 4", "nine", "three numbers"]);
    refused("x.stl", text.replacen("vertex 0", "vertex inf", 1), &["vertex 0", "inf"]);
    refused("x.stl", "solid nothing\nendsolid\n", &["no triangle"]);

    refused("x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["triangle 0", "vertex 3", "there are 3"]);
    refused("x.obj", "v 0 0 0\nvn 0 0 1\nf 1//1 1//1 1//2\n", &["normal 2", "there are 1"]);
    refused("x.obj", "v 0 0 0\nvn 0 0 1\nf 1//1 1//1 9//1\n", &["vertex 9", "there are 1"]);
    refused("x.obj", "v 0 0 0\nf 0 1 1\n", &["line 2", "f 0 1 1"]);
    refused("x.obj", "v 0 0 0\nf 1 -2 1\n", &["line 2"]);
    refused("x.obj", "v 0 0 0\nf 1 1\n", &["line 2", "three corners"]);
    refused("x.obj", "v 0 0\n", &["line 1", "three numbers"]);
    refused("x.obj", "v 0 0 nan\nf 1 1 1\n", &["vertex 0", "NaN"]);
    refused("x.obj", "v 0 0 1e300\nf 1 1 1\n", &["1e300", "1e100"]);
    refused("x.obj", "v 0 0 0 -1 0 0\nf 1 1 1\n", &["colour", "negative"]);
    refused("x.obj", "\0\u{1}\u{2}", &["no triangle"]);

    let text = ply_text();
    refused("x.ply", text.replace("vertex 4", "vertex 400000000000"), &["element vertex", "400000000000", "fit in"]);
    refused("x.ply", text.replace("face 4", "face 5"), &["line", "expected 5, got 4"]);
    refused("x.ply", text.replace("3 0 2 1", "3 0 2 9"), &["vertex 9", "there are 4"]);
    refused("x.ply", text.replace("3 0 2 1", "3 0 -2 1"), &["vertex 4294967295"]);
    refused("x.ply", text.replace("3 0 2 1", "2 0 2"), &["face 0", "2 of them"]);
    refused("x.ply", text.replace("3 0 2 1", "4000000000 0 2 1"), &["line", "element line"]);
    refused("x.ply", text.replace("property double x", "property double u"), &["element vertex", "x, y and z"]);
    refused("x.ply", text.replace("element face", "element facet"), &["no element face"]);
    refused("x.ply", text.replace("end_header", "element nothing 99999999999999999\nend_header"), &["element nothing"]);
    refused("x.ply", "ply\nformat ascii 1.0\n", &["line", "end of file"]);
    for swapped in [false, true] {
        let binary = ply_binary(swapped);
        refused("x.ply", &binary[..binary.len() - 1], &["data", "end of file"]);
    }
    refused("x.raw", "solid", &["STL", "OBJ", "PLY"]);
    let missing = read_mesh("nowhere.stl").unwrap_err();
    assert!(matches!(missing.kind, FileErrorKind::Io(_)), "{missing}");
}
