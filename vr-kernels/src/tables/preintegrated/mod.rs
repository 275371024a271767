//! A transfer function integrated beforehand: the light of a stretch of any length along which the value changes.

mod cell;
mod intervals;
mod lookup;
mod medium;
mod segment;
mod wall;

#[cfg(test)]
mod tests;

pub use lookup::TablePlace;
pub use medium::WALL_DEPTH;

use super::grid::lone_walls;
use super::range::resolves_ramps;
use cell::Cell;
use intervals::{MAX_EXCESS, find_intervals};
use vr_core::Calibration;
use vr_core::Real;
use vr_core::transfer::{OpacityRule, TransferFunction};
use wall::{Wall, walls};

/// Integrals of extinction and emission over the *stored* numbers, tabulated at equal distances.
///
/// Along a stretch on which the value goes linearly from v₀ to v₁, the mean of κ does not depend on how long the stretch is:
///
/// κ̄ = (K(v₁) − K(v₀)) / (v₁ − v₀), K′ = κ,
///
/// and so with the emission q. One table of the antiderivatives therefore serves steps of all lengths, where a table of opacities
/// needs a third dimension (Engel, Kraus and Ertl 2001, *High-quality pre-integrated volume rendering using hardware-accelerated pixel
/// shading*, approximate the length away; Lum, Wilson and Ma 2004, *High-quality lighting and efficient pre-integration for volume
/// rendering*, difference antiderivatives). Features of the transfer function that lie between the two values
/// are never missed, however thin they are.
///
/// # Numbers
/// A difference of floating-point antiderivatives loses the digits that they share. Here they are 32-bit fixed-point numbers, whose
/// differences are exact: what is left is their rounding, 2⁻³¹ of the integral over the whole table. Two values in one interval or in
/// neighbouring ones do not need them at all.
///
/// # Error of a table
/// In each interval κ and q are linear, with the exact mean. Knots of the transfer function (kinks and jumps) fall onto interval ends
/// where any number of intervals between half of `entries` and `entries` allows that ([`PreIntegrated::is_aligned`]); a knot inside an
/// interval is known to that interval only. So an aligned table is off by the square of the interval in κ (10⁻⁶ of it with 1024
/// intervals over a smooth ramp), and one that is not by the share that an interval has in v₁ − v₀.
///
/// # Opaque walls
/// If α is 1 over a range of values and κ is infinite (the power rule), [`PreIntegrated::segment`] ends at the wall exactly. The
/// rows themselves stay finite: κ is [`WALL_DEPTH`] per unit distance there. Where α only touches 1, κ has an integrable logarithm
/// and its mean is finite; a stretch on which the value stays there is a wall.
#[derive(Clone, Debug)]
pub struct PreIntegrated<R> {
    rows: Vec<PreIntegratedRow<R>>,
    /// Entry i: number of the first i rows that are not clear.
    visible: Vec<u32>,
    origin: R,
    per_unit: R,
    last: R,
    quantum: [R; 4],
    /// Ranges of α = 1 in entries, ascending, with the colour at their lower and upper end.
    walls: Vec<Wall<R>>,
    /// Isolated values with α = 1: the place of each, in entries, and its colour.
    lone_walls: Vec<(R, [R; 3])>,
    /// Number of entries by which a wall must be entered: what is less is rounding, and only touches it.
    touch: R,
    /// The largest colour, channel by channel: no stretch shines brighter. Absent where emission is given on its own.
    brightest: Option<[R; 3]>,
    aligned: bool,
    resolves: bool,
}

/// κ and q in one interval of values, and their integrals below it. Components are (q_r, q_g, q_b, κ), per world unit.
///
/// At the fraction t of the interval, the values are `start + t·rise`, and the antiderivative, counted in intervals, is
/// `quantum·sum + t·(start + ½t·rise)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct PreIntegratedRow<R> {
    /// Integral from the first interval to the begin of this one, in multiples of [`PreIntegrated::quantum`]. The difference of two,
    /// wrapping and read as `i32`, is exact.
    pub sum: [u32; 4],
    /// Value at the begin of the interval (its inner side, where it jumps there).
    pub start: [R; 4],
    /// Change over the interval; 0 in the first and the last row.
    pub rise: [R; 4],
}

impl<R: Real> PreIntegrated<R> {
    /// Number of intervals that is enough where the table is aligned: 1024, which is 48 KiB in f32. 4096 gain nothing then.
    pub const ENTRIES: usize = 1024;

