//! Gradients of the kernels of scattered points, and how well polynomials along a straight line follow them.
//!
//! The gradient of a kernel is H(r)·v: v the vector from the point, r its length, H = W'(r)/r (all lengths in radii of the support). Along a line
//! at the distance β, v = p + u d is linear in u. As for values (see `kernel_shape`) even powers of r are polynomials, and the rest is
//! analytic but for branch points at u = ±iβ. A rim's and a cone's H have a pole there besides, 1/r: their ellipse is a little smaller.
//! On one of major semi-axis a' < a (in units of half the interval h) the sum of the distances of a place from both foci is 2a', that of the branch
//! point 2a, and neither focus is nearer by more than the place is: so the branch points are at least h (a − a') away, and |r|² ≥ h² (a − a')².

use crate::PointKernel;

use super::chebyshev::LEBESGUE;
use super::kernel_shape::{GAUSSIAN_REACH, Remainder, Shape, Stretch};

/// Largest degree of interpolation of a gradient: its square must be a polynomial, too ([`MAX_DEGREE`](super::MAX_DEGREE)).
pub const MAX_GRADIENT_DEGREE: usize = 12;

/// Part of the way from the interval to the branch points at which the ellipse of kernels with a pole lies.
const NEAR_POLE: f64 = 0.9;

impl Shape {
    /// H at a distance of t radii; 0 in the middle of a cone, which has no gradient there.
    #[inline(always)]
    pub fn slope_by_distance(self, t: f64) -> f64 {
        let u = 1.0 - t;
        match self {
            Self::Core => -12.0 + 18.0 * t,
            Self::Rim => -6.0 * u * u / t,
            Self::Gaussian => -9.0 * libm::exp(-4.5 * t * t),
            Self::Cone if t > 0.0 => -1.0 / t,
            Self::Cone => 0.0,
        }
    }

    /// Adds the gradients, times an amplitude, at nodes of a part of a line; `across` is the vector from the point to where the line is nearest, in
    /// radii.
    pub fn add_gradients(
        self,
        amplitude: f64,
        part: &Stretch,
        [across, along]: [[f64; 3]; 2],
        nodes: &[f64],
        sums: &mut [[f64; MAX_GRADIENT_DEGREE + 1]; 3],
    ) {
        for (j, &t) in nodes.iter().enumerate() {
            let u = part.middle + part.half * t;
            let slope = amplitude * self.slope_by_distance((part.square + u * u).sqrt());
            for (a, sum) in sums.iter_mut().enumerate() {
                sum[j] += slope * (across[a] + u * along[a]);
            }
        }
    }

    /// Bounds |H·v| from the distance `min` outward.
    pub fn steepest_gradient(self, min: f64) -> f64 {
        match self {
            Self::Gaussian if min > 1.0 / 3.0 => 9.0 * min * libm::exp(-4.5 * min * min),
            _ => self.steepest(min),
        }
    }

    /// Bounds how far the gradient changes per radius of a displacement, from the distance `min` outward: the largest of |W''| and |H|.
    pub fn sharpest_turn(self, min: f64) -> f64 {
        match self {
            Self::Core => 12.0,
            // 12 (1 − t) ≥ 6 (1 − t)²/t from t = 1/3 on.
            Self::Rim => 12.0 * (1.0 - min.max(0.5)).max(0.0),
            Self::Gaussian => 9.0,
            Self::Cone => 1.0 / min,
        }
    }

    /// Bounds the error of interpolation of each component of the gradient on a part of a line.
    pub fn gradient_remainder(self, stretch: &Stretch) -> Remainder {
        let Stretch { square, middle, half, distance } = *stretch;
        let beta = square.sqrt();
        if self == Self::Gaussian {
            // The ellipse of the values' remainder, on which |v| ≤ β + |u|.
            let b = GAUSSIAN_REACH / half;
            let a = (1.0 + b * b).sqrt();
            let (nearest, farthest) = ((middle.abs() - a * half).max(0.0), middle.abs() + a * half);
            let size = libm::exp(4.5 * (GAUSSIAN_REACH * GAUSSIAN_REACH - square - nearest * nearest));
            let size = 9.0 * size * (beta + farthest);
            return Remainder { size: 4.0 * size / (a + b - 1.0), decay: 1.0 / (a + b), crude: 2.2 * (1.0 + LEBESGUE) };
        }
        let crude = |r: f64| (1.0 + LEBESGUE) * self.odd_gradient(r);
        if square == 0.0 {
            // Polynomials in u, but for what lies beyond the point, which may be a rounding of the ends.
            let beyond = (half - middle.abs()).max(0.0);
            let crude = if beyond > 0.0 { 2.0 * crude(beyond) } else { 0.0 };
            return Remainder { size: f64::INFINITY, decay: 1.0, crude };
        }
        let crude = crude(distance + half);
        let Some(a) = stretch.branch_points() else {
            return Remainder { size: f64::INFINITY, decay: 1.0, crude };
        };
        let has_pole = matches!(self, Self::Rim | Self::Cone);
        let own = if has_pole { 1.0 + NEAR_POLE * (a - 1.0) } else { a };
        let farthest = middle.abs() + own * half;
        let (v, r) = (beta + farthest, (square + farthest * farthest).sqrt());
        let over_r = v / (half * (a - own));
        let size = match self {
            Self::Core => 18.0 * r * v,
            Self::Rim => 6.0 * (over_r + r * v),
            _ => over_r,
        };
        let rho = own + (own * own - 1.0).sqrt();
        Remainder { size: 4.0 * size / (rho - 1.0), decay: 1.0 / rho, crude }
    }

