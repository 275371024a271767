//! A transfer function integrated beforehand: the light of a stretch of any length along which the value changes.

use super::{OpacityRule, Segment, TransferFunction};
use crate::grid::Calibration;
use crate::optics::opacity_of_depth;
use crate::real::Real;

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
/// # What a table adds to the error
/// In each interval κ and q are linear, with the exact mean. Knots of the transfer function (kinks and jumps) fall onto interval ends
/// where any number of intervals between half of `entries` and `entries` allows that ([`PreIntegrated::is_aligned`]); a knot inside an
/// interval is known to that interval only. So an aligned table is off by the square of the interval in κ (10⁻⁶ of it with 1024
/// intervals over a smooth ramp), and one that is not by the share that an interval has in v₁ − v₀.
///
/// # Opaque walls
/// Where α is 1 over a range of values and κ is infinite (the power rule), [`PreIntegrated::segment`] ends at the wall exactly. The
/// rows themselves stay finite: κ is [`WALL_DEPTH`] per unit distance there. Where α only touches 1, κ has an integrable logarithm
/// and its mean is finite.
#[derive(Clone, Debug)]
pub struct PreIntegrated<R> {
    rows: Vec<PreIntegratedRow<R>>,
    origin: R,
    per_unit: R,
    last: R,
    quantum: [R; 4],
    /// Ranges of α = 1 in entries, ascending, with the colour at their lower and upper end.
    walls: Vec<Wall<R>>,
    /// Entries by which a wall must be entered: what is less is rounding, and only touches it.
    touch: R,
    /// The largest colour, channel by channel: no stretch shines brighter. Absent where emission is given on its own.
    brightest: Option<[R; 3]>,
    aligned: bool,
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

/// Where a value lies in the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePlace<R> {
    /// The row.
    pub row: usize,
    /// The fraction in its interval: in [0, 1), but for the first row (below 0, too) and the last (above 1, too).
    pub fraction: R,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Wall<R> {
    from: R,
    to: R,
    color: [[R; 3]; 2],
}

/// κ per unit distance that rows hold where it is infinite: over a quarter of a unit distance, nothing (10⁻⁷) comes through.
pub const WALL_DEPTH: f64 = 64.0;

impl<R: Real> PreIntegrated<R> {
    /// Intervals that serve where the table is aligned: 1024, which is 48 KiB in f32. 4096 gain nothing then.
    pub const ENTRIES: usize = 1024;

