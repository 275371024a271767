//! Parts of a placement, as formats hold them apart.

use glam::{DMat3, DVec3};
use vr_core::Placement;

/// Largest cosine between two index axes that count as perpendicular. Rotations of headers in 32 bits are off by 10⁻⁶, and by 10⁻⁵ after a
/// few programs; a gantry is tilted by 10⁻² and more.
const MAX_COSINE: f64 = 1e-4;

/// Directions of the index axes, of length 1.
pub(super) fn directions(placement: &Placement) -> DMat3 {
    let axes = placement.axes();
    DMat3::from_cols(axes.x_axis.normalize(), axes.y_axis.normalize(), axes.z_axis.normalize())
}

/// Largest cosine between two index axes, where they are not perpendicular.
pub(super) fn shear(placement: &Placement) -> Option<f64> {
    let d = directions(placement);
    let cosines = [d.x_axis.dot(d.y_axis), d.y_axis.dot(d.z_axis), d.z_axis.dot(d.x_axis)];
    let largest = cosines.iter().fold(0.0f64, |largest, c| largest.max(c.abs()));
    (largest > MAX_COSINE).then_some(largest)
}

/// True if the index axes run along the axes of the world, in their order and direction.
pub(super) fn is_upright(placement: &Placement) -> bool {
    placement.axes() == DMat3::from_diagonal(placement.spacing())
}

/// Numbers of a header, the shortest digits that give each of them back.
pub(super) fn words(numbers: impl IntoIterator<Item = f64>) -> String {
    // Adding 0 takes the sign from −0.
    numbers.into_iter().map(|x| (x + 0.0).to_string()).collect::<Vec<_>>().join(" ")
}

/// Numbers of a vector.
pub(super) fn vector(v: DVec3) -> String {
    words(v.to_array())
}
