//! Cases whose difficulty lies in how rays meet the grid.

use vr_core::{Calibration, Camera, ControlPoint, OpacityRule, Placement, Projection, Scene, TransferFunction};
use vr_core::{UniformGrid, View, Volume};

use glam::{DMat3, DVec3};

use super::{bump, float_volume, middle, oblique, orthographic, sampled, transfer};

/// A translucent transfer function for fields in [0, 1], per `unit` of length.
fn translucent(unit: f64) -> TransferFunction {
    transfer(&[(0.0, [0.1, 0.2, 0.9], 0.01), (0.5, [0.9, 0.8, 0.3], 0.1), (1.0, [1.0, 0.3, 0.1], 0.4)], unit)
}

pub(super) fn anisotropy() -> (Scene, View) {
    let wave = |x: usize, y: usize, z: usize| 0.5 + 0.5 * libm::sin(0.7 * x as f64 + 0.4 * y as f64 + 1.1 * z as f64);
    let volume = float_volume([25, 25, 5], [1.0, 1.0, 50.0], |x, y, z| wave(x, y, z) as f32);
    // The middle of the long box, filling the picture: rays cross faces of all three kinds.
    let view = orthographic([72.0, 47.0, 190.0], [12.0, 12.0, 100.0], [0.0, 1.0, 0.0], 40.0, [32, 32]);
    (Scene::new(volume, translucent(4.0)), view)
}

/// A view along a diagonal of the x-z plane, tilted by 10⁻⁶ against the faces y = 0 and y = 8: the first row of pixels enters
/// through the upper face half-way along the box, the last row leaves through the lower one, and the middle column meets two
/// vertical edges.
pub(super) fn grazing_rays() -> (Scene, View) {
    let volume = bump_on_floor(9);
    // 31 rows, the first and the last of which have their centres 8 units apart.
    let height = 8.0 * 31.0 / 30.0;
    let tilt = 1.0 / 32768.0;
    let view = orthographic([36.0, 4.0 + tilt, 36.0], [4.0, 4.0, 4.0], [0.0, 1.0, 0.0], height, [31, 31]);
    (Scene::new(volume, translucent(2.0)), view)
}

/// A view along −z with two pixels a voxel: pixel centres on every lattice line and half-way between, from face to face of the box.
pub(super) fn axis_aligned() -> (Scene, View) {
    let volume = bump_on_floor(9);
    // 17 pixels over 8.5 units: centres at 0, 0.5, …, 8, all exact in binary.
    let view = orthographic([4.0, 4.0, 32.0], [4.0, 4.0, 0.0], [0.0, 1.0, 0.0], 8.5, [17, 17]);
    (Scene::new(volume, translucent(2.0)), view)
}

pub(super) fn camera_inside() -> (Scene, View) {
    let volume = bump(17);
    let eye = middle(&volume) + DVec3::new(1.25, -0.5, 2.0);
    let projection = Projection::Perspective { fov: 100.0 };
    let camera = Camera { eye, target: DVec3::new(3.0, 5.0, 0.0), up: DVec3::Y, projection };
    (Scene::new(volume, translucent(1.0)), View::new(camera, [32, 24]))
}

pub(super) fn far_origin() -> (Scene, View) {
    const SPACING: f64 = 1e-3;
    let n = 17;
    let axes = DMat3::from_diagonal(DVec3::splat(SPACING));
    let placement = Placement::new(DVec3::new(1e6, -1e6, 1e6), axes).expect("a valid placement");
    let wave = |x: usize, y: usize, z: usize| 0.5 + 0.5 * libm::sin(0.5 * x as f64 - 0.6 * y as f64 + 0.3 * z as f64);
    let samples = sampled([n; 3], |x, y, z| (255.0 * wave(x, y, z)) as u8);
    let grid = UniformGrid::new([n; 3], samples, placement, Calibration::default()).expect("a valid grid");
    let volume = Volume::from(grid);
    let points = vec![ControlPoint::new(0.0, [0.1, 0.2, 0.9], 0.02), ControlPoint::new(255.0, [1.0, 0.6, 0.2], 0.5)];
    let transfer = TransferFunction::new(points, OpacityRule::Extinction, SPACING).expect("a valid transfer function");
    let view = oblique(&volume, 32);
    (Scene::new(volume, transfer), view)
}

/// The bump on a floor of 0.2, so that the faces of the box are not invisible.
fn bump_on_floor(n: usize) -> Volume {
    let m = (n - 1) as f64;
    let profile = |i: usize| 4.0 * (i as f64 / m) * (1.0 - i as f64 / m);
    float_volume([n; 3], [1.0; 3], |x, y, z| (0.2 + 0.8 * profile(x) * profile(y) * profile(z)) as f32)
}
