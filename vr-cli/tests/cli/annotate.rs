//! Annotations, backgrounds, and pictures in the terminal.

use image::{GenericImageView, RgbaImage};

use crate::harness::Vr;

/// Share of the pixels of a part of the picture (from and to, in parts of width and height) that differ between two pictures.
fn changed(a: &RgbaImage, b: &RgbaImage, [x0, y0, x1, y1]: [f64; 4]) -> f64 {
    let (w, h) = a.dimensions();
    let at = |part: f64, n: u32| (part * f64::from(n)) as u32;
    let (mut count, mut differ) = (0, 0);
    for y in at(y0, h)..at(y1, h) {
        for x in at(x0, w)..at(x1, w) {
            count += 1;
            differ += usize::from(a.get_pixel(x, y) != b.get_pixel(x, y));
        }
    }
    differ as f64 / f64::from(count)
}

const BLOBS: &str = "render --phantom blobs --phantom-size 16 --quiet --error none";

#[test]
fn annotations_have_places_of_their_own_and_leave_the_rest_alone() {
    let vr = Vr::new();
    for (size, background) in [("400x300", "black"), ("300x420", "white"), ("900x500", "transparent")] {
        let draw = |flags: &[&str]| {
            let base = format!("{BLOBS} --size {size} --background {background} -o x.png");
            vr.run_with(&base.split_whitespace().chain(flags.iter().copied()).collect::<Vec<_>>()).succeeded();
            vr.picture("x.png").to_rgba8()
        };
        let bare = draw(&[]);
        let places = [
            (&["--annotate", "marker"][..], [0.0, 0.6, 0.5, 1.0]),
            (&["--annotate", "scale"], [0.5, 0.8, 1.0, 1.0]),
            (&["--annotate", "legend"], [0.6, 0.1, 1.0, 0.9]),
            (&["--title", "Two blobs, Größe 3 µm"], [0.0, 0.0, 1.0, 0.15]),
        ];
        for (flags, place) in places {
            let drawn = draw(flags);
            let (all, inside) = (changed(&bare, &drawn, [0.0, 0.0, 1.0, 1.0]), changed(&bare, &drawn, place));
            assert!(inside > 0.005, "{size} {flags:?}: {inside}");
            // Nothing changes anywhere else.
            let area = (place[2] - place[0]) * (place[3] - place[1]);
            assert!((all - inside * area).abs() < 0.002, "{size} {flags:?}: {all} {inside}");
        }
    }
}

#[test]
fn a_scene_file_asks_for_annotations_and_flags_override_it() {
    let vr = Vr::new();
    let size = "--phantom blobs --phantom-size 16 --size 400x300";
    vr.run_with(
        &[
            &*format!("scene {size} --annotate marker,scale -o s.toml").split(' ').collect::<Vec<_>>(),
            &["--title", "Größe"],
        ]
        .concat(),
    )
    .succeeded();
    let text = std::fs::read_to_string(vr.folder().join("s.toml")).unwrap();
    for line in ["[annotations]", "title = \"Größe\"", "marker = true", "scale = true", "legend = false  # the default"]
    {
        assert!(text.lines().any(|l| l == line), "no {line:?} in\n{text}");
    }
    let draw = |flags: &str| {
        vr.run(&format!("render --quiet --error none {flags} -o x.png -o x.exr")).succeeded();
        vr.picture("x.png")
    };
    let bare = draw(size);
    let by_flags = {
        vr.run_with(
            &[
                &*format!("render {size} --quiet --error none --annotate marker,scale").split(' ').collect::<Vec<_>>(),
                &["--title", "Größe"],
            ]
            .concat(),
        )
        .succeeded();
        vr.picture("vr.png")
    };
    assert!(draw("--scene s.toml") == by_flags && by_flags != bare);
    // The record has the same section; the bare EXR has none.
    for (picture, has) in [("x.png", true), ("x.exr", false)] {
        let json = vr.run(&format!("info {picture} --json")).succeeded().json();
        assert_eq!(json["scene"]["annotations"]["marker"] == true, has, "{picture}: {json}");
        vr.run(&format!("rerun {picture}")).succeeded();
    }
    let title_alone = draw("--scene s.toml --annotate none");
    assert!(title_alone != by_flags && title_alone != bare);
    vr.run_with(&[
        "render",
        "--scene",
        "s.toml",
        "--error",
        "none",
        "--annotate",
        "none",
        "--title",
        "",
        "-o",
        "x.png",
    ])
    .succeeded();
    assert!(vr.picture("x.png") == bare);
    vr.write("bad.toml", text.replace("Größe", "体"));
    let refused = vr.run("render --scene bad.toml").failed(1);
    assert!(refused.contains("bad.toml: annotations.title: found '体'"), "{refused}");
    assert!(vr.run("render --annotate none,scale").failed(2).contains("none goes alone"));
}