    /// Tabulates over the stored numbers that lie in `range` and between the outermost points of the transfer function (beyond
    /// which it is constant), in at most `entries` intervals (at least 2 are made).
    pub fn new(transfer: &TransferFunction, calibration: Calibration, range: (f32, f32), entries: usize) -> Self {
        let mut knots: Vec<f64> = transfer.segments()[1..].iter().map(|s| calibration.stored(s.from)).collect();
        knots.sort_by(f64::total_cmp);
        let field = (f64::from(range.0), f64::from(range.1));
        let ends = (knots[0], knots[knots.len() - 1]);
        // Not `clamp`, which panics where there is no range.
        let inside = |x: f64| x.max(field.0).min(field.1);
        let (mut low, mut high, entries) = (inside(ends.0), inside(ends.1), entries.max(2));
        let (mut intervals, mut aligned) = find_intervals(&knots, low, high, entries);
        if !aligned && ends.1 - ends.0 <= MOST_EXCESS * (high - low) {
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
        cells.push(Cell::beside(transfer, calibration, low, -beyond));
        if high > low {
            cells.extend((0..intervals).map(|i| Cell::new(transfer, calibration, &knots, end(i), end(i + 1))));
        } else if field.0 < field.1 && knots.contains(&low) {
            // All that changes over the field changes here. Of two points the later one may hold above or below.
            cells.push(Cell::beside(transfer, calibration, low, beyond));
        } else {
            cells.push(Cell::at(transfer, calibration, low));
        }
        cells.push(Cell::beside(transfer, calibration, end(intervals), beyond));

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

        let brightest = |c: usize| transfer.points().iter().map(|p| p.color[c]).fold(0.0, f64::max);
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
        Self {
            rows,
            origin: R::from_f64(origin),
            per_unit: R::from_f64(1.0 / spacing),
            last: R::from_index(last),
            quantum: quantum.map(R::from_f64),
            walls,
            touch: R::from_f64(4.0 * nudge),
            brightest: (!transfer.has_emission()).then(|| std::array::from_fn(|c| R::from_f64(brightest(c)))),
            aligned,
        }
    }

    /// The rows, by ascending value. The first and the last hold what is constant beyond the table.
    pub fn rows(&self) -> &[PreIntegratedRow<R>] {
        &self.rows
    }

    /// What one unit of a row's `sum` stands for: κ (or q) times intervals.
    pub fn quantum(&self) -> [R; 4] {
        self.quantum
    }

    /// The stored number at which the first row begins, and intervals per stored unit: x = (stored − first)·second lies in the row
    /// ⌊x⌋, clamped to the rows that exist.
    pub fn scale(&self) -> (R, R) {
        (self.origin, self.per_unit)
    }

    /// Stored units in an interval.
    pub fn spacing(&self) -> f64 {
        1.0 / self.per_unit.to_f64()
    }

    /// Whether every knot of the transfer function inside the table is the end of an interval.
    pub fn is_aligned(&self) -> bool {
        self.aligned
    }

    /// Whether α is 1 over some range of values and κ infinite.
    pub fn has_walls(&self) -> bool {
        !self.walls.is_empty()
    }

    /// Whether nothing absorbs or shines at any value from `low` to `high`, as far as the table knows: segments between such values are
    /// zero to the last bit.
    pub fn is_clear(&self, low: R, high: R) -> bool {
        let (a, b) = (self.place(low), self.place(high));
        let clear = |row: &PreIntegratedRow<R>| row.start == [R::ZERO; 4] && row.rise == [R::ZERO; 4];
        self.rows[a.row..=b.row.max(a.row)].iter().all(clear)
    }

    /// Where a stored number lies. NaN lies in the first row, at a fraction that is NaN.
    #[inline(always)]
    pub fn place(&self, stored: R) -> TablePlace<R> {
        let x = (stored - self.origin) * self.per_unit;
        let row = x.max(R::ZERO).min(self.last).to_index();
        TablePlace { row, fraction: x - R::from_index(row) }
    }

    /// (q_r, q_g, q_b, κ) at a place, per world unit.
    #[inline(always)]
    pub fn at(&self, place: TablePlace<R>) -> [R; 4] {
        let row = &self.rows[place.row];
        std::array::from_fn(|c| row.start[c] + place.fraction * row.rise[c])
    }

    /// Mean emission and extinction (q_r, q_g, q_b, κ) per world unit along a stretch on which the value goes linearly from one
    /// place to another.
    #[inline(always)]
    pub fn mean_between(&self, a: TablePlace<R>, b: TablePlace<R>) -> [R; 4] {
        let half = R::from_f64(0.5);
        let (a, b) = if a.row <= b.row { (a, b) } else { (b, a) };
        let (first, last) = (&self.rows[a.row], &self.rows[b.row]);
        if a.row == b.row {
            let middle = half * (a.fraction + b.fraction);
            return std::array::from_fn(|c| first.start[c] + middle * first.rise[c]);
        }
        // From a to the end of its row, and from the begin of b's row to b: no digits are lost in either.
        let (rest, centre) = (R::ONE - a.fraction, half * (R::ONE + a.fraction));
        let before = half * b.fraction;
        let between = R::from_index(b.row - a.row - 1);
        let per_interval = R::ONE / (rest + between + b.fraction);
        let next = &self.rows[a.row + 1];
        std::array::from_fn(|c| {
            let ends =
                rest * (first.start[c] + centre * first.rise[c]) + b.fraction * (last.start[c] + before * last.rise[c]);
            // Whole rows between them: exactly 0 where there is none.
            let sum = last.sum[c].wrapping_sub(next.sum[c]) as i32;
            let whole = self.quantum[c] * R::from_f64(f64::from(sum));
            (ends + whole) * per_interval
        })
    }

    /// Mean emission and extinction (q_r, q_g, q_b, κ) per world unit along a stretch on which the value goes linearly from `front` to
    /// `back`, in stored units. NaN if either is.
    #[inline(always)]
    pub fn mean(&self, front: R, back: R) -> [R; 4] {
        self.mean_between(self.place(front), self.place(back))
    }
}

impl<R: Real> PreIntegrated<R> {
    /// Light (r, g, b) and opacity of a stretch of `length` world units on which the value goes linearly from `front` to `back`, in stored
    /// units. Nothing if either is NaN.
    ///
    /// α = 1 − e^(−τ) with τ = κ̄·length is exact. The light, ∫ q e^(−τ) ds, is q̄·length·w(τ), exact where the colour is constant, and
    /// corrected by what it changes with depth: the part of the light that lies further in front is dimmed less. To the third order in
    /// the length that is
    ///
    /// e^(−τ/2) (q₀κ₁ − q₁κ₀) length²/12, q₀ and κ₀ being those in front and q₁ and κ₁ those at the back: −Δc·τ²/12·e^(−τ/2) for a colour
    /// that changes by Δc.
    ///
    /// Without it, a rule made of such stretches cannot have an order above 2.
    #[inline(always)]
    pub fn segment(&self, front: R, back: R, length: R) -> [R; 4] {
        if front.is_nan() || back.is_nan() {
            return [R::ZERO; 4];
        }
        self.segment_between(self.place(front), self.place(back), length)
    }

