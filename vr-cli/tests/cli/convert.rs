//! `vr convert`: volumes in other formats.

use crate::harness::Vr;

const HEADER: &str = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 3 2\n\
                      space directions: (0.5,0,0) (0,0.75,0) (0,0,2)\nspace origin: (1,-2,3)\nencoding: raw\n\n";

/// A folder with a patient's volume of 4×3×2 voxels, numbered from 10.
fn scan() -> Vr {
    let vr = Vr::new();
    let mut bytes = HEADER.as_bytes().to_vec();
    bytes.extend(10..34);
    vr.write("scan.nrrd", bytes);
    vr
}

fn info(vr: &Vr, name: &str) -> serde_json::Value {
    vr.run(&format!("info {name} --json")).succeeded().json()
}

#[test]
fn a_pyramid_has_levels_where_they_belong() {
    let vr = Vr::new();
    // Twice as far apart along z.
    let voxels: Vec<u8> = (0..20 * 9 * 3).map(|i: usize| (i % 20 * 10 + i / 20 % 9) as u8).collect();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 9 3\nspacings: 1 1 2\nencoding: raw\n\n";
    vr.write("v.nrrd", [header.as_bytes(), &voxels].concat());
    let run = vr.run("convert v.nrrd v.zarr --levels 3 --reduce mean").succeeded();
    assert!(run.stderr.contains("3 resolutions are written, down to 5×3×2 by the mean"), "{}", run.stderr);
    for (level, dims, spacing, origin) in [
        (0, [20, 9, 3], [1., 1., 2.], [0., 0., 0.]),
        (1, [10, 5, 2], [2., 2., 4.], [0.5, 0.5, 1.]),
        (2, [5, 3, 2], [4., 4., 4.], [1.5, 1.5, 1.]),
    ] {
        let json = vr.run(&format!("info v.zarr --volume-level {level} --json")).succeeded().json();
        assert_eq!(json["dims"], serde_json::json!(dims), "{level}");
        assert_eq!(
            (&json["spacing"], &json["origin"]),
            (&serde_json::json!(spacing), &serde_json::json!(origin)),
            "{level}"
        );
    }
    vr.run("convert v.zarr level.raw --volume-level 1").succeeded();
    let level = std::fs::read(vr.folder().join("level.raw")).unwrap();
    // Tens of x + 0.5, and y + 0.5 of which the half goes to the even number; the last row of y has one voxel.
    assert_eq!(level[..3], [6, 26, 46]);
    assert_eq!(level[40..43], [13, 33, 53]);
    assert!(vr.run("convert v.nrrd w.nrrd --levels 2").failed(2).contains("--levels: only OME-Zarr"));
    assert!(vr.run("convert v.nrrd w.zarr --levels 9").failed(1).contains("must be 1 to 5 for 20×9×3 voxels"));
    assert!(!vr.exists("w.zarr"));
    // Names of regions stay names.
    let labels: Vec<u8> = (0..80 * 8 * 8).map(|i: usize| if i % 80 < 35 { 0 } else { 7 }).collect();
    vr.write("labels_80x8x8_uint8.raw", labels);
    let run = vr.run("convert labels_80x8x8_uint8.raw l.zarr").succeeded();
    assert!(run.stderr.contains("2 resolutions are written, down to 40×4×4 by the mode"), "{}", run.stderr);
    vr.run("convert l.zarr l.raw --volume-level 1").succeeded();
    assert!(std::fs::read(vr.folder().join("l.raw")).unwrap().iter().all(|&v| v == 0 || v == 7));
}

#[test]
fn other_formats_hold_the_same_volume() {
    let vr = scan();
    let before = info(&vr, "scan.nrrd");
    for (name, format) in [("a.nii.gz", "NIfTI-1"), ("a.mhd", "MetaImage"), ("a.vti", "VTK ImageData")] {
        let run = vr.run(&format!("convert scan.nrrd {name}")).succeeded();
        assert!(run.stdout.contains(&format!("{name}: {format}, 4×3×2 u8")), "{}", run.stdout);
        let after = info(&vr, name);
        for field in ["dims", "type", "spacing", "origin", "axes", "range", "histogram"] {
            assert_eq!(after[field], before[field], "{name} {field}");
        }
    }
    let json = vr.run("convert a.mhd b_%03d.png --json").succeeded().json();
    assert_eq!((json["format"].as_str(), json["files"][1].as_str()), (Some("PNG slices"), Some("b_001.png")));
    assert_eq!(vr.picture("b_001.png").to_luma8().into_raw(), (22..34).collect::<Vec<u8>>());
    let run = vr.run("convert --phantom blobs --phantom-size 8 -o blobs.nrrd").succeeded();
    assert!(run.stdout.contains("blobs.nrrd: NRRD, 8×8×8"), "{}", run.stdout);
}

#[test]
fn changes_are_made_and_said() {
    let vr = scan();
    let run = vr.run("convert scan.nrrd --crop 1:3,:,: --flip x x.raw --to i16").succeeded();
    assert!(
        run.stderr.contains("stays where it is") && run.stderr.contains("--dims 2x3x2 --type i16"),
        "{}",
        run.stderr
    );
    let numbers: Vec<u8> = [12, 11, 16, 15, 20, 19, 24, 23, 28, 27, 32, 31].into_iter().flat_map(|n| [n, 0]).collect();
    assert_eq!(std::fs::read(vr.folder().join("x.raw")).unwrap(), numbers);
    let run = vr.run("convert scan.nrrd y.nrrd --resample 7x5x2 --to u8 --rescale 10,30").succeeded();
    assert!(run.stderr.contains("linear interpolation") && run.stderr.contains("clamped to u8"), "{}", run.stderr);
    let after = info(&vr, "y.nrrd");
    assert_eq!(after["dims"], serde_json::json!([7, 5, 2]));
    assert_eq!((after["spacing"][0].as_f64(), after["range"][1].as_f64()), (Some(0.25), Some(255.0)));
    assert_eq!(after["origin"], info(&vr, "scan.nrrd")["origin"]);
}

#[test]
fn what_cannot_be_converted_is_refused() {
    let vr = scan();
    vr.write("points.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,0\n0,0,1\n");
    let before = vr.files();
    for (arguments, code, said) in [
        ("scan.nrrd", 2, "takes a volume and the file to write"),
        ("scan.nrrd x.tif", 2, "no format of volumes"),
        ("scan.nrrd scan.nrrd", 2, "would destroy it"),
        ("scan.nrrd x.nrrd --crop 0:9,:,:", 2, "--crop: found 0:9 along x; must be within 0:4"),
        ("scan.nrrd x.nrrd --to f32 --rescale 0,1", 2, "--rescale"),
        ("scan.nrrd x.nrrd --resample 1x1x1", 2, "--resample"),
        ("points.csv x.nrrd", 1, "scattered points cannot be converted"),
        ("scan.nrrd none/x.nrrd", 1, "cannot be written"),
    ] {
        let error = vr.run(&format!("convert {arguments}")).failed(code);
        assert!(error.contains(said), "{arguments}: {error}");
    }
    assert_eq!(vr.files(), before);
}
