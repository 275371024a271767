//! Step of a ray, with a bound of its error.
//!
//! A step takes the radiance B behind it to light + (1 − A)·B. What it is off by is told as two numbers that do not depend on B:
//! `opacity_error` bounds |Â − A|, and `light_error` bounds what is wrong with the light *apart* from that, so that the whole error is
//! at most light_error + opacity_error·M for any B in [0, M], where M also bounds the source of a density emitter. (For those the
//! light is source·A: an opacity too large adds source·δ and takes B·δ away, and both are at most M.)

use vr_core::optics::source_weight;
use vr_core::{OpacityRule, Real};

use super::cubic::Cubic;
use super::optics::{Extremes, Optics, Piece};
use super::reflection::ColorChange;
use super::series::Series;

/// Step of a ray, with bounds of its errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Step {
    /// World length.
    pub(super) length: f64,
    /// Opacity 1 − e^(−τ).
    pub(super) opacity: f64,
    /// Light at its front.
    pub(super) light: [f64; 3],
    /// Bound on the error of `opacity`.
    pub(super) opacity_error: f64,
    /// Bound on the error of `light` that is not the opacity's.
    pub(super) light_error: f64,
    /// Largest difference between two sources in the step: the cost per opacity of a cut inside it.
    pub(super) variation: f64,
    /// Sum of the parts of the two errors that shorter steps would not make smaller: rounding.
    pub(super) rounding: [f64; 2],
}

impl Step {
    /// Returns the largest component of the light.
    pub(super) fn brightest(&self) -> f64 {
        self.light.into_iter().fold(0.0, f64::max)
    }
}

/// Rounding of one step in f64: a few operations.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Returns 1 − e^(−τ) for any τ up to +∞.
fn opacity(tau: f64) -> f64 {
    -libm::expm1(-tau)
}

/// Returns the step through a medium of which only the extremes are known: the middle, and half the width. `deepest` bounds its optical depth
/// where the extremes do not.
pub(super) fn coarse(optics: &Optics, extremes: &Extremes, length: f64, deepest: f64) -> Step {
    let per_rate = length / optics.unit;
    let depth = [per_rate * extremes.rate[0], (per_rate * extremes.rate[1]).min(deepest)];
    // 0 · ∞: a point of an opaque medium.
    let depth = depth.map(|d| if d.is_nan() { 0.0 } else { d });
    let [min_opacity, max_opacity] = depth.map(opacity);
    let middle = 0.5 * (min_opacity + max_opacity);
    let opacity_error = 0.5 * (max_opacity - min_opacity) + ROUNDING * max_opacity;
    let (mut light, mut light_error) = ([0.0; 3], 0.0f64);
    for (light, [low, high]) in light.iter_mut().zip(extremes.source) {
        if optics.emits {
            let range = [low * length * source_weight(depth[1]), high * length * source_weight(depth[0])];
            *light = 0.5 * (range[0] + range[1]);
            light_error = light_error.max(0.5 * (range[1] - range[0]) + ROUNDING * range[1]);
        } else {
            *light = 0.5 * (low + high) * middle;
            light_error = light_error.max((0.5 * (high - low) + ROUNDING * high) * max_opacity);
        }
    }
    let variation = extremes.source_width();
    Step { length, opacity: middle, light, opacity_error, light_error, variation, rounding: [0.0; 2] }
}

/// Returns the step through one stored number.
pub(super) fn constant(optics: &Optics, rate: f64, source: [f64; 3], length: f64) -> Step {
    let depth = rate * length / optics.unit;
    let a = opacity(depth);
    let factor = if optics.emits { length * source_weight(depth) } else { a };
    let light = source.map(|s| s * factor);
    let brightest = light.into_iter().fold(0.0, f64::max);
    Step {
        length,
        opacity: a,
        light,
        opacity_error: ROUNDING * a,
        light_error: ROUNDING * brightest,
        ..Step::default()
    }
}

/// Extinction along a cubic that lies in one piece of the transfer function, by power series about its middle: κ · unit is k₀ + k₁t + k₂t² + k₃t³ + …, with
/// t ∈ [−1, 1] over the step.
struct Rate<R> {
    k: [R; 4],
    /// Bound of the terms that follow.
    tail: f64,
    /// Its mean, which is known better than by these terms, and a bound of what that is off by.
    mean: R,
    mean_error: f64,
    /// Bound of what κ · unit is off by for being computed from a field that is, and by rounding.
    error: f64,
    rounding: f64,
}

