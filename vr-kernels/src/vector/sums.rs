//! Sums of light and opacity along sixteen rays.

use super::{LANES, Lanes, depth_of_opacity, pick, splat};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

/// The share of homogeneous steps up to which opacity reaches a level, behind transparency `clear`; 1 where it does not. And a mask of the
/// rays on which it does. Light goes with opacity: what is behind the level, or shines in what is clear there, has no share.
#[inline(always)]
pub fn share_to_level<S: Simd, V: SimdFloat<S, Element = f32>>(
    simd: S,
    clear: V,
    alpha: V,
    level: f32,
) -> (V, V::Mask) {
    let (zero, one) = (V::splat(simd, 0.0), V::splat(simd, 1.0));
    let (adds, room) = (clear * alpha, (clear - (1.0 - level)).max(zero));
    let reached = adds.simd_ge(room);
    let divisor = adds.simd_gt(zero).select(adds, one);
    (reached.select(room / divisor, one), reached)
}

/// C ← C + (1 − A)·c, A ← A + (1 − A)·α, front to back, with compensated sums.
///
/// Beside each sum goes the sum of what its roundings lost (Neumaier 1974, "Rundungsfehleranalyse einiger Verfahren zur Summation
/// endlicher Summen"), so thousands of steps of α = 10⁻⁷ add up behind an opacity that would swallow each of them. Adding nothing changes
/// nothing, bit for bit: where the medium is clear, it does not matter whether a sample is taken. (Kahan's sum, which feeds what was lost
/// into the next addition, does not have that: where exactly half a unit in the last place is left, nothing may round it in.)
pub struct Sums<S: Simd> {
    /// r, g, b and opacity.
    sum: [f32x16<S>; 4],
    /// Excess of each sum over what was added, by its roundings.
    lost: [f32x16<S>; 4],
    /// The step in which opacity reaches a half: where it begins, +∞ for none yet; its length; the opacity before it, and its own.
    half: [f32x16<S>; 4],
}

