//! Smooth parts of the kernels of scattered points, and how well polynomials along a straight line follow them.
//!
//! Along a line at the distance β from a point (all lengths in radii of its support) a kernel is a function of r = √(β² + u²), u being
//! the place on the line. Even powers of r are polynomials; the rest, called its *odd part* here, is analytic but for branch points at
//! u = ±iβ. The largest Bernstein ellipse around [u₀, u₁] that they lie outside of passes through them: the sum of the branch point's
//! distances from both foci is r(u₀) + r(u₁), so that a = (r(u₀) + r(u₁))/(u₁ − u₀) is its major semi-axis in units of half the interval,
//! and ρ = a + √(a² − 1). There |r|² ≤ β² + |u|² bounds the odd part, and n + 1 Chebyshev points miss at most 4 M ρ⁻ⁿ/(ρ − 1)
//! (Trefethen, *Approximation Theory and Approximation Practice*, 2013, theorem 8.2). A Gaussian is entire, and any ellipse will do.

use crate::PointKernel;

use super::chebyshev::LEBESGUE;

/// A smooth part of a kernel, without the factor that makes the kernel's integral 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// 1 − 6t² + 6t³: the cubic spline up to t = ½.
    Core,
    /// 2(1 − t)³: the cubic spline from t = ½.
    Rim,
    /// e^(−4.5t²) − e^(−4.5).
    Gaussian,
    /// 1 − t.
    Cone,
}

/// A part of a line relative to one support, in radii.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Square of the distance of the line.
    pub square: f64,
    /// Middle of the part, from where the line is nearest.
    pub middle: f64,
    /// Half its length.
    pub half: f64,
    /// Distance of the middle from the point. Everywhere on the part it is within `half` of that.
    pub distance: f64,
}

impl Stretch {
    /// The part of a line at a distance of √`square`.
    pub fn new(square: f64, middle: f64, half: f64) -> Self {
        Self { square, middle, half, distance: (square + middle * middle).sqrt() }
    }

    /// Major semi-axis, in units of `half`, of the ellipse around the part that passes through the branch points; a little less, for rounding. `None` where
    /// they are too near to tell.
    pub fn branch_points(&self) -> Option<f64> {
        let (from, to) = (self.middle - self.half, self.middle + self.half);
        let (r0, r1) = ((self.square + from * from).sqrt(), (self.square + to * to).sqrt());
        let a = (r0 + r1) / (2.0 * self.half) * (1.0 - 16.0 * f64::EPSILON);
        (a > 1.0 && a.is_finite()).then_some(a)
    }
}

/// Error of interpolation at Chebyshev points on a part of a line: at most `size · ρ⁻ⁿ`, and at most `crude`.
#[derive(Clone, Copy, Debug)]
pub struct Remainder {
    /// Factor of ρ⁻ⁿ in the bound.
    pub size: f64,
    /// 1/ρ.
    pub decay: f64,
    /// Bound for every degree.
    pub crude: f64,
}

impl Remainder {
    /// The bounds for each of [`DEGREES`].
    #[inline]
    pub fn all(&self) -> [f64; DEGREES.len()] {
        let d2 = self.decay * self.decay;
        let d4 = d2 * d2;
        let d8 = d4 * d4;
        [d4, d4 * d2, d8, d8 * d4, d8 * d8, d8 * d8 * d4].map(|power| (self.size * power).min(self.crude))
    }
}

/// Degrees of interpolation for which there are remainders.
pub const DEGREES: [usize; 6] = [4, 6, 8, 12, 16, 20];
/// Distance from the point, in half lengths of a part, beyond which bounds are a little larger, and take half the time.
const FAR: f64 = 3.0;

/// Reach of a Gaussian's ellipse into the complex plane, in radii: farther, the Gaussian grows; nearer, ρ shrinks.
pub(super) const GAUSSIAN_REACH: f64 = 1.2;

/// e^(−4.5).
const GAUSSIAN_EDGE: f64 = 0.011_108_996_538_242_306;

