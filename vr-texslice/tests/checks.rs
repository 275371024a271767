//! The checks that every renderer is put through.

use vr_core::{Compositing, Renderer, Scene, View};
use vr_physics::Reference;
use vr_physics::cases::Case;
use vr_physics::check::invariants::{
    forgets_earlier_frames, ignores_threads, is_free_of_scale, is_linear_in_emission, stays_in_range,
    turns_with_its_data, update_is_prepare,
};
use vr_physics::check::strategies::{Kind, scene_of};
use vr_physics::check::{self, Effort, Falling, Refinement, converges, errors_fall};
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

/// Scenes of some kinds, with a truth that is as good as f32 can show.
fn few(kinds: &[Kind]) -> Effort {
    Effort { reference: Reference::new(1e-6), ..Effort::cases(40) }.of_kinds(kinds)
}

fn errors_of(kinds: &[Kind]) {
    let planes = TexSlice::default();
    let shells = TexSlice { proxy: Proxy::Shells, ..TexSlice::default() };
    let pre_integrated = TexSlice { format: Format::PreIntegrated, ..TexSlice::default() };
    for renderer in [planes, shells, pre_integrated] {
        // Tables of some thousand entries, and rounding.
        let falling = Falling { floor: 3e-4, ..Falling::new("slice-distance") };
        for table in errors_fall(&renderer, &falling, &few(kinds)).unwrap_or_else(|e| panic!("{renderer:?}: {e}")) {
            println!("{table}");
        }
    }
}

#[test]
fn errors_fall_with_the_step() {
    errors_of(&[Kind::Plain, Kind::Spikes, Kind::Opaque, Kind::GradientOpacity, Kind::Lights]);
}

#[test]
#[ignore = "until tables of optics hold jumps, and ranges of blocks know of vacuum"]
fn errors_fall_with_the_step_whatever_is_hard() {
    errors_of(&Kind::ALL);
}

fn agrees_with_its_model_on(kinds: &[Kind]) {
    for renderer in [TexSlice::default(), TexSlice { proxy: Proxy::Shells, ..TexSlice::default() }] {
        // Under the other operators the model is the scene itself, which errors fall towards.
        let bound = |scene: &Scene, _: &View| {
            if scene.compositing == Compositing::Over { 2e-4 } else { f64::INFINITY }
        };
        let effort = Effort { cases: 120, ..few(kinds) };
        let report = check::agrees_with_its_model(&renderer, scene_of(kinds), bound, &effort);
        println!("{}", report.unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
    }
}

#[test]
#[ignore = "until tables of optics hold jumps"]
fn agrees_with_its_model_whatever_is_hard() {
    agrees_with_its_model_on(&Kind::ALL);
}

#[test]
fn an_update_is_a_new_preparation() {
    for renderer in [TexSlice::default(), TexSlice { format: Format::Rgba, ..TexSlice::default() }] {
        for effort in [Effort::cases(32), Effort::cases(48).of_kinds(&Kind::ALL)] {
            println!("{}", update_is_prepare(&renderer, &effort).unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
        }
    }
}
