//! The stored numbers that can be seen.

use vr_core::{Calibration, TransferFunction};

/// Closed, disjoint ranges of stored numbers, ascending: outside them nothing absorbs and nothing shines.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VisibleRanges {
    ranges: Vec<(f32, f32)>,
}

impl VisibleRanges {
    /// The ranges of a transfer function, each wider by `slack` stored units on both sides: a table interpolates between its entries,
    /// and so shows what lies less than an entry's distance beside them.
    pub(crate) fn new(transfer: &TransferFunction, calibration: Calibration, slack: f64) -> Self {
        let visible = transfer.segments().iter().filter(|segment| !segment.is_clear());
        let mut wanted: Vec<(f32, f32)> = visible
            .map(|segment| {
                let ends = [segment.from, segment.to].map(|value| calibration.stored(value));
                let (low, high) = (ends[0].min(ends[1]) - slack, ends[0].max(ends[1]) + slack);
                // Rounded outwards.
                ((low as f32).next_down(), (high as f32).next_up())
            })
            .collect();
        wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ranges: Vec<(f32, f32)> = Vec::with_capacity(wanted.len());
        for (low, high) in wanted {
            match ranges.last_mut() {
                Some(last) if low <= last.1 => last.1 = last.1.max(high),
                _ => ranges.push((low, high)),
            }
        }
        Self { ranges }
    }

    /// Whether something between two numbers can be seen.
    #[inline]
    pub(crate) fn meet(&self, low: f32, high: f32) -> bool {
        self.ranges.iter().any(|&(from, to)| from <= high && low <= to)
    }

    /// Whether everything between two numbers can be seen.
    #[cfg(test)]
    pub(crate) fn cover(&self, low: f32, high: f32) -> bool {
        self.ranges.iter().any(|&(from, to)| from <= low && high <= to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{ControlPoint, OpacityRule};

    fn ranges(points: &[(f64, f64)], calibration: Calibration, slack: f64) -> VisibleRanges {
        let points = points.iter().map(|&(v, a)| ControlPoint::new(v, [1.0; 3], a)).collect();
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        VisibleRanges::new(&transfer, calibration, slack)
    }

    #[test]
    fn a_spike_and_what_lies_beside_it() {
        let r = ranges(&[(0.0, 0.0), (10.0, 0.0), (11.0, 1.0), (12.0, 0.0)], Calibration::default(), 0.5);
        assert!(r.meet(9.6, 9.7) && r.meet(0.0, 100.0) && r.cover(10.0, 12.0));
        assert!(!r.meet(0.0, 9.4) && !r.meet(12.6, 100.0) && !r.cover(9.0, 12.0));
    }

    #[test]
    fn open_ends_and_negative_slopes() {
        let r = ranges(&[(5.0, 0.0), (6.0, 0.3)], Calibration { slope: -2.0, intercept: 1.0 }, 0.0);
        // Values from 5 on are stored numbers up to −2.
        assert!(r.meet(-1e30, -1e20) && r.cover(-100.0, -2.0) && !r.meet(-1.9, 1e30));
    }

    #[test]
    fn emission_without_absorption_is_visible() {
        let point = |value, e| ControlPoint { emission: Some([e; 3]), ..ControlPoint::new(value, [0.0; 3], 0.0) };
        let transfer =
            TransferFunction::new(vec![point(0.0, 0.0), point(1.0, 0.0), point(2.0, 1.0)], OpacityRule::Power, 1.0);
        let r = VisibleRanges::new(&transfer.unwrap(), Calibration::default(), 0.0);
        assert!(r.meet(1.5, 1.6) && !r.meet(0.0, 0.9));
    }
}
