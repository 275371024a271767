//! Two-dimensional transfer functions, against the reference.

use std::sync::Arc;

use crate::common::{oblique, oblique_error, render};
use vr_core::{
    Compositing, ControlPoint, Feature, GradientMethod, OpacityRule, Placement, RenderError, Renderer, Scene, Shading,
    TransferFunction, UniformGrid, Unsupported, Volume,
};
use vr_raycast::{CompositingOrder, RayCaster, Rule, Step};

/// A ball of 1 in a shell of ½ in nothing, as blurred as a scan is.
fn onion() -> Volume {
    const N: usize = 24;
    let soft = |r: f64, edge: f64| 1.0 / (1.0 + ((r - edge) / 0.05).exp());
    let samples: Vec<f32> = (0..N * N * N)
        .map(|i| {
            let [x, y, z] = [i % N, i / N % N, i / N / N].map(|k| 2.0 * k as f64 / (N - 1) as f64 - 1.0);
            let r = (x * x + y * y + z * z).sqrt();
            (0.5 * soft(r, 0.8) + 0.5 * soft(r, 0.45)) as f32
        })
        .collect();
    let placement = Placement::from_spacing([1.0, 1.1, 0.9]).unwrap();
    UniformGrid::new([N; 3], samples, placement, Default::default()).unwrap().into()
}

/// Boundaries by their middle values, orange outside and blue inside; what is flat is faintly grey or clear.
fn boundaries(emits: bool) -> TransferFunction {
    let point = |value, color: [f64; 3], opacity| ControlPoint {
        emission: emits.then(|| color.map(|c| 0.2 * c * opacity)),
        ..ControlPoint::new(value, color, opacity)
    };
    let flat = vec![point(0.3, [0.5; 3], 0.0), point(0.6, [0.5; 3], 0.03), point(1.0, [0.5; 3], 0.0)];
    let steep = vec![
        point(0.05, [1.0, 0.5, 0.1], 0.0),
        point(0.25, [1.0, 0.5, 0.1], 0.35),
        point(0.5, [1.0, 0.5, 0.1], 0.0),
        point(0.5, [0.1, 0.4, 1.0], 0.0),
        point(0.75, [0.1, 0.4, 1.0], 0.7),
        point(0.95, [0.1, 0.4, 1.0], 0.0),
    ];
    TransferFunction::of_rows(vec![(0.02, flat), (0.15, steep)], OpacityRule::Power, 1.0).unwrap()
}

fn scenes() -> Vec<(&'static str, Scene)> {
    let plain = Scene::new(onion(), boundaries(false));
    let with = |shading: Shading| Scene { shading: Some(Arc::new(shading)), ..plain.clone() };
    vec![
        ("shaded", with(Shading::default())),
        ("emitting", Scene { transfer: Arc::new(boundaries(true)), ..plain.clone() }),
        ("accumulated", Scene { compositing: Compositing::Accumulate { level: 0.6 }, ..plain.clone() }),
        ("plain", plain),
    ]
}

/// The midpoint rule is of order 2: a quarter of the step, a sixteenth of the error.
#[test]
fn uniform_steps_converge_to_the_reference() {
    for (name, scene) in scenes() {
        for exact in [false, true] {
            let caster = |step| if exact { RayCaster::exact(step) } else { RayCaster::uniform(step) };
            let [coarse, fine] = [0.6, 0.15].map(|step| oblique_error(&scene, &caster(step)));
            println!("{name}, exact {exact}: {coarse}, then {fine}");
            assert!(fine.rmse < 5e-4 && fine.rmse < coarse.rmse / 6.0 + 5e-5, "{name}: {coarse}, then {fine}");
        }
    }
}

/// The gradient of a trilinear field itself jumps at the faces of cells, and with it the row: order 1, an eighth of the step for an eighth of the error.
#[test]
fn gradients_that_jump_converge_more_slowly() {
    let shading = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let scene = Scene { shading: Some(Arc::new(shading)), ..Scene::new(onion(), boundaries(false)) };
    let [coarse, fine] = [0.8, 0.1].map(|step| oblique_error(&scene, &RayCaster::exact(step)));
    println!("{coarse}, then {fine}");
    assert!(fine.rmse < coarse.rmse / 3.0, "{coarse}, then {fine}");
}

#[test]
fn the_default_is_near_the_reference() {
    for (name, scene) in scenes() {
        let m = oblique_error(&scene, &RayCaster::default());
        println!("{name}: {m}");
        assert!(m.rmse < Step::ERROR, "{name}: {m}");
    }
}

/// Rows that are all the same are the function by value; only the gradient makes another engine of it.
#[test]
fn rows_that_are_the_same_change_nothing() {
    let points = boundaries(false).rows()[1].transfer.points().to_vec();
    let rows = vec![(0.0, points.clone()), (0.1, points.clone())];
    let rows = TransferFunction::of_rows(rows, OpacityRule::Power, 1.0).unwrap();
    let by_value = Scene::new(onion(), TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
    let by_rows = Scene { transfer: Arc::new(rows), ..by_value.clone() };
    let view = oblique(&by_value, 24);
    let caster = RayCaster::exact(0.5);
    let frames = [&by_value, &by_rows].map(|scene| render(&caster, scene, &view).frame);
    for (a, b) in frames[0].pixels().iter().zip(frames[1].pixels()) {
        // A hundred steps, each rounded otherwise, and once to f32.
        assert!((0..4).all(|c| (a[c] - b[c]).abs() <= 2.0 * f32::EPSILON), "{a:?} {b:?}");
    }
}

#[test]
fn settings_that_know_values_alone_refuse() {
    let scene = Scene::new(onion(), boundaries(false));
    let refused = |caster: RayCaster| match caster.supports(&scene, None) {
        Err(RenderError::Unsupported(Unsupported { feature, what, .. })) => (feature, what),
        other => panic!("{other:?}"),
    };
    for rule in [Rule::Linear, Rule::Quadratic] {
        let (feature, what) = refused(RayCaster { rule, ..RayCaster::default() });
        assert!(feature == Feature::GradientOpacity && what.contains("values alone"), "{what}");
    }
    RayCaster { order: CompositingOrder::BackToFront, ..RayCaster::default() }.supports(&scene, None).unwrap();
}
