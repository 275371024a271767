//! Random scenes of every kind: errors fall with the step, models and updates hold.

use crate::every_setting::{FORMATS, by_slope};
use proptest::prelude::*;
use vr_core::{Compositing, Scene, View};
use vr_physics::Reference;
use vr_physics::check::invariants::update_is_prepare;
use vr_physics::check::strategies::{Kind, scene_of};
use vr_physics::check::{Effort, Falling, agrees_with_its_model, errors_fall};
use vr_texslice::{Format, Proxy, TextureSlicer};

/// Scenes of some kinds, with a truth that is as good as f32 can show.
fn few(kinds: &[Kind]) -> Effort {
    Effort { reference: Reference::new(1e-6), ..Effort::cases(40) }.of_kinds(kinds)
}

/// Kinds of both tests are drawn by the same three renderers, which share each scene's reference.
fn errors_fall_over(kinds: &[Kind]) {
    let planes = TextureSlicer::default();
    let shells = TextureSlicer { proxy: Proxy::Shells, ..TextureSlicer::default() };
    let pre_integrated = TextureSlicer { format: Format::PreIntegrated, ..TextureSlicer::default() };
    for renderer in [planes, shells, pre_integrated] {
        // Tables of some thousand entries, and rounding.
        let falling = Falling { floor: 3e-4, ..Falling::new("slice-distance") };
        let tables = errors_fall(&renderer, &falling, &few(kinds));
        for table in tables.unwrap_or_else(|e| panic!("{renderer:?}: {e}")) {
            println!("{table}");
        }
    }
}

#[test]
fn errors_fall_with_the_step_in_the_first_half_of_kinds() {
    errors_fall_over(&Kind::ALL[..Kind::ALL.len() / 2]);
}

#[test]
fn errors_fall_with_the_step_in_the_second_half_of_kinds() {
    errors_fall_over(&Kind::ALL[Kind::ALL.len() / 2..]);
}

#[test]
fn agrees_with_its_model_whatever_is_hard() {
    let of = |format| TextureSlicer { format, ..TextureSlicer::default() };
    let stacks = FORMATS.map(|format| TextureSlicer { proxy: Proxy::Stacks, ..of(format) });
    // Random scenes are of colours, which luminance does not hold; where all is grey, it is the same as RGBA (capabilities.rs).
    let stacks = stacks.into_iter().filter(|renderer| renderer.format != Format::LuminanceAlpha);
    let others = [
        TextureSlicer::default(),
        TextureSlicer { proxy: Proxy::Shells, ..TextureSlicer::default() },
        of(Format::PreIntegrated),
        of(Format::Compressed),
        of(Format::Rgba),
        of(Format::Paletted),
    ];
    for renderer in others.into_iter().chain(stacks) {
        // Under the other operators the model is the scene itself, which errors fall towards.
        let bound = |scene: &Scene, _: &View| {
            if scene.compositing == Compositing::Over { 2e-4 } else { f64::INFINITY }
        };
        let effort = Effort { cases: 60, ..few(&Kind::ALL) };
        let report = agrees_with_its_model(&renderer, scene_of(&Kind::ALL), bound, &effort);
        println!("{}", report.unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
        let rows = scene_of(&Kind::ALL).prop_map(by_slope);
        let report = agrees_with_its_model(&renderer, rows, bound, &Effort { cases: 20, ..effort });
        println!("by slope: {}", report.unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
    }
}

#[test]
fn an_update_is_a_new_preparation() {
    let of = |format| TextureSlicer { format, ..TextureSlicer::default() };
    for renderer in [TextureSlicer::default(), of(Format::Rgba), of(Format::Paletted)] {
        for effort in [Effort::cases(16), Effort::cases(24).of_kinds(&Kind::ALL)] {
            println!("{}", update_is_prepare(&renderer, &effort).unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
        }
    }
}
