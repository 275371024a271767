//! The checks that every renderer is put through.

use vr_core::{Compositing, Renderer, Scene, View};
use vr_physics::Reference;
use vr_physics::cases::Case;
use vr_physics::check::invariants::{
    forgets_earlier_frames, ignores_threads, is_free_of_scale, is_linear_in_emission, stays_in_range,
    turns_with_its_data,
};
use vr_physics::check::{self, Effort, Refinement, converges};
use vr_texslice::{Format, Proxy, TexSlice};

#[test]
fn survives_hard_cases() {
    let renderer = TexSlice::default();
    let bound = |case: &Case| renderer.hard_case_error(case.name).expect("every case has a documented error");
    let table = check::survives_hard_cases(&renderer, bound, &Reference::new(1e-7));
    println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
}

#[test]
fn every_texture_survives_hard_cases() {
    for format in [
        Format::PreIntegrated,
        Format::Compressed,
        Format::Rgba,
        Format::LuminanceAlpha,
        Format::Paletted,
        Format::Scalar,
    ] {
        for proxy in [Proxy::Planes, Proxy::Shells, Proxy::Stacks] {
            let renderer = TexSlice { format, proxy, ..TexSlice::default() };
            let table = check::survives_hard_cases(&renderer, |_| f64::INFINITY, &Reference::new(1e-5));
            println!("{format:?} {proxy:?}\n{}", table.unwrap_or_else(|e| panic!("{e}")));
        }
    }
}

#[test]
fn obeys_invariants() {
    let effort = Effort::cases(24);
    let pre_integrated = TexSlice { format: Format::PreIntegrated, slice_distance: 1.0, ..TexSlice::default() };
    for renderer in [TexSlice::default(), TexSlice { proxy: Proxy::Shells, ..TexSlice::default() }, pre_integrated] {
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
fn converges_at_its_documented_order() {
    for claim in TexSlice::default().orders() {
        // Below that tables and f32 decide.
        let refinement = Refinement {
            options: claim.options,
            floor: claim.floor,
            ..Refinement::new(claim.key, claim.orders.smooth)
        };
        let found = converges(&TexSlice::default(), &refinement, &Effort::cases(24));
        println!("{}: {}", claim.name, found.unwrap_or_else(|e| panic!("{}: {e}", claim.name)));
    }
}

#[test]
fn agrees_with_its_model_on_random_scenes() {
    use vr_physics::check::strategies::tame_scene;
    for renderer in [
        TexSlice::default(),
        TexSlice { proxy: Proxy::Shells, ..TexSlice::default() },
        TexSlice { proxy: Proxy::Stacks, ..TexSlice::default() },
    ] {
        // Random transfer functions bend within a table's entry, and early termination leaves 10⁻⁴. Of values that are picked there is no model.
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
