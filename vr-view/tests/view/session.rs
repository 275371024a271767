//! Sessions: stages, their errors, and what edits do to them.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use vr_core::{Control, Model, RenderError};
use vr_io::ShadingSection;
use vr_physics::Reference;
use vr_study::error_colors;
use vr_view::session::{
    Edit, ErrorMap, Export, Output, Painter, PictureError, Quality, RayPlot, Session, Setting, Side, Stage, Step,
    TruthError,
};

use crate::common::{Watched, document, drawn_anew, frame_anew};

#[test]
fn a_picture_sharpens_until_it_is_proven() {
    let watched = Watched::of(document("hydrogen", 24, [200, 150]));
    let draft = watched.picture(Stage::Draft, 0);
    let [w, h] = draft.head.size;
    assert!(w < 200 && w > h && draft.head.full_size == [200, 150], "the first picture is coarse: {w}x{h}");
    assert_eq!(draft.head.error, PictureError::Unknown);
    let sharp = watched.picture(Stage::Sharp, 0);
    assert_eq!((sharp.head.size, sharp.rgba.len()), ([200, 150], 4 * 200 * 150));
    let measured = watched.wait(|output| match output {
        Output::Error { picture, error } if *picture == sharp.head.picture => Some(*error),
        _ => None,
    });
    let PictureError::Measured { rmse, max, pixels, of } = measured else { panic!("{measured:?}") };
    assert!(rmse > 0.0 && rmse < 2e-3 && max < 0.05 && pixels == 20 * 20 && of == 200 * 150, "{measured:?}");
    let proven = watched.picture(Stage::Proven, 0);
    let PictureError::Proven { bound, rmse: Some(rmse) } = proven.head.error else { panic!("{:?}", proven.head) };
    assert!(bound == 4e-3 && rmse < 4e-3);
    // The error of a draft can be estimated from then on.
    watched.session.apply(1, 1, &Edit::Orbit { right: 3.0, up: 1.0 }).unwrap();
    let draft = watched.picture(Stage::Draft, 1);
    let PictureError::Estimated { rmse } = draft.head.error else { panic!("{:?}", draft.head) };
    assert!(rmse > 1e-5 && rmse < 0.1, "{rmse}");
}

#[test]
fn pixels_at_rest_are_those_of_the_saved_scene() {
    let watched = Watched::of(document("blobs", 24, [96, 80]));
    let shading = ShadingSection { ambient: 0.3, specular: 0.5, ..ShadingSection::default() };
    let edits = [
        Edit::Orbit { right: 33.3, up: -12.1 },
        Edit::Zoom { factor: 1.37, at: [0.11, -0.07] },
        Edit::Projection { perspective: true },
        Edit::FieldOfView { degrees: 41.7 },
        Edit::Preset { name: "viridis".to_owned() },
        Edit::UnitDistance { length: 0.0371 },
        Edit::Shading { shading },
        Edit::Background { color: [0.1, 0.2, 0.3] },
        Edit::Crop { corners: Some([[-0.9, -0.8, -0.7], [0.71, 0.6, 0.9]]) },
        Edit::Size { size: [121, 77] },
        Edit::Roll { degrees: 17.0 },
        Edit::Quality { quality: Quality::Fine },
        Edit::Pan { right: 0.013, up: 0.1 },
        Edit::Shading { shading: ShadingSection { enabled: false, ..ShadingSection::default() } },
        Edit::Quality { quality: Quality::Proven },
        Edit::Side { side: Side::Top },
    ];
    for (number, edit) in (1..).zip(&edits) {
        watched.session.apply(1, number, edit).unwrap();
        if ![1, 7, 9, 12, 16].contains(&number) {
            continue;
        }
        // A quality that is no bound is drawn as well as the renderer does by itself.
        let is_proven = watched.session.state().render.max_error.is_some();
        let shown = watched.picture(if is_proven { Stage::Proven } else { Stage::Sharp }, number);
        let text = String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
        let (size, rgba) = drawn_anew(&text);
        assert!(size == shown.head.size && rgba == shown.rgba, "after {edit:?}:\n{text}");
        assert!(rgba.chunks(4).any(|p| p != &rgba[..4]), "it shows something");
    }
}

