//! Measured or computed phase functions.

use std::sync::Arc;

use crate::error::ParameterError;

/// A phase function given by its values at some cosines, linear in the cosine between them.
///
/// # Examples
/// ```
/// use vr_core::scattering::TabulatedPhase;
///
/// // Only relative values matter: they are normalised.
/// let table = TabulatedPhase::new(&[[-1.0, 0.0], [1.0, 7.0]])?;
/// assert!((table.value(1.0) - 2.0).abs() < 1e-15);
/// assert!((table.mean_cosine() - 1.0 / 3.0).abs() < 1e-15);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TabulatedPhase {
    /// Cosine and normalised value, the cosines rising from −1 to 1.
    points: Arc<[[f64; 2]]>,
    /// Probability of a cosine at most that of each point.
    cumulative: Arc<[f64]>,
}

impl TabulatedPhase {
    /// Makes a phase function of cosines, rising from −1 to 1, and values in any unit.
    ///
    /// # Errors
    /// Fewer than two points, cosines that do not rise from −1 to 1, values that are negative, not finite, or nowhere above 0.
    pub fn new(points: &[[f64; 2]]) -> Result<Self, ParameterError> {
        let wrong = |what: &str, found: &dyn std::fmt::Debug, allowed| {
            Err(ParameterError::new(format!("scattering.phase.{what}"), found, allowed))
        };
        let [first, .., last] = points else {
            return wrong("points", &points.len(), "must be 2 points or more");
        };
        for (i, [_, value]) in points.iter().enumerate() {
            if !(0.0..f64::INFINITY).contains(value) {
                return wrong(&format!("points[{i}].value"), value, "must be finite and not negative");
            }
        }
        for (i, pair) in points.windows(2).enumerate() {
            let rises = pair[0][0] < pair[1][0];
            if !rises {
                let cosines = [pair[0][0], pair[1][0]];
                return wrong(&format!("points[{}].cosine", i + 1), &cosines, "must be above the cosine before");
            }
        }
        if [first[0], last[0]] != [-1.0, 1.0] {
            return wrong("points", &[first[0], last[0]], "cosines must run from -1 to 1");
        }
        let max = points.iter().map(|p| p[1]).fold(0.0, f64::max);
        if max == 0.0 {
            return wrong("points", &max, "some value must be above 0");
        }
        // Relative to the largest value, so that no sum overflows.
        let mut points: Arc<[[f64; 2]]> = points.iter().map(|p| [p[0], p[1] / max]).collect();
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        for pair in points.windows(2) {
            sum += 0.5 * (pair[1][0] - pair[0][0]) * (pair[0][1] + pair[1][1]);
            cumulative.push(sum);
        }
        if sum.is_normal() {
            for point in Arc::make_mut(&mut points) {
                point[1] *= 2.0 / sum;
            }
            Ok(Self { points, cumulative: cumulative.iter().map(|c| c / sum).collect() })
        } else {
            wrong("points", &sum, "the integral over the cosine must be above 0")
        }
    }

    /// Cosines and normalised values.
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    /// p at the cosine of an angle.
    pub fn value(&self, cosine: f64) -> f64 {
        let cosine = cosine.clamp(-1.0, 1.0);
        let i = self.points.partition_point(|p| p[0] <= cosine).clamp(1, self.points.len() - 1);
        let ([x0, a], [x1, b]) = (self.points[i - 1], self.points[i]);
        let t = (cosine - x0) / (x1 - x0);
        a * (1.0 - t) + b * t
    }

    /// Mean of the cosine over scattered light.
    pub fn mean_cosine(&self) -> f64 {
        let moment = |p: &[[f64; 2]]| {
            let ([x0, a], [x1, b]) = (p[0], p[1]);
            (x1 - x0) * (a * (2.0 * x0 + x1) + b * (x0 + 2.0 * x1)) / 12.0
        };
        self.points.windows(2).map(moment).sum()
    }

    /// Largest value of p.
    pub fn max_value(&self) -> f64 {
        self.points.iter().map(|p| p[1]).fold(0.0, f64::max)
    }

    /// Cosine of a random angle, of a number uniform in [0, 1): the exact inverse of the cumulative distribution.
    pub fn sample_cosine(&self, uniform: f64) -> f64 {
        let below = 1.0 - uniform;
        let i = self.cumulative.partition_point(|&c| c < below).clamp(1, self.points.len() - 1);
        let ([x0, a], [x1, b]) = (self.points[i - 1], self.points[i]);
        // a x + (b − a) x²/(2h) = t, by the form of the root that does not cancel where the slope is small.
        let (h, t) = (x1 - x0, 2.0 * (below - self.cumulative[i - 1]).max(0.0));
        let root = (a * a + 2.0 * (b - a) * t / h).max(0.0).sqrt();
        let x = if t > 0.0 { 2.0 * t / (a + root) } else { 0.0 };
        x0 + x.min(h)
    }
}
