//! Fields that are a few f32 numbers wide: where a transfer function jumps or turns inside them must be seen all the same.

use crate::common::*;
use vr_core::*;
use vr_raycast::{Precision, RayCaster, Rule, TransferLookup, Traversal, Vector};

/// Lower bound of all stored numbers: f32 numbers are 6·10⁻⁵ apart there.
const BASE: f64 = 1000.0;

/// Widths of the fields: 65 f32 numbers, and 5.
const WIDTHS: [f64; 2] = [4e-3, 2.5e-4];

/// Values of a jump or of the middle of a ramp, as fractions of the field's range.
const PLACES: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];

/// It grows along all axes, most along z.
fn field(width: f64) -> Volume {
    volume([5, 5, 9], |x, y, z| BASE + width * (z + 0.1 * x + 0.05 * y) / 8.6)
}

/// From faint to dense, by a ramp of a part of the field's range; by a jump if that is 0.
fn scene(width: f64, place: f64, ramp: f64) -> Scene {
    let end = |side: f64| BASE + width * (place + side * ramp);
    Scene::new(field(width), transfer(&[(end(-0.5), [1.0; 3], 0.03), (end(0.5), [1.0; 3], 0.3)], 1.0))
}

/// All engines, and all ways to classify; how far they may be from the truth at a jump.
fn fine_casters() -> [(&'static str, RayCaster, f64); 7] {
    let uniform = RayCaster::uniform(0.05);
    // A jump is known to one step: half as much again as was measured, the same as with exact classification.
    let one_step = 0.0105;
    [
        ("uniform", uniform.clone(), one_step),
        ("without packets", RayCaster { vector: Vector::Off, ..uniform.clone() }, one_step),
        ("f64", RayCaster { precision: Precision::F64, ..uniform.clone() }, one_step),
        ("evaluated", RayCaster { transfer_lookup: TransferLookup::Exact, ..uniform.clone() }, one_step),
        ("exact", RayCaster::exact(0.05), one_step),
        ("cells", RayCaster { traversal: Traversal::Cells, ..uniform.clone() }, one_step),
        ("linear", RayCaster { rule: Rule::Linear, ..uniform }, 3e-4),
    ]
}

#[test]
fn jumps_are_where_they_are() {
    for width in WIDTHS {
        for place in PLACES {
            let scene = scene(width, place, 0.0);
            let view = oblique(&scene, 5);
            let want = truth(&scene, &view);
            let check = |name: &str, caster: &RayCaster, bound: f64| {
                let error = max_error(&render(caster, &scene, &view).frame, &want);
                assert!(error < bound, "{name}, width {width}, jump at {place}: {error}");
            };
            for (name, caster, bound) in fine_casters() {
                check(name, &caster, bound);
            }
            // Its steps are longer: 0.029 in a field from 1000 to 2000, too.
            check("default", &RayCaster::default(), 0.043);
        }
    }
}

#[test]
fn ramps_are_whole() {
    for width in WIDTHS {
        for place in PLACES {
            let scene = scene(width, place, 0.3);
            let view = oblique(&scene, 5);
            let want = truth(&scene, &view);
            for (name, caster, _) in fine_casters() {
                let error = max_error(&render(&caster, &scene, &view).frame, &want);
                assert!(error < 1.5e-4, "{name}, width {width}, ramp at {place}: {error}");
            }
            let error = max_error(&render(&RayCaster::default(), &scene, &view).frame, &want);
            assert!(error < 1.1e-2, "default, width {width}, ramp at {place}: {error}");
        }
    }
}
