//! Look-up in the table: at a value, and the mean between two.

use super::PreIntegrated;
use vr_core::Real;

/// Place of a value in the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePlace<R> {
    /// The row.
    pub row: usize,
    /// The fraction in its interval: in [0, 1), but for the first row (below 0, too) and the last (above 1, too).
    pub fraction: R,
}

impl<R: Real> TablePlace<R> {
    /// Distance from the start of the first row, in entries.
    pub(super) fn x(self) -> R {
        R::from_index(self.row) + self.fraction
    }
}

impl<R: Real> PreIntegrated<R> {
    /// True if anything absorbs or shines at a value from `low` to `high`, ends included, as far as the table knows: segments between other values are
    /// zero to the last bit.
    pub fn shows(&self, low: R, high: R) -> bool {
        let (a, b) = (self.place(low), self.place(high));
        // At the begin of its row, only what the row begins with counts.
        let begins = b.fraction == R::ZERO && self.rows[b.row].start == [R::ZERO; 4];
        let past = if begins { b.row } else { b.row + 1 };
        self.visible[past.max(a.row)] > self.visible[a.row]
    }

    /// Place of a stored number. NaN lies in the first row, at a fraction that is NaN.
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
