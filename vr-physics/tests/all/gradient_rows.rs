//! Two-dimensional transfer functions against what can be integrated on paper.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Camera, ControlPoint, GradientMethod, OpacityRule, Placement, Projection, Ray, Scene, Shading, TransferFunction,
    UniformGrid, View, Volume,
};
use vr_physics::{Certainty, Reference, Transport};

type Rows = Vec<(f64, Vec<ControlPoint>)>;

/// A field that depends on z alone, by its samples at a distance of 1.
fn along_z(values: &[f32]) -> Volume {
    let samples: Vec<f32> = values.iter().flat_map(|&v| [v; 4]).collect();
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    UniformGrid::new([2, 2, values.len()], samples, placement, Default::default()).unwrap().into()
}

fn point(value: f64, opacity: f64, color: [f64; 3]) -> ControlPoint {
    ControlPoint::new(value, color, opacity)
}

fn emitting(opacity: f64, emission: f64) -> Vec<ControlPoint> {
    vec![ControlPoint { emission: Some([emission; 3]), ..point(0.0, opacity, [0.0; 3]) }]
}

fn transport(scene: &Scene) -> Transport {
    let camera = Camera {
        eye: DVec3::new(0.3, 0.6, -5.0),
        target: DVec3::new(0.3, 0.6, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 1.0 },
    };
    let ray = Ray { origin: camera.eye, direction: DVec3::Z };
    Reference::default().transport(scene, &View::new(camera, [1, 1]), &ray).unwrap().expect("the ray meets the volume")
}

fn by_rows(values: &[f32], rows: Rows, rule: OpacityRule) -> Transport {
    transport(&Scene::new(along_z(values), TransferFunction::of_rows(rows, rule, 1.0).unwrap()))
}

fn check(name: &str, t: &Transport, radiance: f64, depth: f64) {
    let Certainty::Bound(bound) = t.certainty else { panic!("{name}: {:?} is no bound", t.certainty) };
    let scale = radiance.abs().max(1.0);
    assert!(bound <= 1e-9 * scale, "{name}: bound {bound:e}");
    let error = (t.radiance[0] - radiance).abs().max((t.opacity() - -(-depth).exp_m1()).abs());
    assert!(error <= bound + 2e-16 * scale, "{name}: error {error:e}, bound {bound:e}");
}

/// Samples of a ramp of a slope.
fn ramp(slope: f32) -> Vec<f32> {
    (0..9).map(|z| slope * z as f32).collect()
}

#[test]
fn on_a_ramp_it_is_the_mixture_at_the_slope() {
    // κ of the rows is 0.2 and 0.9, their colours 1 and ¼: at a slope in the middle, κ = 0.55 and q = ½ (0.2 + 0.225).
    let rows = |low, high| vec![(low, vec![point(0.0, 0.2, [1.0; 3])]), (high, vec![point(0.0, 0.9, [0.25; 3])])];
    for (low, high, kappa, q) in [
        (1.0, 2.0, 0.55, 0.2125),
        (0.0, 1.5, 0.9, 0.225),
        (1.5, 2.0, 0.2, 0.2),
        (0.0, 1.0, 0.9, 0.225),
        (2.0, 3.0, 0.2, 0.2),
        (0.0, 3.0, 0.55, 0.2125),
    ] {
        let t = by_rows(&ramp(1.5), rows(low, high), OpacityRule::Extinction);
        let depth = kappa * 8.0;
        check(&format!("rows at {low} and {high}"), &t, q / kappa * -f64::exp_m1(-depth), depth);
    }
}

#[test]
fn on_a_ramp_rows_that_rise_with_the_value_are_one_function() {
    // Mixed half and half, two lines are the line of the mean opacities, under the rule of extinctions.
    let line = |a: f64, b: f64| vec![point(0.0, a, [0.5; 3]), point(12.0, b, [0.5; 3])];
    let rows = vec![(1.0, line(0.0, 0.8)), (2.0, line(0.4, 1.0))];
    let t = by_rows(&ramp(1.5), rows, OpacityRule::Extinction);
    let one = TransferFunction::new(line(0.2, 0.9), OpacityRule::Extinction, 1.0).unwrap();
    let one = transport(&Scene::new(along_z(&ramp(1.5)), one));
    let allowed = t.certainty.value() + one.certainty.value();
    assert!(allowed < 1e-9 && (t.radiance[0] - one.radiance[0]).abs() <= allowed);
    assert!((t.opacity() - one.opacity()).abs() <= allowed);
    // κ goes linearly from 0.2 to 0.9 along the ray.
    check("rising rows", &t, 0.5 * -f64::exp_m1(-0.55 * 8.0), 0.55 * 8.0);
}

