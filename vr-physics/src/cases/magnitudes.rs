//! Cases whose difficulty lies in numbers that are very small, very many or very large.

use vr_core::{Calibration, ControlPoint, OpacityRule, Placement, Scene, TransferFunction, UniformGrid, View, Volume};

use super::{bump, emitter, oblique, orthographic, sampled};

/// The light is 10¹² times as bright as the medium is thin, so that the picture has ordinary brightness and every lost digit of
/// κ shows in it.
pub(super) fn faint() -> (Scene, View) {
    const KAPPA: f64 = 1e-12;
    let volume = bump(9);
    let points =
        vec![ControlPoint::new(0.0, [1e11, 2e10, 0.0], 0.5 * KAPPA), ControlPoint::new(1.0, [5e10, 1e11, 2e10], KAPPA)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).expect("a valid transfer function");
    let view = oblique(&volume, 16);
    (Scene::new(volume, transfer), view)
}

/// A column seen along its long axis. α = 1 − (1 − 10⁻⁷)⁴⁰⁹⁶ ≈ 4.1 · 10⁻⁴, at a colour of 1000.
pub(super) fn many_faint_steps() -> (Scene, View) {
    let dims = [2, 2, 4097];
    let placement = Placement::from_spacing([1.0; 3]).expect("a valid placement");
    let samples = sampled(dims, |_, _, z| (z % 2) as u8);
    let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).expect("a valid grid");
    // The same opacity everywhere, yet no constant volume: nothing may be skipped or merged.
    let points = vec![ControlPoint::new(0.0, [1e3, 5e2, 0.0], 1e-7), ControlPoint::new(1.0, [5e2, 1e3, 0.0], 1e-7)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).expect("a valid transfer function");
    let view = orthographic([0.5, 0.5, 5000.0], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0], 0.9, [4, 4]);
    (Scene::new(Volume::from(grid), transfer), view)
}

/// Behind an absorption that lets 10⁻⁶ of it through, a light of 10⁶ is as bright as a light of 1.
pub(super) fn bright() -> (Scene, View) {
    let volume = bump(17);
    let points = [(0.0, [0.0; 3], 0.1), (0.6, [0.1, 0.2, 0.3], 0.7), (0.9, [1e6, 2e5, 0.0], 0.7), (1.0, [1e6; 3], 0.2)];
    let view = oblique(&volume, 24);
    (Scene::new(volume, emitter(&points, 1.0)), view)
}
