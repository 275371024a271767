//! A transfer function baked into a table for one step length: a look-up instead of an exponential.

use super::{OpacityRule, Segment, TransferFunction};
use crate::grid::Calibration;
use crate::optics::{opacity_of_depth, opacity_of_thickness, source_weight};
use crate::real::Real;

/// The opacity and the premultiplied light of one step of a given length, tabulated over *stored* numbers at equal distances and
/// interpolated linearly.
///
/// Everything that depends on the step (the exponential, the source weight, the calibration) is folded in, in f64. An entry is
/// (r, g, b, α): the light that a homogeneous step sends out and its opacity. A step of another
/// length is [`TransferFunction::step`].
#[derive(Clone, Debug)]
pub struct BakedTransfer<R> {
    /// One more than there are intervals; the last is repeated, so that index + 1 always exists.
    entries: Vec<[R; 4]>,
    origin: R,
    per_unit: R,
    last: R,
    error: TableError,
}

/// How far a table can be from the transfer function, at any stored number, apart from the rounding of its entries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableError {
    /// Largest deviation of a step's opacity.
    pub opacity: f64,
    /// Largest deviation of a component of a step's light.
    pub light: f64,
    /// Where the transfer function jumps, the table ramps over this many stored units (and the deviations above do not hold
    /// there); 0 where no jump falls between two entries.
    pub jump_width: f64,
}

/// Intervals that a table has, unless its values are few integers.
const INTERVALS: usize = 4096;
/// Integer values get one entry each (or several) up to this many intervals, so that labels and jumps at integers are exact.
const MOST_INTERVALS: usize = 16384;

impl<R: Real> BakedTransfer<R> {
    /// Tabulates over the stored numbers `range` (of integers, if `integer`) for steps of `step` world units.
    pub fn new(
        transfer: &TransferFunction,
        calibration: Calibration,
        range: (f32, f32),
        integer: bool,
        step: f64,
    ) -> Self {
        let (low, high) = (f64::from(range.0), f64::from(range.1));
        let span = high - low;
        let intervals = if span == 0.0 {
            1
        } else if integer && span as usize <= MOST_INTERVALS {
            span as usize * (INTERVALS / span as usize).max(1)
        } else {
            INTERVALS
        };
        let spacing = if span == 0.0 { 1.0 } else { span / intervals as f64 };
        let step_of = |stored: f64| {
            let value = calibration.value(stored);
            step_entry(transfer, transfer.segment_at(value), value, step)
        };
        let exact: Vec<[f64; 4]> = (0..=intervals).map(|i| step_of(low + i as f64 * spacing)).collect();
        let error = table_error(transfer, calibration, low, spacing, &exact, step);
        let mut entries: Vec<[R; 4]> = exact.iter().map(|e| e.map(R::from_f64)).collect();
        entries.push(entries[intervals]);
        Self {
            entries,
            origin: R::from_f64(low),
            per_unit: R::from_f64(1.0 / spacing),
            last: R::from_f64(intervals as f64),
            error,
        }
    }

    /// What the table adds to the error.
    pub fn error(&self) -> TableError {
        self.error
    }

    /// Stored units from one entry to the next.
    pub fn spacing(&self) -> f64 {
        1.0 / self.per_unit.to_f64()
    }

    /// The entries (r, g, b, α), evenly spaced; the last one is there twice.
    pub fn entries(&self) -> &[[R; 4]] {
        &self.entries
    }

    /// The stored number of the first entry.
    pub fn origin(&self) -> R {
        self.origin
    }

    /// Entries per stored unit.
    pub fn per_unit(&self) -> R {
        self.per_unit
    }

    /// Where a stored number, which is not NaN, lies among the entries: at entry i + t for an index i and a fraction t.
    ///
    /// It grows with the stored number, rounding included; numbers beyond the ends lie at the ends.
    #[inline(always)]
    pub fn position(&self, stored: R) -> R {
        ((stored - self.origin) * self.per_unit).max(R::ZERO).min(self.last)
    }

    /// Light and opacity of one whole step at a stored number; nothing for NaN.
    #[inline(always)]
    pub fn step(&self, stored: R) -> [R; 4] {
        if stored.is_nan() {
            return [R::ZERO; 4];
        }
        let x = self.position(stored);
        let i = x.to_index();
        let t = x - R::from_index(i);
        let (a, b) = (self.entries[i], self.entries[i + 1]);
        std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
    }
}

/// Light and opacity of a homogeneous step at a value, with the line of a given segment.
pub(super) fn step_entry(transfer: &TransferFunction, segment: &Segment, value: f64, step: f64) -> [f64; 4] {
    let o = segment.at(value);
    let ratio = step / transfer.unit_distance();
    let (alpha, tau) = match transfer.rule() {
        OpacityRule::Power => (opacity_of_thickness(o.opacity, ratio), transfer.extinction(o.opacity) * step),
        OpacityRule::Extinction => (opacity_of_depth(o.opacity * ratio), o.opacity * ratio),
    };
    let light = if transfer.has_emission() {
        let weight = source_weight(tau) * step;
        o.emission.map(|e| e * weight)
    } else {
        o.color.map(|c| c * alpha)
    };
    [light[0], light[1], light[2], alpha]
}

