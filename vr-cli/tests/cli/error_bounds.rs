//! Error bounds: their lines and the exit code.

use crate::harness::Vr;

/// A wall of a mesh of values that no two rays agree on: along many rays the correct pixel jumps, so that no bound is small.
const JUMPS: &str = r#"
[volume]
dims = [3, 3, 3]
data = [0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]
[transfer]
unit_distance = 1.0
points = [
    { value = 0.0, color = [0.0, 0.0, 0.0], opacity = 0.0 },
    { value = 1.0, color = [0.0, 0.0, 0.0], opacity = 0.0 },
    { value = 1.0, color = [1.0, 1.0, 1.0], opacity = 1.0 },
    { value = 2.0, color = [1.0, 1.0, 1.0], opacity = 1.0 },
]
[camera]
projection = "orthographic"
eye = [1.0, 9.0, 1.0]
target = [1.0, 1.0, 1.0]
up = [0.0, 0.0, 1.0]
height = 1.0
[image]
size = [5, 5]
"#;

/// Emission on its own, cut at an opacity.
const EMITTING: &str = r#"
[volume]
phantom = "blobs"
size = 12
[transfer]
points = [
    { value = 0.0, color = [0.0, 0.0, 0.0], opacity = 0.0, emission = [0.0, 0.0, 0.0] },
    { value = 1.0, color = [1.0, 1.0, 1.0], opacity = 0.5, emission = [0.2, 0.4, 0.1] },
]
[render]
compositing = "accumulate"
level = 0.5
"#;

#[test]
fn a_proven_bound_is_printed() {
    let vr = Vr::new();
    let render = "render --phantom blobs --phantom-size 12 --size 8 --error none -o p.png";
    for bound in ["--max-error 0.004", "--set max-error=0.004", "--renderer physics --max-error 0.004"] {
        let run = vr.run(&format!("{render} {bound}")).succeeded();
        assert!(run.stdout.contains("error bound proven: every pixel within 4.00e-3"), "{bound}: {}", run.stdout);
        let json = vr.run(&format!("{render} {bound} --json")).succeeded().json();
        assert_eq!((&json["promise"]["kept"], &json["promise"]["unbounded"]), (&true.into(), &0.into()), "{json}");
        assert_eq!(json["promise"]["max_error"].as_f64(), Some(0.004), "{json}");
        let quiet = vr.run(&format!("{render} {bound} --quiet")).succeeded();
        assert_eq!((quiet.stdout, quiet.stderr), (String::new(), String::new()));
    }
    // Without a bound, no line is printed.
    for other in ["", "--renderer physics", "--set step=1"] {
        let run = vr.run(&format!("{render} {other}")).succeeded();
        assert!(!run.stdout.contains("error bound"), "{other}: {}", run.stdout);
        assert!(vr.run(&format!("{render} {other} --json")).json()["promise"].is_null());
    }
}

#[test]
fn what_a_renderer_cannot_promise_is_told_with_one_that_can() {
    let vr = Vr::new();
    let render = "render --phantom blobs --phantom-size 12 --size 8 --error none -o p.png --max-error 0.004";
    let shaded = vr.run(&format!("{render} --shading")).succeeded();
    assert!(shaded.stdout.contains("error bound proven"), "{}", shaded.stdout);
    for other in ["--filter bspline", "--gradient-opacity 0,2"] {
        let drawn = vr.run(&format!("{render} --renderer raycast {other}")).succeeded();
        assert!(drawn.stdout.contains("error bound proven"), "{other}: {}", drawn.stdout);
    }
    vr.write("emitting.toml", EMITTING);
    let emitting = "render --scene emitting.toml --size 8 --error none -o p.png --force --max-error 0.004";
    let drawn = vr.run(emitting).succeeded();
    assert!(drawn.stdout.contains("error bound proven"), "{}", drawn.stdout);
    let refused = vr.run("render --phantom blobs --size 8 --error none -o p.png --renderer march").failed(1);
    assert!(refused.contains("uniform grid") && refused.contains(" or physics can)"), "{refused}");
    let refused = vr.run(&format!("{render} --renderer splat")).failed(2);
    assert!(refused.contains("splat cannot bound the error"), "{refused}");
}

