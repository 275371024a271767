//! Volumes that are no grids, through the seam alone: functions and scattered points, against the reference.

use std::sync::Arc;

use glam::DVec3;
use vr_core::field::FunctionField;
use vr_core::phantom::{self, Phantom};
use vr_core::{
    Camera, Compositing, Control, Feature, Light, Model, PointKernel, PointSet, RenderError, Renderer, Scene, Shading,
    TransferFunction, Unsupported, View, Volume,
};
use vr_physics::Reference;
use vr_raycast::{RayCaster, Step};

use crate::common::{self, framed_error};

fn waves() -> FunctionField {
    let value = |p: DVec3| 0.5 + 0.5 * (4.0 * p.x).sin() * (3.0 * p.y).cos() * (2.0 * p.z + 0.3).sin();
    let slope = |p: DVec3| {
        let ((sx, cx), (sy, cy), (sz, cz)) =
            ((4.0 * p.x).sin_cos(), (3.0 * p.y).sin_cos(), (2.0 * p.z + 0.3).sin_cos());
        0.5 * DVec3::new(4.0 * cx * cy * sz, -3.0 * sx * sy * sz, 2.0 * sx * cy * cz)
    };
    FunctionField::new((DVec3::NEG_ONE, DVec3::new(1.0, 0.7, 1.2)), value).unwrap().with_gradient(slope)
}

fn transfer() -> TransferFunction {
    common::transfer(&[(0.2, [0.1, 0.3, 0.9], 0.0), (0.6, [0.9, 0.7, 0.2], 0.2), (1.0, [1.0; 3], 0.5)], 0.1)
}

/// The midpoint rule is of order 2: half the step, a quarter of the error.
#[test]
fn functions_converge_to_the_reference() {
    let scene = Scene::new(Volume::from(waves()), transfer());
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..scene.clone() };
    for scene in [scene, shaded] {
        for fov in [None, Some(40.0)] {
            let [coarse, fine] = [2.0, 0.5].map(|step| framed_error(&scene, &RayCaster::uniform(step), fov));
            assert!(fine.rmse < 1e-4 && fine.rmse < coarse.rmse / 8.0, "{coarse}, then {fine}");
        }
    }
}

#[test]
fn functions_are_drawn_under_every_operator() {
    let scene = Scene::new(Volume::from(waves()), transfer());
    let operators = [
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::Average,
        Compositing::First { threshold: 0.7 },
        Compositing::Accumulate { level: 0.5 },
    ];
    for compositing in operators {
        let m = framed_error(
            &Scene { compositing, ..scene.clone() },
            &RayCaster { step: Step::Uniform(0.2), ..RayCaster::default() },
            None,
        );
        // A first point is found to 10⁻⁹ of a step, but for a ray that touches the surface.
        assert!(m.rmse < 3e-4, "{}: {m}", compositing.name());
    }
}

/// A phantom as the function that it is, and its samples on finer and finer grids: the trilinear field is of order 2 in the spacing.
#[test]
fn phantoms_without_samples_are_the_limit_of_those_with() {
    let field = FunctionField::of_phantom(Arc::from(phantom::by_name("hydrogen").unwrap()));
    let scene = phantom::Hydrogen.scene(33).unwrap();
    let function = Scene { volume: field.into(), ..scene.clone() };
    let m = framed_error(&function, &RayCaster::default(), None);
    assert!(m.rmse < 1e-4, "{m}");
}

#[test]
fn points_are_a_field_like_any_other() {
    let positions = vec![DVec3::ZERO, DVec3::new(0.8, 0.2, -0.1), DVec3::new(-0.3, 0.9, 0.4)];
    let points = PointSet::new(positions, vec![1.0; 3], vec![1.0; 3], vec![1.0, 0.7, 0.4], PointKernel::CubicSpline);
    let scene = Scene::new(points.unwrap().into(), transfer());
    let m = framed_error(&scene, &RayCaster { step: Step::Uniform(0.1), ..RayCaster::default() }, Some(30.0));
    assert!(m.rmse < 1e-3, "{m}");
}

