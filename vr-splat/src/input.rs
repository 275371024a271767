//! The data that are splatted: a grid or points, and what follows from that.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use vr_core::{Calibration, GridVolume, PointSet};

use crate::kernel::Profile;
use crate::point_mixture::smallest_mean;
use crate::splatter::Splatter;

/// The data that are splatted.
#[derive(Clone)]
pub(crate) enum SplatInput {
    Grid(Arc<GridVolume>),
    Points(Arc<PointSet>),
}

/// World length of a unit of views: the shortest edge of a voxel, or half the mean radius of points.
pub(crate) fn unit(input: &SplatInput) -> f64 {
    match input {
        SplatInput::Grid(grid) => grid.placement().spacing().min_element(),
        SplatInput::Points(points) => points.mean_spacing(),
    }
}

/// The kernel that the data are spread by.
pub(crate) fn profile(renderer: &Splatter, input: &SplatInput) -> Profile {
    match input {
        SplatInput::Grid(_) => renderer.kernel.profile(),
        SplatInput::Points(points) => Profile::point(points.kernel()),
    }
}

/// From world vectors to kernel space, of a grid.
pub(crate) fn kernel_space(renderer: &Splatter, grid: &GridVolume) -> DMat3 {
    let reach = renderer.kernel.reach();
    DMat3::from_diagonal(DVec3::from_array(reach.map(|r| 1.0 / r))) * grid.placement().inverse_axes()
}

/// Offset subtracted from a grid's stored numbers, or from values of points whose mean is taken, before they are splatted, and calibration of the rest: sums of small numbers round less, and a constant
/// stays one.
pub(crate) fn offset(input: &SplatInput) -> (f32, Calibration) {
    let grid = match input {
        SplatInput::Grid(grid) => grid,
        SplatInput::Points(points) => {
            let low = smallest_mean(points).unwrap_or(0.0);
            return (low as f32, Calibration { intercept: low, ..Calibration::default() });
        }
    };
    let low = grid.value_stats().range.map_or(0.0, |(low, _)| low);
    let calibration = grid.calibration();
    (low, Calibration { intercept: calibration.value(low.into()), ..calibration })
}
