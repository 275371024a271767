//! Division of a cubic along a piece of the ray into steps: as long as the error allows, cut where the transfer function has a knot.

use vr_core::Real;

use super::account::{Account, PendingWall};
use super::blocks::{Blocks, State};
use super::cubic::Cubic;
use super::looks::Looks;
use super::modulation::{Factor, Modulation};
use super::optics::{Extremes, Optics, Piece};
use super::reflection::{ColorChange, RayReflection};
use super::series::Series;
use super::step::{Step, coarse, constant, smooth};
use super::step_by_place::{ByPlace, constant_by_place, constant_mixture, smooth_by_place, smooth_mixture};
use super::walk::{Course, Jump};
use crate::root::monotone_root;

/// Largest number of halvings of a cell, after which a step is taken as it is.
const MAX_HALVINGS: u32 = 44;
/// Largest depth per unit distance that what is misplaced counts with: α = 1 − e^(−80).
const MAX_DEPTH: f64 = 80.0;
/// Number of steps of a ray after which all are taken as they are: no scene may hang the renderer.
const MAX_STEPS: u64 = 1 << 16;
/// Number of steps after which a ray is better done again in higher precision.
const MAX_STEPS_FIRST: u64 = 1 << 13;

/// Ray that is being integrated.
pub(super) struct Integral<'a> {
    pub(super) optics: &'a Optics,
    /// `None` where colours stay as they are.
    pub(super) reflection: Option<RayReflection<'a>>,
    /// `None` where extinction stays as it is.
    modulation: Option<&'a Modulation>,
    /// Gradient and colours where nothing is known of them.
    unknown: Looks,
    pub(super) account: Account,
    /// True if it stops once the proven bound is above the one asked for: another instance will do the ray again.
    pub(super) gives_up: bool,
}

/// Cell that a ray crosses: the range of its voxels, and the error of positions in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Sample at the first corner, from which the cubic is counted.
    pub(super) base: f64,
    /// Largest difference between a sample and `base`.
    pub(super) reach: f64,
    /// Smallest and largest sample, which the field does not reach inside the cell; `None` if the ray may lie in a face.
    pub(super) limits: Option<[f64; 2]>,
    /// Upper bound of the error of a position, as a fraction of the cell.
    pub(super) misplaced: f64,
    /// Upper bound of how far the field is from the cubic.
    pub(super) off: f64,
}

/// Field along a cell: the part that does not change while the cell is cut.
struct Cell<R> {
    place: Place,
    whole: Cubic<R>,
    looks: Looks,
    length: f64,
}

/// Medium of one stored number.
#[derive(Clone, Copy)]
struct Uniform {
    stored: f64,
    rate: f64,
    source: [f64; 3],
}

/// Part of a cell.
#[derive(Clone, Copy)]
struct Part<R> {
    cubic: Cubic<R>,
    /// Ends, as fractions of the cell.
    ends: [f64; 2],
    /// Distance at which it begins.
    s: f64,
    length: f64,
    cuts: u32,
}

impl<'a> Integral<'a> {
    pub(super) fn new(
        optics: &'a Optics,
        (reflection, modulation, unknown): (Option<RayReflection<'a>>, Option<&'a Modulation>, Looks),
        account: Account,
        gives_up: bool,
    ) -> Self {
        Self { optics, reflection, modulation, unknown, account, gives_up }
    }

    /// True if the bound asked for is kept.
    pub(super) fn is_kept(&self) -> bool {
        let too_long = self.gives_up && self.account.steps > MAX_STEPS_FIRST;
        !(too_long || self.account.is_over())
    }