#[test]
fn every_edit_is_shown_and_the_newest_first() {
    let watched = Watched::of(document("fog", 16, [300, 300]));
    watched.picture(Stage::Proven, 0);
    // Far more edits than pictures; none of the pictures is older than the one before.
    for number in 1..=200 {
        watched.session.apply(1, number, &Edit::Orbit { right: 1.0, up: 0.0 }).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
    let (mut pictures, mut last) = (0, 0);
    while last < 200 {
        let picture = watched.picture(Stage::Draft, 1);
        let answer = picture.answers[&1];
        assert!(answer >= last, "an older picture came after a newer one");
        (pictures, last) = (pictures + 1, answer);
    }
    assert!((2..200).contains(&pictures), "{pictures} pictures of 200 edits");
    // After it all, the camera is where 200 degrees bring it: no edit was lost.
    let text = String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
    let shown = watched.picture(Stage::Proven, 200);
    assert!(drawn_anew(&text).1 == shown.rgba);
    let start = document("fog", 16, [300, 300]).view().camera;
    let [there, here] =
        [start.orbit(200.0, 0.0).eye, vr_io::parse_scene(&text, "x".as_ref()).unwrap().camera.unwrap().eye.unwrap()];
    assert!(there.distance(here) < 1e-9, "{there} {here}");
}

#[test]
fn an_edit_ends_the_work_that_it_makes_stale() {
    // A large picture under a bound takes seconds.
    let watched = Watched::of(document("shepp-logan", 64, [1600, 1200]));
    watched.picture(Stage::Sharp, 0);
    watched.wait(|output| matches!(output, Output::Error { .. }).then_some(()));
    std::thread::sleep(Duration::from_millis(100));
    let start = Instant::now();
    watched.session.apply(1, 1, &Edit::Orbit { right: 1.0, up: 0.0 }).unwrap();
    // The picture that was in progress never comes.
    let stage = watched.wait(|output| match output {
        Output::Picture(picture) => Some(picture.head.stage),
        _ => None,
    });
    assert!(stage == Stage::Draft && start.elapsed() < Duration::from_secs(2), "{stage:?} after {:?}", start.elapsed());
}

#[test]
fn an_hour_in_little_leaves_pictures_right() {
    let watched = Watched::of(document("shells", 16, [64, 48]));
    let mut random = 1u64;
    let mut next = |n: u64| {
        // Knuth's linear congruence: any numbers will do, as long as they are the same each time.
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) % n
    };
    let presets = ["viridis", "inferno", "grey", "cool-warm"];
    let (mut done, mut last) = (0, 0);
    for number in 1..=400 {
        let small = |n: u64| n as f64 / 50.0 - 1.0;
        let edit = match next(12) {
            0 => Edit::Preset { name: presets[next(4) as usize].to_owned() },
            1 => Edit::Undo,
            2 => Edit::Redo,
            3 => Edit::Zoom { factor: 1.0 + 0.2 * small(next(100)), at: [small(next(100)), small(next(100))] },
            4 => Edit::Fit,
            5 => Edit::Crop { corners: (next(2) == 0).then_some([[-0.5; 3], [0.1 + 0.005 * next(100) as f64; 3]]) },
            6 => Edit::Projection { perspective: next(2) == 0 },
            7 => Edit::UnitDistance { length: 0.01 + 0.01 * next(20) as f64 },
            8 => Edit::Quality { quality: [Quality::Draft, Quality::Normal, Quality::Proven][next(3) as usize] },
            9 => Edit::Renderer { name: ["raycast", "shearwarp"][next(2) as usize].to_owned() },
            _ => Edit::Orbit { right: 40.0 * small(next(100)), up: 40.0 * small(next(100)) },
        };
        // What is refused changes nothing.
        if watched.session.apply(1, number, &edit).is_ok() {
            done += 1;
        }
        if number % 80 == 0 {
            watched.session.apply(1, 1000 + number, &Edit::Side { side: Side::Front }).unwrap();
            let has_proof = watched.session.state().quality == Some(Quality::Proven);
            let shown = watched.picture(if has_proof { Stage::Proven } else { Stage::Sharp }, 1000 + number);
            let text = String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
            assert!(drawn_anew(&text).1 == shown.rgba, "after {number} edits:\n{text}");
            last = number;
        }
    }
    assert!(done > 250 && last == 400, "{done} edits were made");
}

