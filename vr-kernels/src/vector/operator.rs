//! Compositing operators, as kernels on sixteen lanes distinguish them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::{Calibration, Compositing};

use super::{pick, splat};

/// Compositing operator on stored numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operator {
    /// Front to back: C ← C + (1 − A)·c, A ← A + (1 − A)·α, up to an opacity `level`.
    Under {
        /// Opacity to stop at; 1 for none.
        level: f32,
    },
    /// Back to front: C ← c + (1 − α)·C, A ← α + (1 − α)·A.
    Over,
    /// The largest value times `sign`.
    Extreme {
        /// −1 for the smallest stored number.
        sign: f32,
    },
    /// The mean value, by length.
    Average,
    /// The first value that, times `sign`, is at least `threshold` times `sign`.
    First {
        /// −1 where larger values have smaller stored numbers.
        sign: f32,
        /// Threshold in stored units.
        threshold: f32,
    },
}

impl Operator {
    /// The operator of a scene whose values are stored as `calibration` says; of light `back_to_front`, where no level cuts it.
    pub fn new(compositing: Compositing, calibration: Calibration, back_to_front: bool) -> Self {
        // A negative slope turns the order of stored numbers round.
        let sign = calibration.slope.signum() as f32;
        match compositing {
            Compositing::Accumulate { level } if level < 1.0 => Self::Under { level: level as f32 },
            Compositing::Over | Compositing::Accumulate { .. } if back_to_front => Self::Over,
            Compositing::Over | Compositing::Accumulate { .. } => Self::Under { level: 1.0 },
            Compositing::Maximum => Self::Extreme { sign },
            Compositing::Minimum => Self::Extreme { sign: -sign },
            Compositing::Average => Self::Average,
            Compositing::First { threshold } => Self::First { sign, threshold: calibration.stored(threshold) as f32 },
        }
    }

    /// True if it picks values; else it composites light.
    #[inline(always)]
    pub fn picks(self) -> bool {
        matches!(self, Self::Extreme { .. } | Self::Average | Self::First { .. })
    }

    /// Takes values over lengths, where there are any, into the value picked so far (of a mean, the sum of values by length) and its length, 0
    /// where there is none yet. Only for an extreme or a mean: others leave both as they are.
    #[inline(always)]
    pub fn choose<S: Simd>(
        self,
        simd: S,
        [so_far, sum]: [f32x16<S>; 2],
        [value, length]: [f32x16<S>; 2],
        there: mask32x16<S>,
    ) -> [f32x16<S>; 2] {
        let zero = splat(simd, 0.0);
        let sum_now = sum + pick(there, length, zero);
        match self {
            Self::Extreme { sign } => {
                let better = there & (sum.simd_le(zero) | (value * sign).simd_gt(so_far * sign));
                [pick(better, value, so_far), sum_now]
            }
            Self::Average => [so_far + pick(there, value * length, zero), sum_now],
            _ => [so_far, sum],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn extremes_and_means_of_what_is_there() {
        let picked = |operator: Operator| {
            dispatch!(Level::new(), simd => {
                let mut so_far = [splat(simd, 0.0); 2];
                for (value, length, there) in [(9.0, 1.0, false), (-3.0, 2.0, true), (-5.0, 0.5, true), (9.0, 1.0, false)] {
                    let length = splat(simd, length);
                    let there = splat(simd, if there { 1.0 } else { 0.0 }).simd_gt(splat(simd, 0.0));
                    so_far = operator.choose(simd, so_far, [splat(simd, value), length], there);
                }
                so_far.map(|x| x[4])
            })
        };
        assert_eq!(picked(Operator::Extreme { sign: 1.0 }), [-3.0, 2.5]);
        assert_eq!(picked(Operator::Extreme { sign: -1.0 }), [-5.0, 2.5]);
        assert_eq!(picked(Operator::Average), [-8.5, 2.5]);
    }

    #[test]
    fn a_negative_slope_turns_values_round() {
        let negative = Calibration { slope: -2.0, intercept: 1.0 };
        let of = |compositing, back_to_front| Operator::new(compositing, negative, back_to_front);
        assert_eq!(of(Compositing::Maximum, false), Operator::Extreme { sign: -1.0 });
        assert_eq!(of(Compositing::Minimum, false), Operator::Extreme { sign: 1.0 });
        assert_eq!(of(Compositing::First { threshold: 5.0 }, false), Operator::First { sign: -1.0, threshold: -2.0 });
        assert_eq!(of(Compositing::Accumulate { level: 1.0 }, true), Operator::Over);
        assert_eq!(of(Compositing::Accumulate { level: 0.5 }, true), Operator::Under { level: 0.5 });
        assert_eq!(of(Compositing::Over, false), Operator::Under { level: 1.0 });
        assert!(of(Compositing::Average, false).picks() && !of(Compositing::Over, true).picks());
    }
}