    /// Integrates a part, from one fraction of a cell to another, of one extinction and colour, which depend on the place.
    fn uniform_part(&mut self, mut medium: Uniform, looks: &Looks, (ends, s, length): ([f64; 2], f64, f64), cuts: u32) {
        if self.is_done() || length <= 0.0 {
            return;
        }
        let factor = self.factor(looks, ends);
        if factor.is_some_and(|factor| factor.is_nothing()) {
            if !(self.optics.emits && medium.source != [0.0; 3]) {
                return;
            }
            // Not even a wall.
            medium.rate = 0.0;
        }
        let Uniform { stored, rate, source } = medium;
        let enough = self.is_enough(cuts);
        if rate < f64::INFINITY {
            let change = self.change(looks, ends);
            let step = if let Some(shares) = self.shares(looks, ends) {
                constant_mixture(self.optics, &shares, stored, length, change.as_ref())
            } else {
                let factor = factor.as_ref().map(|factor| &factor.series);
                let by_place = ByPlace { change: change.as_ref(), factor };
                constant_by_place(self.optics, (rate, source), length, by_place)
            };
            let step = step.unwrap_or_else(|| self.coarse_uniform(&medium, looks, (ends, length)));
            if self.account.fits(&step, s) || enough {
                self.account.take(&step, s);
                return;
            }
        } else if factor.is_none_or(|factor| factor.is_something()) {
            let light = if self.optics.emits { [0.0; 3] } else { source };
            return self.wall(light, 0.0, 0.0, (looks, ends[0]), s);
        } else if enough || looks.normals.is_blurred(ends) {
            let step = self.coarse_uniform(&medium, looks, (ends, length));
            let before = if self.optics.emits { step.light.into_iter().fold(0.0, f64::max) } else { 0.0 };
            return self.account.doubt(PendingWall { step, before, spread: 0.0, turn: self.turn(looks, ends) });
        }
        let (half, middle) = (0.5 * length, 0.5 * (ends[0] + ends[1]));
        self.uniform_part(medium, looks, ([ends[0], middle], s, half), cuts + 1);
        self.uniform_part(medium, looks, ([middle, ends[1]], s + half, half), cuts + 1);
    }

    /// Returns the step over all that the medium of one stored number may be on a part of a cell.
    fn coarse_uniform(&self, medium: &Uniform, looks: &Looks, (ends, length): ([f64; 2], f64)) -> Step {
        let &Uniform { stored, rate, source } = medium;
        let is_wall = rate == f64::INFINITY;
        let before_wall = if is_wall { 0.0 } else { rate };
        let own = Extremes { rate: [rate; 2], before_wall, source: source.map(|x| [x; 2]), wall: is_wall };
        let extremes = if self.optics.rows.is_empty() { own } else { self.optics.extremes(stored, stored) };
        coarse(self.optics, &self.by_place(&extremes, looks, ends), length, f64::INFINITY)
    }

    /// Returns the factor on extinction on a part of a cell; `None` where it stays as it is.
    fn factor(&self, looks: &Looks, ends: [f64; 2]) -> Option<Factor> {
        self.modulation.and_then(|modulation| modulation.on(&looks.normals, ends))
    }

    /// Returns the shares of the transfer function's rows on a part of a cell; `None` where it has none.
    fn shares(&self, looks: &Looks, ends: [f64; 2]) -> Option<Vec<(usize, Series)>> {
        self.modulation.and_then(|modulation| modulation.shares(&looks.normals, ends))
    }

    /// Returns the change of colours on a part of a cell; `None` where they stay.
    fn change(&self, looks: &Looks, ends: [f64; 2]) -> Option<ColorChange> {
        looks.change(self.reflection.as_ref(), ends)
    }

    /// Ends the ray at a wall, at a fraction of a cell: its colour, the error of that, and how fast it changes with the value.
    fn wall(&mut self, source: [f64; 3], error: f64, steepness: f64, (looks, at): (&Looks, f64), s: f64) {
        let Some(change) = self.change(looks, [at; 2]) else {
            return self.account.wall(source, error, steepness, s);
        };
        let colors =
            std::array::from_fn::<_, 3, _>(|c| change.of(&Series { rest: error, ..Series::constant(source[c]) }, c));
        let largest = change.factor.iter().map(Series::size).fold(0.0, f64::max);
        let off = colors.iter().map(Series::spread).fold(0.0, f64::max);
        self.account.wall(colors.map(|color| color.c[0].max(0.0)), off, steepness * largest, s);
    }

