//! Kernels stretched to the unit ball or the unit cube, in f64: values, and integrals along lines.

use std::f64::consts::PI;

use vr_core::PointKernel;

/// A kernel of unit integral that is 0 beyond 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Profile {
    /// A function of the distance.
    Radial(Radial),
    /// Π of tents.
    Bilinear,
    /// Π of cubic B-splines.
    BSpline,
    /// Π of windowed sincs.
    Sinc(WindowedSinc),
    /// The cube itself.
    Box,
    /// Π of Catmull-Rom cubics.
    CatmullRom,
    /// Π of Gaussians.
    Gaussian(LoweredGaussian),
}

/// e^(−½ (deviations·t)²) along an axis, lowered so that it ends in 0 at ±1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LoweredGaussian {
    deviations: f64,
    factor: f64,
}

impl LoweredGaussian {
    pub(crate) fn at(self, t: f64) -> f64 {
        let e = 0.5 * self.deviations * self.deviations;
        if t.abs() >= 1.0 { 0.0 } else { self.factor * libm::exp(-e) * libm::expm1(e * (1.0 - t) * (1.0 + t)) }
    }

    fn slope(self, t: f64) -> f64 {
        let square = self.deviations * self.deviations;
        if t.abs() >= 1.0 { 0.0 } else { -self.factor * square * t * libm::exp(-0.5 * square * t * t) }
    }
}

/// sinc(x)·sinc(x / zeros) along an axis (Lanczos' window), stretched to [−1, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WindowedSinc {
    zeros: f64,
    factor: f64,
}

impl WindowedSinc {
    pub(crate) fn at(self, t: f64) -> f64 {
        if t.abs() >= 1.0 { 0.0 } else { self.factor * sinc(t * self.zeros) * sinc(t) }
    }

    fn slope(self, t: f64) -> f64 {
        if t.abs() >= 1.0 {
            return 0.0;
        }
        let wave = self.zeros * sinc_slope(t * self.zeros) * sinc(t);
        self.factor * (wave + sinc(t * self.zeros) * sinc_slope(t))
    }
}

/// A radially symmetric kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Radial {
    form: Form,
    factor: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// A Gaussian that ends in 0 at the radius.
    Gaussian {
        /// Standard deviations to the radius.
        deviations: f64,
        /// e^(−½ deviations²), by which it is lowered.
        edge: f64,
    },
    Cone,
    /// Kernel of scattered points; normalised already.
    Point(PointKernel),
}

/// Formula of a radially symmetric kernel of a grid: its weight, up to a factor, at a distance t from its centre; 0 for t > 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RadialWeight {
    Gaussian(Gaussian),
    /// 1 − t.
    Cone,
}

/// max(0, e^(−rate t²) − edge).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gaussian {
    pub(crate) rate: f32,
    pub(crate) edge: f32,
}

/// 1 − |t|.
pub(crate) fn tent(t: f64) -> f64 {
    (1.0 - t.abs()).max(0.0)
}

/// The cubic B-spline, stretched to [−1, 1] with an integral of 1.
pub(crate) fn cubic(t: f64) -> f64 {
    let x = 2.0 * t.abs();
    let outer = (2.0 - x).max(0.0);
    let inner = (1.0 - x).max(0.0);
    2.0 * (outer * outer * outer - 4.0 * inner * inner * inner) / 6.0
}

/// 1 in [−1, 1), with an integral of 1: boxes side by side leave no place out.
fn uniform(t: f64) -> f64 {
    if (-1.0..1.0).contains(&t) { 0.5 } else { 0.0 }
}

/// The Catmull-Rom cubic (Keys 1981, a = −½), stretched to [−1, 1] with an integral of 1.
fn catmull_rom(t: f64) -> f64 {
    let x = 2.0 * t.abs();
    let (outer, inner) = ((2.0 - x).max(0.0), (1.0 - x).max(0.0));
    outer * outer * (1.0 - x) + 2.0 * inner * inner * (2.0 * x - 1.0)
}

