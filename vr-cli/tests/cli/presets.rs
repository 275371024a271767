//! Presets by name, on one sheet, and transfer functions from and to other programs' files.

use crate::harness::Vr;

/// A body in Hounsfield units: air around, fat, muscle, two lungs and a spine of bone, with a little noise.
fn body(vr: &Vr) -> &'static str {
    const SIDE: i32 = 40;
    let voxel = |i: i32| {
        let [x, y, z] =
            [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].map(|k| f64::from(2 * k + 1 - SIDE) / f64::from(SIDE));
        let round = |cx: f64, cy: f64, rx: f64, ry: f64| ((x - cx) / rx).powi(2) + ((y - cy) / ry).powi(2);
        let lung = |side: f64| round(side * 0.36, 0.05, 0.24, 0.34) + (z / 0.7).powi(2) < 1.0;
        let value = if round(0.0, 0.0, 0.92, 0.72) > 1.0 || z.abs() > 0.92 {
            -1000
        } else if round(0.0, -0.42, 0.13, 0.13) < 1.0 {
            800
        } else if lung(1.0) || lung(-1.0) {
            -750
        } else if round(0.0, 0.0, 0.78, 0.6) > 1.0 {
            -100
        } else {
            50
        };
        value + (i * 7919 % 11) - 5
    };
    let bytes: Vec<u8> = (0..SIDE * SIDE * SIDE).flat_map(|i| (voxel(i) as i16).to_le_bytes()).collect();
    vr.write("body_40x40x40_int16.raw", bytes);
    "body_40x40x40_int16.raw"
}

/// Mean red, green and blue of what is not black, and its part of the picture.
fn shown(vr: &Vr, arguments: &str) -> ([f64; 3], f64) {
    vr.run(&format!("render {arguments} --size 80 --error none -o p.png")).succeeded();
    let picture = vr.picture("p.png").to_rgb8();
    let visible: Vec<[u8; 3]> = picture.pixels().map(|p| p.0).filter(|p| p.iter().any(|&c| c > 8)).collect();
    let mean = |c: usize| visible.iter().map(|p| f64::from(p[c])).sum::<f64>() / visible.len().max(1) as f64;
    ([mean(0), mean(1), mean(2)], visible.len() as f64 / f64::from(picture.width() * picture.height()))
}

#[test]
fn ct_presets_show_what_they_are_named_after() {
    let vr = Vr::new();
    let body = body(&vr);
    let view = "--fit box --azimuth 0 --elevation 0";
    let of = |preset: &str| shown(&vr, &format!("{body} --preset {preset} {view}"));
    let (bone, of_bone) = of("ct-bone");
    let (_, of_skin) = of("ct-skin");
    assert!(of_bone > 0.002 && of_bone < 0.3 * of_skin, "a spine in a body: {of_bone}, {of_skin}");
    assert!(bone[0] >= bone[1] && bone[1] > bone[2] && bone[2] > 0.4 * bone[0], "ivory: {bone:?}");
    let (muscle, _) = of("ct-muscle");
    assert!(muscle[0] > 1.4 * muscle[1], "red: {muscle:?}");
    let (fat, _) = of("ct-fat");
    assert!(fat[0] > fat[1] && fat[1] > 1.3 * fat[2], "yellow: {fat:?}");
    for preset in ["ct-lung", "ct-air", "ct-soft-tissue", "x-ray", "ct-mip"] {
        let (color, part) = of(preset);
        assert!(color.iter().sum::<f64>() > 40.0 && part > 0.05, "{preset}: {color:?} {part}");
    }
    // No contrast agent, no vessels: the spine alone.
    assert!(of("ct-angio").1 < 0.3 * of_skin && of("ct-cardiac").1 < 0.3 * of_skin);
    // Shading comes along, and may be refused.
    let flat = shown(&vr, &format!("{body} --preset ct-bone --no-shading {view}")).0;
    assert_ne!(flat, bone);
}