    /// Light and opacity of a stretch on which the value is the parabola through three equidistant samples. Nothing if any is NaN.
    ///
    /// The parabola is walked as two chords, from its begin to its middle and on to its end. A parabola whose middle lies δ above the
    /// straight line from begin to end bulges above each chord by δ/6 in the mean: both chords are raised by that, and the mean of
    /// the value is Simpson's. What the chords still differ from the parabola is of the fourth order, like Simpson's rule, but stays so at
    /// kinks of the transfer function.
    #[inline(always)]
    pub fn segment3(&self, front: R, middle: R, back: R, length: R) -> [R; 4] {
        let delta = middle - R::from_f64(0.5) * (front + back);
        let raise = delta * R::from_f64(1.0 / 6.0);
        if raise.is_nan() {
            return [R::ZERO; 4];
        }
        let samples = [front, middle, back];
        // A parabola may leave the range of the field's values; into a wall it must not.
        let raise = if !self.walls.is_empty() && self.overshoots(samples, raise) { R::ZERO } else { raise };
        let [front, middle, back] = samples.map(|v| self.place(v + raise));
        let half = R::from_f64(0.5) * length;
        behind(self.segment_between(front, middle, half), self.segment_between(middle, back, half))
    }

    /// As [`PreIntegrated::segment`], between places that are known already.
    #[inline(always)]
    pub fn segment_between(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> [R; 4] {
        if !self.walls.is_empty()
            && let Some(step) = self.segment_to_wall(front, back, length)
        {
            return step;
        }
        self.open_segment(front, back, length)
    }

    /// A stretch without a wall.
    #[inline(always)]
    fn open_segment(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> [R; 4] {
        let mean = self.mean_between(front, back);
        // Most of a typical scan is air.
        if mean == [R::ZERO; 4] {
            return mean;
        }
        let tau = mean[3] * length;
        let alpha = opacity_of_depth(tau);
        let weight = if tau == R::ZERO { R::ONE } else { alpha / tau };
        let (a, b) = (self.at(front), self.at(back));
        // τ²·/12 e^(−τ/2), by a quotient that follows the projection of the light onto linear colours, 1 − α/2 − α/τ, to 1.5 % up to τ = 4.
        let fade = R::ONE / (R::from_f64(12.0) + tau * (R::from_f64(6.0) + R::from_f64(1.5) * tau));
        // Optical depths, so that worlds of any scale neither overflow nor vanish. Where both ends are denser than the mean, their
        // product counts no more than the mean's square. 0/0 is NaN, which `min` passes over.
        let (tau_a, tau_b) = (a[3] * length, b[3] * length);
        let moment = fade * (tau * tau / (tau_a * tau_b)).min(R::ONE);
        let light = |c: usize| {
            let l = mean[c] * length * weight + moment * (a[c] * length * tau_b - b[c] * length * tau_a);
            let l = l.max(R::ZERO);
            self.brightest.map_or(l, |most| l.min(most[c] * alpha))
        };
        [light(0), light(1), light(2), alpha]
    }

    /// Whether values from `low` to `high`, in entries, get into a wall.
    fn enters(&self, wall: &Wall<R>, low: R, high: R) -> bool {
        high > wall.from + self.touch && low < wall.to - self.touch
    }

    /// Whether the two chords of a parabola get into a wall that its samples do not touch.
    #[cold]
    fn overshoots(&self, samples: [R; 3], raise: R) -> bool {
        let x = |stored: R| {
            let p = self.place(stored);
            R::from_index(p.row) + p.fraction
        };
        let places = samples.map(x);
        let (low, high) = (places[0].min(places[1]).min(places[2]), places[0].max(places[1]).max(places[2]));
        let raise = raise * self.per_unit;
        let (lowest, highest) = (low + raise.min(R::ZERO), high + raise.max(R::ZERO));
        self.walls.iter().any(|w| self.enters(w, lowest, highest) && !self.enters(w, low, high))
    }

    /// A stretch that meets a wall: what lies before it, and the wall's own colour. `None` if it meets none.
    #[cold]
    fn segment_to_wall(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> Option<[R; 4]> {
        let x = |p: TablePlace<R>| R::from_index(p.row) + p.fraction;
        let (from, to) = (x(front), x(back));
        let rising = from <= to;
        let met = |w: &&Wall<R>| {
            // A constant value is in or out, the upper end being out; a value that changes must get inside.
            if from == to { w.from <= from && from < w.to } else { self.enters(w, from.min(to), from.max(to)) }
        };
        let wall = if rising { self.walls.iter().find(met)? } else { self.walls.iter().rev().find(met)? };
        let entry = if rising { from.max(wall.from) } else { from.min(wall.to) };
        // 0/0 in a wall of which nothing else is known: an infinite one has one colour.
        let share = (entry - wall.from) / (wall.to - wall.from);
        let share = share.max(R::ZERO).min(R::ONE);
        let color = |c: usize| {
            let [low, high] = [wall.color[0][c], wall.color[1][c]];
            if low == high { low } else { low + share * (high - low) }
        };
        let mut step = [R::ZERO; 4];
        if entry != from {
            let row = entry.min(self.last).to_index();
            // The side of the entry that was walked.
            let row = if rising && row > 0 && R::from_index(row) == entry { row - 1 } else { row };
            let end = TablePlace { row, fraction: entry - R::from_index(row) };
            let share = (entry - from) / (to - from);
            step = self.open_segment(front, end, share * length);
        }
        let wall = if self.brightest.is_some() { [color(0), color(1), color(2), R::ONE] } else { [R::ZERO; 4] };
        let mut light = behind(step, wall);
        light[3] = R::ONE;
        Some(light)
    }
}

/// What two consecutive steps send out together: the second one dimmed by the first.
#[inline(always)]
fn behind<R: Real>(front: [R; 4], back: [R; 4]) -> [R; 4] {
    let clear = R::ONE - front[3];
    std::array::from_fn(|c| front[c] + clear * back[c])
}

/// How many intervals to make: the number between half of `most` and `most` for which most knots are ends of intervals. And whether all
/// are.
fn find_intervals(knots: &[f64], low: f64, high: f64, most: usize) -> (usize, bool) {
    if high <= low {
        return (1, true);
    }
    let inner: Vec<f64> = knots.iter().filter(|&&k| k > low && k < high).map(|k| (k - low) / (high - low)).collect();
    let missed = |n: usize| {
        let off = |&&x: &&f64| (x * n as f64 - libm::round(x * n as f64)).abs() > ALIGNED;
        inner.iter().filter(off).count()
    };
    let best = (most / 2..=most).rev().map(|n| (missed(n), n)).min_by_key(|&(m, _)| m);
    best.map_or((most, false), |(m, n)| (n, m == 0))
}

/// How far, in intervals, a knot may be from the end of one and still counts as there: the places of f32 values are known to 10⁻³.
const ALIGNED: f64 = 1e-6;

/// A table may be so many times longer than the field needs, if its intervals then fit the knots.
const MOST_EXCESS: f64 = 4.0;

/// κ and q in an interval of stored numbers, before they are rounded.
struct Cell {
    mean: [f64; 4],
    start: [f64; 4],
    rise: [f64; 4],
}

impl Cell {
    /// What holds at an end of the table and beyond; `beyond` tells the side.
    fn beside(transfer: &TransferFunction, calibration: Calibration, stored: f64, beyond: f64) -> Self {
        let outside = calibration.value(stored + beyond);
        let segment = transfer.segment_at(outside);
        let at_end = properties(transfer, segment, calibration.value(stored));
        Self::constant(if at_end[3].is_finite() { at_end } else { properties(transfer, segment, outside) })
    }

    /// What holds at a single value: that of a constant field, on which α = 1 is opaque, whatever it is beside.
    fn at(transfer: &TransferFunction, calibration: Calibration, stored: f64) -> Self {
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
    fn new(transfer: &TransferFunction, calibration: Calibration, knots: &[f64], from: f64, to: f64) -> Self {
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

/// (q, κ) at a value, with the line of a given segment: κ = +∞ where α only touches 1, and a wall's stand-in where it stays there.
fn properties(transfer: &TransferFunction, segment: &Segment, value: f64) -> [f64; 4] {
    let o = segment.at(value);
    let wall = is_wall(transfer, segment);
    let kappa = if wall { WALL_DEPTH / transfer.unit_distance() } else { transfer.extinction(o.opacity) };
    // κ·0 is no light, however large κ.
    let of_color = |c: f64| if c == 0.0 { 0.0 } else { kappa * c };
    let [r, g, b] = if transfer.has_emission() { o.emission } else { o.color.map(of_color) };
    [r, g, b, kappa]
}

/// Whether α is 1 throughout a segment, and κ infinite.
fn is_wall(transfer: &TransferFunction, segment: &Segment) -> bool {
    transfer.rule() == OpacityRule::Power && segment.is_opaque()
}

/// The mean of (q, κ) over the values from `a` to `b` of one segment.
fn mean_of(transfer: &TransferFunction, segment: &Segment, a: f64, b: f64) -> [f64; 4] {
    if transfer.rule() == OpacityRule::Extinction || is_wall(transfer, segment) {
        // κ and c are linear, their product a parabola: Simpson's rule is exact.
        let [start, middle, end] = [a, 0.5 * (a + b), b].map(|v| properties(transfer, segment, v));
        return std::array::from_fn(|c| (start[c] + 4.0 * middle[c] + end[c]) / 6.0);
    }
    let clear = [a, b].map(|v| 1.0 - segment.at(v).opacity);
    if clear[0].min(clear[1]) > 0.5 * clear[0].max(clear[1]) {
        return gauss_mean(|v| properties(transfer, segment, v), a, b);
    }
    // Towards α = 1 the logarithm bends too much for any quadrature. With w = 1 − α, linear in the value like the colour c:
    // ∫ −ln w dw = w (1 − ln w), ∫ −w ln w dw = w² (1 − 2 ln w)/4.
    let (low, high) = if clear[0] <= clear[1] { (a, b) } else { (b, a) };
    let w = [clear[0].min(clear[1]), clear[0].max(clear[1])];
    let ln = w.map(|w| if w > 0.0 { libm::log(w) } else { 0.0 });
    let span = w[1] - w[0];
    let per_unit = 1.0 / (transfer.unit_distance() * span);
    let zeroth = (w[1] * (1.0 - ln[1]) - w[0] * (1.0 - ln[0])) * per_unit;
    let first = 0.25 * (w[1] * w[1] * (1.0 - 2.0 * ln[1]) - w[0] * w[0] * (1.0 - 2.0 * ln[0])) * per_unit;
    let (start, end) = (segment.at(low), segment.at(high));
    let light = |c: usize| {
        if transfer.has_emission() {
            return 0.5 * (start.emission[c] + end.emission[c]);
        }
        let slope = (end.color[c] - start.color[c]) / span;
        (start.color[c] - slope * w[0]) * zeroth + slope * first
    };
    [light(0), light(1), light(2), zeroth]
}

/// The mean of a function whose nearest singularity is as far from the interval's middle as 1.5 intervals: Gauss and Legendre's
/// rule with 8 points misses less than 10⁻¹² of it.
fn gauss_mean(f: impl Fn(f64) -> [f64; 4], a: f64, b: f64) -> [f64; 4] {
    const NODES: [(f64, f64); 4] = [
        (0.183_434_642_495_649_8, 0.362_683_783_378_362),
        (0.525_532_409_916_329, 0.313_706_645_877_887_3),
        (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
        (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut sum = [0.0; 4];
    for (x, weight) in NODES {
        let (below, above) = (f(middle - half * x), f(middle + half * x));
        for c in 0..4 {
            sum[c] += 0.5 * weight * (below[c] + above[c]);
        }
    }
    sum
}

/// The ranges of values that are walls, in places of the table.
fn walls<R: Real>(transfer: &TransferFunction, calibration: Calibration, low: f64, spacing: f64) -> Vec<Wall<R>> {
    let mut walls: Vec<Wall<R>> = transfer
        .segments()
        .iter()
        .filter(|s| is_wall(transfer, s))
        .map(|s| {
            let place = |value: f64| {
                let x = (calibration.stored(value) - low) / spacing;
                let whole = libm::round(x);
                R::from_f64(1.0 + if (x - whole).abs() <= ALIGNED { whole } else { x })
            };
            let color = |o: &super::Optical| o.color.map(R::from_f64);
            let (a, b) = ((place(s.from), color(&s.start)), (place(s.to), color(&s.end)));
            let (a, b) = if calibration.slope > 0.0 { (a, b) } else { (b, a) };
            Wall { from: a.0, to: b.0, color: [a.1, b.1] }
        })
        .collect();
    walls.sort_by(|a, b| a.from.to_f64().total_cmp(&b.from.to_f64()));
    walls
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::ControlPoint;

    type Table = PreIntegrated<f64>;

    fn transfer(points: &[(f64, f64)], rule: OpacityRule, emits: bool) -> TransferFunction {
        let point = |&(value, opacity): &(f64, f64)| ControlPoint {
            emission: emits.then_some([0.01 * value, 1.0, 0.0]),
            ..ControlPoint::new(value, [0.2, 0.01 * value, 1.0 - 0.01 * value], opacity)
        };
        TransferFunction::new(points.iter().map(point).collect(), rule, 0.7).unwrap()
    }

    /// Ramps, a jump, a place where α touches 1.
    fn wild(rule: OpacityRule, emits: bool) -> TransferFunction {
        transfer(&[(10.0, 0.0), (35.0, 0.9), (35.0, 0.1), (60.0, 1.0), (70.0, 0.02), (93.0, 0.5)], rule, emits)
    }

    /// The mean of (q, κ) over the values, by many small steps.
    fn mean(t: &TransferFunction, calibration: Calibration, a: f64, b: f64) -> [f64; 4] {
        let n = 40_000;
        let mut sum = [0.0; 4];
        for i in 0..n {
            let value = calibration.value(a + (b - a) * (f64::from(i) + 0.5) / f64::from(n));
            let all = properties(t, t.segment_at(value), value);
            sum = std::array::from_fn(|c| sum[c] + all[c] / f64::from(n));
        }
        sum
    }

    #[test]
    fn means_are_exact_but_for_the_table() {
        for rule in [OpacityRule::Power, OpacityRule::Extinction] {
            for emits in [false, true] {
                for calibration in [Calibration::default(), Calibration { slope: -0.5, intercept: 80.0 }] {
                    let t = wild(rule, emits);
                    let table = Table::new(&t, calibration, (-200.0, 200.0), 1024);
                    assert!(table.is_aligned() && !table.has_walls());
                    let stored = |value: f64| calibration.stored(value);
                    let pairs = [
                        (5.0, 150.0),
                        (20.0, 21.0),
                        (34.9, 35.1),
                        (59.0, 61.0),
                        (93.5, 200.0),
                        (12.0, 92.0),
                        (69.99, 70.0),
                    ];
                    for (a, b) in pairs {
                        let (a, b) = (stored(a), stored(b));
                        let (got, want) = (table.mean(a, b), mean(&t, calibration, a, b));
                        let back = table.mean(b, a);
                        for c in 0..4 {
                            // κ is linear in an interval of a tenth of a unit; the logarithm at 60, and the sum that it is held against,
                            // have 10⁻⁴. The bound stands for the square of an interval, times the curvature of κ.
                            let bound = 2e-4 * (1.0 + want[c]);
                            assert!((got[c] - want[c]).abs() <= bound, "{rule:?} {emits} {a} {b}: {got:?} {want:?}");
                            assert!((got[c] - back[c]).abs() <= 1e-9 * (1.0 + want[c]), "either way round");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn values_and_small_differences() {
        let t = wild(OpacityRule::Power, false);
        for entries in [1024, 4096] {
            let table = PreIntegrated::<f32>::new(&t, Calibration::default(), (0.0, 100.0), entries);
            for i in 0..2000 {
                let v = 0.05 * i as f32;
                if (v - 60.0).abs() < 1.0 {
                    continue;
                }
                let exact = t.extinction_at(f64::from(v));
                // Straddling the end of an interval, or not: nothing cancels.
                for d in [0.0, 1e-5, 1e-3, 0.1] {
                    let got = f64::from(table.mean(v, v + d)[3]);
                    let steep = (t.extinction_at(f64::from(v + d)) - exact).abs() + 1e-3;
                    let jumps = v <= 35.0 && v + d >= 35.0;
                    assert!(jumps || (got - exact).abs() < steep, "{v} {d}: {got} {exact}");
                }
            }
            // At a jump the later point holds.
            assert!((f64::from(table.mean(35.0, 35.0)[3]) - t.extinction_at(35.0)).abs() < 1e-3);
            assert!((f64::from(table.mean(34.99, 34.99)[3]) - t.extinction_at(34.99)).abs() < 1e-2);
        }
    }

    #[test]
    fn clear_values_are_zero_to_the_last_bit() {
        let t = transfer(&[(10.0, 0.0), (20.0, 0.0), (30.0, 0.5), (40.0, 0.0)], OpacityRule::Power, false);
        let table = PreIntegrated::<f32>::new(&t, Calibration::default(), (0.0, 255.0), 1024);
        assert!(table.is_clear(-5.0, 19.9) && table.is_clear(40.5, 1e6) && !table.is_clear(19.0, 21.0));
        for (a, b) in [(-5.0, 19.9), (15.0, 15.001), (19.0, -1e4), (41.0, 1e5)] {
            assert_eq!(table.segment(a, b, 10.0), [0.0; 4], "{a} {b}");
        }
        assert!(table.segment(0.0, 50.0, 1.0)[3] > 0.0, "a peak between two clear values is not missed");
        assert_eq!(table.segment(f32::NAN, 30.0, 1.0), [0.0; 4]);
        assert_eq!(table.segment3(25.0, f32::NAN, 30.0, 1.0), [0.0; 4]);
    }

    #[test]
    fn constant_fields_and_single_points() {
        let t = transfer(&[(0.0, 0.1), (100.0, 0.9)], OpacityRule::Power, false);
        let table = Table::new(&t, Calibration::default(), (42.0, 42.0), 1024);
        let (got, want) = (table.segment(42.0, 42.0, 1.3), t.step(42.0, 1.3));
        assert!((0..4).all(|c| (got[c] - want[c]).abs() < 1e-15), "{got:?} {want:?}");
        // A jump, and nothing else.
        let t = transfer(&[(50.0, 0.2), (50.0, 0.6)], OpacityRule::Power, false);
        let table = Table::new(&t, Calibration::default(), (0.0, 100.0), 1024);
        let kappa = [0.2, 0.6].map(|a| t.extinction(a));
        assert_eq!(table.mean(49.9, 49.9)[3], kappa[0]);
        assert_eq!(table.mean(50.0, 50.0)[3], kappa[1]);
        assert!((table.mean(40.0, 60.0)[3] - 0.5 * (kappa[0] + kappa[1])).abs() < 1e-8);
        // Its stored number falls as the value rises: the earlier point holds above it, and the later one still on it. So in a field that
        // begins where the points end.
        let falling = Calibration { slope: -2.0, intercept: 10.0 };
        let jump = falling.stored(50.0);
        for last in [50.0, 90.0] {
            let points = [(50.0, 0.2), (50.0, 0.6), (last, 0.6)];
            let t = transfer(&points, OpacityRule::Power, false);
            for range in [(-30.0, 30.0), (-20.5, -19.5), (-20.0, -10.0)] {
                let table = Table::new(&t, falling, range, 1024);
                for above in [1e-9, 1e-3, 0.4, 10.0] {
                    assert_eq!(table.mean(jump + above, jump + above)[3], kappa[0], "{range:?} {above}");
                }
                assert!((table.mean(jump, jump)[3] - kappa[1]).abs() < 1e-9, "{range:?}");
            }
        }
        // Where α touches 1, a constant field is opaque, and one that only passes by is not.
        let t = wild(OpacityRule::Power, false);
        let table = Table::new(&t, Calibration::default(), (60.0, 60.0), 1024);
        assert_eq!(table.segment(60.0, 60.0, 1e-6)[3], 1.0);
        for points in [[(10.0, 0.0), (60.0, 1.0), (70.0, 0.0)], [(10.0, 0.0), (60.0, 1.0), (60.0, 1.0)]] {
            let t = transfer(&points, OpacityRule::Power, false);
            for calibration in [Calibration::default(), Calibration { slope: -0.3, intercept: 70.0 }] {
                let table = PreIntegrated::<f32>::new(&t, calibration, (0.0, 255.0), 1024);
                let stored = |value: f64| calibration.stored(value) as f32;
                // Up to 60 and no further: the mean of −ln(1 − α) over a ramp from ½ to 1, which is 1 + ln 2, per 0.7.
                let alpha = -libm::expm1f(-1.693_147 / 0.7);
                assert!((table.segment(stored(35.0), stored(60.0), 1.0)[3] - alpha).abs() < 1e-3, "{calibration:?}");
                assert!((table.segment(stored(60.0), stored(35.0), 1.0)[3] - alpha).abs() < 1e-3, "{calibration:?}");
                // Nor does a parabola get there that its samples do not.
                assert!(table.segment3(stored(20.0), stored(55.0), stored(60.0), 0.01)[3] < 0.1);
            }
        }
    }

    #[test]
    fn the_later_point_holds_on_a_jump_far_from_zero() {
        for slope in [1.0, -1.0, 0.3, -0.3] {
            let calibration = Calibration { slope, intercept: 5.0 };
            for jump in (1..200).map(|i| 171 * i) {
                let at = calibration.value(f64::from(jump));
                // On its own, and at the end of a ramp that is narrow against the number.
                for ramp in [0.0, 0.7 * slope.abs()] {
                    let points = [(at - ramp, 0.3), (at, 0.2), (at, 0.6), (at + ramp, 0.6)];
                    let points = points.map(|(value, opacity)| ControlPoint::new(value, [1.0; 3], opacity)).to_vec();
                    let t = TransferFunction::new(points, OpacityRule::Power, 0.7).unwrap();
                    let stored = jump as f32;
                    let table = PreIntegrated::<f32>::new(&t, calibration, (stored - 1.0, stored + 1.0), 1024);
                    let kappa = f64::from(table.mean(stored, stored)[3]);
                    assert!((kappa - t.extinction(0.6)).abs() < 0.1, "{slope} {jump} {ramp}: {kappa}");
                }
            }
        }
    }

    #[test]
    fn walls_end_a_segment_where_they_begin() {
        let p = ControlPoint::new;
        let points = vec![
            p(0.0, [0.0; 3], 0.5),
            p(10.0, [0.0; 3], 0.5),
            p(10.0, [1.0, 0.5, 0.0], 1.0),
            p(20.0, [0.0, 0.5, 1.0], 1.0),
        ];
        let t = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let table = Table::new(&t, Calibration::default(), (-50.0, 50.0), 1024);
        assert!(table.has_walls());
        let assert_close = |got: [f64; 4], want: [f64; 4]| {
            assert!((0..4).all(|c| (got[c] - want[c]).abs() < 1e-6), "{got:?}, expected {want:?}");
        };
        // One unit of opacity ½ before it; from behind, its colour at that end.
        assert_close(table.segment(5.0, 15.0, 2.0), [0.5, 0.25, 0.0, 1.0]);
        assert_close(table.segment(15.0, 5.0, 2.0), [0.5, 0.5, 0.5, 1.0]);
        assert_close(table.segment(12.5, 12.5, 1e-9), [0.75, 0.5, 0.25, 1.0]);
        assert_close(table.segment(30.0, 40.0, 1e-9), [0.0, 0.5, 1.0, 1.0]);
        assert_close(table.segment(10.0, 10.0, 1e-9), [1.0, 0.5, 0.0, 1.0]);
        // A wall that is met at the very end is not entered.
        assert_close(table.segment(0.0, 9.999_999, 1.0), [0.0, 0.0, 0.0, 0.5]);
        assert_close(table.segment3(9.0, 9.9, 10.8, 1.8), {
            let before = 1.0 - 0.5f64.powf(1.0);
            [1.0 - before, 0.5 * (1.0 - before), 0.0, 1.0]
        });
    }

    #[test]
    fn light_changes_with_depth() {
        // κ constant, colour from 0 to 1 with the value: ∫ c dα in closed form, 1/τ − e^(−τ)(1 + 1/τ).
        let points = vec![ControlPoint::new(0.0, [0.0; 3], 0.5), ControlPoint::new(1.0, [1.0; 3], 0.5)];
        let t = TransferFunction::new(points, OpacityRule::Extinction, 0.5).unwrap();
        let table = Table::new(&t, Calibration::default(), (0.0, 1.0), 1024);
        for tau in [1e-6, 0.01, 0.1, 1.0, 4.0] {
            let exact = (1.0 - libm::exp(-tau) * (1.0 + tau)) / tau;
            let exact = if tau < 1e-3 { 0.5 * tau } else { exact };
            let got = table.segment(0.0, 1.0, tau)[0];
            // The quotient that stands for the projection is good to 1.5 % of a correction that is at most a quarter.
            assert!((got - exact).abs() <= 4e-3 * tau.min(1.0).powi(3) + 1e-9, "{tau}: {got} {exact}");
        }
    }
}
