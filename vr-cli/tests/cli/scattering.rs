//! Media that scatter, as a user asks for them.

use crate::harness::Vr;

/// A scene of fog whose colour is its albedo, under one lamp.
const SCENE: &str = "[volume]\nphantom = \"fog\"\nsize = 9\n[scattering]\nalbedo = 0.9\nphase = { henyey-greenstein = 0.5 }\n\
                     environment = [0.1, 0.1, 0.2]\nlights = [{ direction = [0.0, 1.0, 0.0] }]\n[image]\nsize = [12, 9]\n";

#[test]
fn pictures_tell_their_noise_and_more_paths_make_less_of_it() {
    let vr = Vr::new();
    vr.write("fog.toml", SCENE);
    let noise = |paths: u32| {
        let json = vr.run(&format!("render --scene fog.toml --set paths={paths} --json -o x.exr")).succeeded().json();
        assert_eq!(
            (json["renderer"].as_str(), json["own_errors"]["kind"].as_str()),
            (Some("light"), Some("standard error"))
        );
        let noise = json["own_errors"]["rms"].as_f64().unwrap();
        // Within a third: 108 pixels.
        assert!((json["error"]["rmse"].as_f64().unwrap() / noise - 1.0).abs() < 0.33, "{json}");
        noise
    };
    let (few, many) = (noise(16), noise(256));
    assert!(few > 2.0 * many && many > 0.0, "{few} {many}");
    let run = vr.run("render --scene fog.toml --set paths=16 -o x.png").succeeded();
    assert!(run.stdout.contains("noise    standard error"), "{}", run.stdout);
}

#[test]
fn flags_choose_the_model_and_light_it() {
    let vr = Vr::new();
    let phantom = "--phantom blobs --phantom-size 12 --size 16 -o x.png --json";
    let full = vr.run(&format!("render {phantom} --model full --set paths=8 --light 1,1,0")).succeeded().json();
    assert_eq!(full["renderer"], "light");
    let single = vr.run(&format!("render {phantom} --model single")).succeeded().json();
    assert!(single["own_errors"].is_null() && single["samples"].as_u64().unwrap() > 0, "{single}");
    let exact = vr.run(&format!("render {phantom} --size 4 --model single --set exact=true")).succeeded().json();
    assert_eq!(exact["own_errors"]["kind"], "bound");
    let none = vr.run(&format!("render {phantom} --model emission-absorption")).succeeded().json();
    assert_eq!(none["renderer"], "raycast");
    // Another renderer says what it lacks; so does this one without scattering.
    let refused = vr.run(&format!("render {phantom} --model full --renderer raycast"));
    assert!(refused.code == 1 && refused.stderr.contains("does not support scattering"), "{}", refused.stderr);
    let refused = vr.run(&format!("render {phantom} --renderer light"));
    assert!(refused.code == 1 && refused.stderr.contains("without scattering"), "{}", refused.stderr);
    let refused = vr.run(&format!("render {phantom} --model full --albedo 2"));
    assert!(refused.code == 2 && refused.stderr.contains("scattering.albedo"), "{}", refused.stderr);
}

#[test]
fn physics_tells_which_model_a_scene_needs() {
    let vr = Vr::new();
    vr.write("fog.toml", SCENE);
    let run = vr.run("physics --scene fog.toml").succeeded();
    for word in [
        "mean free path",
        "optical thickness",
        "albedo             up to 0.9",
        "needed             multiple scattering",
    ] {
        assert!(run.stdout.contains(word), "{word}: {}", run.stdout);
    }
    let json = vr.run("physics --phantom fog --phantom-size 9 --json").succeeded().json();
    assert_eq!(json["chosen"], "emission-absorption");
    assert_eq!(json["models"][3]["bound"], 0.0);
    let json = vr.run("physics --scene fog.toml --allowed 1000 --json").succeeded().json();
    assert_eq!(json["chosen"], "vacuum");
}

#[test]
fn scenes_with_scattering_come_back_from_files_and_records() {
    let vr = Vr::new();
    vr.write("fog.toml", SCENE);
    vr.run("scene --scene fog.toml -o whole.toml").succeeded();
    let [first, again] = ["fog.toml", "whole.toml"].map(|scene| {
        vr.run(&format!("render --scene {scene} --set paths=4 -o {scene}.png --no-record")).succeeded();
        std::fs::read(vr.folder().join(format!("{scene}.png"))).unwrap()
    });
    assert_eq!(first, again);
    vr.run("render --scene fog.toml --set paths=4 -o x.png").succeeded();
    vr.run("rerun x.png").succeeded();
}

#[test]
fn scenes_with_scattering_are_measured_and_compared_by_many_paths() {
    let vr = Vr::new();
    vr.write("fog.toml", SCENE);
    let json = vr.run("render --scene fog.toml --set paths=16 --json -o x.exr").succeeded().json();
    let number = |path: &str| json.pointer(path).and_then(|x| x.as_f64()).unwrap_or_else(|| panic!("{path}: {json}"));
    let (rmse, low, high) =
        (number("/error/noise/rmse"), number("/error/noise/interval/0"), number("/error/noise/interval/1"));
    assert!(low <= rmse && rmse <= high && rmse == number("/error/rmse"), "{json}");
    // Pictures without bias err by their noise; of 108 pixels, within a third.
    let noise = number("/error/noise/picture_noise");
    assert!((rmse / noise - 1.0).abs() < 0.33 && number("/error/noise/reference_noise") < 0.5 * noise, "{json}");
    let json =
        vr.run("compare --scene fog.toml --renderer light --renderer raycast --json -o x.png").succeeded().json();
    let rows = json["renderers"].as_array().unwrap();
    assert!(!rows.is_empty() && rows.iter().all(|row| row["error"]["noise"]["rmse"].is_number()), "{json}");
}

