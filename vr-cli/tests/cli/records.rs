//! Records in pictures: drawn again bit for bit, refused where volume or picture are others, and silent about folders.

use crate::harness::{Vr, test_data};

/// Voxels of a ball in a box, without any symmetry.
fn ball(side: usize) -> Vec<u8> {
    let far = |at: [usize; 3], to: [f64; 3]| (0..3).map(|a| (at[a] as f64 - to[a]).powi(2)).sum::<f64>().sqrt();
    let at = |i: usize| [i % side, i / side % side, i / side / side];
    let value = |i: usize| 15.0 + 180.0 / (1.0 + (far(at(i), [7.0, 9.0, 6.0]) - 4.5).exp()) + (i % 5) as f64;
    (0..side.pow(3)).map(|i| value(i) as u8).collect()
}

fn with_ball() -> Vr {
    let vr = Vr::new();
    vr.write("ball_16x16x16_uint8.raw", ball(16));
    vr
}

#[test]
fn every_renderer_draws_its_picture_again() {
    let vr = Vr::new();
    let small = "--phantom blobs --phantom-size 12 --size 20x16 --error none";
    for flags in [
        "",
        "--renderer shearwarp",
        "--renderer texslice",
        "--renderer splat",
        "--renderer physics",
        "--set step=0.7 --set leaping=none",
        "--set steps=local",
        "--max-error 1e-3",
        "--renderer texslice --set slice-distance=2",
        "--compositing maximum",
        "--compositing first --threshold 0.3 --fov 30 --samples 2",
        "--compositing accumulate --level 0.4 --filter bspline",
        "--shading --light 1,2,3 --gradient analytic --gradient-opacity 0,0 --gradient-opacity 2,1",
        "--transfer viridis --range 0,0.7 --opacity-rule extinction --background 0.1,0.2,0.3",
        "--crop=-1,-1,-1,0.5,1,1 --clip-plane 1,1,0,-0.2",
    ] {
        let drawn = vr.run(&format!("render {small} {flags} -o a.png -o a.exr"));
        assert!(matches!(drawn.code, 0 | 3), "{flags}: {}", drawn.stderr);
        for picture in ["a.png", "a.exr"] {
            let json = vr.run(&format!("rerun {picture} --json")).succeeded().json();
            assert_eq!(json["same_pixels"], true, "{flags}: {json}");
            assert_eq!((&json["differing_pixels"], &json["changed_since"]), (&0.into(), &false.into()), "{flags}");
        }
    }
    vr.run("render --phantom plummer --points-count 200 --size 16 --error none -o p.png").succeeded();
    let again = vr.run("rerun p.png -o q.png").succeeded();
    assert!(again.stdout.contains("all 256 pixels are the same, bit for bit"), "{}", again.stdout);
    assert_eq!(std::fs::read(vr.folder().join("p.png")).unwrap(), std::fs::read(vr.folder().join("q.png")).unwrap());
}

#[test]
fn the_embedded_scene_and_a_chosen_renderer_are_recorded() {
    let vr = Vr::new();
    vr.run("render --size 24").succeeded();
    let info = vr.run("info vr.png").succeeded().stdout;
    for word in
        ["phantom hydrogen, 64×64×64", "raycast", "RMSE", "on 576 of 576 pixels", "hash", "vr rerun vr.png", "[camera]"]
    {
        assert!(info.contains(word), "no {word:?} in\n{info}");
    }
    vr.run("rerun vr.png").succeeded();
    vr.run("render --phantom fog --phantom-size 10 --size 16 --target-rmse 0.05 --no-cache -o t.png").succeeded();
    let json = vr.run("info t.png --json").succeeded().json();
    assert!(json["scene"]["render"]["renderer"].is_string(), "{json}");
    vr.run("rerun t.png").succeeded();
}

