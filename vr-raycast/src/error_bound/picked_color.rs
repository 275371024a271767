//! The colour of the place where an extreme of a ray is, with a bound of what it is off by.

use vr_core::Real;

use super::blocks::Blocks;
use super::cubic::Cubic;
use super::looks::Looks;
use super::piece_by_piece::Place;
use super::series::Series;
use super::tint::Tint;
use super::walk::{Course, Jump};

/// Largest number of halvings of a cell, after which a part counts with all of its colours.
const MAX_HALVINGS: u32 = 30;
/// Share of the error promised that the colours on a part may differ by, so that shorter parts are not looked at.
const SHARE: f64 = 0.02;

/// Extreme of a ray that was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extreme {
    /// 1 for a largest stored number, −1 for a smallest.
    pub(super) sign: f64,
    /// Lower bound of the true extreme, times the sign.
    pub(super) at_least: f64,
    /// Colour of the place where it was found, and a bound of what its channels are off by.
    pub(super) color: [f64; 3],
    pub(super) color_off: f64,
}

/// Search for all places of a ray where the true extreme may be: those where the field may reach its lower bound.
pub(super) struct PlacesOfExtreme {
    extreme: Extreme,
    /// Difference of colours that does not matter.
    resolution: f64,
    /// Largest difference of a channel from the colour that was found.
    apart: f64,
    /// True if a place was seen that has the extreme for certain: of equals, the nearest is picked.
    is_settled: bool,
    pub(super) steps: u64,
}

/// Part of a cell: the field times the sign, less the extreme, between two fractions of the cell.
#[derive(Clone, Copy)]
struct Part {
    above: Cubic<f64>,
    ends: [f64; 2],
    halvings: u32,
}

impl PlacesOfExtreme {
    /// Begins a search, for a picture of which an error is promised.
    pub(super) fn new(extreme: Extreme, error: f64) -> Self {
        Self { extreme, resolution: SHARE * error, apart: 0.0, is_settled: false, steps: 0 }
    }

    /// Returns a bound of how far the true colour is from that of the extreme which was found.
    pub(super) fn largest_difference(&self) -> f64 {
        self.apart.min(1.0) + self.extreme.color_off
    }

    /// Takes the colours of a part of a cell where the extreme may be; `None`: they are white.
    fn take(&mut self, channels: Option<[Series; 3]>) {
        let Some(channels) = channels else { return };
        for (channel, found) in channels.iter().zip(self.extreme.color) {
            self.apart = self.apart.max((channel.c[0] - found).abs() + channel.spread());
        }
    }

    fn part(&mut self, tint: &Tint, off: f64, Part { above, ends, halvings }: Part) {
        self.steps += 1;
        let (low, high) = above.hull();
        if high < -off {
            return;
        }
        let channels = tint.on(ends);
        let difference = channels.iter().flatten().map(Series::spread).fold(0.0, f64::max);
        if difference <= self.resolution || halvings >= MAX_HALVINGS || low >= -off && high <= off {
            return self.take(channels);
        }
        let (front, back) = above.split(0.5);
        let (middle, halvings) = (0.5 * (ends[0] + ends[1]), halvings + 1);
        self.part(tint, off, Part { above: front, ends: [ends[0], middle], halvings });
        self.part(tint, off, Part { above: back, ends: [middle, ends[1]], halvings });
    }

    /// Returns the largest number of a range, times the sign.
    fn reached(&self, [low, high]: [f64; 2]) -> f64 {
        (self.extreme.sign * low).max(self.extreme.sign * high)
    }

    fn cannot_win(&self, range: [f64; 2]) -> bool {
        let (reached, at_least) = (self.reached(range), self.extreme.at_least);
        reached < at_least || self.is_settled && reached == at_least
    }
}

impl Course for PlacesOfExtreme {
    fn is_done(&self) -> bool {
        // All colours are possible.
        self.apart >= 1.0
    }

    fn passes_block(&mut self, blocks: &Blocks, index: usize, _: f64, _: f64) -> bool {
        let [low, high] = blocks.range(index);
        low > high || self.cannot_win([low, high])
    }

    fn passes_values(&self, range: [f64; 2]) -> bool {
        self.cannot_win(range)
    }

    fn resolution(&self, range: [f64; 2]) -> f64 {
        // Where the extreme is depends on all that is known of the field.
        if self.cannot_win(range) { f64::INFINITY } else { 0.0 }
    }

    /// Does nothing: the stretches on both sides of the place count already.
    fn jump(&mut self, _: &Jump) {}

    fn constant(&mut self, stored: f64, looks: impl FnOnce() -> Looks, _: f64, _: f64) {
        self.steps += 1;
        if !self.cannot_win([stored; 2]) {
            self.take(looks().tint.on([0.0; 2]));
            self.is_settled = true;
        }
    }

    fn cell<R: Real>(&mut self, cubic: Cubic<R>, place: Place, looks: impl FnOnce() -> Looks, _: f64, _: f64) {
        let Extreme { sign, at_least, .. } = self.extreme;
        // Inside a cell the field does not reach its extreme samples.
        if place.limits.is_some_and(|limits| self.reached(limits) <= at_least) {
            return;
        }
        // Roundings of the interpolation and of the position, as for the search of the value, and of halving.
        let off = place.reach * (f64::EPSILON * 256.0 + 3.0 * place.misplaced)
            + place.off
            + 4.0 * f64::EPSILON * (place.base.abs() + at_least.abs());
        let above = Cubic(cubic.0.map(|b| (sign * place.base - at_least) + sign * b.to_f64()));
        self.part(&looks().tint, off, Part { above, ends: [0.0, 1.0], halvings: 0 });
    }
}
