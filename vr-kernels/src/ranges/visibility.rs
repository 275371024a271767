//! Ranges of values in which a transfer function shows anything.

use std::sync::Arc;

use super::BlockRange;
use crate::tables::{BakedTransfer, PreIntegrated};
use vr_core::transfer::Segment;
use vr_core::{Calibration, Real, TransferFunction};

/// Calibrated values at which a transfer function absorbs or shines, exactly: asked in a time that does not depend on the width of a range.
#[derive(Clone, Debug)]
pub struct VisibleValues(Vec<OpenRange>);

/// Range of values without its upper end, and without its lower one where `open`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenRange {
    from: f64,
    to: f64,
    open: bool,
}

impl VisibleValues {
    /// Values with any opacity or emission.
    pub fn new(transfer: &TransferFunction) -> Self {
        Self::above(transfer, 0.0)
    }

    /// Values whose opacity is larger than one, or that have emission.
    pub fn above(transfer: &TransferFunction, opacity: f64) -> Self {
        let mut ranges: Vec<OpenRange> = Vec::new();
        for range in transfer.segments().iter().filter_map(|segment| part_above(segment, opacity)) {
            match ranges.last_mut() {
                Some(last) if last.to == range.from && !range.open => last.to = range.to,
                _ => ranges.push(range),
            }
        }
        Self(ranges)
    }

    /// True if any value from `a` to `b`, ends included and in either order, is visible.
    pub fn shows(&self, a: f64, b: f64) -> bool {
        let (low, high) = (a.min(b), a.max(b));
        // Ranges are disjoint and sorted: the first one that does not end below `low` is the only candidate.
        let next = self.0.partition_point(|range| range.to <= low);
        self.0.get(next).is_some_and(|range| if range.open { range.from < high } else { range.from <= high })
    }
}

/// The part of a segment whose opacity is larger than one, or all of it where it has emission. Its upper end belongs to the segment above.
fn part_above(segment: &Segment, opacity: f64) -> Option<OpenRange> {
    let Segment { from, to, start, end } = *segment;
    let shines = [start, end].map(|o| o.emission != [0.0; 3]);
    let [starts, ends] = [start, end].map(|o| o.opacity > opacity);
    if !(starts || ends || shines[0] || shines[1]) {
        return None;
    }
    // A ramp from what is not visible is not visible at its lower end.
    let open = !(starts || shines[0]);
    let whole = OpenRange { from, to, open };
    if shines[0] || shines[1] || starts == ends {
        return Some(whole);
    }
    let share = (opacity - start.opacity) / (end.opacity - start.opacity);
    let cut = if share == 1.0 { to } else { from + share * (to - from) };
    Some(if starts { OpenRange { to: cut, ..whole } } else { OpenRange { from: cut, ..whole } })
}

/// Tells whether anything in a range of stored numbers is visible to a kernel.
///
/// Made from the transfer function and its tables; asked per block, in a time that does not depend on the width of the range. `R` is the
/// precision of the kernel: each answer repeats what the kernel does, operation by operation. All of those grow with the stored number, rounding
/// included, so that what holds at both ends of a range holds between them: no margin is needed, and a block that is 0 throughout is clear under
/// a ramp that begins at 0.
#[derive(Clone, Debug)]
pub enum Visibility<R> {
    /// Compositing that integrates light: visible is what absorbs or shines.
    Light(LightVisibility<R>),
    /// Compositing that looks for a first crossing: visible is what reaches the threshold.
    Reaches {
        /// −1 where larger values have smaller stored numbers.
        sign: R,
        /// sign·threshold, in stored units.
        threshold: R,
    },
}

/// Stored numbers at which a transfer function, or a table that was made of it, is not clear.
#[derive(Clone, Debug)]
pub struct LightVisibility<R> {
    calibration: Calibration,
    /// Visible values of the transfer function itself: not every step is looked up.
    values: VisibleValues,
    table: Option<Arc<BakedTransfer<R>>>,
    segments: Option<Arc<PreIntegrated<R>>>,
}