    /// Takes a step over all values of a range if that is good enough; returns true if so.
    fn coarse(&mut self, extremes: &Extremes, s: f64, length: f64) -> bool {
        if extremes.wall {
            return false;
        }
        let extremes = &self.by_place(extremes, &self.unknown, [0.0, 1.0]);
        let step = coarse(self.optics, extremes, length, f64::INFINITY);
        let fits = self.account.fits(&step, s);
        if fits {
            self.account.take(&step, s);
        }
        fits
    }

    /// Returns extremes of a medium that depends on the place, on a part of a cell.
    fn by_place(&self, extremes: &Extremes, looks: &Looks, ends: [f64; 2]) -> Extremes {
        let mut all = *extremes;
        if let Some(change) = self.change(looks, ends) {
            for (c, [low, high]) in all.source.iter_mut().enumerate() {
                let [[f0, f1], [a0, a1]] = [&change.factor[c], &change.added[c]].map(Series::range);
                (*low, *high) = (*low * f0.max(0.0) + a0.max(0.0), *high * f1 + a1);
            }
        }
        if let Some(Factor { range: [f0, f1], .. }) = self.factor(looks, ends) {
            // Nothing is left of a wall times 0.
            let times = |x: f64, factor: f64| if factor <= 0.0 { 0.0 } else { x * factor };
            all.rate = [times(all.rate[0], f0), times(all.rate[1], f1)];
            all.before_wall = times(all.before_wall, f1);
            all.wall &= f1 > 0.0;
        }
        all
    }

    /// Returns the largest difference that the change of colours makes between two places of a part of a cell.
    fn turn(&self, looks: &Looks, ends: [f64; 2]) -> f64 {
        self.change(looks, ends).map_or(0.0, |change| {
            let width = |c: usize| 2.0 * (change.factor[c].spread() * self.optics.brightest + change.added[c].spread());
            width(0).max(width(1)).max(width(2))
        })
    }

    fn part<R: Real>(&mut self, cell: &Cell<R>, part: Part<R>) {
        if self.is_done() || part.length <= 0.0 {
            return;
        }
        let noise = self.noise(cell, part.cuts);
        // Bound the values of the part; nothing is to be done where all of them are clear.
        let (low, high) = part.cubic.hull();
        let (low, high) = (cell.place.base + low, cell.place.base + high);
        let [min, max] = self.possible(&cell.place, [low, high], noise);
        if self.optics.is_clear(min, max) {
            return;
        }
        let factor = self.factor(&cell.looks, part.ends);
        let nothing = factor.is_some_and(|factor| factor.is_nothing());
        if nothing && !self.optics.emits {
            return;
        }
        let optics = self.optics;
        let piece = optics.piece_at((0.5 * (low + high)).max(min).min(max));
        let single = piece.holds(low, high, noise) || piece.holds(min, max, 0.0);
        let maybe = factor.is_some_and(|factor| !factor.is_something()) && !nothing;
        // A wall ends the ray.
        if single && piece.opaque && !maybe && !nothing {
            let entry = cell.place.base + part.cubic.0[0].to_f64();
            let light = if optics.emits { [0.0; 3] } else { piece.source_at(entry) };
            let steepness = if optics.emits { 0.0 } else { piece.source_steepness() };
            self.wall(light, steepness * 5.0 * noise, steepness, (&cell.looks, part.ends[0]), part.s);
            return;
        }
        // Take the part as one step if its error is small enough, or shorter steps would not help.
        if single
            && !piece.opaque
            && let Some(step) = self.smooth(piece, cell, &part, (noise, factor.as_ref()))
        {
            let account = &self.account;
            if account.fits(&step, part.s) || account.is_rounding(&step, part.s) || self.is_enough(part.cuts) {
                self.account.take(&step, part.s);
                return;
            }
        } else {
            let extremes = self.by_place(&optics.extremes(min, max), &cell.looks, part.ends);
            let step = self.coarse_part(&extremes, cell, &part, noise);
            // Shorter parts would hold the same values, for all that is known.
            let Looks { normals, tint } = &cell.looks;
            let blurred = high - low <= 4.0 * noise
                && tint.is_blurred(part.ends)
                && (!(maybe && extremes.wall) || normals.is_blurred(part.ends));
            if (!extremes.wall && self.account.fits(&step, part.s)) || blurred || self.is_enough(part.cuts) {
                self.take_anyway(&extremes, step, cell, &part, noise);
                return;
            }
            if !single && part.cubic.is_monotone() && self.cut(cell, &part, noise) {
                return;
            }
        }
        // Else halve it.
        let (front, back) = part.cubic.split(R::from_f64(0.5));
        let (half, cuts) = (0.5 * part.length, part.cuts + 1);
        let middle = 0.5 * (part.ends[0] + part.ends[1]);
        self.part(cell, Part { cubic: front, ends: [part.ends[0], middle], length: half, cuts, ..part });
        self.part(cell, Part { cubic: back, ends: [middle, part.ends[1]], s: part.s + half, length: half, cuts });
    }

