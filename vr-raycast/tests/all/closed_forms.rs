//! Rays whose pixel is known in closed form.

use crate::common::*;
use glam::DVec3;
use vr_core::*;
use vr_raycast::{CompositingOrder, Precision, RayCaster, Rule, Step, TransferLookup};

/// A frame holds f32: nothing can be closer than this to a number near 1.
const F32: f64 = 1.2e-7;

/// Precision and classification, all ways.
fn kernels(base: &RayCaster) -> Vec<RayCaster> {
    let mut all = Vec::new();
    for precision in [Precision::F32, Precision::F64] {
        for classification in [TransferLookup::Auto, TransferLookup::Exact] {
            all.push(RayCaster { precision, transfer_lookup: classification, ..base.clone() });
        }
    }
    all
}

#[test]
fn homogeneous_slab_at_any_step() {
    let scene = Scene::new(volume([3, 3, 6], |_, _, _| 7.0), transfer(&[(0.0, [0.5, 1.0, 0.0], 0.3)], 1.0));
    // Five units; steps that divide it and steps that do not, over a factor of 16 and beyond its length.
    let alpha = 1.0 - 0.7f64.powi(5);
    let want = [0.5 * alpha, alpha, 0.0, alpha];
    let depth = 1000.0 - 5.0 + 0.5f64.ln() / 0.7f64.ln();
    for step in [0.25, 0.3, 0.5, 0.77, 1.0, 1.7, 2.0, 4.0, 8.0] {
        for order in [CompositingOrder::default(), CompositingOrder::BackToFront] {
            for rule in [Rule::Midpoint, Rule::Left] {
                for caster in kernels(&RayCaster { step: Step::Uniform(step), order, rule, ..RayCaster::uniform(0.2) })
                {
                    let (rgba, d) = pixel(&caster, &scene, &down(1.0, 1.2));
                    // A constant field has no discretisation error: what is left is the rounding of up to 20 steps.
                    assert_close(rgba, want, 20.0 * F32, &format!("{caster:?}"));
                    assert!((f64::from(d) - depth).abs() < 1e-4, "{caster:?}: {d}, expected {depth}");
                }
            }
        }
    }
}

#[test]
fn thin_media_keep_their_digits() {
    // 4096 steps of α = 10⁻⁷, and κ = 10⁻¹²: f32 sums that started at the ray's front would stall.
    for alpha in [1e-7, 1e-12f64] {
        let scene = Scene::new(volume([2, 2, 4097], |_, _, _| 0.0), homogeneous(alpha));
        let exact = -(4096.0 * (-alpha).ln_1p()).exp_m1();
        for order in [CompositingOrder::default(), CompositingOrder::BackToFront] {
            let caster = RayCaster { step: Step::Uniform(1.0), order, ..RayCaster::uniform(0.2) };
            let mut view = down(0.5, 0.5);
            view.camera.eye.z = 5000.0;
            view.camera.target.z = 0.0;
            let (rgba, _) = pixel(&caster, &scene, &view);
            // Relative: the table's entry and 32 f32 sums.
            assert!((f64::from(rgba[3]) / exact - 1.0).abs() < 32.0 * F32, "{order:?}: {rgba:?}, expected {exact}");
        }
    }
}

/// A field that rises by `slope` a unit from `low` along −z, in the direction of the ray, over 16 units.
fn ramp(low: f64, slope: f64) -> Volume {
    volume([2, 2, 17], move |_, _, z| low + slope * (16.0 - z))
}

