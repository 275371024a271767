//! The hard cases, by name: small scenes, each of which breaks a renderer that takes one thing too lightly.
//!
//! Every renderer is run on all of them, and the error that it may have on each is written down beside it. Volumes are at most
//! 33³ (or 2 × 2 × 4097) voxels and pictures at most 32² pixels, so that all of them together take seconds. They are made from
//! formulas alone: the same numbers on every machine. Most are uniform grids; the last three are volumes that not every renderer draws.

mod lattices;
mod magnitudes;
mod rays;
mod values;
mod voxels;

use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Calibration, Camera, ControlPoint, OpacityRule, Placement, Projection, Scene, TransferFunction, UniformGrid, View,
    Volume,
};

/// A scene that is hard for a reason.
#[derive(Clone, Debug)]
pub struct Case {
    /// Unique name, in kebab case.
    pub name: &'static str,
    /// The difficulty.
    pub summary: &'static str,
    /// The scene.
    pub scene: Scene,
    /// The view of it.
    pub view: View,
}

type Maker = fn() -> (Scene, View);

const TABLE: &[(&str, &str, Maker)] = &[
    (
        "opaque-wall",
        "α = 1 over a positive length: κ is infinite there, light is added once, at the point of entry, and the ray ends",
        values::opaque_wall,
    ),
    (
        "thin-shell",
        "a spike of the transfer function narrower than one cell's range of values: samples step over it",
        values::thin_shell,
    ),
    (
        "marschner-lobb",
        "a signal near the Nyquist frequency on 33³ samples: sharp cubic oscillation inside each trilinear cell",
        voxels::marschner_lobb,
    ),
    (
        "anisotropy",
        "spacing 1:1:50: a step that suits one axis is far too long or too short for another",
        rays::anisotropy,
    ),
    (
        "grazing-rays",
        "rays through the box's edges and nearly parallel to its faces: chords from 0 to the diagonal, from one pixel to the next",
        rays::grazing_rays,
    ),
    (
        "axis-aligned",
        "rays that run exactly in cell faces and cell edges, the faces of the box included",
        rays::axis_aligned,
    ),
    ("camera-inside", "perspective rays that start inside the volume, in an absorbing place", rays::camera_inside),
    ("far-origin", "world origin 10⁶, spacing 10⁻³: positions in f32 would be off by 60 voxels", rays::far_origin),
    ("faint", "κ of 10⁻¹² per unit: 1 − (1 − α) loses everything to rounding", magnitudes::faint),
    (
        "many-faint-steps",
        "4096 unit steps of α = 10⁻⁷: each below half a unit in the last place of f32's 1",
        magnitudes::many_faint_steps,
    ),
    (
        "bright",
        "emission of 10⁶ per unit: absolute thresholds for early termination cut off visible light",
        magnitudes::bright,
    ),
    (
        "missing-voxels",
        "NaN and infinite samples: their cells are vacuum, and nothing of them leaks into a pixel",
        voxels::missing_voxels,
    ),
    (
        "two-samples",
        "two samples along every axis: a single cell, no neighbour for a wider filter or a gradient",
        voxels::two_samples,
    ),
    ("constant", "all samples equal: no range of values to divide by, gradient zero under shading", voxels::constant),
    ("full-u16", "0 to 65535 in u16, with a transfer function that tells neighbouring numbers apart", voxels::full_u16),
    (
        "level-boundary",
        "a steep front of an adaptive mesh that passes from the finest level to the coarsest: steps of one end are wrong at the other, and a crack between them would shine",
        lattices::level_boundary,
    ),
    (
        "uneven-axes",
        "a rectilinear grid with steps from 10⁻⁴ to 1, each decade as dense as the next: one step for all is too long or never ends",
        lattices::uneven_axes,
    ),
    (
        "slivers",
        "a bent layer of cells a hundred thousand times as wide as thick, over which the value jumps: rounding puts faces in the wrong order",
        lattices::slivers,
    ),
];

/// All hard cases.
pub fn all() -> Vec<Case> {
    TABLE.iter().map(make).collect()
}

/// The hard case of a name.
pub fn by_name(name: &str) -> Option<Case> {
    TABLE.iter().find(|entry| entry.0 == name).map(make)
}

fn make(&(name, summary, maker): &(&'static str, &'static str, Maker)) -> Case {
    let (scene, view) = maker();
    Case { name, summary, scene, view }
}

