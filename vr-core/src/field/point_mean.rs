//! Weighted means of scattered points on an interval of a line: quotients of two sums of kernels, by polynomials with bounds on their errors.
//!
//! A mean is m = base + N/D with N = Σ w (v − base) W and D = Σ w W, both known as polynomials of degree 12 at most with their errors ε. Where q interpolates
//! N/D at the Chebyshev points, the residual r = N − q D is a polynomial of degree 24, which its Chebyshev coefficients bound, and
//! |N/D − q| ≤ (|r| + ε_N + |q| ε_D) / (min D − ε_D): a bound without derivatives, which holds however near the poles are. A mean lies between the values
//! besides, which is all that is said of it where D vanishes. The gradient (∇N − (N/D) ∇D) / D is bounded likewise.

use super::chebyshev::{LEBESGUE, interpolation};
use super::kernel_slope::MAX_GRADIENT_DEGREE;
use super::point_sums::{GradientSum, Part, Sum, gradient_of, sum_of};
use super::point_supports::Support;
use super::poly::{MAX_DEGREE, Poly};
use crate::bound::largest;

/// Degree of sums and of quotients, so that a residual has one that polynomials may have.
const DEGREE: usize = MAX_GRADIENT_DEGREE;

/// Error of interpolation that calls for a shorter interval, as a part of the range of what is averaged.
const FINE_MEAN: f64 = 1.0 / (1u64 << 38) as f64;

/// The points that reach into an interval.
pub(super) struct MeanPiece<'a> {
    parts: &'a [Part<'a>],
    /// Number of the point that weighs most in the middle.
    heaviest: u32,
    /// Σ w W, its smallest value and its largest.
    weight: Sum,
    range: [f64; 2],
}

impl<'a> MeanPiece<'a> {
    pub(super) fn new(parts: &'a [Part<'a>]) -> Self {
        let heaviest = parts.iter().max_by(|a, b| a.weight().total_cmp(&b.weight()));
        let heaviest = heaviest.map_or(0, |part| part.support.point);
        let weight = sum_of(parts, |s| s.weight, DEGREE);
        let (constant, spread) = size_of(|t| weight.poly.at(t));
        Self { parts, heaviest, range: [constant - spread, constant + spread], weight }
    }

    /// The mean of what the points carry.
    pub(super) fn of<F: Fn(u32) -> f64>(&'a self, carried: F) -> Mean<'a, F> {
        let base = carried(self.heaviest);
        let values = self.parts.iter().map(|part| carried(part.support.point));
        let (low, high) = values.fold((base, base), |(l, h), v| (l.min(v), h.max(v)));
        let mut mean = Mean {
            piece: self,
            carried,
            base,
            poly: Poly::constant(base),
            missed: 0.0,
            rounded: 0.0,
            quotient: Poly::constant(0.0),
            limits: None,
            width: high - low,
        };
        // If all points carry the same value, the mean is that value.
        if low == high {
            return mean;
        }
        mean.limits = Some([low, high]);
        let sum = sum_of(self.parts, |s| mean.amplitude(s), DEGREE);
        let quotient = self.quotient(|t| sum.poly.at(t), [sum.missed, sum.rounded]);
        if quotient.missed + quotient.rounded <= 0.5 * mean.width {
            mean.quotient = quotient.poly;
            mean.poly = quotient.poly + Poly::constant(base);
            mean.missed = quotient.missed;
            mean.rounded = quotient.rounded + f64::EPSILON * (base.abs() + mean.width);
        } else {
            // No more is known than the values on both sides; what calls for more is the quotient's reason.
            mean.quotient = Poly::constant(0.5 * (low + high) - base);
            mean.poly = Poly::constant(0.5 * (low + high));
            let half = 0.5 * mean.width + f64::EPSILON * (low.abs() + high.abs());
            let by_interpolation = quotient.missed > quotient.rounded;
            (mean.missed, mean.rounded) = if by_interpolation { (half, 0.0) } else { (0.0, half) };
        }
        mean
    }

    /// A quotient by the sum of weights, where errors of its numerator are bounded: of what interpolation misses, and of rounding.
    fn quotient(&self, numerator: impl Fn(f64) -> f64, [missed, rounded]: [f64; 2]) -> Quotient {
        let rule = interpolation(DEGREE);
        let weight = |t: f64| self.weight.poly.at(t);
        let values: Vec<f64> = rule.nodes.iter().map(|&t| numerator(t) / weight(t)).collect();
        let (poly, _) = rule.through(&values, 0.0);
        let [smallest, largest_weight] = self.range;
        let smallest = smallest - self.weight.error();
        let (constant, spread) = size_of(|t| poly.at(t));
        let size = constant.abs() + spread;
        let (constant, spread) = size_of(|t| numerator(t) - poly.at(t) * weight(t));
        let residual = constant.abs() + spread;
        // Values of three polynomials of degree 12, and the sums that find 25 coefficients of them.
        let evaluation = 64.0 * f64::EPSILON * LEBESGUE * size * largest_weight;
        if !(smallest > 0.0 && size.is_finite()) {
            // The weights may vanish by their variation, which shorter intervals have less of, or by rounding.
            let by_rounding = self.weight.rounded >= 0.25 * largest_weight;
            let unknown = f64::INFINITY;
            let (missed, rounded) = if by_rounding { (0.0, unknown) } else { (unknown, 0.0) };
            return Quotient { poly, missed, rounded };
        }
        Quotient {
            poly,
            missed: (residual + missed + size * self.weight.missed) / smallest,
            rounded: (evaluation + rounded + size * self.weight.rounded) / smallest,
        }
    }
}

