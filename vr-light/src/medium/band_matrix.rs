//! Inelastic scattering: from band to band.

use vr_core::ParameterError;

/// Share of the light scattered in each band that goes on in each band: fluorescence, Raman scattering. Without one, light stays in its band.
///
/// # Examples
/// ```
/// use vr_light::BandMatrix;
///
/// // A third of what is scattered in the first band comes out in the second.
/// let shift = BandMatrix::new(vec![vec![2.0 / 3.0, 1.0 / 3.0], vec![0.0, 1.0]])?;
/// assert_eq!(shift.share(0, 1), 1.0 / 3.0);
/// assert_eq!(shift.bands(), 2);
/// assert!(BandMatrix::new(vec![vec![0.5]]).is_err(), "half of the light is lost");
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BandMatrix {
    rows: Vec<Vec<f64>>,
    /// Sums of the columns.
    sums: Vec<f64>,
}

/// Largest difference of the sum of a row from 1 that rounding of the caller's numbers excuses.
const ROUNDING: f64 = 1e-9;

impl BandMatrix {
    /// A matrix of rows, one for each band before scattering, with the shares of all bands after it. Each row is divided by its sum, so that
    /// scattering neither makes nor loses light.
    ///
    /// # Errors
    /// No row, rows that are not as long as there are rows, shares that are negative or not finite, or a row whose sum is not 1 within 10⁻⁹.
    pub fn new(mut rows: Vec<Vec<f64>>) -> Result<Self, ParameterError> {
        let bands = rows.len();
        let field = |row: usize| format!("scattering.bands[{row}]");
        if bands == 0 {
            return Err(ParameterError::new("scattering.bands", "none", "must have one row for each band"));
        }
        for (i, row) in rows.iter_mut().enumerate() {
            let sum: f64 = row.iter().sum();
            if row.len() != bands {
                return Err(ParameterError::new(field(i), row.len(), "must have one share for each band"));
            }
            if row.iter().any(|share| share.is_nan() || *share < 0.0) || (sum - 1.0).abs() > ROUNDING {
                return Err(ParameterError::new(field(i), &*row, "must be shares, 0 or more, whose sum is 1"));
            }
            row.iter_mut().for_each(|share| *share /= sum);
        }
        let sums = (0..bands).map(|to| rows.iter().map(|row| row[to]).sum()).collect();
        Ok(Self { rows, sums })
    }

    /// Number of bands.
    pub fn bands(&self) -> usize {
        self.rows.len()
    }

    /// Share of the light scattered in the band `from` that goes on in the band `to`.
    pub fn share(&self, from: usize, to: usize) -> f64 {
        self.rows[from][to]
    }

    /// A random band from which light of the band `to` came, of a number uniform in [0, 1), and the weight of that choice; `None` if light comes
    /// from none.
    pub fn sample_source(&self, to: usize, uniform: f64) -> Option<(usize, f64)> {
        let mut left = uniform * self.sums[to];
        let shares = || self.rows.iter().map(|row| row[to]).enumerate().filter(|(_, share)| *share > 0.0);
        let found = shares().find(|(_, share)| {
            left -= share;
            left < 0.0
        });
        // Rounding of the sum may leave a last bit: it belongs to the last band that counts.
        found.or_else(|| shares().next_back()).map(|(from, _)| (from, self.sums[to]))
    }

    /// A random band in which light of the band `from` goes on, of a number uniform in [0, 1).
    pub fn sample_target(&self, from: usize, uniform: f64) -> usize {
        let mut left = uniform;
        let row = &self.rows[from];
        let found = row.iter().position(|share| {
            left -= share;
            left < 0.0
        });
        found.or_else(|| row.iter().rposition(|share| *share > 0.0)).unwrap_or(from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_checked() {
        for wrong in
            [vec![], vec![vec![0.9]], vec![vec![1.0, 0.0]], vec![vec![-1.0, 2.0], vec![0.0, 1.0]], vec![vec![f64::NAN]]]
        {
            assert!(BandMatrix::new(wrong).is_err());
        }
    }

    #[test]
    fn bands_are_drawn_by_their_shares() {
        let matrix = BandMatrix::new(vec![vec![0.25, 0.75], vec![0.0, 1.0]]).unwrap();
        assert_eq!([0.1, 0.3, 0.9].map(|u| matrix.sample_target(0, u)), [0, 1, 1]);
        assert_eq!(matrix.sample_source(0, 0.99), Some((0, 0.25)));
        // Into the second band come 0.75 of the first and all of the second.
        assert_eq!(matrix.sample_source(1, 0.4), Some((0, 1.75)));
        assert_eq!(matrix.sample_source(1, 0.5), Some((1, 1.75)));
        assert_eq!(BandMatrix::new(vec![vec![0.0, 1.0]; 2]).unwrap().sample_source(0, 0.5), None);
    }
}
