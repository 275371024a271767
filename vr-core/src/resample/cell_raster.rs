//! Cells of a mesh, drawn into planes of samples.

use glam::DVec3;

use super::lattice::SampleLattice;
use crate::cells::{CellMesh, ON_FACE};

/// Largest number of entries in the lists of cells: 256 MiB. A mesh of more is sampled place by place.
const MAX_ENTRIES: usize = 1 << 26;

/// The cells of a mesh, listed by the planes of samples that they reach: each is drawn row by row, which costs a few operations a sample in
/// place of a search in a tree. Of several cells that hold a sample, that one is seen which holds it deepest, as in the mesh's field.
pub(super) struct CellRaster<'a> {
    mesh: &'a CellMesh,
    lattice: &'a SampleLattice,
    /// Planes that share a list.
    parts: usize,
    /// First entry of each list, and one more.
    starts: Vec<usize>,
    cells: Vec<u32>,
}

impl<'a> CellRaster<'a> {
    /// The cells by planes, `parts` of which share a list; `None` where the lists would be too long.
    pub fn new(mesh: &'a CellMesh, lattice: &'a SampleLattice, parts: usize) -> Option<Self> {
        let heights = &lattice.places[2];
        let lists = heights.len().div_ceil(parts);
        let reached = |cell: usize| {
            let z = mesh.corners(cell).map(|c| c.z);
            let (low, high) = z.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &z| (l.min(z), h.max(z)));
            let planes = widened(heights, low, high);
            (!planes.is_empty()).then(|| planes.start / parts..(planes.end - 1) / parts + 1)
        };
        // Count, then fill.
        let mut starts = vec![0usize; lists + 1];
        for range in (0..mesh.cells().len()).filter_map(reached) {
            for list in range {
                starts[list + 1] += 1;
            }
        }
        for list in 0..lists {
            starts[list + 1] += starts[list];
        }
        if starts[lists] > MAX_ENTRIES {
            return None;
        }
        let (mut next, mut cells) = (starts.clone(), vec![0u32; starts[lists]]);
        for cell in 0..mesh.cells().len() {
            for list in reached(cell).into_iter().flatten() {
                cells[next[list]] = cell as u32;
                next[list] += 1;
            }
        }
        Some(Self { mesh, lattice, parts, starts, cells })
    }

    /// Fills a plane with values; NaN in vacuum.
    pub fn fill(&self, plane: usize, out: &mut [f64]) {
        out.fill(f64::NAN);
        let mut depths = vec![ON_FACE; out.len()];
        let list = plane / self.parts;
        let z = self.lattice.places[2][plane];
        for &cell in &self.cells[self.starts[list]..self.starts[list + 1]] {
            self.draw(cell as usize, z, out, &mut depths);
        }
    }

    /// Draws a cell: between the ends that its four faces leave of each row.
    fn draw(&self, cell: usize, z: f64, out: &mut [f64], depths: &mut [f64]) {
        let [xs, ys, _] = &self.lattice.places;
        let corners = self.mesh.corners(cell);
        let (low, high) = corners.iter().fold((corners[0], corners[0]), |(l, h), &c| (l.min(c), h.max(c)));
        let faces = self.mesh.face_planes(cell);
        let values = self.mesh.corner_values(cell);
        for row in widened(ys, low.y, high.y) {
            let y = ys[row];
            // Depth under each face, as a line in x: a + b (x − low.x).
            let start = DVec3::new(low.x, y, z);
            let mut ends = [low.x, high.x];
            for (normal, on) in faces {
                let (a, b) = (normal.dot(on - start), -normal.x);
                let at = low.x + (ON_FACE - a) / b;
                if b > 0.0 {
                    ends[0] = ends[0].max(at);
                } else if b < 0.0 {
                    ends[1] = ends[1].min(at);
                }
            }
            // A sample more on both sides, for rounding.
            for column in widened(xs, ends[0], ends[1]) {
                let at = DVec3::new(xs[column], y, z);
                let weights = faces.map(|(normal, on)| normal.dot(on - at));
                let depth = weights.into_iter().fold(f64::INFINITY, f64::min);
                let place = row * xs.len() + column;
                if depth > depths[place] {
                    depths[place] = depth;
                    out[place] = values[0] + (1..4).map(|i| weights[i] * (values[i] - values[0])).sum::<f64>();
                }
            }
        }
    }
}

/// Places between two ends, and one more on each side; empty where `low` is well above `high`.
fn widened(places: &[f64], low: f64, high: f64) -> std::ops::Range<usize> {
    let (first, last) = (places.partition_point(|&p| p < low), places.partition_point(|&p| p <= high));
    if last + 1 < first { 0..0 } else { first.saturating_sub(1)..(last + 1).min(places.len()) }
}
