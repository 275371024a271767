//! Options that would have no effect are refused, or a note says so.

use crate::harness::Vr;

#[test]
fn options_without_effect_are_refused() {
    let vr = Vr::new();
    let render = "render --phantom fog --phantom-size 4 --size 4 --error none";
    for (flags, words) in [
        ("-o p.exr --bits 16", &["--bits", "PNG"][..]),
        ("-o p.exr --encode none", &["--encode", "PNG"]),
        ("-o p.exr --alpha", &["--alpha", "PNG"]),
        ("--max-error 0.01 --set max-error=0.1", &["--max-error", "--set max-error"]),
        ("--renderer physics --max-error 0.01 --set tolerance=0.001", &["--max-error", "--set tolerance"]),
        ("--projection perspective --height 3", &["camera.height", "fov"]),
        ("--projection orthographic --fov 3", &["camera.fov", "height"]),
        ("--point 0,0,0,0,0 --point 1,1,1,1,0.5 --range 0,1", &["transfer.range", "points"]),
    ] {
        let error = vr.run(&format!("{render} {flags}")).failed(2);
        assert!(words.iter().all(|word| error.contains(word)), "{flags}: {error}");
        assert!(vr.files().is_empty(), "{flags}");
    }
    vr.run(&format!("{render} -o p.exr -o p.png --bits 16 --alpha")).succeeded();
}

#[test]
fn a_flag_overrides_the_error_bound_of_a_scene_file() {
    let vr = Vr::new();
    let scene = "[volume]\nphantom = \"fog\"\nsize = 4\n[image]\nsize = [4, 4]\n[render]\nmax_error = 0.01\n";
    vr.write("scene.toml", scene);
    let bound = |flags: &str| {
        let run = vr.run(&format!("render --scene scene.toml --error none -o p.png --json {flags}")).succeeded();
        run.json()["promise"]["max_error"].as_f64()
    };
    assert_eq!(bound(""), Some(0.01));
    assert_eq!(bound("--max-error 0.1"), Some(0.1));
    assert_eq!(bound("--set max-error=0.2"), Some(0.2));
    // Two bounds in one file.
    vr.write("scene.toml", format!("{scene}max-error = 0.2\n"));
    let error = vr.run("render --scene scene.toml --error none").failed(1);
    assert!(error.contains("render.max_error") && error.contains("render.max-error"), "{error}");
}

#[test]
fn what_commands_do_not_use_is_said() {
    let vr = Vr::new();
    let scene = "[volume]\nphantom = \"fog\"\nsize = 4\n[image]\nsize = [4, 4]\nsamples = 2\n[render]\nrenderer = \"raycast\"\nstep = 2.0\n";
    vr.write("scene.toml", scene);
    for (command, words) in [
        (
            "render --scene scene.toml --error none --target-rmse 0.01 --no-cache",
            &["render.renderer, render.step", "--target-rmse"][..],
        ),
        ("compare --scene scene.toml --renderer texslice", &["render.renderer, render.step", "compared"]),
        (
            "render --scene scene.toml --error none --renderer texslice",
            &["options of the scene file", "raycast", "texslice"],
        ),
        ("ray 1 1 --scene scene.toml", &["samples", "centre"]),
        (
            "render --phantom fog --phantom-size 4 --size 4 --error none --colors srgb",
            &["transfer.colors", "no effect"],
        ),
    ] {
        let run = vr.run(command).succeeded();
        let notes: Vec<&str> = run.stderr.lines().filter(|line| line.starts_with("note: ")).collect();
        assert!(notes.iter().any(|note| words.iter().all(|word| note.contains(word))), "{command}: {notes:?}");
    }
}
