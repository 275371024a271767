//! State of sixteen pixels, and the light or values of sheets that join it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::optics::fraction_to_level;
use vr_kernels::vector::{LANES, Lanes, Operator, pick, share_to_level, splat};

/// Sixteen pixels so far.
#[derive(Clone, Copy)]
pub(crate) struct State {
    /// Light; or sums of colours times lengths, where values are averaged of voxels that have colours.
    pub(crate) light: [Lanes; 3],
    /// Transmittance.
    pub(crate) clear: Lanes,
    /// A value picked, or a sum of values times lengths; of which there is none where `length` is 0.
    pub(crate) value: Lanes,
    pub(crate) length: Lanes,
    /// The depth of what is seen, +∞ for none: of light where the sheet begins in which opacity reaches a half; and of that sheet its thickness,
    /// the transmittance before it, and its opacity. Of the first value, second, the depth of the sheet before.
    pub(crate) seen: [Lanes; 4],
}

impl State {
    pub(crate) const EMPTY: Self = Self {
        light: [Lanes::ZERO; 3],
        clear: Lanes([1.0; LANES]),
        value: Lanes::ZERO,
        length: Lanes::ZERO,
        seen: [Lanes([f32::INFINITY; LANES]), Lanes::ZERO, Lanes::ZERO, Lanes::ZERO],
    };

    /// Depth that one of the pixels sees.
    pub(crate) fn depth(&self, operator: Operator, lane: usize) -> f64 {
        let [at, thickness, clear, alpha] = self.seen.map(|lanes| f64::from(lanes.0[lane]));
        match operator {
            // Its sheet is homogeneous.
            Operator::Under { .. } if at < f64::INFINITY => at + thickness * fraction_to_level(clear, alpha, 0.5),
            _ => at,
        }
    }

    /// Takes in light and opacity of what lies between two depths.
    #[inline(always)]
    pub(crate) fn blend<S: Simd>(
        &mut self,
        simd: S,
        operator: Operator,
        [r, g, b, alpha]: [f32x16<S>; 4],
        [from, to]: [f32x16<S>; 2],
    ) {
        let clear = self.clear.load(simd);
        let light = [r, g, b];
        match operator {
            Operator::Under { level } => {
                let one = splat(simd, 1.0);
                let (mut share, mut after) = (clear, clear * (one - alpha));
                if level < 1.0 {
                    let (part, reached) = share_to_level(simd, clear, alpha, level);
                    share *= part;
                    after = pick(reached, splat(simd, 1.0 - level).min(clear), after);
                }
                for c in 0..3 {
                    self.light[c] = Lanes::new(self.light[c].load(simd) + share * light[c]);
                }
                self.clear = Lanes::new(after);
                let half = splat(simd, 0.5);
                // The whole sheet decides, for light may end at a level within it.
                let reaches = clear.simd_gt(half) & (clear * (one - alpha)).simd_le(half);
                if reaches.any_true() {
                    for (seen, new) in self.seen.iter_mut().zip([from, to - from, clear, alpha]) {
                        *seen = Lanes::new(pick(reaches, new, seen.load(simd)));
                    }
                }
            }
            _ => {
                let rest = splat(simd, 1.0) - alpha;
                for c in 0..3 {
                    self.light[c] = Lanes::new(self.light[c].load(simd) * rest + light[c]);
                }
                self.clear = Lanes::new(clear * rest);
            }
        }
    }

    /// Takes in values over lengths of what lies between two depths, where the first mask is set; where the second one is, there is vacuum.
    #[inline(always)]
    pub(crate) fn choose<S: Simd>(
        &mut self,
        simd: S,
        operator: Operator,
        value: f32x16<S>,
        length: f32x16<S>,
        [there, vacuum]: [mask32x16<S>; 2],
        [from, to]: [f32x16<S>; 2],
    ) {
        let (before, sum) = (self.value.load(simd), self.length.load(simd));
        let zero = splat(simd, 0.0);
        let fresh = sum.simd_le(zero);
        let middle = (from + to) * 0.5;
        let seen = self.seen[0].load(simd);
        match operator {
            Operator::First { sign, threshold } => {
                let reaches = there & (value * sign).simd_ge(splat(simd, threshold * sign));
                let found = self.clear.load(simd).simd_le(zero);
                // Whatever comes before reaches less: what is found lies between two sheets, at the threshold, or it is the first of all or the
                // first behind vacuum.
                let at = pick(fresh, value, splat(simd, threshold));
                self.value = Lanes::new(pick(found, before, pick(reaches, at, value)));
                self.clear = Lanes::new(pick(reaches, zero, self.clear.load(simd)));
                self.length = Lanes::new(pick(vacuum & !found, zero, sum + pick(there, length, zero)));
                // Between the middles of two sheets the field is about linear; what is first of all is where it begins.
                let last = self.seen[1].load(simd);
                let rise = value - before;
                let share = (splat(simd, threshold) - before) / pick(rise.simd_eq(zero), splat(simd, 1.0), rise);
                let passed = last + (middle - last) * share.max(zero).min(splat(simd, 1.0));
                self.seen[0] = Lanes::new(pick(reaches & !found, pick(fresh, from, passed), seen));
                self.seen[1] = Lanes::new(pick(there, middle, last));
            }
            _ => {
                let [after, length] = operator.choose(simd, [before, sum], [value, length], there);
                if let Operator::Extreme { .. } = operator {
                    let better = there & (fresh | !after.simd_eq(before));
                    self.seen[0] = Lanes::new(pick(better, middle, seen));
                }
                (self.value, self.length) = (Lanes::new(after), Lanes::new(length));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn nothing_shines_once_the_level_is_reached() {
        let mut state = State::EMPTY;
        let operator = Operator::Under { level: 0.5 };
        let mut blend = |light: f32, alpha: f32| {
            dispatch!(Level::new(), simd => {
                let light = splat(simd, light);
                state.blend(simd, operator, [light, light, light, splat(simd, alpha)], [splat(simd, 0.0); 2]);
            });
            (state.light[0].0[3], state.clear.0[3])
        };
        // What is clear shines before the level; of an opaque sheet a half has room; behind it nothing has, clear or not.
        assert_eq!(blend(0.25, 0.0), (0.25, 1.0));
        let (light, clear) = blend(1.0, 1.0);
        assert_eq!((light, clear), (0.75, 0.5));
        assert_eq!(blend(1.0, 0.0), (0.75, 0.5));
        assert_eq!(blend(1.0, 0.3), (0.75, 0.5));
    }
}
