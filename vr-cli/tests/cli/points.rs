//! Scattered points: told of, chosen by flags, refused in one line.

use crate::harness::{Vr, test_data};

const CSV: &str = "x,y,z,h,Temperature,m\n0,0,0,0.5,10,1\n1,-2,0.5,0.25,20,1\n3,1.5,2,1,30,1\n";

#[test]
fn info_tells_of_points() {
    let vr = Vr::new();
    vr.write("p.csv", CSV);
    let run = vr.run("info p.csv").succeeded();
    for word in ["p.csv, 3 points", "CSV", "x, y, z, h, Temperature, m", "cubic-spline", "0.5 to 2", "10 to 30"] {
        assert!(run.stdout.contains(word), "no {word:?} in\n{}", run.stdout);
    }
    assert!(run.stderr.contains("2 smoothing lengths, 'h'"), "{}", run.stderr);
    let json = vr.run("info p.csv --json").succeeded().json();
    assert_eq!((&json["points"], &json["radius"][1], &json["values"][0]), (&3.into(), &2.0.into(), &10.0.into()));
    assert_eq!(json["bounds"], serde_json::json!([[-1.0, -2.5, -1.0], [5.0, 3.5, 4.0]]));
    assert_eq!(json["file"]["arrays"][5], "m");

    let flags = "--value m --kernel cone --radius 0.25 --radius-scale 2 --column weight=h --position-columns y,x,z";
    let json = vr.run(&format!("info p.csv --json {flags}")).succeeded().json();
    assert_eq!(json["bounds"][0], serde_json::json!([-2.5, -0.5, -0.5]));
    assert_eq!((&json["kernel"], &json["weight_sum"]), (&"cone".into(), &1.75.into()));
    let json = vr.run("info --phantom plummer --points-count 70 --json").succeeded().json();
    assert_eq!((&json["points"], &json["volume"]), (&70.into(), &"phantom plummer, 70 points".into()));
    assert!(vr.run("info nowhere.csv").failed(1).contains("nowhere.csv"));
}

#[test]
fn wrong_flags_and_files_get_one_line() {
    let vr = Vr::new();
    vr.write("p.csv", CSV);
    vr.write("zero.csv", CSV.replace("0.25", "0"));
    vr.write("p.toml", "[volume]\npath = \"p.csv\"\nradius = -1.0\n");
    for (arguments, code, words) in [
        ("zero.csv", 1, &["zero.csv", "line 3", "'h'", "positive"][..]),
        ("p.csv --points-count 3", 2, &["--points-count"]),
        ("p.csv --value Pressure", 1, &["value", "Pressure", "Temperature"]),
        ("p.csv --radius 0", 2, &["volume.radius", "positive"]),
        ("p.csv --kernel cube", 2, &["--kernel", "cubic-spline"]),
        ("p.csv --column x=h", 2, &["--column", "smoothing_length"]),
        ("p.csv --frame 0", 1, &["frame", "scattered points"]),
        ("--phantom plummer --phantom-size 4", 2, &["volume.size", "made of points"]),
        ("--phantom plummer --kernel cone", 2, &["volume.kernel"]),
        ("--phantom fog --points-count 4", 2, &["volume.count", "grid"]),
    ] {
        let error = vr.run(&format!("info {arguments}")).failed(code);
        for word in words {
            assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
        }
    }
    assert!(vr.run("render --scene p.toml").failed(1).contains("p.toml: volume.radius"));
    // A flag that is right is not to blame for a key whose name begins with its own.
    vr.write("p.toml", "[volume]\npath = \"p.csv\"\nradius_scale = -1.0\n");
    assert!(vr.run("render --scene p.toml --radius 2").failed(1).contains("p.toml: volume.radius_scale: found -1"));
    assert!(
        vr.run("render --scene p.toml --radius-scale 0").failed(2).starts_with("error: volume.radius_scale: found 0")
    );
    // A grid is what it takes.
    let error = vr.run("render p.csv --renderer shearwarp --error none").failed(1);
    assert!(error.contains("shearwarp") && error.contains("scattered points"), "{error}");
    assert_eq!(vr.files(), ["p.csv", "p.toml", "zero.csv"]);
    // Splatting is what draws points where no renderer is named.
    let json = vr.run("render p.csv --size 8 --error none --json").succeeded().json();
    assert_eq!(json["renderer"], "splat");
}

#[test]
fn real_points() {
    let Some(data) = test_data() else { return };
    let vr = Vr::new();
    let halo = data.join("particles/halo_low_res.npy");
    let run = vr.run_with(&["info", halo.to_str().unwrap()]).succeeded();
    assert!(run.stdout.contains("halo_low_res.npy, 32314 points"), "{}", run.stdout);
    assert!(run.stderr.contains("58th neighbour"), "{}", run.stderr);
}

#[test]
fn means_and_colours_are_drawn() {
    let vr = Vr::new();
    vr.write("p.csv", CSV);
    // The mean of one value is that value wherever a support reaches: one colour times the opacity.
    let flags = "--value 1 --mixing mean --point 0,1,1,1,0.2 --point 2,1,1,1,0.2 --size 16 --error none";
    for renderer in ["splat", "raycast", "physics"] {
        vr.run(&format!("render p.csv {flags} --renderer {renderer} -o {renderer}.exr")).succeeded();
    }
    for renderer in ["splat", "raycast"] {
        // Sheets and steps of half a radius end where the body does, but for rays that graze it.
        vr.run(&format!("diff {renderer}.exr physics.exr --fail-above 0.05")).succeeded();
    }
    let run = vr.run("info p.csv --mixing mean --color-value Temperature --color-map cool-warm --json").succeeded();
    let json = run.json();
    assert_eq!((&json["mixing"], &json["colors"]), (&"mean".into(), &true.into()));
    assert!(run.stderr.contains("colours: 'Temperature' from 10 to 30, by cool-warm"), "{}", run.stderr);
    vr.run("render p.csv --color-value Temperature --value 1 --size 16 --error none -o colors.png").succeeded();
    for (arguments, code, words) in [
        ("p.csv --color-map inferno", 2, &["volume.color_map", "color_value"][..]),
        ("p.csv --color-value Temperature --color-range 3,3", 2, &["volume.color_range"]),
        ("p.csv --color-value Pressure", 1, &["color_value", "Pressure", "Temperature"]),
        ("p.csv --mixing median", 2, &["--mixing", "mean"]),
        ("--phantom fog --mixing mean", 2, &["volume.mixing"]),
    ] {
        let error = vr.run(&format!("info {arguments}")).failed(code);
        for word in words {
            assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
        }
    }
    // A weight that is no divisor.
    vr.write("zero.csv", CSV.replace("30,1", "30,0"));
    let error = vr.run("info zero.csv --mixing mean --column weight=m").failed(1);
    assert!(error.contains("point 2") && error.contains("weight 0"), "{error}");
    vr.run("info zero.csv --column weight=m").succeeded();
}