#[test]
fn a_volume_is_known_by_what_it_holds() {
    let vr = with_ball();
    vr.run("render ball_16x16x16_uint8.raw --size 24 --error none -o a.png --bits 16 --alpha --encode none -o a.exr")
        .succeeded();
    let message = vr.run("rerun a.png").failed(2);
    assert!(message.contains("ball_16x16x16_uint8.raw: name it, as in vr rerun a.png VOLUME"), "{message}");
    // Under another name, which says nothing of its size.
    vr.write("other.bin", ball(16));
    for picture in ["a.png", "a.exr"] {
        vr.run(&format!("rerun {picture} other.bin")).succeeded();
    }
    // One voxel inside of the ball.
    let mut changed = ball(16);
    changed[7 + 16 * (9 + 16 * 6)] ^= 0x40;
    vr.write("changed.bin", &changed);
    let message = vr.run("rerun a.png changed.bin -o b.png").failed(1);
    for word in ["changed.bin: not the volume of the picture", "a voxel differs", "--anyway"] {
        assert!(message.contains(word), "no {word:?} in {message}");
    }
    assert!(!vr.exists("b.png"));
    let message = vr.run("rerun a.png changed.bin --anyway -o b.png").failed(1);
    assert!(message.contains("of 576 pixels differ: the volume or the mesh is not the recorded one"), "{message}");
    vr.run("rerun b.png changed.bin").succeeded();
    // What is not asked for, and what would be destroyed.
    vr.run("render --phantom fog --phantom-size 8 --size 8 --error none -o p.png").succeeded();
    assert!(vr.run("rerun p.png other.bin").failed(2).contains("needs no volume"));
    assert!(vr.run("rerun p.png -o p.png").failed(2).contains("would destroy it"));
    assert!(vr.run("rerun p.png --mesh other.bin").failed(2).contains("no mesh"));
    assert!(vr.run("rerun missing.png").failed(1).contains("missing.png"));
    assert!(vr.run("rerun other.bin").failed(1).contains("only PNG and EXR"));
}

#[test]
fn a_picture_without_a_record_or_with_other_pixels_is_told() {
    let vr = Vr::new();
    let small = "render --phantom shells --phantom-size 10 --size 12 --error none";
    vr.run(&format!("{small} -o a.png -o a.exr --no-record")).succeeded();
    for picture in ["a.png", "a.exr"] {
        let message = vr.run(&format!("rerun {picture}")).failed(1);
        assert!(message.contains(&format!("{picture}: no record of vr in it")), "{message}");
    }
    assert!(vr.run("info a.exr").failed(1).contains("a.exr: no volume, and a picture without a record"));
    assert!(vr.run("info a.png").failed(1).contains("slices: found 1"));
    // The record of one picture, the pixels of another.
    vr.run(&format!("{small} -o a.png")).succeeded();
    vr.run(&format!("{small} --azimuth 200 -o b.png")).succeeded();
    let [a, b] = ["a.png", "b.png"].map(|name| std::fs::read(vr.folder().join(name)).unwrap());
    let pixels = |bytes: &[u8]| bytes.windows(4).position(|w| w == b"IDAT").unwrap() - 4;
    vr.write("mixed.png", [&a[..pixels(&a)], &b[pixels(&b)..]].concat());
    let message = vr.run("rerun mixed.png").failed(1);
    assert!(
        message.contains("of 144 pixels differ: it was drawn again as it was recorded, but the pixels"),
        "{message}"
    );
}