/// Error of pixels of the saved scene, drawn anew, against a reference: independent of any error map.
fn errors_anew(watched: &Watched, reference: &Reference, pixels: &[[u32; 2]]) -> Vec<f64> {
    let text = String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
    let (loaded, frame) = frame_anew(&text);
    let control = Control::default();
    let solution = reference.solve_pixels(&loaded.scene, &loaded.view, &Model::Canonical, pixels, &control).unwrap();
    let error = |(&[x, y], pixel): (&[u32; 2], &vr_physics::Pixel)| {
        (0..4).map(|c| (f64::from(frame.pixel(x, y)[c]) - pixel.rgba[c]).abs()).fold(0.0, f64::max)
    };
    pixels.iter().zip(&solution.pixels).map(error).collect()
}

#[test]
fn an_error_map_tells_the_errors_of_the_picture_at_rest() {
    let watched = Watched::of(document("hydrogen", 24, [100, 50]));
    let mut largest = Vec::new();
    for (number, quality) in (1..).zip([Quality::Draft, Quality::Proven]) {
        watched.session.apply(1, number, &Edit::Quality { quality }).unwrap();
        let map: ErrorMap = watched.session.error_map().unwrap();
        assert_eq!((map.size, map.parts, map.pixels.len()), ([100, 50], [64, 50], 64 * 50));
        assert_eq!(map.renderer, "raycast");
        // Each error is that of its pixel, and has its colour.
        let errors = errors_anew(&watched, &Reference::default(), &map.pixels);
        for (i, (&error, told)) in errors.iter().zip(&map.errors).enumerate() {
            let told = told.expect("this reference has no noise");
            assert!((told - error).abs() < 1e-12, "{i}: {told} {error}");
            let [r, g, b] = error_colors::color(told);
            let pixel = vr_core::Frame::new([1, 1], vec![[r, g, b, 1.0]], None);
            assert_eq!(map.colors[i], vr_io::screen_rgba(&pixel, [0.0; 3])[..3], "{i}");
        }
        assert!((map.max - errors.iter().copied().fold(0.0, f64::max)).abs() < 1e-12);
        assert_eq!((map.ends, map.legend.len()), ([1e-7, 1e-1], 61));
        assert!(map.legend.windows(2).all(|two| two[0] != two[1]), "the legend tells errors apart");
        largest.push(map.max);
    }
    let [draft, proven] = largest[..] else { unreachable!() };
    assert!(proven <= 4e-3 && draft > proven && proven > 0.0, "{draft} {proven}");
}

#[test]
fn an_error_map_that_an_edit_makes_stale_is_cancelled() {
    let watched = Watched::of(document("hydrogen", 24, [600, 600]));
    let whole = Instant::now();
    watched.session.error_map().unwrap();
    let whole = whole.elapsed();
    std::thread::scope(|scope| {
        let start = Instant::now();
        let asked = scope.spawn(|| watched.session.error_map());
        // Edits until one has come after the question.
        for number in 1.. {
            std::thread::sleep(Duration::from_millis(5));
            watched.session.apply(1, number, &Edit::Orbit { right: 1.0, up: 0.0 }).unwrap();
            if asked.is_finished() {
                break;
            }
        }
        let outcome = asked.join().unwrap();
        assert!(matches!(outcome, Err(TruthError::Render(RenderError::Cancelled))), "{:?}", outcome.map(|m| m.max));
        assert!(start.elapsed() < whole, "{:?} of {whole:?}", start.elapsed());
    });
    // The next question is answered, and none after the end.
    watched.session.apply(1, 9_999, &Edit::Size { size: [20, 20] }).unwrap();
    assert_eq!(watched.session.error_map().unwrap().size, [20, 20]);
    watched.session.end();
    assert!(matches!(watched.session.error_map(), Err(TruthError::Render(RenderError::Cancelled))));
}