impl<R: Real> Rate<R> {
    /// `c`: the cubic by powers of t. `None` where the series does not converge well enough to say anything.
    #[inline]
    fn along(optics: &Optics, piece: &Piece, c: &[R; 4], base: f64, noise: f64) -> Option<Self> {
        let real = R::from_f64;
        let u = 2.0 * R::ROUNDOFF;
        let middle = base + c[0].to_f64();
        let (alpha, clearness) = (piece.opacity_at(middle), piece.clearness_at(middle));
        let power = optics.rule == OpacityRule::Power;

        // κ·unit = k₀ − ln(1 − x) or k₀ + x, x = x₁t + x₂t² + x₃t³, |x| ≤ ρ|t|.
        let scale = if power { real(piece.opacity_slope / clearness) } else { real(piece.opacity_slope) };
        let (x1, x2, x3) = (c[1] * scale, c[2] * scale, c[3] * scale);
        let (s1, s2, s3) = (x1.abs().to_f64(), x2.abs().to_f64(), x3.abs().to_f64());
        let rho = s1 + s2 + s3;
        let off = 5.0 * piece.steepest_opacity * noise;
        let (k, mean, mean_error, tail, error);
        if power {
            if !(rho <= 0.9 && 2.0 * off <= clearness * (1.0 - rho)) {
                return None;
            }
            let k0 = if alpha < 0.5 { -real(-alpha).ln_1p() } else { real(-libm::log(clearness)) };
            let k2 = x2 + real(0.5) * x1 * x1;
            k = [k0, x1, k2, x3 + x1 * x2 + x1 * x1 * x1 * real(1.0 / 3.0)];
            let square =
                x1 * x1 * real(1.0 / 3.0) + (x2 * x2 + real(2.0) * x1 * x3) * real(0.2) + x3 * x3 * real(1.0 / 7.0);
            let cube = real(0.6) * x1 * x1 * x2
                + (x2 * x2 * x2 + real(6.0) * x1 * x2 * x3) * real(1.0 / 7.0)
                + x2 * x3 * x3 * real(1.0 / 3.0);
            let fourth = x1 * x1 * x1 * x1 * real(0.05);
            mean = k0 + x2 * real(1.0 / 3.0) + real(0.5) * square + real(1.0 / 3.0) * cube + fourth;
            let rest = s2 + s3;
            let (r2, r4) = (rho * rho, rho * rho * rho * rho);
            mean_error = rest * (rho + s1) * (r2 + s1 * s1) / 24.0 + rest * r4 / 7.0 + r4 * r2 / (42.0 * (1.0 - rho));
            tail = 0.5 * (s2 * s2 + s3 * s3)
                + s3 * (s1 + s2)
                + rest * (r2 + rho * s1 + s1 * s1) / 3.0
                + r4 / (4.0 * (1.0 - rho));
            error = off / (clearness * (1.0 - rho) - off);
        } else {
            let k0 = real(alpha);
            k = [k0, x1, x2, x3];
            mean = k0 + x2 * real(1.0 / 3.0);
            (mean_error, tail, error) = (0.0, 0.0, off);
        }
        let rounding = 8.0 * u * (k[0].abs().to_f64() + 4.0 * rho);
        Some(Self { k, tail, mean, mean_error, error, rounding })
    }

    /// Returns that of one stored number.
    fn uniform(rate: f64) -> Self {
        let k = [R::from_f64(rate), R::ZERO, R::ZERO, R::ZERO];
        let error = 2.0 * R::ROUNDOFF * rate;
        Self { k, tail: 0.0, mean: k[0], mean_error: 0.0, error, rounding: 0.0 }
    }

    /// Returns a bound of |k₀| + |k₁| + |k₂| + |k₃|.
    fn size(&self) -> f64 {
        let [k0, k1, k2, k3] = self.k.map(|k| k.abs().to_f64());
        k0 + k1 + k2 + k3
    }

