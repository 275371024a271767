//! Choice among the values along sixteen rays.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Cells, LANES, Lanes, Operator, pick, splat};

use crate::packet::fields::PacketField;
use crate::packet::march::in_lanes;

/// Values and positions that the rays have picked so far.
pub(crate) struct Choice<S: Simd> {
    /// Value times the sign of an extreme; of a mean, the sum of values by length.
    pub(crate) value: f32x16<S>,
    /// Excess of a sum over what was added, by its roundings.
    lost: f32x16<S>,
    /// Sum of lengths; 0 where nothing was picked.
    pub(crate) length: f32x16<S>,
    /// Position of the sample picked.
    pub(crate) at: f32x16<S>,
    /// Position at which a threshold was not reached yet.
    pub(crate) before: f32x16<S>,
}

impl<S: Simd> Choice<S> {
    /// Rays that have picked nothing.
    #[inline(always)]
    pub(crate) fn new(simd: S, operator: Operator) -> Self {
        let zero = splat(simd, 0.0);
        let is_extreme = matches!(operator, Operator::Extreme { .. });
        let value = if is_extreme { splat(simd, f32::NEG_INFINITY) } else { zero };
        Self { value, lost: zero, length: zero, at: zero, before: zero }
    }

    /// Takes the values of live rays at positions, each behind another one and standing for a length.
    #[inline(always)]
    pub(crate) fn take(
        &mut self,
        simd: S,
        operator: Operator,
        live: mask32x16<S>,
        [before, at, length]: [f32x16<S>; 3],
        value: f32x16<S>,
    ) {
        let zero = splat(simd, 0.0);
        match operator {
            Operator::Average => {
                // Losses by rounding are summed beside it, as in `Sums`.
                let added = pick(live, value * length, zero);
                let sum = self.value + added;
                self.lost += (sum - self.value) - added;
                self.value = sum;
                self.length += pick(live, length, zero);
            }
            Operator::Extreme { sign } => {
                let better = live & (value * sign).simd_gt(self.value);
                self.value = pick(better, value * sign, self.value);
                self.at = pick(better, at, self.at);
                self.length = pick(better, splat(simd, 1.0), self.length);
            }
            Operator::First { sign, threshold } => {
                let reached = live & (value * sign).simd_ge(splat(simd, threshold * sign)) & self.length.simd_le(zero);
                self.value = pick(reached, value, self.value);
                self.before = pick(reached, before, self.before);
                self.at = pick(reached, at, self.at);
                self.length = pick(reached, splat(simd, 1.0), self.length);
            }
            Operator::Under { .. } | Operator::Over => {}
        }
    }

    /// Rays that need not go on.
    #[inline(always)]
    pub(crate) fn done(&self, simd: S, operator: Operator) -> mask32x16<S> {
        let is_first = if matches!(operator, Operator::First { .. }) { 0.0 } else { f32::INFINITY };
        self.length.simd_gt(splat(simd, is_first))
    }

    /// Takes the middle positions of the steps in which a threshold is reached, and the values there, in the place of the ends where it is reached too, or else
    /// of the begins.
    #[inline(always)]
    pub(crate) fn halve(&mut self, _: S, reached: mask32x16<S>, middle: f32x16<S>, value: f32x16<S>) {
        self.value = pick(reached, value, self.value);
        self.at = pick(reached, middle, self.at);
        self.before = pick(reached, self.before, middle);
    }

    /// The numbers picked; of means, sums of numbers by length.
    #[inline(always)]
    pub(crate) fn number(&self, operator: Operator) -> f32x16<S> {
        match operator {
            Operator::Extreme { sign } => self.value * sign,
            _ => self.value - self.lost,
        }
    }
}

/// Sums of colours by length, of means.
pub(super) struct MeanColor {
    sum: [Lanes; 3],
    /// Excess of the sums over what was added, by their roundings.
    lost: [Lanes; 3],
}

impl MeanColor {
    pub(super) const NONE: Self = Self { sum: [Lanes::ZERO; 3], lost: [Lanes::ZERO; 3] };

    /// Adds the colours of the places of live rays that were fetched last, each standing for a length; `stage` is used up.
    #[inline(always)]
    pub(super) fn take<S: Simd, T: PacketField>(
        &mut self,
        simd: S,
        field: &T,
        live: mask32x16<S>,
        (at, length): (&Cells<S>, f32x16<S>),
        stage: &mut T::Stage,
    ) {
        let zero = splat(simd, 0.0);
        let mut color = [Lanes([1.0; LANES]); 4];
        field.look(simd, None, &in_lanes(at), &[Lanes::ZERO; 3], None, &mut color, stage);
        for c in 0..3 {
            let (before, added) = (self.sum[c].load(simd), pick(live, color[c].load(simd) * length, zero));
            let sum = before + added;
            self.lost[c] = Lanes::new(self.lost[c].load(simd) + ((sum - before) - added));
            self.sum[c] = Lanes::new(sum);
        }
    }

    /// Sums of a ray.
    pub(super) fn of_lane(&self, lane: usize) -> [f64; 3] {
        [0, 1, 2].map(|c| f64::from(self.sum[c].0[lane] - self.lost[c].0[lane]))
    }
}
