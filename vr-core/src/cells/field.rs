//! A mesh of cells as a field.

use glam::DVec3;

use super::FACES;
use super::line::CellLine;
use super::mesh::{CellMesh, CellValues};
use crate::field::{Field, FieldLine};
use crate::ray::Ray;
use crate::view::Clip;

/// Depth in a cell, as a barycentric coordinate, down to which a place counts as inside: a place on a face belongs to a cell, whatever rounding did.
pub(crate) const ON_FACE: f64 = -1e-12;

impl CellMesh {
    /// The cell that holds a place deepest, and its barycentric coordinates there; `None` in vacuum.
    pub fn cell_at(&self, at: DVec3) -> Option<(usize, [f64; 4])> {
        let mut found: Option<(usize, [f64; 4])> = None;
        let mut deepest = ON_FACE;
        self.tree().each_around(at - self.tree().middle(), |cell| {
            let coordinates = self.coordinates(cell, at);
            let depth = coordinates.into_iter().fold(f64::INFINITY, f64::min);
            if depth > deepest || (depth == deepest && found.is_some_and(|(other, _)| cell < other)) {
                (found, deepest) = (Some((cell, coordinates)), depth);
            }
        });
        found
    }

    /// Outward normals of the four faces of a cell, so long that a place's barycentric coordinate is n·(e − place), and a corner e on each face.
    pub(crate) fn face_planes(&self, cell: usize) -> [(DVec3, DVec3); 4] {
        let corners = self.corners(cell);
        let [a, b, c, d] = corners;
        let volume = (b - a).cross(c - a).dot(d - a);
        FACES.map(|face| {
            let [e, f, g] = face.map(|i| corners[i]);
            ((f - e).cross(g - e) / volume, e)
        })
    }

    /// Barycentric coordinates of a place in a cell; negative beyond its faces.
    pub fn coordinates(&self, cell: usize, at: DVec3) -> [f64; 4] {
        self.face_planes(cell).map(|(normal, on)| normal.dot(on - at))
    }
}

fn mixed(weights: [f64; 4], corners: [f64; 4]) -> f64 {
    let rise: f64 = (1..4).map(|i| weights[i] * (corners[i] - corners[0])).sum();
    corners[0] + rise
}

impl Field for CellMesh {
    fn kind(&self) -> &'static str {
        "mesh of cells"
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds()
    }

    fn spacing(&self) -> f64 {
        self.mean_spacing()
    }

    fn value_range(&self) -> Option<(f64, f64)> {
        Some(self.value_range())
    }

    fn value(&self, at: DVec3) -> Option<f64> {
        let (cell, weights) = self.cell_at(at)?;
        Some(mixed(weights, self.corner_values(cell)))
    }

    fn has_gradient(&self) -> bool {
        matches!(self.values(), CellValues::Vertices(_))
    }

    /// The gradients at the vertices, between them linear in each cell.
    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        let gradients = self.gradients()?;
        let (cell, weights) = self.cell_at(at)?;
        let corners = self.cells()[cell].map(|v| gradients[v as usize]);
        Some((0..4).map(|i| corners[i] * weights[i]).sum())
    }

    fn jumps(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<f64>) {
        CellLine::jumps(self, ray, part, out);
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        Some(Box::new(CellLine::new(self, ray, clip, far, gradients)?))
    }

    fn prepare_derived(&self) {
        self.tree();
        self.gradients();
    }
}