impl<R: Real> Visibility<R> {
    /// Visibility under a transfer function, and under the tables that steps and segments are looked up in, if there are any.
    pub fn of_light(
        transfer: &TransferFunction,
        calibration: Calibration,
        table: Option<&Arc<BakedTransfer<R>>>,
        segments: Option<&Arc<PreIntegrated<R>>>,
    ) -> Self {
        let values = VisibleValues::new(transfer);
        Self::Light(LightVisibility { calibration, values, table: table.cloned(), segments: segments.cloned() })
    }

    /// Visibility under a threshold in calibrated values.
    pub fn of_threshold(threshold: f64, calibration: Calibration) -> Self {
        let sign = calibration.slope.signum();
        Self::Reaches { sign: R::from_f64(sign), threshold: R::from_f64(sign * calibration.stored(threshold)) }
    }

    /// True if a field between two stored numbers, ends included, can be visible. Never for `low` above `high`.
    pub fn shows(&self, low: f32, high: f32) -> bool {
        if low > high {
            return false;
        }
        match self {
            Self::Light(light) => light.shows(low, high),
            Self::Reaches { sign, threshold } => {
                let end = if *sign > R::ZERO { high } else { low };
                *sign * R::from_f32(end) >= *threshold
            }
        }
    }

    /// True if anything in a block can be visible. Vacuum cannot.
    pub fn shows_block(&self, block: &BlockRange) -> bool {
        self.shows(block.low, block.high)
    }
}

