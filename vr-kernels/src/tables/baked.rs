//! A transfer function baked into a table for one step length: a look-up instead of an exponential.

use super::grid::{TableGrid, lone_walls};
use super::range::resolves_ramps;
use vr_core::Calibration;
use vr_core::Real;
use vr_core::transfer::{Optical, TransferFunction};

/// Opacity and premultiplied light of one step of a given length, tabulated over *stored* numbers at equal distances and
/// interpolated linearly.
///
/// Everything that depends on the step (the exponential, the source weight, the calibration) is folded in, in f64. A row is
/// (r, g, b, α): the light that a homogeneous step sends out and its opacity. Each interval has a row of its own for both of its
/// ends, so that a jump of the transfer function is a jump of the table. Where opacity touches 1 at a single value, that value has a row
/// to itself, and the rows around it have the same mean extinction. A step of another length is [`TransferFunction::step`].
#[derive(Clone, Debug)]
pub struct BakedTransfer<R> {
    grid: TableGrid,
    /// Start and end of each interval; and the last end once more, as an interval of no length.
    rows: Vec<[[R; 4]; 2]>,
    /// Isolated values of opacity 1: the stored number of each, and its row.
    walls: Vec<(R, [R; 4])>,
    /// Entry i: number of the first i intervals that are not clear.
    visible: Vec<u32>,
    origin: R,
    per_unit: R,
    last: R,
    resolves: bool,
}

/// Largest deviation of a [`BakedTransfer`] from the transfer function, at any stored number, apart from the rounding of its rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TableError {
    /// Largest deviation of a step's opacity.
    pub opacity: f64,
    /// Largest deviation of a component of a step's light.
    pub light: f64,
    /// Stored units by which the table moves a jump of the transfer function (and between the two places the deviations above do
    /// not hold); 0 where all of them lie on entries.
    pub jump_shift: f64,
}

impl TableError {
    /// Bounds the error of the table that [`BakedTransfer::new`] makes of the same arguments. This takes several times as long as the table, and no
    /// picture needs it.
    pub fn of(
        transfer: &TransferFunction,
        calibration: Calibration,
        range: (f32, f32),
        integer: bool,
        step: f64,
    ) -> Self {
        let grid = TableGrid::new(transfer, calibration, range, integer);
        let rows = grid.rows(transfer, calibration, |at| transfer.step_of(at, step));
        table_error(transfer, calibration, &grid, &rows[..grid.intervals()], step)
    }
}

impl<R: Real> BakedTransfer<R> {
    /// Tabulates over the stored numbers `range` (of integers, if `integer`) for steps of `step` world units.
    pub fn new(
        transfer: &TransferFunction,
        calibration: Calibration,
        range: (f32, f32),
        integer: bool,
        step: f64,
    ) -> Self {
        let grid = TableGrid::new(transfer, calibration, range, integer);
        let intervals = grid.intervals();
        let rounded = |row: [f64; 4]| row.map(R::from_f64);
        let row = |at: &Optical| rounded(transfer.step_of(at, step));
        let rows: Vec<[[R; 4]; 2]> = grid.rows(transfer, calibration, row);
        let walls = lone_walls(transfer, calibration).into_iter().map(|(at, wall)| (at, row(&wall))).collect();
        // Count the intervals that are not clear, so that a range of them is judged by one difference.
        let mut visible = vec![0];
        for row in &rows {
            visible.push(visible[visible.len() - 1] + u32::from(*row != [[R::ZERO; 4]; 2]));
        }
        let origin = R::from_f64(grid.origin());
        let per_unit = per_unit(&grid, calibration, origin);
        let resolves = resolves_ramps(grid.spacing().abs(), calibration, transfer);
        Self { grid, rows, walls, visible, origin, per_unit, last: R::from_f64(intervals as f64), resolves }
    }

    /// True if the entries lie close enough together to tell apart all that the transfer function does: else it must be evaluated.
    pub fn resolves(&self) -> bool {
        self.resolves
    }

    /// Stored units from one entry to the next.
    pub fn spacing(&self) -> f64 {
        self.grid.spacing().abs()
    }

    /// The places of the entries.
    pub(crate) fn grid(&self) -> &TableGrid {
        &self.grid
    }

    /// Rows (r, g, b, α) at the start and the end of each interval; and an interval of no length after the last.
    pub fn rows(&self) -> &[[[R; 4]; 2]] {
        &self.rows
    }