impl Shape {
    /// The value at a distance of t radii.
    #[inline(always)]
    pub fn at(self, t: f64) -> f64 {
        let u = 1.0 - t;
        match self {
            Self::Core => 1.0 - 6.0 * t * t * u,
            Self::Rim => 2.0 * u * u * u,
            // Without cancellation near the edge.
            Self::Gaussian => GAUSSIAN_EDGE * libm::expm1(4.5 * u * (1.0 + t)),
            Self::Cone => u,
        }
    }

    /// Adds the values, times an amplitude, at nodes of a part of a line.
    pub fn add(self, amplitude: f64, part: &Stretch, nodes: &[f64], sums: &mut [f64]) {
        #[inline(always)]
        fn each(part: &Stretch, nodes: &[f64], sums: &mut [f64], value: impl Fn(f64) -> f64) {
            for (sum, &t) in sums.iter_mut().zip(nodes) {
                let u = part.middle + part.half * t;
                *sum += value((part.square + u * u).sqrt());
            }
        }
        // One loop for each shape: no branch inside.
        match self {
            Self::Core => each(part, nodes, sums, |t| amplitude * Self::Core.at(t)),
            Self::Rim => each(part, nodes, sums, |t| amplitude * Self::Rim.at(t)),
            Self::Gaussian => each(part, nodes, sums, |t| amplitude * Self::Gaussian.at(t)),
            Self::Cone => each(part, nodes, sums, |t| amplitude * Self::Cone.at(t)),
        }
    }

    /// Bounds |slope| from the distance `min` outward.
    pub fn steepest(self, min: f64) -> f64 {
        let u = (1.0 - min).clamp(0.0, 1.0);
        match self {
            Self::Core => 2.0,
            Self::Rim => (6.0 * u * u).min(1.5),
            Self::Gaussian => 1.82,
            Self::Cone => 1.0,
        }
    }

    /// Bounds the odd part where |r| is at most `r`.
    fn odd(self, r: f64) -> f64 {
        match self {
            Self::Core => 6.0 * r * r * r,
            Self::Rim => 6.0 * r + 2.0 * r * r * r,
            Self::Gaussian => 1.0,
            Self::Cone => r,
        }
    }

    /// Bounds the error of interpolation on a part of a line.
    pub fn remainder(self, stretch: &Stretch) -> Remainder {
        let Stretch { square, middle, half, distance } = *stretch;
        if self == Self::Gaussian {
            // Semi-axes REACH along i and at most √(half² + REACH²) along the line: |e^(−4.5 r²)| ≤ e^(−4.5 (β² + Re u²)).
            let b = GAUSSIAN_REACH / half;
            let (a, b2) = ((1.0 + b * b).sqrt(), GAUSSIAN_REACH * GAUSSIAN_REACH);
            let nearest = (middle.abs() - a * half).max(0.0);
            let size = libm::exp(4.5 * (b2 - square - nearest * nearest));
            return Remainder { size: 4.0 * size / (a + b - 1.0), decay: 1.0 / (a + b), crude: 1.0 + LEBESGUE };
        }
        let (from, to) = (middle - half, middle + half);
        let crude = |r: f64| (1.0 + LEBESGUE) * self.odd(r);
        if square == 0.0 {
            // r = |u|: a cubic in u, but for what lies beyond the point, which may be a rounding of the ends.
            let beyond = (-from).min(to).max(0.0);
            return Remainder { size: f64::INFINITY, decay: 1.0, crude: 2.0 * crude(beyond) };
        }
        if distance > FAR * half {
            // r(u₀) + r(u₁) ≥ 2 r, and the ellipse of a = r/half has |r|² ≤ 4 r² everywhere. There ρ ≥ 2a − 1/a ≥ 5.6.
            let a = distance / half;
            let decay = a / (2.0 * a * a - 1.0);
            let size = 4.0 * 1.22 * decay * self.odd(2.0 * distance);
            return Remainder { size, decay, crude: crude(distance + half) };
        }
        let crude = crude((square + (middle.abs() + half) * (middle.abs() + half)).sqrt());
        let Some(a) = stretch.branch_points() else {
            return Remainder { size: f64::INFINITY, decay: 1.0, crude };
        };
        let rho = a + (a * a - 1.0).sqrt();
        let farthest = middle.abs() + a * half;
        let size = self.odd((square + farthest * farthest).sqrt());
        Remainder { size: 4.0 * size / (rho - 1.0), decay: 1.0 / rho, crude }
    }
}

