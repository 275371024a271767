//! A rectilinear grid along a ray.

use super::gradients::CornerGradients;
use super::grid::RectilinearGrid;
use super::ray::RectilinearRay;
use crate::bound::{Bound, largest};
use crate::clip_error::clip_error;
use crate::field::{Chord, Cut, FieldLine, LineModel, Poly, distinct_places};
use crate::ray::{IndexRay, Ray};
use crate::shading::GradientMethod;
use crate::stretch::Stretch;
use crate::view::Clip;

/// Size of the grid of one cell that the box of a rectilinear grid is.
pub(super) const ONE_CELL: [usize; 3] = [2; 3];

/// A rectilinear grid along a ray: cut at its planes, and between two of them a cubic.
#[derive(Debug)]
pub(super) struct RectilinearLine<'a> {
    grid: &'a RectilinearGrid,
    ray: RectilinearRay<'a>,
    chord: Chord,
    gradients: bool,
    /// Bound on the error of both ends, as far as the clip sets them.
    clip_error: f64,
}

impl<'a> RectilinearLine<'a> {
    /// The field along a ray; `None` where the ray does not meet its box.
    pub(super) fn new(grid: &'a RectilinearGrid, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Self> {
        let IndexRay { start, end, offset, .. } = IndexRay::new(ray, grid.extent(), ONE_CELL, clip, far)?;
        let clip_error = largest([start, end].map(|at| clip_error(ray, clip, offset, at)));
        let chord = Chord { start, end, offset };
        let ray = RectilinearRay::new(grid, ray, offset, start.abs().max(end.abs()));
        Some(Self { grid, ray, chord, gradients, clip_error })
    }

    /// Appends the world distances between two at which vacuum begins or ends.
    pub(super) fn jumps(grid: &'a RectilinearGrid, ray: &Ray, [from, to]: [f64; 2], out: &mut Vec<f64>) {
        let Some(line) = Self::new(grid, ray, &Clip::default(), to, false) else { return };
        let Chord { start, end, offset } = line.chord;
        let start = start.max(from - offset);
        if start >= end {
            return;
        }
        out.push(start + offset);
        if grid.lattice().vacuum_cells().is_some() {
            let mut breaks = Vec::new();
            line.breakpoints(&mut breaks);
            let is_vacuum = |pair: &[f64]| line.between(pair[0], pair[1]).is_none();
            let seen = breaks.windows(3).filter(|w| w[1] > start && is_vacuum(&w[..2]) != is_vacuum(&w[1..]));
            out.extend(seen.map(|w| w[1] + offset));
        }
        out.push(end + offset);
    }

    /// The gradient on a stretch per world unit, in values, and a bound on the error of each component.
    fn gradient(
        &self,
        stretch: &Stretch,
        cell: [usize; 3],
        model: Option<[Poly; 3]>,
        model_error: f64,
    ) -> ([Poly; 3], f64) {
        let (lattice, axes) = (self.grid.lattice(), self.grid.axes());
        let slope = lattice.calibration().slope;
        let rounding = |polys: &[Poly; 3]| {
            8.0 * f64::EPSILON * largest(polys.iter().map(|p| p.coefficients()[0].abs() + p.spread(1.0)))
        };
        match model {
            // Per index step, each with the width of the cell.
            Some(per_index) => {
                let factors: [f64; 3] = std::array::from_fn(|a| slope / axes[a].width(cell[a]));
                let made = std::array::from_fn(|a| per_index[a] * factors[a]);
                let error = Bound::new(model_error) * largest(factors) + rounding(&made);
                (made, error.value())
            }
            None => {
                let corners = lattice.with_lattice(CornerGradients { axes, cell });
                let (made, error) = stretch.between_corners(cell, &corners);
                let made = made.map(|p| p * slope);
                (made, (Bound::new(error) * slope + rounding(&made)).value())
            }
        }
    }
}

impl FieldLine for RectilinearLine<'_> {
    fn chord(&self) -> Chord {
        self.chord
    }

    /// Appends the planes, each at its number on its axis.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        out.push((self.chord.start, Cut::Entry));
        self.ray.each_crossing([self.chord.start, self.chord.end], |c| {
            out.push((c.distance, Cut::Face { axis: c.axis, at: c.plane as f64 }));
        });
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        let Chord { start, end, .. } = self.chord;
        let mut faces = Vec::new();
        self.ray.each_crossing([start, end], |c| faces.push((c.distance, c.error)));
        let rounded = |at: f64| (at, self.misplaced(at) + f64::EPSILON * at.abs());
        distinct_places([rounded(start), rounded(end)], faces, out);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let analytic = self.gradients && self.grid.gradient_method() == GradientMethod::Analytic;
        let (stretch, cell) = self.ray.stretch(from, to);
        let stretch = Stretch { gradient: analytic.then_some(GradientMethod::Analytic), ..stretch };
        let model = stretch.model(self.grid.lattice())?;
        let (field, field_error) = model.calibrated(self.grid.lattice().calibration(), 0.0);
        let gradient = self.gradients.then(|| self.gradient(&stretch, cell, model.gradient, model.gradient_error));
        Some(LineModel {
            field,
            field_error: field_error.value(),
            gradient: gradient.map(|g| g.0),
            gradient_error: gradient.map_or(0.0, |g| g.1),
            limits: None,
            certain: true,
        })
    }

    fn misplaced(&self, at: f64) -> f64 {
        let is_end = at <= self.chord.start || at >= self.chord.end;
        let own = if is_end { self.clip_error } else { 0.0 };
        // Inside, the field jumps at vacuum alone.
        let jumps = is_end || self.grid.lattice().vacuum_cells().is_some();
        if jumps { own.max(self.ray.plane_error(at)) } else { own }
    }
}
