//! The operators that pick one value of a ray, with a bound of what that is off by.

use vr_core::transfer::Segment;
use vr_core::{Calibration, Compositing, Real, TransferFunction};

use super::blocks::Blocks;
use super::cubic::Cubic;
use super::looks::Looks;
use super::picked_color::Extreme;
use super::piece_by_piece::Place;
use super::tint::Tint;
use super::walk::{Course, Jump};

/// Value that is picked from a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wanted {
    /// The largest of sign · stored number, the sign being 1 or −1.
    Extreme(f64),
    Average,
}

/// Search for the value that an operator picks from one ray, in f64.
#[derive(Clone, Debug)]
pub(super) struct Search {
    wanted: Wanted,
    /// Error of values that does not matter.
    resolution: f64,
    /// Largest value found, times the sign, and its distance.
    found: f64,
    pub(super) distance: f64,
    /// True if places have colours of their own.
    colored: bool,
    /// Colour of the place of the value found, and a bound of its error.
    color: ([f64; 3], f64),
    /// Bounds of the largest value that there is.
    at_least: f64,
    at_most: f64,
    /// Integrals of the field and of what it is off by, and the length of all that is no vacuum.
    integral: f64,
    off: f64,
    length: f64,
    /// Error of `length`.
    length_off: f64,
    /// Integrals of the colours and of what they are off by.
    colors: [f64; 3],
    colors_off: f64,
    pub(super) steps: u64,
}

impl Wanted {
    /// Returns what an operator picks; `None` if it picks no value of the whole ray.
    pub(super) fn by(compositing: Compositing, calibration: Calibration) -> Option<Self> {
        // A negative slope turns the order of the stored numbers round.
        let rising = calibration.slope > 0.0;
        match compositing {
            Compositing::Maximum => Some(Self::Extreme(if rising { 1.0 } else { -1.0 })),
            Compositing::Minimum => Some(Self::Extreme(if rising { -1.0 } else { 1.0 })),
            Compositing::Average => Some(Self::Average),
            _ => None,
        }
    }
}

impl Search {
    pub(super) fn new(wanted: Wanted, resolution: f64, colored: bool) -> Self {
        let none = f64::NEG_INFINITY;
        let (integral, off, length, length_off) = (0.0, 0.0, 0.0, 0.0);
        Self {
            wanted,
            resolution,
            found: none,
            distance: f64::INFINITY,
            colored,
            color: ([1.0; 3], 0.0),
            at_least: none,
            at_most: none,
            integral,
            off,
            length,
            length_off,
            colors: [0.0; 3],
            colors_off: 0.0,
            steps: 0,
        }
    }

    /// Returns the stored number that is picked and bounds of the true one; `None` where all is vacuum.
    pub(super) fn stored(&self) -> Option<(f64, [f64; 2])> {
        match self.wanted {
            Wanted::Extreme(sign) if self.found > f64::NEG_INFINITY => {
                let (low, high) = (self.at_least.min(self.found), self.at_most.max(self.found));
                Some((sign * self.found, if sign > 0.0 { [low, high] } else { [-high, -low] }))
            }
            Wanted::Average if self.length > 0.0 => {
                let mean = self.integral / self.length;
                let off = (self.off + self.length_off * mean.abs()) / self.length
                    + f64::EPSILON * (self.steps as f64 + 4.0) * mean.abs();
                Some((mean, [mean - off, mean + off]))
            }
            _ => None,
        }
    }

    /// Returns the extreme that was found; `None` if none was looked for.
    pub(super) fn extreme(&self) -> Option<Extreme> {
        let Wanted::Extreme(sign) = self.wanted else { return None };
        let (color, color_off) = self.color;
        Some(Extreme { sign, at_least: self.at_least, color, color_off })
    }

    /// Returns the mean colour, and a bound of what its channels are off by.
    pub(super) fn mean_color(&self) -> ([f64; 3], f64) {
        let off = (self.colors_off + self.length_off) / self.length + f64::EPSILON * (self.steps as f64 + 4.0);
        (self.colors.map(|sum| sum / self.length), off)
    }

    /// Takes a value at a distance, times the sign, that is off by `off` at most, and nowhere nearby beyond `limit`. Returns true if it is the best so far.
    fn take(&mut self, value: f64, off: f64, limit: f64, s: f64) -> bool {
        let is_best = value > self.found;
        if is_best {
            (self.found, self.distance) = (value, s);
        }
        self.at_least = self.at_least.max(value - off);
        self.at_most = self.at_most.max((value + off).min(limit));
        is_best
    }

    /// Adds the colours of a cell of a length.
    fn add_colors(&mut self, tint: &Tint, length: f64) {
        let (color, off) = tint.mean();
        for (sum, color) in self.colors.iter_mut().zip(color) {
            *sum += color * length;
        }
        self.colors_off += off * length;
    }

    /// True if no value of a range can be the one that is picked.
    fn cannot_win(&self, [low, high]: [f64; 2]) -> bool {
        match self.wanted {
            Wanted::Extreme(sign) => (sign * low).max(sign * high) <= self.at_least,
            Wanted::Average => false,
        }
    }
}

impl Course for Search {
    fn is_done(&self) -> bool {
        false
    }

    fn passes_block(&mut self, blocks: &Blocks, index: usize, _: f64, _: f64) -> bool {
        let [low, high] = blocks.range(index);
        low > high || self.cannot_win([low, high])
    }

    fn passes_values(&self, range: [f64; 2]) -> bool {
        self.cannot_win(range)
    }

