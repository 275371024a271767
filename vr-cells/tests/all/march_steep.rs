//! The marcher against the reference where extinction is steep: opaque peaks and jumps, seen from all sides and along the mesh's silhouette.

use crate::meshes::errors;
#[allow(dead_code, reason = "each test file compiles the whole module")]
use glam::DVec3;
use vr_cells::CellMarcher;
use vr_core::cells::{CellMesh, CellValues};
use vr_core::phantom::{MarschnerLobb, Phantom};
use vr_core::{
    Calibration, Camera, ControlPoint, Filter, GridVolume, OpacityRule, Placement, Projection, Scene, TransferFunction,
    UniformGrid, View,
};
use vr_physics::check::strategies::uneven_cubes;

/// The bound of the documentation.
const EXACT: f64 = 1e-5;

/// Largest error of the marcher against the reference, less its bound.
fn error(scene: &Scene, view: &View) -> f64 {
    errors(&CellMarcher::default(), scene, view).0
}

/// The signal of Marschner & Lobb on `side`³ points, as bytes, six cells a cube.
fn signal(side: usize) -> CellMesh {
    let values: Vec<u8> = (0..side * side * side)
        .map(|i| {
            let at = [i % side, i / side % side, i / (side * side)].map(|x| x as f64 * 2.0 / (side - 1) as f64 - 1.0);
            (255.0 * MarschnerLobb::default().value(DVec3::from_array(at))).round().clamp(0.0, 255.0) as u8
        })
        .collect();
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let grid = UniformGrid::new([side; 3], values, placement, Calibration::default()).unwrap();
    CellMesh::of_grid(&GridVolume::new(grid.into(), Filter::Trilinear)).unwrap()
}

/// Rays that cut through a corner of the mesh pass a short way of high extinction: errors of either end count, and nothing hides them.
#[test]
fn a_nearly_opaque_signal_is_exact_along_its_silhouette() {
    let side = 21;
    let p = ControlPoint::new;
    let points = vec![
        p(0.0, [0.0; 3], 0.0),
        p(115.0, [0.2, 0.4, 0.85], 0.0),
        p(135.0, [0.35, 0.65, 0.95], 0.85),
        p(200.0, [0.95, 0.8, 0.35], 0.9),
        p(255.0, [1.0, 0.45, 0.2], 0.95),
    ];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 0.125).unwrap();
    let scene = Scene::new(signal(side).into(), transfer);
    let middle = DVec3::splat(0.5 * (side - 1) as f64);
    for projection in [Projection::Orthographic { height: 30.0 }, Projection::Perspective { fov: 30.0 }] {
        let eye = middle + DVec3::new(0.47, -0.82, 0.34).normalize() * 60.0;
        let camera = Camera { eye, target: middle, up: DVec3::Z, projection };
        let error = error(&scene, &View::new(camera, [160; 2]));
        assert!(error < EXACT, "{projection:?}: {error}");
    }
}

/// Numbers in [0, 1) from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// Peaks, ramps and jumps of any height, up to an optical depth of 100 across a cell.
fn steep(random: &mut Random, rule: OpacityRule, unit: f64, width: f64) -> TransferFunction {
    let mut points = Vec::new();
    let mut value = 1e3 + 0.3 * random.next();
    for i in 0..6 {
        let opacity = if random.next() < 0.4 { 0.0 } else { 0.98 * random.next() };
        points.push(ControlPoint::new(value, [random.next(), random.next(), random.next()], opacity));
        // Every third point is a jump.
        if i % 3 != 2 {
            value += width * (0.5 + 0.5 * random.next());
        }
    }
    TransferFunction::new(points, rule, unit).unwrap()
}

#[test]
fn steep_transfer_functions_are_exact_on_meshes_with_holes() {
    for seed in 0..24 {
        let mut random = Random(seed);
        let n = 2 + seed as usize % 5;
        let (vertices, cells) = uneven_cubes([n; 3], 0.25, seed);
        let cells = cells.into_iter().filter(|_| random.next() < 0.9).collect();
        let values = vertices.iter().map(|_| 1e3 + random.next()).collect();
        let mesh = CellMesh::new(vertices, cells, CellValues::Vertices(values)).unwrap();
        let rule = if seed % 2 == 0 { OpacityRule::Extinction } else { OpacityRule::Power };
        let (unit, width) = ([0.1, 0.03, 0.01][seed as usize % 3], [0.3, 0.03][seed as usize / 3 % 2]);
        let scene = Scene::new(mesh.into(), steep(&mut random, rule, unit, width));
        let fov = (seed % 4 == 0).then_some(10.0 + 60.0 * random.next());
        let (yaw, pitch) = (360.0 * random.next(), 160.0 * random.next() - 80.0);
        let view = View::new(Camera::framing(scene.volume.bounds(), yaw, pitch, fov), [61, 60]);
        let error = error(&scene, &view);
        assert!(error < EXACT, "{seed}: {error}");
    }
}