    /// Returns the sum of two extinctions.
    fn plus(&self, other: &Self) -> Self {
        Self {
            k: std::array::from_fn(|i| self.k[i] + other.k[i]),
            tail: self.tail + other.tail,
            mean: self.mean + other.mean,
            mean_error: self.mean_error + other.mean_error,
            error: self.error + other.error,
            rounding: self.rounding + other.rounding + 4.0 * R::ROUNDOFF * (self.size() + other.size()),
        }
    }

    /// Returns the extinction times a factor.
    fn times(&self, factor: &Series) -> Self {
        let k = self.k.map(R::to_f64);
        let (size, gain) = (self.size(), factor.size());
        let of = |series: &Series| (series.c.map(R::from_f64), series.rest);
        let own = Series { c: k, rest: self.tail };
        let (product, tail) = of(&own.product(factor));
        // The mean of κ is known better than its series: only what the factor changes by goes by that.
        let [m0, m1, m2, m3] = factor.c;
        let mean = m0 * self.mean.to_f64()
            + m1 * (k[1] / 3.0 + k[3] / 5.0)
            + m2 * (k[0] / 3.0 + k[2] / 5.0)
            + m3 * (k[1] / 5.0 + k[3] / 7.0);
        let changes = m1.abs() + m2.abs() + m3.abs();
        let mean_error = m0.abs() * self.mean_error + changes * self.tail + factor.rest * (size + self.tail);
        let rounding = (self.rounding + 16.0 * R::ROUNDOFF * size) * gain;
        Self { k: product, tail, mean: R::from_f64(mean), mean_error, error: self.error * gain, rounding }
    }
}

/// Optical depth of a step along which the extinction is known.
struct Depth<R> {
    rate: Rate<R>,
    /// Optical depth per value of κ · unit.
    per_rate: f64,
    /// The step, as yet without light.
    step: Step,
}

impl<R: Real> Depth<R> {
    /// `None` where the series says nothing.
    #[inline]
    fn new(optics: &Optics, rate: Rate<R>, length: f64) -> Option<Self> {
        let u = 2.0 * R::ROUNDOFF;
        let per_rate = length / optics.unit;
        let tau = (R::from_f64(per_rate) * rate.mean).max(R::ZERO);
        let tau_rounding = per_rate * (rate.error + rate.rounding) + 2.0 * u * tau.to_f64();
        let tau_error = per_rate * rate.mean_error + tau_rounding;
        if tau_error >= 1.0 || tau_error.is_nan() {
            return None;
        }
        let a = tau_opacity(tau);
        let transmittance = 1.0 - a.to_f64();
        let step = Step {
            length,
            opacity: a.to_f64(),
            // e^x − 1 ≤ x + x² for x ≤ 1.
            opacity_error: transmittance * (tau_error + tau_error * tau_error) + 2.0 * u * a.to_f64(),
            rounding: [transmittance * tau_rounding, 0.0],
            ..Step::default()
        };
        Some(Self { rate, per_rate, step })
    }

    /// Returns the depth of a step through one stored number.
    fn uniform(optics: &Optics, rate: f64, length: f64) -> Self {
        let per_rate = length / optics.unit;
        let a = opacity(rate * per_rate);
        let step = Step { length, opacity: a, opacity_error: ROUNDING * a, ..Step::default() };
        Self { rate: Rate::uniform(rate), per_rate, step }
    }
}

/// Transparency inside a step: P/P₀ = e^(−y) = 1 + p₁t + p₂t² + p₃t³ + …, with P = 1 at the front.
struct Transparency<R> {
    p: [R; 3],
    /// 1/P₀ at the front.
    first: R,
    /// Bound of what the series misses, and of what P₀ is off by relative to itself.
    missed: f64,
    scaled: f64,
    growth: f64,
}

