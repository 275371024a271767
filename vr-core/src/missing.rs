//! Voxels that are NaN: the cells that they make vacuum, and the values that the wider filters take in their place.

use crate::cancel;
use crate::grid::UniformGrid;
use crate::real::Real;

/// The closed cells that are vacuum because one of their eight corners is NaN.
///
/// # Examples
/// ```
/// use vr_core::{Calibration, Placement, UniformGrid, VacuumCells};
///
/// let mut values = vec![1.0f32; 16]; // 4 × 2 × 2 voxels, 3 × 1 × 1 cells
/// values[3] = f32::NAN;
/// let grid = UniformGrid::new([4, 2, 2], values, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
/// let vacuum = VacuumCells::new(&grid);
/// assert!(!vacuum.is_vacuum([1, 0, 0]) && vacuum.is_vacuum([2, 0, 0]));
/// assert!(vacuum.contains([2.0, 0.5, 0.5]), "a face belongs to both of its cells");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug)]
pub struct VacuumCells {
    cells: [usize; 3],
    /// One bit a cell.
    bits: Vec<u64>,
}

impl VacuumCells {
    /// Finds the vacuum cells of a grid.
    pub fn new(grid: &UniformGrid<f32>) -> Self {
        let dims = grid.dims();
        let cells = dims.map(|n| n - 1);
        let mut bits = vec![0u64; cells.iter().product::<usize>().div_ceil(64)];
        for (i, _) in grid.samples().iter().enumerate().filter(|(_, s)| s.is_nan()) {
            let p = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            // The up to eight cells around the voxel.
            let around = |a: usize| p[a].saturating_sub(1)..=p[a].min(cells[a] - 1);
            for z in around(2) {
                for y in around(1) {
                    for x in around(0) {
                        let c = (z * cells[1] + y) * cells[0] + x;
                        bits[c / 64] |= 1 << (c % 64);
                    }
                }
            }
        }
        Self { cells, bits }
    }

    /// True if a cell is vacuum.
    #[inline]
    pub fn is_vacuum(&self, cell: [usize; 3]) -> bool {
        let c = (cell[2] * self.cells[1] + cell[1]) * self.cells[0] + cell[0];
        self.bits[c / 64] >> (c % 64) & 1 == 1
    }

    /// True if a position lies in a closed vacuum cell: on a face, the cells on both sides count.
    #[inline]
    pub fn contains<R: Real>(&self, p: [R; 3]) -> bool {
        let range: [(usize, usize); 3] = std::array::from_fn(|a| {
            let i = p[a].to_index().min(self.cells[a] - 1);
            let on_lower_face = p[a] == R::from_index(i) && i > 0;
            (if on_lower_face { i - 1 } else { i }, i)
        });
        (range[2].0..=range[2].1)
            .any(|z| (range[1].0..=range[1].1).any(|y| (range[0].0..=range[0].1).any(|x| self.is_vacuum([x, y, z]))))
    }
}

/// A copy in which missing voxels take the value of the nearest finite one (in steps along the axes; among equals the one
/// first in memory). All zeros if no voxel is finite: everything is vacuum then.
pub fn fill_missing(grid: &UniformGrid<f32>) -> UniformGrid<f32> {
    let dims = grid.dims();
    let mut samples = grid.samples().to_vec();
    // Breadth-first from all finite voxels at once.
    let mut front: Vec<usize> = (0..samples.len()).filter(|&i| !samples[i].is_nan()).collect();
    if front.is_empty() {
        samples.fill(0.0);
    }
    let strides = [1, dims[0], dims[0] * dims[1]];
    while !front.is_empty() {
        cancel::poll();
        let mut next = Vec::new();
        for &i in &front {
            for a in 0..3 {
                let x = i / strides[a] % dims[a];
                let below = (x > 0).then(|| i - strides[a]);
                let above = (x + 1 < dims[a]).then(|| i + strides[a]);
                for n in below.into_iter().chain(above) {
                    if samples[n].is_nan() {
                        samples[n] = samples[i];
                        next.push(n);
                    }
                }
            }
        }
        front = next;
    }
    UniformGrid::new(dims, samples, *grid.placement(), grid.calibration()).expect("same shape as a valid grid")
}
