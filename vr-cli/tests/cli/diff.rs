//! `vr diff`, and the map of a render's error.

use std::path::Path;

use crate::harness::{Vr, test_data};

/// A small picture of the embedded scene.
const RENDER: &str = "render --phantom blobs --phantom-size 24 --error none";

#[test]
fn equal_pictures_have_no_error() {
    let vr = Vr::new();
    vr.run(&format!("{RENDER} --size 40x30 -o a.exr -o b.exr")).succeeded();
    let json = vr.run("diff a.exr b.exr --json --fail-above 0").succeeded().json();
    assert_eq!((json["error"]["max"].as_f64(), json["ssim"].as_f64()), (Some(0.0), Some(1.0)), "{json}");
    assert_eq!((&json["channels"], &json["largest"]), (&"rgba".into(), &serde_json::Value::Null));
    let text = vr.run("diff a.exr b.exr").succeeded().stdout;
    for word in ["40x30", "R, G, B and opacity", "equal", "PSNR inf", "SSIM     1.0", "0 of 1200", "32-bit floats"] {
        assert!(text.contains(word), "no {word:?} in\n{text}");
    }
    assert_eq!(text.contains("FLIP"), cfg!(feature = "flip"));
    assert_eq!(vr.files(), ["a.exr", "b.exr"]);
}

#[test]
fn a_png_differs_from_an_exr_by_its_rounding() {
    let vr = Vr::new();
    vr.run(&format!("{RENDER} --size 64 --background 0.1,0.2,0.3 -o a.exr -o b.png")).succeeded();
    vr.run(&format!("{RENDER} --size 64 --alpha -o c.png")).succeeded();
    vr.run(&format!("{RENDER} --size 64 --bits 16 --encode none -o d.png")).succeeded();
    let error = |arguments: &str| vr.run(&format!("diff --json {arguments}")).succeeded().json();
    // Half a code of 8 bits at white, where the curve is steepest: 2.275/2/255.
    let json = error("a.exr b.png --background 0.1,0.2,0.3");
    assert!((1e-5..0.0046).contains(&json["error"]["max"].as_f64().unwrap()), "{json}");
    assert_eq!((&json["blended"], &json["channels"]), (&"reference".into(), &"rgb".into()));
    assert!(json["ssim"].as_f64().unwrap() > 0.99, "{json}");
    // The other way round, and with opacity on both sides.
    let json = error("b.png a.exr --background 0.1,0.2,0.3");
    assert!(json["blended"] == "picture" && json["error"]["max"].as_f64().unwrap() < 0.0046, "{json}");
    let json = error("a.exr c.png");
    assert!(json["channels"] == "rgba" && json["error"]["max"].as_f64().unwrap() < 0.0066, "{json}");
    let json = error("a.exr d.png --encode none");
    assert!(json["error"]["max"].as_f64().unwrap() < 1e-5, "{json}");
    // Without what was said about them they are other pictures.
    assert!(error("a.exr b.png")["error"]["max"].as_f64().unwrap() > 0.05);
    assert!(error("a.exr d.png")["error"]["max"].as_f64().unwrap() > 0.05);
}

#[test]
fn differences_are_drawn_and_kept() {
    let vr = Vr::new();
    vr.run(&format!("{RENDER} --size 200x20 -o a.exr")).succeeded();
    vr.run(&format!("{RENDER} --size 200x20 --set step=4 -o b.exr")).succeeded();
    let run = vr.run("diff a.exr b.exr -o map.png -o map.exr --json").succeeded().json();
    assert_eq!(run["outputs"], serde_json::json!(["map.png", "map.exr"]));
    let map = vr.picture("map.png").to_rgb8();
    assert!(map.width() == 200 && map.height() > 40);
    let largest: Vec<u32> =
        run["largest"]["pixel"].as_array().unwrap().iter().map(|p| p.as_u64().unwrap() as u32).collect();
    let brightness = |x: u32, y: u32| map.get_pixel(x, y).0.iter().map(|&c| u32::from(c)).sum::<u32>();
    assert!(brightness(largest[0], largest[1]) > 200 && brightness(0, 0) == brightness(199, 19));
    // What the floats hold is the error.
    let kept = largest_value(&vr, "map.exr", [200, 20]);
    assert!(kept > 0.0 && kept <= run["error"]["max"].as_f64().unwrap(), "{kept} {run}");
}

#[test]
fn scripts_can_set_a_limit() {
    let vr = Vr::new();
    vr.run(&format!("{RENDER} --size 32 -o a.exr")).succeeded();
    vr.run(&format!("{RENDER} --size 32 --set step=4 -o b.exr")).succeeded();
    let rmse = vr.run("diff a.exr b.exr --json --fail-above 0.5").succeeded().json()["error"]["rmse"].as_f64().unwrap();
    assert!(rmse > 1e-7, "{rmse}");
    let run = vr.run("diff a.exr b.exr --fail-above 1e-9 -o map.png");
    assert!(run.stdout.contains("RMSE") && vr.exists("map.png"), "the rest is done all the same");
    let error = run.failed(1);
    assert!(error.contains("RMSE") && error.contains("above 1.00e-9") && error.contains("b.exr"), "{error}");
    let quiet = vr.run("diff a.exr b.exr --quiet --fail-above 0.5").succeeded();
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}

