//! A medium that is the same everywhere in a box.

use glam::DVec3;
use vr_core::ParameterError;
use vr_core::scattering::PhaseFunction;

use super::{BandMatrix, Coefficients, Medium, contains};

/// The same medium everywhere in a box.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::PhaseFunction;
/// use vr_light::{Coefficients, Homogeneous, Medium};
///
/// let fog = Coefficients { absorption: 0.1, scattering: 0.9, emission: 0.0 };
/// let cube = Homogeneous::new((DVec3::ZERO, DVec3::ONE), vec![fog; 3], PhaseFunction::Isotropic)?;
/// assert_eq!(cube.extinction(DVec3::splat(0.5), DVec3::X, 0), 1.0);
/// assert_eq!(cube.extinction(DVec3::splat(1.5), DVec3::X, 0), 0.0, "vacuum outside");
///
/// // A slab without end in x and y.
/// let slab = Homogeneous::slab([0.0, 2.0], vec![fog], PhaseFunction::Isotropic)?;
/// assert_eq!(slab.bounds().0, DVec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, 0.0));
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Homogeneous {
    bounds: (DVec3, DVec3),
    bands: Vec<Coefficients>,
    phase: PhaseFunction,
    matrix: Option<BandMatrix>,
}

impl Homogeneous {
    /// A medium of the given coefficients, one for each band, in a box. Sides of the box may be infinitely far away.
    ///
    /// # Errors
    /// No band, coefficients that are negative or not finite, or a box whose first corner is not below the second.
    pub fn new(bounds: (DVec3, DVec3), bands: Vec<Coefficients>, phase: PhaseFunction) -> Result<Self, ParameterError> {
        super::check_bounds(bounds)?;
        if bands.is_empty() {
            return Err(ParameterError::new("medium.bands", "none", "must have at least one band"));
        }
        for (i, band) in bands.iter().enumerate() {
            let Coefficients { absorption, scattering, emission } = *band;
            if [absorption, scattering, emission].iter().any(|c| !(*c >= 0.0 && c.is_finite())) {
                let allowed = "must be finite and not negative, per world unit";
                return Err(ParameterError::new(format!("medium.bands[{i}]"), band, allowed));
            }
        }
        Ok(Self { bounds, bands, phase, matrix: None })
    }

    /// A slab between two heights along z, without end in x and y.
    ///
    /// # Errors
    /// Same as for [`Self::new`].
    pub fn slab([from, to]: [f64; 2], bands: Vec<Coefficients>, phase: PhaseFunction) -> Result<Self, ParameterError> {
        let side = f64::INFINITY;
        Self::new((DVec3::new(-side, -side, from), DVec3::new(side, side, to)), bands, phase)
    }

    /// The same medium, in which scattering moves light between bands.
    ///
    /// # Errors
    /// A matrix of another number of bands.
    pub fn with_band_matrix(self, matrix: BandMatrix) -> Result<Self, ParameterError> {
        if matrix.bands() != self.bands.len() {
            let allowed = "must have as many bands as the medium";
            return Err(ParameterError::new("scattering.bands", matrix.bands(), allowed));
        }
        Ok(Self { matrix: Some(matrix), ..self })
    }
}

impl Medium for Homogeneous {
    fn albedo(&self, band: usize) -> Option<f64> {
        Some(self.bands[band].albedo())
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    fn bands(&self) -> usize {
        self.bands.len()
    }

    fn coefficients(&self, at: DVec3, _direction: DVec3, first: usize, out: &mut [Coefficients]) {
        if contains(self.bounds, at) {
            out.copy_from_slice(&self.bands[first..first + out.len()]);
        } else {
            out.fill(Coefficients::default());
        }
    }

    fn is_grey(&self) -> bool {
        self.bands.iter().all(|band| band.extinction() == self.bands[0].extinction())
    }

    fn phase(&self) -> &PhaseFunction {
        &self.phase
    }

    fn band_matrix(&self) -> Option<&BandMatrix> {
        self.matrix.as_ref()
    }

    fn extinction_range(&self, low: DVec3, high: DVec3) -> [f64; 2] {
        let extinctions = || self.bands.iter().map(Coefficients::extinction);
        let largest = extinctions().fold(0.0, f64::max);
        if contains(self.bounds, low) && contains(self.bounds, high) {
            [extinctions().fold(f64::INFINITY, f64::min), largest]
        } else {
            [0.0, largest]
        }
    }

    fn has_emission(&self) -> bool {
        self.bands.iter().any(|band| band.emission > 0.0)
    }
}