#[test]
fn linear_extinction() {
    // κ rises linearly from 0.05 to 0.13, unequal and above 0 at both ends: τ = 16 · 0.09.
    let rule = OpacityRule::Extinction;
    let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.0), ControlPoint::new(1.0, [1.0; 3], 1.0)];
    let scene = Scene::new(ramp(0.05, 0.005), TransferFunction::new(points, rule, 1.0).unwrap());
    let alpha = -(-16.0f64 * 0.09).exp_m1();
    let error = |caster: RayCaster| {
        let (rgba, _) = pixel(&caster, &scene, &down(0.5, 0.5));
        (f64::from(rgba[3]) - alpha).abs()
    };
    for step in [1.0, 0.25] {
        // The midpoint rule is exact for linear κ, the last step included.
        assert!(error(RayCaster::exact(step)) < 2.0 * F32);
        assert!(error(RayCaster::exact(step * 0.9)) < 2.0 * F32);
        // Left rectangles miss ½·h·Δκ of τ: 0.04 h, times e^(−τ).
        let left = error(RayCaster { rule: Rule::Left, ..RayCaster::exact(step) });
        let expected = 0.5 * step * 0.08 * (1.0 - alpha);
        assert!((left / expected - 1.0).abs() < 0.05, "step {step}: {left}, expected {expected}");
    }
}

#[test]
fn pure_emission_and_pure_absorption() {
    let point =
        |opacity, emission| ControlPoint { emission: Some(emission), ..ControlPoint::new(0.0, [1.0; 3], opacity) };
    let scene = |p| Scene::new(ramp(1.0, 0.0), TransferFunction::new(vec![p], OpacityRule::Power, 1.0).unwrap());
    for step in [0.3, 0.5, 3.0] {
        for caster in kernels(&RayCaster { step: Step::Uniform(step), ..RayCaster::uniform(0.2) }) {
            let (rgba, depth) = pixel(&caster, &scene(point(0.0, [1e6, 0.25, 0.0])), &down(0.5, 0.5));
            assert!((f64::from(rgba[0]) / 16e6 - 1.0).abs() < 16.0 * F32, "{rgba:?}");
            assert_close([0.0, rgba[1], rgba[2], rgba[3]], [0.0, 4.0, 0.0, 0.0], 4e-6, "pure emission");
            assert_eq!(depth, f32::INFINITY);
            // What lies behind sends nothing: early termination would leave its opacity out.
            let whole = RayCaster { order: CompositingOrder::WHOLE_RAY, ..caster };
            let (rgba, _) = pixel(&whole, &scene(point(0.5, [0.0; 3])), &down(0.5, 0.5));
            assert_close(rgba, [0.0, 0.0, 0.0, 1.0 - 0.5f64.powi(16)], 8.0 * F32, "pure absorption");
        }
    }
}

#[test]
fn opaque_walls_end_the_ray() {
    // Clear up to the value 8, opaque from there on: 8 units before a wall of colour c.
    let wall = transfer(&[(8.0, [0.0; 3], 0.0), (8.0, [0.25, 0.5, 1.0], 1.0)], 1.0);
    let scene = Scene::new(ramp(0.0, 1.0), wall);
    for caster in kernels(&RayCaster { step: Step::Uniform(0.25), ..RayCaster::uniform(0.2) }) {
        let picture = render(&caster, &scene, &down(0.5, 0.5));
        assert_eq!(picture.frame.pixels()[0], [0.25, 0.5, 1.0, 1.0], "{caster:?}");
        // A wall's place is known to one step.
        let depth = picture.frame.depth().unwrap()[0];
        assert!((depth - (1000.0 - 8.0)).abs() <= 0.5, "{depth}");
    }
    // Behind a wall there is nothing, however bright.
    let lamp = transfer(&[(8.0, [0.0; 3], 0.0), (8.0, [0.5; 3], 1.0), (9.0, [0.5; 3], 1.0), (9.1, [1e6; 3], 0.9)], 1.0);
    for order in [CompositingOrder::default(), CompositingOrder::BackToFront] {
        let (rgba, _) = pixel(
            &RayCaster { order, ..RayCaster::uniform(0.2) },
            &Scene::new(ramp(0.0, 1.0), lamp.clone()),
            &down(0.5, 0.5),
        );
        assert_eq!(rgba, [0.5, 0.5, 0.5, 1.0], "{order:?}");
    }
    // Where emission is given on its own, an opaque medium sends nothing.
    let dark = ControlPoint { emission: Some([5.0; 3]), ..ControlPoint::new(0.0, [1.0; 3], 1.0) };
    let dark = TransferFunction::new(vec![dark], OpacityRule::Power, 1.0).unwrap();
    for caster in kernels(&RayCaster::uniform(0.2)) {
        assert_eq!(pixel(&caster, &Scene::new(ramp(0.0, 1.0), dark.clone()), &down(0.5, 0.5)).0, [0.0, 0.0, 0.0, 1.0]);
    }
}

