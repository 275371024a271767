//! Meshes of cells: told of, drawn, chosen by flags, refused in one line.

use crate::harness::Vr;

/// Two tetrahedra on both sides of a triangle, and a triangle that is left out; a scalar, a vector, and a number of each cell.
const MESH: &str = r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="5" NumberOfCells="3">
<PointData Scalars="heat">
<DataArray type="Float64" Name="heat">1 2 3 8 10</DataArray>
<DataArray type="Float32" Name="wind" NumberOfComponents="3">0 3 4 0 0 0 0 0 0 0 0 0 0 0 1</DataArray>
</PointData>
<CellData><DataArray type="Int32" Name="part">4 6 9</DataArray></CellData>
<Points><DataArray type="Float32" NumberOfComponents="3">0 0 0 1 0 0 0 1 0 0.3 0.3 1 0.3 0.3 -1</DataArray></Points>
<Cells>
<DataArray type="Int32" Name="connectivity">0 1 2 3 0 2 1 4 0 1 2</DataArray>
<DataArray type="Int32" Name="offsets">4 8 11</DataArray>
<DataArray type="UInt8" Name="types">10 10 5</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>"#;

#[test]
fn info_tells_of_cells() {
    let vr = Vr::new();
    vr.write("m.vtu", MESH);
    let run = vr.run("info m.vtu").succeeded();
    for word in [
        "m.vtu, 2 cells",
        "VTK UnstructuredGrid",
        "heat, wind, part",
        "2 tetrahedra, 5 vertices, values of vertices",
        "0 0 -1 to 1 1 1",
        "0.333333 cubic units",
        "6 faces without",
        "1 to 10",
        "histogram",
    ] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    assert!(run.stderr.contains("array 'heat' of the points is taken, the active scalars"), "{}", run.stderr);
    assert!(run.stderr.contains("1 cells of fewer than three dimensions"), "{}", run.stderr);
    let json = vr.run("info m.vtu --json --value part").succeeded().json();
    assert_eq!(
        (&json["cells"], &json["values_of"], &json["range"]),
        (&2.into(), &"cells".into(), &serde_json::json!([4.0, 6.0]))
    );
    assert_eq!(json["file"]["arrays"], serde_json::json!(["heat", "wind", "part"]));
    assert_eq!(json["repairs"]["degenerate"], 0);
    let shares: f64 = json["histogram"].as_array().unwrap().iter().map(|share| share.as_f64().unwrap()).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    let json = vr.run("info m.vtu --json --value wind").succeeded().json();
    assert_eq!(json["range"], serde_json::json!([0.0, 5.0]));
    let json = vr.run("info m.vtu --json --value wind --component 1").succeeded().json();
    assert_eq!(json["range"], serde_json::json!([0.0, 3.0]));
    let json = vr.run("info m.vtu --json --as points --radius 1").succeeded().json();
    assert_eq!(json["points"], 5);
}

#[test]
fn a_mesh_is_drawn() {
    let vr = Vr::new();
    vr.write("m.vtu", MESH);
    vr.run("render m.vtu --size 24 --error none -o a.png").succeeded();
    let lit = vr.picture("a.png").to_rgb8().pixels().filter(|p| p.0.iter().any(|&c| c > 8)).count();
    assert!(lit > 20 && lit < 24 * 24, "{lit} pixels show anything");
    // The reference agrees with what is drawn.
    let json = vr.run("render m.vtu --size 12 --json -o b.png").succeeded().json();
    assert!(json["error"].is_object() || json["error"].is_null(), "{json}");
    vr.write("s.toml", "[volume]\npath = \"m.vtu\"\nvalue = \"part\"\nas = \"cells\"\n[image]\nsize = [8, 8]\n");
    vr.run("render --scene s.toml --error none -o c.png").succeeded();
    assert_eq!(vr.files(), ["a.png", "b.png", "c.png", "m.vtu", "s.toml"]);
}

#[test]
fn wrong_choices_get_one_line() {
    let vr = Vr::new();
    vr.write("m.vtu", MESH);
    vr.write("bad.vtu", MESH.replace("0 1 2 3 0 2 1 4", "0 1 2 3 0 2 1 7"));
    vr.write("p.csv", "x,y,z\n0,0,0\n1,0,0\n");
    for (arguments, code, words) in [
        ("info m.vtu --value cold", 1, &["array", "cold", "heat, wind, part"][..]),
        ("info m.vtu --component 1", 1, &["component", "'heat' has 1"]),
        ("info m.vtu --frame 3", 1, &["frame", "the file has 1"]),
        ("info m.vtu --radius 1", 2, &["volume.radius", "as = \"points\""]),
        ("info m.vtu --as lines", 2, &["--as", "`points`"]),
        ("info m.vtu -o x.png", 2, &["--output", "found: mesh of cells"]),
        ("info bad.vtu", 1, &["bad.vtu: cell 1", "vertex 7", "there are 5"]),
        ("info p.csv --as cells", 1, &["as", "only files of cells"]),
        ("info --phantom fog --as points", 2, &["volume.as"]),
        ("convert m.vtu x.nrrd", 1, &["cannot be converted", "cells are no voxels"]),
    ] {
        let error = vr.run(arguments).failed(code);
        for word in words {
            assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
        }
    }
}
