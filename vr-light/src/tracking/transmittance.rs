//! Estimates of the transmittance along a ray.

use glam::DVec3;
use vr_core::Ray;

use super::walk::Walk;
use super::{FlightEnd, TrackedMedium};
use crate::medium::Medium;
use crate::random::RandomStream;

/// Estimator of a transmittance e^(−τ) through a medium that is known at points. All are free of bias; they differ in variance and cost.
///
/// # Examples
/// ```
/// use vr_light::TransmittanceEstimator;
///
/// assert_eq!(TransmittanceEstimator::default(), TransmittanceEstimator::ResidualRatio);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransmittanceEstimator {
    /// 1 if a free flight gets through, else 0. Its variance is T (1 − T); it stops at the first collision.
    Delta,
    /// Product of 1 − χ/μ over all tentative collisions (Novák, Selle & Jarosz, "Residual ratio tracking", SIGGRAPH Asia 2014).
    Ratio,
    /// Transmittance of a control extinction in each cell in closed form, times the product of 1 − (χ − control)/μ over tentative collisions, which
    /// come at the rate μ of what is left: nothing is left to chance where a medium is homogeneous.
    #[default]
    ResidualRatio,
}

/// Control extinction of a cell: the middle of its bounds, which halves the rate of collisions, or the lower bound.
///
/// With the middle c and μ = max − c, weights grow where χ < c: their mean square along L is at most exp(−2cL + 3μL), for χ = min. That is below 1
/// if max ≤ 5 min, whatever the medium does between its bounds. With the lower bound no weight ever exceeds 1.
fn control([min, max]: [f64; 2]) -> f64 {
    if max <= 5.0 * min { 0.5 * (min + max) } else { min }
}

/// Transmittance below which ratio tracking plays for the rest.
const SMALL: f64 = 1e-3;
/// Tentative collisions whose places are looked up together.
const TOGETHER: usize = 8;

/// Tentative collisions on a straight line, not looked up yet.
struct Tentative<'a> {
    medium: &'a dyn Medium,
    direction: DVec3,
    band: usize,
    count: usize,
    at: [DVec3; TOGETHER],
    /// Control extinction and rate.
    bounds: [[f64; 2]; TOGETHER],
}

impl Tentative<'_> {
    /// The weight after the collisions so far, which are forgotten then. Roulette: a small weight is dropped, or raised by as much as it is likely to be.
    fn weighted(&mut self, mut weight: f64, random: &mut RandomStream) -> f64 {
        let count = std::mem::take(&mut self.count);
        let mut extinctions = [0.0; TOGETHER];
        self.medium.extinctions(&self.at[..count], self.direction, self.band, &mut extinctions[..count]);
        for (extinction, [control, rate]) in extinctions[..count].iter().zip(&self.bounds) {
            weight *= 1.0 - (extinction - control) / rate;
            if weight == 0.0 {
                return 0.0;
            }
            if weight.abs() < SMALL {
                if random.uniform() * SMALL >= weight.abs() {
                    return 0.0;
                }
                weight = SMALL.copysign(weight);
            }
        }
        weight
    }
}

impl TransmittanceEstimator {
    /// All estimators.
    pub const ALL: [Self; 3] = [Self::Delta, Self::Ratio, Self::ResidualRatio];
}

impl TrackedMedium {
    /// An estimate of the transmittance of one band along a ray up to the world distance `far`, whose expectation is right. Light travels
    /// against the ray.
    pub fn transmittance(
        &self,
        ray: &Ray,
        far: f64,
        band: usize,
        estimator: TransmittanceEstimator,
        random: &mut RandomStream,
    ) -> f64 {
        match estimator {
            TransmittanceEstimator::Delta => {
                let passed = self.fly(ray, far, band, random) == FlightEnd::Passed;
                f64::from(u8::from(passed))
            }
            TransmittanceEstimator::Ratio => self.weighted(ray, far, band, random, |_| 0.0),
            TransmittanceEstimator::ResidualRatio => self.weighted(ray, far, band, random, control),
        }
    }

