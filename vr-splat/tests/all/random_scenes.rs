//! Random scenes of every kind: errors fall with the step, models and updates hold.

use vr_core::{Classification, Compositing, Scene, View};
use vr_physics::Reference;
use vr_physics::check::invariants::update_is_prepare;
use vr_physics::check::strategies::{Kind, scene_of};
use vr_physics::check::{Effort, Falling, agrees_with_its_model, errors_fall};
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

fn voxels(buffers: Buffers, shape: Shape) -> Splatter {
    let kernel = SplatKernel::new(shape);
    Splatter { buffers, classification: Classification::Pre, kernel, ..Splatter::default() }
}

/// Scenes of some kinds, with a truth that is as good as f32 can show.
fn few(kinds: &[Kind]) -> Effort {
    Effort { reference: Reference::new(1e-6), ..Effort::cases(40) }.of_kinds(kinds)
}

fn errors_fall_over(kinds: &[Kind]) {
    // Sheets are no closer than 0.02. Tables of some thousand entries, and rounding.
    let falling = Falling { ratio: 6.0, floor: 3e-4, ..Falling::new("slice-distance") };
    for table in errors_fall(&Splatter::default(), &falling, &few(kinds)).unwrap_or_else(|e| panic!("{e}")) {
        println!("{table}");
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
    for renderer in [Splatter::default(), voxels(Buffers::Image, Shape::Gaussian)] {
        // Under the other operators the model is the scene itself, which errors fall towards.
        let bound = |scene: &Scene, _: &View| {
            if scene.compositing == Compositing::Over { 3e-4 } else { f64::INFINITY }
        };
        let effort = Effort { cases: 60, ..few(&Kind::ALL) };
        let report = agrees_with_its_model(&renderer, scene_of(&Kind::ALL), bound, &effort);
        println!("{}", report.unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
    }
}

#[test]
fn an_update_is_a_new_preparation() {
    for renderer in [Splatter::default(), voxels(Buffers::Axis, Shape::BSpline)] {
        for effort in [Effort::cases(16), Effort::cases(24).of_kinds(&Kind::ALL)] {
            println!("{}", update_is_prepare(&renderer, &effort).unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
        }
    }
}
