//! Which ranges of stored numbers hold something visible.

use std::sync::Arc;

use vr_core::transfer::Segment;
use vr_core::{Calibration, Real, TransferFunction};
use vr_kernels::ranges::BlockRange;
use vr_kernels::tables::{BakedTransfer, PreIntegrated};

/// Says of a range of stored numbers whether any number in it is visible.
///
/// Made from the transfer function, in a time that depends on its points and its table alone; asked per block, in a time that does not
/// depend on the width of the range. `R` is the precision of the kernel: each answer repeats what the kernel does, operation by
/// operation. All of those grow with the stored number, rounding included, so that what holds at both ends of a range holds
/// between them: no margin is needed, and a block that is 0 throughout is clear under a ramp that begins at 0.
#[derive(Clone, Debug)]
pub(crate) enum Visibility<R> {
    /// Where light is integrated: visible is what absorbs or shines.
    Light(LightVisibility<R>),
    /// Where a first crossing is looked for: visible is what reaches the threshold.
    Reaches {
        /// −1 where larger values have smaller stored numbers.
        sign: R,
        /// sign·threshold, in stored units.
        threshold: R,
    },
}

/// Where a transfer function, and the table that was made of it, are not clear.
#[derive(Clone, Debug)]
pub(crate) struct LightVisibility<R> {
    calibration: Calibration,
    /// Of the transfer function itself: a shorter step at the end of a ray is not looked up.
    visible: Vec<OpenRange>,
    table: Option<Arc<BakedTransfer<R>>>,
    /// Of the table that rules which integrate between samples look segments up in.
    segments: Option<SummedRows<R>>,
}

/// The values between two ends, which are visible but for the upper end, and for the lower end where `open`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenRange {
    from: f64,
    to: f64,
    open: bool,
}

/// How many of the first rows of a table of segments are not zero.
#[derive(Clone, Debug)]
struct SummedRows<R> {
    /// Entry i: visible ones among the first i.
    count: Vec<u32>,
    table: Arc<PreIntegrated<R>>,
}

impl<R: Real> Visibility<R> {
    /// Of a transfer function, and of the table that steps are looked up in, if there is one.
    pub(crate) fn of_light(
        transfer: &TransferFunction,
        calibration: Calibration,
        table: Option<&Arc<BakedTransfer<R>>>,
    ) -> Self {
        let visible = visible_ranges(transfer.segments());
        Self::Light(LightVisibility { calibration, visible, table: table.map(Arc::clone), segments: None })
    }

    /// The same where segments between samples are looked up, in this table: what is visible in it is visible, too.
    pub(crate) fn with_segments(mut self, table: Option<&Arc<PreIntegrated<R>>>) -> Self {
        if let Self::Light(light) = &mut self {
            light.segments = table.map(SummedRows::new);
        }
        self
    }

    /// Of a threshold in calibrated values.
    pub(crate) fn of_threshold(threshold: f64, calibration: Calibration) -> Self {
        let sign = calibration.slope.signum();
        Self::Reaches { sign: R::from_f64(sign), threshold: R::from_f64(sign * calibration.stored(threshold)) }
    }

    /// Whether a field between two stored numbers, ends included, can be visible. Never for `low` above `high`.
    pub(crate) fn is_visible(&self, low: f32, high: f32) -> bool {
        if low > high {
            return false;
        }
        match self {
            Self::Light(light) => light.is_visible(low, high),
            Self::Reaches { sign, threshold } => {
                let most = if *sign > R::ZERO { high } else { low };
                *sign * R::from_f32(most) >= *threshold
            }
        }
    }

    /// Whether anything in a block can be visible. Vacuum cannot.
    pub(crate) fn sees(&self, block: &BlockRange) -> bool {
        self.is_visible(block.low, block.high)
    }
}

impl<R: Real> LightVisibility<R> {
    fn is_visible(&self, low: f32, high: f32) -> bool {
        if let Some(table) = &self.table
            && table.shows(R::from_f32(low), R::from_f32(high))
        {
            return true;
        }
        if let Some(table) = &self.segments
            && table.is_visible(R::from_f32(low), R::from_f32(high))
        {
            return true;
        }
        let (a, b) = (self.calibration.value(low.into()), self.calibration.value(high.into()));
        let (low, high) = (a.min(b), a.max(b));
        // Ranges are disjoint and sorted: the first one that does not end below `low` is the only candidate.
        let next = self.visible.partition_point(|range| range.to <= low);
        self.visible.get(next).is_some_and(|range| if range.open { range.from < high } else { range.from <= high })
    }
}

impl<R: Real> SummedRows<R> {
    fn new(table: &Arc<PreIntegrated<R>>) -> Self {
        let mut count = vec![0];
        let mut sum = 0;
        for row in table.rows() {
            sum += u32::from(row.start != [R::ZERO; 4] || row.rise != [R::ZERO; 4]);
            count.push(sum);
        }
        Self { count, table: Arc::clone(table) }
    }

    /// Whether any row counts that a segment between two numbers passes.
    fn is_visible(&self, low: R, high: R) -> bool {
        let (a, b) = (self.table.place(low), self.table.place(high));
        // At the begin of its row, only what the row begins with counts.
        let begins = b.fraction == R::ZERO && self.table.rows()[b.row].start == [R::ZERO; 4];
        let past = if begins { b.row } else { b.row + 1 };
        self.count[past.max(a.row)] > self.count[a.row]
    }
}