#[test]
fn an_exr_is_data_and_so_is_the_error() {
    let vr = Vr::new();
    let error = |flags: &str| {
        let run = vr.run(&format!("render --phantom fog --phantom-size 8 --size 200 --json {flags}")).succeeded();
        run.json()["error"]["rmse"].as_f64().unwrap()
    };
    assert_eq!(error("-o bare.png -o bare.exr"), error("-o drawn.png -o drawn.exr --annotate all --title fog"));
    let read = |name: &str| std::fs::read(vr.folder().join(name)).unwrap();
    assert_ne!(read("bare.png"), read("drawn.png"));
    assert_eq!(read("bare.exr"), read("drawn.exr"));
    for flags in ["--annotate all", "--title x"] {
        let refused = vr.run(&format!("render --phantom fog -o x.exr {flags}")).failed(2);
        assert!(refused.contains("OpenEXR holds data") && refused.contains(&flags[..7]), "{refused}");
    }
}

#[test]
fn titles_that_cannot_be_written_are_refused_and_small_pictures_say_what_is_left_out() {
    let vr = Vr::new();
    let refused = |title: &str| vr.run_with(&["render", "--title", title]).failed(2);
    assert!(refused("体").contains("'体'") && refused(" ").contains("blanks"));
    let run = vr.run("render --phantom fog --phantom-size 8 --size 16 --error none --annotate all").succeeded();
    for what in ["orientation marker", "scale bar", "legend"] {
        assert!(run.stderr.contains(&format!("note: {what}: left out")), "{}", run.stderr);
    }
    assert!(vr.run("render --annotate compass").failed(2).contains("compass"));
}

#[test]
fn a_transparent_background_keeps_the_opacity() {
    let vr = Vr::new();
    vr.run(&format!("{BLOBS} --size 64 --background transparent -o a.png")).succeeded();
    vr.run(&format!("{BLOBS} --size 64 --alpha -o b.png")).succeeded();
    assert_eq!(vr.picture("a.png"), vr.picture("b.png"));
    let picture = vr.picture("a.png").to_rgba8();
    assert_eq!(picture.get_pixel(0, 0).0, [0; 4]);
    assert!(picture.pixels().any(|p| p.0[3] > 100));
    vr.run(&format!("{BLOBS} --size 64 --background #ff8000 -o c.png")).succeeded();
    assert_eq!(vr.picture("c.png").get_pixel(0, 0).0[..3], [255, 128, 0]);
    assert!(vr.run("render --background plaid").failed(2).contains("#RRGGBB"));
    for command in ["compare", "bench", "presets", "scene", "ray 1 1"] {
        let error = vr.run(&format!("{command} --size 8 --background transparent")).failed(2);
        assert!(error.contains("vr render keeps it"), "{command}: {error}");
    }
}

#[test]
fn lights_have_colours_and_go_with_a_headlight() {
    let vr = Vr::new();
    let mean = |flags: &str| {
        vr.run(&format!("{BLOBS} --transfer grey --ambient 0 --specular 0 --size 48 {flags} -o x.png")).succeeded();
        let picture = vr.picture("x.png").to_rgb8();
        [0, 1, 2].map(|c| picture.pixels().map(|p| u64::from(p.0[c])).sum::<u64>())
    };
    let red = mean("--light 1,0,0,1,0,0");
    assert!(red[0] > 0 && red[1] == 0 && red[2] == 0, "{red:?}");
    let both = mean("--light 1,0,0,1,0,0 --light 0,1,0,0,0,1");
    assert!(both[0] == red[0] && both[1] == 0 && both[2] > 0, "{both:?}");
    let with_headlight = mean("--light 1,0,0,1,0,0 --headlight=0,1,0");
    assert!(with_headlight[0] == red[0] && with_headlight[1] > 0 && with_headlight[2] == 0, "{with_headlight:?}");
    assert_eq!(mean("--headlight"), mean(""), "the only light there is");
    assert!(vr.run("render --light 1,2,3,4").failed(2).contains("three numbers or six"));
    assert!(vr.run("render --light 1,0,0,-1,0,0").failed(2).contains("shading.lights[0].color"));
}

#[test]
fn pictures_are_shown_where_there_is_no_terminal_too() {
    let vr = Vr::new();
    let show = |flags: &str| vr.run(&format!("{BLOBS} --size 160x100 {flags}")).succeeded().stdout;
    let blocks = show("--show");
    let lines: Vec<&str> = blocks.lines().collect();
    assert_eq!(lines.len(), 25);
    let signs = |line: &str| line.chars().filter(|c| "▀▄".contains(*c)).count();
    assert_eq!(signs(lines[0]), 80, "80 columns, each two of the picture's");
    assert!(show("--show=kitty").starts_with("\u{1b}_Ga=T,f=100"));
    assert!(show("--show=iterm").starts_with("\u{1b}]1337;File="));
    let sixel = show("--show=sixel");
    assert!(sixel.starts_with("\u{1b}P0;1q\"1;1;160;100") && sixel.ends_with("\u{1b}\\\n"));
    assert!(vr.run("render --show --json").failed(2).contains("stdout holds the result as JSON"));
    // The words come after the picture.
    let loud = vr.run("render --phantom fog --phantom-size 8 --size 16 --error none --show").succeeded().stdout;
    assert!(loud.contains('▀') && loud.trim_end().ends_with("vr.png"));
}