/// The factor that makes a kernel's integral 1.
pub fn factor(kernel: PointKernel) -> f64 {
    match kernel {
        PointKernel::CubicSpline => 8.0 / std::f64::consts::PI,
        PointKernel::Cone => 3.0 / std::f64::consts::PI,
        PointKernel::Gaussian => kernel.at(0.0) / Shape::Gaussian.at(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::chebyshev::interpolation;

    #[test]
    fn shapes_are_the_kernels() {
        for i in 0..1000 {
            let t = f64::from(i) / 1000.0;
            let of = |kernel: PointKernel, shape: Shape| {
                let difference = factor(kernel) * shape.at(t) - kernel.at(t);
                assert!(difference.abs() < 1e-14, "{shape:?} at {t}: {difference}");
            };
            of(PointKernel::Cone, Shape::Cone);
            of(PointKernel::Gaussian, Shape::Gaussian);
            of(PointKernel::CubicSpline, if t <= 0.5 { Shape::Core } else { Shape::Rim });
        }
    }

    #[test]
    fn slopes_are_bounded() {
        for shape in [Shape::Core, Shape::Rim, Shape::Gaussian, Shape::Cone] {
            let (low, high) = if shape == Shape::Core { (0.0, 0.5) } else { (0.5, 1.0) };
            for i in 0..100 {
                let t = low + (high - low) * f64::from(i) / 100.0 + 1e-4;
                let slope = (shape.at(t + 1e-6) - shape.at(t - 1e-6)) / 2e-6;
                assert!(slope.abs() <= shape.steepest(t - 2e-6) + 1e-6, "{shape:?} at {t}: {slope}");
            }
        }
    }

    #[test]
    fn interpolation_misses_no_more_than_the_remainder() {
        // Parts of lines at all distances, short and long, near the point and far.
        let (mut tried, mut tight) = (0, 0);
        for shape in [Shape::Core, Shape::Rim, Shape::Gaussian, Shape::Cone] {
            for beta in [0.0, 1e-9, 1e-3, 0.03, 0.2, 0.5, 0.9] {
                for middle in [0.0, 1e-3, 0.05, 0.3, -0.6] {
                    for half in [1e-4, 0.01, 0.05, 0.3] {
                        for (i, n) in DEGREES.into_iter().enumerate() {
                            let stretch = Stretch::new(beta * beta, middle, half);
                            let f = |t: f64| shape.at((beta * beta + (middle + half * t).powi(2)).sqrt());
                            let rule = interpolation(n);
                            let values: Vec<f64> = rule.nodes.iter().map(|&t| f(t)).collect();
                            let (p, _) = rule.through(&values, 0.0);
                            let off = (0..200).map(|i| -0.995 + 0.01 * f64::from(i)).map(|t| (p.at(t) - f(t)).abs());
                            let off = off.fold(0.0, f64::max);
                            let bound = shape.remainder(&stretch).all()[i];
                            // Rounding of values of about 1, and in powers of t.
                            assert!(off <= bound + 1e-11, "{shape:?} {beta} {middle} {half} {n}: {off} > {bound}");
                            tried += 1;
                            tight += usize::from(off > 1e-10 && off > 1e-3 * bound);
                        }
                    }
                }
            }
        }
        // A bound that is far off everywhere would be of no use.
        assert!(tight > 50, "{tight} of {tried}");
    }
}
