//! Adaptive meshes: a uniform grid as one, linear data, and brute force through the field's values alone.

use crate::brute::{OPERATORS, agrees_with_brute_force, same_under_every_operator, transfer, view, waves};
use glam::DVec3;
use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid, AmrSampling};
use vr_core::field::FunctionField;
use vr_core::{
    Calibration, Compositing, ControlPoint, OpacityRule, Placement, Ray, Scene, Shading, TransferFunction, UniformGrid,
    Volume,
};
use vr_physics::Reference;

const CENTRINGS: [AmrCentring; 2] = [AmrCentring::Cells, AmrCentring::Points];

/// Three levels over the unit cube and a little more: the middle is refined, and of that one corner again.
fn mesh(centring: AmrCentring, value: impl Fn(DVec3) -> f64) -> AmrGrid {
    let sampling = AmrSampling {
        origin: DVec3::splat(-0.1),
        edge: 0.3,
        blocks: [4; 3],
        block_cells: [2; 3],
        ratios: vec![[2; 3]; 2],
        centring,
    };
    let near = |low: DVec3, high: DVec3, level: usize| {
        let middle = 0.5 * (low + high);
        [(middle - 0.5).abs().max_element() < 0.3, middle.max_element() < 0.5][level]
    };
    AmrGrid::refining(&sampling, |p| value(p) as f32, near).unwrap()
}

/// A mesh of one level has the pixels of the uniform grid, shaded or not, under every operator.
#[test]
fn one_level_has_the_pixels_of_a_uniform_grid() {
    let (n, step) = (6, 1.0 / 6.0);
    for centring in CENTRINGS {
        let first = if centring == AmrCentring::Cells { 0.5 * step } else { 0.0 };
        let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / (n * n)) as f64) * step + first;
        let values: Vec<f32> = (0..n * n * n).map(|i| waves(at(i)) as f32).collect();
        let placement = Placement::new(DVec3::splat(first), glam::DMat3::from_diagonal(DVec3::splat(step))).unwrap();
        let uniform = UniformGrid::new([n; 3], values.clone(), placement, Calibration::default()).unwrap();
        let uniform = Volume::from(uniform);
        let block = AmrBlock { level: 0, first: [0; 3], dims: [n; 3], values };
        let grid = AmrGrid::new(DVec3::ZERO, DVec3::splat(step), vec![], vec![block], centring).unwrap();
        for shading in [None, Some(Shading::default().into())] {
            let [a, b] = [uniform.clone(), grid.clone().into()]
                .map(|volume| Scene { shading: shading.clone(), ..Scene::new(volume, transfer(0.2)) });
            same_under_every_operator([&a, &b], 8, 1e-12, 1e-6);
        }
    }
}

/// A mesh of a linear function is that function, under every operator, to the rounding of f32.
#[test]
fn a_linear_field_is_its_function() {
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = move |p: DVec3| 0.2 + slope.dot(p);
    for centring in CENTRINGS {
        let grid = mesh(centring, value);
        let function = FunctionField::new(grid.bounds(), value).unwrap().with_lipschitz(slope.length());
        let [a, b] = [grid.into(), function.into()].map(|volume: Volume| Scene::new(volume, transfer(0.2)));
        // The rim of the mesh is coarse everywhere, so that both boxes are full. Values are rounded to f32.
        same_under_every_operator([&a, &b], 8, 1e-6, 1e-7);
    }
}

/// Waves on three levels, against many samples of the values.
#[test]
fn every_operator_agrees_with_brute_force() {
    for centring in CENTRINGS {
        let grid = mesh(centring, waves);
        for (compositing, shading) in OPERATORS.map(|o| (o, false)).into_iter().chain([(Compositing::Over, true)]) {
            let shading = shading.then(Shading::default).map(Into::into);
            let scene = Scene { compositing, shading, ..Scene::new(grid.clone().into(), transfer(0.2)) };
            agrees_with_brute_force(&scene, 1e-3);
        }
    }
}

/// Cells without a value, and rays along the faces of cells, which graze vacuum.
#[test]
fn holes_are_vacuum() {
    let block = |hole: bool| {
        let mut values = vec![1.0; 216];
        values[3 * 36 + 3 * 6 + 3] = if hole { f32::NAN } else { 1.0 };
        AmrBlock { level: 0, first: [0; 3], dims: [6; 3], values }
    };
    let scene = |hole: bool| {
        let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![], vec![block(hole)], AmrCentring::Cells).unwrap();
        let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
        Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap())
    };
    let depth = |scene: &Scene, y: f64| {
        let ray = Ray { origin: DVec3::new(-9.0, y, 3.3), direction: DVec3::X };
        let solved = Reference::default().transport(scene, &view(1), &ray).unwrap().expect("it meets the box");
        -solved.transmittance().ln()
    };
    // From the first middle to the last are 5 steps; the hole takes one on both sides of its middle.
    for (y, hole, expected) in
        [(3.3, false, 2.5), (3.3, true, 1.5), (2.7, true, 1.5), (2.2, true, 2.5), (5.2, true, 2.5)]
    {
        let found = depth(&scene(hole), y);
        assert!((found - expected).abs() < 1e-9, "{y} {hole}: {found}");
    }
}