impl<R: Real> Transparency<R> {
    /// `None` where the series does not converge well enough.
    #[inline]
    fn inside(depth: &Depth<R>) -> Option<Self> {
        let real = R::from_f64;
        let u = 2.0 * R::ROUNDOFF;
        let Rate { k: [k0, k1, k2, k3], tail, error, .. } = depth.rate;
        // y = y₁t + y₂t² + y₃t³ + ….
        let y1 = real(0.5 * depth.per_rate) * k0;
        let y2 = real(0.25 * depth.per_rate) * k1;
        let y3 = real(depth.per_rate / 6.0) * k2;
        let (m1, m2) = (y1.abs().to_f64(), y2.abs().to_f64());
        let behind = depth.per_rate * (0.125 * (k3.abs().to_f64() + tail) + error);
        let z = y3.abs().to_f64() + behind;
        let all = m1 + m2 + z;
        let (p1, p2) = (-y1, real(0.5) * y1 * y1 - y2);
        let p3 = y1 * y2 - y3 - y1 * y1 * y1 * real(1.0 / 6.0);
        let start = R::ONE - p1 + p2 - p3;
        let growth = 1.0 + all + all * all;
        let missed = behind
            + 0.5 * (m2 * m2 + z * z)
            + z * (m1 + m2)
            + (all - m1) * (all * all + all * m1 + m1 * m1) / 6.0
            + all * all * all * all / 24.0 * growth
            + 8.0 * u * growth;
        let min_opacity = start.to_f64() - missed;
        if !(all <= 1.2 && min_opacity >= 0.5) {
            return None;
        }
        let scaled = missed / (start.to_f64() * min_opacity) * growth;
        Some(Self { p: [p1, p2, p3], first: R::ONE / start, missed, scaled, growth })
    }

    /// Returns the coefficients of κ·unit·P/P₀ = g₀ + g₁t + g₂t² + g₃t³ + …, and a bound of what they leave out.
    #[inline]
    fn absorbed(&self, depth: &Depth<R>) -> ([R; 4], f64) {
        let Rate { k: [k0, k1, k2, k3], tail, error, .. } = depth.rate;
        let [p1, p2, p3] = self.p;
        let g = [k0, k1 + k0 * p1, k2 + k1 * p1 + k0 * p2, k3 + k2 * p1 + k1 * p2 + k0 * p3];
        let [m_k1, m_k2, m_k3] = [k1, k2, k3].map(|k| k.abs().to_f64());
        let [m_p1, m_p2, m_p3] = [p1, p2, p3].map(|p| p.abs().to_f64());
        let left_out = (tail + error) * self.growth
            + depth.rate.size() * (self.missed + self.scaled)
            + m_k1 * m_p3
            + m_k2 * (m_p2 + m_p3)
            + m_k3 * (m_p1 + m_p2 + m_p3);
        (g, left_out)
    }
}

/// Returns the step along a cubic that lies in one piece of the transfer function, by power series about its middle; `None` where they do not
/// converge well enough to say anything.
///
/// `base` is what the cubic's values are reckoned from; `noise` bounds how far they are off. Where a cruder estimate misses no more than
/// `enough`, it will do. See the README beside this file for the series and their remainders.
pub(super) fn smooth<R: Real>(
    optics: &Optics,
    piece: &Piece,
    cubic: &Cubic<R>,
    base: f64,
    noise: f64,
    length: f64,
    enough: f64,
) -> Option<Step> {
    let real = R::from_f64;
    let u = 2.0 * R::ROUNDOFF;
    let c = cubic.about_middle();
    let depth = Depth::new(optics, Rate::along(optics, piece, &c, base, noise)?, length)?;
    let source = piece.source_at(base + c[0].to_f64());
    let steep = piece.source_steepness();
    let spread = c[1].abs().to_f64() + c[2].abs().to_f64() + c[3].abs().to_f64();
    let source_off = 5.0 * piece.steepest_source * noise;
    let brightest = source.iter().fold(0.0f64, |m, s| m.max(s.abs()));
    let mut step = depth.step;
    step.variation = 2.0 * (steep * spread + source_off);
    step.rounding[1] = source_off * if optics.emits { length } else { step.opacity };
    // The source at the middle stands for all of it.
    let plain = |mut step: Step| {
        step.light = source.map(|s| (s * step.opacity).max(0.0));
        step.light_error = (steep * spread + source_off + 4.0 * u * brightest) * step.opacity;
        step
    };
    if !optics.emits && (steep == 0.0 || steep * spread * step.opacity <= enough) {
        return Some(plain(step));
    }
    let Some(inside) = Transparency::inside(&depth) else {
        return (!optics.emits).then(|| plain(step));
    };
    let (c1, c2, c3) = (c[1], c[2], c[3]);
    let (third, fifth, seventh) = (real(1.0 / 3.0), real(0.2), real(1.0 / 7.0));
    if optics.emits {
        let [p1, p2, p3] = inside.p;
        let even = (inside.first * (R::ONE + p2 * third)).to_f64();
        let odd = c1 * (p1 * third + p3 * fifth) + c2 * (third + p2 * fifth) + c3 * (p1 * fifth + p3 * seventh);
        let odd = (inside.first * odd).to_f64();
        step.light = std::array::from_fn(|i| (length * (source[i] * even + piece.source_slope[i] * odd)).max(0.0));
        step.light_error = length * ((brightest + steep * spread) * (inside.missed + inside.scaled) + source_off);
        return Some(step);
    }
    let (g, left_out) = inside.absorbed(&depth);
    let weight =
        c1 * (g[1] * third + g[3] * fifth) + c2 * (g[0] * third + g[2] * fifth) + c3 * (g[1] * fifth + g[3] * seventh);
    let weight = depth.per_rate * (inside.first * weight).to_f64();
    // |c₁t + c₂t² + c₃t³| ≤ spread·|t|, whose mean is ½.
    let light_error = depth.per_rate * steep * spread * (0.5 * left_out + 8.0 * u * depth.rate.size())
        + (source_off + 4.0 * u * brightest) * step.opacity;
    let crude = plain(step);
    if light_error >= crude.light_error {
        return Some(crude);
    }
    step.light = std::array::from_fn(|i| (source[i] * step.opacity + piece.source_slope[i] * weight).max(0.0));
    step.light_error = light_error;
    Some(step)
}