    /// Returns the range of the values that a part may hold if its computed range, off by up to `noise`, is `low` to `high`.
    fn possible(&self, place: &Place, [low, high]: [f64; 2], noise: f64) -> [f64; 2] {
        let range = [low - noise, high + noise];
        let Some([min, max]) = place.limits.filter(|_| self.optics.knots_are_exact) else { return range };
        let inside = [range[0].max(min.next_up()), range[1].min(max.next_down())];
        if inside[0] <= inside[1] { inside } else { range }
    }

    /// Returns the error of values: the corners' differences, three rounds of interpolation and what each cut adds, all of numbers up to
    /// `reach`; the place; and the knots that they are compared with.
    fn noise<R: Real>(&self, cell: &Cell<R>, cuts: u32) -> f64 {
        let u = 2.0 * R::ROUNDOFF;
        let Place { reach, misplaced, off, .. } = cell.place;
        reach * (u * (16.0 + 4.0 * f64::from(cuts)) + 3.0 * misplaced) + off + self.optics.knot_error
    }

    fn smooth<R: Real>(
        &self,
        piece: &Piece,
        cell: &Cell<R>,
        part: &Part<R>,
        (noise, factor): (f64, Option<&Factor>),
    ) -> Option<Step> {
        let change = self.change(&cell.looks, part.ends);
        if let Some(shares) = self.shares(&cell.looks, part.ends) {
            // All rows have the same pieces.
            let values = (cell.place.base, noise, piece.inside());
            return smooth_mixture(self.optics, &shares, &part.cubic, values, part.length, change.as_ref());
        }
        if change.is_some() || factor.is_some() {
            let by_place = ByPlace { change: change.as_ref(), factor: factor.map(|f| &f.series) };
            let values = (cell.place.base, noise);
            return smooth_by_place(self.optics, piece, &part.cubic, values, part.length, by_place);
        }
        let enough = self.account.enough(part.s + part.length);
        smooth(self.optics, piece, &part.cubic, cell.place.base, noise, part.length, enough)
    }

    fn coarse_part<R: Real>(&self, extremes: &Extremes, cell: &Cell<R>, part: &Part<R>, noise: f64) -> Step {
        let deepest = if extremes.wall { f64::INFINITY } else { self.deepest(extremes, cell, part, noise) };
        coarse(self.optics, extremes, part.length, deepest)
    }

