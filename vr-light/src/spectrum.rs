//! Numbers by spectral band.

use vr_core::ParameterError;

/// Bands that one path carries.
pub(crate) const LANES: usize = 4;
/// A number for each band that a path carries; 0 in lanes without a band.
pub(crate) type Lanes = [f64; LANES];

/// Neighbouring bands that one path carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BandGroup {
    /// The first band; its extinction is that of the others.
    pub first: usize,
    /// Number of bands, [`LANES`] at most.
    pub count: usize,
}

/// A number that is not negative for each band: a radiance, or a share of light.
///
/// # Examples
/// ```
/// use vr_light::Spectrum;
///
/// let grey = Spectrum::grey(0.5);
/// assert_eq!((grey.at(0), grey.at(100)), (0.5, 0.5));
/// assert_eq!(Spectrum::new(vec![1.0, 0.5, 0.0]).at(1), 0.5);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum(Vec<f64>);

impl Spectrum {
    /// A number for each band, or a single one for all of them.
    pub fn new(bands: Vec<f64>) -> Self {
        Self(bands)
    }

    /// The same number for all bands.
    pub fn grey(number: f64) -> Self {
        Self(vec![number])
    }

    /// Nothing in any band.
    pub fn black() -> Self {
        Self::grey(0.0)
    }

    /// The number of a band.
    ///
    /// Panics if the spectrum is neither grey nor has such a band: a bug in the caller.
    pub fn at(&self, band: usize) -> f64 {
        if self.0.len() == 1 { self.0[0] } else { self.0[band] }
    }

    /// True if every band has nothing.
    pub fn is_black(&self) -> bool {
        self.0.iter().all(|&x| x == 0.0)
    }

    /// The numbers of a group of bands.
    pub(crate) fn lanes(&self, group: BandGroup) -> Lanes {
        std::array::from_fn(|i| if i < group.count { self.at(group.first + i) } else { 0.0 })
    }

    /// Checks that there is one number or one for each band, from 0 to `max`.
    pub(crate) fn validate(&self, field: &str, bands: usize, max: f64) -> Result<(), ParameterError> {
        if self.0.len() != 1 && self.0.len() != bands {
            return Err(ParameterError::new(field, self.0.len(), "must have one number, or one for each band"));
        }
        match self.0.iter().find(|x| !(0.0..=max).contains(*x)) {
            Some(wrong) => {
                Err(ParameterError::new(field, wrong, "must be finite and not negative; a share of light 1 at most"))
            }
            None => Ok(()),
        }
    }
}

impl From<[f64; 3]> for Spectrum {
    fn from(rgb: [f64; 3]) -> Self {
        Self(rgb.to_vec())
    }
}
