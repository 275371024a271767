//! One interval of stored numbers: its exact mean, and a straight line.

use super::intervals::ALIGNED;
use super::medium::{WALL_DEPTH, mean_of, properties};
use vr_core::Calibration;
use vr_core::TransferFunction;

/// κ and q in an interval of stored numbers, before they are rounded.
pub(super) struct Cell {
    pub(super) mean: [f64; 4],
    pub(super) start: [f64; 4],
    pub(super) rise: [f64; 4],
}

impl Cell {
    /// The properties at an end of the table and beyond, constant; the sign of `beyond` tells the side.
    pub(super) fn beside(transfer: &TransferFunction, calibration: Calibration, stored: f64, beyond: f64) -> Self {
        let outside = calibration.value(stored + beyond);
        let segment = transfer.segment_at(outside);
        let at_end = properties(transfer, segment, calibration.value(stored));
        Self::constant(if at_end[3].is_finite() { at_end } else { properties(transfer, segment, outside) })
    }

    /// The properties at a single value: that of a constant field, on which α = 1 is opaque, whatever it is beside.
    pub(super) fn at(transfer: &TransferFunction, calibration: Calibration, stored: f64) -> Self {
        let value = calibration.value(stored);
        let at = properties(transfer, transfer.segment_at(value), value);
        // Infinite: a wall, which is looked for first.
        let at = if at[3].is_finite() { at } else { [0.0, 0.0, 0.0, WALL_DEPTH / transfer.unit_distance()] };
        Self::constant(at)
    }

    fn constant(start: [f64; 4]) -> Self {
        Self { mean: start, start, rise: [0.0; 4] }
    }

    /// The exact mean over [from, to], and the straight line of that mean with the rise from end to end.
    pub(super) fn new(
        transfer: &TransferFunction,
        calibration: Calibration,
        knots: &[f64],
        from: f64,
        to: f64,
    ) -> Self {
        // The mean, part by part between the knots inside; and the properties at both ends.
        let slack = ALIGNED * (to - from);
        let first = knots.partition_point(|&k| k <= from + slack);
        let end = knots.partition_point(|&k| k < to - slack).max(first);
        let mut mean = [0.0; 4];
        let mut ends = [[0.0; 4]; 2];
        let cuts = [from].into_iter().chain(knots[first..end].iter().copied()).chain([to]);
        let cuts: Vec<f64> = cuts.collect();
        for (i, part) in cuts.windows(2).enumerate() {
            let [a, b] = [part[0], part[1]].map(|stored| calibration.value(stored));
            let segment = transfer.segment_at(0.5 * (a + b));
            let share = (part[1] - part[0]) / (to - from);
            for (sum, m) in mean.iter_mut().zip(mean_of(transfer, segment, a, b)) {
                *sum += share * m;
            }
            if i == 0 {
                ends[0] = properties(transfer, segment, a);
            }
            if i + 2 == cuts.len() {
                ends[1] = properties(transfer, segment, b);
            }
        }
        // The straight line: the exact mean, and the rise between the ends where it keeps the line above zero.
        let (mut start, mut rise) = ([0.0; 4], [0.0; 4]);
        for c in 0..4 {
            let (a, b) = (ends[0][c], ends[1][c]);
            (start[c], rise[c]) = match (a.is_finite(), b.is_finite()) {
                (true, true) => (mean[c] - 0.5 * (b - a), b - a),
                // A logarithm at one end: the other end and the mean say the line.
                (false, true) => (2.0 * mean[c] - b, 2.0 * (b - mean[c])),
                (true, false) => (a, 2.0 * (mean[c] - a)),
                (false, false) => (mean[c], 0.0),
            };
            // A knot inside, or rounding: never below zero, and the mean stays.
            let excess = start[c].min(start[c] + rise[c]);
            if excess < 0.0 {
                let up = rise[c] > 0.0;
                start[c] = if up { 0.0 } else { 2.0 * mean[c] };
                rise[c] = if up { 2.0 * mean[c] } else { -2.0 * mean[c] };
            }
        }
        Self { mean, start, rise }
    }
}