    fn resolution(&self, _: [f64; 2]) -> f64 {
        self.resolution
    }

    fn jump(&mut self, jump: &Jump) {
        let largest = jump.sides.iter().flatten().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
        self.off += jump.misplaced * largest;
        self.length_off += jump.misplaced;
        self.colors_off += jump.misplaced;
    }

    fn constant(&mut self, stored: f64, looks: impl FnOnce() -> Looks, s: f64, length: f64) {
        self.steps += 1;
        match self.wanted {
            Wanted::Extreme(sign) => {
                if self.take(sign * stored, 0.0, f64::INFINITY, s) && self.colored {
                    self.color = looks().tint.at(0.0);
                }
            }
            Wanted::Average => {
                self.integral += stored * length;
                self.length += length;
                if self.colored {
                    self.add_colors(&looks().tint, length);
                }
            }
        }
    }

    fn cell<R: Real>(&mut self, cubic: Cubic<R>, place: Place, looks: impl FnOnce() -> Looks, s: f64, length: f64) {
        self.steps += 1;
        let cubic = Cubic(cubic.0.map(R::to_f64));
        // Roundings of the interpolation and of the position, as for integrals, and of the cubic's own values and turns.
        let off = place.reach * (2.0 * R::ROUNDOFF * 32.0 + 3.0 * place.misplaced)
            + place.off
            + f64::EPSILON * place.base.abs();
        match self.wanted {
            Wanted::Extreme(sign) => {
                // Inside a cell the field does not reach its extreme samples; at an end it may.
                let reached = |[low, high]: [f64; 2]| (sign * low).max(sign * high);
                let limit = place.limits.map_or(f64::INFINITY, reached);
                let turns = cubic.turns().into_iter().flatten();
                let mut best = None;
                for t in [0.0, 1.0].into_iter().chain(turns) {
                    if self.take(sign * (place.base + cubic.at(t)), off, limit, s + t * length) {
                        best = Some(t);
                    }
                }
                if let Some(t) = best.filter(|_| self.colored) {
                    self.color = looks().tint.at(t);
                }
            }
            Wanted::Average => {
                let mean = cubic.0.iter().sum::<f64>() * 0.25;
                self.integral += (place.base + mean) * length;
                self.off += off * length;
                self.length += length;
                if self.colored {
                    self.add_colors(&looks().tint, length);
                }
            }
        }
    }
}

/// Returns the steepest slope of a pixel's components by the stored number, apart from jumps.
pub(super) fn steepest(transfer: &TransferFunction, calibration: Calibration) -> f64 {
    let slope = |s: &Segment| {
        let change = |c: usize| (s.end.color[c] - s.start.color[c]).abs();
        let opacity = (s.end.opacity - s.start.opacity).abs() * (1.0 + s.start.color.into_iter().fold(0.0, f64::max));
        (opacity + change(0).max(change(1)).max(change(2))) / (s.to - s.from)
    };
    let steepest = transfer.segments().iter().map(slope).filter(|slope| slope.is_finite()).fold(0.0, f64::max);
    steepest * calibration.slope.abs()
}

/// Returns the pixel of a stored number, and the largest difference of one of its components from those of the others in a range.
pub(super) fn pixel(
    transfer: &TransferFunction,
    calibration: Calibration,
    (stored, [low, high]): (f64, [f64; 2]),
) -> ([f64; 4], f64) {
    let pixel = transfer.at(calibration.value(stored)).pixel();
    let ends = [low, high].map(|x| calibration.value(x));
    // A unit in the last place for what the calibration rounds.
    let (low, high) = (ends[0].min(ends[1]).next_down(), ends[0].max(ends[1]).next_up());
    let mut off = 0.0f64;
    let exact = low.next_up() == high.next_down();
    let touched = transfer.segments().iter().filter(|s| s.to >= low && s.from <= high);
    for segment in touched.filter(|_| !exact) {
        // Opacity and colour are linear here: products lie between those of their extremes.
        let [a, b] = [low.max(segment.from), high.min(segment.to)].map(|value| segment.at(value));
        let (min, max) = (a.opacity.min(b.opacity), a.opacity.max(b.opacity));
        off = off.max(pixel[3] - min).max(max - pixel[3]);
        for c in 0..3 {
            let (dark, bright) = (a.color[c].min(b.color[c]), a.color[c].max(b.color[c]));
            off = off.max(pixel[c] - min * dark).max(max * bright - pixel[c]);
        }
    }
    (pixel, off + 8.0 * f64::EPSILON * pixel.into_iter().fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use vr_core::{ControlPoint, OpacityRule};

    use super::*;

    #[test]
    fn pixels_are_off_by_what_their_values_are() {
        let points = vec![
            ControlPoint::new(0.0, [0.2, 0.4, 0.0], 0.0),
            ControlPoint::new(1.0, [0.6, 0.4, 1.0], 0.5),
            ControlPoint::new(1.0, [1.0, 0.0, 0.0], 0.9),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let of = |x: f64, low: f64, high: f64| pixel(&transfer, Calibration::default(), (x, [low, high]));
        let (half, off) = of(0.5, 0.5, 0.5);
        assert_eq!(half, [0.1, 0.1, 0.125, 0.25]);
        assert!(off < 1e-14);
        let (_, off) = of(0.5, 0.48, 0.52);
        assert!((0.01..0.03).contains(&off), "{off}");
        // Across the jump, all of it.
        assert!(of(0.99, 0.98, 1.01).1 > 0.4);
        assert!(of(1.0, 1.0, 1.0).1 < 1e-14, "known to the last bit");
    }
}
