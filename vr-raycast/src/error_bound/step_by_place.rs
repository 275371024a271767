//! Steps through a medium that depends on more than the value: on the gradient, which light and opacity may follow, and on the colours of the places.

use vr_core::Real;

use super::cubic::Cubic;
use super::depth::{Depth, Rate, Transparency};
use super::optics::{Optics, Piece};
use super::reflection::ColorChange;
use super::series::Series;
use super::step::Step;

/// Effects of the place on the medium of a step.
#[derive(Clone, Copy)]
pub(super) struct ByPlace<'a> {
    /// Change of its colours or emissions, and the factor on extinction; `None` where these stay as they are.
    pub(super) change: Option<&'a ColorChange>,
    pub(super) factor: Option<&'a Series>,
}

impl ByPlace<'_> {
    /// Returns the step through a medium of an extinction and of colours or emissions that are known as series. `rounding`: the part of their rests that shorter
    /// steps would not make smaller.
    fn step<R: Real>(
        &self,
        optics: &Optics,
        rate: Rate<R>,
        sources: [Series; 3],
        rounding: f64,
        length: f64,
    ) -> Option<Step> {
        let rate = if let Some(factor) = self.factor { rate.times(factor) } else { rate };
        let depth = Depth::new(optics, rate, length)?;
        let gain = self.change.map_or(1.0, |change| change.factor.iter().map(Series::size).fold(0.0, f64::max));
        self.with_sources(optics, &depth, sources, rounding * gain)
    }

    /// Adds the light of colours or emissions.
    fn with_sources<R: Real>(
        &self,
        optics: &Optics,
        depth: &Depth<R>,
        sources: [Series; 3],
        rounding: f64,
    ) -> Option<Step> {
        let sources = self.change.map_or(sources, |change| std::array::from_fn(|c| change.of(&sources[c], c)));
        if optics.emits {
            return with_emission(depth, &sources, rounding);
        }
        Some(with_light(depth, &sources, rounding))
    }
}

/// Returns the step along a cubic as [`smooth`](super::step::smooth) does, of a medium that depends on the place.
pub(super) fn smooth_by_place<R: Real>(
    optics: &Optics,
    piece: &Piece,
    cubic: &Cubic<R>,
    (base, noise): (f64, f64),
    length: f64,
    by_place: ByPlace<'_>,
) -> Option<Step> {
    let c = cubic.about_middle();
    let rate = Rate::along(optics, piece, &c, base, noise)?;
    let sources = sources(piece, &c, base, noise);
    by_place.step(optics, rate, sources, sources[0].rest, length)
}

/// Returns the step through one stored number, of a medium that depends on the place; `None` where series say nothing.
pub(super) fn constant_by_place(
    optics: &Optics,
    (rate, source): (f64, [f64; 3]),
    length: f64,
    by_place: ByPlace<'_>,
) -> Option<Step> {
    let sources = source.map(Series::constant);
    if by_place.factor.is_none() {
        // However deep it is.
        return by_place.with_sources(optics, &Depth::<f64>::uniform(optics, rate, length), sources, 0.0);
    }
    by_place.step(optics, Rate::<f64>::uniform(rate), sources, 0.0, length)
}

/// A row of a transfer function on a step: the extinction, and colours or emissions; and its share.
struct Part<'a, R> {
    rate: Rate<R>,
    sources: [Series; 3],
    share: &'a Series,
}

/// Returns the step along a cubic that lies in one piece of each row of a transfer function, the shares of which are given. `None` where series say nothing.
pub(super) fn smooth_mixture<R: Real>(
    optics: &Optics,
    shares: &[(usize, Series)],
    cubic: &Cubic<R>,
    (base, noise, value): (f64, f64, f64),
    length: f64,
    change: Option<&ColorChange>,
) -> Option<Step> {
    let c = cubic.about_middle();
    let parts = shares.iter().map(|(row, share)| {
        let piece = optics.rows[*row].piece_at(value);
        let sources = sources(piece, &c, base, noise);
        Some(Part { rate: Rate::along(optics, piece, &c, base, noise)?, sources, share })
    });
    mixture(optics, &parts.collect::<Option<Vec<_>>>()?, length, change)
}

/// Returns the step through one stored number, of the rows of a transfer function that have these shares. `None` where series say nothing.
pub(super) fn constant_mixture(
    optics: &Optics,
    shares: &[(usize, Series)],
    stored: f64,
    length: f64,
    change: Option<&ColorChange>,
) -> Option<Step> {
    let parts = shares.iter().map(|(row, share)| {
        let (rate, source) = optics.rows[*row].exactly(stored);
        Part { rate: Rate::<f64>::uniform(rate), sources: source.map(Series::constant), share }
    });
    mixture(optics, &parts.collect::<Vec<_>>(), length, change)
}