/// The values at which any of the segments is not clear, by ascending value, those that touch joined.
fn visible_ranges(segments: &[Segment]) -> Vec<OpenRange> {
    let shines = |o: &vr_core::transfer::Optical| o.opacity > 0.0 || o.emission != [0.0; 3];
    let mut ranges: Vec<OpenRange> = Vec::new();
    for segment in segments.iter().filter(|s| !s.is_clear()) {
        // A ramp from 0 is clear at its lower end. Its upper end belongs to the segment above.
        let open = !shines(&segment.start);
        match ranges.last_mut() {
            Some(last) if last.to == segment.from && !open => last.to = segment.to,
            _ => ranges.push(OpenRange { from: segment.from, to: segment.to, open }),
        }
    }
    ranges
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
        Visibility::of_light(&transfer(points), Calibration::default(), None)
    }

    #[test]
    fn ends_and_jumps_are_exact() {
        let ramp = exact(&[(0.0, 0.0), (10.0, 0.5), (20.0, 0.0)]);
        assert!(!ramp.is_visible(-5.0, 0.0) && !ramp.is_visible(20.0, 30.0) && !ramp.is_visible(3.0, 2.0));
        assert!(ramp.is_visible(-5.0, 0.0f32.next_up()) && ramp.is_visible(20f32.next_down(), 30.0));
        assert!(ramp.is_visible(-5.0, 30.0) && ramp.is_visible(10.0, 10.0));

        // At the jump at 10, the later point holds: it is clear from there on, and visible up to there.
        let falls = exact(&[(0.0, 0.5), (10.0, 0.5), (10.0, 0.0)]);
        assert!(!falls.is_visible(10.0, 20.0) && falls.is_visible(10f32.next_down(), 20.0));
        let rises = exact(&[(10.0, 0.0), (10.0, 0.5)]);
        assert!(rises.is_visible(10.0, 10.0) && !rises.is_visible(0.0, 10f32.next_down()));
        // A ramp up to a jump back to nothing reaches its upper end from below only.
        let spike = exact(&[(0.0, 0.0), (10.0, 1.0), (10.0, 0.0)]);
        assert!(!spike.is_visible(10.0, 10.0) && spike.is_visible(9.0, 10.0) && !spike.is_visible(-1.0, 0.0));
        // A single visible value, between two clear ramps' ends.
        assert!(exact(&[(0.0, 0.0), (5.0, 0.1), (5.0, 0.0), (9.0, 0.0)]).is_visible(4.0, 6.0));
    }

    #[test]
    fn emission_alone_is_visible() {
        let p = |v, e| ControlPoint { emission: Some([0.0, e, 0.0]), ..ControlPoint::new(v, [1.0; 3], 0.0) };
        let points = vec![p(0.0, 0.0), p(1.0, 0.0), p(2.0, 3.0)];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
        let seen = Visibility::<f64>::of_light(&transfer, Calibration::default(), None);
        assert!(!seen.is_visible(0.0, 1.0) && seen.is_visible(0.0, 1.5));
    }

    #[test]
    fn a_table_blurs_and_a_range_at_an_entry_is_still_clear() {
        let transfer = transfer(&[(0.0, 0.0), (100.0, 0.0), (200.0, 0.5)]);
        let calibration = Calibration::default();
        let table = Arc::new(BakedTransfer::<f32>::new(&transfer, calibration, (0.0, 255.0), true, 0.3));
        let seen = Visibility::of_light(&transfer, calibration, Some(&table));
        assert!(!seen.is_visible(0.0, 100.0), "entries lie at integers");
        assert!(seen.is_visible(0.0, 100.001));
    }

    #[test]
    fn a_threshold_is_reached_from_below_or_from_above() {
        let up = Visibility::<f32>::of_threshold(0.5, Calibration { slope: 0.01, intercept: 0.0 });
        assert!(!up.is_visible(0.0, 49.9) && up.is_visible(0.0, 50.1));
        let down = Visibility::<f32>::of_threshold(0.5, Calibration { slope: -0.01, intercept: 1.0 });
        assert!(!down.is_visible(50.1, 100.0) && down.is_visible(49.9, 100.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

        /// What a kernel finds visible, looked up or evaluated, lies in no range that is called clear.
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
            let seen = Visibility::of_light(&transfer, calibration, Some(&table));
            let exact = Visibility::<f32>::of_light(&transfer, calibration, None);
            let segments = Arc::new(PreIntegrated::<f32>::new(&transfer, calibration, (0.0, 20.0), 64));
            let integrated = exact.clone().with_segments(Some(&segments));
            for k in 0..=200u16 {
                let stored = (low + width * f32::from(k) / 200.0).min(high);
                let value = calibration.value(stored.into());
                if transfer.step(value, step)[3] > 0.0 {
                    prop_assert!(exact.is_visible(low, high), "{stored}");
                }
                if k > 0 {
                    let light = segments.segment(low, stored, 1.0);
                    prop_assert!(light == [0.0; 4] || integrated.is_visible(low, high), "{low} to {stored}: {light:?}");
                }
                if table.step(stored)[3] > 0.0 || transfer.step(value, step)[3] > 0.0 {
                    prop_assert!(seen.is_visible(low, high), "{stored}");
                }
            }
        }
    }
}
