//! Scattered points along a ray: kernels, each smooth between the spheres that bound it, whose values are summed or averaged.

use super::kernel_shape::factor;
use super::kernel_slope::jumps_at_edge;
use super::line::{Chord, Cut, FieldLine, LineColor, LineModel};
use super::point_mean::{MeanPiece, graded, refined};
use super::point_sums::{Part, gradient_of, sum_of};
use super::point_supports::{Support, cuts, members};
use crate::bound::largest;
use crate::point_field::PointCrossing;
use crate::point_kernel::PointKernel;
use crate::point_mixing::PointMixing;
use crate::point_set::PointSet;
use crate::ray::Ray;
use crate::view::Clip;

/// The field of scattered points along a ray: f = Σ wₖ vₖ W(|x − xₖ|/Rₖ)/Rₖ³, or that divided by the same sum of the weights alone.
///
/// Breakpoints are where the ray enters and leaves supports and, in them, crosses spheres on which the kernel is not smooth. Between them
/// the sum is interpolated at Chebyshev points; the bound is the sum of what interpolation misses of each kernel (see
/// `kernel_shape`), of rounding, and of how far rounding displaces points. Where a kernel bends sharply beside its point, further
/// breakpoints are added, closer and closer to it, unless those of other points are close already.
///
/// The gradient is interpolated likewise, between breakpoints that are closer together. It jumps where the ray enters or leaves a support of a cone or a
/// Gaussian.
///
/// A mean, of values or of colours, is a quotient of two such sums (see `point_mean`): between breakpoints a rational function, where there are as many as
/// its interpolation by a polynomial asks for. Where one point reaches alone, it is constant. It begins and ends with the vacuum with a jump.
///
/// Distances are world units behind the offset of its [`Chord`](crate::field::Chord::offset).
#[derive(Clone, Debug)]
pub struct PointLine<'a> {
    points: &'a PointSet,
    supports: Vec<Support>,
    /// Breakpoints, ascending.
    cuts: Vec<f64>,
    /// The supports of piece i, between cuts i and i + 1, are `inside[first[i]..first[i + 1]]`.
    first: Vec<usize>,
    inside: Vec<u32>,
    offset: f64,
    /// Direction of the ray, where gradients are asked for.
    gradients_along: Option<[f64; 3]>,
    /// Places at which the field or its gradient jumps, ascending, with the largest displacement of each by rounding.
    jumps: Vec<(f64, f64)>,
}

impl<'a> PointLine<'a> {
    /// The field along a ray, within the clip and up to the world distance `far` (an opaque layer, say); `None` where it meets no support.
    pub fn new(points: &'a PointSet, ray: &Ray, clip: &Clip, far: f64) -> Option<Self> {
        Self::build(points, ray, clip, far, false)
    }

    /// The same with the gradient.
    pub fn with_gradients(points: &'a PointSet, ray: &Ray, clip: &Clip, far: f64) -> Option<Self> {
        Self::build(points, ray, clip, far, true)
    }

    fn build(points: &'a PointSet, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Self> {
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
                weight: factor * points.weight_density(k),
                point: c.point,
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
        // A mean's polynomials have the degrees of gradients, and want breakpoints as close.
        let is_mean = points.mixing() == PointMixing::Mean;
        let divides = is_mean || points.colors().is_some();
        let cuts = cuts(&supports, ends, gradients || divides);
        let (first, inside) = members(&supports, &cuts);
        // A cone's and a Gaussian's gradient jumps at the edge of a support; that of a mean, and the mean itself, where another point reaches alone, or none.
        let mut jumps = Vec::new();
        if gradients && jumps_at_edge(kernel) || divides {
            let edges = |s: &Support| [-1.0, 1.0].map(|side| (s.nearest + side * s.half, s.misplaced_edge()));
            jumps.extend(supports.iter().flat_map(edges));
            jumps.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        }
        let gradients_along = gradients.then(|| ray.direction.to_array());
        let mut line = Self { points, supports, cuts, first, inside, offset: crossings.offset, gradients_along, jumps };
        if divides {
            line.refine(gradients && is_mean);
        }
        Some(line)
    }

