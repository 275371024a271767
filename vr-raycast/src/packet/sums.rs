//! What sixteen rays have gathered.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::elementary::depth_of_opacity;
use super::lanes::{Lanes, pick, splat};

/// C ← C + (1 − A)·c, A ← A + (1 − A)·α, front to back, with compensated sums.
///
/// Each sum carries what its roundings lost (Kahan 1965, "Further remarks on reducing truncation errors"), so thousands of steps of
/// α = 10⁻⁷ add up behind an opacity that would swallow each of them. Adding nothing changes nothing, bit for bit: where the
/// medium is clear, it does not matter whether a sample is taken.
pub(crate) struct Sums<S: Simd> {
    /// r, g, b and opacity.
    sum: [f32x16<S>; 4],
    /// What was added too much.
    lost: [f32x16<S>; 4],
    /// The step of the first sample with α > 0; +∞: none yet.
    first: f32x16<S>,
    /// The step in which opacity reaches a half, the opacity before it and its own; +∞: none yet.
    half: [f32x16<S>; 3],
}

impl<S: Simd> Sums<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        let (zero, never) = (splat(simd, 0.0), splat(simd, f32::INFINITY));
        Self { sum: [zero; 4], lost: [zero; 4], first: never, half: [never, zero, zero] }
    }

    /// What is still seen through.
    #[inline(always)]
    pub(crate) fn clear(&self, simd: S) -> f32x16<S> {
        splat(simd, 1.0) - self.sum[3]
    }

    /// Adds the light and opacity of one step, whose number is `step`, to the live rays. Says in which of them opacity reaches a half.
    #[inline(always)]
    pub(crate) fn add(&mut self, simd: S, live: mask32x16<S>, step: f32x16<S>, light: [f32x16<S>; 4]) -> mask32x16<S> {
        let zero = splat(simd, 0.0);
        let before = self.sum[3];
        let clear = pick(live, splat(simd, 1.0) - before, zero);
        for c in 0..4 {
            let added = clear * light[c] - self.lost[c];
            let sum = self.sum[c] + added;
            self.lost[c] = (sum - self.sum[c]) - added;
            self.sum[c] = sum;
        }
        let visible = live & light[3].simd_gt(zero);
        self.first = pick(visible, self.first.min(step), self.first);
        let half = splat(simd, 0.5);
        let crossing = before.simd_lt(half) & self.sum[3].simd_ge(half) & live;
        if crossing.any_true() {
            for (kept, now) in self.half.iter_mut().zip([step, before, light[3]]) {
                *kept = pick(crossing, now, *kept);
            }
        }
        crossing
    }

    /// The sums.
    #[inline(always)]
    pub(crate) fn rgba(&self) -> [f32x16<S>; 4] {
        [0, 1, 2, 3].map(
            #[inline(always)]
            |c: usize| self.sum[c] - self.lost[c],
        )
    }

    /// The step of the first sample with α > 0; +∞ where there is none.
    #[inline(always)]
    pub(crate) fn first(&self) -> f32x16<S> {
        self.first
    }

    /// Where opacity reaches a half: the step, and the fraction of it before that, with the medium homogeneous within the step.
    ///
    /// (1 − A)(1 − α)^x = ½ at the fraction x.
    #[inline(always)]
    pub(crate) fn half(&self, simd: S) -> [Lanes; 2] {
        let [step, before, alpha] = self.half;
        let mut share = Lanes::ZERO;
        if step.simd_lt(splat(simd, f32::INFINITY)).any_true() {
            share_of_half(simd, &Lanes::of(before), &Lanes::of(alpha), &mut share);
        }
        [Lanes::of(step), share]
    }
}

/// The fraction of a step of opacity `alpha`, behind opacity `before`, at which a half is reached.
#[inline(never)]
fn share_of_half<S: Simd>(simd: S, before: &Lanes, alpha: &Lanes, share: &mut Lanes) {
    simd.vectorize(
        #[inline(always)]
        || {
            let one = splat(simd, 1.0);
            let (before, alpha) = (before.load(simd), alpha.load(simd));
            let wanted = (one - splat(simd, 0.5) / (one - before)).max(splat(simd, 0.0));
            let whole = depth_of_opacity(simd, alpha).max(splat(simd, f32::MIN_POSITIVE));
            let part = (depth_of_opacity(simd, wanted) / whole).min(one);
            // An opaque step is so from its first point on.
            *share = Lanes::of(pick(alpha.simd_ge(one), splat(simd, 0.0), part));
        },
    );
}
