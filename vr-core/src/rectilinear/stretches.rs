//! Stretches of a ray through a rectilinear grid.

use glam::DVec3;

use super::grid::RectilinearGrid;
use super::line::RectilinearLine;
use crate::field::{Chord, FieldLine, Stretch};
use crate::filter::Lattice;
use crate::grid_volume::LatticeVisitor;
use crate::ray::Ray;
use crate::view::Clip;
use crate::voxel::Voxel;

impl RectilinearLine<'_> {
    /// Appends the stretches of a ray between two world distances that are not vacuum, ascending: one for each cell that it crosses.
    pub(super) fn stretches(grid: &RectilinearGrid, ray: &Ray, [from, to]: [f64; 2], out: &mut Vec<Stretch>) {
        let Some(line) = RectilinearLine::new(grid, ray, &Clip::default(), to, false) else { return };
        let Chord { offset, .. } = line.chord();
        let mut breaks = Vec::new();
        line.breakpoints(&mut breaks);
        let (vacuum, mean) = (grid.lattice().vacuum_cells(), grid.mean_spacing());
        for pair in breaks.windows(2) {
            let [begin, end] = [pair[0].max(from - offset), pair[1]];
            let cell = line.cell(pair[0], pair[1]);
            if begin >= end || vacuum.is_some_and(|vacuum| vacuum.is_vacuum(cell)) {
                continue;
            }
            let widths = DVec3::from_array(std::array::from_fn(|a| grid.axes()[a].width(cell[a])));
            let spacing = pace((ray.direction / widths).length_recip(), mean);
            let range = grid.lattice().with_lattice(CellRange(cell));
            let range = range.map(|stored| grid.lattice().calibration().value(stored));
            let [low, high] = [range[0].min(range[1]) as f32, range[0].max(range[1]) as f32];
            let range = [low.next_down(), high.next_up()];
            out.push(Stretch { from: begin + offset, to: end + offset, spacing, range });
        }
    }
}

/// World length of an index step, to the nearest power of √2 in mean steps of the axes: cells of about one size share a lattice of steps, and faces
/// between them make no short ones. A larger world has longer steps in proportion.
fn pace(length: f64, mean: f64) -> f64 {
    mean * libm::exp2(0.5 * (2.0 * libm::log2(length / mean)).round())
}

/// Smallest and largest stored number at the corners of a cell.
struct CellRange([usize; 3]);

impl LatticeVisitor for CellRange {
    type Output = [f64; 2];

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [f64; 2] {
        let corner = |c: usize| {
            let [x, y, z] = std::array::from_fn(|a| self.0[a] + (c >> a & 1));
            lattice.at::<f64>(x, y, z)
        };
        (0..8).map(corner).fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)])
    }
}
