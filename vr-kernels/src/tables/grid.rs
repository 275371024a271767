//! Places of a table's entries: evenly spaced over stored numbers, with the breaks of the transfer function on entries where possible.

use vr_core::Calibration;
use vr_core::Real;
use vr_core::transfer::{OpacityRule, Optical, Segment, TransferFunction};

/// Number of intervals of a table, unless its values are few integers or its breaks ask for more.
const INTERVALS: usize = 4096;
/// Largest number of intervals of a table. Integer values get one entry each (or several) up to this many, so that labels are exact;
/// and so many may be taken to bring breaks onto entries.
const MAX_INTERVALS: usize = 16384;
/// Part of an interval by which a break on an entry may miss it: the rounding of f64, with room to spare.
const ALIGNED: f64 = 1e-6;

/// Evenly spaced places over stored numbers, in the order of the values that they are calibrated to.
///
/// A table holds a row for each end of each interval. At a break (see [`TransferFunction::breaks`]) the end of one interval and
/// the start of the next are different rows, so that nothing of one side shows on the other.
#[derive(Clone, Debug)]
pub(crate) struct TableGrid {
    /// Stored number of the first place.
    origin: f64,
    /// Stored units from one place to the next; negative where larger stored numbers have smaller values.
    spacing: f64,
    intervals: usize,
    /// Value of each break, and the entry that stands for it; ascending.
    breaks: Vec<(f64, usize)>,
    /// Largest distance of a break from its entry, in intervals.
    shift: f64,
}

impl TableGrid {
    /// Places over the stored numbers `range` (of integers, if `integer`).
    pub(crate) fn new(transfer: &TransferFunction, calibration: Calibration, range: (f32, f32), integer: bool) -> Self {
        let (low, high) = (f64::from(range.0), f64::from(range.1));
        let span = high - low;
        let (origin, sign) = if calibration.slope > 0.0 { (low, 1.0) } else { (high, -1.0) };
        // Distance from the first place to each break inside the range.
        let distance = |value: f64| sign * (calibration.stored(value) - origin);
        let inside: Vec<(f64, f64)> =
            transfer.breaks().map(|v| (v, distance(v))).filter(|&(_, d)| d > 0.0 && d <= span).collect();
        let distances: Vec<f64> = inside.iter().map(|&(_, d)| d).collect();
        let (spacing, intervals) = spacing(span, integer, &distances);
        let entry = |d: f64| ((d / spacing).round() as usize).min(intervals);
        let shift = distances.iter().map(|&d| miss(d, spacing)).fold(0.0, f64::max);
        let breaks = inside.iter().map(|&(v, d)| (v, entry(d))).collect();
        Self { origin, spacing: sign * spacing, intervals, breaks, shift }
    }

    /// Stored number of the first place.
    pub(crate) fn origin(&self) -> f64 {
        self.origin
    }

    /// Stored units from one place to the next, with the sign of the calibration's slope.
    pub(crate) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Number of intervals.
    pub(crate) fn intervals(&self) -> usize {
        self.intervals
    }

    /// Stored units by which the table moves a break; 0 where all lie on entries.
    pub(crate) fn break_shift(&self) -> f64 {
        if self.shift <= ALIGNED { 0.0 } else { self.shift * self.spacing.abs() }
    }

    /// Stored number of an entry.
    pub(crate) fn place(&self, entry: usize) -> f64 {
        self.origin + entry as f64 * self.spacing
    }

    /// Stored number of each break, and its entry.
    pub(crate) fn breaks(&self, calibration: Calibration) -> impl Iterator<Item = (f64, usize)> + '_ {
        self.breaks.iter().map(move |&(value, entry)| (calibration.stored(value), entry))
    }

    /// Properties at both ends of an interval; a table interpolates between them.
    ///
    /// If opacity reaches 1 at one end only, extinction has an integrable singularity there, which the returned line replaces by one of
    /// the same mean; the end itself, where extinction is infinite, is one of [`lone_walls`]. With w = 1 − α from ω to 0, the mean of −ln w is 1 − ln ω: a line from −ln ω to 2 − ln ω has the same mean,
    /// and so the same optical depth.
    pub(crate) fn ends(&self, transfer: &TransferFunction, calibration: Calibration, interval: usize) -> [Optical; 2] {
        let entries = [interval, (interval + 1).min(self.intervals)];
        let mut ends = entries.map(|entry| self.optical(transfer, calibration, interval, self.place(entry)));
        let peak = |other: f64| 1.0 - (1.0 - other) * libm::exp(-2.0);
        if transfer.rule() == OpacityRule::Power {
            match ends.map(|end| end.opacity) {
                [a, b] if a < 1.0 && b >= 1.0 => ends[1].opacity = peak(a),
                [a, b] if a >= 1.0 && b < 1.0 => ends[0].opacity = peak(b),
                _ => {}
            }
        }
        ends
    }

    /// Rows of a table: `row` of the properties at both ends of each interval, and of an interval of no length after the last.
    pub(crate) fn rows<T: Copy>(
        &self,
        transfer: &TransferFunction,
        calibration: Calibration,
        row: impl Fn(&Optical) -> T,
    ) -> Vec<[T; 2]> {
        // An interval begins where the one before ends, mostly with the same properties: a row, with its exponential or logarithm, is made once.
        let mut before: Option<(Optical, T)> = None;
        let mut shared = |at: Optical| match before {
            Some((same, row)) if same == at => row,
            _ => before.insert((at, row(&at))).1,
        };
        (0..=self.intervals).map(|i| self.ends(transfer, calibration, i).map(&mut shared)).collect()
    }

    /// The properties at a stored number as an interval has them: those of the stretch between two breaks that it belongs to.
    pub(crate) fn optical(
        &self,
        transfer: &TransferFunction,
        calibration: Calibration,
        interval: usize,
        stored: f64,
    ) -> Optical {
        let value = calibration.value(stored);
        let next = self.breaks.partition_point(|&(_, entry)| entry <= interval);
        let (below, above) = (next.checked_sub(1).map(|i| self.breaks[i].0), self.breaks.get(next).map(|b| b.0));
        match (below, above) {
            (Some(below), _) if value <= below => transfer.at(below),
            (_, Some(above)) if value >= above => transfer.at_below(above),
            _ => transfer.at(value),
        }
    }
}

