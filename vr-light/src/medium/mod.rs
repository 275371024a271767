//! Media: what absorbs, scatters and emits light between the boundaries.

mod band_matrix;
mod extinction_curve;
mod function;
mod homogeneous;
mod scene;
mod scene_field;

pub use band_matrix::BandMatrix;
pub use function::FunctionMedium;
pub use homogeneous::Homogeneous;
pub use scene::{SceneMedium, WALL_DEPTH};

use std::fmt::Debug;

use glam::DVec3;
use vr_core::ParameterError;
use vr_core::scattering::PhaseFunction;

/// Coefficients of a medium at a point, for light of one band in one direction.
///
/// # Examples
/// ```
/// use vr_light::Coefficients;
///
/// let fog = Coefficients { absorption: 0.5, scattering: 1.5, emission: 0.0 };
/// assert_eq!((fog.extinction(), fog.albedo(), fog.mean_free_path()), (2.0, 0.75, 0.5));
/// assert_eq!(Coefficients::default().albedo(), 0.0, "vacuum scatters nothing");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coefficients {
    /// κ: share of the light that is absorbed per world unit.
    pub absorption: f64,
    /// σ: share of the light that is scattered into other directions per world unit.
    pub scattering: f64,
    /// q: radiance that the medium itself adds per world unit.
    pub emission: f64,
}

impl Coefficients {
    /// χ = κ + σ, per world unit.
    pub fn extinction(&self) -> f64 {
        self.absorption + self.scattering
    }

    /// ϖ = σ/χ, 0 in vacuum.
    pub fn albedo(&self) -> f64 {
        let extinction = self.extinction();
        if extinction > 0.0 { self.scattering / extinction } else { 0.0 }
    }

    /// 1/χ in world units; +∞ in vacuum.
    pub fn mean_free_path(&self) -> f64 {
        1.0 / self.extinction()
    }
}

/// Medium that light travels through, in any number of spectral bands.
///
/// Directions are those in which light travels. All coefficients are per world unit, finite and not negative.
pub trait Medium: Send + Sync + Debug {
    /// Lower and upper corner of the world box outside of which is vacuum. Sides may be infinitely far away.
    fn bounds(&self) -> (DVec3, DVec3);

    /// Number of spectral bands, 1 or more.
    fn bands(&self) -> usize {
        3
    }

    /// Fills the coefficients of the bands `first .. first + out.len()` at a point, for light that travels in a direction.
    ///
    /// # Panics
    /// May panic if there are no such bands.
    fn coefficients(&self, at: DVec3, direction: DVec3, first: usize, out: &mut [Coefficients]);

    /// χ of one band at a point, for light that travels in a direction.
    fn extinction(&self, at: DVec3, direction: DVec3, band: usize) -> f64 {
        let mut one = [Coefficients::default()];
        self.coefficients(at, direction, band, &mut one);
        one[0].extinction()
    }

    /// Fills χ of one band at points, for light that travels in a direction. What a look-up begins with is done once for all of them.
    ///
    /// # Panics
    /// May panic if the lists are not of one length.
    fn extinctions(&self, at: &[DVec3], direction: DVec3, band: usize, out: &mut [f64]) {
        for (out, &at) in out.iter_mut().zip(at) {
            *out = self.extinction(at, direction, band);
        }
    }

    /// The albedo of a band, if it is the same in all places that are not vacuum and in all directions: paths need not look it up then.
    fn albedo(&self, _band: usize) -> Option<f64> {
        None
    }

    /// True if all bands have the same extinction everywhere: one path serves all of them then.
    fn is_grey(&self) -> bool {
        false
    }

    /// Directions in which scattered light leaves.
    fn phase(&self) -> &PhaseFunction;

    /// Bands into which scattered light goes; `None` where it stays in its own.
    fn band_matrix(&self) -> Option<&BandMatrix> {
        None
    }

    /// Bounds of the extinction of all bands and directions within a box. Sides of the box may be infinitely far away.
    fn extinction_range(&self, low: DVec3, high: DVec3) -> [f64; 2];

    /// True if any place emits.
    fn has_emission(&self) -> bool {
        true
    }

    /// Cells along x, y and z whose ranges of extinction are worth telling apart; 1 along an axis without end.
    fn resolution(&self) -> [usize; 3] {
        [1; 3]
    }
}

/// Checks the corners of a medium's box, whose sides may be infinitely far away.
fn check_bounds((low, high): (DVec3, DVec3)) -> Result<(), ParameterError> {
    if low.cmplt(high).all() {
        return Ok(());
    }
    let found = (low.to_array(), high.to_array());
    Err(ParameterError::new("medium.bounds", found, "the first corner must be below the second along x, y and z"))
}

/// True if a point lies in a box, its faces included.
fn contains((low, high): (DVec3, DVec3), at: DVec3) -> bool {
    at.cmpge(low).all() && at.cmple(high).all()
}
