//! Every command, with no argument and with many.

use crate::harness::Vr;

#[test]
fn render_without_arguments_shows_time_and_error() {
    let vr = Vr::new();
    let run = vr.run("render").succeeded();
    assert_eq!(vr.files(), ["vr.png"]);
    for word in ["time", "prepare", "render", "samples", "error", "max", "RMSE", "reference", "vr.png"] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    let picture = vr.picture("vr.png").to_rgb8();
    assert_eq!(picture.dimensions(), (512, 512));
    let lit = picture.pixels().filter(|p| p.0.iter().any(|&c| c > 40)).count();
    assert!(lit > 10_000, "only {lit} pixels show anything");
}

#[test]
fn compare_without_arguments_makes_a_table_and_a_sheet() {
    let vr = Vr::new();
    let run = vr.run("compare --size 40").succeeded();
    assert_eq!(vr.files(), ["vr-compare.png"]);
    for word in ["raycast", "physics", "max error", "RMSE", "12 of", "--all"] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    assert!(run.stdout.lines().count() <= 24 && run.stdout.lines().all(|l| l.chars().count() <= 100), "{}", run.stdout);
    let summary = vr.picture("vr-compare.png");
    assert!(summary.width() > 80);
    // Of a small volume: what is told of it does not depend on its size, and the models of all settings are solved.
    let all = vr.run("compare --phantom blobs --phantom-size 12 --size 40 --all").succeeded().stdout;
    for word in ["bias", "PSNR", "samples", "own model", "Features"] {
        assert!(all.contains(word), "no {word:?} in\n{all}");
    }
    assert!(vr.picture("vr-compare.png").height() > summary.height());
}

#[test]
fn info_without_arguments_draws_a_histogram() {
    let vr = Vr::new();
    let run = vr.run("info").succeeded();
    for word in ["size", "64×64×64", "spacing", "values", "--transfer", "histogram", "█"] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    assert!(vr.files().is_empty());
}

#[test]
fn info_draws_slices_of_grids() {
    let vr = Vr::new();
    let drawn = vr.run("info --phantom blobs --phantom-size 16 -o slices.png").succeeded().stdout;
    assert!(drawn.contains("wrote        slices.png"), "{drawn}");
    assert!(vr.picture("slices.png").width() > 900, "three slices side by side");
    assert!(vr.run("info --phantom plummer --points-count 9 -o p.png").failed(2).contains("found: scattered points"));
    assert!(vr.run("info -o slices.exr").failed(2).contains("must be png"));
}

#[test]
fn json_is_one_object() {
    let vr = Vr::new();
    let render = vr.run("render --size 48x32 --json --quiet").succeeded();
    assert!(render.stderr.is_empty(), "{}", render.stderr);
    let render = render.json();
    assert_eq!(render["size"], serde_json::json!([48, 32]));
    assert!(render["error"]["max"].as_f64().unwrap() < 1.0 / 255.0, "{render}");
    assert!(render["error"]["reference_error"].as_f64().unwrap() < 1e-6, "{render}");
    assert!(render["samples"].as_u64().unwrap() > 0);
    let compare = vr.run("compare --phantom fog --phantom-size 9 --size 24 --json").succeeded().json();
    assert!(compare["renderers"].as_array().unwrap().len() >= 3, "{compare}");
    let info = vr.run("info --json --phantom fog --phantom-size 9").succeeded().json();
    assert_eq!(info["dims"], serde_json::json!([9, 9, 9]));
    let counts = info["histogram"].as_array().unwrap();
    assert_eq!(counts.iter().map(|c| c.as_u64().unwrap()).sum::<u64>(), 729);
}

#[test]
fn quiet_says_nothing() {
    let vr = Vr::new();
    let run = vr.run("render --size 16 --quiet").succeeded();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert!(vr.exists("vr.png"));
}

