//! Sums of kernels on an interval of a line, and of their gradients: polynomials, with bounds on their errors.

use super::chebyshev::{LEBESGUE, interpolation};
use super::kernel_shape::{DEGREES, Shape, Stretch};
use super::kernel_slope::MAX_GRADIENT_DEGREE;
use super::point_supports::Support;
use super::poly::Poly;
use crate::bound::largest;

/// Largest error of interpolation, as a part of the field: no more than rounding.
const FINE: f64 = 1.0 / (1u64 << 46) as f64;

/// A support on an interval.
pub(super) struct Part<'a> {
    pub(super) support: &'a Support,
    stretch: Stretch,
    shape: Shape,
}

impl<'a> Part<'a> {
    pub(super) fn new(support: &'a Support, middle: f64, half: f64) -> Self {
        let along = (middle - support.nearest) * support.per_radius;
        let stretch = Stretch::new(support.square, along, half * support.per_radius);
        Self { support, stretch, shape: support.shape_at(middle) }
    }

    /// The kernel's weight in the middle of the interval.
    pub(super) fn weight(&self) -> f64 {
        self.support.weight * self.shape.at(self.stretch.distance)
    }

    /// Distance of the interval from the point, in radii; a little less, for what displaces the point.
    fn nearest(&self) -> f64 {
        (self.stretch.distance - self.stretch.half - self.support.displaced).max(0.0)
    }
}

/// A sum of kernels on an interval.
pub(super) struct Sum {
    pub(super) poly: Poly,
    /// Bound of what interpolation misses, which shorter intervals make less.
    pub(super) missed: f64,
    /// Bound of what rounding does.
    pub(super) rounded: f64,
}

impl Sum {
    pub(super) fn error(&self) -> f64 {
        self.missed + self.rounded
    }
}

/// The sum on an interval of kernels times amplitudes, by a polynomial of at most a degree.
pub(super) fn sum_of(parts: &[Part<'_>], amplitude: impl Fn(&Support) -> f64, max_degree: usize) -> Sum {
    // Bound the error of interpolation by each degree, and that of rounding.
    let degrees = DEGREES.iter().take_while(|&&n| n <= max_degree).count();
    let mut missed = [0.0; DEGREES.len()];
    // Of the field, of what rounding of r does to it, and of what moves points.
    let (mut size, mut evaluation, mut displaced) = (0.0, 0.0, 0.0);
    for part in parts {
        let (support, stretch) = (part.support, &part.stretch);
        let amplitude = amplitude(support).abs();
        let remainder = part.shape.remainder(stretch).all();
        missed.iter_mut().zip(remainder).for_each(|(sum, r)| *sum += amplitude * r);
        let nearest = part.nearest();
        let steepest = amplitude * part.shape.steepest(nearest);
        size += amplitude * part.shape.at(nearest);
        evaluation += steepest * (stretch.distance + stretch.half);
        displaced += steepest * support.displaced;
    }
    // Interpolate by the lowest degree that is as good as rounding.
    let chosen = missed[..degrees].iter().position(|&m| m <= FINE * size).unwrap_or(degrees - 1);
    let degree = DEGREES[chosen];

    let rule = interpolation(degree);
    let mut values = [0.0; DEGREES[DEGREES.len() - 1] + 1];
    for part in parts {
        part.shape.add(amplitude(part.support), &part.stretch, &rule.nodes, &mut values);
    }
    let (poly, dropped) = rule.through(&values[..=degree], f64::EPSILON * size);
    // One rounding for each term of the sum, and a few of its value; a displaced point moves the field itself.
    let rounding = f64::EPSILON * ((parts.len() + degree + 16) as f64 * size + 4.0 * evaluation);
    Sum { poly, missed: missed[chosen], rounded: dropped + LEBESGUE * rounding + displaced }
}

/// A sum of kernels' gradients on an interval, the errors being those of each component.
pub(super) struct GradientSum {
    pub(super) polys: [Poly; 3],
    pub(super) missed: f64,
    pub(super) rounded: f64,
}

impl GradientSum {
    pub(super) fn error(&self) -> f64 {
        self.missed + self.rounded
    }
}

/// The sum on an interval of kernels' gradients times amplitudes; `along` is the direction of the line.
pub(super) fn gradient_of(parts: &[Part<'_>], amplitude: impl Fn(&Support) -> f64, along: [f64; 3]) -> GradientSum {
    // Bound the error of interpolation by each degree, that of rounding, and of what moves points: by as much across the ray as along it.
    let degrees = DEGREES.iter().take_while(|&&n| n <= MAX_GRADIENT_DEGREE).count();
    let mut missed = [0.0; DEGREES.len()];
    let (mut size, mut evaluation, mut displaced) = (0.0, 0.0, 0.0);
    for part in parts {
        let (support, stretch) = (part.support, &part.stretch);
        let amplitude = amplitude(support).abs() * support.per_radius;
        let remainder = part.shape.gradient_remainder(stretch).all();
        missed.iter_mut().zip(remainder).for_each(|(sum, r)| *sum += amplitude * r);
        let nearest = part.nearest();
        let turn = part.shape.sharpest_turn(nearest);
        // Wherever the point is, two gradients are no farther apart than twice the steepest.
        let steepest = part.shape.steepest_gradient(nearest);
        size += amplitude * steepest;
        evaluation += amplitude * (turn * (stretch.distance + stretch.half)).min(steepest / f64::EPSILON);
        displaced += amplitude * (2.0 * turn * support.displaced).min(2.0 * (1.0 + LEBESGUE) * steepest);
    }
    let chosen = missed[..degrees].iter().position(|&m| m <= FINE * size).unwrap_or(degrees - 1);
    let degree = DEGREES[chosen];
    let rule = interpolation(degree);
    let mut values = [[0.0; MAX_GRADIENT_DEGREE + 1]; 3];
    for part in parts {
        let support = part.support;
        let amplitude = amplitude(support) * support.per_radius;
        part.shape.add_gradients(amplitude, &part.stretch, [support.across, along], &rule.nodes, &mut values);
    }
    let through = values.map(|values| rule.through(&values[..=degree], f64::EPSILON * size));
    let dropped = largest(through.iter().map(|(_, dropped)| *dropped));
    let rounding = f64::EPSILON * ((parts.len() + degree + 16) as f64 * size + 4.0 * evaluation);
    let rounded = dropped + LEBESGUE * rounding + displaced;
    GradientSum { polys: through.map(|(poly, _)| poly), missed: missed[chosen], rounded }
}
