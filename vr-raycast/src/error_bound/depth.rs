//! Optical depth along a step by power series, and the transparency inside it, with bounds of what they miss. The README beside this file has the series.

use vr_core::{OpacityRule, Real};

use super::optics::{Optics, Piece};
use super::series::Series;
use super::step::{ROUNDING, Step, opacity};

/// Extinction along a cubic that lies in one piece of the transfer function, by power series about its middle: κ · unit is k₀ + k₁t + k₂t² + k₃t³ + …, with
/// t ∈ [−1, 1] over the step.
pub(super) struct Rate<R> {
    pub(super) k: [R; 4],
    /// Bound of the terms that follow.
    pub(super) tail: f64,
    /// Its mean, which is known better than by these terms, and a bound of what that is off by.
    pub(super) mean: R,
    pub(super) mean_error: f64,
    /// Bound of what κ · unit is off by for being computed from a field that is, and by rounding.
    pub(super) error: f64,
    pub(super) rounding: f64,
}

impl<R: Real> Rate<R> {
    /// `c`: the cubic by powers of t. `None` where the series does not converge well enough to say anything.
    #[inline]
    pub(super) fn along(optics: &Optics, piece: &Piece, c: &[R; 4], base: f64, noise: f64) -> Option<Self> {
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
    #[inline]
    pub(super) fn uniform(rate: f64) -> Self {
        let k = [R::from_f64(rate), R::ZERO, R::ZERO, R::ZERO];
        let error = 2.0 * R::ROUNDOFF * rate;
        Self { k, tail: 0.0, mean: k[0], mean_error: 0.0, error, rounding: 0.0 }
    }

    /// Returns a bound of |k₀| + |k₁| + |k₂| + |k₃|.
    #[inline]
    pub(super) fn size(&self) -> f64 {
        let [k0, k1, k2, k3] = self.k.map(|k| k.abs().to_f64());
        k0 + k1 + k2 + k3
    }

    /// Returns the sum of two extinctions.
    #[inline]
    pub(super) fn plus(&self, other: &Self) -> Self {
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
    #[inline]
    pub(super) fn times(&self, factor: &Series) -> Self {
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
pub(super) struct Depth<R> {
    pub(super) rate: Rate<R>,
    /// Optical depth per value of κ · unit.
    pub(super) per_rate: f64,
    /// The step, as yet without light.
    pub(super) step: Step,
}

impl<R: Real> Depth<R> {
    /// `None` where the series says nothing.
    #[inline]
    pub(super) fn new(optics: &Optics, rate: Rate<R>, length: f64) -> Option<Self> {
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
    #[inline]
    pub(super) fn uniform(optics: &Optics, rate: f64, length: f64) -> Self {
        let per_rate = length / optics.unit;
        let a = opacity(rate * per_rate);
        let step = Step { length, opacity: a, opacity_error: ROUNDING * a, ..Step::default() };
        Self { rate: Rate::uniform(rate), per_rate, step }
    }
}

/// Transparency inside a step: P/P₀ = e^(−y) = 1 + p₁t + p₂t² + p₃t³ + …, with P = 1 at the front.
pub(super) struct Transparency<R> {
    pub(super) p: [R; 3],
    /// 1/P₀ at the front.
    pub(super) first: R,
    /// Bound of what the series misses, and of what P₀ is off by relative to itself.
    pub(super) missed: f64,
    pub(super) scaled: f64,
    pub(super) growth: f64,
}

impl<R: Real> Transparency<R> {
    /// `None` where the series does not converge well enough.
    #[inline]
    pub(super) fn inside(depth: &Depth<R>) -> Option<Self> {
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
    pub(super) fn absorbed(&self, depth: &Depth<R>) -> ([R; 4], f64) {
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

#[inline]
fn tau_opacity<R: Real>(tau: R) -> R {
    -(-tau).exp_m1()
}
