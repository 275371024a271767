//! `vr report`, `vr verify` and `vr render --target-rmse`.

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::harness::Vr;

/// The errors that no later version may exceed. A change that makes them better on purpose writes it anew:
/// `vr report --untimed -o FOLDER`, and FOLDER/errors.json is the file.
const BASELINE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../benches/baseline.json");

fn number(json: &serde_json::Value, path: &str) -> f64 {
    json.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("{path} in {json}"))
}

#[test]
fn errors_of_the_quick_suite_are_not_worse_than_the_baseline() {
    let vr = Vr::new();
    let run = vr.run_with(&["report", "--untimed", "--cache", "exact", "-o", "report", "--baseline", BASELINE]);
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    assert!(run.stdout.contains(" 0 not as documented"), "{}", run.stdout);
    for file in ["index.html", "report.json", "points.csv", "errors.json"] {
        assert!(vr.exists(&format!("report/{file}")), "{file}");
    }
    assert!(!vr.exists("report/journal-quick.jsonl"), "nothing is left to take up");

    let page = fs::read_to_string(vr.folder().join("report/index.html")).unwrap();
    // Nothing from elsewhere: no script, no link but within the page, no picture that is not in it.
    for outside in ["<script", "src=\"http", "href=\"http", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("<svg") && page.contains("data:image/png;base64,"));
    // Every term that can be opened is explained.
    let terms: Vec<&str> =
        page.split("popovertarget=\"").skip(1).map(|rest| &rest[..rest.find('"').unwrap()]).collect();
    assert!(terms.len() > 20 && terms.iter().all(|term| page.contains(&format!("popover id=\"{term}\""))));
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(vr.folder().join("report/report.json")).unwrap()).unwrap();
    made_again(&vr, ".", &report["subjects"][0]["picture"]);
    // The terminal has a summary alone.
    assert!(run.stdout.lines().count() <= 16 && run.stdout.contains("index.html and 5 more"), "{}", run.stdout);

    let table = fs::read_to_string(vr.folder().join("report/points.csv")).unwrap();
    let baseline: serde_json::Value = serde_json::from_str(&fs::read_to_string(BASELINE).unwrap()).unwrap();
    let points: usize = baseline.as_object().unwrap().values().map(|s| s.as_object().unwrap().len()).sum();
    assert_eq!(table.lines().count(), points + 1, "one row each, and the header");
}

/// Checks that the command of a picture of a report, run in a folder, makes the picture, and that its record does.
#[track_caller]
fn made_again(vr: &Vr, folder: &str, picture: &serde_json::Value) {
    let png = STANDARD.decode(picture["png"].as_str().unwrap()).unwrap();
    vr.write("page.png", &png);
    let words: Vec<&str> = picture["command"].as_str().unwrap().split(' ').collect();
    assert_eq!(words[..2], ["vr", "render"], "{words:?}");
    let place = vr.folder().join(folder);
    let made = vr.command(&[&words[1..], &["--error", "none"]].concat()).current_dir(&place).output().unwrap();
    assert!(made.status.success(), "{words:?}: {}", String::from_utf8_lossy(&made.stderr));
    let again = image::open(place.join(words.last().unwrap())).unwrap();
    assert!(again == vr.picture("page.png"), "{words:?} made another picture");
}

