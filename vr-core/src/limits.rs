//! Ranges of the numbers of a scene: what f32 kernels and f64 set-up can keep.
//!
//! Kernels work in f32, whose normal numbers lie between 1.2·10⁻³⁸ and 3.4·10³⁸, and take lengths in steps or voxels. Within these limits
//! their results stay there:
//! * κ = −ln(1 − α) / unit distance is below 37 / [`MIN_LENGTH`] = 3.7·10²⁵ in front of a wall; along a step of a volume that is larger by far,
//!   it is a wall, and tables cut it at 10³⁰;
//! * the light of a sample is at most [`MAX_COLOR`]·[`MAX_FACTOR`]·[`MAX_LIGHT`] a lamp: 10²¹, which f32 adds up along any ray;
//! * emission that is given on its own, [`MAX_EMISSION`] in a unit distance, along 10⁹ of them: 10²¹.
//!
//! A spacing of 10⁻⁴⁶, which is 0 in f32, once made a ray caster step on the spot for ever.

/// Smallest spacing and unit distance, in world units.
pub(crate) const MIN_LENGTH: f64 = 1e-24;
/// Largest spacing and unit distance, in world units.
pub(crate) const MAX_LENGTH: f64 = 1e24;
/// Largest component of a control point's colour.
pub(crate) const MAX_COLOR: f64 = 1e12;
/// Largest component of a light's colour.
pub(crate) const MAX_LIGHT: f64 = 1e6;
/// Largest emission given on its own, in a unit distance.
pub(crate) const MAX_EMISSION: f64 = 1e12;
/// Largest coefficient of shading, and factor of gradient opacity.
pub(crate) const MAX_FACTOR: f64 = 1e3;
/// Largest specular exponent: f32 keeps three digits of xᵖ up to there.
pub(crate) const MAX_POWER: f64 = 1e4;
/// Largest gradient magnitude of gradient opacity, per world unit.
pub(crate) const MAX_MAGNITUDE: f64 = 1e60;
/// Largest distance of a volume from the world's origin, in its smallest spacing: f64 keeps 10⁻⁴ of a step there.
pub(crate) const MAX_STEPS_AWAY: f64 = 1e12;
/// Largest coordinate of a camera, a point or the box of a function: distances along rays are stored as f32, and their squares are finite in f64.
pub(crate) const MAX_COORDINATE: f64 = 1e30;
/// Largest distance of a camera from its target and from the world's origin, in heights of what it sees: rays in f64 are off by
/// 2·10⁻⁶ heights there, a hundredth of a pixel in pictures of 4096 rows.
pub(crate) const MAX_HEIGHTS_AWAY: f64 = 1e10;
/// Smallest vertical field of view in degrees: pixels of a narrower one are too close together for directions in f64.
pub(crate) const MIN_FOV: f64 = 1e-6;
/// Lengths of vectors of which only the direction counts: their squares are normal f64.
pub(crate) const DIRECTION_LENGTHS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

/// True if a spacing or a unit distance is within [`MIN_LENGTH`] and [`MAX_LENGTH`]; false for NaN.
pub(crate) fn is_length(x: f64) -> bool {
    (MIN_LENGTH..=MAX_LENGTH).contains(&x)
}
