//! What is splatted: a grid or points, and what follows from that.

use glam::{DMat3, DVec3};
use vr_core::{Calibration, PointSet, UniformVolume};

use crate::kernel::{Profile, point_profile};
use crate::splatting::Splatting;

/// What is splatted.
#[derive(Clone, Copy)]
pub(crate) enum Things<'s> {
    Grid(&'s UniformVolume),
    Points(&'s PointSet),
}

/// World length of a unit of views: the shortest edge of a voxel, or half the mean radius of points.
pub(crate) fn unit(things: Things<'_>) -> f64 {
    match things {
        Things::Grid(grid) => grid.placement().spacing().min_element(),
        Things::Points(points) => points.mean_spacing(),
    }
}

/// The kernel that things are spread by.
pub(crate) fn profile(renderer: &Splatting, things: Things<'_>) -> Profile {
    match things {
        Things::Grid(_) => renderer.kernel.profile(),
        Things::Points(points) => point_profile(points.kernel()),
    }
}

/// From world vectors to kernel space, of a grid.
pub(crate) fn kernel_space(renderer: &Splatting, grid: &UniformVolume) -> DMat3 {
    let reach = renderer.kernel.reach();
    DMat3::from_diagonal(DVec3::from_array(reach.map(|r| 1.0 / r))) * grid.placement().inverse_axes()
}

/// What is subtracted from a grid's stored numbers before they are splatted, and what the rest means: sums of small numbers round less, and a constant
/// stays one.
pub(crate) fn offset(things: Things<'_>) -> (f32, Calibration) {
    let Things::Grid(grid) = things else { return (0.0, Calibration::default()) };
    let low = grid.census().range.map_or(0.0, |(low, _)| low);
    let calibration = grid.calibration();
    (low, Calibration { intercept: calibration.value(low.into()), ..calibration })
}
