//! A labelled grid along a ray.

use glam::DVec3;

use super::labelled_grid::{LabelCode, LabelledGrid};
use super::lattice_ray::{Crossed, LatticeRay};
use crate::bound::{Bound, largest};
use crate::clip_error::clip_error;
use crate::field::{Chord, Cut, Field, FieldLine, LEBESGUE, LineModel, Poly, distinct_places, interpolation};
use crate::filter::Filter;
use crate::ray::{IndexRay, Ray};
use crate::shading::GradientMethod;
use crate::stretch::Stretch;
use crate::view::Clip;

/// A labelled grid along a ray: cut at the faces of the grid's cells and at every change of the label, and between them the grid's own
/// polynomial, shifted to the band of the label.
#[derive(Debug)]
pub(super) struct LabelledLine<'a> {
    field: &'a LabelledGrid,
    grid: LatticeRay,
    labels: LatticeRay,
    chord: Chord,
    gradients: bool,
    /// Bound on the error of both ends, as far as the clip sets them.
    clip_error: f64,
}

impl<'a> LabelledLine<'a> {
    /// The field along a ray; `None` where the ray does not meet its box.
    pub(super) fn new(field: &'a LabelledGrid, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Self> {
        let volume = &field.volume;
        let IndexRay { start, end, offset, .. } = IndexRay::new(ray, volume.placement(), volume.dims(), clip, far)?;
        let chord = Chord { start, end, offset };
        let farthest = start.abs().max(end.abs());
        let clip_error = [start, end].map(|at| clip_error(ray, clip, offset, at));
        Some(Self {
            field,
            grid: LatticeRay::new(ray, volume.placement(), offset, farthest),
            labels: LatticeRay::new(ray, field.labels.placement(), offset, farthest),
            chord,
            gradients,
            clip_error: clip_error[0].max(clip_error[1]),
        })
    }

    /// Appends the world distances between two at which the field jumps: the ends of the grid's box, changes of the label's code and, under the
    /// nearest filter, of the voxel.
    pub(super) fn jumps(field: &LabelledGrid, ray: &Ray, [from, to]: [f64; 2], out: &mut Vec<f64>) {
        let volume = &field.volume;
        let inside = IndexRay::new(ray, volume.placement(), volume.dims(), &Clip::default(), f64::INFINITY);
        let Some(IndexRay { start, end, offset, .. }) = inside else { return };
        let (start, end) = (start + offset, end + offset);
        let part = [from.max(start), to.min(end)];
        if part[0] >= part[1] {
            return;
        }
        let first = out.len();
        // Light may meet a label in the very face of the box.
        out.push(part[0]);
        let labels = LatticeRay::new(ray, field.labels.placement(), 0.0, part[1].abs());
        each_jump(field, &labels, part, |face| out.push(face.distance));
        out.push(part[1]);
        if volume.filter() == Filter::Nearest {
            let grid = LatticeRay::new(ray, volume.placement(), 0.0, part[1].abs());
            grid.each_face(0.5, part, |face| out.push(face.distance));
            out[first..].sort_by(f64::total_cmp);
        }
    }

