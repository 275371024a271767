//! Brute force: many samples of a field's values along a ray, no polynomials; and the scene that volumes over the unit cube are put into.

use glam::DVec3;
use vr_core::{
    Camera, Clip, Compositing, Control, ControlPoint, Model, OpacityRule, Ray, Rays, Scene, TransferFunction, View,
};
use vr_physics::{Pixel, Reference};

/// Every compositing operator.
pub const OPERATORS: [Compositing; 6] = [
    Compositing::Over,
    Compositing::Maximum,
    Compositing::Minimum,
    Compositing::Average,
    Compositing::First { threshold: 0.55 },
    Compositing::Accumulate { level: 0.5 },
];

/// A function over the unit cube, from 0 to 1.
pub fn waves(p: DVec3) -> f64 {
    0.5 + 0.3 * (7.0 * p.x + 3.0 * p.y).sin() + 0.2 * (9.0 * p.z - 4.0 * p.y).cos()
}

/// A transfer function with kinks, without jumps, for a unit distance.
pub fn transfer(unit_distance: f64) -> TransferFunction {
    let p = ControlPoint::new;
    let points = vec![
        p(0.1, [0.1, 0.2, 0.9], 0.0),
        p(0.45, [0.9, 0.3, 0.1], 0.25),
        p(0.6, [0.2, 0.8, 0.3], 0.05),
        p(1.0, [1.0, 1.0, 0.9], 0.6),
    ];
    TransferFunction::new(points, OpacityRule::Power, unit_distance).unwrap()
}

/// A view of the unit cube.
pub fn view(size: u32) -> View {
    View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), 35.0, 25.0, Some(40.0)), [size; 2])
}

/// Pixels of the reference.
pub fn solved(scene: &Scene, view: &View) -> Vec<Pixel> {
    Reference::default().solve(scene, view, &Model::Canonical, &Control::default()).unwrap().pixels
}

/// Asserts that two scenes have the same pixels under every operator, up to the bounds of both and `slack`; and that those of the first are certain to `certainty`.
pub fn same_under_every_operator([a, b]: [&Scene; 2], size: u32, slack: f64, certainty: f64) {
    for compositing in OPERATORS {
        let [a, b] = [a, b].map(|scene| solved(&Scene { compositing, ..scene.clone() }, &view(size)));
        for (a, b) in a.iter().zip(&b) {
            let bound = a.certainty.value() + b.certainty.value();
            let off = difference(&a.rgba, &b.rgba);
            assert!(off <= bound + slack, "{compositing:?}: {off} beyond {bound}");
            assert!(a.certainty.value() < certainty, "{compositing:?}: {:?}", a.certainty);
        }
    }
}

/// Asserts that a small picture is what brute force makes of it; and that each pixel is certain to `certainty`.
pub fn agrees_with_brute_force(scene: &Scene, certainty: f64) {
    const SIDE: u32 = 6;
    let view = view(SIDE);
    let rays = Rays::new(&view).unwrap();
    let name = format!("{:?}, {:?}", scene.compositing, scene.shading);
    for (i, pixel) in (0..).zip(&solved(scene, &view)) {
        let expected = brute(scene, &rays.at(f64::from(i % SIDE) + 0.5, f64::from(i / SIDE) + 0.5));
        let off = difference(&pixel.rgba, &expected);
        // Midpoint samples are 1/4000 of the chord apart; those that pick a place are off by as much of the slope.
        assert!(off <= pixel.certainty.value() + 2e-3, "{name}: {off} at {i}");
        assert!(pixel.certainty.value() < certainty, "{name}: {:?}", pixel.certainty);
    }
}

/// Largest difference of two pixels.
pub fn difference(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, |worst, off| if off.is_nan() || off > worst { off } else { worst })
}

/// The same scene by many samples along a ray.
pub fn brute(scene: &Scene, ray: &Ray) -> [f64; 4] {
    const SAMPLES: usize = 4000;
    let field = scene.volume.field().expect("no uniform grid");
    let inside = Clip { crop: Some(field.bounds()), ..Clip::default() };
    let Some([from, to]) = ray.inside(&inside).filter(|[a, b]| a < b) else { return [0.0; 4] };
    let h = (to - from) / SAMPLES as f64;
    let places = (0..SAMPLES).map(|k| ray.origin + ray.direction * (from + (k as f64 + 0.5) * h));
    let along = scene.shading.as_ref().map(|s| s.along::<f64>(&scene.lights, ray.direction));
    let samples: Vec<(DVec3, f64)> = places.filter_map(|at| Some((at, field.value(at)?))).collect();
    let picked = |v: f64| {
        let o = scene.transfer.at(v);
        [o.color[0] * o.opacity, o.color[1] * o.opacity, o.color[2] * o.opacity, o.opacity]
    };
    let values = samples.iter().map(|s| s.1);
    match scene.compositing {
        Compositing::Maximum => return picked(values.fold(f64::NEG_INFINITY, f64::max)),
        Compositing::Minimum => return picked(values.fold(f64::INFINITY, f64::min)),
        Compositing::Average => return picked(values.sum::<f64>() / samples.len() as f64),
        Compositing::First { threshold } => {
            let hit = samples.iter().find(|s| s.1 >= threshold);
            return hit.map_or([0.0; 4], |s| {
                let [r, g, b] = scene.transfer.at(s.1).color;
                [r, g, b, 1.0]
            });
        }
        _ => {}
    }
    let level = if let Compositing::Accumulate { level } = scene.compositing { level } else { 1.0 };
    let (mut rgb, mut alpha) = ([0.0; 3], 0.0);
    for (at, value) in samples {
        let mut color = scene.transfer.at(value).color;
        if let Some(along) = &along {
            let (factor, added) = along.reflect(field.gradient(at).unwrap().to_array());
            color = std::array::from_fn(|c| color[c] * factor[c] + added[c]);
        }
        let step: f64 = 1.0 - (-scene.transfer.extinction_at(value) * h).exp();
        let step = step.min((level - alpha) / (1.0 - alpha));
        for c in 0..3 {
            rgb[c] += (1.0 - alpha) * step * color[c];
        }
        alpha += (1.0 - alpha) * step;
    }
    [rgb[0], rgb[1], rgb[2], alpha]
}
