//! Study.
mod common;
use common::*;
use vr_core::*;
use vr_physics::Reference;
use vr_physics::check::{self, Effort, Refinement};
use vr_raycast::*;

#[test]
fn cases() {
    let d = RayCaster::default;
    for (name, caster) in [
        ("linear .2", RayCaster { rule: Rule::Linear, ..d() }),
        ("quadratic .2", RayCaster { rule: Rule::Quadratic, ..d() }),
        ("quadratic 1", RayCaster { rule: Rule::Quadratic, step: Step::Uniform(1.0), ..d() }),
        ("quadratic exact 1", RayCaster { rule: Rule::Quadratic, ..RayCaster::exact(1.0) }),
        ("midpoint cells", RayCaster { traversal: Traversal::Cells, step: Step::Uniform(1.0), ..d() }),
        (
            "quadratic cells",
            RayCaster { traversal: Traversal::Cells, rule: Rule::Quadratic, step: Step::Uniform(1.0), ..d() },
        ),
        ("exact f32", RayCaster { traversal: Traversal::Cells, rule: Rule::Exact, ..d() }),
        ("exact f64", RayCaster { traversal: Traversal::Cells, rule: Rule::Exact, ..RayCaster::exact(1.0) }),
        ("voxels", RayCaster { traversal: Traversal::Voxels, ..d() }),
    ] {
        println!("---- {name}");
        match check::survives_hard_cases(&caster, |_| f64::INFINITY, &Reference::new(1e-7)) {
            Ok(t) => println!("{t}"),
            Err(e) => println!("{e}"),
        }
    }
}

#[test]
fn converge() {
    for (rule, order) in [("linear", 2.0), ("quadratic", 4.0)] {
        for traversal in ["samples", "cells"] {
            let caster = RayCaster::exact(1.0)
                .configure(&Options::new().with("rule", rule).with("traversal", traversal))
                .unwrap();
            for (coarsest, floor) in [(1.0, 3e-7), (2.0, 1e-7), (0.5, 1e-7)] {
                let r = Refinement { coarsest, floor, ..Refinement::new("step", order) };
                let found = check::converges(&*caster, &r, &Effort::cases(12));
                println!("{rule} {traversal} {coarsest}: {}", found.map_or_else(|e| e.reason, |c| c.to_string()));
            }
        }
    }
}
