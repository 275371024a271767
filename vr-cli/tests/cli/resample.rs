//! Resampling: a mesh becomes a grid in a file, in a picture and beside itself, with an account of what that costs.

use serde_json::json;

use crate::harness::{Vr, test_data};

/// A cube of five tetrahedra around the values x + 2 y + 4 z.
const CUBE: &str = r#"<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="8" NumberOfCells="5">
<PointData Scalars="f"><DataArray type="Float64" Name="f">0 1 2 3 4 5 6 7</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3">0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1</DataArray></Points>
<Cells>
<DataArray type="Int32" Name="connectivity">1 2 4 7 0 1 2 4 3 1 2 7 5 1 4 7 6 2 4 7</DataArray>
<DataArray type="Int32" Name="offsets">4 8 12 16 20</DataArray>
<DataArray type="UInt8" Name="types">10 10 10 10 10</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>"#;

fn cube() -> Vr {
    let vr = Vr::new();
    vr.write("m.vtu", CUBE);
    vr
}

#[test]
fn a_mesh_becomes_a_grid_with_an_account() {
    let vr = cube();
    let run = vr.run("convert m.vtu a.nrrd --resample 5x5x3 --json").succeeded();
    let json = run.json();
    let account = &json["resampled"];
    assert_eq!((&json["dims"], &account["filter"]), (&json!([5, 5, 3]), &json!("point")));
    assert_eq!((&account["vacuum_share"], &account["integral_is_exact"]), (&json!(0.0), &json!(true)));
    // The mean of 0 to 7 over a volume of 1; a linear function is its own grid.
    assert!((account["integral"][0].as_f64().unwrap() - 3.5).abs() < 1e-12);
    assert!(account["integral_error"].as_f64().unwrap() < 1e-6);
    assert!(account["picture"]["max"].as_f64().unwrap() < 0.02, "{account}");
    let info = vr.run("info a.nrrd --json").succeeded().json();
    assert_eq!((&info["range"], &info["spacing"]), (&json!([0.0, 7.0]), &json!([0.25, 0.25, 0.5])));

    let run = vr.run("convert m.vtu b.nrrd --resample 0.3 --resample-filter box --conserve").succeeded();
    for words in ["mesh of cells to 5×5×5 voxels", "by the filter box; none is vacuum", "every voxel times", "RMSE"] {
        assert!(run.stderr.contains(words), "no {words:?} in {}", run.stderr);
    }
    let run = vr.run("convert m.vtu c.nrrd --resample 16,16,16 --to u8 --rescale 0,7").succeeded();
    assert!(run.stdout.contains("16×16×16 u8"), "{}", run.stdout);
    let run = vr.run("convert m.vtu c.nrrd --force --resample 4x4x4 --error none --json").succeeded();
    assert!(run.json()["resampled"]["picture"].is_null() && !run.stderr.contains("RMSE"), "{}", run.stderr);
    assert!(vr.run("convert a.nrrd d.nrrd --resample 3x3x3 --error full").failed(2).contains("no uniform grid"));
    assert!(vr.run("convert m.vtu c.nrrd --error full").failed(2).contains("--resample"));
    // A grid is smoothed on the way to fewer voxels.
    let run = vr.run("convert a.nrrd d.nrrd --resample 3x3x3 --resample-filter box").succeeded();
    assert!(run.stderr.contains("uniform grid to 3×3×3 voxels"), "{}", run.stderr);
}

#[test]
fn renderers_of_grids_draw_a_mesh() {
    let vr = cube();
    let flags = "--resample 12x12x12 --size 16 --error none";
    for renderer in ["shearwarp", "raycast"] {
        let run = vr.run(&format!("render m.vtu {flags} --renderer {renderer} -o {renderer}.png")).succeeded();
        assert!(run.stderr.contains("mesh of cells to 12×12×12"), "{}", run.stderr);
        let lit =
            vr.picture(&format!("{renderer}.png")).to_rgb8().pixels().filter(|p| p.0.iter().any(|&c| c > 8)).count();
        assert!(lit > 20, "{renderer}: {lit} pixels show anything");
    }
    // The record draws the same picture again, and the scene file says how.
    vr.run("rerun raycast.png m.vtu -o again.png").succeeded();
    assert_eq!(vr.picture("raycast.png").to_rgb8(), vr.picture("again.png").to_rgb8());
    let text = "[volume]\npath = \"m.vtu\"\nresample = \"finest\"\nresample_filter = \"box\"\n[image]\nsize = [8, 8]\n";
    vr.write("s.toml", text);
    let run = vr.run("render --scene s.toml --error none -o s.png").succeeded();
    assert!(run.stderr.contains("by the filter box"), "{}", run.stderr);
}

#[test]
fn the_grid_stands_beside_the_mesh() {
    let vr = cube();
    let run = vr.run("compare m.vtu --size 24 -o sheet.png --pictures single --json").succeeded();
    let json = run.json();
    let names: Vec<&str> = json["renderers"].as_array().unwrap().iter().map(|r| r["name"].as_str().unwrap()).collect();
    assert!(names.iter().any(|name| name.starts_with("resampled ") && name.ends_with("raycast")), "{names:?}");
    assert!(!names[0].starts_with("resampled"), "{names:?}");
    let single = json["files"].as_array().unwrap().iter().filter_map(|f| f.as_str()).find(|f| f.contains("resampled"));
    vr.run(&format!("rerun {} m.vtu -o again.png", single.unwrap())).succeeded();
}

#[test]
fn wrong_resampling_is_refused_in_a_line() {
    let vr = cube();
    vr.write("p.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,0\n0,0,1\n");
    vr.write("s.toml", "[volume]\npath = \"m.vtu\"\nconserve = true\n");
    let before = vr.files();
    for (arguments, code, said) in [
        ("convert m.vtu x.nrrd --resample coarse", 2, "a positive spacing, or finest"),
        ("convert m.vtu x.nrrd --resample 1x4x4", 2, "every axis must have 2"),
        ("convert m.vtu x.nrrd --resample 1e-5", 2, "choose a coarser resolution"),
        ("convert m.vtu x.nrrd --resample 4x4x4 --resample-filter cubic", 2, "expected point or box"),
        ("convert m.vtu x.nrrd --conserve", 2, "--resample"),
        ("render m.vtu --resample 1x1x1 -o x.png", 2, "every axis must have 2"),
        ("render --phantom fog --resample 8x8x8 -o x.png", 2, "only a volume that is no grid"),
        ("render --scene s.toml -o x.png", 1, "must go with resample"),
    ] {
        let error = vr.run(arguments).failed(code);
        assert!(error.contains(said), "{arguments}: {error}");
    }
    assert_eq!(vr.files(), before);
    vr.run("convert p.csv p.nrrd --resample 0.5 --resample-filter box").succeeded();
}

/// A real mesh: the picture of its grid is close to its own.
#[test]
fn a_real_mesh_is_resampled() {
    let Some(data) = test_data() else { return println!("VR_TEST_DATA is not set: a real mesh is left out") };
    let vr = Vr::new();
    let mesh = data.join("unstructured/tetraMesh.vtk");
    let place = mesh.display();
    if !mesh.exists() {
        return println!("{place} is not there: left out");
    }
    let json =
        vr.run(&format!("convert {place} m.nrrd --resample 64x64x64 --resample-filter box --json")).succeeded().json();
    let account = &json["resampled"];
    assert!(account["integral_error"].as_f64().unwrap() < 0.2, "{account}");
    assert!(account["picture"]["rmse"].as_f64().unwrap() < 0.2, "{account}");
}
