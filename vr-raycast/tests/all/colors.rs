//! Grids whose voxels have colours, against the reference.

use std::sync::Arc;

use crate::common::{oblique, oblique_error, render};
use vr_core::{
    ColorGrid, Compositing, ControlPoint, Feature, Filter, OpacityRule, Placement, RenderError, Renderer, Scene,
    Shading, TransferFunction, Unsupported,
};
use vr_raycast::{CompositingOrder, Precision, RayCaster, Rule, Step};

/// A ball of smooth values in which the colours alternate from place to place.
fn scene(filter: Filter) -> Scene {
    let dims = [17, 15, 16];
    let voxels: Vec<u8> = (0..17 * 15 * 16)
        .flat_map(|i| {
            let [x, y, z] =
                [(i % 17) as f64 / 8.0 - 1.0, (i / 17 % 15) as f64 / 7.0 - 1.0, (i / 255) as f64 / 7.5 - 1.0];
            let opacity = 255.0 * (1.0 - 0.7 * (x * x + y * y + z * z)).clamp(0.0, 1.0);
            let wave = |k: f64| 127.0 + 120.0 * (k * x + 5.0 * y - 4.0 * z).sin();
            [wave(3.0), wave(7.0), wave(-5.0), opacity].map(|c| c as u8)
        })
        .collect();
    let colors = ColorGrid::from_components(dims, &voxels, 4, Placement::from_spacing([1.0, 1.1, 0.9]).unwrap());
    let points = vec![ControlPoint::new(20.0, [1.0; 3], 0.0), ControlPoint::new(255.0, [1.0, 0.9, 0.8], 0.4)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    Scene::new(colors.unwrap().into(), transfer).with_filter(filter)
}

/// The midpoint rule is of order 2: a quarter of the step, a sixteenth of the error.
#[test]
fn uniform_steps_converge_to_the_reference() {
    let plain = scene(Filter::Trilinear);
    let shading = Shading { gradient_opacity: vec![(0.0, 0.6), (30.0, 1.0)], ..Shading::default() };
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..plain.clone() };
    let modulated = Scene { shading: Some(Arc::new(shading)), ..plain.clone() };
    for (name, scene) in [("plain", plain), ("shaded", shaded), ("modulated", modulated)] {
        for exact in [false, true] {
            let caster = |step| if exact { RayCaster::exact(step) } else { RayCaster::uniform(step) };
            let [coarse, fine] = [0.8, 0.2].map(|step| oblique_error(&scene, &caster(step)));
            // Termination and the table leave 10⁻⁴.
            assert!(fine.rmse < 5e-4 && fine.rmse < coarse.rmse / 8.0 + 5e-5, "{name}: {coarse}, then {fine}");
        }
    }
}

#[test]
fn the_default_is_near_the_reference() {
    for filter in Filter::ALL {
        let plain = scene(filter);
        let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..plain.clone() };
        for scene in [plain, shaded] {
            let m = oblique_error(&scene, &RayCaster::default());
            println!("{filter}, shaded {}: {m}", scene.shading.is_some());
            // At most 2.8e-5 was measured; steps aim at 5e-4 in their own right.
            assert!(m.rmse < 1e-4, "{filter}: {m}");
        }
    }
}

#[test]
fn every_operator_has_the_colour_of_the_place() {
    let operators = [
        (Compositing::Maximum, 2e-2),
        (Compositing::Average, 3e-4),
        (Compositing::First { threshold: 150.0 }, 3e-4),
        (Compositing::Accumulate { level: 0.5 }, 1e-3),
    ];
    for (compositing, most) in operators {
        let scene = Scene { compositing, ..scene(Filter::Trilinear) };
        // A smooth extreme's place is known to a step, and the colour changes by a tenth on that.
        let m = oblique_error(&scene, &RayCaster::uniform(0.1));
        assert!(m.rmse < most, "{}: {m}", compositing.name());
    }
    let backwards = RayCaster { order: CompositingOrder::BackToFront, ..RayCaster::uniform(0.1) };
    let m = oblique_error(&scene(Filter::Trilinear), &backwards);
    assert!(m.rmse < 3e-4, "back to front: {m}");
}

#[test]
fn an_emission_has_the_colour_of_the_place() {
    let scene = scene(Filter::Trilinear);
    let points = [(20.0, 0.0), (255.0, 0.2)].map(|(value, e)| ControlPoint {
        emission: Some([e, 0.5 * e, e]),
        ..ControlPoint::new(value, [1.0; 3], 0.3 * e)
    });
    let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
    let m = oblique_error(&Scene { transfer: Arc::new(transfer), ..scene }, &RayCaster::default());
    assert!(m.rmse < 1e-3, "{m}");
}

/// White voxels leave every bit as it is without them.
#[test]
fn white_is_no_colour() {
    let colored = scene(Filter::Trilinear);
    let colors = colored.volume.colors().unwrap();
    let white = [(); 3].map(|()| vec![ColorGrid::WHITE; 17 * 15 * 16]);
    let white = ColorGrid::new(colors.values().as_ref().clone(), white).unwrap();
    let grid = Scene { volume: vr_core::Volume::Grid(Arc::clone(colors.values())), ..colored.clone() };
    let white = Scene { volume: white.into(), ..colored };
    let caster = RayCaster { precision: Precision::F64, ..RayCaster::uniform(0.3) };
    let view = oblique(&grid, 24);
    let [a, b] = [&grid, &white].map(|scene| render(&caster, scene, &view).frame);
    assert_eq!(a.pixels(), b.pixels());
}

#[test]
fn what_cannot_be_done_is_refused() {
    let refused = |caster: RayCaster| match caster.supports(&scene(Filter::Trilinear), None) {
        Err(RenderError::Unsupported(Unsupported { feature, what, .. })) => (feature, what),
        other => panic!("{other:?}"),
    };
    let (feature, what) = refused(RayCaster { step: Step::ErrorBound(1e-3), ..RayCaster::default() });
    assert_eq!(feature, Feature::MaxError);
    assert!(what.contains("colours"), "{what}");
    let (feature, _) = refused(RayCaster { rule: Rule::Quadratic, ..RayCaster::default() });
    assert_eq!(feature, Feature::Setting);
}
