//! Random scenes of every kind: errors fall with the step, models and updates hold.

use vr_physics::Reference;
use vr_physics::check::invariants::update_is_prepare;
use vr_physics::check::strategies::Kind;
use vr_physics::check::{Effort, Falling, errors_fall};
use vr_shearwarp::ShearWarp;

/// Scenes of some kinds, with a truth that is as good as f32 can show.
fn few(kinds: &[Kind]) -> Effort {
    Effort { reference: Reference::new(1e-6), ..Effort::cases(40) }.of_kinds(kinds)
}

fn errors_fall_over(kinds: &[Kind]) {
    // Slices are as far apart as texels are wide, or half of that, and pictures of texels a third as wide take 27 times as long: down to a ninth of a voxel
    // errors must fall to the half that order ½ leaves at a sixteenth. The nearest entry of tables, and the levels of codes, are below.
    let falling = Falling { ratio: 3.0, order: 0.63, floor: 3e-4, ..Falling::new("texel") };
    // Of the kind Filters, all but the trilinear one and the nearest are refused, and not counted.
    for table in errors_fall(&ShearWarp::default(), &falling, &few(kinds)).unwrap_or_else(|e| panic!("{e}")) {
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
fn an_update_is_a_new_preparation() {
    for renderer in [ShearWarp::default(), ShearWarp::classic()] {
        for effort in [Effort::cases(16), Effort::cases(24).of_kinds(&Kind::ALL)] {
            println!("{}", update_is_prepare(&renderer, &effort).unwrap_or_else(|e| panic!("{renderer:?}: {e}")));
        }
    }
}
