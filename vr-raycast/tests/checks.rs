//! The checks that every renderer is put through.

use vr_core::{Options, Renderer};
use vr_physics::Reference;
use vr_physics::cases::Case;
use vr_physics::check::invariants::update_is_prepare;
use vr_physics::check::strategies::Kind;
use vr_physics::check::{self, Effort, Falling, Refinement, errors_fall};
use vr_raycast::{Order, RayCaster};

#[test]
fn survives_hard_cases() {
    for caster in [RayCaster::default(), RayCaster::uniform(0.2)] {
        let bound = |case: &Case| caster.hard_case_error(case.name).expect("every case has a documented error");
        let table = check::survives_hard_cases(&caster, bound, &Reference::new(1e-7));
        println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
    }
}

#[test]
fn converges_at_the_documented_orders() {
    for (rule, order) in [("midpoint", 2.0), ("left", 1.0)] {
        let caster = RayCaster::exact(1.0).configure(&Options::new().with("rule", rule)).unwrap();
        let found = check::converges(&*caster, &Refinement::new("step", order), &Effort::cases(12));
        println!("{rule}: {}", found.unwrap_or_else(|e| panic!("{e}")));
    }
}

#[test]
fn obeys_invariants() {
    let whole = RayCaster { order: Order::WHOLE_RAY, ..RayCaster::uniform(0.2) };
    // 32 additions in f32 a run, and positions rounded to 10⁻⁵ of a voxel; 8·10⁻⁶ measured.
    for report in check::obeys_invariants(&whole, 5e-5, &Effort::cases(32)).unwrap_or_else(|e| panic!("{e}")) {
        println!("{}: held {}, worst {:.1e}", report.check, report.held, report.worst);
    }
}

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
fn errors_fall_with_the_step() {
    errors_of(&[exact()], &Kind::ALL);
    let smooth = [Kind::Plain, Kind::Opaque, Kind::GradientOpacity, Kind::Lights];
    errors_of(&[uniform(), local()], &smooth);
}

#[test]
fn errors_fall_with_the_step_whatever_is_hard() {
    errors_of(&[uniform(), local()], &Kind::ALL);
}

#[test]
fn an_update_is_a_new_preparation() {
    for caster in [RayCaster::default(), RayCaster::uniform(0.2), RayCaster::exact(0.5)] {
        for effort in [Effort::cases(32), Effort::cases(48).of_kinds(&Kind::ALL)] {
            println!("{}", update_is_prepare(&caster, &effort).unwrap_or_else(|e| panic!("{caster:?}: {e}")));
        }
    }
}