#[test]
fn no_folder_is_in_a_picture() {
    let vr = with_ball();
    vr.write("m.obj", "v 0 0 0\nv 15 0 9\nv 0 15 9\nf 1 2 3\n");
    vr.write(
        "map.json",
        "[{\"Name\": \"x\", \"RGBPoints\": [0, 0, 0, 1, 1, 1, 0, 0], \"Points\": [0, 0, 0.5, 0, 1, 0.5, 0.5, 0]}]",
    );
    let folder = vr.folder().to_str().unwrap().to_owned();
    let name = vr.folder().file_name().unwrap().to_str().unwrap();
    vr.run(&format!(
        "render {folder}/ball_16x16x16_uint8.raw --mesh {folder}/m.obj --transfer {folder}/map.json --size 16 --error none -o a.png -o a.exr"
    ))
    .succeeded();
    let record = vr.run("info a.png --json").succeeded().stdout;
    assert!(
        record.contains("\"ball_16x16x16_uint8.raw\"") && record.contains("\"map.json\"") && !record.contains(name)
    );
    let exr = std::fs::read(vr.folder().join("a.exr")).unwrap();
    let holds = |word: &str| exr.windows(word.len()).any(|w| w == word.as_bytes());
    assert!(holds("ball_16x16x16_uint8.raw") && !holds(name));
    let again = |flags: &str| vr.run(&format!("rerun a.exr ball_16x16x16_uint8.raw {flags}"));
    again("--mesh m.obj").succeeded();
    assert!(again("").failed(2).contains("shows a mesh, m.obj: name it with --mesh FILE"));
    vr.write("n.obj", "v 0 0 0\nv 15 0 9\nv 0 15 8\nf 1 2 3\n");
    assert!(again("--mesh n.obj").failed(1).contains("n.obj: not the mesh of the picture"));
}

#[test]
fn single_pictures_of_sheets_are_drawn_again_and_sheets_are_told() {
    let vr = with_ball();
    let small = "ball_16x16x16_uint8.raw --size 20";
    vr.run(&format!("presets {small} --pictures singles -o sheet.png")).succeeded();
    let json = vr.run("info sheet.png --json").succeeded().json();
    let pictures = json["record"]["sheet"]["pictures"].as_array().unwrap().clone();
    assert!(pictures.len() > 1 && json["record"]["sheet"]["command"] == "presets", "{json}");
    assert!(json["scene"]["transfer"].is_null() && json["scene"]["camera"].is_object(), "{json}");
    for picture in &pictures {
        let (name, flags) = (picture["name"].as_str().unwrap(), picture["flags"].as_str().unwrap());
        assert_eq!(flags, format!("--preset {name}"));
        vr.run(&format!("rerun singles/{name}.png ball_16x16x16_uint8.raw")).succeeded();
    }
    let refused = vr.run("rerun sheet.png ball_16x16x16_uint8.raw").failed(1);
    assert!(refused.contains("pictures by vr presets") && refused.contains("--pictures FOLDER"), "{refused}");

    vr.run(&format!("compare {small} --renderer raycast --renderer splat --pictures all -o sheet.png")).succeeded();
    let text = vr.run("info sheet.png").succeeded().stdout;
    assert!(text.contains("compare, 12 pictures") && text.contains("--renderer splat"), "{text}");
    let json = vr.run("info sheet.png --json").succeeded().json();
    let pictures = json["record"]["sheet"]["pictures"].as_array().unwrap();
    assert_eq!(std::fs::read_dir(vr.folder().join("all")).unwrap().count(), pictures.len());
    for file in std::fs::read_dir(vr.folder().join("all")).unwrap().take(3) {
        let name = file.unwrap().file_name().into_string().unwrap();
        vr.run(&format!("rerun all/{name} ball_16x16x16_uint8.raw")).succeeded();
    }
}

/// Files of every kind that is in the test data, in small pictures.
#[test]
fn real_volumes_are_drawn_again() {
    let Some(data) = test_data() else { return };
    let vr = Vr::new();
    for name in
        ["raw/fuel_64x64x64_uint8.raw", "dicom/pet_head", "nifti/anatomical_be.nii", "nrrd/prostate_phantom.nrrd"]
    {
        let path = data.join(name);
        if !path.exists() {
            eprintln!("skipped: no {name}");
            continue;
        }
        let path = path.to_str().unwrap();
        vr.run_with(&["render", path, "--size", "24", "--error", "none", "-o", "a.png"]).succeeded();
        vr.run_with(&["rerun", "a.png", path]).succeeded();
    }
}