/// Isolated values of opacity 1: the stored number of each, and the properties there.
///
/// A table that is interpolated cannot hold them. They matter where the field keeps such a value over a length, as inside a label.
pub(crate) fn lone_walls<R: Real>(transfer: &TransferFunction, calibration: Calibration) -> Vec<(R, Optical)> {
    if transfer.rule() != OpacityRule::Power {
        return Vec::new();
    }
    let tops = transfer.segments().iter().filter(|s| s.start.opacity >= 1.0 && s.end.opacity < 1.0);
    // A field whose precision has no such number never takes it.
    let exact = |s: &Segment| {
        let stored = R::from_f64(calibration.stored(s.from));
        (calibration.value(stored.to_f64()) == s.from).then_some((stored, s.start))
    };
    tops.filter_map(exact).collect()
}

/// Spacing and number of the intervals over `span` stored units, given the distance of each break from its begin.
fn spacing(span: f64, integer: bool, breaks: &[f64]) -> (f64, usize) {
    if span == 0.0 {
        return (1.0, 1);
    }
    let worst = |spacing: f64| breaks.iter().map(|&d| miss(d, spacing)).fold(0.0, f64::max);
    // Of some spacings, the first that has all breaks on entries; else the one whose largest miss, in stored units, is smallest.
    let best = |spacings: &mut dyn Iterator<Item = f64>| {
        let mut best = (f64::INFINITY, 0.0);
        for spacing in spacings {
            let miss = worst(spacing);
            if miss <= ALIGNED {
                return spacing;
            }
            if miss * spacing < best.0 {
                best = (miss * spacing, spacing);
            }
        }
        best.1
    };
    if integer && span as usize <= MAX_INTERVALS {
        let min = (INTERVALS / span as usize).max(1);
        let max = (MAX_INTERVALS / span as usize).max(min);
        let per_unit = 1.0 / best(&mut (min..=max).map(|k| 1.0 / k as f64));
        return (1.0 / per_unit, (span * per_unit).round() as usize);
    }
    let usual = span / INTERVALS as f64;
    let Some(&last) = breaks.last().filter(|_| worst(usual) > ALIGNED) else { return (usual, INTERVALS) };
    // The last break lies on an entry by choice of the spacing, the others by luck.
    let min = (last / usual).ceil();
    let max = (last / span * MAX_INTERVALS as f64).floor().max(min);
    let spacing = best(&mut (min as usize..=max as usize).map(|m| last / m as f64));
    (spacing, (span / spacing).ceil() as usize)
}

