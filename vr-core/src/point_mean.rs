//! Weighted means of what scattered points carry: their values, and their colours.

use glam::DVec3;

use crate::point_set::PointSet;

/// Sums of a mean at a place.
///
/// Each point adds its difference from one of them, the base. If all points carry the same value, the mean is exactly that value and its gradient
/// is exactly 0.
#[derive(Clone, Copy, Debug)]
struct MeanSums<const N: usize> {
    base: [f64; N],
    /// Σ w (c − base) W.
    sum: [f64; N],
    /// Σ w W.
    weight: f64,
    low: [f64; N],
    high: [f64; N],
}

impl<const N: usize> MeanSums<N> {
    /// The mean: within what the points carry, whatever rounding does.
    fn mean(&self) -> [f64; N] {
        // At the edge of a support its kernel may be 0 by rounding.
        let per_weight = if self.weight > 0.0 { 1.0 / self.weight } else { 0.0 };
        std::array::from_fn(|c| (self.base[c] + self.sum[c] * per_weight).clamp(self.low[c], self.high[c]))
    }
}

impl PointSet {
    /// Sums over what points near a place carry; `None` in vacuum.
    fn mean_sums<const N: usize>(&self, at: DVec3, carried: impl Fn(usize) -> [f64; N]) -> Option<MeanSums<N>> {
        let mut sums: Option<MeanSums<N>> = None;
        self.each_around(at, |k| {
            let (carried, weight) = (carried(k), self.weight_density(k) * self.kernel_at(k, at));
            let fresh = MeanSums { base: carried, sum: [0.0; N], weight: 0.0, low: carried, high: carried };
            let sums = sums.get_or_insert(fresh);
            sums.weight += weight;
            for c in 0..N {
                sums.sum[c] += weight * (carried[c] - sums.base[c]);
                (sums.low[c], sums.high[c]) = (sums.low[c].min(carried[c]), sums.high[c].max(carried[c]));
            }
        });
        sums
    }

    /// The weighted mean of the values at a world position; `None` in vacuum.
    pub(crate) fn mean_at(&self, at: DVec3) -> Option<f64> {
        let [mean] = self.mean_sums(at, |k| [f64::from(self.values()[k])])?.mean();
        Some(mean)
    }

    /// The gradient of the mean, (Σ w (v − mean) ∇W) / Σ w W by the quotient rule; `None` in vacuum.
    pub(crate) fn mean_gradient_at(&self, at: DVec3) -> Option<DVec3> {
        let sums = self.mean_sums(at, |k| [f64::from(self.values()[k])])?;
        // There is no gradient if all points carry the same value, or if all kernels round to 0.
        if sums.low == sums.high || sums.weight <= 0.0 {
            return Some(DVec3::ZERO);
        }
        let [mean] = sums.mean();
        let mut rise = DVec3::ZERO;
        self.each_around(at, |k| {
            let apart = f64::from(self.values()[k]) - mean;
            rise += self.kernel_gradient(k, at) * (self.weight_density(k) * apart);
        });
        Some(rise / sums.weight)
    }

    /// The colour at a world position, the weighted mean of those of the points; `None` in vacuum, and of points that have none.
    pub fn color_at(&self, at: DVec3) -> Option<[f64; 3]> {
        let colors = self.colors()?;
        Some(self.mean_sums(at, |k| colors[k].map(f64::from))?.mean())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PointKernel, PointMixing};
    use proptest::prelude::*;

    fn clouds() -> impl Strategy<Value = PointSet> {
        let place = prop::array::uniform3(-1.0f64..1.0);
        let one = (place, 0.3f32..0.9, 0.1f32..4.0, -2.0f32..3.0);
        let kernel = prop::sample::select(PointKernel::ALL.to_vec());
        (prop::collection::vec(one, 1..40), kernel).prop_map(|(all, kernel)| {
            let positions = all.iter().map(|p| p.0.into()).collect();
            let radii = all.iter().map(|p| p.1).collect();
            let weights = all.iter().map(|p| p.2).collect();
            let values = all.iter().map(|p| p.3).collect();
            let points = PointSet::new(positions, radii, weights, values, kernel).unwrap();
            points.with_mixing(PointMixing::Mean).unwrap()
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(11), failure_persistence: None, ..ProptestConfig::with_cases(128) })]

        #[test]
        fn a_mean_stays_within_the_values_and_is_the_one_value_of_all(points in clouds(), at in prop::array::uniform3(-1.2f64..1.2), value in -1e3f32..1e3) {
            let at = DVec3::from(at);
            let near = points.around(at);
            prop_assert_eq!(points.field(at).is_some(), !near.is_empty());
            if let Some(mean) = points.field(at) {
                let values = near.iter().map(|&k| f64::from(points.values()[k as usize]));
                let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
                prop_assert!(low <= mean && mean <= high, "{mean} beyond {low} and {high}");
                // The quotient of both sums, which rounds more.
                let weight: f64 = near.iter().map(|&k| points.weight_density(k as usize) * points.kernel_at(k as usize, at)).sum();
                let sum: f64 = near.iter().map(|&k| points.contribution(k as usize, at)).sum();
                prop_assert!((sum / weight - mean).abs() < 1e-12, "{mean} for {}", sum / weight);
            }
            let count = points.count();
            let same = PointSet::new(points.positions().to_vec(), points.radii().to_vec(), points.weights().to_vec(), vec![value; count], points.kernel()).unwrap();
            let same = same.with_mixing(PointMixing::Mean).unwrap().with_colors(vec![[0.25, 0.5, 1.0]; count]).unwrap();
            prop_assert_eq!(same.field(at), (!near.is_empty()).then_some(f64::from(value)));
            prop_assert_eq!(same.gradient(at), (!near.is_empty()).then_some(DVec3::ZERO));
            prop_assert_eq!(same.color_at(at), (!near.is_empty()).then_some([0.25, 0.5, 1.0]));
        }

        #[test]
        fn gradients_are_differences_of_the_mean(points in clouds(), at in prop::array::uniform3(-1.0f64..1.0)) {
            let (at, h) = (DVec3::from(at), 1e-6);
            // Where no edge, centre or core is within the differences, and kernels do not vanish.
            let smooth = |k: usize| {
                let t = at.distance(points.positions()[k]) / f64::from(points.radii()[k]);
                t > 0.01 && points.kernel().breakpoints().iter().all(|b| (t - b).abs() > 1e-2)
            };
            let (Some(gradient), true) = (points.gradient(at), (0..points.count()).all(smooth)) else { return Ok(()) };
            let value = |by: DVec3| points.field(at + by).unwrap();
            let difference = DVec3::from(DVec3::AXES.map(|a| (value(a * h) - value(-a * h)) / (2.0 * h)));
            // h² of third derivatives, which are at most the values by the cube of the distance of a cone's tip, and rounding of values by h.
            prop_assert!((gradient - difference).length() < 1e-5 * (1.0 + gradient.length()), "{gradient} for {difference}");
        }
    }
}
