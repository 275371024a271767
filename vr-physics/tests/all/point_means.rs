//! The reference on weighted means of scattered points, of values and of colours: bounds along rays, brute force, and closed forms.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use vr_core::field::{FieldLine, PointLine};
use vr_core::{
    Camera, Clip, Compositing, Control, ControlPoint, Light, Model, OpacityRule, PointKernel, PointMixing, PointSet,
    Ray, Scene, Shading, TransferFunction, View,
};
use vr_physics::{Certainty, Reference};

fn bound(certainty: Certainty) -> f64 {
    match certainty {
        Certainty::Bound(b) => b,
        Certainty::Estimate(_) => panic!("points have bounds"),
    }
}

fn any_view() -> View {
    View::new(Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 0.0, 0.0, None), [1, 1])
}

/// Means of clustered points with colours; some of them coincident, if asked for.
fn means(coincident: bool) -> impl Strategy<Value = PointSet> {
    let place = prop::array::uniform3((-1.0f64..1.0).prop_map(|x| x * x * x));
    let one = (place, -1.3f32..0.2, (0.1f32..3.0, -1.0f32..1.0), prop::array::uniform3(0.0f32..1.0));
    (prop::collection::vec(one, 1..30), prop::sample::select(PointKernel::ALL.to_vec())).prop_map(
        move |(all, kernel)| {
            let mut positions: Vec<DVec3> = all.iter().map(|p| DVec3::from(p.0)).collect();
            let mut radii: Vec<f32> = all.iter().map(|p| libm::exp10f(p.1)).collect();
            for k in (3..positions.len()).step_by(7).filter(|_| coincident) {
                (positions[k], radii[k]) = (positions[k - 1], radii[k - 1]);
            }
            let weights = all.iter().zip(&radii).map(|(p, r)| p.2.0 * r * r * r).collect();
            let values = all.iter().map(|p| p.2.1).collect();
            let points = PointSet::new(positions, radii, weights, values, kernel).unwrap();
            let colors = all.iter().map(|p| p.3).collect();
            points.with_mixing(PointMixing::Mean).unwrap().with_colors(colors).unwrap()
        },
    )
}

/// Coincident points alone have a mean without a gradient, of which rounding makes a direction: only unshaded light is known of them.
fn lit_or_not() -> impl Strategy<Value = (PointSet, bool)> {
    prop_oneof![means(true).prop_map(|points| (points, false)), means(false).prop_map(|points| (points, true))]
}

