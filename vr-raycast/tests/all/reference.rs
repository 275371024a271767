//! Against the reference: every compositing operator, shaded and not, on a smooth scene and on the hard ones.

use std::sync::Arc;

use crate::common::*;
use vr_core::*;
use vr_raycast::RayCaster;

const OPERATORS: [Compositing; 7] = [
    Compositing::Over,
    Compositing::Accumulate { level: 0.6 },
    Compositing::First { threshold: 0.6 },
    Compositing::Average,
    Compositing::Maximum,
    Compositing::Minimum,
    Compositing::First { threshold: 0.1 },
];

/// A field between 0.1 and 0.9 that no ray grazes at 0.6 for long.
fn scene(filter: Filter) -> Scene {
    let field = |x: f64, y: f64, z: f64| 0.5 + 0.2 * (0.45 * x).sin() * (0.35 * y + 0.3).cos() + 0.2 * (0.4 * z).sin();
    let points = [(0.0, [0.2, 0.9, 0.1], 0.02), (0.5, [1.0, 0.4, 0.1], 0.3), (1.0, [0.3, 0.1, 0.9], 0.1)];
    Scene::new(volume([17, 15, 13], field).with_filter(filter), transfer(&points, 1.0))
}

#[test]
fn every_operator_and_filter() {
    for filter in Filter::ALL {
        for shading in
            [None, Some(Arc::new(Shading { gradient_opacity: vec![(0.0, 0.5), (0.1, 1.5)], ..Shading::default() }))]
        {
            for compositing in OPERATORS {
                let scene = Scene { compositing, shading: shading.clone(), ..scene(filter) };
                let view = oblique(&scene, 16);
                let want = truth(&scene, &view);
                let error = |step| max_error(&render(&RayCaster::exact(step), &scene, &view).frame, &want);
                let (coarse, fine) = (error(0.25), error(1.0 / 32.0));
                println!("{filter}, {}, {}: {coarse:.1e}, {fine:.1e}", compositing.name(), shading.is_some());
                // With nearest samples, the ends of every voxel on a ray are known to a step, and a corner of one that the ray
                // cuts more briefly than a step may be missed as the first hit. All else falls with the square.
                let bound = if filter.is_continuous() { 1e-3 } else { 5e-2 };
                assert!(fine <= bound, "{filter} {compositing:?} {fine}");
            }
        }
    }
}

#[test]
fn depths() {
    for compositing in OPERATORS {
        let scene = Scene { compositing, ..scene(Filter::CatmullRom) };
        let view = oblique(&scene, 16);
        let frame = render(&RayCaster::exact(1.0 / 32.0), &scene, &view).frame;
        for (got, want) in frame.depth().unwrap().iter().zip(truth(&scene, &view).depth().unwrap()) {
            // An extreme is flat: it lies within a step or so of where it is found.
            assert!(got == want || (got - want).abs() < 0.1, "{compositing:?}: {got}, expected {want}");
        }
    }
}
