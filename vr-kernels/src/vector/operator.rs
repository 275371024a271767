//! Compositing operators, as kernels on sixteen lanes tell them apart.

use vr_core::{Calibration, Compositing};

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
        /// In stored units.
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
}

#[cfg(test)]
mod tests {
    use super::*;

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
