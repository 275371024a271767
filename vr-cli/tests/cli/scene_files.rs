//! `vr scene`: a complete scene file that draws the same bytes.

use crate::harness::{Vr, test_data};

/// Draws with flags, and by the scene file of these flags; returns that file.
#[track_caller]
fn drawn_the_same(vr: &Vr, flags: &[&str]) -> String {
    let run = |first: &[&str], last: &[&str]| vr.run_with(&[first, flags, last].concat());
    let by_flags = run(&["render"], &["--error", "none", "-o", "flags.png"]);
    run(&["scene"], &["-o", "s.toml", "--force"]).succeeded();
    let by_scene = vr.run("render --scene s.toml --error none -o scene.png");
    // An error bound may turn out not to be proven.
    assert!(matches!(by_flags.code, 0 | 3), "{flags:?}: {}", by_flags.stderr);
    assert_eq!(by_flags.code, by_scene.code, "{flags:?}: {}", by_scene.stderr);
    let text = std::fs::read_to_string(vr.folder().join("s.toml")).unwrap();
    let [by_flags, by_scene] = ["flags.png", "scene.png"].map(|name| std::fs::read(vr.folder().join(name)).unwrap());
    // Records and all: what the file says is what the flags came to.
    assert!(by_flags == by_scene, "{flags:?} gave another picture by\n{text}");
    text
}

#[test]
fn what_flags_come_to_is_drawn_by_the_file() {
    let vr = Vr::new();
    vr.write("cube_8x8x8_uint8.raw", (0..512).map(|i| ((i * 37) % 251) as u8).collect::<Vec<_>>());
    vr.write("p.csv", "x,y,z,radius,value\n0,0,0,1,5\n2,0.5,0,1.5,6\n0,2,1,1,7\n");
    vr.write("m.obj", "v 0 0 0\nv 5 0 4\nv 0 6 4\nf 1 2 3\n");
    vr.write("inline.toml", "[volume]\ndata = [0, 0.1, 0.2, 1, 0, 1, 1, 0.7]\ndims = [2, 2, 2]\nspacing = [1, 1, 2]\n[image]\nsize = [16, 16]\n");
    vr.write(
        "rows.toml",
        "[volume]\npoints = [[0, 0, 0, 1, 1, 1], [1, 0.5, 0, 0.8, 1, 2]]\n[image]\nsize = [16, 16]\n",
    );
    let blobs = "--phantom blobs --phantom-size 12 --size 16";
    for flags in [
        "--size 20",
        blobs,
        &format!("{blobs} --renderer shearwarp"),
        &format!("{blobs} --renderer texslice --compositing accumulate --level 0.3"),
        &format!("{blobs} --renderer splat --set buffers=axis"),
        &format!("{blobs} --renderer physics --samples 2"),
        &format!("{blobs} --set step=0.7 --background 0.1,0.2,0.3 --fov 35"),
        &format!("{blobs} --max-error 0.01"),
        &format!("{blobs} --shading --light 1,2,3 --light=-1,0,0.5 --gradient-opacity 0,0 --gradient-opacity 2,1"),
        &format!("{blobs} --crop=-1,-1,-1,0.5,1,1 --clip-plane 1,1,0,-0.2 --clip-plane 0,0,1,-0.9"),
        &format!("{blobs} --compositing first --threshold 0.3 --transfer viridis --range 0,0.5"),
        "cube_8x8x8_uint8.raw --size 16 --azimuth 70",
        "cube_8x8x8_uint8.raw --size 16 --mesh m.obj --mesh-color 1,0.5,0.2 --look flat",
        "p.csv --size 16 --kernel cone --radius-scale 1.5",
        "--phantom plummer --points-count 100 --size 16",
        "--scene inline.toml",
        "--scene rows.toml --set slice-distance=2",
    ] {
        let flags: Vec<&str> = flags.split_whitespace().collect();
        drawn_the_same(&vr, &flags);
    }
}

#[test]
fn every_section_is_there_with_comments() {
    let vr = Vr::new();
    let text = drawn_the_same(&vr, &["--phantom", "fog", "--phantom-size", "9", "--size", "8"]);
    for line in [
        "[volume]",
        "phantom = \"fog\"",
        "size = 9",
        "filter = \"trilinear\"  # the default",
        "[transfer]",
        "look = \"auto\"  # the default",
        "[shading]",
        "[camera]",
        "# [mesh]",
        "# path = \"surface.stl\"",
        "size = [8, 8]",
        "samples = 1  # the default",
        "renderer = \"raycast\"",
        "steps = \"auto\"  # the default",
        "# step = 0.2",
    ] {
        assert!(text.lines().any(|l| l == line), "no {line:?} in\n{text}");
    }
    // A comment stands above every key.
    let lines: Vec<&str> = text.lines().collect();
    let is_key = |line: &str| line.starts_with(|c: char| c.is_ascii_lowercase()) && line.contains(" = ");
    assert!((1..lines.len()).all(|i| !is_key(lines[i]) || lines[i - 1].starts_with('#')), "{text}");
    // Printed as it is written.
    let printed = vr.run("scene --phantom fog --phantom-size 9 --size 8").succeeded();
    assert_eq!(printed.stdout.trim_end(), text.trim_end());
    let json = vr.run("scene --phantom fog --phantom-size 9 --json").succeeded().json();
    assert_eq!(json["scene"]["volume"]["size"], 9);
}