/// Bounds the deviation of every interval from its chord.
///
/// Between knots, α of a step is concave or convex in the value (all three laws are), and so its greatest distance from a chord is at
/// most twice that at the middle. Light is the product of α with a linear colour: the product of two chords leaves |Δα Δc|/4.
/// Where emission is given on its own, w(τ) is monotone and the chord is off by no more than the difference of the ends.
fn table_error(
    transfer: &TransferFunction,
    calibration: Calibration,
    low: f64,
    spacing: f64,
    exact: &[[f64; 4]],
    step: f64,
) -> TableError {
    let mut error = TableError::default();
    let knots: Vec<f64> = transfer.segments()[1..].iter().map(|s| calibration.stored(s.from)).collect();
    for (i, ends) in exact.windows(2).enumerate() {
        let (a, b) = (low + i as f64 * spacing, low + (i + 1) as f64 * spacing);
        let mut cuts: Vec<f64> = knots.iter().copied().filter(|&k| k > a && k < b).collect();
        cuts.sort_by(f64::total_cmp);
        cuts.insert(0, a);
        cuts.push(b);
        for part in cuts.windows(2) {
            let middle = 0.5 * (part[0] + part[1]);
            let segment = transfer.segment_at(calibration.value(middle));
            let entry = |x: f64| step_entry(transfer, segment, calibration.value(x), step);
            let chord = |x: f64, c: usize| ends[0][c] + (x - a) / (b - a) * (ends[1][c] - ends[0][c]);
            let (start, mid, end) = (entry(part[0]), entry(middle), entry(part[1]));
            // At a jump the entry at the end of a part belongs to the other side: it is the jump, not the table, that is far off.
            let jumps = [(part[0], start), (part[1], end)].iter().any(|&(x, e)| {
                let here = step_entry(transfer, transfer.segment_at(calibration.value(x)), calibration.value(x), step);
                (0..4).any(|c| (here[c] - e[c]).abs() > 1e-12 * (1.0 + here[c].abs()))
            });
            if jumps {
                error.jump_width = error.jump_width.max(spacing);
                continue;
            }
            let at_ends = |c: usize| {
                let ends = [(part[0], start[c]), (part[1], end[c])];
                ends.iter().map(|&(x, e)| (e - chord(x, c)).abs()).fold(0.0, f64::max)
            };
            let bend = 2.0 * (mid[3] - 0.5 * (start[3] + end[3])).abs();
            error.opacity = error.opacity.max(at_ends(3) + bend);
            let (o0, o1) = (segment.at(calibration.value(part[0])), segment.at(calibration.value(part[1])));
            for c in 0..3 {
                let inside = if transfer.has_emission() {
                    (end[c] - start[c]).abs()
                } else {
                    let (c0, c1) = (o0.color[c], o1.color[c]);
                    bend * c0.max(c1) + 0.25 * (end[3] - start[3]).abs() * (c1 - c0).abs()
                };
                error.light = error.light.max(at_ends(c) + inside);
            }
        }
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::ControlPoint;

    fn exact(t: &TransferFunction, v: f64, step: f64) -> [f64; 4] {
        step_entry(t, t.segment_at(v), v, step)
    }

    #[test]
    fn stays_within_its_stated_error() {
        for rule in [OpacityRule::Power, OpacityRule::Extinction] {
            for emits in [false, true] {
                let p = |value, opacity| ControlPoint {
                    emission: emits.then_some([value, 1.0, 0.0]),
                    ..ControlPoint::new(value, [0.2, value, 1.0 - value], opacity)
                };
                let t = TransferFunction::new(vec![p(0.1, 0.0), p(0.35, 0.9), p(0.6, 0.2), p(0.93, 1.0)], rule, 0.7)
                    .unwrap();
                let table = BakedTransfer::<f64>::new(&t, Calibration::default(), (0.0, 1.0), false, 0.31);
                // The logarithm at α = 1 is what a chord follows worst.
                assert!(table.error().opacity < 4e-2 && table.error().jump_width == 0.0, "{:?}", table.error());
                for i in 0..=100_000 {
                    let v = f64::from(i) / 1e5;
                    let (got, want) = (table.step(v), exact(&t, v, 0.31));
                    assert!((got[3] - want[3]).abs() <= table.error().opacity + 1e-15, "{rule:?} {v}");
                    for c in 0..3 {
                        assert!((got[c] - want[c]).abs() <= table.error().light + 1e-15, "{rule:?} {emits} {v}");
                    }
                }
            }
        }
    }

    #[test]
    fn jumps_at_integers_are_exact_for_labels() {
        let points = vec![
            ControlPoint::new(3.0, [1.0; 3], 0.0),
            ControlPoint::new(3.0, [1.0; 3], 1.0),
            ControlPoint::new(4.0, [1.0; 3], 1.0),
            ControlPoint::new(4.0, [1.0; 3], 0.0),
        ];
        let t = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let table = BakedTransfer::<f32>::new(&t, Calibration::default(), (0.0, 29.0), true, 0.5);
        let opacity = [2.0, 3.0, 4.0].map(|v| table.step(v)[3]);
        assert_eq!(opacity, [0.0, 1.0, 0.0]);
    }
}