    /// Returns a bound of the optical depth of a part, without walls.
    fn deepest<R: Real>(&self, extremes: &Extremes, cell: &Cell<R>, part: &Part<R>, noise: f64) -> f64 {
        if extremes.before_wall.is_finite() {
            return extremes.before_wall * part.length / self.optics.unit;
        }
        let factor = self.factor(&cell.looks, part.ends).map_or(1.0, |factor| factor.range[1]);
        let (low, high) = part.cubic.hull();
        let farthest = |v: f64| {
            let at = |t: f64| (cell.place.base + cell.whole.at(R::from_f64(t)).to_f64() - v).abs() - noise;
            [0.0, 0.25, 0.5, 0.75, 1.0].map(at).into_iter().fold(0.0, f64::max)
        };
        let (low, high) = (cell.place.base + low - noise, cell.place.base + high + noise);
        factor * self.optics.depth_at_touch(low, high, farthest, part.length, cell.length)
    }

    /// True if a part must not be cut any more, whatever its error.
    fn is_enough(&self, cuts: u32) -> bool {
        cuts >= MAX_HALVINGS || self.account.steps >= MAX_STEPS
    }

    fn take_anyway<R: Real>(&mut self, extremes: &Extremes, step: Step, cell: &Cell<R>, part: &Part<R>, noise: f64) {
        if !extremes.wall {
            self.account.take(&step, part.s);
            return;
        }
        let (low, high) = part.cubic.hull();
        let before = if self.optics.emits {
            part.length * extremes.source.iter().map(|s| s[1]).fold(0.0, f64::max)
        } else {
            -libm::expm1(-self.deepest(extremes, cell, part, noise)) * extremes.source_width()
        };
        let spread = high - low + 2.0 * noise;
        // The wall's place decides what it reflects, too.
        let turn = self.turn(&cell.looks, part.ends);
        self.account.doubt(PendingWall { step, before, spread, turn });
    }

    /// Cuts a monotone part where it crosses a knot; returns false where that place is too uncertain.
    ///
    /// The crossing is known up to a short part, which is taken with all that the medium can be in it. Before and behind it, the
    /// Bernstein coefficients themselves prove on which side of the knot the field is.
    fn cut<R: Real>(&mut self, cell: &Cell<R>, part: &Part<R>, noise: f64) -> bool {
        let [first, .., last] = part.cubic.0;
        let (first, last) = (first.to_f64(), last.to_f64());
        let rising = last > first;
        let Some(knot) = self.optics.knot_between(cell.place.base + first.min(last), cell.place.base + first.max(last))
        else {
            return false;
        };
        let knot = knot - cell.place.base;
        let at = |t: R| (part.cubic.at(t) - R::from_f64(knot), part.cubic.slope(t));
        let t = monotone_root([R::ZERO, R::ONE], rising, at);
        let steepness = part.cubic.slope(t).abs().to_f64();
        let mut apart = (3.0 * noise / steepness).max(4.0 * R::ROUNDOFF);
        for _ in 0..3 {
            if apart.is_nan() || apart > 0.125 {
                return false;
            }
            let [t0, t1] = [(t.to_f64() - apart).max(0.0), (t.to_f64() + apart).min(1.0)].map(R::from_f64);
            let (front, _) = part.cubic.split(t0);
            let (rest, back) = part.cubic.split(t1);
            let beyond = |x: R| if rising { x.to_f64() - knot } else { knot - x.to_f64() };
            let noise = self.noise(cell, part.cuts + 1);
            // A little more, so that the same comparison with the piece's end holds after rounding, too.
            let clear = 1.01 * noise;
            let before = t0 == R::ZERO || beyond(front.0[3]) <= -clear;
            let behind = t1 == R::ONE || beyond(back.0[0]) >= clear;
            if before && behind {
                let (d0, d1) = (t0.to_f64() * part.length, t1.to_f64() * part.length);
                let cuts = part.cuts + 1;
                let [start, end] = part.ends;
                let [e0, e1] = [t0, t1].map(|t| start + t.to_f64() * (end - start));
                self.part(cell, Part { cubic: front, ends: [start, e0], length: d0, cuts, ..*part });
                let middle = if t1 == R::ZERO { rest } else { rest.split(t0 / t1).1 };
                let length = d1 - d0;
                self.across(cell, Part { cubic: middle, ends: [e0, e1], s: part.s + d0, length, cuts: cuts + 1 });
                let length = part.length - d1;
                self.part(cell, Part { cubic: back, ends: [e1, end], s: part.s + d1, length, cuts });
                return true;
            }
            apart *= 4.0;
        }
        false
    }

