//! A function along a ray.

use super::chebyshev::interpolation;
use super::line::{Chord, FieldLine, LineModel};
use super::poly::Poly;
use super::{Field, FunctionField};
use crate::bound::largest;
use crate::ray::Ray;

/// A function along a ray, interpolated between its breakpoints.
///
/// The error is bounded where the function has a Lipschitz constant ([`FunctionField::with_lipschitz`]), and falls with the length of a stretch
/// then; else it is estimated from what interpolation misses at three points of the stretch, and falls with the twelfth power.
///
/// Vacuum is seen at the points of interpolation alone. A stretch that has some of both, because vacuum begins where there is no
/// breakpoint, has an unknown error: it is halved until it is too short to matter.
#[derive(Debug)]
pub struct FunctionLine<'a> {
    field: &'a FunctionField,
    ray: Ray,
    start: f64,
    end: f64,
    gradients: bool,
}

/// Degree of the interpolating polynomial.
const DEGREE: usize = 12;
/// Distance from its ends within which a stretch is not evaluated, as a part of its half length: above the rounding of the breakpoints.
const INSIDE: f64 = 1e-9;
/// Number of parts that the line is cut into: waves must not hide between the nodes.
const PARTS: usize = 32;

impl<'a> FunctionLine<'a> {
    /// A function between two world distances along a ray.
    pub fn new(field: &'a FunctionField, ray: Ray, start: f64, end: f64) -> Self {
        Self { field, ray, start, end, gradients: false }
    }

    /// The same with gradients, where the field has them.
    pub fn with_gradients(self) -> Self {
        Self { gradients: self.field.has_gradient(), ..self }
    }
}

impl FieldLine for FunctionLine<'_> {
    fn chord(&self) -> Chord {
        Chord { start: self.start, end: self.end, offset: 0.0 }
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        let mut cuts = Vec::new();
        self.field.breakpoints(&self.ray, &mut cuts);
        cuts.retain(|&s| s > self.start && s < self.end);
        let part = |k: usize| self.start + (self.end - self.start) * k as f64 / PARTS as f64;
        cuts.extend((0..PARTS).map(part));
        cuts.push(self.end);
        cuts.sort_by(f64::total_cmp);
        out.extend(cuts);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        // Evaluate the function at the nodes, a hair inside: at a breakpoint itself the field may belong to the other side.
        let place = |t: f64| self.ray.origin + self.ray.direction * (middle + half * t * (1.0 - INSIDE));
        let nodes = &interpolation(DEGREE).nodes;
        let values: [f64; DEGREE + 1] = std::array::from_fn(|j| self.field.raw(place(nodes[j])));
        let missing = values.iter().filter(|v| v.is_nan()).count();
        if missing == values.len() {
            return None;
        }
        // An edge of the vacuum lies inside: the value beyond it is that of the nearest place where there is one.
        let known: Vec<usize> = (0..=DEGREE).filter(|&j| !values[j].is_nan()).collect();
        let filled = |j: usize| values[known[known.partition_point(|&k| k < j).min(known.len() - 1)]];
        let values: [f64; DEGREE + 1] = std::array::from_fn(|j| if values[j].is_nan() { filled(j) } else { values[j] });
        let field = Poly::through_chebyshev_points(&values);
        // Half the largest gap between nodes, times how fast function and interpolant can part.
        let gap = largest((0..DEGREE).map(|j| 0.5 * (nodes[j] - nodes[j + 1])));
        let slope = field.derivative();
        let parting = self.field.lipschitz().unwrap_or(f64::INFINITY) * half + slope.at(0.0).abs() + slope.spread(1.0);
        let certain = parting.is_finite() && missing == 0;
        const SEEN: [f64; 3] = [0.13, -0.58, 0.91];
        let apart = |truth: &dyn Fn(f64) -> f64, p: &Poly| {
            4.0 * largest(SEEN.map(|t| truth(t) - p.at(t)).into_iter().filter(|d| !d.is_nan()))
        };
        let field_error = if missing > 0 {
            f64::INFINITY
        } else if certain {
            (gap + INSIDE) * parting
        } else {
            apart(&|t| self.field.raw(place(t)), &field)
        };
        let along = self.field.raw_gradient().filter(|_| self.gradients).map(|gradient| {
            let at: [_; DEGREE + 1] = std::array::from_fn(|j| gradient(place(nodes[j])));
            std::array::from_fn(|a| Poly::through_chebyshev_points(&at.map(|g| g[a])))
        });
        let gradient_error = along.as_ref().map_or(0.0, |polys: &[Poly; 3]| {
            let gradient = self.field.raw_gradient().expect("it has just been interpolated");
            largest((0..3).map(|a| apart(&|t| gradient(place(t))[a], &polys[a])))
        });
        let certain = certain && along.is_none();
        Some(LineModel { field, field_error, gradient: along, gradient_error, limits: None, certain })
    }
}