    /// Tabulates over the stored numbers that lie in `range` and between the outermost points of the transfer function (beyond
    /// which it is constant), in at most `entries` intervals (at least 2 are made).
    pub fn new(transfer: &TransferFunction, calibration: Calibration, range: (f32, f32), entries: usize) -> Self {
        // The range and the number of intervals, such that knots fall onto their ends if they can.
        let mut knots: Vec<f64> = transfer.segments()[1..].iter().map(|s| calibration.stored(s.from)).collect();
        knots.sort_by(f64::total_cmp);
        let field = (f64::from(range.0), f64::from(range.1));
        let ends = (knots[0], knots[knots.len() - 1]);
        // Not `clamp`, which panics where there is no range.
        let inside = |x: f64| x.max(field.0).min(field.1);
        let (mut low, mut high, entries) = (inside(ends.0), inside(ends.1), entries.max(2));
        let (mut intervals, mut aligned) = find_intervals(&knots, low, high, entries);
        if !aligned && ends.1 - ends.0 <= MAX_EXCESS * (high - low) {
            // From the first point to the last, though the field does not go so far, they may fit.
            let (whole, fits) = find_intervals(&knots, ends.0, ends.1, entries);
            if fits {
                (low, high, intervals, aligned) = (ends.0, ends.1, whole, fits);
            }
        }
        let extent = field.1 - field.0;
        let spacing = if high > low {
            (high - low) / intervals as f64
        } else if (f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&extent) {
            extent
        } else {
            // A single value: anything that rounding tells from it.
            1.0f64.max(low.abs() / 1024.0)
        };

        // One row more at either end, for what lies beyond: constant, and never left.
        let end = |i: usize| low + i as f64 * spacing;
        let mut cells: Vec<Cell> = Vec::with_capacity(intervals + 2);
        let beyond = 1e-3 * spacing;
        // A constant field is nowhere but at its value.
        let constant = field.0 >= field.1;
        let beside = |stored: f64, beyond: f64| match constant {
            true => Cell::at(transfer, calibration, low),
            false => Cell::beside(transfer, calibration, stored, beyond),
        };
        cells.push(beside(low, -beyond));
        if high > low {
            cells.extend((0..intervals).map(|i| Cell::new(transfer, calibration, &knots, end(i), end(i + 1))));
        } else if field.0 < field.1 && knots.contains(&low) {
            // All that changes over the field changes here. Of two points the later one may hold above or below.
            cells.push(Cell::beside(transfer, calibration, low, beyond));
        } else {
            cells.push(Cell::at(transfer, calibration, low));
        }
        cells.push(beside(end(intervals), beyond));

        // The antiderivative below each row, in fixed point.
        let inner = &cells[1..=intervals];
        let total: [f64; 4] = std::array::from_fn(|c| inner.iter().map(|e| e.mean[c]).sum());
        let quantum = total.map(|t| t / f64::from(i32::MAX));
        let mut before = [0.0; 4];
        let rows = cells.iter().enumerate().map(|(i, cell)| {
            let sum = std::array::from_fn(|c| {
                if quantum[c] > 0.0 { libm::round(before[c] / quantum[c]).min(f64::from(i32::MAX)) as u32 } else { 0 }
            });
            if i > 0 {
                before = std::array::from_fn(|c| before[c] + cell.mean[c]);
            }
            PreIntegratedRow { sum, start: cell.start.map(R::from_f64), rise: cell.rise.map(R::from_f64) }
        });
        let rows = rows.collect::<Vec<_>>();
        // Count the rows that are not clear, so that a range of them is judged by one difference.
        let mut visible = vec![0];
        for row in &rows {
            let shows = row.start != [R::ZERO; 4] || row.rise != [R::ZERO; 4];
            visible.push(visible[visible.len() - 1] + u32::from(shows));
        }

        let last = intervals + 1;
        // At a jump the later point holds: a value on it must not be rounded onto the other side. Places are rounded, and so is the origin.
        let nudge = R::ROUNDOFF * (4.0 * last as f64 + low.abs() / spacing);
        let origin = low - spacing - nudge * spacing * calibration.slope.signum();
        let mut walls = walls(transfer, calibration, low, spacing);
        let constant = transfer.at(calibration.value(low));
        if field.0 == field.1 && transfer.rule() == OpacityRule::Power && constant.opacity == 1.0 {
            // A constant field on a value where α only touches 1 has α = 1 over a length, too.
            let color = constant.color.map(R::from_f64);
            walls = vec![Wall { from: -R::ONE / R::ZERO, to: R::ONE / R::ZERO, color: [color; 2] }];
        }
        let mut table = Self {
            rows,
            visible,
            lone_walls: Vec::new(),
            origin: R::from_f64(origin),
            per_unit: R::from_f64(1.0 / spacing),
            last: R::from_index(last),
            quantum: quantum.map(R::from_f64),
            walls,
            touch: R::from_f64(4.0 * nudge),
            brightest: (!transfer.has_emission()).then(|| transfer.brightest_color_by_channel().map(R::from_f64)),
            aligned,
            resolves: aligned || resolves_ramps(spacing, calibration, transfer),
        };
        let lone = lone_walls(transfer, calibration).into_iter();
        table.lone_walls = lone.map(|(at, wall)| (table.place(at).x(), wall.color.map(R::from_f64))).collect();
        table
    }

    /// The rows, by ascending value. The first and the last hold what is constant beyond the table.
    pub fn rows(&self) -> &[PreIntegratedRow<R>] {
        &self.rows
    }

    /// Value of one unit of a row's `sum`: κ (or q) times intervals.
    pub fn quantum(&self) -> [R; 4] {
        self.quantum
    }

    /// The stored number at which the first row begins, and intervals per stored unit: x = (stored − first)·second lies in the row
    /// ⌊x⌋, clamped to the rows that exist.
    pub fn scale(&self) -> (R, R) {
        (self.origin, self.per_unit)
    }

    /// Length of an interval in stored units.
    pub fn spacing(&self) -> f64 {
        1.0 / self.per_unit.to_f64()
    }

    /// True if every knot of the transfer function inside the table is the end of an interval.
    pub fn is_aligned(&self) -> bool {
        self.aligned
    }

    /// True if the intervals tell apart all that the transfer function does: else it must be evaluated.
    pub fn resolves(&self) -> bool {
        self.resolves
    }

    /// Ranges of values at which α is 1, in entries.
    pub(crate) fn opaque_ranges(&self) -> impl Iterator<Item = [R; 2]> + '_ {
        let lone = self.lone_walls.iter().map(|(at, _)| [*at, *at]);
        self.walls.iter().map(|wall| [wall.from, wall.to]).chain(lone)
    }

    /// The largest colour, channel by channel; absent where emission is given on its own.
    pub(crate) fn brightest(&self) -> Option<[R; 3]> {
        self.brightest
    }

    /// True if α is 1, and κ infinite, at one value or more.
    pub fn has_walls(&self) -> bool {
        !self.walls.is_empty() || !self.lone_walls.is_empty()
    }
}
