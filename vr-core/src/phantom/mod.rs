//! Phantoms: fields given by a formula, with bounds of their values and slopes, that can be sampled onto a grid of any size.
//!
//! | name | use |
//! |---|---|
//! | `marschner-lobb` | a reconstruction filter's smoothing and aliasing |
//! | `shepp-logan` | line integrals in closed form; jumps |
//! | `blobs` | a few per cent visible: skipping pays |
//! | `shells` | features a few hundredths wide: steps that are too long miss them |
//! | `fog` | visible everywhere: skipping cannot pay |
//! | `hydrogen` | smooth, with a large dynamic range |
//!
//! [`points_by_name`] has scattered points: [`POINT_NAMES`].

mod blobs;
mod fog;
mod hydrogen;
mod marschner_lobb;
mod plummer;
mod points;
mod sample;
mod shells;
mod shepp_logan;
mod split_mix;
mod turbulence;

pub use blobs::Blobs;
pub use fog::Fog;
pub use hydrogen::Hydrogen;
pub use marschner_lobb::MarschnerLobb;
pub use points::{POINT_NAMES, point_transfer_function, points_by_name};
pub use sample::{Quantize, sample, sampled_scene};
pub use shells::Shells;
pub use shepp_logan::SheppLogan;

use glam::DVec3;

use crate::error::GridError;
use crate::scene::Scene;
use crate::transfer::ControlPoint;

/// The `unit_distance`, in world units, that [`Phantom::transfer_points`] are for: the spacing of a grid of 65³ voxels
/// over [−1, 1]³. Given explicitly, it keeps the picture the same at every grid size.
pub const TRANSFER_UNIT_DISTANCE: f64 = 2.0 / 64.0;

/// A scalar field given by a formula.
///
/// Values depend on the position alone, bit for bit, on every machine: transcendental functions come from `libm`.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{self, Phantom, Shells};
///
/// let value = Shells.value(DVec3::new(0.1, 0.2, 0.3));
/// let (low, high) = Shells.value_range();
/// assert!((low..=high).contains(&value));
///
/// let scene = phantom::by_name("shells").unwrap().scene(9)?;
/// assert_eq!(scene.volume.grid().unwrap().dims(), [9; 3]);
/// # Ok::<(), vr_core::GridError>(())
/// ```
pub trait Phantom: Send + Sync {
    /// Name in scene files and on the command line.
    fn name(&self) -> &'static str;

    /// The field at a world position.
    fn value(&self, p: DVec3) -> f64;

    /// Its gradient per world unit; where the field jumps, that of the smooth pieces beside the jump.
    fn gradient(&self, p: DVec3) -> DVec3;

    /// Two opposite corners, lower first, of the axis-parallel world box that the phantom is meant to be seen in.
    fn domain(&self) -> (DVec3, DVec3) {
        (DVec3::NEG_ONE, DVec3::ONE)
    }

    /// Numbers, lower first, that every value in the domain lies between, up to rounding.
    fn value_range(&self) -> (f64, f64);

    /// A bound of the gradient's length over all of space, per world unit; +∞ where the field jumps.
    fn lipschitz(&self) -> f64;

    /// A bound of the gradient's length along a line, between two neighbouring [`breakpoints`](Self::breakpoints).
    fn lipschitz_between_breakpoints(&self) -> f64 {
        self.lipschitz()
    }

    /// Appends the parameters s, in any order and of either sign, at which the field is not smooth along the line
    /// `origin + s·direction`; in world units where `direction` is a unit vector.
    fn breakpoints(&self, _origin: DVec3, _direction: DVec3, _out: &mut Vec<f64>) {}

    /// Control points of a transfer function that shows the phantom's features, by ascending value, for a
    /// `unit_distance` of [`TRANSFER_UNIT_DISTANCE`].
    fn transfer_points(&self) -> Vec<ControlPoint>;

    /// An unshaded scene of `n`³ samples of it in f32, under its own transfer function.
    ///
    /// # Errors
    /// Fewer than two samples, or more than can be held.
    fn scene(&self, n: usize) -> Result<Scene, GridError> {
        sampled_scene::<f32>(self, n, 1.0)
    }
}