    /// Isolated values of opacity 1: the stored number of each, and its row.
    pub fn walls(&self) -> &[(R, [R; 4])] {
        &self.walls
    }

    /// The stored number of the first entry.
    pub fn origin(&self) -> R {
        self.origin
    }

    /// Intervals per stored unit; negative where larger stored numbers have smaller values.
    pub fn per_unit(&self) -> R {
        self.per_unit
    }

    /// Place of a stored number, which is not NaN, in the table: i + t for an interval i and a fraction t of it.
    ///
    /// It grows with the calibrated value, rounding included; numbers beyond the ends lie at the ends.
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
        if let Some((_, row)) = self.walls.iter().find(|(at, _)| *at == stored) {
            return *row;
        }
        let x = self.position(stored);
        let i = x.to_index();
        let t = x - R::from_index(i);
        let [a, b] = self.rows[i];
        std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
    }

    /// True if a step at any stored number from `low` to `high`, ends included, has light or opacity.
    ///
    /// Repeats what [`BakedTransfer::step`] does, rounding included: what is clear there is clear here.
    pub fn shows(&self, low: R, high: R) -> bool {
        let (a, b) = (self.position(low), self.position(high));
        let (from, to) = if a <= b { (a, b) } else { (b, a) };
        let (first, last) = (from.to_index(), to.to_index());
        let [start, end] = self.rows[last];
        // On an entry, the end of the interval has the weight 0.
        let reached = start != [R::ZERO; 4] || (to > R::from_index(last) && end != [R::ZERO; 4]);
        reached || self.visible[last] > self.visible[first]
    }
}

/// Intervals per stored unit, in the precision of the look-up, such that what lies on a break is found behind it: at a jump, the
/// later point holds.
fn per_unit<R: Real>(grid: &TableGrid, calibration: Calibration, origin: R) -> R {
    let mut per_unit = 1.0 / grid.spacing();
    // The first number of this precision that is on the break or past it.
    let behind = |stored: f64| {
        let nearest = R::from_f64(stored);
        let short = (stored - nearest.to_f64()) * grid.spacing() > 0.0;
        if short {
            R::from_f64(nearest.to_f64() + stored.abs() * 2.0 * R::ROUNDOFF * grid.spacing().signum())
        } else {
            nearest
        }
    };
    // Each round moves the last place by about one unit of rounding; three are what the look-up can lose.
    for _ in 0..4 {
        let tried = R::from_f64(per_unit);
        let missed = |(stored, entry): (f64, usize)| (behind(stored) - origin) * tried < R::from_index(entry);
        if !grid.breaks(calibration).any(missed) {
            break;
        }
        per_unit *= 1.0 + 2.0 * R::ROUNDOFF;
    }
    R::from_f64(per_unit)
}