/// Returns the step through a mixture: extinctions and emissions add up, each times its share.
fn mixture<R: Real>(optics: &Optics, parts: &[Part<'_, R>], length: f64, change: Option<&ColorChange>) -> Option<Step> {
    let zero = || (Rate::uniform(0.0), [Series::constant(0.0); 3], 0.0);
    let (rate, emissions, rounding) = parts.iter().fold(zero(), |(sum, mut emissions, rounding), part| {
        let own = part.rate.times(part.share);
        let density = Series { c: own.k.map(R::to_f64), rest: own.tail + own.error + own.rounding };
        let mut unshortened = 0.0f64;
        for (c, sum) in emissions.iter_mut().enumerate() {
            let source = &part.sources[c];
            let color = change.map_or(*source, |change| change.of(source, c));
            let emission = if optics.emits {
                color.product(part.share)
            } else {
                unshortened = unshortened.max((own.error + own.rounding) * color.size() + density.size() * source.rest);
                density.product(&color).times(1.0 / optics.unit)
            };
            *sum = sum.plus(&emission);
        }
        (sum.plus(&own), emissions, rounding + unshortened / optics.unit)
    });
    let mut step = with_emission(&Depth::new(optics, rate, length)?, &emissions, rounding)?;
    // Of a mixture of colours no more is known than that they are colours.
    for part in parts {
        for (c, source) in part.sources.iter().enumerate() {
            let color = change.map_or(*source, |change| change.of(source, c));
            step.variation = step.variation.max(color.size());
        }
    }
    Some(step)
}

/// Returns the colours or emissions of a piece along a cubic by its powers of t.
fn sources<R: Real>(piece: &Piece, c: &[R; 4], base: f64, noise: f64) -> [Series; 3] {
    let source = piece.source_at(base + c[0].to_f64());
    let off = 5.0 * piece.steepest_source * noise;
    std::array::from_fn(|i| {
        let slope = piece.source_slope[i];
        let rising = [1, 2, 3].map(|k| slope * c[k].to_f64());
        Series { c: [source[i], rising[0], rising[1], rising[2]], rest: off }
    })
}

/// Adds light that is emitted, of emissions that are known as series; `None` where the transparency is not.
fn with_emission<R: Real>(depth: &Depth<R>, emissions: &[Series; 3], rounding: f64) -> Option<Step> {
    let u = 2.0 * R::ROUNDOFF;
    let inside = Transparency::inside(depth)?;
    let [p1, p2, p3] = inside.p.map(R::to_f64);
    let first = inside.first.to_f64();
    // Means of P times 1, t, t² and t³ over the step.
    let weights = [1.0 + p2 / 3.0, p1 / 3.0 + p3 / 5.0, 1.0 / 3.0 + p2 / 5.0, p1 / 5.0 + p3 / 7.0];
    let mut step = depth.step;
    let length = step.length;
    step.light = emissions.map(|emission| {
        let mean = (0..4).map(|k| emission.c[k] * weights[k]).sum::<f64>();
        (length * first * mean).max(0.0)
    });
    let missed = inside.missed + inside.scaled + 8.0 * u;
    let off = |emission: &Series| length * (emission.size() * missed + emission.rest);
    step.light_error = emissions.iter().map(off).fold(0.0, f64::max);
    step.variation = 2.0 * emissions.iter().map(Series::spread).fold(0.0, f64::max);
    step.rounding[1] = rounding * length;
    Some(step)
}

/// Adds the light of a density emitter whose colours are known as series. `rounding`: the part of their rests that shorter steps would not make smaller.
fn with_light<R: Real>(depth: &Depth<R>, colors: &[Series; 3], rounding: f64) -> Step {
    let u = 2.0 * R::ROUNDOFF;
    let mut step = depth.step;
    step.variation = 2.0 * colors.iter().map(Series::spread).fold(0.0, f64::max);
    step.rounding[1] = rounding * step.opacity;
    let known = |color: &Series| color.rest + 4.0 * u * color.size();
    // The colours in the middle stand for all of them, unless their changes can be weighed.
    let plain = |mut step: Step| {
        step.light = colors.map(|color| (color.c[0] * step.opacity).max(0.0));
        let off = |color: &Series| color.spread() - color.rest + known(color);
        step.light_error = colors.iter().map(off).fold(0.0, f64::max) * step.opacity;
        step
    };
    let crude = plain(step);
    let Some(inside) = Transparency::inside(depth) else { return crude };
    let (g, left_out) = inside.absorbed(depth);
    let g = g.map(|g| (inside.first * g).to_f64() * depth.per_rate);
    // Means of κ·P times t, t² and t³ over the step.
    let weights = [g[1] / 3.0 + g[3] / 5.0, g[0] / 3.0 + g[2] / 5.0, g[1] / 5.0 + g[3] / 7.0];
    let missed = depth.per_rate * (0.5 * left_out + 8.0 * u * depth.rate.size());
    step.light = colors.map(|color| {
        let changes = (1..4).map(|k| color.c[k] * weights[k - 1]).sum::<f64>();
        (color.c[0] * step.opacity + changes).max(0.0)
    });
    let off = |color: &Series| (color.spread() - color.rest) * missed + known(color) * step.opacity;
    step.light_error = colors.iter().map(off).fold(0.0, f64::max);
    if step.light_error < crude.light_error { step } else { crude }
}
