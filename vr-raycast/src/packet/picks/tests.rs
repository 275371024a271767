//! Comparison of picked values with those of the plain engine.

use proptest::prelude::*;
use vr_core::{Compositing, Control, ControlPoint, OpacityRule, Renderer, Scene, Shading, TransferFunction};

use crate::caster::{EmptySpace, RayCaster, Rule};
use crate::packet::compared::{plain, same_picks};
use crate::packet::random_scenes::{picks, scenes};

/// The scene under an operator and a ramp over all values: a difference of values is one of pixels, and not larger.
fn with(scene: Scene, compositing: Compositing) -> Scene {
    let points = vec![ControlPoint::new(0.0, [0.0, 0.2, 1.0], 0.0), ControlPoint::new(1.0, [1.0, 0.7, 0.2], 1.0)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    Scene { compositing, transfer: transfer.into(), ..scene }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn picks_what_the_plain_engine_picks(
        (scene, view) in scenes(0.9), compositing in picks(), step in 0.1f64..2.5, left in any::<bool>(), shaded in any::<bool>()
    ) {
        let mut scene = with(scene, compositing);
        scene.shading = shaded.then(|| Shading::default().into());
        // The direction of a small gradient is set by rounding; positions differ by some units in the last place of f32, and fields rise by their whole range
        // within a cell.
        let allowed = if shaded { 2e-3 } else { 3e-5 };
        let caster = RayCaster { rule: if left { Rule::Left } else { Rule::Midpoint }, ..RayCaster::uniform(step) };
        let control = Control::default();
        let fast = caster.prepare(&scene, &control).unwrap().render(&view, &control).unwrap();
        let plain = plain(&caster, &scene, &view);
        prop_assert_eq!(fast.stats.counts.rays, plain.stats.counts.rays);
        same_picks(fast.frame.pixels().iter().copied(), &plain, (compositing, true), allowed)?;
    }

    /// Blocks in which nothing can be picked do not change a bit.
    #[test]
    fn no_bit_depends_on_leaping((scene, view) in scenes(0.9), compositing in picks(), step in 0.1f64..2.5) {
        let scene = with(scene, compositing);
        let leaping = RayCaster::uniform(step);
        let all = RayCaster { empty_space: EmptySpace::None, ..leaping.clone() };
        let control = Control::default();
        let [a, b] = [leaping, all].map(|caster| caster.prepare(&scene, &control).unwrap().render(&view, &control).unwrap());
        prop_assert!(a.stats.counts.samples <= b.stats.counts.samples);
        prop_assert_eq!(a.frame, b.frame);
    }
}