    /// Shifts from the lattice of the faces at which the grid's polynomial changes.
    fn grid_shifts(&self) -> &'static [f64] {
        let central = self.gradients && self.field.gradient == GradientMethod::CentralDifferences;
        match (self.field.volume.filter(), central || self.field.volume.vacuum_cells().is_some()) {
            (Filter::Nearest, false) => &[0.5],
            (Filter::Nearest, true) => &[0.0, 0.5],
            _ => &[0.0],
        }
    }

    /// True if the polynomial of a region's gradient changes at faces that are not among the grid's own.
    fn has_region_faces(&self) -> bool {
        let own = self.field.shared && self.grid_shifts().contains(&0.0);
        self.gradients && self.field.has_solids() && !own
    }

    fn each_face(&self, mut each: impl FnMut(Crossed)) {
        let part = [self.chord.start, self.chord.end];
        for &shift in self.grid_shifts() {
            self.grid.each_face(shift, part, &mut each);
        }
        each_jump(self.field, &self.labels, part, &mut each);
        if self.has_region_faces() {
            self.labels.each_face(0.0, part, &mut each);
        }
    }

    /// Code in the middle of a stretch, and false if rounding leaves open which code holds there.
    fn code(&self, from: f64, to: f64) -> (LabelCode, bool) {
        let (map, field) = (&self.field.labels, self.field);
        let here = field.code(map.rank_near(self.labels.at(0.5 * (from + to))));
        let mut sure = true;
        self.labels.each_tie(from, to, |sides| {
            sure &= sides.iter().all(|&side| field.code(map.rank_near(side)) == here);
        });
        (here, sure)
    }

    /// The model of a stretch of which nothing is known.
    fn unknown(&self) -> LineModel {
        let (low, high) = self.field.value_range().unwrap_or_default();
        LineModel {
            field: Poly::constant(0.5 * (low + high)),
            field_error: f64::INFINITY,
            gradient: self.gradients.then_some([Poly::constant(0.0); 3]),
            gradient_error: f64::INFINITY,
            limits: None,
            certain: true,
        }
    }

    /// The model of a solid stretch.
    fn solid(&self, from: f64, to: f64, code: LabelCode, value: f64) -> LineModel {
        let (mut gradient, mut gradient_error) = (None, 0.0);
        if self.gradients {
            // Inside a cell each component is a cubic.
            let (middle, half) = self.labels.middle_and_half(from, to);
            let cell = self.field.boundary(middle, code);
            let rule = interpolation(3);
            let at: Vec<DVec3> =
                rule.nodes.iter().map(|&t| self.field.region_gradient(cell.gradient(middle + half * t))).collect();
            let size = largest(at.iter().map(|g| g.abs().max_element()));
            let made: [(Poly, f64); 3] = std::array::from_fn(|a| {
                let values: Vec<f64> = at.iter().map(|g| g[a]).collect();
                rule.through(&values, f64::EPSILON * size)
            });
            let norm = self.field.region_gradient(DVec3::ONE).abs().max_element();
            let displaced = 4.0 * norm * self.labels.position_error();
            let rounding = 64.0 * f64::EPSILON * (norm + size);
            gradient_error =
                if size == 0.0 { 0.0 } else { LEBESGUE * (rounding + displaced) + largest(made.map(|m| m.1)) };
            gradient = Some(made.map(|m| m.0));
        }
        LineModel {
            field: Poly::constant(value),
            field_error: 0.0,
            gradient,
            gradient_error,
            limits: None,
            certain: true,
        }
    }

    /// The model of a stretch of the grid, its values shifted by `offset`.
    fn shifted(&self, from: f64, to: f64, offset: f64) -> Option<LineModel> {
        let volume = &self.field.volume;
        let (middle, half) = self.grid.middle_and_half(from, to);
        let stretch = Stretch {
            middle,
            half,
            position_error: self.grid.position_error(),
            gradient: self.gradients.then_some(self.field.gradient),
        };
        let model = stretch.model(volume)?;
        let slope = volume.calibration().slope;
        let (field, mut field_error) = model.calibrated(volume.calibration(), offset);
        if volume.filter() == Filter::Nearest {
            // The stretch may run along a face between two voxels.
            self.grid.each_tie(from, to, |sides| {
                let [a, b] = sides.map(|side| {
                    Stretch { middle: side, half: DVec3::ZERO, gradient: None, ..stretch }
                        .model(volume)
                        .map(|m| m.field.at(0.0))
                });
                if a != b {
                    field_error = Bound::UNKNOWN;
                }
            });
        }
        let to_world = volume.placement().inverse_axes().transpose() * slope;
        let rows = [0, 1, 2].map(|r| to_world.row(r));
        let gradient = model.gradient.map(|g| rows.map(|row| g[0] * row.x + g[1] * row.y + g[2] * row.z));
        let gradient_error = model.gradient.map_or(0.0, |g| {
            let norm = largest(rows.map(|r| r.abs().element_sum()));
            let size = largest(g.map(|p| p.coefficients()[0].abs() + p.spread(1.0)));
            (Bound::new(model.gradient_error) + 8.0 * f64::EPSILON * size).value() * norm
        });
        let field_error = field_error.value();
        Some(LineModel { field, field_error, gradient, gradient_error, limits: None, certain: model.certain })
    }
}

/// Calls `each` with every face at which the code of the label changes.
fn each_jump(field: &LabelledGrid, labels: &LatticeRay, part: [f64; 2], mut each: impl FnMut(Crossed)) {
    labels.each_change(&field.labels, part, |face, [before, behind]| {
        if field.code(before) != field.code(behind) {
            each(face);
        }
    });
}

impl FieldLine for LabelledLine<'_> {
    fn chord(&self) -> Chord {
        self.chord
    }

    /// Appends the faces of the grid's cells, and those at which the label changes, each on an index axis of its own lattice.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        out.push((self.chord.start, Cut::Entry));
        self.each_face(|face| out.push((face.distance, Cut::Face { axis: face.axis, at: face.at })));
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        let mut faces = Vec::new();
        self.each_face(|face| faces.push((face.distance, face.error)));
        let Chord { start, end, .. } = self.chord;
        let rounded = |at: f64| (at, self.misplaced(at) + f64::EPSILON * at.abs());
        distinct_places([rounded(start), rounded(end)], faces, out);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let (code, sure) = self.code(from, to);
        if !sure {
            // Any code may hold, vacuum among them.
            return Some(self.unknown());
        }
        match code {
            LabelCode::Vacuum => None,
            LabelCode::Constant(value) => Some(self.solid(from, to, code, value)),
            LabelCode::Offset(offset) => self.shifted(from, to, offset),
        }
    }

    fn misplaced(&self, at: f64) -> f64 {
        let is_end = at <= self.chord.start || at >= self.chord.end;
        let mut error = self.labels.face_error(0.5, at);
        if is_end {
            error = error.max(self.grid.face_error(0.0, at)).max(self.clip_error);
        }
        if self.field.grid_jumps() {
            let shifts = self.grid_shifts().iter();
            error = shifts.map(|&shift| self.grid.face_error(shift, at)).fold(error, f64::max);
        }
        error
    }
}