impl Profile {
    pub(crate) fn gaussian(deviations: f64) -> Self {
        // 4π ∫ t² (e^(−at²) − e^(−a)) dt; ∫ t² e^(−at²) dt = (√(π/a) erf(√a) − 2 e^(−a)) / 4a.
        let a = 0.5 * deviations * deviations;
        let edge = libm::exp(-a);
        let moment = ((PI / a).sqrt() * libm::erf(a.sqrt()) - 2.0 * edge) / (4.0 * a);
        Self::Radial(Radial {
            form: Form::Gaussian { deviations, edge },
            factor: 1.0 / (4.0 * PI * (moment - edge / 3.0)),
        })
    }

    pub(crate) fn cone() -> Self {
        Self::Radial(Radial { form: Form::Cone, factor: 3.0 / PI })
    }

    pub(crate) fn sinc(zeros: f64) -> Self {
        let raw = WindowedSinc { zeros, factor: 1.0 };
        let integral = 2.0 * quadrature(0.0, 1.0, 16, |t| raw.at(t));
        Self::Sinc(WindowedSinc { zeros, factor: 1.0 / integral })
    }

    pub(crate) fn product_gaussian(deviations: f64) -> Self {
        let raw = LoweredGaussian { deviations, factor: 1.0 };
        let integral = 2.0 * quadrature(0.0, 1.0, 16, |t| raw.at(t));
        Self::Gaussian(LoweredGaussian { deviations, factor: 1.0 / integral })
    }

    pub(crate) fn point(kernel: PointKernel) -> Self {
        Self::Radial(Radial { form: Form::Point(kernel), factor: 1.0 })
    }
}

impl Radial {
    /// True for a cone, of a grid or of points.
    pub(crate) fn is_cone(&self) -> bool {
        matches!(self.form, Form::Cone | Form::Point(PointKernel::Cone))
    }

    /// W'(t)/t, for t ≥ 0; 0 in the middle of a cone, which has no gradient there.
    fn slope_by_distance(&self, t: f64) -> f64 {
        if t >= 1.0 {
            return 0.0;
        }
        self.factor
            * match self.form {
                Form::Gaussian { deviations, .. } => {
                    let square = deviations * deviations;
                    -square * libm::exp(-0.5 * square * t * t)
                }
                Form::Cone if t > 0.0 => -1.0 / t,
                Form::Cone => 0.0,
                Form::Point(kernel) => kernel.slope_by_distance(t),
            }
    }

    /// Formula of a kernel of a grid; `None` for kernels of scattered points.
    pub(crate) fn weight(&self) -> Option<RadialWeight> {
        match self.form {
            Form::Gaussian { deviations, edge } => {
                let rate = (0.5 * deviations * deviations) as f32;
                Some(RadialWeight::Gaussian(Gaussian { rate, edge: edge as f32 }))
            }
            Form::Cone => Some(RadialWeight::Cone),
            Form::Point(_) => None,
        }
    }

    /// The kernel of scattered points; `None` for kernels of grids.
    pub(crate) fn point(&self) -> Option<PointKernel> {
        match self.form {
            Form::Point(kernel) => Some(kernel),
            _ => None,
        }
    }

    /// W(t), for t ≥ 0.
    pub(crate) fn at(&self, t: f64) -> f64 {
        if t >= 1.0 {
            return 0.0;
        }
        self.factor
            * match self.form {
                Form::Gaussian { deviations, edge } => {
                    let e = 0.5 * deviations * deviations;
                    edge * libm::expm1(e * (1.0 - t) * (1.0 + t))
                }
                Form::Cone => 1.0 - t,
                Form::Point(kernel) => kernel.at(t),
            }
    }

    /// ∫ W from 0 to z along a line that passes the middle at a distance b; odd in z, and constant from the edge on.
    pub(crate) fn along_line(&self, b: f64, z: f64) -> f64 {
        self.section(b, 0.0, z)
    }

    /// ∫ W between two places of that line: summed there, so that near the edge it has digits of its own.
    pub(crate) fn section(&self, b: f64, from: f64, to: f64) -> f64 {
        self.integral(b, [from, to], &|t| self.at(t))
    }

    /// ∫ W'(t)/t between two places of that line: the factor of its nearest place in the integral of the gradient.
    pub(crate) fn slope_section(&self, b: f64, from: f64, to: f64) -> f64 {
        self.integral(b, [from, to], &|t| self.slope_by_distance(t))
    }