#[test]
fn paths_lead_from_the_file_to_the_volume() {
    let vr = Vr::new();
    std::fs::create_dir(vr.folder().join("sub")).unwrap();
    vr.write("sub/cube_4x4x4_uint8.raw", (0..64).map(|i| 3 * i as u8).collect::<Vec<_>>());
    vr.run("scene sub/cube_4x4x4_uint8.raw --size 8 -o sub/s.toml").succeeded();
    vr.run("scene --scene sub/s.toml -o t.toml").succeeded();
    let path = |name: &str| {
        let text = std::fs::read_to_string(vr.folder().join(name)).unwrap();
        text.lines().find(|l| l.starts_with("path = ")).unwrap().to_owned()
    };
    assert_eq!(path("sub/s.toml"), "path = \"cube_4x4x4_uint8.raw\"");
    assert_eq!(path("t.toml"), "path = \"sub/cube_4x4x4_uint8.raw\"");
    for scene in ["sub/s.toml", "t.toml"] {
        vr.run(&format!("render --scene {scene} --error none")).succeeded();
    }
    assert!(vr.run("scene --scene t.toml -o t.toml").failed(2).contains("would destroy it"));
    assert!(vr.run("scene -o x.txt").failed(2).contains("must be toml"));
    assert!(vr.run("scene --phantom frog").failed(2).contains("did you mean 'fog'"));
}

#[test]
fn a_real_volume_comes_back() {
    let Some(data) = test_data() else { return };
    let vr = Vr::new();
    let file = data.join("nifti/anatomical_be.nii");
    if !file.exists() {
        eprintln!("skipped: no nifti/anatomical_be.nii");
        return;
    }
    drawn_the_same(&vr, &[file.to_str().unwrap(), "--size", "24"]);
}

#[test]
fn flags_of_the_camera_override_single_keys() {
    let vr = Vr::new();
    let scene = |camera: &str| {
        format!("[volume]\nphantom = \"blobs\"\nsize = 16\n\n[camera]\n{camera}\n\n[image]\nsize = [24, 24]\n")
    };
    let picture = |camera: &str, flags: &str| {
        vr.write("s.toml", scene(camera));
        vr.run(&format!("render --scene s.toml --error none --force -o s.png {flags}")).succeeded();
        vr.picture("s.png")
    };
    let flat = "azimuth = 10\nelevation = 5\nheight = 1.5\n";
    let deep = "azimuth = 10\nelevation = 5\nprojection = \"perspective\"\nfov = 50\n";
    let placed = "eye = [3, 2, 4]\ntarget = [0, 0, 0.2]\nup = [0, 1, 0]\nheight = 1.5\n";
    for (camera, flags, same_as) in [
        (flat, "--azimuth 70", "azimuth = 70\nelevation = 5\nheight = 1.5\n"),
        (flat, "--elevation=-40", "azimuth = 10\nelevation = -40\nheight = 1.5\n"),
        (flat, "--height 0.7", "azimuth = 10\nelevation = 5\nheight = 0.7\n"),
        (flat, "--target 0.2,0,0", "azimuth = 10\nelevation = 5\nheight = 1.5\ntarget = [0.2, 0, 0]\n"),
        (flat, "--up 0,0,1", "azimuth = 10\nelevation = 5\nheight = 1.5\nup = [0, 0, 1]\n"),
        (flat, "--eye 3,2,4", "eye = [3, 2, 4]\nheight = 1.5\n"),
        (flat, "--projection orthographic", flat),
        (flat, "--fov 50", deep),
        (flat, "--projection perspective", "azimuth = 10\nelevation = 5\nprojection = \"perspective\"\n"),
        (deep, "--azimuth 70", "azimuth = 70\nelevation = 5\nprojection = \"perspective\"\nfov = 50\n"),
        (deep, "--fov 20", "azimuth = 10\nelevation = 5\nprojection = \"perspective\"\nfov = 20\n"),
        (deep, "--projection perspective", deep),
        (deep, "--projection orthographic", "azimuth = 10\nelevation = 5\n"),
        (deep, "--height 1.5", flat),
        (placed, "--eye 4,2,3", "eye = [4, 2, 3]\ntarget = [0, 0, 0.2]\nup = [0, 1, 0]\nheight = 1.5\n"),
        (placed, "--height 2", "eye = [3, 2, 4]\ntarget = [0, 0, 0.2]\nup = [0, 1, 0]\nheight = 2\n"),
        // Angles take the place of the eye, and all is seen from them.
        (placed, "--azimuth 70 --elevation 5", "azimuth = 70\nelevation = 5\n"),
    ] {
        let (by_flag, by_key) = (picture(camera, flags), picture(same_as, ""));
        assert!(by_flag == by_key, "{camera}{flags}");
        if same_as != camera {
            assert!(by_flag != picture(camera, ""), "no effect: {camera}{flags}");
        }
    }
    // A wrong flag is the command line's fault, though the key is in the file, too; a wrong key that a flag overrides does no harm.
    vr.write("s.toml", scene(deep));
    assert!(vr.run("render --scene s.toml --fov 200").failed(2).contains("camera.fov"));
    picture("projection = \"perspective\"\nfov = 200\n", "--fov 20");
}
