//! Optical thickness of straight paths through a medium.

use glam::DVec3;

use crate::medium::Medium;

/// Largest number of slices along an axis.
const MAX_SLICES: usize = 64;
/// Number of places along a path that is tried.
const PLACES: usize = 256;

/// Upper bound of the optical thickness of any straight path through a medium: +∞ where a path never ends.
///
/// A path crosses the slices of the box across its longest axis in turn, each over at most √3 times its thickness in a box that is scaled to a cube; in
/// each it meets no more than the largest extinction there.
pub fn thickness_bound(medium: &dyn Medium) -> f64 {
    let (low, high) = medium.bounds();
    let size = high - low;
    if !size.is_finite() {
        let vacuum = medium.extinction_range(low, high)[1] == 0.0;
        return if vacuum { 0.0 } else { f64::INFINITY };
    }
    // Of a path whose longest part of the scaled box is along this axis, the world length within a slice is at most the slice's share of the box's
    // diagonal.
    let along = |axis: usize| -> f64 {
        let slices = medium.resolution()[axis].clamp(1, MAX_SLICES);
        let step = size[axis] / slices as f64;
        let slice = |i: usize| {
            let (mut near, mut far) = (low, high);
            near[axis] = low[axis] + step * i as f64;
            far[axis] = if i + 1 == slices { high[axis] } else { low[axis] + step * (i + 1) as f64 };
            medium.extinction_range(near, far)[1]
        };
        (0..slices).map(slice).sum::<f64>() * (size.length() / slices as f64)
    };
    (0..3).map(along).fold(0.0, f64::max)
}

/// Largest optical thickness, in any band, of the three straight paths through the middle of a medium along x, y and z, by the midpoint rule: an example of
/// how thick it is, and no bound.
pub fn thickness_along(medium: &dyn Medium) -> f64 {
    let (low, high) = medium.bounds();
    let size = high - low;
    if !size.is_finite() {
        return thickness_bound(medium);
    }
    let along = |axis: usize, band: usize| -> f64 {
        let step = size[axis] / PLACES as f64;
        let direction = DVec3::AXES[axis];
        let place = |i: usize| {
            let mut at = low + 0.5 * size;
            at[axis] = low[axis] + step * (i as f64 + 0.5);
            medium.extinction(at, direction, band)
        };
        (0..PLACES).map(place).sum::<f64>() * step
    };
    let paths = (0..3).flat_map(|axis| (0..medium.bands()).map(move |band| (axis, band)));
    paths.map(|(axis, band)| along(axis, band)).fold(0.0, f64::max)
}
