//! `vr bench`, as scripts and people use it.

use serde_json::Value;

use crate::harness::Vr;

const SMALL: &str = "bench --phantom blobs --phantom-size 12 --size 16";

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|x| x.as_f64().expect("a number")).collect()
}

#[test]
fn json_holds_what_scripts_read() {
    let vr = Vr::new();
    let run = vr.run(&format!("{SMALL} --frames 4 --azimuth-step 90 --threads 2 --set step=0.5 --json --quiet"));
    let json = run.succeeded().json();
    let mut keys: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    let mut expected = ["renderer", "settings", "threads", "prepare_ms", "frames_ms", "median_ms", "min_ms", "max_ms"]
        .into_iter()
        .chain(["cpu_ms", "samples", "peak_bytes"])
        .collect::<Vec<_>>();
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!((json["renderer"].as_str(), json["threads"].as_u64()), (Some("raycast"), Some(2)));
    // What was set, and nothing else: a default may not apply beside it.
    assert_eq!(json["settings"], serde_json::json!({"step": 0.5}));
    let mut frames = numbers(&json["frames_ms"]);
    assert_eq!(frames.len(), 4);
    frames.sort_by(f64::total_cmp);
    assert!(frames[0] > 0.0 && json["prepare_ms"].as_f64().unwrap() > 0.0);
    assert_eq!((json["min_ms"].as_f64(), json["max_ms"].as_f64()), (Some(frames[0]), Some(frames[3])));
    let middle = 0.5 * (frames[1] + frames[2]);
    // Times are rounded to a nanosecond.
    assert!((json["median_ms"].as_f64().unwrap() - middle).abs() < 2e-6, "{json}");
    assert!(json["samples"].as_u64().unwrap() > 0);
    if cfg!(target_os = "linux") {
        assert!(json["cpu_ms"].as_f64().unwrap() > 0.0);
        // A program that has drawn pictures holds a megabyte at the least, and this one not a gigabyte.
        assert!((1 << 20..1 << 30).contains(&json["peak_bytes"].as_u64().unwrap()), "{json}");
    }
    assert!(vr.files().is_empty(), "no picture is written");
}

#[test]
fn the_camera_turns_and_a_step_of_zero_keeps_it() {
    let vr = Vr::new();
    let samples = |flags: &str| {
        let json = vr
            .run(&format!("{SMALL} --set termination=1 --set step=0.2 --set leaping=none --json {flags}"))
            .succeeded()
            .json();
        json["samples"].as_u64().unwrap()
    };
    let still = samples("--frames 1");
    assert_eq!(samples("--frames 3 --azimuth-step 0"), still);
    // The mean over views from the side and from an edge differs from the one view's.
    assert_ne!(
        samples("--frames 3 --azimuth-step 20 --elevation 0 --azimuth 0"),
        samples("--frames 1 --elevation 0 --azimuth 0")
    );
    // A box is the same from the right and from the left: as many samples are taken.
    let flags = "--frames 2 --elevation 0 --azimuth 0 --azimuth-step";
    assert_eq!(samples(&format!("{flags} 25")), samples(&format!("{flags} -25")));
}

#[test]
fn the_error_is_that_of_the_scenes_own_view() {
    let vr = Vr::new();
    let json = vr.run(&format!("{SMALL} --frames 3 --azimuth-step 70 --set step=2 --error --json")).succeeded().json();
    let picture = SMALL.replace("bench", "render");
    let render = vr.run(&format!("{picture} --set step=2 --error full --json")).succeeded().json();
    // All 16x16 pixels belong to a 64x64 subgrid.
    assert_eq!(json["error"], render["error"]);
    assert!(json["error"]["max"].as_f64().unwrap() > json["error"]["rmse"].as_f64().unwrap());
    let exact = vr.run(&format!("{SMALL} --frames 1 --renderer physics --error --json")).succeeded().json();
    assert_eq!(exact["renderer"].as_str(), Some("physics"));
    // What is left is the rounding of pixels to f32.
    assert!(exact["error"]["max"].as_f64().unwrap() < 1e-6, "{exact}");
}

#[test]
fn people_get_a_table() {
    let vr = Vr::new();
    let run = vr.run(&format!("{SMALL} --frames 3 --azimuth-step 7.5 --threads 1 --error --quiet"));
    assert_eq!(run.succeeded().stdout, "");
    let run = vr.run(&format!("{SMALL} --frames 3 --azimuth-step 7.5 --set step=0.5 --threads 1 --error")).succeeded();
    for words in [
        "phantom blobs",
        "16x16 pixels",
        "step=0.5",
        "azimuth",
        "7.5",
        "median",
        "on 1 thread (after 2 warm-up frames, which count nowhere)",
        "prepare",
        "samples a frame",
        "RMSE",
        "reference",
    ] {
        assert!(run.stdout.contains(words), "no {words:?} in\n{}", run.stdout);
    }
    let cold = vr.run(&format!("{SMALL} --frames 1 --warm-up 0")).succeeded().stdout;
    assert!(cold.contains("no warm-up frame") && cold.contains("settings all at their defaults"), "{cold}");
}

#[test]
fn scene_files_are_timed_with_their_renderer_and_options() {
    let vr = Vr::new();
    vr.write(
        "scene.toml",
        "[volume]\nphantom = \"fog\"\nsize = 8\n[image]\nsize = [8, 8]\n[render]\nrenderer = \"raycast\"\nstep = 0.75\n",
    );
    let json = vr.run("bench --scene scene.toml --frames 1 --json").succeeded().json();
    assert_eq!(json["settings"]["step"].as_f64(), Some(0.75));
    let json = vr.run("bench --scene scene.toml --frames 1 --json --set step=2").succeeded().json();
    assert_eq!(json["settings"]["step"].as_f64(), Some(2.0));
    let json = vr.run("bench --scene scene.toml --frames 1 --json --renderer physics").succeeded().json();
    assert_eq!(json["settings"], serde_json::json!({}), "another renderer's options are not its own");
}

#[test]
fn nonsense_is_refused() {
    let vr = Vr::new();
    for (flags, words) in [
        ("--frames 0", &["--frames", "0"][..]),
        ("--frames -3", &["-3"]),
        ("--frames many", &["--frames", "many"]),
        ("--azimuth-step nan", &["--azimuth-step", "-360 to 360"]),
        ("--azimuth-step inf", &["--azimuth-step", "-360 to 360"]),
        ("--azimuth-step=-400", &["--azimuth-step", "-360 to 360"]),
        ("--azimuth-step right", &["--azimuth-step", "degrees"]),
        ("--warm-up -1", &["-1"]),
        ("--threads 0", &["--threads", "0"]),
        ("--renderer raytrace", &["raytrace", "raycast"]),
        ("--set stop=1", &["stop", "step"]),
        ("--size 0x8", &["size"]),
    ] {
        let error = vr.run(&format!("{SMALL} {flags}")).failed(2);
        for word in words {
            assert!(error.contains(word), "{flags}: no {word:?} in {error}");
        }
    }
    vr.run("bench --scene missing.toml").failed(1);
}

#[test]
fn help_tells_what_is_timed() {
    let help = Vr::new().run("bench --help").succeeded().stdout;
    for words in ["--frames", "--azimuth-step", "--warm-up", "--error", "--scene", "vr help raycast"] {
        assert!(help.contains(words), "no {words:?} in\n{help}");
    }
}