/// Shaded by the sum of the kernels' gradients, plain and with opacity by its length: the midpoint rule is of order 2, and of 1 where supports end.
#[test]
fn shaded_points_converge_to_the_reference() {
    for kernel in PointKernel::ALL {
        let positions = vec![DVec3::ZERO, DVec3::new(0.8, 0.2, -0.1), DVec3::new(-0.3, 0.9, 0.4)];
        let points = PointSet::new(positions, vec![1.0; 3], vec![1.0; 3], vec![1.0, 0.7, 0.4], kernel).unwrap();
        let plain = Scene::new(points.into(), transfer());
        for gradient_opacity in [vec![], vec![(0.0, 0.1), (1.0, 1.0)]] {
            let shading = Some(Arc::new(Shading { gradient_opacity, ..Shading::default() }));
            let scene = Scene { shading, lights: vec![Light::default()], ..plain.clone() };
            let errors = [0.4, 0.1, 0.025].map(|step| framed_error(&scene, &RayCaster::uniform(step), Some(30.0)).rmse);
            println!("{kernel}: {errors:?}");
            assert!(errors[2] < 3e-4 && errors[2] < errors[0] / 8.0, "{kernel}: {errors:?}");
        }
    }
    let positions = vec![DVec3::ZERO, DVec3::new(0.8, 0.2, -0.1)];
    let points =
        PointSet::new(positions, vec![1.0; 2], vec![1.0; 2], vec![1.0, 0.7], PointKernel::CubicSpline).unwrap();
    let first = Scene {
        compositing: Compositing::First { threshold: 0.5 },
        shading: Some(Arc::new(Shading::default())),
        lights: vec![Light::default()],
        ..Scene::new(points.into(), transfer())
    };
    let m = framed_error(&first, &RayCaster::uniform(0.1), None);
    assert!(m.rmse < 1e-3, "{m}");
}

#[test]
fn what_a_function_does_not_have_is_refused() {
    let plain = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| p.x).unwrap();
    let scene = Scene::new(Volume::from(plain), transfer());
    let refused = |caster: RayCaster, scene: &Scene| match caster.supports(scene, None) {
        Err(RenderError::Unsupported(Unsupported { feature, .. })) => Some(feature),
        other => other.map(|()| None).unwrap(),
    };
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..scene.clone() };
    assert_eq!(refused(RayCaster::default(), &scene), None);
    assert_eq!(refused(RayCaster::default(), &shaded), Some(Feature::Shading));
    assert_eq!(
        refused(RayCaster { step: Step::Local { error: 1e-3 }, ..RayCaster::default() }, &scene),
        Some(Feature::Setting)
    );
}

/// A function keeps a promise as far as it says how fast it changes; of one that does not, no ray is proven.
#[test]
fn promises_need_a_bound_of_the_slope() {
    let function =
        || FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| 0.5 + 0.2 * (3.0 * p.x + p.y).sin()).unwrap();
    let caster = RayCaster { step: Step::ErrorBound(1e-2), ..RayCaster::default() };
    for (field, proven) in [(function().with_lipschitz(0.7), true), (function(), false)] {
        let scene = Scene::new(Volume::from(field), transfer());
        let view = View::new(Camera::framing(scene.bounds(), 20.0, 30.0, None), [12, 12]);
        let picture = common::render(&caster, &scene, &view);
        let counts = picture.stats.counts;
        assert_eq!(counts.unbounded, if proven { 0 } else { counts.rays }, "{counts:?}");
        let truth = Reference::default().solve(&scene, &view, &Model::Canonical, &Control::default()).unwrap();
        for (got, want) in picture.frame.pixels().iter().zip(&truth.pixels) {
            let off = (0..4).map(|c| (f64::from(got[c]) - want.rgba[c]).abs()).fold(0.0, f64::max);
            assert!(off <= 1e-2, "{off}");
        }
    }
}
