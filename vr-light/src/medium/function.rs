//! A medium given by functions.

use std::fmt;

use glam::DVec3;
use vr_core::ParameterError;
use vr_core::scattering::PhaseFunction;

use super::{BandMatrix, Coefficients, Medium, check_bounds, contains};

/// Coefficients at a point, for light that travels in a direction, in one band.
type Function = dyn Fn(DVec3, DVec3, usize) -> Coefficients + Send + Sync;
/// Bounds of the extinction within a box.
type Range = dyn Fn(DVec3, DVec3) -> [f64; 2] + Send + Sync;

/// Medium whose coefficients are a function of point, direction and band, with a bound on the extinction.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::PhaseFunction;
/// use vr_light::{Coefficients, FunctionMedium, Medium};
///
/// // A ball that grows thinner outwards.
/// let density = |p: DVec3| (1.0 - p.length()).max(0.0);
/// let ball = FunctionMedium::new(
///     (DVec3::NEG_ONE, DVec3::ONE),
///     1,
///     PhaseFunction::Isotropic,
///     [0.0, 1.0],
///     move |p, _, _| Coefficients { scattering: density(p), ..Coefficients::default() },
/// )?;
/// assert_eq!(ball.extinction(DVec3::new(0.5, 0.0, 0.0), DVec3::X, 0), 0.5);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
pub struct FunctionMedium {
    bounds: (DVec3, DVec3),
    bands: usize,
    phase: PhaseFunction,
    whole: [f64; 2],
    function: Box<Function>,
    range: Option<Box<Range>>,
    resolution: [usize; 3],
    is_grey: bool,
    matrix: Option<BandMatrix>,
}

impl FunctionMedium {
    /// A medium of a function of point, direction of light and band. The extinction must lie within `range` everywhere in the box; where it is
    /// larger, light is lost from the bound on.
    ///
    /// # Errors
    /// No band, a box whose first corner is not below the second, a range that is negative, not finite or the wrong way round.
    pub fn new(
        bounds: (DVec3, DVec3),
        bands: usize,
        phase: PhaseFunction,
        range: [f64; 2],
        function: impl Fn(DVec3, DVec3, usize) -> Coefficients + Send + Sync + 'static,
    ) -> Result<Self, ParameterError> {
        check_bounds(bounds)?;
        if bands == 0 {
            return Err(ParameterError::new("medium.bands", bands, "must be at least 1"));
        }
        if !(0.0 <= range[0] && range[0] <= range[1] && range[1].is_finite()) {
            let allowed = "must be bounds of the extinction, finite, not negative, the lower one first";
            return Err(ParameterError::new("medium.range", range, allowed));
        }
        let function = Box::new(function);
        let (range, whole) = (None, range);
        Ok(Self { bounds, bands, phase, whole, function, range, resolution: [1; 3], is_grey: bands == 1, matrix: None })
    }

    /// The same medium, with bounds of its extinction in any box, worth asking in so many cells along x, y and z.
    #[must_use]
    pub fn with_ranges(
        self,
        resolution: [usize; 3],
        range: impl Fn(DVec3, DVec3) -> [f64; 2] + Send + Sync + 'static,
    ) -> Self {
        Self { range: Some(Box::new(range)), resolution: resolution.map(|n| n.max(1)), ..self }
    }

    /// The same medium, known to have one extinction in all bands.
    #[must_use]
    pub fn grey(self) -> Self {
        Self { is_grey: true, ..self }
    }

    /// The same medium, in which scattering moves light between bands.
    ///
    /// # Errors
    /// A matrix of another number of bands.
    pub fn with_band_matrix(self, matrix: BandMatrix) -> Result<Self, ParameterError> {
        if matrix.bands() != self.bands {
            let allowed = "must have as many bands as the medium";
            return Err(ParameterError::new("scattering.bands", matrix.bands(), allowed));
        }
        Ok(Self { matrix: Some(matrix), ..self })
    }
}

impl Medium for FunctionMedium {
    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    fn bands(&self) -> usize {
        self.bands
    }

    fn coefficients(&self, at: DVec3, direction: DVec3, first: usize, out: &mut [Coefficients]) {
        let inside = contains(self.bounds, at);
        for (i, out) in out.iter_mut().enumerate() {
            *out = if inside { (self.function)(at, direction, first + i) } else { Coefficients::default() };
        }
    }

    fn is_grey(&self) -> bool {
        self.is_grey
    }

    fn phase(&self) -> &PhaseFunction {
        &self.phase
    }

    fn band_matrix(&self) -> Option<&BandMatrix> {
        self.matrix.as_ref()
    }

    fn extinction_range(&self, low: DVec3, high: DVec3) -> [f64; 2] {
        let [min, max] = self.range.as_ref().map_or(self.whole, |range| range(low, high));
        if contains(self.bounds, low) && contains(self.bounds, high) { [min, max] } else { [0.0, max] }
    }

    fn resolution(&self) -> [usize; 3] {
        self.resolution
    }
}

impl fmt::Debug for FunctionMedium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FunctionMedium")
            .field("bounds", &self.bounds)
            .field("bands", &self.bands)
            .finish_non_exhaustive()
    }
}