/// Effect of gradient and colours of the places on the medium of a step.
#[derive(Clone, Copy)]
pub(super) struct ByPlace<'a> {
    /// Change of its light, and the factor on extinction; `None` where these stay as they are.
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

/// Returns the step along a cubic as [`smooth`] does, of a medium that follows its place.
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

/// Returns the step through one stored number, of a medium that follows its place; `None` where series say nothing.
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

fn tau_opacity<R: Real>(tau: R) -> R {
    -(-tau).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_bound::seeded::runner;
    use proptest::prelude::*;
    use vr_core::{Calibration, ControlPoint, TransferFunction};

    /// Returns opacity and light of a step by 4000 midpoints: good to 10⁻⁸ or so on these smooth functions.
    fn exact(optics: &Optics, piece: &Piece, cubic: &Cubic<f64>, length: f64) -> (f64, [f64; 3]) {
        const N: usize = 4000;
        let (mut depth, mut light) = (0.0f64, [0.0; 3]);
        for i in 0..N {
            let f = cubic.at((i as f64 + 0.5) / N as f64);
            let tau = length / N as f64 / optics.unit * optics.rate(piece.opacity_at(f), piece.clearness_at(f));
            let weight =
                if optics.emits { length / N as f64 * source_weight(tau) } else { opacity(tau) } * libm::exp(-depth);
            for (sum, s) in light.iter_mut().zip(piece.source_at(f)) {
                *sum += s * weight;
            }
            depth += tau;
        }
        (opacity(depth), light)
    }

    /// Errors of many random steps, each as a fraction of its bound (opacity and light).
    fn ratios<R: Real>(of: impl Fn(&Optics, &Piece, &Cubic<R>, f64) -> Option<(Step, Step)>) -> Vec<[f64; 2]> {
        let coefficient = || 0.02f64..0.98;
        let strategy = (
            [coefficient(), coefficient(), coefficient(), coefficient()],
            [0.0f64..0.95, 0.0f64..0.95],
            [[0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0], [0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0]],
            (any::<bool>(), any::<bool>(), 0.01f64..3.0, 0.0f64..1.0),
        );
        let found = std::cell::RefCell::new(Vec::new());
        let run = runner(3000, 7).run(&strategy, |(b, alpha, color, (power, emits, length, flat))| {
            let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
            let point = |i: usize| ControlPoint {
                emission: emits.then_some(color[i]),
                ..ControlPoint::new(i as f64, color[i], alpha[i])
            };
            let transfer = TransferFunction::new(vec![point(0), point(1)], rule, 1.0).unwrap();
            let optics = Optics::new(&transfer, Calibration::default(), 1.0);
            let piece = optics.piece_at(0.5);
            // From wild to nearly flat: the smaller, the more the leading terms count.
            let b = b.map(|x| 0.5 + (x - 0.5) * flat * flat);
            let cubic = Cubic(b);
            let rounded = Cubic(b.map(R::from_f64));
            if let Some((estimate, bound)) = of(&optics, piece, &rounded, length) {
                let (a, light) = exact(&optics, piece, &cubic, length);
                let max_light = if optics.emits { 0.0 } else { 1.0 };
                let off = (0..3).map(|c| (estimate.light[c] - light[c]).abs()).fold(0.0, f64::max);
                let slack = 3e-7;
                found.borrow_mut().push([
                    ((estimate.opacity - a).abs() - slack).max(0.0) / bound.opacity_error.max(1e-12),
                    (off - slack).max(0.0) / (bound.light_error + max_light * bound.opacity_error).max(1e-12),
                ]);
            }
            Ok(())
        });
        run.unwrap();
        found.into_inner()
    }

    fn noise<R: Real>() -> f64 {
        4.0 * R::ROUNDOFF
    }

    fn holds<R: Real>() {
        let all = ratios::<R>(|o, p, c, l| smooth(o, p, c, 0.0, noise::<R>(), l, 0.0).map(|s| (s, s)));
        assert!(all.len() > 2000, "{}", all.len());
        let worst = |i: usize| all.iter().map(|r| r[i]).fold(0.0, f64::max);
        println!("{}: {} steps, worst share of the bound {:.2} and {:.2}", R::NAME, all.len(), worst(0), worst(1));
        assert!(worst(0) <= 1.0 && worst(1) <= 1.0);
        // And is no bound for its own sake: some steps use a good part of it.
        assert!(worst(0) > 0.05 && worst(1) > 0.05);
    }

    #[test]
    fn smooth_steps_keep_their_bounds() {
        holds::<f64>();
        holds::<f32>();
    }

    #[test]
    fn a_left_out_term_breaks_the_bound() {
        // What a value at the middle alone gives, with the bound of the whole series.
        let crude = |o: &Optics, p: &Piece, c: &Cubic<f64>, l: f64| {
            let bound = smooth(o, p, c, 0.0, noise::<f64>(), l, 0.0)?;
            let f = c.about_middle()[0];
            Some((constant(o, o.rate(p.opacity_at(f), p.clearness_at(f)), p.source_at(f), l), bound))
        };
        let all = ratios::<f64>(crude);
        let broken = |i: usize| all.iter().filter(|r| r[i] > 1.0).count();
        assert!(
            broken(0) > all.len() / 10 && broken(1) > all.len() / 10,
            "{} {} of {}",
            broken(0),
            broken(1),
            all.len()
        );
    }

    #[test]
    fn coarse_steps_hold_whatever_the_order_of_values() {
        let points = vec![
            ControlPoint::new(0.0, [0.1, 0.5, 0.9], 0.0),
            ControlPoint::new(0.5, [0.9, 0.5, 0.0], 0.7),
            ControlPoint::new(1.0, [0.2, 0.3, 0.4], 0.2),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let optics = Optics::new(&transfer, Calibration::default(), 1.0);
        let extremes = optics.extremes(0.2, 0.9);
        let step = coarse(&optics, &extremes, 2.0, f64::INFINITY);
        for pair in [[0.2, 0.9], [0.9, 0.2], [0.5, 0.5], [0.5, 0.2], [0.3, 0.8]] {
            let halves = pair.map(|v| {
                let (rate, source) = optics.exactly(v);
                constant(&optics, rate, source, 1.0)
            });
            for behind in [0.0, 1.0] {
                let through = |s: &Step, b: [f64; 3]| -> [f64; 3] {
                    std::array::from_fn(|c| s.light[c] + (1.0 - s.opacity) * b[c])
                };
                let want = through(&halves[0], through(&halves[1], [behind; 3]));
                let got = through(&step, [behind; 3]);
                for c in 0..3 {
                    assert!((got[c] - want[c]).abs() <= step.light_error + step.opacity_error + 1e-15, "{pair:?}");
                }
            }
        }
    }
}