    /// Ratio tracking about a control extinction in each cell, of its bounds.
    fn weighted(
        &self,
        ray: &Ray,
        far: f64,
        band: usize,
        random: &mut RandomStream,
        control: impl Fn([f64; 2]) -> f64,
    ) -> f64 {
        // The depth of the controls is subtracted in one exponential: light that the controls let through is known before the walk is done.
        let (mut controlled, mut weight) = (0.0, 1.0);
        let mut depth = random.exponential();
        let mut tentative = Tentative {
            medium: self.medium(),
            direction: -ray.direction,
            band,
            count: 0,
            at: [DVec3::ZERO; TOGETHER],
            bounds: [[0.0; 2]; TOGETHER],
        };
        for stretch in Walk::new(self.grid(), ray, far) {
            let cell = stretch.cell;
            if cell.max == 0.0 {
                continue;
            }
            let control = control([cell.min, cell.max]);
            // 0·∞ of a medium without end is nothing.
            if control > 0.0 {
                controlled += control * (stretch.end - stretch.start);
            }
            // e^(−746) is 0, and weights do not grow as fast as that falls.
            if controlled > 800.0 {
                return 0.0;
            }
            // Where bounds meet, rounding of the medium is all that is left; it is no reason for collisions.
            let rate = (cell.max - control).max(control - cell.min);
            if rate > 0.0 {
                let mut at = stretch.start;
                while depth < rate * (stretch.end - at) {
                    at += depth / rate;
                    tentative.at[tentative.count] = ray.origin + ray.direction * at;
                    tentative.bounds[tentative.count] = [control, rate];
                    tentative.count += 1;
                    depth = random.exponential();
                    if tentative.count == TOGETHER {
                        weight = tentative.weighted(weight, random);
                        if weight == 0.0 {
                            return 0.0;
                        }
                    }
                }
                depth -= rate * (stretch.end - at);
            }
        }
        if tentative.count > 0 {
            weight = tentative.weighted(weight, random);
        }
        libm::exp(-controlled) * weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{Coefficients, FunctionMedium};
    use std::sync::Arc;
    use vr_core::scattering::PhaseFunction;

    const RAY: Ray = Ray { origin: DVec3::new(-1.0, 0.3, 0.4), direction: DVec3::X };

    /// A medium of an extinction along x in the unit cube, with bounds in 10 cells.
    fn medium(
        extinction: impl Fn(f64) -> f64 + Clone + Send + Sync + 'static,
        range: impl Fn(f64, f64) -> [f64; 2] + Send + Sync + 'static,
    ) -> TrackedMedium {
        let whole = [0.0, range(0.0, 1.0)[1]];
        let medium =
            FunctionMedium::new((DVec3::ZERO, DVec3::ONE), 1, PhaseFunction::Isotropic, whole, move |p, _, _| {
                Coefficients { absorption: extinction(p.x), ..Coefficients::default() }
            });
        let medium = medium.unwrap().with_ranges([10, 1, 1], move |low, high| range(low.x, high.x));
        TrackedMedium::new(Arc::new(medium))
    }

    /// Mean and its standard error over `count` estimates.
    fn mean(medium: &TrackedMedium, estimator: TransmittanceEstimator, count: u64, seed: u64) -> [f64; 2] {
        let (mut sum, mut squares) = (0.0, 0.0);
        for sample in 0..count {
            let mut random = RandomStream::new(seed, 0, sample);
            let value = medium.transmittance(&RAY, f64::INFINITY, 0, estimator, &mut random);
            sum += value;
            squares += value * value;
        }
        let n = count as f64;
        let variance = (squares / n - (sum / n).powi(2)).max(0.0);
        [sum / n, (variance / n).sqrt()]
    }

    /// Media with their optical depths: a ramp, blocks between vacuum, contrast of 10⁶, a thin wall in vacuum.
    fn media() -> Vec<(TrackedMedium, f64)> {
        let ramp = |x: f64| 6.0 * x;
        let blocks = |x: f64| if ((5.0 * x) as u32).is_multiple_of(2) { 2.5 } else { 0.0 };
        let contrast = |x: f64| 1e-3 + 1e3 * (-((x - 0.5) / 1e-3).powi(2)).exp();
        let wall = |x: f64| if (0.501..0.503).contains(&x) { 400.0 } else { 0.0 };
        // Bounds of the bell in a cell: at the point nearest the middle, and the one furthest away.
        let bell = move |a: f64, b: f64| {
            let far = if (a - 0.5).abs() > (b - 0.5).abs() { a } else { b };
            [contrast(far), contrast(0.5f64.clamp(a, b))]
        };
        vec![
            (medium(ramp, move |a, b| [ramp(a), ramp(b)]), 3.0),
            (medium(blocks, |_, _| [0.0, 2.5]), 1.5),
            (medium(contrast, bell), 1e-3 + std::f64::consts::PI.sqrt()),
            (medium(wall, |a, b| if a < 0.503 && b > 0.501 { [0.0, 400.0] } else { [0.0; 2] }), 0.8),
        ]
    }

    #[test]
    fn estimators_have_no_bias() {
        let (mut beyond, mut cases) = (0, 0);
        for (m, (medium, depth)) in media().into_iter().enumerate() {
            for (e, estimator) in TransmittanceEstimator::ALL.into_iter().enumerate() {
                for seed in 0..8 {
                    let [mean, error] = mean(&medium, estimator, 4000, 1000 * m as u64 + 100 * e as u64 + seed);
                    let z = ((mean - (-depth).exp()) / error).abs();
                    assert!(z < 5.0, "medium {m}, {estimator:?}: {z} standard errors");
                    beyond += usize::from(z > 3.0);
                    cases += 1;
                }
            }
        }
        // Beyond 3 standard errors are 0.27 % of normal means, here 0.26 of 96; skew of few rare events may add some.
        assert!(cases == 96 && beyond <= 2, "{beyond} of {cases} beyond 3 standard errors");
    }

    #[test]
    fn extremes_of_extinction_come_out_right() {
        for exponent in -12..=12 {
            let extinction = 10f64.powi(exponent);
            let medium = medium(move |_| extinction, move |_, _| [0.5 * extinction, 2.0 * extinction]);
            let (truth, n) = ((-extinction).exp(), 2000f64);
            for estimator in TransmittanceEstimator::ALL {
                let [mean, _] = mean(&medium, estimator, 2000, 77);
                // Mean squares of the weights under χ = 1, in units of extinction: of a bound μ = 2 about 0, and of μ = 0.75 about 1.25.
                let square = match estimator {
                    TransmittanceEstimator::Delta => truth,
                    TransmittanceEstimator::Ratio => (extinction * (-2.0 + 1.0 / 2.0)).exp(),
                    TransmittanceEstimator::ResidualRatio => (extinction * (-2.0 + 0.25 * 0.25 / 0.75)).exp(),
                };
                // Roulette raises weights below 10⁻³ to that.
                let roulette = SMALL * truth;
                let error = ((square - truth * truth).max(0.0) + roulette).sqrt() / n.sqrt();
                assert!((mean - truth).abs() <= 4.0 * error, "{extinction} {estimator:?}: {mean} for {truth}, {error}");
            }
        }
    }

    #[test]
    fn ratios_have_less_variance_than_free_flights() {
        for (medium, _) in media() {
            let errors = TransmittanceEstimator::ALL.map(|estimator| mean(&medium, estimator, 4000, 5)[1]);
            // In a medium of vacuum and one extinction, all are the same but for chance.
            assert!(errors[1] <= 1.05 * errors[0] && errors[2] <= 1.05 * errors[1], "{errors:?}");
        }
    }
}
