//! The first place of a ray where the field reaches a value, with a bound of what its pixel is off by.

use vr_core::{Calibration, Real};

use super::blocks::Blocks;
use super::cubic::Cubic;
use super::looks::Looks;
use super::optics::Optics;
use super::piece_by_piece::Place;
use super::reflection::RayReflection;
use super::series::Series;
use super::walk::{Course, Jump};

/// Largest number of halvings of a cell, after which a part is taken as in doubt.
const MAX_HALVINGS: u32 = 60;
/// Largest gap, relative to the distance, between two cells that touch.
const GAP: f64 = 4.0 * f64::EPSILON;

/// Search for the first place of one ray where the field is at least a threshold, in f64.
pub(super) struct FirstSearch<'a> {
    optics: &'a Optics,
    reflection: Option<RayReflection<'a>>,
    /// Calibrated value, its stored number, and 1 or −1 where larger values have smaller stored numbers.
    threshold: f64,
    stored: f64,
    sign: f64,
    /// Distance at which the last cell ended.
    end: f64,
    /// Last part of the last cell, if it may reach the threshold or not: what comes next tells.
    doubt: Option<Hit>,
    /// True if a part in doubt was followed by none that settles it.
    uncertain: bool,
    hit: Option<Hit>,
    pub(super) steps: u64,
}

/// Place where the threshold is reached.
#[derive(Clone, Copy, Debug)]
struct Hit {
    distance: f64,
    /// Bounds of the colour that is seen.
    colors: [[f64; 2]; 3],
}

/// Cell in which the threshold is looked for.
struct Cell {
    looks: Looks,
    s: f64,
    length: f64,
    /// Bound of what values are off by.
    off: f64,
    /// True if another cell ends where it begins.
    follows: bool,
}

/// Part of a cell: how far the field is above the threshold, between two fractions of the cell.
#[derive(Clone, Copy)]
struct Part {
    above: Cubic<f64>,
    ends: [f64; 2],
    halvings: u32,
}

/// Pixel of a first place.
pub(super) struct FirstPixel {
    pub(super) rgba: [f64; 4],
    /// Bound of what each component is off by.
    pub(super) off: f64,
    pub(super) distance: f64,
}

impl<'a> FirstSearch<'a> {
    pub(super) fn new(optics: &'a Optics, reflection: Option<RayReflection<'a>>, threshold: f64) -> Self {
        let calibration: Calibration = optics.calibration;
        let (stored, sign) = (calibration.stored(threshold), calibration.slope.signum());
        let (end, doubt, uncertain, hit, steps) = (f64::NAN, None, false, None, 0);
        Self { optics, reflection, threshold, stored, sign, end, doubt, uncertain, hit, steps }
    }

    /// Returns the pixel, if the threshold is reached. `brightest` bounds reflected colours.
    pub(super) fn pixel(mut self, brightest: f64) -> FirstPixel {
        self.settle();
        let unknown = if self.uncertain { brightest.max(1.0) } else { 0.0 };
        let Some(hit) = self.hit else {
            return FirstPixel { rgba: [0.0; 4], off: unknown, distance: f64::INFINITY };
        };
        let [r, g, b] = hit.colors.map(|[low, high]| 0.5 * (low + high));
        let width = hit.colors.iter().map(|[low, high]| 0.5 * (high - low)).fold(0.0, f64::max);
        let off = width + 8.0 * f64::EPSILON * brightest.max(1.0) + unknown;
        FirstPixel { rgba: [r, g, b, 1.0], off, distance: hit.distance }
    }

    /// Settles a part in doubt that nothing above the threshold follows: whether it was reached there is not known.
    fn settle(&mut self) {
        self.uncertain |= self.doubt.take().is_some();
    }

    /// Returns a place on a part of a cell where the field has a value in a range of calibrated ones, the lower end of which is approached from above alone.
    fn place(&self, [low, high]: [f64; 2], looks: &Looks, ends: [f64; 2], distance: f64) -> Hit {
        let transfer = &self.optics.transfer;
        let mut colors = transfer.at(low).color.map(|c| [c; 2]);
        for segment in transfer.segments().iter().filter(|s| s.to > low && s.from <= high) {
            for value in [low.max(segment.from), high.min(segment.to)] {
                for (range, c) in colors.iter_mut().zip(segment.at(value).color) {
                    if high > low {
                        *range = [range[0].min(c), range[1].max(c)];
                    }
                }
            }
        }
        if let Some(change) = looks.change(self.reflection.as_ref(), ends) {
            for (c, range) in colors.iter_mut().enumerate() {
                let lit = change.of(&Series::between(range[0], range[1]), c);
                *range = lit.range().map(|x| x.max(0.0));
            }
        }
        Hit { distance, colors }
    }