#[test]
fn pictures_of_ones_own_scene_are_made_again_by_their_commands() {
    let vr = Vr::new();
    let voxels: Vec<u8> = (0..16 * 16 * 16).map(|i: usize| (i % 16 * 9 + i / 16 % 16 * 5 + i / 256) as u8).collect();
    vr.write("ramp_16x16x16_uint8.raw", voxels);
    vr.write(
        "s.toml",
        "[volume]\npath = \"ramp_16x16x16_uint8.raw\"\n[annotations]\ntitle = \"T\"\n[render]\nstep = 0.9\n",
    );
    let flags = "--scene s.toml --azimuth 70 --shading --size 24x18 --untimed --no-cache --renderer raycast";
    let run = vr.run(&format!("report {flags} -o r")).succeeded();
    assert!(run.stderr.contains("annotations of the scene file: without effect"), "{}", run.stderr);
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(vr.folder().join("r/report.json")).unwrap()).unwrap();
    assert_eq!(report["command"], format!("vr report {flags} -o r"));
    let subject = &report["subjects"][0];
    assert!(subject["note"].as_str().unwrap().contains("scene.toml"));
    made_again(&vr, "r", &subject["picture"]);
    vr.run("rerun page.png ramp_16x16x16_uint8.raw").succeeded();
    // A map has its command, too.
    let map = subject["error_maps"][0]["command"].as_str().unwrap();
    assert!(map.contains("--error full --error-map "), "{map}");
}

#[test]
fn a_baseline_that_was_better_fails() {
    let vr = Vr::new();
    let report = "report --phantom fog --phantom-size 12 --size 12x12 --untimed --cache exact --renderer raycast -o r";
    assert_eq!(vr.run(report).code, 0);
    let errors = fs::read_to_string(vr.folder().join("r/errors.json")).unwrap();
    let mut better: serde_json::Value = serde_json::from_str(&errors).unwrap();
    better["fog"]["raycast midpoint 4"]["rmse"] = 1e-9.into();
    vr.write("better.json", better.to_string());
    let run = vr.run(&format!("{report} --baseline better.json"));
    assert_eq!(run.code, 1, "{}", run.stdout);
    assert!(run.stderr.contains("fog: raycast midpoint 4: RMSE"), "{}", run.stderr);
    // What two runs find is the same, to the last bit: the pictures are drawn twice, the correct pixels come from the cache.
    assert_eq!(fs::read_to_string(vr.folder().join("r/errors.json")).unwrap(), errors);
}

// One report shows both. The ray caster is left out: it takes ten times as long as the others together, and the tests of its crate hold it to the
// same cases, promises included.
#[test]
fn a_report_that_was_cut_short_is_taken_up_and_has_no_unexplained_failure() {
    let vr = Vr::new();
    let renderers = ["shearwarp", "splat", "texslice"].map(|name| ["--renderer", name]);
    let mut report = vec!["report", "--suite", "hard", "--no-cache", "-o", "r", "--json"];
    report.extend(renderers.as_flattened());
    let mut process = vr.command(&report).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let journal = vr.folder().join("r/journal-hard.jsonl");
    let deadline = Instant::now() + Duration::from_secs(60);
    let noted = loop {
        let text = fs::read_to_string(&journal).unwrap_or_default();
        if text.lines().count() >= 3 && text.ends_with('\n') {
            break text;
        }
        assert!(Instant::now() < deadline, "nothing is noted");
        sleep(Duration::from_millis(5));
    };
    process.kill().unwrap();
    process.wait().unwrap();
    // What was noted is taken as it is, and not made again.
    let marked = noted.replacen("\"summary\":\"", "\"summary\":\"as noted: ", 1);
    assert_ne!(marked, noted);
    fs::write(&journal, marked).unwrap();
    let run = vr.run_with(&report);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("as noted: "), "{}", run.stdout);
    assert!(!journal.exists());
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let cells = json["stability"].as_array().unwrap();
    assert!(cells.len() >= 15 * 5, "all cases, several candidates: {}", cells.len());
    for cell in cells {
        assert_ne!(cell["verdict"]["verdict"], "failed", "{cell}");
    }
}