    /// Bounds the odd part of the gradient on the line itself where r is at most `r`.
    fn odd_gradient(self, r: f64) -> f64 {
        match self {
            Self::Core => 18.0 * r * r,
            Self::Rim => 6.0 + 6.0 * r * r,
            Self::Gaussian | Self::Cone => 1.0,
        }
    }
}

/// True if a kernel's gradient jumps at the edge of its support.
pub fn jumps_at_edge(kernel: PointKernel) -> bool {
    kernel != PointKernel::CubicSpline
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::chebyshev::interpolation;
    use crate::field::kernel_shape::{DEGREES, factor};

    const SHAPES: [Shape; 4] = [Shape::Core, Shape::Rim, Shape::Gaussian, Shape::Cone];

    #[test]
    fn slopes_are_the_kernels() {
        for i in 1..1000 {
            let t = f64::from(i) / 1000.0;
            let of = |kernel: PointKernel, shape: Shape| {
                let difference = factor(kernel) * shape.slope_by_distance(t) * t - kernel.slope(t);
                assert!(difference.abs() < 1e-13, "{shape:?} at {t}: {difference}");
            };
            of(PointKernel::Cone, Shape::Cone);
            of(PointKernel::Gaussian, Shape::Gaussian);
            of(PointKernel::CubicSpline, if t <= 0.5 { Shape::Core } else { Shape::Rim });
        }
    }

    #[test]
    fn turns_and_sizes_are_bounded() {
        for shape in SHAPES {
            let (low, high) = if shape == Shape::Core { (0.0, 0.5) } else { (0.5, 1.0) };
            for i in 0..100 {
                let t = low + (high - low) * f64::from(i) / 100.0 + 1e-4;
                let radial = |t: f64| shape.slope_by_distance(t) * t;
                let bend = (radial(t + 1e-6) - radial(t - 1e-6)) / 2e-6;
                let turn = bend.abs().max(shape.slope_by_distance(t).abs());
                assert!(turn <= shape.sharpest_turn(t - 2e-6) + 1e-4, "{shape:?} at {t}: {turn}");
                assert!(radial(t).abs() <= shape.steepest_gradient(t) + 1e-12, "{shape:?} at {t}: {}", radial(t));
            }
        }
    }

    #[test]
    fn interpolation_misses_no_more_than_the_remainder() {
        // Parts of lines at all distances, short and long, near the point and far.
        let (mut tried, mut tight) = (0, 0);
        for shape in SHAPES {
            for beta in [0.0, 1e-9, 1e-3, 0.03, 0.2, 0.5, 0.9] {
                for middle in [1e-3, 0.05, 0.3, -0.6] {
                    for half in [1e-4, 0.01, 0.05, 0.3] {
                        let inside = middle - half > 0.0 || beta > 0.0;
                        for (i, n) in
                            DEGREES.into_iter().enumerate().filter(|&(_, n)| n <= MAX_GRADIENT_DEGREE && inside)
                        {
                            let stretch = Stretch::new(beta * beta, middle, half);
                            let vectors = [[beta, 0.0, 0.0], [0.0, 1.0, 0.0]];
                            let rule = interpolation(n);
                            let at = |nodes: &[f64]| {
                                let mut sums = [[0.0; MAX_GRADIENT_DEGREE + 1]; 3];
                                shape.add_gradients(1.0, &stretch, vectors, nodes, &mut sums);
                                sums
                            };
                            let sums = at(&rule.nodes);
                            let bound = shape.gradient_remainder(&stretch).all()[i];
                            for a in 0..2 {
                                let (p, _) = rule.through(&sums[a][..=n], 0.0);
                                let off = (0..200).map(|i| -0.995 + 0.01 * f64::from(i));
                                let off = off.map(|t| (p.at(t) - at(&[t])[a][0]).abs()).fold(0.0, f64::max);
                                // Rounding of values up to 24 and, near the point, of a direction.
                                assert!(off <= bound + 1e-10, "{shape:?} {beta} {middle} {half} {n}: {off} > {bound}");
                                tried += 1;
                                tight += usize::from(off > 1e-9 && off > 1e-3 * bound);
                            }
                        }
                    }
                }
            }
        }
        // A bound that is far off everywhere would be of no use.
        assert!(tight > 50, "{tight} of {tried}");
    }
}