impl<R: Real> LightVisibility<R> {
    fn shows(&self, low: f32, high: f32) -> bool {
        let [a, b] = [low, high].map(R::from_f32);
        let [from, to] = [low, high].map(|stored| self.calibration.value(stored.into()));
        self.table.as_ref().is_some_and(|table| table.shows(a, b))
            || self.segments.as_ref().is_some_and(|table| table.shows(a, b))
            || self.values.shows(from, to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use vr_core::{ControlPoint, OpacityRule};

    fn transfer(points: &[(f64, f64)]) -> TransferFunction {
        let points = points.iter().map(|&(v, a)| ControlPoint::new(v, [1.0; 3], a)).collect();
        TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap()
    }

    fn exact(points: &[(f64, f64)]) -> Visibility<f32> {
        Visibility::of_light(&transfer(points), Calibration::default(), None, None)
    }

    #[test]
    fn ends_and_jumps_are_exact() {
        let ramp = exact(&[(0.0, 0.0), (10.0, 0.5), (20.0, 0.0)]);
        assert!(!ramp.shows(-5.0, 0.0) && !ramp.shows(20.0, 30.0) && !ramp.shows(3.0, 2.0));
        assert!(ramp.shows(-5.0, 0.0f32.next_up()) && ramp.shows(20f32.next_down(), 30.0));
        assert!(ramp.shows(-5.0, 30.0) && ramp.shows(10.0, 10.0));

        // At the jump at 10, the later point holds: it is clear from there on, and visible up to there.
        let falls = exact(&[(0.0, 0.5), (10.0, 0.5), (10.0, 0.0)]);
        assert!(!falls.shows(10.0, 20.0) && falls.shows(10f32.next_down(), 20.0));
        let rises = exact(&[(10.0, 0.0), (10.0, 0.5)]);
        assert!(rises.shows(10.0, 10.0) && !rises.shows(0.0, 10f32.next_down()));
        // A ramp up to a jump back to nothing reaches its upper end from below only.
        let spike = exact(&[(0.0, 0.0), (10.0, 1.0), (10.0, 0.0)]);
        assert!(!spike.shows(10.0, 10.0) && spike.shows(9.0, 10.0) && !spike.shows(-1.0, 0.0));
        // A single visible value, between two clear ramps' ends.
        assert!(exact(&[(0.0, 0.0), (5.0, 0.1), (5.0, 0.0), (9.0, 0.0)]).shows(4.0, 6.0));
    }

    #[test]
    fn what_is_above_an_opacity_is_cut_out_of_ramps() {
        let ramp = transfer(&[(0.0, 0.0), (10.0, 0.5), (20.0, 0.0), (20.0, 0.25), (30.0, 0.25)]);
        let above = VisibleValues::above(&ramp, 0.25);
        assert!(!above.shows(-9.0, 5.0) && above.shows(5.001, 5.0) && above.shows(14.999, 14.999));
        assert!(!above.shows(15.0, 99.0));
        let low = VisibleValues::above(&ramp, 0.125);
        assert!(!low.shows(17.5, 19.9) && low.shows(19.9, 20.0) && low.shows(30.0, 99.0));
        // Every value, where it is asked for alone.
        for opacity in [0.0, 0.1, 0.25, 0.4] {
            let above = VisibleValues::above(&ramp, opacity);
            for k in -8..280 {
                let value = f64::from(k) / 8.0;
                assert_eq!(above.shows(value, value), ramp.at(value).opacity > opacity, "{opacity} {value}");
            }
        }
    }

    #[test]
    fn emission_alone_shows() {
        let p = |v, e| ControlPoint { emission: Some([0.0, e, 0.0]), ..ControlPoint::new(v, [1.0; 3], 0.0) };
        let points = vec![p(0.0, 0.0), p(1.0, 0.0), p(2.0, 3.0)];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
        let seen = Visibility::<f64>::of_light(&transfer, Calibration::default(), None, None);
        assert!(!seen.shows(0.0, 1.0) && seen.shows(0.0, 1.5));
    }

    #[test]
    fn a_table_blurs_and_a_range_at_an_entry_is_still_clear() {
        let transfer = transfer(&[(0.0, 0.0), (100.0, 0.0), (200.0, 0.5)]);
        let calibration = Calibration::default();
        let table = Arc::new(BakedTransfer::<f32>::new(&transfer, calibration, (0.0, 255.0), true, 0.3));
        let seen = Visibility::of_light(&transfer, calibration, Some(&table), None);
        assert!(!seen.shows(0.0, 100.0), "entries lie at integers");
        assert!(seen.shows(0.0, 100.001));
    }

    #[test]
    fn a_threshold_is_reached_from_below_or_from_above() {
        let up = Visibility::<f32>::of_threshold(0.5, Calibration { slope: 0.01, intercept: 0.0 });
        assert!(!up.shows(0.0, 49.9) && up.shows(0.0, 50.1));
        let down = Visibility::<f32>::of_threshold(0.5, Calibration { slope: -0.01, intercept: 1.0 });
        assert!(!down.shows(50.1, 100.0) && down.shows(49.9, 100.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

        /// Nothing that a kernel finds visible, looked up or evaluated, lies in a range that is called clear.
        #[test]
        fn nothing_visible_is_called_clear(
            points in prop::collection::vec((0u8..20, prop_oneof![2 => Just(0.0), 1 => 0.0f64..1.0]), 1..7),
            (slope, intercept) in prop_oneof![Just((1.0, 0.0)), (0.1f64..3.0, -5.0f64..5.0), (-3.0f64..-0.1, 0.0f64..9.0)],
            (low, width) in (-2.0f32..22.0, prop_oneof![Just(0.0f32), 0.0f32..0.01, 0.0f32..8.0]),
            integer in prop::bool::ANY,
            step in 0.01f64..2.0,
        ) {
            let mut points: Vec<_> = points.into_iter().map(|(v, a)| (f64::from(v), a)).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let transfer = transfer(&points);
            let calibration = Calibration { slope, intercept };
            let low = if integer { low.round() } else { low };
            let high = low + width;
            let table = Arc::new(BakedTransfer::<f32>::new(&transfer, calibration, (0.0, 20.0), integer, step));
            let seen = Visibility::of_light(&transfer, calibration, Some(&table), None);
            let exact = Visibility::<f32>::of_light(&transfer, calibration, None, None);
            let segments = Arc::new(PreIntegrated::<f32>::new(&transfer, calibration, (0.0, 20.0), 64));
            let integrated = Visibility::of_light(&transfer, calibration, None, Some(&segments));
            for k in 0..=200u16 {
                let stored = (low + width * f32::from(k) / 200.0).min(high);
                let value = calibration.value(stored.into());
                if transfer.step(value, step)[3] > 0.0 {
                    prop_assert!(exact.shows(low, high), "{stored}");
                }
                if k > 0 {
                    let light = segments.segment(low, stored, 1.0);
                    prop_assert!(light == [0.0; 4] || integrated.shows(low, high), "{low} to {stored}: {light:?}");
                }
                if table.step(stored)[3] > 0.0 || transfer.step(value, step)[3] > 0.0 {
                    prop_assert!(seen.shows(low, high), "{stored}");
                }
            }
        }
    }
}
