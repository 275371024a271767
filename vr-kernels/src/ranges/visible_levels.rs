//! Ranges of stored numbers that show something, in a table.

use vr_core::Voxel;

/// Ranges of stored numbers that may be visible, for many questions: one look-up each.
///
/// Lacroute & Levoy (1994, fast classification) ask a summed-area table of opacity over both ends of the range. Opacity over one number
/// needs sums over one axis only, and since no more is asked than whether a sum is zero, we keep for each lower end the smallest upper
/// end that makes it positive: one look-up instead of two.
///
/// Integers are levels of their own, and what lies strictly between two neighbours counts as well: interpolated values get there though no
/// voxel does. Other numbers fall into [`Self::INTERVALS`] equal intervals, their ends rounded outward; but the smallest and the largest
/// number are levels of their own, so that air that is one number stays clear under a ramp that begins there.
#[derive(Clone, Debug)]
pub struct VisibleLevels {
    scale: Scale,
    /// For each level the lowest one, it or above, so that something in between is visible; [`NEVER`] if there is none.
    reach: Vec<u32>,
    /// For each level the lowest one, it or above, that is not visible itself; one behind the last if there is none.
    solid: Vec<u32>,
}

const NEVER: u32 = u32::MAX;

/// Map from stored numbers to levels.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    integer: bool,
    low: f64,
    high: f64,
    /// Intervals per stored unit.
    density: f64,
    last: u32,
}

impl Scale {
    /// The level of a number that no integer type holds.
    #[inline]
    fn interval(&self, x: f64) -> u32 {
        if x <= self.low {
            0
        } else if x >= self.high {
            self.last
        } else {
            // `as` makes 0 of NaN.
            1 + (((x - self.low) * self.density) as u32).min(self.last - 2)
        }
    }

    /// The level of an integer.
    #[inline]
    fn whole(&self, x: i32) -> u32 {
        (x - self.low as i32) as u32
    }
}

/// Voxels that know their level: for integers that is a subtraction.
pub trait Leveled: Voxel {
    /// The level of a voxel.
    fn level(self, scale: &Scale) -> u32;
}

macro_rules! whole {
    ($($t:ty),*) => {$(
        impl Leveled for $t {
            #[inline(always)]
            fn level(self, scale: &Scale) -> u32 {
                scale.whole(self.into())
            }
        }
    )*};
}
whole!(u8, i8, u16, i16);

impl Leveled for f32 {
    #[inline(always)]
    fn level(self, scale: &Scale) -> u32 {
        scale.interval(self.into())
    }
}

impl VisibleLevels {
    /// Intervals of numbers that are not integers.
    pub const INTERVALS: u32 = 4096;

    /// Levels of numbers from `low` to `high`, the smallest and the largest; `integer` where their type is. Numbers beyond count as the ends.
    /// `visible(from, to)` is true if a stored number may be visible anywhere from `from` to `to`, ends included.
    pub fn new((low, high): (f64, f64), integer: bool, visible: impl Fn(f64, f64) -> bool) -> Self {
        let span = high - low;
        debug_assert!(!integer || span <= 65535.0, "integers have at most 16 bits");
        if integer {
            let last = span as u32;
            let at = |level: u32| low + f64::from(level);
            let scale = Scale { integer, low, high, density: 1.0, last };
            return Self::of_levels(scale, |l| visible(at(l), at(l)), |l| visible(at(l), at(l + 1)));
        }
        let spacing = span / f64::from(Self::INTERVALS);
        let density = if span > 0.0 { 1.0 / spacing } else { 0.0 };
        let last = Self::INTERVALS + 1;
        // Far more than the rounding of a level, far less than an interval.
        let slack = 1e-9 * spacing;
        let seen = |level: u32| match level {
            0 => visible(low, low),
            l if l == last => visible(high, high),
            l => {
                let from = low + f64::from(l - 1) * spacing - slack;
                visible(from.max(low), (from + spacing + 2.0 * slack).min(high))
            }
        };
        // Intervals are closed: there is nothing between two of them.
        Self::of_levels(Scale { integer, low, high, density, last }, seen, |_| false)
    }

    /// Levels of a scale, from what is visible at each, and what between each and the next.
    fn of_levels(scale: Scale, at: impl Fn(u32) -> bool, above: impl Fn(u32) -> bool) -> Self {
        let levels = scale.last as usize + 1;
        let (mut reach, mut solid) = (vec![NEVER; levels], vec![scale.last + 1; levels]);
        for level in (0..=scale.last).rev() {
            let l = level as usize;
            let seen = at(level);
            if !seen {
                solid[l] = level;
            } else if level < scale.last {
                solid[l] = solid[l + 1];
            }
            reach[l] = if seen {
                level
            } else if level == scale.last {
                NEVER
            } else if above(level) {
                level + 1
            } else {
                reach[l + 1]
            };
        }
        Self { scale, reach, solid }
    }

    /// True if anything between two voxels may be visible.
    #[inline(always)]
    pub fn between<T: Leveled>(&self, low: T, high: T) -> bool {
        self.reach[low.level(&self.scale).min(self.scale.last) as usize] <= high.level(&self.scale)
    }

