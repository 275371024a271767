//! State of pixels between fragments.

use vr_core::optics::fraction_to_level;
use vr_kernels::vector::{LANES, Lanes, Operator};

/// Sixteen pixels.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Light and opacity: their sum, what rounding lost of it, and where opacity reaches a half ([`vr_kernels::vector::Sums`]).
    pub(crate) sums: [[Lanes; 4]; 3],
    /// The value picked (of an average the sum of values by length), or the number of the sample that passed a test.
    pub(crate) value: Lanes,
    /// Length, of an average; number of the sample before, of a test; number of the value picked, of an extreme.
    pub(crate) other: Lanes,
    /// Rounding error of the sum of values.
    pub(crate) lost: Lanes,
    /// Back to front: where each fragment begins, how long it is, and its opacity. What hides a half is known once all are drawn.
    pub(crate) over: Vec<[Lanes; 3]>,
}

impl State {
    /// Nothing drawn yet.
    pub(crate) fn new(operator: Operator) -> Self {
        let nowhere = [Lanes([f32::INFINITY; LANES]), Lanes::ZERO, Lanes::ZERO, Lanes::ZERO];
        let value = match operator {
            Operator::Extreme { .. } => f32::NEG_INFINITY,
            Operator::First { .. } => f32::INFINITY,
            _ => 0.0,
        };
        Self {
            sums: [[Lanes::ZERO; 4], [Lanes::ZERO; 4], nowhere],
            value: Lanes([value; LANES]),
            other: Lanes::ZERO,
            lost: Lanes::ZERO,
            over: Vec::new(),
        }
    }

    /// The number at which opacity, summed from the eye on, reaches a half, of fragments that were drawn back to front: their numbers grow towards the eye.
    pub(crate) fn half_from_behind(&self, pixel: usize) -> f32 {
        let mut clear = 1.0f64;
        for fragment in self.over.iter().rev() {
            let [begin, length, alpha] = fragment.each_ref().map(|lanes| lanes.0[pixel]);
            let behind = clear * (1.0 - f64::from(alpha));
            if behind <= 0.5 {
                return begin + length * (1.0 - fraction_to_level(clear, alpha.into(), 0.5) as f32);
            }
            clear = behind;
        }
        f32::INFINITY
    }

    /// The number at which a pixel's opacity reaches a half, the medium being homogeneous in the slab in which it does; +∞ where it does not.
    pub(crate) fn half(&self, pixel: usize) -> f32 {
        let [begin, length, before, alpha] = self.sums[2].map(|lanes| lanes.0[pixel]);
        if begin == f32::INFINITY {
            return begin;
        }
        begin + length * fraction_to_level(1.0 - f64::from(before), alpha.into(), 0.5) as f32
    }
}
