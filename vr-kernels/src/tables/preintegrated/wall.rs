//! Opaque walls: ranges of values over which α is 1, at which a stretch ends.

use super::intervals::ALIGNED;
use super::medium::is_wall;
use super::segment::behind;
use super::{PreIntegrated, TablePlace};
use vr_core::Calibration;
use vr_core::Real;
use vr_core::transfer::{Optical, TransferFunction};

/// A range of values with α = 1, in entries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wall<R> {
    pub(super) from: R,
    pub(super) to: R,
    /// Colour at the lower and at the upper end.
    pub(super) color: [[R; 3]; 2],
}

impl<R: Real> PreIntegrated<R> {
    /// True if values from `low` to `high`, in entries, get into a wall.
    fn enters(&self, wall: &Wall<R>, low: R, high: R) -> bool {
        high > wall.from + self.touch && low < wall.to - self.touch
    }

    /// True if the two chords of a parabola get into a wall that its samples do not touch.
    #[cold]
    pub(super) fn overshoots(&self, samples: [R; 3], raise: R) -> bool {
        let places = samples.map(|stored| self.place(stored).x());
        let (low, high) = (places[0].min(places[1]).min(places[2]), places[0].max(places[1]).max(places[2]));
        let raise = raise * self.per_unit;
        let (lowest, highest) = (low + raise.min(R::ZERO), high + raise.max(R::ZERO));
        self.walls.iter().any(|w| self.enters(w, lowest, highest) && !self.enters(w, low, high))
    }

    /// Light and opacity of a stretch that meets a wall: of what lies before it, and the wall's own colour. `None` if it meets none.
    #[cold]
    pub(super) fn segment_to_wall(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> Option<[R; 4]> {
        let (from, to) = (front.x(), back.x());
        let wall = |color: [R; 3]| if self.brightest.is_some() { color } else { [R::ZERO; 3] };
        let lone = self.lone_walls.iter().find(|(at, _)| from == *at && to == *at);
        if let Some((_, color)) = lone {
            let [r, g, b] = wall(*color);
            return Some([r, g, b, R::ONE]);
        }
        // The first wall on the way, its entry, and its colour there.
        let rising = from <= to;
        let is_met = |w: &&Wall<R>| {
            // A constant value is in or out, the upper end being out; a value that changes must get inside.
            if from == to { w.from <= from && from < w.to } else { self.enters(w, from.min(to), from.max(to)) }
        };
        let met = if rising { self.walls.iter().find(is_met)? } else { self.walls.iter().rev().find(is_met)? };
        let entry = if rising { from.max(met.from) } else { from.min(met.to) };
        // 0/0 in a wall of which nothing else is known: an infinite one has one colour.
        let share = (entry - met.from) / (met.to - met.from);
        let share = share.max(R::ZERO).min(R::ONE);
        let [low, high] = met.color;
        let color = |c: usize| if low[c] == high[c] { low[c] } else { low[c] + share * (high[c] - low[c]) };
        // The part before the wall, and the wall behind it.
        let mut step = [R::ZERO; 4];
        if entry != from {
            let row = entry.min(self.last).to_index();
            // The side of the entry that was walked.
            let row = if rising && row > 0 && R::from_index(row) == entry { row - 1 } else { row };
            let end = TablePlace { row, fraction: entry - R::from_index(row) };
            let share = (entry - from) / (to - from);
            step = self.open_segment(front, end, share * length);
        }
        let [r, g, b] = wall(std::array::from_fn(color));
        let mut light = behind(step, [r, g, b, R::ONE]);
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
