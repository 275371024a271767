//! Light of segments on which the value is linear, from integrals of the transfer function over values.

use vr_core::{OpacityRule, TransferFunction};

use super::samples::boxed;

/// Intervals of a table, and values by which it goes on beyond the range.
const MIN_INTERVALS: usize = 4096;
const MAX_INTERVALS: usize = 1 << 14;
const BEYOND: usize = 4;
/// Intervals in the narrowest range of values between two control points.
const IN_SEGMENT: f64 = 32.0;
/// Intervals of a transfer function that jumps.
const FOR_JUMPS: f64 = 8192.0;
/// Opacity under the power rule above which extinction is too steep for a table.
const STEEP: f64 = 0.9999;
/// Parts along each axis of the table of largest extinctions.
const PARTS: usize = 128;
/// Nodes of Gauss's rule of three points on [0, 1], and its weights.
const NODES: [f64; 3] = [0.112_701_665_379_258_31, 0.5, 0.887_298_334_620_741_7];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];

/// Rows of four in a table: more than the most intervals have, and a power of two, so that any number can be made one of them by its lower bits.
const ROWS: usize = 4 * MAX_INTERVALS;

/// The intervals of a table, two rows each, and zeros: integrals of (extinction, light) from the table's start up to a fraction `f` of one are `start + f rate`.
pub(super) struct Intervals {
    rows: Box<[[f32; 4]; ROWS]>,
    count: usize,
}

impl Intervals {
    /// Number of intervals.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// An interval.
    #[inline(always)]
    pub(super) fn at(&self, index: u32) -> [&[f32; 4]; 2] {
        // Without a check: the lower bits of any number are good for one.
        let first = (2 * index as usize) & (ROWS - 2);
        [&self.rows[first], &self.rows[first + 1]]
    }
}

/// Integrals of extinction and of the light sent, over values, at equal intervals.
///
/// The mean of both over any range of values is a difference of two integrals, exact whatever control points lie between: no table of two values and a length
/// is needed, and a mesh of cells of all sizes has one table.
pub(super) struct SegmentTable {
    pub(super) intervals: Intervals,
    low: f64,
    per_value: f64,
    /// Largest extinction between two parts of the range; NaN-free, −1 where nothing is seen.
    largest: Vec<f32>,
    /// Intervals in a part.
    per_part: f64,
}

impl SegmentTable {
    /// The table of a transfer function over a range of values; `None` for one that absorbs without bound, or changes too quickly.
    pub(super) fn new(transfer: &TransferFunction, [low, high]: [f64; 2]) -> Option<Self> {
        let points = transfer.points();
        if transfer.rule() == OpacityRule::Power && points.iter().any(|p| p.opacity > STEEP) {
            return None;
        }
        // Room for rounding at both ends; a range of one value gets a width.
        let spread = (high - low).max(1e-6 * low.abs().max(high.abs()).max(1e-30));
        let narrowest = transfer
            .segments()
            .iter()
            .filter(|s| s.from.is_finite() && s.to.is_finite() && s.to > low && s.from < high)
            .map(|s| s.to - s.from)
            .fold(f64::INFINITY, f64::min);
        // An interval with a jump in it has the right integral, and is wrong inside.
        let wanted = (spread / narrowest * IN_SEGMENT).max(if transfer.has_jumps() { FOR_JUMPS } else { 0.0 });
        if wanted > MAX_INTERVALS as f64 {
            return None;
        }
        let count = (wanted as usize).next_power_of_two().max(MIN_INTERVALS);
        let per_value = count as f64 / spread;
        let low = low - BEYOND as f64 / per_value;
        let mut table = Self {
            intervals: Intervals { rows: boxed([0.0; 4]), count: 0 },
            low,
            per_value,
            largest: Vec::new(),
            per_part: (count + 2 * BEYOND) as f64 / PARTS as f64,
        };
        table.integrate(transfer, count + 2 * BEYOND);
        Some(table)
    }

