//! `vr ray`: one pixel, told.

use serde_json::Value;

use crate::harness::Vr;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("no number: {value}"))
}

fn four(value: &Value) -> [f64; 4] {
    std::array::from_fn(|c| number(&value[c]))
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("no list: {value}"))
}

#[test]
fn tells_of_the_embedded_scene() {
    let vr = Vr::new();
    let run = vr.run("ray 256 256").succeeded();
    for word in
        ["pixel", "256, 256 of 512x512", "exact", "error", "why", "value", "clear", "kappa", "theta", "knots crossed"]
    {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    assert!(run.stdout.contains("40 of ") && run.stdout.contains("--all"), "{}", run.stdout);
    let drawing = run.stdout.lines().filter(|line| line.contains('│'));
    assert!(drawing.clone().count() > 20 && drawing.clone().all(|line| line.chars().count() <= 100), "{}", run.stdout);
    let all = vr.run("ray 256 256 --all").succeeded().stdout;
    assert!(all.lines().count() > run.stdout.lines().count() + 60 && !all.contains("--all"));
    assert!(vr.files().is_empty());
}

#[test]
fn the_pixel_is_that_of_the_picture_and_every_step_adds_up() {
    let vr = Vr::new();
    vr.write("plain.toml", "[volume]\nphantom = \"shells\"\nsize = 24\n[image]\nsize = [40, 30]\n");
    let scene = "--scene plain.toml --set vector=off --set step=0.5";
    let json = vr.run(&format!("ray 17 13 {scene} --json")).succeeded().json();
    assert_eq!(json["own_kernel"], true);
    let rgba = four(&json["rgba"]);
    // The picture itself, in 16 bits.
    vr.run(&format!("render {scene} --error none --encode none --bits 16 --alpha -o a.png")).succeeded();
    let picture = vr.picture("a.png").to_rgba16();
    let alpha = f64::from(picture.get_pixel(17, 13).0[3]) / 65535.0;
    assert!((alpha - rgba[3]).abs() < 1e-5 && alpha > 0.0, "{alpha} {rgba:?}");

    let (steps, exact) = (list(&json["steps"]), four(&json["exact"]["rgba"]));
    let worst = ["red", "green", "blue", "opacity"].iter().position(|name| json["worst"] == **name).unwrap();
    let changes: f64 = steps.iter().map(|step| number(&step["change"])).sum();
    let error = changes + number(&json["left_out"]);
    assert!((error - (rgba[worst] - exact[worst])).abs() < 1e-5, "{error}");
    let last = list(&json["segments"]).last().unwrap();
    let (running, bound) = (four(&last["running"]), number(&last["running_error"]) + number(&json["exact"]["error"]));
    assert!((0..4).all(|c| (running[c] - exact[c]).abs() <= bound), "{running:?} {exact:?}");
    // Knots of the whole ray are those of its steps, and of what was leaped over.
    let knots = |of: &Value| list(of).len();
    let crossed: usize = steps.iter().map(|step| knots(&step["knots"])).sum();
    let fronts = list(&json["segments"]).iter().flat_map(|segment| list(&segment["front"]));
    let all = fronts.filter(|cut| cut.get("knot").is_some()).count();
    assert!(crossed > 0 && crossed <= all, "{crossed} {all}");
}

#[test]
fn writes_every_step_as_csv() {
    let vr = Vr::new();
    let run = vr.run("ray 20 20 --size 40 --csv steps.csv").succeeded();
    assert!(run.stdout.contains("steps.csv"));
    assert_eq!(vr.files(), ["steps.csv"]);
    let text = std::fs::read_to_string(vr.folder().join("steps.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    for name in
        ["step", "begin", "length", "index_x", "value", "kappa", "theta", "light_r", "tau", "exact_tau", "error"]
    {
        assert!(header.contains(&name), "{header:?}");
    }
    let rows: Vec<&str> = lines.collect();
    let json = vr.run("ray 20 20 --size 40 --json").succeeded().json();
    assert_eq!(rows.len(), list(&json["steps"]).len());
    assert!(rows.iter().all(|row| row.split(',').count() == header.len()));
}

#[test]
fn a_renderer_that_cannot_tell_still_shows_the_exact_solution() {
    let vr = Vr::new();
    for renderer in ["--renderer physics", "--max-error 0.004"] {
        let run = vr.run(&format!("ray 12 12 --size 24 {renderer} --all --csv parts.csv --force")).succeeded();
        for word in ["cannot list", "begins at", "entry", "tau so far", "exact"] {
            assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
        }
        let json = vr.run(&format!("ray 12 12 --size 24 {renderer} --json")).succeeded().json();
        assert!(json["steps"].is_null() && list(&json["segments"]).len() > 20, "{json}");
        assert!(four(&json["error"]).iter().all(|e| e.abs() < 0.004), "{json}");
        let text = std::fs::read_to_string(vr.folder().join("parts.csv")).unwrap();
        assert_eq!(text.lines().count(), list(&json["segments"]).len() + 1);
    }
}

#[test]
fn picked_values_have_no_light() {
    let vr = Vr::new();
    for compositing in ["maximum", "minimum", "average", "first --threshold 0.05"] {
        let run = vr.run(&format!("ray 16 16 --size 32 --compositing {compositing}")).succeeded();
        assert!(run.stdout.contains("value") && !run.stdout.contains("theta"), "{}", run.stdout);
        assert_eq!(run.stdout.contains(" * "), compositing != "average", "{}", run.stdout);
        let json = vr.run(&format!("ray 16 16 --size 32 --json --compositing {compositing}")).succeeded().json();
        assert!(list(&json["steps"]).iter().all(|step| step.get("light").is_none()), "{json}");
    }
}

#[test]
fn rays_that_miss_and_pixels_that_do_not_exist() {
    let vr = Vr::new();
    let unseen = vr.run("ray 0 0 --size 30x20").succeeded().stdout;
    assert!(unseen.contains("nothing on the way") && !unseen.contains("clear"), "{unseen}");
    let miss = vr.run("ray 0 0 --size 30x20 --fov 60 --csv none.csv").succeeded();
    assert!(miss.stdout.contains("misses the volume"), "{}", miss.stdout);
    assert!(vr.run("ray 30 5 --size 30x20").failed(2).contains("X: found 30; must be 0 to 29: the picture is 30x20"));
    assert!(vr.run("ray 3 -1 --size 30x20").failed(2).contains("Y: found -1; must be 0 to 19"));
    vr.run("ray 3").failed(2);
    vr.run("ray a 3").failed(2);
    assert!(vr.run("ray 3 3 --csv steps.txt").failed(2).contains("csv"));
    assert!(vr.run("ray 3 3 --csv no/where.csv").failed(1).contains("where.csv"));
    assert!(vr.run("ray --help").succeeded().stdout.contains("vr help raycast"));
}
