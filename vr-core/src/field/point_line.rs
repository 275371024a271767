//! Scattered points along a ray: a sum of kernels, each smooth between the spheres that bound it.

use super::chebyshev::{LEBESGUE, interpolation};
use super::kernel_shape::{DEGREES, Shape, Stretch, factor};
use super::kernel_slope::{MAX_GRADIENT_DEGREE, jumps_at_edge};
use super::line::{Chord, Cut, FieldLine, LineModel};
use super::point_supports::{Support, cuts, members};
use super::poly::Poly;
use crate::bound::largest;
use crate::point_field::PointCrossing;
use crate::point_kernel::PointKernel;
use crate::point_set::PointSet;
use crate::ray::Ray;
use crate::view::Clip;

/// The field of scattered points along a ray: f = Σ wₖ vₖ W(|x − xₖ|/Rₖ)/Rₖ³.
///
/// Breakpoints are where the ray enters and leaves supports and, in them, crosses spheres on which the kernel is not smooth. Between them
/// the sum is interpolated at Chebyshev points; the bound is the sum of what interpolation misses of each kernel (see
/// `kernel_shape`), of rounding, and of how far rounding displaces points. Where a kernel bends sharply beside its point, further
/// breakpoints are added, closer and closer to it, unless those of other points are close already.
///
/// The gradient is interpolated likewise, between breakpoints that are closer together. It jumps where the ray enters or leaves a support of a cone or a
/// Gaussian.
///
/// Distances are world units behind the offset of its [`Chord`](crate::field::Chord::offset).
#[derive(Clone, Debug)]
pub struct PointLine {
    supports: Vec<Support>,
    /// Breakpoints, ascending.
    cuts: Vec<f64>,
    /// The supports of piece i, between cuts i and i + 1, are `inside[first[i]..first[i + 1]]`.
    first: Vec<usize>,
    inside: Vec<u32>,
    offset: f64,
    /// Direction of the ray, where gradients are asked for.
    gradients_along: Option<[f64; 3]>,
    /// Places at which the gradient jumps, ascending, with the largest displacement of each by rounding.
    jumps: Vec<(f64, f64)>,
}

/// Largest error of interpolation, as a part of the field: no more than rounding.
const FINE: f64 = 1.0 / (1u64 << 46) as f64;

impl PointLine {
    /// The field along a ray, within the clip and up to the world distance `far` (an opaque layer, say); `None` where it meets no support.
    pub fn new(points: &PointSet, ray: &Ray, clip: &Clip, far: f64) -> Option<Self> {
        Self::build(points, ray, clip, far, false)
    }

    /// The same with the gradient.
    pub fn with_gradients(points: &PointSet, ray: &Ray, clip: &Clip, far: f64) -> Option<Self> {
        Self::build(points, ray, clip, far, true)
    }

    fn build(points: &PointSet, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Self> {
        let [from, to] = ray.inside(clip)?;
        let to = to.min(far);
        if from >= to {
            return None;
        }
        let crossings = points.crossings(ray, [from, to]);
        let kernel = points.kernel();
        let factor = factor(kernel);
        let support = |c: &PointCrossing| {
            let k = c.point as usize;
            let radius = f64::from(points.radii()[k]);
            let inner = 0.5 * radius;
            let core = if kernel == PointKernel::CubicSpline && c.distance < inner {
                ((inner - c.distance) * (inner + c.distance)).sqrt()
            } else {
                0.0
            };
            let beta = c.distance / radius;
            Support {
                nearest: c.nearest,
                half: c.half,
                core,
                across: (c.across / radius).to_array(),
                square: beta * beta,
                per_radius: 1.0 / radius,
                amplitude: factor * points.amplitude(k),
                displaced: c.error / radius,
                kernel,
            }
        };
        let supports: Vec<Support> = crossings.all.iter().map(support).collect();
        let begin = supports.iter().map(|s| s.nearest - s.half).reduce(f64::min)?;
        let end = supports.iter().map(|s| s.nearest + s.half).reduce(f64::max)?;
        let ends = [begin.max(from - crossings.offset), end.min(to - crossings.offset)];
        if ends[0] >= ends[1] {
            return None;
        }
        let cuts = cuts(&supports, ends, gradients);
        let (first, inside) = members(&supports, &cuts);
        let mut jumps = Vec::new();
        if gradients && jumps_at_edge(kernel) {
            let edges = |s: &Support| [-1.0, 1.0].map(|side| (s.nearest + side * s.half, s.misplaced_edge()));
            jumps.extend(supports.iter().flat_map(edges));
            jumps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        }
        let gradients_along = gradients.then(|| ray.direction.to_array());
        Some(Self { supports, cuts, first, inside, offset: crossings.offset, gradients_along, jumps })
    }
}

impl FieldLine for PointLine {
    fn chord(&self) -> Chord {
        Chord { start: self.cuts[0], end: self.cuts[self.cuts.len() - 1], offset: self.offset }
    }

    /// Appends the places at which the ray comes out of vacuum: spheres are far too many to name.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        let empty = |i: usize| self.first[i] == self.first[i + 1];
        let entries = (0..self.cuts.len() - 1).filter(|&i| !empty(i) && (i == 0 || empty(i - 1)));
        out.extend(entries.map(|i| (self.cuts[i], Cut::Entry)));
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        out.extend_from_slice(&self.cuts);
    }