#[test]
fn short_last_steps_of_dense_media() {
    // τ = 18.4 a unit, and a ray of a hundredth of a step: the table's entry is 1 in f32 and tells nothing of it.
    let mut scene = Scene::new(volume([2; 3], |_, _, _| 0.0), homogeneous(1.0 - 1e-8));
    scene.compositing = Compositing::Over;
    let mut view = down(0.5, 0.5);
    view.clip.crop = Some((DVec3::ZERO, DVec3::new(1.0, 1.0, 0.01)));
    for caster in kernels(&RayCaster { step: Step::Uniform(1.0), ..RayCaster::uniform(0.2) }) {
        let (rgba, _) = pixel(&caster, &scene, &view);
        let alpha = 1.0 - 1e-8f64.powf(0.01);
        assert_close(rgba, [alpha; 4], 2.0 * F32, &format!("{caster:?}"));
    }
}

#[test]
fn accumulate_stops_at_its_level() {
    let mut scene = Scene::new(ramp(1.0, 0.0), transfer(&[(0.0, [0.5, 1.0, 0.0], 0.3)], 1.0));
    for level in [0.1, 0.5, 0.9, 0.99] {
        scene.compositing = Compositing::Accumulate { level };
        for caster in kernels(&RayCaster::uniform(0.2)) {
            let picture = render(&caster, &scene, &down(0.5, 0.5));
            assert_close(picture.frame.pixels()[0], [0.5 * level, level, 0.0, level], 2.0 * F32, "level");
        }
    }
    // Never reached, and 1: the whole integral.
    for level in [0.999, 1.0] {
        scene.compositing = Compositing::Accumulate { level };
        let alpha = 1.0 - 0.7f64.powi(16);
        let (rgba, _) = pixel(&RayCaster::uniform(0.2), &scene, &down(0.5, 0.5));
        assert_close(rgba, [0.5 * alpha, alpha, 0.0, alpha], 32.0 * F32, "level");
    }
}

#[test]
fn first_hits_are_refined() {
    let colors = transfer(&[(0.0, [0.0; 3], 0.0), (10.0, [1.0, 0.5, 0.0], 0.7)], 1.0);
    let mut scene = Scene::new(ramp(0.0, 1.0), colors.clone());
    for threshold in [0.123, 5.0, 7.77, 15.99, 16.0] {
        scene.compositing = Compositing::First { threshold };
        for caster in kernels(&RayCaster { step: Step::Uniform(0.9), ..RayCaster::uniform(0.2) }) {
            let (rgba, depth) = pixel(&caster, &scene, &down(0.5, 0.5));
            let c = (threshold / 10.0).min(1.0);
            assert_close(rgba, [c, 0.5 * c, 0.0, 1.0], F32, "colour");
            // f32 has 6·10⁻⁵ at a distance of a thousand.
            assert!((f64::from(depth) - (984.0 + threshold)).abs() < 6.2e-5, "{threshold}: {depth}");
        }
    }
    // The entry point counts, what is never reached is nothing.
    scene.volume = ramp(3.0, 1.0);
    scene.compositing = Compositing::First { threshold: -1.0 };
    let (rgba, depth) = pixel(&RayCaster::uniform(0.2), &scene, &down(0.5, 0.5));
    assert_close(rgba, [0.3, 0.15, 0.0, 1.0], F32, "the colour of what is met at the entry");
    assert_eq!(depth, 984.0);
    scene.volume = ramp(0.0, 1.0);
    scene.compositing = Compositing::First { threshold: 16.01 };
    assert_eq!(pixel(&RayCaster::uniform(0.2), &scene, &down(0.5, 0.5)), ([0.0; 4], f32::INFINITY));
    // With a negative slope, stored numbers fall where values rise.
    let samples = (0..68).map(|i| (i / 4) as u8).collect::<Vec<_>>();
    let calibration = Calibration { slope: -2.0, intercept: 40.0 };
    let grid = UniformGrid::new([2, 2, 17], samples, Placement::from_spacing([1.0; 3]).unwrap(), calibration);
    scene = Scene::new(grid.unwrap().into(), colors);
    // From z = 16 downwards: 40 − 2 z.
    scene.compositing = Compositing::First { threshold: 25.0 };
    assert!((pixel(&RayCaster::uniform(0.2), &scene, &down(0.5, 0.5)).1 - (1000.0 - 7.5)).abs() < 6.2e-5);
}

