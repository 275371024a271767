//! A volume that turns keeps its brightness and does not jump where the principal axis changes.

use vr_core::phantom::{self, Phantom};
use vr_core::{Camera, Control, Frame, Model, Prepared, Renderer, Scene, View};
use vr_physics::Reference;
use vr_physics::metrics::{outline_mask, subgrid};
use vr_shearwarp::ShearWarp;

const PIXELS: u32 = 112;
const SAMPLES: usize = 32;

/// A phantom that light passes through: a twentieth of its opacities.
fn translucent(name: &str) -> Scene {
    let phantom: Box<dyn Phantom> = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, SAMPLES, 0.05).expect("a valid size")
}

fn view(scene: &Scene, azimuth: f64) -> View {
    View::new(Camera::framing(scene.volume.bounds(), azimuth, 0.0, None), [PIXELS; 2])
}

fn prepare(renderer: &ShearWarp, scene: &Scene) -> Box<dyn Prepared> {
    renderer.prepare(scene, &Control::default()).expect("a scene that it can draw")
}

fn draw(prepared: &mut dyn Prepared, view: &View) -> Frame {
    prepared.render(view, &Control::default()).expect("a view that it can draw").frame
}

/// The mean error of brightness as a part of the mean brightness, at some pixels of a frame, against a model.
fn bias(frame: &Frame, scene: &Scene, view: &View, model: &Model) -> f64 {
    // The outline is a texel wide, and soft; fog ends there at once.
    let outline = outline_mask(&scene.volume, view).expect("a valid view");
    let mut chosen = subgrid(48, view.size);
    chosen.retain(|&[x, y]| !outline[(y * view.size[0] + x) as usize]);
    let solution = Reference::new(1e-4).solve_pixels(scene, view, model, &chosen, &Control::default());
    let want = solution.expect("a view that it can solve").pixels;
    let got = chosen.iter().map(|&[x, y]| frame.pixel(x, y).map(f64::from));
    let light = |p: [f64; 4]| p[0] + p[1] + p[2];
    got.map(light).sum::<f64>() / want.iter().map(|p| light(p.rgba)).sum::<f64>() - 1.0
}

/// Angles of a whole turn; the principal axis changes at 45°, 135°, ….
fn angles() -> impl Iterator<Item = f64> {
    (0..24).map(|k| 15.0 * f64::from(k))
}

/// The error of brightness at every angle against the renderer's own model.
fn keeps_its_brightness(name: &str, renderer: &ShearWarp) {
    let scene = translucent(name);
    let mut prepared = prepare(renderer, &scene);
    for azimuth in angles() {
        let view = view(&scene, azimuth);
        let frame = draw(&mut *prepared, &view);
        let off = bias(&frame, &scene, &view, &prepared.model(&view).unwrap());
        assert!(off.abs() < 0.005, "{name} at {azimuth}°: off by {off}");
    }
}

#[test]
fn brightness_is_what_the_model_says_from_everywhere() {
    // At most 0.0017 and 0.0022. Light, not values, is interpolated between texels, and the model knows of no texels: with one to a voxel
    // that alone is 0.024 of a hydrogen atom of 32³ samples. Fog changes slowly.
    let default = ShearWarp::default();
    keeps_its_brightness("fog", &default);
    keeps_its_brightness("hydrogen", &ShearWarp { texel: 0.25, slice_distance: 2.0, ..default });
}

#[test]
fn brightness_of_the_classic_is_what_the_model_says_from_everywhere() {
    // At most 0.0004 was measured.
    keeps_its_brightness("fog", &ShearWarp::classic());
}

#[test]
fn without_correction_brightness_depends_on_the_angle() {
    for name in ["fog", "hydrogen"] {
        let scene = translucent(name);
        let corrected = prepare(&ShearWarp::default(), &scene);
        let mut prepared = prepare(&ShearWarp { correction: false, ..ShearWarp::default() }, &scene);
        // Its own model leaves the correction out, too: that of a corrected renderer shows what is missing.
        let biases = angles().map(|azimuth| {
            let view = view(&scene, azimuth);
            bias(&draw(&mut *prepared, &view), &scene, &view, &corrected.model(&view).unwrap())
        });
        let darkest = biases.fold(0.0, f64::min);
        // At 45° slices are √2 times as far apart as they are taken to be: 1 − 1/√2 of thin light is missing. Measured: 0.28 and 0.26.
        assert!((-0.3..-0.2).contains(&darkest), "{name}: {darkest}");
    }
}

#[test]
fn pictures_do_not_jump_where_the_axis_changes() {
    for name in ["fog", "hydrogen"] {
        let scene = translucent(name);
        let mut prepared = prepare(&ShearWarp::default(), &scene);
        // Steps of 1°; in that from 44.5° to 45.5° the axis changes.
        let frames: Vec<Frame> = (0..21).map(|k| draw(&mut *prepared, &view(&scene, 34.5 + f64::from(k)))).collect();
        let mut changes: Vec<f64> = frames.windows(2).map(|pair| change(&pair[0], &pair[1])).collect();
        let there = changes.remove(10);
        let elsewhere = changes.into_iter().fold(0.0, f64::max);
        // Measured: 0.95 and 0.79 of the largest change elsewhere.
        assert!(there <= 1.2 * elsewhere, "{name}: {there}, elsewhere {elsewhere}");
    }
}

/// Root of the mean square of the difference of two frames.
fn change(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    let square: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (square / (4 * a.pixels().len()) as f64).sqrt()
}
