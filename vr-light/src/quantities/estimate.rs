//! A mean with its standard error.

/// Mean of random samples, with its standard error.
///
/// # Examples
/// ```
/// use vr_light::quantities::Estimate;
///
/// let estimate: Estimate = [1.0, 3.0].into_iter().collect();
/// assert_eq!((estimate.mean, estimate.standard_error), (2.0, 1.0));
/// assert!(estimate.is_within(4.0, 3.0) && !estimate.is_within(6.0, 3.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean; +∞ of less than two samples.
    pub standard_error: f64,
}

impl Estimate {
    /// True if an expected number is within so many standard errors of the mean.
    pub fn is_within(&self, expected: f64, errors: f64) -> bool {
        // Sums of equal samples are off by their rounding alone.
        let rounding = 1e-10 * self.mean.abs().max(expected.abs());
        (self.mean - expected).abs() <= errors * self.standard_error + rounding
    }

    /// The same quantity in other units.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, standard_error: self.standard_error * factor.abs() }
    }
}

impl FromIterator<f64> for Estimate {
    /// Mean and error of samples, by Welford's updates: no square of the mean is subtracted.
    fn from_iter<I: IntoIterator<Item = f64>>(samples: I) -> Self {
        let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
        for sample in samples {
            count += 1.0;
            let difference = sample - mean;
            mean += difference / count;
            squares += difference * (sample - mean);
        }
        let variance = if count > 1.0 { squares / (count - 1.0) } else { f64::INFINITY };
        Self { mean, standard_error: (variance / f64::max(count, 1.0)).sqrt() }
    }
}