#[test]
fn what_cannot_be_compared_is_one_line() {
    let vr = Vr::new();
    vr.run(&format!("{RENDER} --size 20 -o a.exr -o a.png")).succeeded();
    vr.run(&format!("{RENDER} --size 20x21 -o b.png")).succeeded();
    let whole = std::fs::read(vr.folder().join("a.png")).unwrap();
    vr.write("cut.png", &whole[..whole.len() / 2]);
    let whole = std::fs::read(vr.folder().join("a.exr")).unwrap();
    vr.write("cut.exr", &whole[..whole.len() / 2]);
    vr.write("text.png", "no picture");
    let before = vr.files();
    for (arguments, code, words) in [
        ("a.png b.png", 1, &["a.png", "20x20", "b.png", "20x21"][..]),
        ("a.png cut.png", 1, &["cut.png", "PNG", "damaged"]),
        ("cut.exr a.exr", 1, &["cut.exr", "EXR", "damaged"]),
        ("a.png text.png", 1, &["text.png", "TIFF"]),
        ("a.png none.png", 1, &["none.png"]),
        ("a.png .", 1, &["a folder"]),
        ("a.png", 2, &["<B>"]),
        ("a.png a.exr -o map.jpg", 2, &["map.jpg", "png or exr"]),
        ("a.png a.exr -o no/map.png", 1, &["no/map.png", "folder"]),
        ("a.png a.exr -o ./a.exr", 2, &["a.exr", "compared"]),
        ("a.png a.exr --fail-above -1", 2, &["fail-above"]),
        ("a.png a.exr --background nan,0,0", 2, &["background"]),
        ("a.png a.exr --encode gamma", 2, &["encode", "srgb"]),
    ] {
        let error = vr.run(&format!("diff {arguments}")).failed(code);
        for word in words {
            assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
        }
    }
    assert_eq!(vr.files(), before);
}

#[test]
fn what_is_no_number_is_infinitely_wrong() {
    let vr = Vr::new();
    let save = |name: &str, red: f32| {
        let pixels =
            image::Rgb32FImage::from_fn(12, 12, |x, y| image::Rgb([if x == 3 && y == 5 { red } else { 0.5 }; 3]));
        image::DynamicImage::ImageRgb32F(pixels).save(vr.folder().join(name)).unwrap();
    };
    save("a.tiff", 0.5);
    save("b.tiff", f32::NAN);
    let text = vr.run("diff a.tiff b.tiff -o map.png -o map.exr").succeeded().stdout;
    for word in ["max inf", "pixel 3, 5", "B NaN, NaN, NaN", "1 of 144 pixels"] {
        assert!(text.contains(word), "no {word:?} in\n{text}");
    }
    let json = vr.run("diff a.tiff b.tiff --json").succeeded().json();
    assert!(json["error"]["max"].is_null() && json["largest"]["picture"][0].is_null(), "{json}");
    vr.run("diff a.tiff b.tiff --fail-above 1000").failed(1);
}

#[test]
fn help_says_what_is_compared() {
    let help = Vr::new().run("diff --help").succeeded().stdout;
    for word in ["SSIM", "FLIP", "heat map", "--fail-above", "--background"] {
        assert!(help.contains(word), "no {word:?} in\n{help}");
    }
}

/// The largest value in R, G and B of a picture of floats: its error against black.
fn largest_value(vr: &Vr, name: &str, size: [u32; 2]) -> f64 {
    let black = image::DynamicImage::ImageRgb32F(image::Rgb32FImage::new(size[0], size[1]));
    black.save(vr.folder().join("black.tiff")).unwrap();
    vr.run(&format!("diff black.tiff {name} --json")).succeeded().json()["error"]["max"].as_f64().unwrap()
}

#[test]
fn renders_map_their_error() {
    let vr = Vr::new();
    let scene = "render --phantom blobs --phantom-size 24 --size 170x80 --set step=4 --compositing maximum";
    // 64 columns of 170: most pixels are interpolated.
    let run = vr.run(&format!("{scene} --error-map map.png")).succeeded();
    assert!(run.stdout.contains("map.png: error interpolated between 4096 of 13600 pixels"), "{}", run.stdout);
    assert!(vr.picture("map.png").width() == 170 && vr.picture("map.png").height() > 80);
    let full = vr.run(&format!("{scene} --error full --error-map map.exr --json")).succeeded().json();
    assert_eq!(full["error_map"]["interpolated"], false);
    assert_eq!(full["error_map"]["known_pixels"], 13600);
    let max = full["error"]["max"].as_f64().unwrap();
    let kept = largest_value(&vr, "map.exr", [170, 80]);
    assert!(max > 1e-4 && kept <= max * 1.001 && kept > 0.2 * max, "{kept} of {max}");
    // No numbers are printed, and the map is drawn all the same.
    let quiet = vr.run(&format!("{scene} --quiet --error-map quiet.exr")).succeeded();
    assert!(quiet.stdout.is_empty() && vr.exists("quiet.exr"));
    assert!(largest_value(&vr, "quiet.exr", [170, 80]) <= max * 1.001);
}

#[test]
fn error_maps_that_cannot_be() {
    let vr = Vr::new();
    for (arguments, code, words) in [
        ("--error none --error-map map.png", 2, &["--error-map", "subgrid", "full"][..]),
        ("--error-map map.jpg", 2, &["map.jpg", "png or exr"]),
        ("--error-map no/map.png", 1, &["no/map.png"]),
        ("-o x.png --error-map x.png", 2, &["x.png", "picture"]),
    ] {
        let error = vr.run(&format!("render --size 8 {arguments}")).failed(code);
        for word in words {
            assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
        }
    }
    assert!(vr.files().is_empty());
}

#[test]
fn files_that_are_no_pictures_are_refused() {
    let Some(data) = test_data() else { return };
    let vr = Vr::new();
    for entry in std::fs::read_dir(data.join("bad")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            let name = Path::to_str(&path).unwrap();
            vr.run_with(&["diff", name, name]).failed(1);
        }
    }
}