#[test]
fn pictures_of_the_sky_and_lights_at_a_place_light_the_medium() {
    let vr = Vr::new();
    vr.write("fog.toml", SCENE);
    // Any picture is a sky.
    vr.run("render --scene fog.toml --set paths=4 --error none -o sky.exr").succeeded();
    let render = "render --scene fog.toml --set paths=4 --error none --json";
    let run = vr.run(&format!("{render} --environment-map sky.exr --point-light 0,3,0,5,5,5 -o x.png")).succeeded();
    let notes = run.json()["notes"].to_string();
    assert!(notes.contains("12x9 pixels; an equirectangular picture"), "{notes}");
    // The record knows the picture by its name and its hash.
    let refused = vr.run("rerun x.png");
    assert!(refused.code != 0 && refused.stderr.contains("--environment-map FILE"), "{}", refused.stderr);
    vr.run("rerun x.png --environment-map sky.exr").succeeded();
    vr.run("render --scene fog.toml --set paths=5 --error none -o other.exr").succeeded();
    let other = vr.run("rerun x.png --environment-map other.exr");
    assert!(other.code != 0 && other.stderr.contains("not the environment map of the picture"), "{}", other.stderr);
    // What a scene file says of them comes back.
    vr.run("scene --scene fog.toml --environment-map sky.exr --point-light 0,3,0,5,5,5 -o lit.toml").succeeded();
    vr.run("render --scene lit.toml --set paths=4 --error none -o y.png").succeeded();
    vr.run("diff x.png y.png --fail-above 0").succeeded();
    let single = vr.run("render --scene lit.toml --model single -o z.png");
    assert!(single.code != 0 && single.stderr.contains("model=full samples them"), "{}", single.stderr);
    let none = vr.run("render --scene fog.toml --environment-map no.exr -o z.png");
    assert!(none.code != 0 && none.stderr.contains("no.exr"), "{}", none.stderr);
}

#[test]
fn physics_measures_what_simpler_models_cost() {
    let vr = Vr::new();
    vr.write("fog.toml", SCENE);
    let json = vr.run("physics --scene fog.toml --measure --json").succeeded().json();
    let of = |model: &str| {
        let models = json["models"].as_array().unwrap();
        let found = models.iter().find(|found| found["model"] == model).unwrap();
        [&found["measured"]["rms"], &found["measured"]["at_most"]].map(|x| x.as_f64().unwrap())
    };
    let (dark, once) = (of("emission-absorption"), of("single scattering"));
    assert!(0.0 < once[0] && once[0] < once[1] && once[1] < dark[0] && dark[0] < dark[1], "{json}");
    let text = vr.run("physics --scene fog.toml --measure").succeeded().stdout;
    assert!(text.contains("RMS error, measured"), "{text}");
    let plain = vr.run("physics --phantom fog --measure").succeeded();
    assert!(plain.stderr.contains("nothing scatters") && !plain.stdout.contains("measured"), "{}", plain.stderr);
}

#[test]
fn surfaces_of_flags_are_those_of_scene_files() {
    let vr = Vr::new();
    let surfaces = "[[scattering.surfaces]]\nshape = { plane = { point = [0, -1.5, 0], normal = [0, 1, 0] } }\nreflectance = [0.8, 0.8, 0.8]\n\
                    [[scattering.surfaces]]\nshape = { sphere = { centre = [0, 3, 0], radius = 0.5 } }\nemission = [20, 20, 20]\n";
    vr.write("fog.toml", SCENE);
    vr.write("lamp.toml", SCENE.replace("[image]", &format!("{surfaces}[image]")));
    vr.run("render --scene lamp.toml --set paths=8 -o a.png").succeeded();
    let flags = "--surface plane=0,-1.5,0,0,1,0:matte=0.8 --surface sphere=0,3,0,0.5:emission=20";
    vr.run(&format!("render --scene fog.toml {flags} --set paths=8 -o b.png")).succeeded();
    assert_eq!(vr.picture("a.png").into_rgba8(), vr.picture("b.png").into_rgba8());
    vr.run("render --scene fog.toml --set paths=8 -o c.png").succeeded();
    assert_ne!(vr.picture("a.png").into_rgba8(), vr.picture("c.png").into_rgba8());
    let physics = vr.run(&format!("physics --scene fog.toml {flags}")).succeeded();
    assert!(physics.stdout.contains("light of surfaces"), "{}", physics.stdout);
    let refused = vr.run("render --scene fog.toml --surface cube=1 -o x.png");
    assert!(refused.code == 2 && refused.stderr.contains("sphere=0,2,0,0.3:emission=9"), "{}", refused.stderr);
    let refused = vr.run("render --scene fog.toml --surface sphere=0,2,0,0.3:matte=2 -o x.png");
    assert!(refused.code == 2 && refused.stderr.contains("scattering.surfaces[0].reflectance"), "{}", refused.stderr);
}
