//! Cases whose difficulty lies in cells that are not equal boxes.

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrSampling};
use vr_core::cells::CellValues;
use vr_core::rectilinear::Centering;
use vr_core::{AmrGrid, CellMesh, GridVolume, RectilinearGrid, Scene, View, Volume};

use super::{float_volume, oblique, transfer};

/// A front between 0 and 1, a cell of level 0 thick, oblique to all axes: in cells of level 2 on one side of the box, in cells of level 0 on the other.
pub(super) fn level_boundary() -> (Scene, View) {
    let across = |p: DVec3| p.dot(DVec3::new(0.48, 0.64, 0.6)) - 0.8;
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 0.25,
        blocks: [4; 3],
        block_cells: [4; 3],
        ratios: vec![[2; 3]; 2],
        centring: AmrCentring::Cells,
    };
    let refined = |low: DVec3, high: DVec3, level: usize| {
        let is_near = across(0.5 * (low + high)).abs() < 0.5 * (high - low).length();
        is_near && high.x <= [0.5, 0.25][level]
    };
    let value = |p: DVec3| (0.5 + 0.5 * libm::tanh(30.0 * across(p))) as f32;
    let mesh = AmrGrid::refining(&sampling, value, refined).expect("a valid sampling");
    let points = [
        (0.2, [0.1, 0.3, 0.9], 0.0),
        (0.5, [1.0, 0.7, 0.2], 0.9),
        (0.8, [0.9, 0.2, 0.1], 0.1),
        (1.0, [0.6, 0.1, 0.1], 0.02),
    ];
    let volume = Volume::from(mesh);
    let view = oblique(&volume, 24);
    (Scene::new(volume, transfer(&points, 1.0 / 16.0)), view)
}

/// A layer at z = 0 as boundary layers have them: half a unit of optical depth in each decade of the distance from it, each in its own colour.
pub(super) fn uneven_axes() -> (Scene, View) {
    let decades: Vec<f64> = (0..=8).map(|k| libm::pow(10.0, -4.0 + 0.5 * f64::from(k))).collect();
    let z: Vec<f64> = [0.0].into_iter().chain(decades).collect();
    // Graded from both sides, 1 to 50.
    let across: Vec<f64> =
        (-6i32..=6).map(|k| 0.5 + f64::from(k.signum()) * 0.5 * libm::pow(1.9, f64::from(k.abs() - 6))).collect();
    let mut values = Vec::new();
    for &z in &z {
        for &y in &across {
            let decade = |x: f64| {
                let bent = z * (1.0 + 0.5 * libm::sin(4.0 * x + 3.0 * y));
                1.0 - 0.25 * (libm::log10(bent.max(1e-4)) + 4.0)
            };
            values.extend(across.iter().map(|&x| decade(x) as f32));
        }
    }
    let axes = [across.clone(), across, z];
    let grid = RectilinearGrid::new(axes, values, Centering::Points).expect("a valid grid");
    // Each decade is ten times as thin as the next.
    let points = [
        (0.0, [0.2, 0.2, 0.9], 2e-5),
        (0.25, [0.1, 0.8, 0.9], 2e-4),
        (0.5, [0.2, 0.9, 0.2], 2e-3),
        (0.75, [0.9, 0.8, 0.1], 2e-2),
        (1.0, [1.0, 0.2, 0.1], 0.2),
    ];
    let volume = Volume::from(grid);
    let view = oblique(&volume, 32);
    (Scene::new(volume, transfer(&points, 1e-4)), view)
}

/// Four layers of cubes, six cells each, bent as one; the third is 10⁻⁶ thick, and carries nearly the whole range of values.
pub(super) fn slivers() -> (Scene, View) {
    const HEIGHTS: [f64; 5] = [0.0, 0.3, 0.5, 0.500_001, 1.0];
    const VALUES: [f64; 5] = [0.1, 0.15, 0.2, 0.9, 0.6];
    let Volume::Grid(cubes) = float_volume([5; 3], [1.0; 3], |_, _, _| 0.0) else { unreachable!("a grid") };
    let cubes = CellMesh::of_grid(&GridVolume::clone(&cubes)).expect("a small mesh");
    let layer = |v: &DVec3| v.z as usize;
    let place = |v: &DVec3| {
        let (x, y) = (0.25 * v.x, 0.25 * v.y);
        // Vertices within are moved, so that no two cubes are alike: both sides of the thin layer in the same way, or they would cross.
        let inner = |t: f64| t * (1.0 - t);
        let aside = 0.3 * inner(x) * inner(y) * libm::sin(7.0 * x + 11.0 * y + 6.0 * HEIGHTS[layer(v)]);
        DVec3::new(x + aside, y - aside, HEIGHTS[layer(v)] + 0.1 * libm::sin(3.0 * x + 2.0 * y))
    };
    let values = cubes.vertices().iter().map(|v| VALUES[layer(v)]).collect();
    let vertices = cubes.vertices().iter().map(place).collect();
    let mesh = CellMesh::new(vertices, cubes.cells().to_vec(), CellValues::Vertices(values)).expect("a valid mesh");
    let points = [
        (0.0, [0.1, 0.2, 0.9], 0.05),
        (0.3, [0.2, 0.8, 0.4], 0.2),
        (0.7, [1.0, 0.8, 0.3], 0.1),
        (1.0, [1.0, 0.3, 0.1], 0.7),
    ];
    let volume = Volume::from(mesh);
    let view = oblique(&volume, 32);
    (Scene::new(volume, transfer(&points, 0.25)), view)
}