/// The names that [`by_name`] knows.
pub const NAMES: &[&str] = &["marschner-lobb", "shepp-logan", "blobs", "shells", "fog", "hydrogen"];

/// The phantom of a name, with its usual parameters.
pub fn by_name(name: &str) -> Option<Box<dyn Phantom>> {
    Some(match name {
        "marschner-lobb" => Box::new(MarschnerLobb::default()),
        "shepp-logan" => Box::new(SheppLogan::new()),
        "blobs" => Box::new(Blobs::default()),
        "shells" => Box::new(Shells),
        "fog" => Box::new(Fog::default()),
        "hydrogen" => Box::new(Hydrogen),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::split_mix::SplitMix64;
    use super::*;

    fn all() -> impl Iterator<Item = Box<dyn Phantom>> {
        NAMES.iter().map(|name| by_name(name).unwrap())
    }

    fn point_in(phantom: &dyn Phantom, random: &mut SplitMix64) -> DVec3 {
        let (low, high) = phantom.domain();
        low + (high - low) * DVec3::new(random.unit(), random.unit(), random.unit())
    }

    #[test]
    fn names_are_found_again() {
        for (phantom, &name) in all().zip(NAMES) {
            assert_eq!(phantom.name(), name);
        }
        assert!(by_name("teapot").is_none());
    }

    #[test]
    fn gradients_agree_with_central_differences() {
        // Error of the differences: h²/6 times the third derivative, which for the steepest phantom is below 10⁶.
        const H: f64 = 1e-5;
        for phantom in all().filter(|p| p.lipschitz().is_finite()) {
            let mut random = SplitMix64::new(1);
            for _ in 0..2000 {
                let p = point_in(&*phantom, &mut random);
                let difference = |axis: DVec3| (phantom.value(p + axis * H) - phantom.value(p - axis * H)) / (2.0 * H);
                let expected = DVec3::new(difference(DVec3::X), difference(DVec3::Y), difference(DVec3::Z));
                let found = phantom.gradient(p);
                assert!((found - expected).length() < 1e-4, "{} at {p}: {found} {expected}", phantom.name());
            }
        }
    }

    #[test]
    fn values_lie_in_the_range_and_fill_most_of_it() {
        for phantom in all() {
            let (low, high) = phantom.value_range();
            let mut random = SplitMix64::new(2);
            let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
            for _ in 0..200_000 {
                let value = phantom.value(point_in(&*phantom, &mut random));
                min = min.min(value);
                max = max.max(value);
            }
            let name = phantom.name();
            assert!(min >= low - 1e-12 && max <= high + 1e-12, "{name}: {min} to {max} outside {low} to {high}");
            assert!(max - min > 0.85 * (high - low), "{name}: {min} to {max}, far inside {low} to {high}");
        }
    }

    #[test]
    fn no_pair_of_points_is_steeper_than_the_lipschitz_bound() {
        for phantom in all() {
            let bound = phantom.lipschitz();
            let mut random = SplitMix64::new(3);
            let mut steepest = 0.0f64;
            for k in 0..100_000 {
                let p = point_in(&*phantom, &mut random);
                let shrink = if k % 2 == 0 { 1.0 } else { 1e-3 };
                let q = p + (point_in(&*phantom, &mut random) - p) * shrink;
                steepest = steepest.max((phantom.value(p) - phantom.value(q)).abs() / p.distance(q));
                steepest = steepest.max(phantom.gradient(p).length());
            }
            assert!(steepest <= bound, "{}: {steepest} above {bound}", phantom.name());
            // A bound that is far off would cost its users dearly.
            assert!(bound.is_infinite() || steepest > 0.4 * bound, "{}: {steepest} far below {bound}", phantom.name());
        }
    }

    #[test]
    fn transfer_points_ascend_within_the_range() {
        for phantom in all() {
            let points = phantom.transfer_points();
            let (low, high) = phantom.value_range();
            assert!(points.is_sorted_by(|a, b| a.value < b.value), "{}", phantom.name());
            assert!(points.iter().all(|p| (low..=high).contains(&p.value)), "{}", phantom.name());
            assert!(points.iter().all(|p| (0.0..1.0).contains(&p.opacity)), "{}", phantom.name());
        }
    }
}