#[test]
fn where_no_renderer_is_named_one_that_can_bound_the_error_draws() {
    let vr = Vr::new();
    let render = "render --size 8 --error none -o p.png --force";
    for (scene, told) in [
        (
            "--phantom plummer --points-count 20 --max-error 0.004",
            "renderer raycast, since splat cannot bound the error",
        ),
        (
            "--phantom plummer --points-count 20 --quality proven",
            "renderer raycast, since splat cannot bound the error",
        ),
    ] {
        let run = vr.run(&format!("{render} {scene}")).succeeded();
        assert!(run.stdout.contains("error bound proven"), "{scene}: {}", run.stdout);
        assert!(run.stderr.contains(told), "{scene}: {}", run.stderr);
    }
    // Nothing is said where the usual one can.
    let run = vr.run(&format!("{render} --phantom blobs --phantom-size 12 --max-error 0.004")).succeeded();
    assert!(!run.stderr.contains("cannot bound"), "{}", run.stderr);
}

#[test]
fn a_bound_that_is_not_proven_has_an_exit_code_of_its_own() {
    let vr = Vr::new();
    vr.write("scene.toml", JUMPS);
    let run = vr.run("render --scene scene.toml --max-error 0.004 --error none -o p.png");
    assert!(run.stdout.contains("error bound not proven: "), "{}", run.stdout);
    let error = run.failed(3);
    assert!(error.contains("5 of 25 pixels") && error.contains("largest bound"), "{error}");
    assert!(vr.exists("p.png"), "the picture is there, for those who want it");

    let quiet = vr.run("render --scene scene.toml --max-error 0.004 --error none -o p.png --quiet");
    assert_eq!((&*quiet.stdout, quiet.stderr.trim()), ("", &*error));
    quiet.failed(3);

    let json = vr.run("render --scene scene.toml --max-error 0.004 --error none -o p.png --json");
    let bound = &json.json()["promise"];
    assert_eq!((&bound["kept"], &bound["unbounded"]), (&false.into(), &5.into()), "{bound}");
    assert!(bound["max_bound"].as_f64().is_none_or(|bound| bound > 0.004), "{bound}");
    json.failed(3);

    // A bound of the scene file, and one for many frames.
    vr.write("bound.toml", format!("{JUMPS}\n[render]\nmax_error = 0.004\n"));
    vr.run("render --scene bound.toml --error none -o p.png").failed(3);
    vr.run("bench --scene bound.toml --frames 2 --azimuth-step 0").failed(3);
    vr.run("bench --scene scene.toml --frames 2 --azimuth-step 0").succeeded();
}

#[test]
fn exit_codes_are_documented() {
    let vr = Vr::new();
    for command in ["--help", "render --help"] {
        let help = vr.run(command).succeeded().stdout;
        assert!(help.contains("Exit codes:") && help.contains("  3  "), "{help}");
    }
}

#[test]
fn a_quality_is_what_it_stands_for() {
    let vr = Vr::new();
    vr.write("scene.toml", format!("{JUMPS}\n[render]\nmax_error = 0.004\n"));
    let run = |flags: &str| vr.run(&format!("render --scene scene.toml --error none -o p.png --force --json {flags}"));
    for (quality, option) in [("draft", "quality=draft"), ("normal", "quality=normal"), ("fine", "quality=fine")] {
        // The flag overrides the bound of the scene file.
        let (by_flag, by_option) = (run(&format!("--quality {quality}")).json(), {
            vr.write("plain.toml", JUMPS);
            vr.run(&format!("render --scene plain.toml --error none -o q.png --force --json --set {option}")).json()
        });
        assert_eq!(by_flag["samples"], by_option["samples"], "{quality}");
        assert!(by_flag["promise"].is_null(), "{by_flag}");
        assert_eq!(vr.picture("p.png"), vr.picture("q.png"), "{quality}");
    }
    assert_eq!(run("--quality proven").json()["promise"]["max_error"].as_f64(), Some(0.004));
    for (flags, words) in [
        ("--quality draft --renderer shearwarp", &["shearwarp", "--target-rmse"][..]),
        ("--quality draft --set step=1", &["quality", "steps=auto"]),
        ("--quality draft --set quality=fine", &["--quality", "--set quality"]),
        ("--quality draft --max-error 0.1", &["--quality", "--max-error"]),
        ("--quality best", &["draft", "proven"]),
    ] {
        let message = run(flags).failed(2);
        for word in words {
            assert!(message.contains(word), "{flags}: {message}");
        }
    }
}