    /// Fills the intervals.
    fn integrate(&mut self, transfer: &TransferFunction, count: usize) {
        let mut sum = [0.0f64; 4];
        let mut parts = vec![-1.0f32; PARTS];
        let optics = |opacity: f64, light: [f64; 3]| {
            let extinction = transfer.extinction(opacity);
            let [r, g, b] = if transfer.has_emission() { light } else { light.map(|c| c * extinction) };
            [extinction, r, g, b]
        };
        let light_of = |at: &vr_core::transfer::Optical| if transfer.has_emission() { at.emission } else { at.color };
        let segments = transfer.segments();
        let mut first = 0;
        for i in 0..count {
            let [from, to] = [self.value(i as f64), self.value((i + 1) as f64)];
            while segments[first].to <= from && first + 1 < segments.len() {
                first += 1;
            }
            // Segment by segment, each of which is smooth.
            let mut integral = [0.0f64; 4];
            for segment in segments[first..].iter().take_while(|s| s.from < to) {
                let (start, end) = (from.max(segment.from), to.min(segment.to));
                let share = (end - start) / (to - from);
                for (node, weight) in NODES.into_iter().zip(WEIGHTS) {
                    let at = segment.at(start + (end - start) * node);
                    let here = optics(at.opacity, light_of(&at));
                    (0..4).for_each(|c| integral[c] += weight * share * here[c]);
                }
                if !segment.is_clear() {
                    let most = [start, end]
                        .map(|v| transfer.extinction(segment.at(v).opacity))
                        .into_iter()
                        .fold(0.0, f64::max);
                    let part = ((i as f64 / self.per_part) as usize).min(PARTS - 1);
                    parts[part] = parts[part].max(most as f32);
                }
            }
            self.intervals.rows[2 * i] = sum.map(|x| x as f32);
            self.intervals.rows[2 * i + 1] = integral.map(|x| x as f32);
            (0..4).for_each(|c| sum[c] += integral[c]);
        }
        self.intervals.count = count;
        // The largest between each two parts.
        self.largest = vec![-1.0; PARTS * PARTS];
        for from in 0..PARTS {
            let mut most = -1.0f32;
            for to in from..PARTS {
                most = most.max(parts[to]);
                self.largest[from * PARTS + to] = most;
            }
        }
    }

    /// Place of a value in the table, in intervals.
    pub(super) fn place(&self, value: f64) -> f64 {
        (value - self.low) * self.per_value
    }

    /// Value at a place.
    pub(super) fn value(&self, place: f64) -> f64 {
        self.low + place / self.per_value
    }

    /// Largest extinction between two places, in ascending order; `None` if nothing between them can be seen.
    pub(super) fn largest(&self, [low, high]: [f32; 2]) -> Option<f32> {
        let part = |place: f32| ((place / self.per_part as f32) as usize).min(PARTS - 1);
        let most = self.largest[part(low) * PARTS + part(high)];
        (most >= 0.0).then_some(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::ControlPoint;

    #[test]
    fn means_are_exact_across_control_points() {
        let p = ControlPoint::new;
        let points = vec![
            p(0.1, [1.0; 3], 0.0),
            p(0.3, [0.5, 0.2, 0.1], 0.6),
            p(0.3, [0.1, 0.9, 0.3], 0.2),
            p(0.8, [1.0; 3], 0.9),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 0.5).unwrap();
        let table = SegmentTable::new(&transfer, [0.0, 1.0]).unwrap();
        let up_to = |value: f64| {
            let place = table.place(value);
            let (i, f) = (place as usize, (place - place.floor()) as f32);
            let [start, rate] = table.intervals.at(i as u32);
            f64::from(start[0] + f * rate[0]) / table.per_value
        };
        // Extinction is opacity by 0.5: two triangles and what is constant.
        let exact = 2.0 * (0.5 * 0.2 * 0.6 + 0.5 * (0.2 + 0.9) * 0.5 + 0.9 * 0.1);
        assert!((up_to(0.9) - up_to(0.05) - exact).abs() < 1e-5, "{} for {exact}", up_to(0.9) - up_to(0.05));
        assert_eq!(table.largest([0.0, table.place(0.05) as f32]), None);
        assert!((table.largest([0.0, table.place(0.99) as f32]).unwrap() - 1.8).abs() < 1e-5);
    }
}
