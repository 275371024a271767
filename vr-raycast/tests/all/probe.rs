//! Tests that the caster's account of one pixel is what it draws there.

use crate::common::*;
use proptest::prelude::*;
use vr_core::*;
use vr_physics::cases;
use vr_physics::check::TestScene;
use vr_physics::check::strategies::scene;
use vr_raycast::{CompositingOrder, Connectivity, EmptySpace, ImageSampling, RayCaster, Rule, Step, Traversal, Vector};

/// The probe of a pixel, and the frame.
fn probed(caster: &RayCaster, scene: &Scene, view: &View, pixel: [u32; 2]) -> (Option<Probe>, Frame) {
    let control = Control::default();
    let mut prepared = caster.prepare(scene, &control).unwrap();
    let probe = prepared.probe(view, pixel, &control).unwrap();
    (probe, prepared.render(view, &control).unwrap().frame)
}

/// Casters of every kind of step, rule and order, without vectors.
fn casters() -> Vec<RayCaster> {
    let plain = RayCaster { vector: Vector::Off, ..RayCaster::default() };
    let whole = CompositingOrder::WHOLE_RAY;
    vec![
        plain.clone(),
        RayCaster { step: Step::Uniform(0.3), ..plain.clone() },
        RayCaster { step: Step::Uniform(0.3), rule: Rule::Left, empty_space: EmptySpace::None, ..plain.clone() },
        RayCaster { step: Step::Uniform(0.7), rule: Rule::Linear, ..plain.clone() },
        RayCaster { step: Step::Uniform(0.7), rule: Rule::Quadratic, order: whole, ..plain.clone() },
        RayCaster { step: Step::Uniform(0.4), order: CompositingOrder::BackToFront, ..plain.clone() },
        RayCaster { rule: Rule::Quadratic, traversal: Traversal::Cells, ..plain.clone() },
        RayCaster { step: Step::Auto, traversal: Traversal::Voxels, ..plain.clone() },
        RayCaster::exact(0.5),
    ]
}

/// Checks what must hold of any probe.
fn check(test: &TestScene, probe: &Probe) -> Result<(), TestCaseError> {
    for pair in probe.steps.windows(2) {
        prop_assert!(pair[1].begin >= pair[0].end() - 1e-9 * (1.0 + pair[0].end().abs()), "{pair:?}");
    }
    for step in &probe.steps {
        prop_assert!(!step.samples.is_empty() && (0.0..=1.0).contains(&step.transparency), "{step:?}");
        let (from, to) = (step.begin - 1e-9, step.end() + 1e-9);
        prop_assert!(step.samples.iter().all(|s| (from..=to).contains(&s.at) || to.abs() > 1e3), "{step:?}");
    }
    if test.scene.compositing.integrates_light() {
        let level = if let Compositing::Accumulate { level } = test.scene.compositing { level } else { 1.0 };
        let sum = probe.running(level).last().copied().unwrap_or_default();
        for c in 0..4 {
            // The kernel's own sum is in runs of f32.
            let allowed = 2e-5 * (1.0 + sum[c].abs());
            prop_assert!((sum[c] - f64::from(probe.rgba[c])).abs() <= allowed, "{sum:?} {:?}", probe.rgba);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_plain_engine_tells_of_the_pixel_that_it_draws(test in scene(), which in 0usize..9, at in [0.0f64..1.0, 0.0f64..1.0]) {
        let caster = &casters()[which];
        let view = View { supersampling: 1, ..test.view.clone() };
        let pixel = [0, 1].map(|a| (at[a] * f64::from(view.size[a])) as u32);
        if caster.prepare(&test.scene, &Control::default()).is_err() {
            return Ok(());
        }
        let (probe, frame) = probed(caster, &test.scene, &view, pixel);
        let probe = probe.unwrap();
        prop_assert!(probe.own_kernel);
        prop_assert_eq!(probe.rgba, frame.pixel(pixel[0], pixel[1]));
        let depth = frame.depth().unwrap()[(pixel[1] * view.size[0] + pixel[0]) as usize];
        prop_assert_eq!(probe.depth, depth);
        check(&test, &probe)?;
    }

    #[test]
    fn for_packets_the_plain_kernel_tells_of_the_same_ray(test in scene(), uniform in any::<bool>(), at in [0.0f64..1.0, 0.0f64..1.0]) {
        let caster = if uniform { RayCaster::uniform(0.3) } else { RayCaster::default() };
        let plain = RayCaster { vector: Vector::Off, ..caster.clone() };
        let scene = Scene { compositing: Compositing::Over, ..test.scene.with_filter(Filter::Trilinear) };
        let view = View { supersampling: 1, ..test.view.clone() };
        let pixel = [0, 1].map(|a| (at[a] * f64::from(view.size[a])) as u32);
        let (probe, _) = probed(&caster, &scene, &view, pixel);
        let probe = probe.unwrap();
        // The same probe as without vectors, skipped space included: what packets and plain rays differ by is tested where they are.
        let (own, frame) = probed(&plain, &scene, &view, pixel);
        // As text, for vacuum is NaN.
        let told = Probe { own_kernel: true, ..probe.clone() };
        prop_assert_eq!(format!("{told:?}"), format!("{:?}", own.unwrap()));
        prop_assert_eq!(probe.rgba, frame.pixel(pixel[0], pixel[1]));
    }
}

#[test]
fn packets_draw_what_the_probe_tells_to_rounding() {
    let scene = cases::by_name("marschner-lobb").expect("a hard case").scene;
    let view = oblique(&scene, 24);
    let mut vectors = 0;
    for caster in [RayCaster::uniform(0.3), RayCaster::default()] {
        for pixel in [[12, 12], [7, 15], [16, 9], [0, 0]] {
            let (probe, frame) = probed(&caster, &scene, &view, pixel);
            let probe = probe.unwrap();
            vectors += usize::from(!probe.own_kernel);
            for c in 0..4 {
                assert!((probe.rgba[c] - frame.pixel(pixel[0], pixel[1])[c]).abs() < 4e-5, "{pixel:?}");
            }
        }
    }
    assert!(vectors > 0, "no frame was drawn by packets");
}

#[test]
fn who_cannot_tell_says_so_and_pixels_must_exist() {
    let scene = cases::by_name("marschner-lobb").expect("a hard case").scene;
    let view = oblique(&scene, 8);
    let template = ImageSampling::Template { connectivity: Connectivity::Continuous };
    for caster in [
        RayCaster { image_sampling: template, ..RayCaster::uniform(0.5) },
        RayCaster { step: Step::ErrorBound(1e-3), ..RayCaster::default() },
    ] {
        assert_eq!(probed(&caster, &scene, &view, [3, 3]).0, None);
    }
    let control = Control::default();
    let mut prepared = RayCaster::default().prepare(&scene, &control).unwrap();
    let error = prepared.probe(&view, [8, 0], &control).unwrap_err();
    assert_eq!(error.to_string(), "pixel: found [8, 0]; must lie in the picture");
}