    /// Integrates the short part across a knot.
    fn across<R: Real>(&mut self, cell: &Cell<R>, part: Part<R>) {
        if self.is_done() || part.length <= 0.0 {
            return;
        }
        let noise = self.noise(cell, part.cuts);
        let (low, high) = part.cubic.hull();
        let [min, max] = self.possible(&cell.place, [cell.place.base + low, cell.place.base + high], noise);
        let extremes = self.by_place(&self.optics.extremes(min, max), &cell.looks, part.ends);
        let step = self.coarse_part(&extremes, cell, &part, noise);
        self.take_anyway(&extremes, step, cell, &part, noise);
    }
}

impl Course for Integral<'_> {
    fn is_done(&self) -> bool {
        self.account.ended || (self.gives_up && !self.is_kept())
    }

    fn passes_block(&mut self, blocks: &Blocks, index: usize, s: f64, length: f64) -> bool {
        let state = blocks.state(index);
        state == State::Clear || state == State::Filled && self.coarse(&blocks.extremes(index, self.optics), s, length)
    }

    fn passes_values(&self, [low, high]: [f64; 2]) -> bool {
        // Knots may lie a little off: the cut will look at that.
        let room = self.optics.knot_error;
        self.optics.is_clear(low - room, high + room)
    }

    fn resolution(&self, [low, high]: [f64; 2]) -> f64 {
        let largest = self.modulation.map_or(1.0, |modulation| modulation.largest());
        let [rate, source] = self.optics.sensitivity(low, high);
        self.account.resolution([rate * largest / self.optics.unit, source])
    }

    fn jump(&mut self, jump: &Jump) {
        let [mut rate, mut emitted, mut wall] = [0.0, 0.0, 0.0f64];
        for (side, &[low, high]) in jump.sides.iter().enumerate().filter_map(|(i, side)| Some((i, side.as_ref()?))) {
            let extremes = self.by_place(&self.optics.extremes(low, high), &self.unknown, [0.0, 1.0]);
            rate += extremes.before_wall.min(MAX_DEPTH);
            if self.optics.emits {
                emitted += extremes.source.iter().map(|s| s[1]).fold(0.0, f64::max);
            }
            // So thin a wall need not exist.
            wall = wall.max(f64::from(u8::from(side == 1 && jump.short && extremes.wall)));
        }
        let opacity = -libm::expm1(-rate * jump.misplaced / self.optics.unit) + wall;
        self.account.misplace(opacity, emitted * jump.misplaced);
    }

    fn constant(&mut self, stored: f64, looks: impl FnOnce() -> Looks, s: f64, length: f64) {
        let (rate, source) = self.optics.exactly(stored);
        if rate == 0.0 && !(self.optics.emits && source != [0.0; 3]) {
            return;
        }
        let looks = looks();
        if rate < f64::INFINITY && self.modulation.is_none() && looks.is_plain() {
            let step = constant(self.optics, rate, source, length);
            if self.account.cut(&step) == 0.0 {
                self.account.take(&step, s);
                return;
            }
        }
        self.uniform_part(Uniform { stored, rate, source }, &looks, ([0.0, 1.0], s, length), 0);
    }

    fn cell<R: Real>(&mut self, cubic: Cubic<R>, place: Place, looks: impl FnOnce() -> Looks, s: f64, length: f64) {
        let cell = Cell { place, whole: cubic, looks: looks(), length };
        self.part(&cell, Part { cubic, ends: [0.0, 1.0], s, length, cuts: 0 });
    }
}