    /// Returns the displacement of a place at which the gradient jumps; of breakpoints that do not move the field it is 0.
    fn misplaced(&self, at: f64) -> f64 {
        let first = self.jumps.partition_point(|jump| jump.0 < at);
        self.jumps[first..].iter().take_while(|jump| jump.0 == at).fold(0.0, |off, jump| off.max(jump.1))
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let piece = self.cuts.partition_point(|&c| c <= middle).clamp(1, self.cuts.len() - 1) - 1;
        let inside = &self.inside[self.first[piece]..self.first[piece + 1]];
        if inside.is_empty() {
            return None;
        }
        let parts: Vec<Part> = inside.iter().map(|&k| Part::new(&self.supports[k as usize], middle, half)).collect();
        // Bound the error of interpolation by each degree, and that of rounding.
        let mut missed = [0.0; DEGREES.len()];
        // Of the field, of what rounding of r does to it, and of what moves points.
        let (mut size, mut evaluation, mut displaced) = (0.0, 0.0, 0.0);
        for (k, part) in inside.iter().zip(&parts) {
            let (support, stretch) = (&self.supports[*k as usize], &part.stretch);
            let amplitude = support.amplitude.abs();
            let remainder = part.shape.remainder(stretch).all();
            missed.iter_mut().zip(remainder).for_each(|(sum, r)| *sum += amplitude * r);
            let nearest = (stretch.distance - stretch.half - support.displaced).max(0.0);
            let steepest = amplitude * part.shape.steepest(nearest);
            size += amplitude * part.shape.at(nearest);
            evaluation += steepest * (stretch.distance + stretch.half);
            displaced += steepest * support.displaced;
        }
        // Interpolate by the lowest degree that is as good as rounding.
        let chosen = missed.iter().position(|&m| m <= FINE * size).unwrap_or(DEGREES.len() - 1);
        let degree = DEGREES[chosen];

        let rule = interpolation(degree);
        let mut values = [0.0; DEGREES[DEGREES.len() - 1] + 1];
        for part in &parts {
            part.shape.add(part.amplitude, &part.stretch, &rule.nodes, &mut values);
        }
        let (field, dropped) = rule.through(&values[..=degree], f64::EPSILON * size);
        // One rounding for each term of the sum, and a few of its value; a displaced point moves the field itself.
        let rounding = f64::EPSILON * ((parts.len() + degree + 16) as f64 * size + 4.0 * evaluation);
        let field_error = missed[chosen] + dropped + LEBESGUE * rounding + displaced;
        let (gradient, gradient_error) = self.gradients_along.map_or((None, 0.0), |along| {
            let (gradient, error) = self.gradient_of(inside, &parts, along);
            (Some(gradient), error)
        });
        Some(LineModel { field, field_error, gradient, gradient_error, limits: None, certain: true })
    }
}

impl PointLine {
    /// The gradient on an interval with some supports, and the error of its components.
    fn gradient_of(&self, inside: &[u32], parts: &[Part], along: [f64; 3]) -> ([Poly; 3], f64) {
        // Bound the error of interpolation by each degree, that of rounding, and of what moves points: by as much across the ray as along it.
        let degrees = DEGREES.iter().take_while(|&&n| n <= MAX_GRADIENT_DEGREE).count();
        let mut missed = [0.0; DEGREES.len()];
        let (mut size, mut evaluation, mut displaced) = (0.0, 0.0, 0.0);
        for (k, part) in inside.iter().zip(parts) {
            let (support, stretch) = (&self.supports[*k as usize], &part.stretch);
            let amplitude = support.amplitude.abs() * support.per_radius;
            let remainder = part.shape.gradient_remainder(stretch).all();
            missed.iter_mut().zip(remainder).for_each(|(sum, r)| *sum += amplitude * r);
            let nearest = (stretch.distance - stretch.half - support.displaced).max(0.0);
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
        for (k, part) in inside.iter().zip(parts) {
            let support = &self.supports[*k as usize];
            let amplitude = part.amplitude * support.per_radius;
            part.shape.add_gradients(amplitude, &part.stretch, [support.across, along], &rule.nodes, &mut values);
        }
        let through = values.map(|values| rule.through(&values[..=degree], f64::EPSILON * size));
        let dropped = largest(through.iter().map(|(_, dropped)| *dropped));
        let rounding = f64::EPSILON * ((parts.len() + degree + 16) as f64 * size + 4.0 * evaluation);
        (through.map(|(poly, _)| poly), missed[chosen] + dropped + LEBESGUE * rounding + displaced)
    }
}

/// A support on an interval.
struct Part {
    stretch: Stretch,
    shape: Shape,
    amplitude: f64,
}

impl Part {
    fn new(s: &Support, middle: f64, half: f64) -> Self {
        let stretch = Stretch::new(s.square, (middle - s.nearest) * s.per_radius, half * s.per_radius);
        Self { stretch, shape: s.shape_at(middle), amplitude: s.amplitude }
    }
}
