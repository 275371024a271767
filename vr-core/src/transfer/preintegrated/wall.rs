//! Opaque walls: where α is 1 over a range of values, and a stretch ends.

use super::intervals::ALIGNED;
use super::medium::is_wall;
use super::segment::behind;
use super::{PreIntegrated, TablePlace};
use crate::grid::Calibration;
use crate::real::Real;
use crate::transfer::{Optical, TransferFunction};

/// A range of values with α = 1, in entries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wall<R> {
    pub(super) from: R,
    pub(super) to: R,
    /// At the lower and at the upper end.
    pub(super) color: [[R; 3]; 2],
}

impl<R: Real> PreIntegrated<R> {
    /// Whether values from `low` to `high`, in entries, get into a wall.
    fn enters(&self, wall: &Wall<R>, low: R, high: R) -> bool {
        high > wall.from + self.touch && low < wall.to - self.touch
    }

    /// Whether the two chords of a parabola get into a wall that its samples do not touch.
    #[cold]
    pub(super) fn overshoots(&self, samples: [R; 3], raise: R) -> bool {
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
    pub(super) fn segment_to_wall(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> Option<[R; 4]> {
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

/// The ranges of values that are walls, in places of the table.
pub(super) fn walls<R: Real>(
    transfer: &TransferFunction,
    calibration: Calibration,
    low: f64,
    spacing: f64,
) -> Vec<Wall<R>> {
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
            let color = |o: &Optical| o.color.map(R::from_f64);
            let (a, b) = ((place(s.from), color(&s.start)), (place(s.to), color(&s.end)));
            let (a, b) = if calibration.slope > 0.0 { (a, b) } else { (b, a) };
            Wall { from: a.0, to: b.0, color: [a.1, b.1] }
        })
        .collect();
    walls.sort_by(|a, b| a.from.to_f64().total_cmp(&b.from.to_f64()));
    walls
}