/// A quotient on an interval, and bounds of its errors.
struct Quotient {
    poly: Poly,
    missed: f64,
    rounded: f64,
}

/// The constant of a polynomial of degree 24 at most on [−1, 1], and a bound of its distance from that: the sum of its other Chebyshev coefficients.
fn size_of(poly: impl Fn(f64) -> f64) -> (f64, f64) {
    let rule = interpolation(MAX_DEGREE);
    let values: Vec<f64> = rule.nodes.iter().map(|&t| poly(t)).collect();
    rule.constant_and_spread(&values)
}

/// A mean on an interval.
pub(super) struct Mean<'a, F> {
    piece: &'a MeanPiece<'a>,
    carried: F,
    base: f64,
    /// The mean itself.
    pub(super) poly: Poly,
    /// Bound of what interpolation misses.
    missed: f64,
    /// Bound of what rounding does.
    rounded: f64,
    /// The mean less its base.
    quotient: Poly,
    /// Smallest and largest value of the points; `None` where they are one.
    pub(super) limits: Option<[f64; 2]>,
    width: f64,
}

impl<F: Fn(u32) -> f64> Mean<'_, F> {
    pub(super) fn error(&self) -> f64 {
        self.missed + self.rounded
    }

    /// True if a shorter interval would be known better, and it matters.
    pub(super) fn needs_refinement(&self) -> bool {
        self.missed > FINE_MEAN * self.width && self.missed > self.rounded
    }

    /// w (v − base).
    fn amplitude(&self, support: &Support) -> f64 {
        support.weight * ((self.carried)(support.point) - self.base)
    }

    /// The gradient of the mean; `along` is the direction of the line.
    pub(super) fn gradient(&self, along: [f64; 3]) -> MeanGradient {
        let piece = self.piece;
        if self.limits.is_none() {
            return MeanGradient { polys: [Poly::constant(0.0); 3], missed: 0.0, rounded: 0.0, size: 0.0 };
        }
        let rise = gradient_of(piece.parts, |s| self.amplitude(s), along);
        let thinning = gradient_of(piece.parts, |s| s.weight, along);
        let bound = |sum: &GradientSum| largest(sum.polys.iter().map(|p| p.coefficients()[0].abs() + p.spread(1.0)));
        // The quotient is off as the mean is, and multiplies what weights lose.
        let (constant, spread) = size_of(|t| self.quotient.at(t));
        let (size, thins) = (constant.abs() + spread, bound(&thinning) + thinning.error());
        let missed = rise.missed + size * thinning.missed + self.missed * thins;
        let evaluation = 64.0 * f64::EPSILON * LEBESGUE * (bound(&rise) + size * thins);
        let rounded = rise.rounded + size * thinning.rounded + self.rounded * thins + evaluation;
        let quotients = [0, 1, 2].map(|a| {
            let numerator = |t: f64| rise.polys[a].at(t) - self.quotient.at(t) * thinning.polys[a].at(t);
            piece.quotient(numerator, [missed, rounded])
        });
        let size = largest(quotients.iter().map(|q| q.poly.coefficients()[0].abs() + q.poly.spread(1.0)));
        MeanGradient {
            missed: largest(quotients.iter().map(|q| q.missed)),
            rounded: largest(quotients.iter().map(|q| q.rounded)),
            polys: quotients.map(|q| q.poly),
            size,
        }
    }
}