#[test]
fn mean_and_extremes() {
    let grey = transfer(&[(0.0, [1.0; 3], 0.0), (32.0, [1.0; 3], 1.0)], 1.0);
    let mut scene = Scene::new(ramp(3.0, 1.0), grey.clone());
    for step in [0.5, 0.7, 5.0, 40.0] {
        for caster in kernels(&RayCaster { step: Step::Uniform(step), ..RayCaster::uniform(0.2) }) {
            for (compositing, value, depth) in [
                (Compositing::Average, 11.0, f32::INFINITY),
                (Compositing::Maximum, 19.0, 1000.0),
                (Compositing::Minimum, 3.0, 984.0),
            ] {
                scene.compositing = compositing;
                let (rgba, d) = pixel(&caster, &scene, &down(0.5, 0.5));
                // Means and ends of a ramp are exact for a midpoint rule: rounding is left, and (α c, α) for c = 1.
                assert_close(rgba, [value / 32.0; 4], 4.0 * F32, compositing.name());
                assert_eq!(d, depth, "{}", compositing.name());
            }
        }
    }
    let samples = (0..68).map(|i| (i / 4) as i16).collect::<Vec<_>>();
    let calibration = Calibration { slope: -1.0, intercept: 20.0 };
    let grid = UniformGrid::new([2, 2, 17], samples, Placement::from_spacing([1.0; 3]).unwrap(), calibration);
    scene = Scene::new(grid.unwrap().into(), grey);
    for (compositing, value) in [(Compositing::Maximum, 20.0), (Compositing::Minimum, 4.0)] {
        scene.compositing = compositing;
        assert_close(
            pixel(&RayCaster::uniform(0.2), &scene, &down(0.5, 0.5)).0,
            [value / 32.0; 4],
            F32,
            "negative slope",
        );
    }
}

#[test]
fn vacuum_is_left_out() {
    // One missing sample makes the cells around it vacuum: of 16 units, those between z = 4 and z = 6.
    let holed = volume([2, 2, 17], |x, y, z| if (x, y, z) == (0.0, 1.0, 5.0) { f64::NAN } else { 8.0 });
    let mut scene = Scene::new(holed, transfer(&[(0.0, [1.0; 3], 0.0), (16.0, [1.0; 3], 0.5)], 1.0));
    let alpha = 1.0 - 0.75f64.powi(14);
    // Steps of a whole fraction of a cell meet the faces of the hole.
    for caster in kernels(&RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) }) {
        scene.compositing = Compositing::Over;
        assert_close(pixel(&caster, &scene, &down(0.5, 0.5)).0, [alpha; 4], 16.0 * F32, "over");
        scene.compositing = Compositing::Average;
        assert_close(pixel(&caster, &scene, &down(0.5, 0.5)).0, [0.25, 0.25, 0.25, 0.25], F32, "average");
    }
    let nothing = volume([3; 3], |_, _, _| f64::NAN);
    for compositing in [
        Compositing::Over,
        Compositing::First { threshold: 0.0 },
        Compositing::Average,
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::Accumulate { level: 0.5 },
    ] {
        let scene = Scene { compositing, ..Scene::new(nothing.clone(), homogeneous(0.5)) };
        assert_eq!(
            pixel(&RayCaster::uniform(0.2), &scene, &down(1.0, 1.0)),
            ([0.0; 4], f32::INFINITY),
            "{compositing:?}"
        );
    }
}
