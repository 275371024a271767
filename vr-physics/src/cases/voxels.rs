//! Cases whose difficulty lies in the voxels.

use vr_core::phantom::{MarschnerLobb, sample};
use vr_core::{
    Calibration, ControlPoint, OpacityRule, Placement, Scene, Shading, TransferFunction, UniformGrid, View, Volume,
};

use super::{float_volume, oblique, sampled, transfer, with_shading};

/// The phantom under a transfer function that shows one of its ripples.
pub(super) fn marschner_lobb() -> (Scene, View) {
    const N: usize = 33;
    let grid = sample::<f32>(&MarschnerLobb::default(), [N; 3]).expect("a valid grid");
    let volume = Volume::from(grid);
    let points = [(0.4, [0.1, 0.3, 0.9], 0.0), (0.5, [1.0, 0.8, 0.3], 0.6), (0.6, [0.9, 0.2, 0.1], 0.0)];
    let view = oblique(&volume, 32);
    let unit_distance = volume.mean_spacing();
    (Scene::new(volume, transfer(&points, unit_distance)), view)
}

/// A lone NaN, a lone infinity, a wall of NaN and a corner of −∞ in a ramp whose brightest place is a 0 (what a NaN turned into
/// a number would show).
pub(super) fn missing_voxels() -> (Scene, View) {
    let n = 9;
    let volume = float_volume([n; 3], [1.0; 3], |x, y, z| match (x, y, z) {
        (2, 3, 4) => f32::NAN,
        (6, 6, 6) => f32::INFINITY,
        (5, y, _) if y < 3 => f32::NAN,
        (0 | 1, 7 | 8, 7 | 8) => f32::NEG_INFINITY,
        _ => 0.3 + (x + 2 * y + 3 * z) as f32 / 70.0,
    });
    let points = [(0.0, [9.0, 9.0, 9.0], 0.9), (0.3, [0.2, 0.5, 1.0], 0.05), (1.0, [1.0, 0.4, 0.1], 0.3)];
    let view = oblique(&volume, 32);
    (Scene::new(volume, transfer(&points, 1.0)), view)
}

/// x·y·z with jumps of sign between the corners, shaded.
pub(super) fn two_samples() -> (Scene, View) {
    let volume = float_volume([2; 3], [1.0, 2.0, 0.5], |x, y, z| if (x + y + z) % 2 == 0 { 0.0 } else { 1.0 });
    let points = [(0.0, [0.1, 0.3, 0.9], 0.1), (1.0, [1.0, 0.8, 0.3], 0.7)];
    let view = oblique(&volume, 24);
    (with_shading(Scene::new(volume, transfer(&points, 1.0)), Shading::default()), view)
}

pub(super) fn constant() -> (Scene, View) {
    let volume = float_volume([5; 3], [1.0; 3], |_, _, _| 0.7);
    let points = [(0.0, [0.0; 3], 0.0), (1.0, [1.0, 0.5, 0.25], 0.5)];
    let view = oblique(&volume, 24);
    (with_shading(Scene::new(volume, transfer(&points, 1.0)), Shading::default()), view)
}

/// Blocks of 2³ voxels that differ by 1 from each other, on top of the whole range; the transfer function goes from clear to
/// dense within three units in the middle of it, which a table with fewer than 2¹⁶ entries smears.
pub(super) fn full_u16() -> (Scene, View) {
    let n = 17;
    let samples = sampled([n; 3], |x, y, z| {
        let edge = |i: usize| i == 0 || i == n - 1;
        if edge(x) && edge(y) && edge(z) {
            return if x == 0 { 0 } else { u16::MAX };
        }
        32766 + ((x / 2 + y / 2 + z / 2) % 5) as u16
    });
    let placement = Placement::from_spacing([1.0; 3]).expect("a valid placement");
    let grid = UniformGrid::new([n; 3], samples, placement, Calibration::default()).expect("a valid grid");
    let points = vec![
        ControlPoint::new(0.0, [0.0, 0.0, 1.0], 0.0),
        ControlPoint::new(32767.0, [0.2, 0.4, 1.0], 0.01),
        ControlPoint::new(32770.0, [1.0, 0.6, 0.1], 0.5),
        ControlPoint::new(65535.0, [1.0, 0.0, 0.0], 0.6),
    ];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).expect("a valid transfer function");
    let volume = Volume::from(grid);
    let view = oblique(&volume, 32);
    (Scene::new(volume, transfer), view)
}
