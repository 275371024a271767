//! Tests how the error against the reference falls with the step: fitted orders, the default step on the phantoms, and the floor of f32.

use crate::common::*;
use vr_core::*;
use vr_raycast::{CompositingOrder, Precision, RayCaster, Rule, Step, TransferLookup};

/// A smooth field between 0 and 1 on 17³ samples.
fn smooth() -> Volume {
    let wave = |x: f64, y: f64, z: f64| 0.5 + 0.2 * (0.5 * x).sin() * (0.4 * y + 0.3).cos() + 0.25 * (0.45 * z).sin();
    volume([17; 3], wave)
}

/// Smooth in the value, and above 0 everywhere: κ differs at the two ends of most rays.
fn gentle() -> TransferFunction {
    let points = [ControlPoint::new(0.0, [0.2, 0.9, 0.1], 0.02), ControlPoint::new(1.0, [1.0, 0.1, 0.6], 0.20)];
    TransferFunction::new(points.to_vec(), OpacityRule::Extinction, 1.0).unwrap()
}

fn listed(errors: &[f64]) -> String {
    errors.iter().map(|e| format!("{e:.1e}")).collect::<Vec<_>>().join(" ")
}

/// The slope of log error against log step.
fn fitted_order(steps: &[f64], errors: &[f64]) -> f64 {
    let points: Vec<_> = steps.iter().zip(errors).map(|(s, e)| (s.log2(), e.log2())).collect();
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let cov: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    cov / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

/// Errors at steps 1, ½, … 1/16 in f64.
fn measure(scene: &Scene, rule: Rule) -> (f64, Vec<f64>) {
    let steps = [1.0, 0.5, 0.25, 0.125, 0.0625];
    let view = oblique(scene, 12);
    let at = |step: f64, rule| render(&RayCaster { rule, ..RayCaster::exact(step) }, scene, &view).frame;
    let truth = truth(scene, &view);
    let errors: Vec<f64> = steps.iter().map(|&s| rms(&at(s, rule), &truth)).collect();
    (fitted_order(&steps, &errors), errors)
}

#[test]
fn orders_of_both_rules_for_every_filter() {
    for filter in Filter::ALL {
        let scene = Scene::new(smooth().with_filter(filter), gentle());
        for (rule, documented) in [(Rule::Midpoint, 2.0), (Rule::Left, 1.0)] {
            let (order, errors) = measure(&scene, rule);
            println!("{filter}, {rule:?}: order {order:.3}, errors {}", listed(&errors));
            if filter.is_continuous() {
                // Kinks at cell faces, and the last step's changing length, scatter the fit by a few per cent.
                assert!((order - documented).abs() < 0.15, "{filter} {rule:?}: {order}");
            } else {
                assert!((0.6..1.6).contains(&order), "{filter} {rule:?}: {order}");
            }
        }
    }
}

#[test]
fn jumps_of_the_transfer_function_leave_order_one() {
    let c = [1.0, 0.5, 0.2];
    let scene = Scene::new(smooth(), transfer(&[(0.4, c, 0.0), (0.4, c, 0.3), (0.6, c, 0.3), (0.6, c, 0.05)], 1.0));
    let (order, errors) = measure(&scene, Rule::Midpoint);
    println!("jumps: order {order:.3}, errors {}", listed(&errors));
    assert!((0.6..1.6).contains(&order), "{order}");
}

#[test]
fn default_step_cannot_be_seen_on_smooth_phantoms() {
    for n in [64, 128] {
        for (name, scene) in phantom_scenes(n) {
            for (azimuth, elevation) in [(0.0, 0.0), (33.0, 21.0), (80.0, -50.0), (30.0, 70.0)] {
                let view = View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, None), [40, 40]);
                let truth = truth(&scene, &view);
                let error = |caster: RayCaster| max_error(&render(&caster, &scene, &view).frame, &truth);
                let at = [2.0, 1.0, 0.5, 0.2]
                    .map(|step| error(RayCaster { step: Step::Uniform(step), ..RayCaster::uniform(0.2) }));
                println!("{name} {n}³ from {azimuth}°: max error at steps 2, 1, ½, ⅕: {}", listed(&at));
                assert!(at[3] <= 1.0 / 255.0, "{name}");
            }
        }
    }
}

#[test]
fn floor_of_single_precision() {
    for (name, scene) in phantom_scenes(64) {
        let view = oblique(&scene, 32);
        let exact = RayCaster::exact(0.2);
        let truth = render(&exact, &scene, &view).frame;
        let floor = |caster: RayCaster| max_error(&render(&caster, &scene, &view).frame, &truth);
        let single = floor(RayCaster { precision: Precision::F32, ..exact.clone() });
        let table = floor(RayCaster { transfer_lookup: TransferLookup::Table, ..exact.clone() });
        let termination = floor(RayCaster { order: CompositingOrder::default(), ..exact.clone() });
        let all = floor(RayCaster::uniform(0.2));
        println!("{name}: f32 {single:.1e}, table {table:.1e}, termination {termination:.1e}, all {all:.1e}");
        // The floor that the settings state.
        assert!(all <= 3e-4, "{name}: {all}");
        assert!(termination <= 1.0 - CompositingOrder::TERMINATION, "{name}: {termination}");
        // Rounded positions (10⁻⁵ of a voxel) and 32 f32 additions a run.
        assert!(single <= 2e-5, "{name}: {single}");
    }
}

#[test]
fn local_steps_come_near_the_error_they_aim_at() {
    for (name, scene) in phantom_scenes(64) {
        let view = oblique(&scene, 64);
        let truth = truth(&scene, &view);
        let mut samples = Vec::new();
        for aim in [1e-2, 2e-3, 5e-4] {
            let picture =
                render(&RayCaster { step: Step::Local { error: aim }, ..RayCaster::uniform(0.2) }, &scene, &view);
            let error = rms(&picture.frame, &truth);
            println!("{name}: aimed at {aim:.0e}, RMSE {error:.1e}, {} samples", picture.stats.counts.samples);
            // An estimate: twice as much would say that it is none.
            assert!(error <= 2.0 * aim, "{name}: {error} where {aim} was aimed at");
            samples.push(picture.stats.counts.samples);
        }
        assert!(samples.windows(2).all(|w| w[0] < w[1]), "smaller errors take more samples: {samples:?}");
    }
}