#[test]
fn a_slope_that_changes_is_followed() {
    // Central differences 0, 1, 3, 3 at the voxels, linear between: κ = |∇f|/5 is too. (The last is one-sided.)
    let values = [0.0f32, 0.0, 2.0, 6.0, 9.0];
    let gradients = [0.0, 1.0, 3.0, 3.5, 3.0];
    let rows = vec![(0.0, vec![point(0.0, 0.0, [0.0; 3])]), (5.0, vec![point(0.0, 1.0, [0.7; 3])])];
    let depth: f64 = gradients.windows(2).map(|w| 0.5 * (w[0] + w[1]) / 5.0).sum();
    let t = by_rows(&values, rows, OpacityRule::Extinction);
    // The clear row has no colour: the light is that of the other alone.
    check("κ by the slope", &t, 0.7 * -f64::exp_m1(-depth), depth);
    // A kink at a magnitude that is met between voxels: κ = 0.1 up to 2, then 0.1 + 0.3 (|∇f| − 2).
    let rows = vec![(2.0, vec![point(0.0, 0.1, [0.7; 3])]), (4.0, vec![point(0.0, 0.7, [0.7; 3])])];
    let kappa = |g: f64| 0.1 + 0.3 * (g - 2.0).max(0.0);
    // Linear on [0, 1], [1, 1.5], [1.5, 2], [2, 3], [3, 4].
    let ends = [(0.0, 0.0), (1.0, 1.0), (1.5, 2.0), (2.0, 3.0), (3.0, 3.5), (4.0, 3.0)];
    let depth: f64 = ends.windows(2).map(|w| 0.5 * (w[1].0 - w[0].0) * (kappa(w[0].1) + kappa(w[1].1))).sum();
    let t = by_rows(&values, rows, OpacityRule::Extinction);
    check("a row's own magnitude", &t, 0.7 * -f64::exp_m1(-depth), depth);
}

#[test]
fn emission_is_mixed_too() {
    // q = |∇f| and κ = ½ everywhere: piece by piece (a + m s) e^(−s/2).
    let gradients = [0.0, 1.0, 3.0, 3.5, 3.0];
    let rows = vec![(0.0, emitting(0.5, 0.0)), (5.0, emitting(0.5, 5.0))];
    let t = by_rows(&[0.0, 0.0, 2.0, 6.0, 9.0], rows, OpacityRule::Extinction);
    let k = 0.5;
    let mut light = 0.0;
    for (i, w) in gradients.windows(2).enumerate() {
        // ∫₀¹ (a + m s) e^(−ks) ds
        let (a, m, e) = (w[0], w[1] - w[0], f64::exp(-k));
        light += f64::exp(-k * i as f64) * (a * (1.0 - e) / k + m * (1.0 - e * (1.0 + k)) / (k * k));
    }
    check("emission by the slope", &t, light, 2.0);
    // Light without absorption.
    let rows = vec![(0.0, emitting(0.0, 0.0)), (5.0, emitting(0.0, 5.0))];
    let t = by_rows(&[0.0, 0.0, 2.0, 6.0, 9.0], rows, OpacityRule::Power);
    let light: f64 = gradients.windows(2).map(|w| 0.5 * (w[0] + w[1])).sum();
    check("pure emission", &t, light, 0.0);
}

#[test]
fn rows_that_are_all_the_same_are_the_function_by_value() {
    let values: Vec<f32> = (0..17).map(|z| (0.9 * z as f32).sin()).collect();
    let points = vec![
        point(-1.0, 0.0, [0.2, 1.0, 0.4]),
        point(0.1, 0.3, [0.9, 0.1, 0.4]),
        point(0.1, 0.95, [0.3, 0.1, 0.9]),
        point(0.8, 0.2, [1.0; 3]),
    ];
    for rule in [OpacityRule::Power, OpacityRule::Extinction] {
        let one = Scene::new(along_z(&values), TransferFunction::new(points.clone(), rule, 1.0).unwrap());
        let shading = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
        for shading in [None, Some(Arc::new(shading))] {
            let one = Scene { shading: shading.clone(), ..one.clone() };
            let expected = transport(&one);
            for magnitudes in [vec![0.0], vec![0.3, 0.6], vec![0.0, 0.2, 0.5, 3.0]] {
                let rows: Rows = magnitudes.iter().map(|&m| (m, points.clone())).collect();
                let transfer = Arc::new(TransferFunction::of_rows(rows, rule, 1.0).unwrap());
                let t = transport(&Scene { transfer, ..one.clone() });
                let allowed = t.certainty.value() + expected.certainty.value();
                let apart = (0..3).map(|c| (t.radiance[c] - expected.radiance[c]).abs()).fold(0.0, f64::max);
                assert!(allowed < 1e-8 && apart <= allowed, "{rule:?} {magnitudes:?}: {apart:e}, {allowed:e}");
                assert!((t.opacity() - expected.opacity()).abs() <= allowed);
            }
        }
    }
}

#[test]
fn operators_that_pick_a_value_are_refused() {
    use vr_core::Compositing;
    let rows = vec![(0.0, vec![point(0.0, 0.2, [1.0; 3])])];
    let transfer = TransferFunction::of_rows(rows, OpacityRule::Power, 1.0).unwrap();
    let mut scene = Scene::new(along_z(&ramp(1.0)), transfer);
    for compositing in
        [Compositing::Maximum, Compositing::Minimum, Compositing::Average, Compositing::First { threshold: 0.5 }]
    {
        scene.compositing = compositing;
        assert_eq!(scene.validate().unwrap_err().field, "render.compositing");
    }
    scene.compositing = Compositing::Accumulate { level: 0.5 };
    scene.validate().unwrap();
    scene.shading = Some(Arc::new(Shading { gradient_opacity: vec![(0.0, 0.5)], ..Shading::default() }));
    assert_eq!(scene.validate().unwrap_err().field, "shading.gradient_opacity");
}