/// Pages in the documentation are what the program prints: `vr help features > docs/features.md` and `vr help keys > docs/scene-files.md` write
/// them anew.
#[test]
fn pages_in_the_documentation_are_what_the_program_prints() {
    for (topic, name) in [("features", "features.md"), ("keys", "scene-files.md")] {
        let page = std::fs::read_to_string(format!("{}/../docs/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
        assert_eq!(Vr::new().run(&format!("help {topic}")).succeeded().stdout.trim_end(), page.trim_end(), "{name}");
    }
}

#[test]
fn help_and_version() {
    let vr = Vr::new();
    assert!(vr.run("--version").succeeded().stdout.starts_with("vr "));
    for (command, words) in [
        ("render --help", ["--gradient-opacity", "Features", "clip planes", "vr help raycast"]),
        ("render -h", ["--preset", "--crop", "--output", "vr help raycast"]),
        ("help render", ["--gradient-opacity", "Features", "Usage: vr render", "Exit codes"]),
        ("help", ["render", "compare", "help", "Exit codes"]),
        ("help renderers", ["Features", "raycast", "shearwarp", "vr help splat"]),
        ("help keys", ["# Keys of scene files", "## [camera]", "| `azimuth` | (`30.0`) |", "| `spacing` |"]),
        ("help features", ["| feature | raycast |", "## shearwarp", "- **scattering**: ", "vr help features"]),
        ("help raycast", ["Options of raycast", "step=", "leaping=", "screen="]),
        ("help shearwarp", ["Options of shearwarp", "slice-distance=", "warp=", "encoding="]),
        ("help texslice", ["Options of texslice", "proxy=", "format=", "brick="]),
        ("help splat", ["Options of splat", "buffers=", "kernel=", "sigma="]),
        ("help physics", ["Options of physics", "tolerance=", "1e-10", "largest error"]),
        ("help presets", ["ct-bone", "viridis", "grey", "vr presets"]),
        ("help phantoms", ["marschner-lobb", "hydrogen", "plummer", "--phantom"]),
    ] {
        let help = vr.run(command).succeeded().stdout;
        for word in words {
            assert!(help.contains(word), "{command}: no {word:?} in\n{help}");
        }
    }
    for command in ["render", "compare", "bench", "report", "turntable", "animate", "presets", "scene", "ray"] {
        let command = format!("{command} -h");
        let lines = vr.run(&command).succeeded().stdout.lines().count();
        assert!(lines <= 40, "{command}: {lines} lines");
    }
    let error = vr.run("help nothing").failed(2);
    assert!(
        error.contains("nothing") && error.contains("raycast, shearwarp") && error.contains("ray, render, report"),
        "{error}"
    );
}

#[test]
fn outputs_in_every_format() {
    let vr = Vr::new();
    vr.run("render --size 20 --error none -o a.png -o b.exr -o c.PNG").succeeded();
    assert_eq!(vr.files(), ["a.png", "b.exr", "c.PNG"]);
    vr.run("render --size 20 --error none -o deep.png --bits 16 --alpha --encode none").succeeded();
    assert_eq!(vr.picture("deep.png").color(), image::ColorType::Rgba16);
}

#[test]
fn threads_change_no_pixel() {
    let vr = Vr::new();
    vr.run("render --size 40 --error none --threads 1 -o one.png --bits 16").succeeded();
    vr.run("render --size 40 --error none --threads 3 -o three.png --bits 16").succeeded();
    assert_eq!(vr.picture("one.png"), vr.picture("three.png"));
}

#[test]
fn flags_for_everything_change_the_picture() {
    let vr = Vr::new();
    let small = "render --size 24 --error none --phantom blobs --phantom-size 20";
    vr.run(&format!("{small} -o plain.png")).succeeded();
    let plain = vr.picture("plain.png");
    for flags in [
        "--transfer viridis",
        "--point 0.1,1,0,0,0 --point 0.9,0,1,0,0.5",
        "--transfer grey --range 0,0.5",
        "--unit-distance 1",
        "--opacity-rule extinction --unit-distance 0.02",
        "--shading",
        "--light 1,0.5,-1,1,0.5,0 --headlight --ambient 0.1 --diffuse 0.9 --specular 0.5 --power 40 --gradient analytic",
        "--gradient-opacity 0,0 --gradient-opacity 2,1",
        "--azimuth 75 --elevation -10",
        "--eye 0,0,9 --target 0.2,0,0 --up 1,0,0 --height 3",
        "--projection perspective --fov 20",
        "--crop=-1,-1,-1,0,1,1",
        "--clip-plane 1,1,0,0",
        "--samples 2",
        "--background 0.1,0.2,0.3",
        "--background transparent",
        "--filter nearest",
        "--compositing maximum",
        "--compositing first --threshold 0.3",
        "--compositing accumulate --level 0.2",
        "--set step=8",
    ] {
        vr.run(&format!("{small} {flags} -o changed.png")).succeeded();
        assert_ne!(plain, vr.picture("changed.png"), "{flags}");
    }
    vr.run(&format!("{small} --shading --no-shading -o changed.png")).failed(2);
    vr.run(&format!("{small} --no-shading --colors srgb --set step=0.5 -o changed.png")).succeeded();
}

const SCENE: &str = r#"
[volume]
data = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 1.0]
dims = [2, 2, 2]
[transfer]
points = [ {value = 0.0, color = [1.0, 0.0, 0.0], opacity = 0.0}, {value = 1.0, color = [0.0, 1.0, 0.0], opacity = 0.9} ]
[camera]
eye = [0.5, 0.5, 9.0]
target = [0.5, 0.5, 0.5]
up = [0.0, 1.0, 0.0]
height = 1.0
[image]
size = [17, 9]
[render]
step = 0.25
"#;

#[test]
fn scene_files_are_drawn_and_flags_override_them() {
    let vr = Vr::new();
    vr.write("scene.toml", SCENE);
    let json = vr.run("render --scene scene.toml --json").succeeded().json();
    assert_eq!(json["size"], serde_json::json!([17, 9]));
    let coarse = vr.run("render --scene scene.toml --set step=1 --size 5 --json").succeeded().json();
    assert_eq!(coarse["size"], serde_json::json!([5, 5]));
    assert!(coarse["error"]["max"].as_f64() > json["error"]["max"].as_f64());
    let moved = vr.run("render --scene scene.toml --phantom shells --phantom-size 8 --renderer physics --json");
    assert!(moved.succeeded().json()["error"]["max"].as_f64().unwrap() < 1e-6);
}

#[test]
fn paths_in_a_scene_file_are_relative_to_it() {
    let vr = Vr::new();
    std::fs::create_dir(vr.folder().join("sub")).unwrap();
    vr.write("sub/cube_2x2x2_uint8.raw", [0, 10, 20, 30, 40, 50, 60, 70]);
    vr.write("sub/scene.toml", "[volume]\npath = \"cube_2x2x2_uint8.raw\"\n[image]\nsize = [8, 8]\n");
    vr.run("render --scene sub/scene.toml").succeeded();
    vr.write("here_2x2x2_uint8.raw", [0; 8]);
    vr.run("render here_2x2x2_uint8.raw --scene sub/scene.toml").succeeded();
}

#[test]
fn what_was_assumed_is_said() {
    let vr = Vr::new();
    vr.write("cube_2x2x2_uint8.raw", [0, 10, 20, 30, 40, 50, 60, 70]);
    let run = vr.run("render cube_2x2x2_uint8.raw --size 8").succeeded();
    assert!(run.stderr.lines().all(|l| l.starts_with("note: ")), "{}", run.stderr);
    for word in ["no spacing", "look: "] {
        assert!(run.stderr.contains(word), "no {word:?} in\n{}", run.stderr);
    }
}

#[test]
fn missing_voxels_are_counted() {
    let vr = Vr::new();
    let voxels = [0.0f32, f32::NAN, 1.0, 2.0, f32::INFINITY, 1.0, 0.5, 3.0, 1.0, 1.0, 1.0, 1.0];
    vr.write("holes_3x2x2_float32.raw", voxels.map(f32::to_le_bytes).concat());
    let run = vr.run("render holes_3x2x2_float32.raw --size 8").succeeded();
    assert!(run.stderr.contains("1 of 12 voxels are NaN"), "{}", run.stderr);
    let info = vr.run("info holes_3x2x2_float32.raw --json").succeeded().json();
    assert_eq!((info["nan"].as_u64(), info["infinite"].as_u64()), (Some(1), Some(1)));
}

#[test]
fn raw_files_can_be_described() {
    let vr = Vr::new();
    vr.write("x.bin", [9, 0, 0, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7]);
    let info = vr
        .run("info x.bin --dims 2x2x2 --type u16 --endian big --skip 1 --spacing 1,2,3 --origin -1,0,4 --json")
        .succeeded()
        .json();
    assert_eq!(info["range"], serde_json::json!([0.0, 7.0]));
    assert_eq!(info["spacing"], serde_json::json!([1.0, 2.0, 3.0]));
    assert_eq!(info["origin"], serde_json::json!([-1.0, 0.0, 4.0]));
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let vr = Vr::new();
    let mut child = vr.command(&["info"]).stdout(std::process::Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn an_error_bound_is_kept_and_printed() {
    let vr = Vr::new();
    for bound in [1e-2, 1e-4] {
        let arguments =
            format!("render --phantom marschner-lobb --phantom-size 33 --size 48 --max-error {bound} --json");
        let render = vr.run(&arguments).succeeded().json();
        assert!(render["error"]["max"].as_f64().unwrap() <= bound, "{render}");
        assert_eq!(render["unbounded"].as_u64(), Some(0), "{render}");
    }
    // A scene file may ask for it, too.
    std::fs::write(vr.folder().join("p.toml"), "[volume]\nphantom = \"fog\"\nsize = 9\n[render]\nmax_error = 0.001\n")
        .unwrap();
    let render = vr.run("render --scene p.toml --size 24 --json").succeeded().json();
    assert!(render["error"]["max"].as_f64().unwrap() <= 1e-3, "{render}");
    // Light that is reflected has one, too.
    let render = vr.run("render --phantom fog --phantom-size 9 --size 24 --ambient 0.5 --max-error 0.001 --json");
    assert!(render.succeeded().json()["error"]["max"].as_f64().unwrap() <= 1e-3);
}
