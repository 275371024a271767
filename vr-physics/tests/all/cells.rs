//! Meshes of cells: closed forms, a function of the same values, and brute force through the field's values alone.

use crate::brute::{OPERATORS, agrees_with_brute_force, same_under_every_operator, transfer, view, waves};
use glam::DVec3;
use vr_core::cells::{CellMesh, CellValues};
use vr_core::field::FunctionField;
use vr_core::{Compositing, ControlPoint, OpacityRule, Ray, Scene, Shading, TransferFunction, Volume};
use vr_physics::Reference;
use vr_physics::check::strategies::uneven_cubes;

/// n³ cubes of six cells each, over the unit cube; inner vertices are moved by up to `jitter` of a step.
fn mesh(n: usize, jitter: f64, value: impl Fn(DVec3) -> f64) -> CellMesh {
    let (moved, cells) = uneven_cubes([n; 3], jitter, 1);
    let values = moved.iter().map(|&v| value(v)).collect();
    CellMesh::new(moved, cells, CellValues::Vertices(values)).unwrap()
}

/// The slab on which a ray caster of another program gives 0.35 to 0.88, for rays run along the faces that cells share: 1 − e^(−½) everywhere.
#[test]
fn a_constant_slab_is_met_along_shared_faces() {
    let mesh = mesh(8, 0.0, |_| 1.0);
    let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
    let scene = Scene::new(mesh.into(), TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap());
    let any = view(1);
    let exact = 1.0 - (-0.5f64).exp();
    for direction in [DVec3::X, DVec3::Y, DVec3::Z] {
        let [across, up] =
            if direction == DVec3::Z { [DVec3::X, DVec3::Y] } else { [DVec3::Z, direction.cross(DVec3::Z).abs()] };
        for i in 1..16 {
            for j in 1..16 {
                let at = across * (f64::from(i) / 16.0) + up * (f64::from(j) / 16.0);
                let ray = Ray { origin: at - direction * 5.0, direction };
                let solved = Reference::default().transport(&scene, &any, &ray).unwrap().expect("it meets the slab");
                let off = (1.0 - solved.transmittance() - exact).abs();
                assert!(off < 1e-12 && solved.certainty.value() < 1e-12, "{ray:?}: {off}, {:?}", solved.certainty);
            }
        }
    }
}

/// A mesh of a linear function is that function, under every operator.
#[test]
fn a_linear_field_is_its_function() {
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = move |p: DVec3| 0.2 + slope.dot(p);
    let function = FunctionField::new((DVec3::ZERO, DVec3::ONE), value).unwrap().with_lipschitz(slope.length());
    let scene = |volume: Volume| Scene::new(volume, transfer(0.2));
    let (a, b) = (scene(mesh(4, 0.2, value).into()), scene(function.into()));
    same_under_every_operator([&a, &b], 8, 1e-9, 1e-8);
}

/// Waves on a mesh of uneven cells, against many samples of its values.
#[test]
fn every_operator_agrees_with_brute_force() {
    let mesh = mesh(4, 0.25, waves);
    for (compositing, shading) in OPERATORS.map(|o| (o, false)).into_iter().chain([(Compositing::Over, true)]) {
        let shading = shading.then(Shading::default).map(Into::into);
        let scene = Scene { compositing, shading, ..Scene::new(mesh.clone().into(), transfer(0.2)) };
        agrees_with_brute_force(&scene, 1e-3);
    }
}