    /// ∫ of a function of the distance t between two places of that line.
    fn integral(&self, b: f64, [from, to]: [f64; 2], of: &dyn Fn(f64) -> f64) -> f64 {
        if b >= 1.0 {
            return 0.0;
        }
        if to < from {
            return -self.integral(b, [to, from], of);
        }
        // The same on either side of the middle.
        if to <= 0.0 && from < 0.0 {
            return self.integral(b, [-to, -from], of);
        }
        if from < 0.0 {
            return self.integral(b, [0.0, -from], of) + self.integral(b, [0.0, to], of);
        }
        let edge = ((1.0 - b) * (1.0 + b)).sqrt();
        let [from, to] = [from, to].map(|z| z.min(edge));
        // Where W bends, the rule must not go across.
        let bend = match self.form {
            Form::Point(PointKernel::CubicSpline) if b < 0.5 => ((0.5 - b) * (0.5 + b)).sqrt().clamp(from, to),
            _ => from,
        };
        let value = |s: f64| of((b * b + s * s).sqrt());
        // A kink at the middle shows as one of s where b is small: s = b sinh u makes it smooth.
        let part = |from: f64, to: f64| {
            if b < 1e-12 {
                return quadrature(from, to, 8, value);
            }
            let [u, v] = [from, to].map(|s| libm::asinh(s / b));
            quadrature(u, v, 8, |u| b * libm::cosh(u) * value(b * libm::sinh(u)))
        };
        part(from, bend) + part(bend, to)
    }
}

