//! What pixels have gathered so far, and the blend states that say how.

use vr_core::optics::depth_of_opacity;
use vr_kernels::vector::{LANES, Lanes};

/// A blend state: how a fragment is put onto a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operator {
    /// Front to back: C ← C + (1 − A)·c, A ← A + (1 − A)·α, up to an opacity `level`.
    Under { level: f32 },
    /// Back to front: C ← c + (1 − α)·C, A ← α + (1 − α)·A.
    Over,
    /// The largest value times `sign`.
    Extreme { sign: f32 },
    /// The mean value, by length.
    Average,
    /// The first sample whose value times `sign` is at least `threshold` times `sign`: alpha test.
    First { sign: f32, threshold: f32 },
}

impl Operator {
    /// Whether fragments are values, not light.
    pub(crate) fn picks(self) -> bool {
        matches!(self, Self::Extreme { .. } | Self::Average | Self::First { .. })
    }

    /// Whether samples are wanted on the faces of slabs, where rays enter and leave among them.
    pub(crate) fn wants_faces(self) -> bool {
        matches!(self, Self::Extreme { .. } | Self::First { .. })
    }
}

/// Sixteen pixels.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Light and opacity: their sum, what rounding lost of it, and where opacity reaches a half ([`vr_kernels::vector::Sums`]).
    pub(crate) sums: [[Lanes; 4]; 3],
    /// The value picked (of an average the sum of values by length), or the number of the sample that passed a test.
    pub(crate) value: Lanes,
    /// Of an average, the length; of a test, the number of the sample before.
    pub(crate) other: Lanes,
    /// What the sum of values has lost by rounding.
    pub(crate) lost: Lanes,
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
        }
    }

    /// The number at which a pixel's opacity reaches a half, the medium being homogeneous in the slab in which it does; +∞ where it does not.
    ///
    /// (1 − A)(1 − α)^x = ½ at the fraction x of the slab.
    pub(crate) fn half(&self, pixel: usize) -> f32 {
        let [begin, length, before, alpha] = self.sums[2].map(|lanes| lanes.0[pixel]);
        if begin == f32::INFINITY || alpha >= 1.0 {
            return begin;
        }
        let wanted = (1.0 - 0.5 / (1.0 - f64::from(before))).max(0.0);
        let share = depth_of_opacity(wanted) / depth_of_opacity(f64::from(alpha)).max(f64::MIN_POSITIVE);
        begin + length * share.min(1.0) as f32
    }
}