    /// Takes a place where the threshold is reached for certain, or was in the part in doubt right before.
    fn reach(&mut self, place: Hit) {
        self.hit = Some(self.or_doubt(place));
    }

    /// Returns a place, or the part in doubt right before it, whichever it is.
    fn or_doubt(&mut self, place: Hit) -> Hit {
        self.doubt.take().map_or(place, |doubt| doubt.or(&place))
    }

    /// Searches a part of a cell.
    fn part(&mut self, cell: &Cell, part: Part) {
        if self.is_done() {
            return;
        }
        self.steps += 1;
        let Part { above, ends, halvings } = part;
        let (low, high) = above.hull();
        if high < -cell.off {
            return self.settle();
        }
        let distance = cell.s + ends[0] * cell.length;
        let is_entry = ends[0] == 0.0 && !cell.follows;
        let slope = self.optics.calibration.slope.abs();
        if above.0[0] >= cell.off {
            // Between cells the field is continuous: but for an entry, it has the very value here, or had it in the part in doubt.
            let value = |above: f64| self.threshold + slope * above.max(0.0);
            let values = if is_entry {
                [value(above.0[0] - cell.off).next_down().max(self.threshold), value(above.0[0] + cell.off).next_up()]
            } else {
                [self.threshold; 2]
            };
            let place = self.place(values, &cell.looks, [ends[0]; 2], distance);
            return self.reach(place);
        }
        if high - low <= 4.0 * cell.off || halvings >= MAX_HALVINGS {
            let top = (self.threshold + slope * (high + cell.off).max(0.0)).next_up();
            let values = [self.threshold, if is_entry { top } else { self.threshold }];
            let place = self.place(values, &cell.looks, ends, distance);
            self.doubt = Some(self.or_doubt(place));
            return;
        }
        let (front, back) = above.split(0.5);
        let middle = 0.5 * (ends[0] + ends[1]);
        self.part(cell, Part { above: front, ends: [ends[0], middle], halvings: halvings + 1 });
        self.part(cell, Part { above: back, ends: [middle, ends[1]], halvings: halvings + 1 });
    }

    /// True if no stored number of a range reaches the threshold.
    fn is_below(&self, [low, high]: [f64; 2]) -> bool {
        (self.sign * (low - self.stored)).max(self.sign * (high - self.stored)) < -self.optics.knot_error
    }

    /// True if a cell that begins at a distance follows the last one; what else is in doubt stays so.
    fn follows(&mut self, s: f64) -> bool {
        let follows = (self.end - s).abs() <= GAP * s.abs();
        if !follows {
            self.settle();
        }
        follows
    }
}

impl Hit {
    /// Returns the place, of which only is known that it is one of two.
    fn or(&self, other: &Self) -> Self {
        let both = |c: usize| {
            let ([a, b], [d, e]) = (self.colors[c], other.colors[c]);
            [a.min(d), b.max(e)]
        };
        Self { distance: self.distance, colors: std::array::from_fn(both) }
    }
}

impl Course for FirstSearch<'_> {
    fn is_done(&self) -> bool {
        self.hit.is_some()
    }

    fn passes_block(&mut self, blocks: &Blocks, index: usize, _: f64, _: f64) -> bool {
        let [low, high] = blocks.range(index);
        low > high || self.is_below([low, high])
    }

    fn passes_values(&self, range: [f64; 2]) -> bool {
        self.is_below(range)
    }

    fn resolution(&self, range: [f64; 2]) -> f64 {
        // Only where the threshold is matters.
        if self.is_below(range) { f64::INFINITY } else { 0.0 }
    }

    /// Does nothing: places are not what a pixel depends on.
    fn jump(&mut self, _: &Jump) {}

    fn constant(&mut self, stored: f64, looks: impl FnOnce() -> Looks, s: f64, length: f64) {
        self.steps += 1;
        self.follows(s);
        self.end = s + length;
        let value = self.optics.calibration.value(stored);
        if value >= self.threshold {
            let place = self.place([value; 2], &looks(), [0.0; 2], s);
            self.reach(place);
        } else {
            self.settle();
        }
    }

    fn cell<R: Real>(&mut self, cubic: Cubic<R>, place: Place, looks: impl FnOnce() -> Looks, s: f64, length: f64) {
        let follows = self.follows(s);
        self.end = s + length;
        // Roundings of the interpolation and of the position, as for integrals, of halving, and of the threshold.
        let off = place.reach * (f64::EPSILON * 256.0 + 3.0 * place.misplaced)
            + place.off
            + 2.0 * f64::EPSILON * (place.base.abs() + self.stored.abs())
            + self.optics.knot_error;
        let above = Cubic(cubic.0.map(|b| self.sign * ((place.base - self.stored) + b.to_f64())));
        let cell = Cell { looks: looks(), s, length, off, follows };
        self.part(&cell, Part { above, ends: [0.0, 1.0], halvings: 0 });
    }
}