fn sinc(x: f64) -> f64 {
    let x = PI * x;
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

/// Derivative of sin(πx) / (πx).
fn sinc_slope(x: f64) -> f64 {
    if x.abs() < 1e-4 { -PI * PI * x / 3.0 } else { (libm::cos(PI * x) - sinc(x)) / x }
}

/// Gauss-Legendre of five points on each of so many parts.
pub(crate) fn quadrature(from: f64, to: f64, parts: usize, f: impl Fn(f64) -> f64) -> f64 {
    const NODES: [(f64, f64); 3] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    if to <= from {
        return 0.0;
    }
    let half = 0.5 * (to - from) / parts as f64;
    let mut sum = 0.0;
    for part in 0..parts {
        let middle = from + half * (2 * part + 1) as f64;
        for (x, w) in NODES {
            sum += w * f(middle + half * x);
            if x > 0.0 {
                sum += w * f(middle - half * x);
            }
        }
    }
    sum * half
}

impl Profile {
    /// ∫ along the part from `from` to `to` of a line `at + s·along` in kernel space, per unit of s.
    pub(crate) fn integral(&self, at: [f64; 3], along: [f64; 3], from: f64, to: f64) -> f64 {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        match self {
            Self::Radial(radial) => {
                let length = dot(along, along).sqrt();
                let nearest = -dot(at, along) / (length * length);
                let foot: [f64; 3] = std::array::from_fn(|a| at[a] + nearest * along[a]);
                let b = dot(foot, foot).sqrt();
                let z = |s: f64| (s - nearest) * length;
                radial.section(b, z(from), z(to)) / length
            }
            _ => {
                let [mut start, mut end] = [from, to];
                let mut cuts = Vec::new();
                let (knots, parts): (&[f64], usize) = match self {
                    Self::Bilinear => (&[0.0], 1),
                    Self::BSpline | Self::CatmullRom => (&[-0.5, 0.0, 0.5], 1),
                    Self::Box => (&[], 1),
                    // Smooth, and of a few waves.
                    _ => (&[], 16),
                };
                for a in 0..3 {
                    if along[a] == 0.0 {
                        if at[a].abs() >= 1.0 {
                            return 0.0;
                        }
                        continue;
                    }
                    let [p, q] = [-1.0, 1.0].map(|edge| (edge - at[a]) / along[a]);
                    (start, end) = (start.max(p.min(q)), end.min(p.max(q)));
                    cuts.extend(knots.iter().map(|k| (k - at[a]) / along[a]));
                }
                cuts.retain(|&s| s > start && s < end);
                cuts.push(end);
                cuts.sort_by(f64::total_cmp);
                // Polynomials of degree 3 and 9 are exact.
                let mut sum = 0.0;
                for cut in cuts {
                    sum += quadrature(start, cut, parts, |s| self.at(std::array::from_fn(|a| at[a] + s * along[a])));
                    start = start.max(cut);
                }
                sum
            }
        }
    }

    /// The kernel at a place, and its slopes; at a kink the mean of both sides' slopes.
    pub(crate) fn with_slope(&self, t: [f64; 3]) -> (f64, [f64; 3]) {
        if let Self::Radial(radial) = self {
            let distance = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
            let by_distance = radial.slope_by_distance(distance);
            return (radial.at(distance), t.map(|x| by_distance * x));
        }
        let along = t.map(|t| self.along_axis(t));
        let other = |a: usize, b: usize| along[a][0] * along[b][0];
        let slopes = [along[0][1] * other(1, 2), along[1][1] * other(0, 2), along[2][1] * other(0, 1)];
        (along[0][0] * other(1, 2), slopes)
    }

    /// Value and slope of a product's factor along an axis.
    fn along_axis(&self, t: f64) -> [f64; 2] {
        let (x, sign) = (2.0 * t.abs(), if t == 0.0 { 0.0 } else { t.signum() });
        let (outer, inner) = ((2.0 - x).max(0.0), (1.0 - x).max(0.0));
        match self {
            Self::Bilinear => [tent(t), if t.abs() < 1.0 { -sign } else { 0.0 }],
            Self::BSpline => [cubic(t), -sign * 2.0 * (outer * outer - 4.0 * inner * inner)],
            Self::Box => [uniform(t), 0.0],
            Self::CatmullRom => {
                let beyond = -2.0 * outer * (1.0 - x) - outer * outer;
                let within = -4.0 * inner * (2.0 * x - 1.0) + 4.0 * inner * inner;
                [catmull_rom(t), 2.0 * sign * (beyond + within)]
            }
            Self::Sinc(sinc) => [sinc.at(t), sinc.slope(t)],
            Self::Gaussian(gaussian) => [gaussian.at(t), gaussian.slope(t)],
            Self::Radial(_) => unreachable!("no product"),
        }
    }

    /// The kernel at a place.
    pub(crate) fn at(&self, t: [f64; 3]) -> f64 {
        match self {
            Self::Radial(radial) => radial.at((t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt()),
            Self::Bilinear => t.map(tent).into_iter().product(),
            Self::BSpline => t.map(cubic).into_iter().product(),
            Self::Sinc(sinc) => t.map(|t| sinc.at(t)).into_iter().product(),
            Self::Box => t.map(uniform).into_iter().product(),
            Self::CatmullRom => t.map(catmull_rom).into_iter().product(),
            Self::Gaussian(gaussian) => t.map(|t| gaussian.at(t)).into_iter().product(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Profile> {
        let mut all = vec![Profile::gaussian(2.0 / 0.7), Profile::cone()];
        all.extend(PointKernel::ALL.map(Profile::point));
        all.extend([Profile::Bilinear, Profile::BSpline, Profile::sinc(3.0), Profile::CatmullRom]);
        all.push(Profile::product_gaussian(2.0 / 0.7));
        all
    }

    #[test]
    fn line_integrals_are_those_of_the_values() {
        for profile in all() {
            let along = [0.6, -0.48, 0.64];
            for at in [[0.1, 0.2, -0.3], [0.0; 3], [0.4, 0.1, 0.5], [0.9, 0.9, 0.0]] {
                for (from, to) in [(-2.0, 2.0), (-0.2, 0.3), (0.1, 3.0)] {
                    // The midpoint rule on 40000 parts of a function that may have a kink: far below 10⁻⁶.
                    let n = 40_000;
                    let h = (to - from) / f64::from(n);
                    let value = |s: f64| profile.at(std::array::from_fn(|a| at[a] + s * along[a]));
                    let sum: f64 = (0..n).map(|i| value(from + h * (f64::from(i) + 0.5))).sum::<f64>() * h;
                    let got = profile.integral(at, along, from, to);
                    assert!((got - sum).abs() < 1e-6, "{profile:?} {at:?} {from} {to}: {got} for {sum}");
                }
            }
        }
    }

    #[test]
    fn footprints_hold_the_whole_kernel() {
        for profile in all() {
            let Profile::Radial(radial) = profile else { continue };
            let total = quadrature(0.0, 1.0, 200, |b| 2.0 * PI * b * 2.0 * radial.along_line(b, 1.0));
            assert!((total - 1.0).abs() < 1e-6, "{profile:?}: {total}");
        }
    }
}