/// Bounds the deviation of every interval from its chord.
///
/// Between knots, α of a step is concave or convex in the value (all three laws are), and so its greatest distance from a chord is at
/// most twice that at the middle. Light is the product of α with a linear colour: the product of two chords leaves |Δα Δc|/4.
/// If emission is given on its own, w(τ) is monotone and the chord is off by no more than the difference of the ends.
fn table_error(
    transfer: &TransferFunction,
    calibration: Calibration,
    grid: &TableGrid,
    exact: &[[[f64; 4]; 2]],
    step: f64,
) -> TableError {
    let mut error = TableError { jump_shift: grid.break_shift(), ..TableError::default() };
    let knots: Vec<f64> = transfer.segments()[1..].iter().map(|s| calibration.stored(s.from)).collect();
    for (i, ends) in exact.iter().enumerate() {
        let (a, b) = (grid.place(i), grid.place(i + 1));
        // Cut the interval at the knots inside it: on each part, colour and opacity are linear in the value.
        let inside = |k: &f64| (*k - a) * (*k - b) < 0.0;
        let mut cuts: Vec<f64> = knots.iter().copied().filter(inside).chain([a, b]).collect();
        cuts.sort_by(|x, y| ((x - a) / (b - a)).total_cmp(&((y - a) / (b - a))));
        for part in cuts.windows(2) {
            let optical = |x: f64| grid.optical(transfer, calibration, i, x);
            let entry = |x: f64| transfer.step_of(&optical(x), step);
            let chord = |x: f64, c: usize| ends[0][c] + (x - a) / (b - a) * (ends[1][c] - ends[0][c]);
            let (start, mid, end) = (entry(part[0]), entry(0.5 * (part[0] + part[1])), entry(part[1]));
            let at_ends = |c: usize| {
                let ends = [(part[0], start[c]), (part[1], end[c])];
                ends.iter().map(|&(x, e)| (e - chord(x, c)).abs()).fold(0.0, f64::max)
            };
            let bend = 2.0 * (mid[3] - 0.5 * (start[3] + end[3])).abs();
            error.opacity = error.opacity.max(at_ends(3) + bend);
            let (o0, o1) = (optical(part[0]), optical(part[1]));
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
    use vr_core::transfer::{ControlPoint, OpacityRule};

    fn exact(t: &TransferFunction, v: f64, step: f64) -> [f64; 4] {
        t.step(v, step)
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
                let error = TableError::of(&t, Calibration::default(), (0.0, 1.0), false, 0.31);
                // The logarithm at α = 1 is what a chord follows worst.
                assert!(error.opacity < 4e-2 && error.jump_shift == 0.0, "{error:?}");
                for i in 0..=100_000 {
                    let v = f64::from(i) / 1e5;
                    let (got, want) = (table.step(v), exact(&t, v, 0.31));
                    assert!((got[3] - want[3]).abs() <= error.opacity + 1e-15, "{rule:?} {v}");
                    for c in 0..3 {
                        assert!((got[c] - want[c]).abs() <= error.light + 1e-15, "{rule:?} {emits} {v}");
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

    /// Blue fog, and an orange wall from a value on.
    fn fog_and_wall(at: f64) -> TransferFunction {
        let (blue, orange) = ([0.0, 0.0, 1.0], [1.0, 0.7, 0.3]);
        let points = [(0.0, blue, 0.002), (at, blue, 0.002), (at, orange, 1.0), (100.0, orange, 1.0)];
        let points = points.map(|(value, color, opacity)| ControlPoint::new(value, color, opacity));
        TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap()
    }

    #[test]
    fn a_jump_shows_nothing_of_its_other_side() {
        for (slope, at) in [(1.0, 0.1f32), (1.0, 12.3), (-1.0, 33.3), (0.01, 77.7)] {
            let calibration = Calibration { slope, intercept: 0.0 };
            let transfer = fog_and_wall(f64::from(at));
            let stored = |value: f64| calibration.stored(value) as f32;
            let range = (stored(0.0).min(stored(100.0)), stored(0.0).max(stored(100.0)));
            let table = BakedTransfer::<f32>::new(&transfer, calibration, range, false, 1e-4);
            let jump = stored(f64::from(at));
            for k in -1000i16..=1000 {
                let stored = jump + f32::from(k) * jump.abs() * 1e-6;
                // Up to the rounding of the look-up.
                if k.abs() > 3 {
                    let wanted = exact(&transfer, calibration.value(f64::from(stored)), 1e-4);
                    let got = table.step(stored).map(f64::from);
                    assert!((0..4).all(|c| (got[c] - wanted[c]).abs() < 1e-6), "{stored}: {got:?}, not {wanted:?}");
                }
            }
            if calibration.value(f64::from(jump)) >= f64::from(at) {
                assert_eq!(table.step(jump)[3], 1.0, "at the jump, the later point holds: {slope} {at}");
            }
        }
    }

    #[test]
    fn what_shows_is_what_steps_show() {
        let transfer = fog_and_wall(12.5);
        let clear = ControlPoint::new(-5.0, [1.0; 3], 0.0);
        let points = [&[clear, ControlPoint { value: 0.0, ..clear }], transfer.points()].concat();
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        for slope in [1.0, -1.0] {
            let calibration = Calibration { slope, intercept: 0.0 };
            let range = if slope > 0.0 { (-20.0, 100.0) } else { (-100.0, 20.0) };
            let table = BakedTransfer::<f32>::new(&transfer, calibration, range, true, 1.0);
            let shows = |low: f32, high: f32| table.shows(slope as f32 * low, slope as f32 * high);
            assert!(!shows(-20.0, -1.0) && shows(-20.0, 0.0) && shows(50.0, 60.0) && shows(0.0, 0.0));
        }
    }
}