#[test]
fn presets_say_what_they_assume() {
    let vr = Vr::new();
    let body = body(&vr);
    let render = |flags: &str| vr.run(&format!("render {flags} --size 8 --error none -o p.png"));
    let notes = |flags: &str| render(flags).succeeded().stderr;
    assert!(!notes(&format!("{body} --preset ct-bone")).contains("Hounsfield"));
    vr.write("a_16x16x16_uint8.raw", (0..4096u32).map(|i| (i * 31 % 251) as u8).collect::<Vec<u8>>());
    assert!(notes("a_16x16x16_uint8.raw --preset ct-bone").contains("Hounsfield units, which the values are not"));
    assert!(!notes("a_16x16x16_uint8.raw --preset mr-angio").contains("Hounsfield"));
    assert!(notes(&format!("{body} --preset ct-mip")).contains("compositing = \"maximum\""));
    let error = render(&format!("{body} --preset ct-bones")).failed(2);
    assert!(error.contains("did you mean 'ct-bone'") && error.contains("pet-hot"), "{error}");
    let error = render(&format!("{body} --preset ct-bone --transfer grey")).failed(2);
    assert!(error.contains("--preset") && error.contains("--transfer"), "{error}");
}

#[test]
fn a_sheet_of_all_that_suits() {
    let vr = Vr::new();
    let body = body(&vr);
    let run = vr.run(&format!("presets {body} --size 48 --json")).succeeded();
    let json = run.json();
    let names: Vec<&str> = json["presets"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"ct-lung") && names.contains(&"grey") && !names.contains(&"pet-hot"), "{names:?}");
    assert_eq!(json["output"], "vr-presets.png");
    let sheet = vr.picture("vr-presets.png");
    assert!(sheet.width() >= 3 * 48 && sheet.height() >= 3 * 48);
    let all = vr.run(&format!("presets {body} --size 8 --all --json -o all.png")).succeeded().json();
    assert_eq!(all["presets"].as_array().unwrap().len(), 22);
    let error = vr.run(&format!("presets {body} --preset grey")).failed(2);
    assert!(error.contains("every preset is drawn"), "{error}");
    assert!(vr.run(&format!("presets {body} -o x.exr")).failed(2).contains("must be png"));
}

#[test]
fn transfer_functions_are_printed_drawn_and_converted() {
    let vr = Vr::new();
    let body = body(&vr);
    let printed = vr.run("tf ct-bone").succeeded().stdout;
    assert!(printed.contains("Hounsfield units") && printed.contains("450") && printed.contains('#'), "{printed}");
    let files = ["a.json", "a.vp", "a.csv", "a.toml", "a.lut", "a.png"];
    let outputs: String = files.iter().map(|name| format!(" -o {name}")).collect();
    vr.run(&format!("tf ct-bone {body}{outputs}")).succeeded();
    assert_eq!(vr.picture("a.png").width(), 800);
    // The same picture through every file that holds all of it.
    let pixels = |flags: &str| {
        vr.run(&format!("render {body} --size 40 --error none --fit box -o p.png {flags}")).succeeded();
        vr.picture("p.png").to_rgb8().into_raw()
    };
    let expected = pixels("--preset ct-bone");
    for (flags, steps) in [
        ("--transfer a.toml", 0),
        // Colours and opacities within what 8 bits show, along a ray.
        ("--transfer a.vp", 4),
        ("--transfer a.csv --ambient 0.25 --diffuse 0.8 --specular 0.15 --power 12", 4),
        ("--transfer a.json --range 150,3071 --ambient 0.25 --diffuse 0.8 --specular 0.15 --power 12", 4),
    ] {
        let found = pixels(flags);
        let worst = found.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(worst <= steps, "{flags}: {worst}");
    }
    // What a volume would be drawn with.
    let auto = vr.run(&format!("tf auto {body} --json")).succeeded().json();
    assert!(auto["points"].as_array().unwrap().len() > 3 && auto["shading"].is_object(), "{auto}");
    for (arguments, word) in [
        ("tf auto", "found no volume"),
        ("tf ct-bones", "did you mean 'ct-bone'"),
        ("tf ct-bone -o a.doc", "must be json"),
        ("tf a.vp -o a.vp", "would destroy it"),
        ("tf grey -o b.csv -o b.csv", "another output"),
        ("tf grey --range 3,1", "smaller one first"),
    ] {
        assert!(vr.run(arguments).failed(2).contains(word), "{arguments}");
    }
    assert!(vr.run("tf missing.json").failed(1).contains("missing.json"));
    vr.write("broken.vp", "1\n1\n0.9\n");
    assert!(vr.run("tf broken.vp").failed(1).contains("broken.vp: line 4 (ambient)"));
}