    /// Adds the breakpoints that means ask for; closer and closer to where a gradient begins, if one is asked for.
    fn refine(&mut self, gradients: bool) {
        let numbers: Vec<usize> = self.first.windows(2).map(|w| w[1] - w[0]).collect();
        let mut cuts = self.cuts.clone();
        if gradients {
            graded(&self.cuts, &numbers, &mut cuts);
        }
        let needs = |from: f64, to: f64| {
            let parts = self.parts(from, to);
            let mean = MeanPiece::new(&parts);
            let value = (self.points.mixing() == PointMixing::Mean).then(|| {
                let mean = mean.of(|point| self.value(point));
                let slope = self.gradients_along.map(|along| mean.gradient(along).needs_refinement());
                mean.needs_refinement() || slope == Some(true)
            });
            let color = |c: usize| self.points.colors().is_some_and(|all| mean.of(channel(all, c)).needs_refinement());
            value == Some(true) || (0..3).any(color)
        };
        self.cuts = refined(&cuts, needs);
        (self.first, self.inside) = members(&self.supports, &self.cuts);
    }

    /// The value of a point.
    fn value(&self, point: u32) -> f64 {
        f64::from(self.points.values()[point as usize])
    }

    /// The supports on an interval that no breakpoint separates.
    fn parts(&self, from: f64, to: f64) -> Vec<Part<'_>> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let piece = self.cuts.partition_point(|&c| c <= middle).clamp(1, self.cuts.len() - 1) - 1;
        let inside = &self.inside[self.first[piece]..self.first[piece + 1]];
        inside.iter().map(|&k| Part::new(&self.supports[k as usize], middle, half)).collect()
    }
}

/// A channel of points' colours.
fn channel(colors: &[[f32; 3]], c: usize) -> impl Fn(u32) -> f64 + '_ {
    move |point| f64::from(colors[point as usize][c])
}

impl FieldLine for PointLine<'_> {
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

    /// Returns the displacement of a place at which the field or its gradient jumps; of breakpoints that do not move the field it is 0.
    fn misplaced(&self, at: f64) -> f64 {
        let first = self.jumps.partition_point(|jump| jump.0 < at);
        self.jumps[first..].iter().take_while(|jump| jump.0 == at).fold(0.0, |off, jump| off.max(jump.1))
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let parts = self.parts(from, to);
        if parts.is_empty() {
            return None;
        }
        if self.points.mixing() == PointMixing::Mean {
            let mean = MeanPiece::new(&parts);
            let mean = mean.of(|point| self.value(point));
            let gradient = self.gradients_along.map(|along| mean.gradient(along));
            return Some(LineModel {
                field: mean.poly,
                field_error: mean.error(),
                gradient_error: gradient.as_ref().map_or(0.0, |gradient| gradient.error()),
                gradient: gradient.map(|gradient| gradient.polys),
                limits: mean.limits,
                certain: true,
            });
        }
        let sum = sum_of(&parts, |s| s.amplitude, usize::MAX);
        let (gradient, gradient_error) = self.gradients_along.map_or((None, 0.0), |along| {
            let gradient = gradient_of(&parts, |s| s.amplitude, along);
            (Some(gradient.polys), gradient.error())
        });
        let (field, field_error) = (sum.poly, sum.error());
        Some(LineModel { field, field_error, gradient, gradient_error, limits: None, certain: true })
    }

    fn color(&self, from: f64, to: f64) -> Option<LineColor> {
        let colors = self.points.colors()?;
        let parts = self.parts(from, to);
        if parts.is_empty() {
            return None;
        }
        let mean = MeanPiece::new(&parts);
        let means = [0, 1, 2].map(|c| mean.of(channel(colors, c)));
        let error = largest(means.iter().map(|mean| mean.error()));
        Some(LineColor { channels: means.map(|mean| mean.poly), error })
    }
}
