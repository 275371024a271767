//! The checks that every renderer is put through.

use vr_core::{Configurable, Options};
use vr_physics::Reference;
use vr_physics::check::{self, Effort, Refinement, Volumes};
use vr_raycast::{CompositingOrder, RayCaster};

// Local steps follow the light, and are no linear function of it: the suite is that of uniform ones. Rays end early, at 1e-4, and
// tables are rounded: the tolerance of the invariants.
vr_physics::renderer_suite!(suite: RayCaster::uniform(0.2), invariants = 1e-3, cases = 24);

#[test]
fn local_steps_survive_hard_cases() {
    let table = check::survives_documented_cases(&RayCaster::default(), &Reference::new(1e-7));
    println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
}

#[test]
fn converges_at_the_documented_orders() {
    for (rule, order) in [("midpoint", 2.0), ("left", 1.0)] {
        let caster = RayCaster::exact(1.0).configure(&Options::new().with("rule", rule)).unwrap();
        let found = check::converges(&caster, &Refinement::new("step", order), &Effort::cases(12));
        println!("{rule}: {}", found.unwrap_or_else(|e| panic!("{e}")));
    }
}

#[test]
fn obeys_invariants() {
    let whole = RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
    // 32 additions in f32 a run, and positions rounded to 10⁻⁵ of a voxel; 8·10⁻⁶ measured.
    for report in check::obeys_invariants(&whole, 5e-5, &Effort::cases(32)).unwrap_or_else(|e| panic!("{e}")) {
        println!("{}: held {}, worst {:.1e}", report.check, report.held, report.worst);
    }
}

const OTHER_VOLUMES: [Volumes; 3] = [Volumes::AdaptiveMeshes, Volumes::RectilinearGrids, Volumes::Meshes];

/// In f64 nothing but frames is rounded; in f32 tables are, and rays end early, as on grids.
#[test]
fn obeys_invariants_on_other_volumes() {
    for volumes in OTHER_VOLUMES {
        for (caster, tolerance) in [(RayCaster::exact(0.5), 1e-6), (RayCaster::uniform(0.2), 1e-3)] {
            let effort = Effort::cases(24).on(volumes);
            for report in check::obeys_invariants(&caster, tolerance, &effort).unwrap_or_else(|e| panic!("{e}")) {
                println!("{volumes:?}: {report}");
            }
        }
    }
}

/// Steps of a 16th of a cell under transfer functions that may rise from 0 to 0.95 within a tenth of the values.
#[test]
fn agrees_with_the_reference_on_other_volumes() {
    for volumes in OTHER_VOLUMES {
        let effort = Effort::cases(48).on(volumes);
        let report = check::agrees_with_reference(&RayCaster::exact(1.0 / 16.0), |_, _| 1e-2, &effort);
        println!("{volumes:?}: {}", report.unwrap_or_else(|e| panic!("{e}")));
    }
}