#[test]
fn orders_are_verified_on_a_volume_of_ones_own() {
    let vr = Vr::new();
    let run = vr.run("verify --phantom hydrogen --phantom-size 24 --no-cache --json");
    assert_eq!(run.code, 0, "{}{}", run.stdout, run.stderr);
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let orders = json["orders"].as_array().unwrap();
    assert!(orders.iter().any(|o| o["refined"] == "step") && orders.iter().any(|o| o["refined"] == "grid"));
    assert!(
        vr.run("verify --renderer physics").stderr.contains("must name one that documents an order of convergence")
    );
    // Orders are claimed of unshaded light; nothing held is nothing verified.
    let shaded = vr.run("verify --phantom fog --phantom-size 8 --shading --no-cache");
    assert_eq!((shaded.code, shaded.stderr.contains("no order could be verified")), (1, true), "{}", shaded.stderr);
}

#[test]
fn flags_about_a_scene_need_one() {
    let vr = Vr::new();
    for command in ["report --untimed --shading", "verify --size 9x9", "report --suite hard --azimuth 3"] {
        let run = vr.run(command);
        assert_eq!((run.code, run.stderr.contains("need one")), (2, true), "{command}: {}", run.stderr);
    }
    assert!(vr.files().is_empty());
}

#[test]
fn a_target_chooses_a_setting_that_keeps_it() {
    let vr = Vr::new();
    let render = "render --phantom blobs --phantom-size 32 --size 96x80 --no-cache --error full --json --target-rmse";
    for target in [1e-2, 1e-4] {
        let run = vr.run(&format!("{render} {target}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        assert!(number(&json, "/error/rmse") <= target, "{json}");
        assert!(number(&json, "/chosen/rmse_at_most") <= target && number(&json, "/chosen/confidence") == 0.95);
    }
    let run = vr.run(&format!("{render} 1e-9"));
    assert_eq!((run.code, run.stderr.contains("at least 1e-7")), (2, true), "{}", run.stderr);
    assert_eq!(vr.run(&format!("{render} 1e-2 --set step=1")).code, 2, "settings are what is chosen");
}

/// Single bright voxels: a handful of pixels make all of the error, and an even sample of pixels holds none of them.
#[test]
fn a_target_is_kept_where_large_errors_are_rare() {
    let vr = Vr::new();
    let mut voxels = vec![0u8; 32 * 32 * 32];
    for star in 0..6 {
        voxels[(star * 5003 + 1234) % (32 * 32 * 32)] = 255;
    }
    vr.write("stars.raw", &voxels);
    let scene = "[volume]\npath = \"stars.raw\"\ndims = [32, 32, 32]\ntype = \"u8\"\n[transfer]\nunit_distance = 1.0\n\
                 points = [{ value = 200.0, color = [1.0, 0.9, 0.6], opacity = 0.0 }, { value = 255.0, color = [1.0, 0.9, 0.6], opacity = 0.95 }]\n\
                 [image]\nsize = [160, 160]\n";
    vr.write("stars.toml", scene);
    for (target, shading) in [(1e-2, ""), (1e-3, ""), (1e-4, ""), (1e-3, "--shading")] {
        let run = vr
            .run(&format!("render --scene stars.toml --no-cache --error full --json --target-rmse {target} {shading}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        let json = run.json();
        let (rmse, at_most) = (number(&json, "/error/rmse"), number(&json, "/chosen/rmse_at_most"));
        assert!(rmse <= at_most && at_most <= target, "{target} {shading}: {json}");
    }
}

#[test]
fn pages_that_are_no_report_are_spared() {
    let vr = Vr::new();
    fs::create_dir(vr.folder().join("site")).unwrap();
    vr.write("site/index.html", "<!DOCTYPE html><title>Home</title>");
    let command = "report --suite hard --renderer splat --untimed --no-cache -o site";
    let refused = vr.run(command).failed(2);
    assert!(refused.contains("site/index.html") && refused.contains("--force"), "{refused}");
    assert_eq!(fs::read_dir(vr.folder().join("site")).unwrap().count(), 1);
    vr.run(&format!("{command} --force")).succeeded();
    // A report's own page is replaced without a word.
    vr.run(command).succeeded();
}
