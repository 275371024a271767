//! Two-dimensional transfer functions in files: read, written, refused.

use std::path::Path;

use vr_core::transfer::srgb_to_linear;
use vr_core::{ControlPoint, OpacityRule, TransferFunction};
use vr_io::{
    SceneFile, SceneFileError, TransferSource, parse_scene, parse_transfer, read_transfer, resolve_scene, scene_text,
    write_transfer,
};

const ROWS: &str = r#"
[transfer]
unit_distance = 2.0
colors = "srgb"
[[transfer.rows]]
gradient = 0.5
points = [{ value = 0.0, color = [0.5, 0.5, 0.5], opacity = 0.0 }]
[[transfer.rows]]
gradient = 3.0
points = [
  { value = 0.2, color = [1.0, 0.5, 0.0], opacity = 0.0 },
  { value = 0.8, color = [1.0, 0.5, 0.0], opacity = 0.9 },
]
"#;

fn scene(transfer: &str) -> Result<vr_core::Scene, String> {
    let text = format!("[volume]\nphantom = \"fog\"\nsize = 4\n{transfer}");
    let file = parse_scene(&text, Path::new("s.toml")).map_err(|e| e.to_string())?;
    resolve_scene(&file, Path::new("")).map(|loaded| loaded.scene).map_err(|e| e.to_string())
}

#[test]
fn rows_of_a_scene_file_make_a_transfer_function() {
    let scene = scene(ROWS).unwrap();
    let rows = scene.transfer.rows();
    assert_eq!(rows.iter().map(|row| row.gradient).collect::<Vec<_>>(), [0.5, 3.0]);
    assert_eq!(scene.transfer.unit_distance(), 2.0);
    let half = srgb_to_linear(0.5);
    assert_eq!(rows[0].transfer.points(), [ControlPoint::new(0.0, [half; 3], 0.0)]);
    assert_eq!(rows[1].transfer.points()[1], ControlPoint::new(0.8, [1.0, half, 0.0], 0.9));
    assert!(scene.shading.is_none(), "rows need no shading");
}

#[test]
fn a_scene_with_rows_comes_back_as_it_was() {
    let scene = scene(ROWS).unwrap();
    let camera = vr_core::Camera::framing(scene.volume.bounds(), 30.0, 20.0, None);
    let view = vr_core::View::new(camera, [4, 4]);
    let described = SceneFile::describe(&scene, &view).unwrap();
    let completed = described.completed(&scene, None, &view, None);
    for file in [described, completed] {
        let text = scene_text(&file).unwrap();
        let again = parse_scene(&text, Path::new("")).unwrap();
        assert_eq!(again, file);
        assert_eq!(resolve_scene(&again, Path::new("")).unwrap().scene.transfer, scene.transfer);
        let commented = vr_io::commented_scene(&file, "A scene", &[]).unwrap();
        assert_eq!(parse_scene(&commented, Path::new("")).unwrap(), file, "{commented}");
    }
}

#[test]
fn files_hold_rows_to_the_last_digit() {
    let points = |a: f64| vec![ControlPoint::new(0.1, [0.3, 1.0 / 3.0, 0.0], a), ControlPoint::new(0.7, [1.0; 3], a)];
    let rows = vec![(0.0, points(0.0)), (1.0 / 3.0, points(0.2)), (1e5, points(0.999))];
    let transfer = TransferFunction::of_rows(rows, OpacityRule::Power, 0.7).unwrap();
    let source = TransferSource { name: "x", transfer: &transfer, shading: None, gradient_per_voxel: &[] };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    assert!(write_transfer(&path, &source).unwrap().is_empty());
    let file = read_transfer(&path).unwrap();
    assert!(file.points.is_empty() && file.rows.len() == 3);
    let back = file.transfer_points(None).function(OpacityRule::Power, 0.7).unwrap();
    assert_eq!(back, transfer);
    // All rows are stretched alike.
    let wide = file.transfer_points(Some((0.0, 6.0))).function(OpacityRule::Power, 0.7).unwrap();
    assert_eq!(wide.rows()[1].transfer.points()[1].value, 6.0);
    for name in ["a.json", "a.vp", "a.csv", "a.lut"] {
        let message = write_transfer(folder.path().join(name), &source).unwrap_err().to_string();
        assert!(message.contains("rows by gradient are held by .toml alone"), "{message}");
        assert!(!folder.path().join(name).exists());
    }
    // As the transfer function of a volume.
    let named = format!("[transfer]\nfile = {:?}\n", path.to_string_lossy());
    assert_eq!(scene(&named).unwrap().transfer.rows().len(), 3);
}

#[test]
fn wrong_rows_are_named() {
    let row = |gradient: &str, rest: &str| {
        format!(
            "[[transfer.rows]]\ngradient = {gradient}\npoints = [{{ value = 0.0, color = [1.0, 1.0, 1.0], opacity = 0.5 }}]\n{rest}\n"
        )
    };
    for (text, word) in [
        (
            format!("{}{}", row("2.0", ""), row("1.0", "")),
            "transfer.rows[1].gradient: found 1.0; rows must be in order",
        ),
        (row("-1.0", ""), "transfer.rows[0].gradient"),
        (row("0.0", "").replace("0.5", "1.0"), "transfer.rows[0].points[0].opacity: found 1.0; must be below 1"),
        (row("0.0", "").replace("gradient", "gradiant"), "did you mean 'gradient'"),
        (row("0.0", "colour = 3"), "unknown key 'colour'"),
        ("[transfer]\nrows = []\n".to_owned(), "transfer.rows: found \"none\"; must have at least one row"),
        (format!("[transfer]\npreset = \"grey\"\n{}", row("0.0", "")), "several of points, rows, preset and file"),
        (format!("[transfer]\nrange = [0.0, 1.0]\n{}", row("0.0", "")), "transfer.range"),
        (
            format!(
                "[transfer]\npoints = [{{ value = 0.0, color = [1.0, 1.0, 1.0], opacity = 0.5 }}]\n{}",
                row("0.0", "")
            ),
            "transfer.rows: found rows; must be absent beside points",
        ),
        (format!("{}[render]\ncompositing = \"maximum\"\n", row("0.0", "")), "goes with over and accumulate"),
        (
            format!("{}[shading]\ngradient_opacity = [[0.0, 1.0]]\n", row("0.0", "")),
            "shading.gradient_opacity: found [(0.0, 1.0)]; must be absent beside rows",
        ),
    ] {
        let message = scene(&text).unwrap_err();
        assert!(message.contains(word), "{text}\n{message}");
    }
    let unknown = parse_scene("[[transfer.rows]]\ngradient = 0.0\npoints = []\nx = 1\n", Path::new(""));
    assert!(matches!(unknown, Err(SceneFileError::UnknownKey { .. })));
    let message = parse_transfer(b"[transfer]\nrows = []\n", Path::new("a.toml")).unwrap_err().to_string();
    assert!(message.contains("transfer.rows: found none; must have at least one row"), "{message}");
}