/// Part of an interval by which a distance misses the nearest place.
fn miss(distance: f64, spacing: f64) -> f64 {
    let x = distance / spacing;
    (x - x.round()).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::{ControlPoint, OpacityRule};

    /// Jumps at values, from clear to half opaque and back.
    fn jumps(at: &[f64]) -> TransferFunction {
        let points = at.iter().enumerate().flat_map(|(i, &v)| {
            let sides = if i % 2 == 0 { [0.0, 0.5] } else { [0.5, 0.0] };
            sides.map(|a| ControlPoint::new(v, [a; 3], a))
        });
        TransferFunction::new(points.collect(), OpacityRule::Power, 1.0).unwrap()
    }

    fn grid(transfer: &TransferFunction, slope: f64, integer: bool) -> TableGrid {
        TableGrid::new(transfer, Calibration { slope, intercept: 0.0 }, (-10.0, 100.0), integer)
    }

    #[test]
    fn breaks_lie_on_entries_wherever_that_can_be_had() {
        assert_eq!(grid(&jumps(&[0.3]), 1.0, false).break_shift(), 0.0);
        assert_eq!(grid(&jumps(&[0.3]), -1.0, false).break_shift(), 0.0);
        assert_eq!(grid(&jumps(&[0.1, 0.3, 17.7, 31.2]), 1.0, false).break_shift(), 0.0);
        assert_eq!(grid(&jumps(&[10.5, 11.5, 20.5]), 1.0, true).break_shift(), 0.0);
        assert_eq!(grid(&jumps(&[1.0, 2.0, 3.0]), 1.0, true).break_shift(), 0.0);
        // Numbers without a common measure: as near as may be.
        let odd = [1.0f64, 2f64.sqrt(), std::f64::consts::PI, 7f64.sqrt() * 4.0];
        let shift = grid(&jumps(&odd), 1.0, false).break_shift();
        assert!(shift > 0.0 && shift < 110.0 / 4096.0 / 4.0, "{shift}");
    }

    #[test]
    fn a_touch_of_opacity_one_keeps_its_mean_extinction_and_is_a_wall_by_itself() {
        let point = |value, opacity| ControlPoint::new(value, [0.5; 3], opacity);
        let points = vec![point(1.5, 0.0), point(2.0, 1.0), point(2.5, 0.0), point(70.0, 1.0)];
        let tent = |rule| TransferFunction::new(points.clone(), rule, 1.0).unwrap();
        for slope in [1.0, -1.0] {
            let calibration = Calibration { slope, intercept: 0.0 };
            let (transfer, grid) = (tent(OpacityRule::Power), grid(&tent(OpacityRule::Power), slope, true));
            let (wall, entry) = (2.0 * slope, ((2.0 * slope - grid.origin()) / grid.spacing()).round() as usize);
            assert_eq!(grid.place(entry), wall);
            for interval in [entry - 1, entry] {
                let ends = grid.ends(&transfer, calibration, interval).map(|end| transfer.extinction(end.opacity));
                // Of −ln|1 − α| over the interval, by the midpoint rule: half a step from the pole it is good to (ln 2)/2n.
                let (from, steps) = (grid.place(interval), 100_000);
                let at = |i: u32| from + grid.spacing() * (f64::from(i) + 0.5) / f64::from(steps);
                let sum: f64 = (0..steps).map(|i| transfer.extinction_at(calibration.value(at(i)))).sum();
                let mean = 0.5 * (ends[0] + ends[1]);
                assert!((mean - sum / f64::from(steps)).abs() < 1e-5, "{mean} {sum}");
            }
            // At 70 it stays 1: the rows say that.
            let walls = lone_walls::<f32>(&transfer, calibration);
            assert_eq!(walls.iter().map(|w| w.0).collect::<Vec<_>>(), [wall as f32]);
        }
        // 2 is no number that a field of such a calibration has; and extinction that is given is never infinite.
        let odd = Calibration { slope: 0.3, intercept: 0.1 };
        assert!(lone_walls::<f32>(&tent(OpacityRule::Power), odd).is_empty());
        assert!(lone_walls::<f32>(&tent(OpacityRule::Extinction), Calibration::default()).is_empty());
    }

    #[test]
    fn rows_are_those_of_both_ends() {
        let point = |value, opacity| ControlPoint::new(value, [0.5, 0.01 * value, 0.2], opacity);
        let tent = [(0.5, 0.0), (20.0, 1.0), (30.5, 0.0), (30.5, 0.4), (50.0, 0.4)].map(|(v, a)| point(v, a));
        let tent = TransferFunction::new(tent.to_vec(), OpacityRule::Power, 1.0).unwrap();
        for (transfer, slope) in [(jumps(&[2.5, 7.25]), 1.0), (jumps(&[0.1, 17.7]), -1.0), (tent, 1.0)] {
            let calibration = Calibration { slope, intercept: 0.0 };
            let (grid, made) = (grid(&transfer, slope, false), std::cell::Cell::new(0));
            let rows = grid.rows(&transfer, calibration, |at| {
                made.set(made.get() + 1);
                *at
            });
            let ends = (0..=grid.intervals()).map(|i| grid.ends(&transfer, calibration, i));
            assert!(ends.eq(rows.iter().copied()) && rows.len() == grid.intervals() + 1);
            // One each place, and those of the other side of a break or of a value of opacity 1.
            let most = grid.intervals() + 1 + 2 * transfer.points().len();
            assert!(made.get() <= most, "{} rows of {most}", made.get());
        }
    }

    #[test]
    fn intervals_know_their_side_of_a_break() {
        for slope in [1.0, -1.0] {
            let calibration = Calibration { slope, intercept: 0.0 };
            let transfer = jumps(&[2.5, 7.25]);
            let grid = grid(&transfer, slope, false);
            for (stored, entry) in grid.breaks(calibration) {
                assert!((grid.place(entry) - stored).abs() < 1e-9);
                let [before, after] = [entry - 1, entry].map(|i| grid.optical(&transfer, calibration, i, stored));
                let rises = calibration.value(stored) == 2.5;
                assert_eq!((before.opacity, after.opacity), if rises { (0.0, 0.5) } else { (0.5, 0.0) });
            }
        }
    }
}