/// The values of a function of the index (x, y, z).
fn sampled<T>(dims: [usize; 3], f: impl Fn(usize, usize, usize) -> T) -> Vec<T> {
    let mut samples = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            samples.extend((0..dims[0]).map(|x| f(x, y, z)));
        }
    }
    samples
}

/// A volume of floats with voxel (0, 0, 0) at the world's origin.
fn float_volume(dims: [usize; 3], spacing: [f64; 3], f: impl Fn(usize, usize, usize) -> f32) -> Volume {
    let placement = Placement::from_spacing(spacing).expect("cases have positive spacing");
    let grid = UniformGrid::new(dims, sampled(dims, f), placement, Calibration::default());
    grid.expect("cases are valid grids").into()
}

/// A smooth bump on `n`³ voxels with unit spacing: 1 in the middle, 0 (and no slope) at the faces.
fn bump(n: usize) -> Volume {
    let profile = |i: usize| {
        let t = i as f64 / (n - 1) as f64;
        let s = 4.0 * t * (1.0 - t);
        s * s
    };
    float_volume([n; 3], [1.0; 3], |x, y, z| (profile(x) * profile(y) * profile(z)) as f32)
}

/// A density emitter under the power rule, from (value, colour, α).
fn transfer(points: &[(f64, [f64; 3], f64)], unit_distance: f64) -> TransferFunction {
    let points = points.iter().map(|&(value, color, alpha)| ControlPoint::new(value, color, alpha)).collect();
    TransferFunction::new(points, OpacityRule::Power, unit_distance).expect("cases have valid transfer functions")
}

/// Emission given on its own, from (value, emission per unit, α).
fn emitter(points: &[(f64, [f64; 3], f64)], unit_distance: f64) -> TransferFunction {
    let point = |&(value, emission, alpha): &(f64, [f64; 3], f64)| ControlPoint {
        emission: Some(emission),
        ..ControlPoint::new(value, [0.0; 3], alpha)
    };
    TransferFunction::new(points.iter().map(point).collect(), OpacityRule::Power, unit_distance)
        .expect("cases have valid transfer functions")
}

/// An orthographic picture of the whole volume from an oblique direction.
fn oblique(volume: &Volume, side: u32) -> View {
    View::new(Camera::framing(volume.bounds(), 35.0, 25.0, None), [side, side])
}

/// An orthographic view, from `eye` towards `target`.
fn orthographic(eye: [f64; 3], target: [f64; 3], up: [f64; 3], height: f64, size: [u32; 2]) -> View {
    let projection = Projection::Orthographic { height };
    View::new(Camera { eye: eye.into(), target: target.into(), up: up.into(), projection }, size)
}

fn with_shading(scene: Scene, shading: vr_core::Shading) -> Scene {
    Scene { shading: Some(Arc::new(shading)), ..scene }
}

/// The middle of a volume's bounds.
fn middle(volume: &Volume) -> DVec3 {
    let (low, high) = volume.bounds();
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Clip, Rays};

    #[test]
    fn every_case_is_small_valid_and_meets_its_volume() {
        for case in all() {
            case.scene.validate().unwrap();
            case.view.validate().unwrap();
            assert!(case.view.size.iter().all(|&n| n <= 32), "{}", case.name);
            let volume = &case.scene.volume;
            let values = match volume {
                Volume::Grid(grid) => grid.dims().iter().product::<usize>(),
                Volume::Amr(mesh) => mesh.blocks().iter().map(|block| block.values.len()).sum(),
                Volume::Rectilinear(grid) => grid.dims().iter().product(),
                Volume::Cells(mesh) => mesh.vertices().len(),
                other => panic!("{}: a {}", case.name, other.kind()),
            };
            assert!(values <= 33 * 33 * 33, "{}: {values}", case.name);
            let bounds = Clip { crop: Some(volume.bounds()), ..Clip::default() };
            let rays = Rays::new(&case.view).unwrap();
            let [w, h] = case.view.size;
            let hits = (0..w * h).filter(|i| {
                let ray = rays.at(f64::from(i % w) + 0.5, f64::from(i / w) + 0.5);
                ray.inside(&bounds).is_some()
            });
            assert!(hits.count() as u32 * 4 >= w * h, "{}: most rays miss", case.name);
        }
    }

    #[test]
    fn names_are_unique_and_found() {
        let names: std::collections::BTreeSet<_> = all().iter().map(|c| c.name).collect();
        assert_eq!(names.len(), TABLE.len());
        assert!(names.iter().all(|n| by_name(n).is_some_and(|c| c.name == *n)) && by_name("easy").is_none());
    }
}