#[test]
fn a_ray_tells_of_its_pixel_and_of_the_reference() {
    let watched = Watched::of(document("hydrogen", 24, [60, 50]));
    let pixel @ [x, y] = [31, 22];
    for (number, quality) in (1..).zip([Quality::Draft, Quality::Proven]) {
        watched.session.apply(1, number, &Edit::Quality { quality }).unwrap();
        let plot: RayPlot = watched.session.ray(pixel).unwrap();
        let text = String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
        let (loaded, frame) = frame_anew(&text);
        let rgba = frame.pixel(x, y);
        let control = Control::default();
        let solution =
            Reference::default().solve_pixels(&loaded.scene, &loaded.view, &Model::Canonical, &[pixel], &control);
        let exact = solution.unwrap().pixels[0];
        assert_eq!((plot.pixel, plot.size, plot.exact), (pixel, [60, 50], exact.rgba));
        assert!(plot.is_proven && plot.bound == exact.certainty.value() && exact.rgba[3] > 0.1, "{plot:?}");
        for c in 0..4 {
            // Steps are listed by a plain kernel, the same to rounding.
            assert!((plot.rgba[c] - f64::from(rgba[c])).abs() < 1e-5, "{c}: {plot:?} {rgba:?}");
            assert_eq!(plot.error[c], plot.rgba[c] - exact.rgba[c]);
        }
        let shown = vr_io::screen_rgba(&frame, loaded.scene.background);
        let shown = &shown[4 * (60 * y + x) as usize..];
        assert!(plot.screen[0].iter().zip(shown).all(|(a, b)| a.abs_diff(*b) <= 1), "{:?}", plot.screen);
        // Curves run up to the pixel: the reference's to the reference, the renderer's, where it lists steps, to its own.
        let last = plot.parts.last().unwrap();
        let transmittance: f64 = plot.parts.iter().map(|part| 1.0 - part.opacity).product();
        assert!((1.0 - transmittance - exact.rgba[3]).abs() < 2e-4, "{transmittance}");
        assert_eq!(plot.steps.is_some(), quality == Quality::Draft);
        for c in 0..4 {
            assert!((last.exact[c] - exact.rgba[c]).abs() < 2e-4, "{c}");
            if let Some(drawn) = last.drawn {
                assert!((drawn[c] - plot.rgba[c]).abs() < 2e-4, "{c}");
            }
        }
        assert!(plot.parts.iter().all(|part| part.drawn.is_some() == plot.steps.is_some()));
        assert!(plot.parts.windows(2).all(|two| two[0].ends[1] == two[1].ends[0]));
        // Opacity is that of the transfer function at the value: κ lies between those at both ends of a part whose value hardly changes.
        let (mut thin, mut seen) = (0, 0);
        for part in plot.parts.iter().filter(|part| part.values.is_some_and(|[low, high]| high - low < 2e-3)) {
            let [low, high] = part.values.unwrap().map(|value| loaded.scene.transfer.extinction_at(value));
            let kappa = -(-part.opacity).ln_1p() / (part.ends[1] - part.ends[0]);
            let slack = 1e-6 + 0.02 * (low + high);
            thin += usize::from((low.min(high) - slack..=low.max(high) + slack).contains(&kappa));
            seen += 1;
        }
        assert!(seen > 20 && thin == seen, "{thin} of {seen}");
    }
    // Other questions are refused, or cancelled.
    assert!(watched.session.ray([60, 0]).unwrap_err().to_string().contains("pixel"));
    watched.session.end();
    assert!(matches!(watched.session.ray(pixel), Err(TruthError::Render(RenderError::Cancelled))));
}