    /// True if the number of a voxel is visible itself.
    #[inline(always)]
    pub fn at<T: Leveled>(&self, sample: T) -> bool {
        let level = sample.level(&self.scale).min(self.scale.last);
        self.reach[level as usize] == level
    }

    /// The levels that enclose a range of numbers.
    #[inline]
    fn levels(&self, low: f64, high: f64) -> (u32, u32) {
        if self.scale.integer {
            // `as` saturates.
            let level = |x: f64| (x as u32).min(self.scale.last);
            (level((low - self.scale.low).floor()), level((high - self.scale.low).ceil()))
        } else {
            (self.scale.interval(low), self.scale.interval(high))
        }
    }

    /// True if anything between two numbers may be visible.
    #[inline]
    pub fn any(&self, low: f64, high: f64) -> bool {
        let (low, high) = self.levels(low, high);
        self.reach[low as usize] <= high
    }

    /// True if every voxel between two numbers is visible itself.
    pub fn all(&self, low: f64, high: f64) -> bool {
        let (low, high) = self.levels(low, high);
        self.solid[low as usize] > high
    }

    /// True if the numbers are integers.
    pub fn is_integer(&self) -> bool {
        self.scale.integer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// True if one of the closed ranges in `seen` meets another one.
    fn meets(seen: &[(f64, f64)], from: f64, to: f64) -> bool {
        seen.iter().any(|&(a, b)| from <= b && a <= to)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn integers_are_brute_force(low in -128i8..100, span in 0u8..27, seen in prop::collection::vec((-130.0f64..130.0, 0.0f64..1.5, any::<bool>()), 0..4)) {
            // Round ends, too: they are integers or halves.
            let seen: Vec<_> = seen.iter().map(|&(a, w, round)| if round { (a.round(), a.round() + (w * 2.0).round() / 2.0) } else { (a, a + w) }).collect();
            let high = (i32::from(low) + i32::from(span)).min(127) as i8;
            let visibility = VisibleLevels::new((low.into(), high.into()), true, |a, b| meets(&seen, a, b));
            for a in low..=high {
                prop_assert_eq!(visibility.at(a), meets(&seen, a.into(), a.into()));
                for b in a..=high {
                    prop_assert_eq!(visibility.between(a, b), meets(&seen, a.into(), b.into()));
                    prop_assert_eq!(visibility.any(a.into(), b.into()), visibility.between(a, b));
                    prop_assert_eq!(visibility.all(a.into(), b.into()), (a..=b).all(|x| visibility.at(x)));
                }
            }
        }

        #[test]
        fn floats_are_brute_force_to_an_interval(a in 0.0f32..1.0, b in 0.0f32..1.0, seen in prop::collection::vec((-0.2f64..1.2, 0.0f64..0.3), 0..4), end in any::<bool>()) {
            let mut seen: Vec<_> = seen.iter().map(|&(a, w)| (a, a + w)).collect();
            if end {
                seen.push((0.0, 0.0));
            }
            let visibility = VisibleLevels::new((0.0, 1.0), false, |a, b| meets(&seen, a, b));
            let (a, b) = (a.min(b), a.max(b));
            let interval = 1.001 / f64::from(VisibleLevels::INTERVALS);
            let found = visibility.between(a, b);
            prop_assert!(found || !meets(&seen, a.into(), b.into()));
            prop_assert!(!found || meets(&seen, f64::from(a) - interval, f64::from(b) + interval));
            prop_assert_eq!(visibility.any(a.into(), b.into()), found);
        }
    }

    #[test]
    fn air_is_clear_under_a_ramp_from_it() {
        let visibility = VisibleLevels::new((0.5, 2.0), false, |_, to| to > 0.5);
        assert!(!visibility.at(0.5f32) && !visibility.between(0.5f32, 0.5));
        assert!(visibility.between(0.5f32, 0.500_001) && visibility.at(2.0f32));
    }

    #[test]
    fn a_peak_between_two_integers_is_seen() {
        let visibility = VisibleLevels::new((0.0, 255.0), true, |from, to| from <= 7.5 && 7.5 <= to);
        assert!(visibility.between(7u8, 8) && visibility.between(0u8, 255));
        assert!(!visibility.between(7u8, 7) && !visibility.between(8u8, 255) && !visibility.at(7u8));
    }

    #[test]
    fn extreme_ranges() {
        let constant = VisibleLevels::new((3.0, 3.0), false, |_, _| true);
        assert!(constant.at(3.0f32) && constant.any(3.0, 3.0));
        let wide = VisibleLevels::new((f32::MIN.into(), f32::MAX.into()), false, |from, to| from <= 0.0 && 0.0 <= to);
        assert!(wide.between(f32::MIN, f32::MAX) && !wide.between(1e38f32, f32::MAX) && wide.at(0.0f32));
        let words = VisibleLevels::new((-32768.0, 32767.0), true, |from, to| from <= 9.0 && 9.0 <= to);
        assert!(words.between(i16::MIN, i16::MAX) && words.at(9i16) && !words.between(10i16, i16::MAX));
    }
}