fn transfer() -> TransferFunction {
    let knots = vec![
        ControlPoint::new(-1.0, [0.9, 0.5, 0.1], 0.0),
        ControlPoint::new(0.2, [0.1, 0.5, 0.9], 0.3),
        ControlPoint::new(1.0, [1.0; 3], 0.8),
    ];
    TransferFunction::new(knots, OpacityRule::Power, 0.3).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(21), failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn means_along_rays_are_within_their_bounds(points in means(true), aim in 0usize..30, aside in prop::array::uniform3(-0.1f64..0.1), to in prop::array::uniform3(-1.0f64..1.0)) {
        let direction = DVec3::from(to).normalize_or(DVec3::X);
        let target = points.positions()[aim % points.count()] + DVec3::from(aside);
        let ray = Ray { origin: target - direction * 4.0, direction };
        let Some(line) = PointLine::with_gradients(&points, &ray, &Clip::default(), f64::INFINITY) else { return Ok(()) };
        let mut breakpoints = Vec::new();
        line.breakpoints(&mut breakpoints);
        let (mut uncertain, mut length) = (0.0, 0.0);
        for ends in breakpoints.windows(2) {
            let (model, color) = (line.between(ends[0], ends[1]), line.color(ends[0], ends[1]));
            if let Some(model) = model {
                uncertain += (ends[1] - ends[0]) * model.field_error;
                length += ends[1] - ends[0];
            }
            for t in [-0.97, -0.4, 0.1, 0.77] {
                let s = 0.5 * (ends[0] + ends[1]) + 0.5 * (ends[1] - ends[0]) * t;
                let at = ray.origin + direction * (s + line.chord().offset);
                // Where a place that rounding moves by 4·10⁻¹⁵ crosses an edge or a tip, or all kernels nearly vanish, little is known of it.
                let near = points.around(at);
                let lengths = near.iter().map(|&k| (at.distance(points.positions()[k as usize]), f64::from(points.radii()[k as usize])));
                let clear = (0..points.count()).all(|k| {
                    let off = at.distance(points.positions()[k]) - f64::from(points.radii()[k]);
                    off.abs() > 1e-6
                });
                let smooth = lengths.clone().all(|(d, _)| d > 1e-4);
                if !clear || !smooth {
                    continue;
                }
                match (&model, points.field(at)) {
                    (None, truth) => prop_assert_eq!(truth, None),
                    (Some(model), Some(truth)) => {
                        let error = (model.field.at(t) - truth).abs();
                        // Edges are 10⁻⁶ away: relative errors of kernels there are 10⁻⁸ at most, of values below 1.
                        prop_assert!(error <= model.field_error + 2e-8, "{}: {error:e} > {:e}", points.kernel(), model.field_error);
                        let mut colors = [0.0; 3];
                        if let (Some(color), Some(truth)) = (&color, points.color_at(at)) {
                            for (c, truth) in truth.into_iter().enumerate() {
                                colors[c] = (color.channels[c].at(t) - truth).abs();
                                prop_assert!(colors[c] <= color.error + 2e-8, "{:e} > {:e}", colors[c], color.error);
                            }
                        }
                        let (gradient, slope) = (points.gradient(at).unwrap(), model.gradient.unwrap().map(|p| p.at(t)));
                        let error = (gradient - DVec3::from(slope)).length();
                        // The same by the distance from edges, points and tips.
                        let doubt = 1e-7 * (1.0 + gradient.length());
                        prop_assert!(error <= 2.0 * model.gradient_error + doubt, "{}: {error:e} > {:e}", points.kernel(), model.gradient_error);
                    }
                    (Some(_), None) => prop_assert!(false, "vacuum at {s}"),
                }
            }
        }
        // And worth something.
        prop_assert!(uncertain <= 1e-9 * length.max(1e-3), "{uncertain:e} over {length}");
    }
}

proptest! {
    // Each case looks the field up twenty thousand times.
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(22), failure_persistence: None, ..ProptestConfig::with_cases(30) })]

    #[test]
    fn light_is_that_of_fine_steps((points, shaded) in lit_or_not(), summed in any::<bool>(), aside in prop::array::uniform3(-0.3f64..0.3), to in prop::array::uniform3(-1.0f64..1.0)) {
        // A sum that is coloured by means, or a mean.
        let points = if summed { points.with_mixing(PointMixing::Sum).unwrap() } else { points };
        let direction = DVec3::from(to).normalize_or(DVec3::X);
        let ray = Ray { origin: DVec3::from(aside) - direction * 3.0, direction };
        let clip = Clip { crop: Some((DVec3::splat(-0.7), DVec3::splat(0.8))), planes: vec![] };
        let Some([from, to]) = ray.inside(&clip) else { return Ok(()) };
        let shading = shaded.then(|| Arc::new(Shading { power: 7.5, ..Shading::default() }));
        let scene = Scene { shading: shading.clone(), lights: vec![Light::default()], ..Scene::new(points.clone().into(), transfer()) };
        let view = View { clip, ..any_view() };
        let t = Reference::default().transport(&scene, &view, &ray).unwrap();
        let along = shading.map(|s| s.along::<f64>(&scene.lights, direction));
        let steps = 20_000;
        let h = (to - from) / f64::from(steps);
        let (mut light, mut depth) = ([0.0; 3], 0.0);
        for i in 0..steps {
            let at = ray.origin + direction * (from + h * (f64::from(i) + 0.5));
            let Some(f) = points.field(at) else { continue };
            let (optical, tint) = (scene.transfer.at(f), points.color_at(at).unwrap());
            let kappa = scene.transfer.extinction(optical.opacity);
            let (factor, added) = along.as_ref().map_or(([1.0; 3], [0.0; 3]), |along| along.reflect(points.gradient(at).unwrap().to_array()));
            let gain = libm::exp(-depth) * -libm::expm1(-kappa * h);
            for c in 0..3 {
                light[c] += gain * (optical.color[c] * tint[c] * factor[c] + added[c]);
            }
            depth += kappa * h;
        }
        let Some(t) = t else {
            prop_assert_eq!(depth, 0.0);
            return Ok(());
        };
        let uncertain = bound(t.certainty);
        // Means end in jumps, which a proof of where they lie costs; directions beside them lose digits.
        prop_assert!(uncertain < if shaded { 1e-6 } else { 1e-8 }, "{uncertain:e}");
        // κ is at most 5.4 per unit and a colour below 3; each edge of a support is off by a step at most, where a jump is.
        let edges = 2.0 * points.count() as f64;
        let allowed = uncertain + 5.4 * h * edges.min(10.0) * if shaded { 3.0 } else { 1.0 } + 2e-4;
        prop_assert!((t.opacity() - -libm::expm1(-depth)).abs() <= allowed, "{} {}", t.opacity(), -libm::expm1(-depth));
        for c in 0..3 {
            prop_assert!((t.radiance[c] - light[c]).abs() <= allowed, "{} {} of {allowed:e}", t.radiance[c], light[c]);
        }
    }
}