#[test]
fn a_second_picture_is_that_of_a_session_with_its_setting() {
    let settings =
        [("raycast", Some(Quality::Draft)), ("raycast", Some(Quality::Proven)), ("raycast", None), ("shearwarp", None)];
    let watched = Watched::of(document("hydrogen", 24, [100, 60]));
    watched.session.apply(1, 1, &Edit::Orbit { right: 20.0, up: 5.0 }).unwrap();
    let saved = |watched: &Watched| String::from_utf8(watched.session.export(Export::Scene).unwrap()).unwrap();
    let before = saved(&watched);
    for (renderer, quality) in settings {
        let setting = Setting { renderer: renderer.to_owned(), quality };
        let second = watched.session.second(&setting).unwrap();
        assert_eq!((second.renderer, second.size), (renderer, [100, 60]));
        // A session of its own is given the same setting by edits, and its scene drawn anew.
        let other = Watched::of(document("hydrogen", 24, [100, 60]));
        other.session.apply(1, 1, &Edit::Orbit { right: 20.0, up: 5.0 }).unwrap();
        if renderer != "raycast" {
            other.session.apply(1, 2, &Edit::Renderer { name: renderer.to_owned() }).unwrap();
        }
        if let Some(quality) = quality {
            other.session.apply(1, 3, &Edit::Quality { quality }).unwrap();
        }
        assert!(drawn_anew(&saved(&other)).1 == second.rgba, "{setting:?}");
        // Its error is measured on as many pixels as that of the first picture, by a reference within 10⁻⁶, or proven.
        let is_proven = renderer == "raycast" && quality != Some(Quality::Draft);
        let errors = errors_anew(&other, &Reference::new(1e-6), &vr_physics::metrics::subgrid(20, [100, 60]));
        let largest = errors.iter().copied().fold(0.0, f64::max);
        match second.error {
            PictureError::Proven { bound, rmse: Some(rmse) } if is_proven => {
                assert!(bound == 4e-3 && largest <= bound && rmse <= largest, "{largest} {rmse}");
            }
            PictureError::Measured { max, pixels: 400, of: 6000, rmse } if !is_proven => {
                assert!((max - largest).abs() < 1e-12 && rmse < max && max > 0.0, "{max} {largest}");
            }
            ref error => panic!("{setting:?}: {error:?}"),
        }
    }
    assert_eq!(saved(&watched), before, "the first setting stays as it was");
    // Settings that there are not are refused in words.
    let refused = |renderer: &str, quality| {
        watched.session.second(&Setting { renderer: renderer.to_owned(), quality }).unwrap_err().to_string()
    };
    assert!(refused("oil", None).contains("oil"));
    assert!(refused("shearwarp", Some(Quality::Proven)).contains("shearwarp cannot prove"));
    watched.session.end();
    let setting = Setting { renderer: "raycast".to_owned(), quality: None };
    assert!(matches!(watched.session.second(&setting), Err(TruthError::Render(RenderError::Cancelled))));
}

#[test]
fn without_a_thread_it_is_drawn_step_by_step_and_given_up_for_an_edit() {
    // The pixels are those of a session with a thread: of the saved scene.
    let told = Arc::new(Mutex::new(Vec::new()));
    let (asked, is_waiting) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let (telling, asking, waiting) = (Arc::clone(&told), Arc::clone(&asked), Arc::clone(&is_waiting));
    let interrupted = move || {
        asking.fetch_add(1, Ordering::Relaxed);
        waiting.load(Ordering::Relaxed)
    };
    let document = document("blobs", 24, [160, 120]);
    let (session, mut painter) =
        Session::without_thread(document, interrupted, move |output| telling.lock().unwrap().push(output));
    let rest = |painter: &mut Painter| {
        loop {
            match painter.step() {
                Step::Worked => {}
                Step::Wait(time) => std::thread::sleep(time),
                Step::Idle => break,
            }
        }
    };
    let stages = || -> Vec<Stage> {
        let told = told.lock().unwrap();
        told.iter().filter_map(|o| if let Output::Picture(p) = o { Some(p.head.stage) } else { None }).collect()
    };
    rest(&mut painter);
    assert_eq!((stages().first(), stages().last()), (Some(&Stage::Draft), Some(&Stage::Proven)));
    assert!(asked.load(Ordering::Relaxed) > 0, "it asks while it draws");
    let proven = |told: &[Output]| {
        told.iter().rev().find_map(|o| if let Output::Picture(p) = o { Some(p.rgba.clone()) } else { None }).unwrap()
    };
    let file = String::from_utf8(session.export(Export::Scene).unwrap()).unwrap();
    assert!(proven(&told.lock().unwrap()) == drawn_anew(&file).1);
    // While an edit waits, drafts alone are drawn, and an answer is given up; afterwards, all of it is made.
    told.lock().unwrap().clear();
    session.apply(1, 1, &Edit::Orbit { right: 30.0, up: 10.0 }).unwrap();
    is_waiting.store(true, Ordering::Relaxed);
    let start = Instant::now();
    while start.elapsed() < Duration::from_millis(300) {
        let step = painter.step();
        assert_ne!(step, Step::Idle);
    }
    assert!(stages().iter().all(|stage| *stage < Stage::Sharp), "{:?}", stages());
    let map = session.error_map();
    assert!(matches!(map, Err(TruthError::Render(RenderError::Cancelled))), "{:?}", map.err());
    is_waiting.store(false, Ordering::Relaxed);
    rest(&mut painter);
    assert_eq!(stages().last(), Some(&Stage::Proven));
    let file = String::from_utf8(session.export(Export::Scene).unwrap()).unwrap();
    assert!(proven(&told.lock().unwrap()) == drawn_anew(&file).1);
    assert!(!told.lock().unwrap().iter().any(|o| matches!(o, Output::Problem(_))));
}