impl<S: Simd> Sums<S> {
    /// Sums of nothing yet.
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        let (zero, never) = (splat(simd, 0.0), splat(simd, f32::INFINITY));
        Self { sum: [zero; 4], lost: [zero; 4], half: [never, zero, zero, zero] }
    }

    /// Loads the sums that [`Self::store`] left.
    #[inline(always)]
    pub fn load(simd: S, [sum, lost, half]: &[[Lanes; 4]; 3]) -> Self {
        let all = |four: &[Lanes; 4]| [four[0].load(simd), four[1].load(simd), four[2].load(simd), four[3].load(simd)];
        Self { sum: all(sum), lost: all(lost), half: all(half) }
    }

    /// Stores the sums to memory, without loss.
    #[inline(always)]
    pub fn store(&self, [sum, lost, half]: &mut [[Lanes; 4]; 3]) {
        for c in 0..4 {
            sum[c] = Lanes::new(self.sum[c]);
            lost[c] = Lanes::new(self.lost[c]);
            half[c] = Lanes::new(self.half[c]);
        }
    }

    /// Transparency so far: the part that is still seen through.
    #[inline(always)]
    pub fn clear(&self, simd: S) -> f32x16<S> {
        splat(simd, 1.0) - self.opacity()
    }

    #[inline(always)]
    fn opacity(&self) -> f32x16<S> {
        self.sum[3] - self.lost[3]
    }

    /// Adds the light and opacity of one step, which begins at `begin` and is so long, to the live rays.
    #[inline(always)]
    pub fn add(&mut self, simd: S, live: mask32x16<S>, step: [f32x16<S>; 2], light: [f32x16<S>; 4]) {
        self.add_part(simd, live, step, light, light[3]);
    }

    /// Adds the light and opacity of one step, as [`add`](Self::add) does, up to an opacity `level`: of the step that reaches it, only the part before
    /// counts. Returns the live rays that reach it; nothing must be added behind it. A level of 1 cuts nothing.
    #[inline(always)]
    pub fn add_up_to(
        &mut self,
        simd: S,
        level: f32,
        live: mask32x16<S>,
        step: [f32x16<S>; 2],
        light: [f32x16<S>; 4],
    ) -> mask32x16<S> {
        // Two ways in the place of a share of 1: that would take a register from rays that are not cut.
        if level >= 1.0 {
            self.add(simd, live, step, light);
            return live & !live;
        }
        let [r, g, b, alpha] = light;
        let (share, reached) = share_to_level(simd, self.clear(simd), alpha, level);
        self.add_part(simd, live, step, [r * share, g * share, b * share, alpha * share], alpha);
        live & reached
    }

    /// Adds the light of a step or of a part of it; `whole` is the opacity of the whole step, by which the place of opacity ½ within it is found.
    #[inline(always)]
    fn add_part(
        &mut self,
        simd: S,
        live: mask32x16<S>,
        [begin, length]: [f32x16<S>; 2],
        light: [f32x16<S>; 4],
        whole: f32x16<S>,
    ) {
        let zero = splat(simd, 0.0);
        let before = self.opacity();
        let clear = pick(live, splat(simd, 1.0) - before, zero);
        for c in 0..4 {
            let added = clear * light[c];
            let sum = self.sum[c] + added;
            self.lost[c] += (sum - self.sum[c]) - added;
            self.sum[c] = sum;
        }
        let half = splat(simd, 0.5);
        let crossing = before.simd_lt(half) & self.opacity().simd_ge(half) & live;
        if crossing.any_true() {
            self.half[0] = pick(crossing, begin, self.half[0]);
            self.half[1] = pick(crossing, length, self.half[1]);
            self.half[2] = pick(crossing, before, self.half[2]);
            self.half[3] = pick(crossing, whole, self.half[3]);
        }
    }

    /// The sums.
    #[inline(always)]
    pub fn rgba(&self) -> [f32x16<S>; 4] {
        let [r, g, b, a] = self.sum;
        let lost = &self.lost;
        [r - lost[0], g - lost[1], b - lost[2], a - lost[3]]
    }

    /// Distance at which opacity reaches a half, the medium homogeneous within the step in which it does; +∞ where it does not.
    ///
    /// (1 − A)(1 − α)^x = ½ at the fraction x of the step.
    #[inline(always)]
    pub fn half(&self, simd: S) -> Lanes {
        let [begin, length, before, alpha] = self.half;
        if begin.simd_ge(splat(simd, f32::INFINITY)).all_true() {
            return Lanes([f32::INFINITY; LANES]);
        }
        let mut share = Lanes::ZERO;
        share_of_half(simd, &Lanes::new(before), &Lanes::new(alpha), &mut share);
        Lanes::new(begin + length * share.load(simd))
    }
}

/// Fractions of sixteen steps of opacity `alpha`, behind opacity `before`, at which a half is reached.
///
/// Its own function: few steps are those in which that happens.
#[inline(never)]
pub fn share_of_half<S: Simd>(simd: S, before: &Lanes, alpha: &Lanes, share: &mut Lanes) {
    simd.vectorize(
        #[inline(always)]
        || {
            let one = splat(simd, 1.0);
            let (before, alpha) = (before.load(simd), alpha.load(simd));
            let wanted = (one - splat(simd, 0.5) / (one - before)).max(splat(simd, 0.0));
            let whole = depth_of_opacity(simd, alpha).max(splat(simd, f32::MIN_POSITIVE));
            let part = (depth_of_opacity(simd, wanted) / whole).min(one);
            // An opaque step is so from its first point on.
            *share = Lanes::new(pick(alpha.simd_ge(one), splat(simd, 0.0), part));
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch, f32x4};

    #[test]
    fn a_level_cuts_the_step_that_reaches_it() {
        // (clear, opacity, share to the level ¾).
        let cases =
            [(1.0, 0.5, 1.0), (0.5, 1.0, 0.5), (0.5, 0.25, 1.0), (0.25, 0.5, 0.0), (0.25, 0.0, 0.0), (0.0, 1.0, 0.0)];
        for (clear, alpha, share) in cases {
            let (got, reached) = dispatch!(Level::new(), simd => {
                let (share, reached) = share_to_level(simd, splat(simd, clear), splat(simd, alpha), 0.75);
                (share[7], reached.all_true())
            });
            assert_eq!((got, reached), (share, share < 1.0), "{clear} {alpha}");
            let four = dispatch!(Level::new(), simd => {
                share_to_level(simd, f32x4::splat(simd, clear), f32x4::splat(simd, alpha), 0.75).0[2]
            });
            assert_eq!(four, share);
        }
    }
}