#[test]
fn equal_values_are_a_homogeneous_body() {
    // The union of two balls, in which κ is one number and the colour another.
    let positions = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, 1.0)];
    for kernel in PointKernel::ALL {
        let points = PointSet::new(positions.clone(), vec![1.0, 0.75], vec![1.0, 3.0], vec![0.25; 2], kernel).unwrap();
        let points = points.with_mixing(PointMixing::Mean).unwrap().with_colors(vec![[0.5, 0.25, 1.0]; 2]).unwrap();
        let scene = Scene::new(points.into(), transfer());
        let ray = Ray { origin: DVec3::new(0.25, 0.0, -5.0), direction: DVec3::Z };
        let t = Reference::default().transport(&scene, &any_view(), &ray).unwrap().unwrap();
        let [first, last] = [1.0f64, 0.75].map(|r| (r * r - 0.0625).sqrt());
        let depth = scene.transfer.extinction_at(0.25) * (first + 1.0 + last);
        let allowed = bound(t.certainty);
        assert!(allowed < 1e-10, "{kernel}: {allowed:e}");
        assert!((t.depth - depth).abs() <= allowed + 1e-14, "{kernel}: {} {depth}", t.depth);
        let color = scene.transfer.at(0.25).color;
        for (c, tint) in [0.5, 0.25, 1.0].into_iter().enumerate() {
            let wanted = color[c] * tint * -libm::expm1(-depth);
            assert!((t.radiance[c] - wanted).abs() <= allowed + 1e-14, "{kernel}: {} {wanted}", t.radiance[c]);
        }
    }
}

#[test]
fn values_of_rays_are_picked_of_means() {
    // Two points of one size: half-way between them the mean is that of their values, beyond it the value of one alone.
    let positions = vec![DVec3::ZERO, DVec3::Z];
    let points = PointSet::new(positions, vec![0.75; 2], vec![2.0; 2], vec![-0.5, 0.5], PointKernel::Cone).unwrap();
    let points = points.with_mixing(PointMixing::Mean).unwrap().with_colors(vec![[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let camera = Camera { eye: DVec3::new(0.0, 0.0, -5.0), target: DVec3::ZERO, ..any_view().camera };
    let scene = Scene::new(points.unwrap().into(), transfer());
    let picked = |compositing| {
        let scene = Scene { compositing, ..scene.clone() };
        let view = View::new(camera, [1, 1]);
        Reference::default().solve(&scene, &view, &Model::Canonical, &Control::default()).unwrap().pixels[0]
    };
    let maximum = picked(Compositing::Maximum);
    let at = scene.transfer.at(0.5);
    // Blue, where the second point reaches alone.
    let wanted = [0.0, 0.0, at.opacity * at.color[2], at.opacity];
    let allowed = bound(maximum.certainty);
    assert!(allowed < 1e-8, "{allowed:e}");
    assert!((0..4).all(|c| (maximum.rgba[c] - wanted[c]).abs() <= allowed), "{:?} {wanted:?}", maximum.rgba);
    // Through 0 half-way, in purple.
    let first = picked(Compositing::First { threshold: 0.0 });
    assert!((first.depth - 5.5).abs() < 1e-9, "{}", first.depth);
    let color = scene.transfer.at(0.0).color;
    assert!((0..3).all(|c| (first.rgba[c] - color[c] * [0.5, 0.0, 0.5][c]).abs() < 1e-8), "{:?}", first.rgba);
}
