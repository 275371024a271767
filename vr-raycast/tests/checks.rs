//! The checks that every renderer is put through.

use vr_core::{Options, Renderer};
use vr_physics::Reference;
use vr_physics::cases::Case;
use vr_physics::check::{self, Effort, Refinement};
use vr_raycast::{Order, RayCaster};

/// What steps of ⅕ may be off by, case by case: the measured error, and half as much again.
fn bound(case: &Case) -> f64 {
    match case.name {
        // The wall's place is known to a step, and where a ray just passes it or just not, all of it is at stake.
        "opaque-wall" => 0.8,
        // A hundredth of a step wide: most rays that cross it at a right angle never see it.
        "thin-shell" => 0.75,
        // 33³ samples under a transfer function that a ray crosses in half a voxel.
        "marschner-lobb" => 2e-2,
        // Faces of vacuum are known to a step.
        "missing-voxels" => 4e-2,
        // Ten or so ramps in a cell.
        "full-u16" => 6e-2,
        // Shading turns fast where the gradient is nearly 0.
        "two-samples" => 1.3e-2,
        "bright" => 1e-2,
        // Smooth fields: what the square of a step of ⅕ leaves.
        "anisotropy" | "grazing-rays" | "axis-aligned" | "camera-inside" | "far-origin" => 6e-4,
        "faint" => 1e-4,
        // Nothing but rounding.
        "many-faint-steps" | "constant" => 3e-7,
        other => panic!("no bound for the hard case '{other}'"),
    }
}

/// The same of the default's local steps, which aim at an RMSE of 5·10⁻⁴.
fn bound_of_default(case: &Case) -> f64 {
    match case.name {
        "opaque-wall" | "thin-shell" => 0.85,
        // Walls, holes and ramps much narrower than a step are found as well or as badly as by steps of ⅕.
        "missing-voxels" => 6e-2,
        "two-samples" => 2.2e-2,
        // Twice the error aimed at, in the worst pixel of a smooth field.
        "anisotropy" | "grazing-rays" | "axis-aligned" | "camera-inside" | "far-origin" | "faint" => 1.2e-3,
        // The field alternates from voxel to voxel, faster than long steps can see: they meet both values equally often.
        "many-faint-steps" => 4e-4,
        _ => bound(case),
    }
}

#[test]
fn survives_hard_cases() {
    for (caster, bound) in
        [(RayCaster::default(), bound_of_default as fn(&Case) -> f64), (RayCaster::uniform(0.2), bound)]
    {
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