/// The gradient of a mean on an interval, the errors being those of each component.
pub(super) struct MeanGradient {
    pub(super) polys: [Poly; 3],
    missed: f64,
    rounded: f64,
    /// Bound of the components.
    size: f64,
}

impl MeanGradient {
    pub(super) fn error(&self) -> f64 {
        self.missed + self.rounded
    }

    /// True if a shorter interval would be known better, and it matters.
    pub(super) fn needs_refinement(&self) -> bool {
        self.missed > FINE_MEAN * self.size && self.missed > self.rounded
    }
}

/// Adds breakpoints closer and closer to where one point reaches alone, in quarters of the piece beyond: a mean's gradient, which there is none of
/// on this side, vanishes on the other with a power of the distance, and on a short piece its direction has all its digits.
pub(super) fn graded(cuts: &[f64], numbers: &[usize], out: &mut Vec<f64>) {
    const QUARTERINGS: i32 = 20;
    let alone = |piece: Option<usize>| piece.and_then(|i| numbers.get(i)).is_none_or(|&n| n <= 1);
    for (i, ends) in cuts.windows(2).enumerate().filter(|&(i, _)| numbers[i] > 1) {
        let [from, to] = [ends[0], ends[1]];
        for k in 1..=QUARTERINGS {
            let near = (to - from) * 0.25f64.powi(k);
            out.extend(alone(i.checked_sub(1)).then_some(from + near));
            out.extend(alone(Some(i + 1)).then_some(to - near));
        }
    }
    out.sort_unstable_by(f64::total_cmp);
    out.dedup();
}

/// Halves the pieces between breakpoints as long as they need it.
pub(super) fn refined(cuts: &[f64], needs: impl Fn(f64, f64) -> bool) -> Vec<f64> {
    // A piece shorter than this part of its distances is one of rounding.
    const SHORTEST: f64 = 64.0 * f64::EPSILON;
    const MAX_HALVINGS: u32 = 40;
    const MAX_PIECES: usize = 1 << 16;
    let mut out = Vec::with_capacity(2 * cuts.len());
    for ends in cuts.windows(2) {
        // Pieces still to be looked at, the nearest last.
        let mut left = vec![(ends[0], ends[1], 0)];
        while let Some((from, to, halvings)) = left.pop() {
            let middle = 0.5 * (from + to);
            let is_long = to - from > SHORTEST * from.abs().max(to.abs()) && halvings < MAX_HALVINGS;
            if is_long && out.len() + left.len() < MAX_PIECES && needs(from, to) {
                left.extend([(middle, to, halvings + 1), (from, middle, halvings + 1)]);
            } else {
                out.push(from);
            }
        }
    }
    out.extend(cuts.last());
    out
}
