//! The checks that every renderer is put through.

use proptest::strategy::Strategy;
use vr_core::{Compositing, DocumentedError, Scene, View};
use vr_physics::cases::{self, Case};
use vr_physics::check::invariants::{
    forgets_earlier_frames, ignores_threads, is_free_of_scale, is_linear_in_emission, stays_in_range,
    turns_with_its_data,
};
use vr_physics::check::strategies::tame_scene;
use vr_physics::check::{self, CaseOutcome, CaseResult, Effort, HardCases, TestScene};
use vr_physics::{Metrics, Reference};
use vr_texslice::{Format, Proxy, TextureSlicer};

vr_physics::renderer_suite!(suite: TextureSlicer::default(), invariants = 1e-3, cases = 24);

#[test]
fn survives_hard_cases() {
    let table = check::survives_documented_cases(&TextureSlicer::default(), &Reference::new(1e-7));
    let table = table.unwrap_or_else(|e| panic!("{e}"));
    println!("{table}");
    // A wall just met or just missed is all of a pixel: here, too, the RMSE says more.
    let grids = cases::all().iter().filter(|case| case.scene.volume.grid().is_some()).count();
    assert_eq!(hold(&table, "default", true), grids);
}

/// RMSE that a case may cost: what was measured at worst of these, and half as much again.
fn rmse_bound(case: &str, values: bool) -> f64 {
    let [a, b] = match case {
        "opaque-wall" => [0.053, 0.063],
        "thin-shell" => [0.075, 0.071],
        "marschner-lobb" => [0.012, 0.077],
        "anisotropy" => [3.3e-3, 0.041],
        "grazing-rays" => [2.7e-3, 0.011],
        "axis-aligned" => [3.2e-3, 0.011],
        // Stacks: what lies between layers is seen from near by.
        "camera-inside" => [0.05, 0.043],
        "far-origin" => [7.8e-3, 0.018],
        "faint" => [1.3e-3, 1.3e-3],
        "many-faint-steps" => [3.3e-6, 3.3e-6],
        "bright" => [5.6e-3, 0.036],
        "missing-voxels" => [0.026, 0.012],
        "two-samples" => [6.2e-3, 0.057],
        "constant" => [1e-7, 1e-7],
        "full-u16" => [0.033, 0.3],
        // No uniform grids: refused.
        "level-boundary" | "uneven-axes" | "slivers" => [0.0; 2],
        other => panic!("{other}: no figures"),
    };
    if values { a } else { b }
}

/// Holds every case that was drawn to its bound; says how many there were.
fn hold(table: &HardCases, how: &str, values: bool) -> usize {
    let drawn = table.results.iter().filter_map(|result| match result.outcome {
        CaseOutcome::Drawn(metrics) => Some((result, metrics)),
        _ => None,
    });
    let check = |(result, metrics): (&CaseResult, Metrics)| {
        let bound = rmse_bound(result.name, values) + result.uncertainty;
        assert!(
            metrics.rmse <= bound,
            "{how}, {}: RMSE {:.2e}, measured before {bound:.2e}",
            result.name,
            metrics.rmse
        );
    };
    drawn.map(check).count()
}

#[test]
fn every_texture_survives_hard_cases() {
    // All of these are of colours, which luminance and alpha alone cannot hold: those are the same as RGBA where all is grey (capabilities.rs).
    for format in [Format::PreIntegrated, Format::Compressed, Format::Rgba, Format::Paletted, Format::Scalar] {
        for proxy in [Proxy::Planes, Proxy::Shells, Proxy::Stacks] {
            let renderer = TextureSlicer { format, proxy, ..TextureSlicer::default() };
            let how = format!("{format:?} {proxy:?}");
            let values = matches!(format, Format::Scalar | Format::PreIntegrated | Format::Compressed);
            // The largest error of light that is interpolated may be anything: the RMSE says more.
            let bound = |case: &Case| DocumentedError::Rmse(rmse_bound(case.name, values));
            let table = check::survives_hard_cases(&renderer, bound, &Reference::new(1e-5));
            let table = table.unwrap_or_else(|e| panic!("{how}: {e}"));
            println!("{how}\n{table}");
            assert!(hold(&table, &how, values) >= 12, "{how}");
        }
    }
}

#[test]
fn obeys_invariants() {
    let effort = Effort::cases(24);
    let pre_integrated =
        TextureSlicer { format: Format::PreIntegrated, slice_spacing: 1.0, ..TextureSlicer::default() };
    for renderer in
        [TextureSlicer::default(), TextureSlicer { proxy: Proxy::Shells, ..TextureSlicer::default() }, pre_integrated]
    {
        let reports = [
            stays_in_range(&renderer, 1e-5, &effort),
            is_linear_in_emission(&renderer, 1e-4, &effort),
            is_free_of_scale(&renderer, 1e-4, &effort),
            turns_with_its_data(&renderer, 1e-3, &effort),
            ignores_threads(&renderer, &effort),
            forgets_earlier_frames(&renderer, &effort),
        ];
        for report in reports {
            let report = report.unwrap_or_else(|e| panic!("{e}"));
            println!("{}: held {}, refused {}, worst {:.1e}", report.check, report.held, report.refused, report.worst);
        }
    }
}

#[test]
fn agrees_with_its_model_on_random_scenes() {
    for renderer in [
        TextureSlicer::default(),
        TextureSlicer { proxy: Proxy::Shells, ..TextureSlicer::default() },
        TextureSlicer { proxy: Proxy::Stacks, ..TextureSlicer::default() },
    ] {
        // Random transfer functions bend within a table's entry, and early termination leaves 10⁻⁴. What the others may be off by: see below.
        let bound = |scene: &Scene, _: &View| {
            if scene.compositing == Compositing::Over { 2e-4 } else { f64::INFINITY }
        };
        let report = check::agrees_with_its_model(&renderer, tame_scene(), bound, &Effort::cases(48));
        println!(
            "{}",
            report.map_or_else(
                |e| panic!("{e}"),
                |r| format!("held {}, refused {}, worst {:.1e}", r.held, r.refused, r.worst)
            )
        );
    }
}

/// Random scenes, all of them under one operator.
fn under(compositing: Compositing) -> impl Strategy<Value = TestScene> {
    tame_scene().prop_map(move |test| TestScene { scene: Scene { compositing, ..test.scene }, view: test.view })
}

#[test]
fn other_operators_come_near_the_canonical_pixel() {
    // Measured on these scenes, and half as much again: noise of a few voxels, and samples lie as far apart as they do.
    for (compositing, bound) in [
        (Compositing::Average, 0.011),
        (Compositing::Maximum, 0.08),
        (Compositing::Minimum, 0.17),
        (Compositing::Accumulate { level: 0.4 }, 0.052),
    ] {
        let report = check::agrees_with_reference_on(
            &TextureSlicer::default(),
            under(compositing),
            |_, _| bound,
            &Effort::cases(48),
        );
        let report = report.unwrap_or_else(|e| panic!("{compositing:?}: {e}"));
        println!(
            "{}: held {}, refused {}, worst {:.1e}",
            compositing.name(),
            report.held,
            report.refused,
            report.worst
        );
        assert!(report.held > 0, "{compositing:?}");
    }
}
