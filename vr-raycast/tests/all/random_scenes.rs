//! Random scenes of every kind: errors fall with the step, models and updates hold.

use vr_physics::Reference;
use vr_physics::check::invariants::update_is_prepare;
use vr_physics::check::strategies::Kind;
use vr_physics::check::{Effort, Falling, errors_fall};
use vr_raycast::{Connectivity, ImageSampling, RayCaster};

/// Scenes of some kinds, with a truth that is as good as f32 can show.
fn few(kinds: &[Kind]) -> Effort {
    Effort { reference: Reference::new(1e-6), ..Effort::cases(40) }.of_kinds(kinds)
}

/// The plain engine in f64, the vector engine at equal steps, and local steps, of which the error aimed at is refined: one a
/// 32nd as large takes steps about a sixth as long.
fn errors_of(casters: &[(RayCaster, Falling)], kinds: &[Kind]) {
    for (caster, falling) in casters {
        for table in errors_fall(caster, falling, &few(kinds)).unwrap_or_else(|e| panic!("{caster:?}: {e}")) {
            println!("{table}");
        }
    }
}

fn exact() -> (RayCaster, Falling) {
    (RayCaster::exact(1.0), Falling::new("step"))
}

fn uniform() -> (RayCaster, Falling) {
    (RayCaster::uniform(1.0), Falling { floor: 3e-4, ..Falling::new("step") })
}

fn local() -> (RayCaster, Falling) {
    let falling = Falling { coarsest: 3.2e-2, ratio: 32.0, order: 0.25, floor: 5e-4, ..Falling::new("local-error") };
    (RayCaster::default(), falling)
}

#[test]
fn errors_of_the_plain_engine_fall_with_the_step() {
    errors_of(&[exact()], &Kind::ALL);
}

#[test]
fn errors_of_the_vector_engine_fall_with_the_step_in_the_first_half_of_kinds() {
    errors_of(&[uniform(), local()], &Kind::ALL[..Kind::ALL.len() / 2]);
}

#[test]
fn errors_of_the_vector_engine_fall_with_the_step_in_the_second_half_of_kinds() {
    errors_of(&[uniform(), local()], &Kind::ALL[Kind::ALL.len() / 2..]);
}

/// Adaptive meshes, rectilinear grids and meshes of cells are sampled at places: local steps are not theirs.
#[test]
fn errors_fall_with_the_step_on_other_volumes() {
    errors_of(&[exact(), uniform()], &Kind::OF_OTHER_VOLUMES);
}

#[test]
fn an_update_is_a_new_preparation() {
    let template = RayCaster {
        image_sampling: ImageSampling::Template { connectivity: Connectivity::Continuous },
        ..RayCaster::uniform(0.5)
    };
    for caster in [RayCaster::default(), RayCaster::uniform(0.2), RayCaster::exact(0.5), template] {
        for effort in [Effort::cases(16), Effort::cases(24).of_kinds(&Kind::ALL)] {
            println!("{}", update_is_prepare(&caster, &effort).unwrap_or_else(|e| panic!("{caster:?}: {e}")));
        }
    }
}
