//! Which cells of a block can be seen.

use std::sync::Arc;

use rayon::prelude::*;
use vr_core::filter::{Lattice, Reconstruction};
use vr_core::{Sampler, SamplerVisitor, Voxel};

/// Whether anything between two stored numbers, ends included, can be seen, by the kernels that the picture is drawn with.
pub(crate) type Sight = Arc<dyn Fn(f32, f32) -> bool + Send + Sync>;

/// Cells along the edge of a block.
pub(crate) const EDGE: usize = 8;

/// One bit for each cell of a block: a word per layer in z, in it a byte per row in y, in that a bit per cell in x.
pub(crate) type CellMask = [u64; EDGE];

/// Finds the outer cells of some blocks: those that can be seen and of whose six neighbours in the block one cannot, or is
/// missing because the block ends. A ray that comes from outside meets one of them before any other visible cell.
///
/// For filters whose field in a cell stays within the cell's own eight samples.
pub(crate) struct OuterCells<'a> {
    /// Coordinates of the blocks.
    pub(crate) blocks: &'a [[usize; 3]],
    pub(crate) sight: &'a Sight,
}

impl SamplerVisitor for OuterCells<'_> {
    type Output = Vec<CellMask>;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Vec<CellMask> {
        assert_eq!(F::FILTER.reach(), 0, "a cell's field depends on its own corners alone");
        let lattice = sampler.lattice();
        self.blocks.par_iter().map(|&block| outer(visible_cells(lattice, block, self.sight))).collect()
    }
}

const CORNERS: usize = EDGE + 1;

/// The cells of a block that can be seen. What is vacuum counts as the samples that stand in for the missing ones.
fn visible_cells<T: Voxel>(lattice: &Lattice<'_, T>, block: [usize; 3], sight: &Sight) -> CellMask {
    let first = block.map(|b| b * EDGE);
    let cells: [usize; 3] = std::array::from_fn(|a| (lattice.dims[a] - 1 - first[a]).min(EDGE));
    let mut mask = [0; EDGE];
    // Smallest and largest corner of the 2×2 ones around each cell, of the last two layers of samples.
    let mut layers = [[[(0.0f32, 0.0f32); EDGE]; EDGE]; 2];
    for z in 0..=cells[2] {
        let mut rows = [[(0.0f32, 0.0f32); EDGE]; CORNERS];
        for (y, row) in rows.iter_mut().enumerate().take(cells[1] + 1) {
            let start = lattice.offset(first[0], first[1] + y, first[2] + z);
            let samples = &lattice.samples[start..=start + cells[0]];
            for (pair, range) in samples.windows(2).zip(row) {
                let (a, b) = (pair[0].to_f32(), pair[1].to_f32());
                *range = (a.min(b), a.max(b));
            }
        }
        let join = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                layers[z % 2][y][x] = join(rows[y][x], rows[y + 1][x]);
            }
        }
        if z == 0 {
            continue;
        }
        for y in 0..cells[1] {
            for x in 0..cells[0] {
                let (low, high) = join(layers[0][y][x], layers[1][y][x]);
                // What a kernel's interpolation rounds by, as in the ranges of blocks.
                let slack = 16.0 * f32::EPSILON * low.abs().max(high.abs());
                mask[z - 1] |= u64::from(sight(low - slack, high + slack)) << (EDGE * y + x);
            }
        }
    }
    mask
}

/// Takes away the cells whose six neighbours are all there.
fn outer(mask: CellMask) -> CellMask {
    /// The first and the last cell of each row.
    const FIRST: u64 = 0x0101_0101_0101_0101;
    const LAST: u64 = FIRST << 7;
    std::array::from_fn(|z| {
        let m = mask[z];
        let beside = (m << 1 & !FIRST) & (m >> 1 & !LAST);
        let above_and_below = m << EDGE & m >> EDGE;
        let layers = if z > 0 && z + 1 < EDGE { mask[z - 1] & mask[z + 1] } else { 0 };
        m & !(beside & above_and_below & layers)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::filter::Trilinear;

    #[test]
    fn cells_around_a_sample_are_seen() {
        let dims = [12, 9, 11];
        let mut samples = vec![0.0f32; dims.iter().product()];
        let lattice = Lattice { samples: &samples, dims };
        let at = lattice.offset(9, 4, 8);
        samples[at] = 1.0;
        let lattice = Lattice { samples: &samples, dims };
        let blocks = [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]];
        let sight: Sight = Arc::new(|_, high| high > 0.5);
        let masks = OuterCells { blocks: &blocks, sight: &sight }.visit(Sampler::<f32, Trilinear>::new(lattice, None));
        // Cells 8 and 9 in x, 3 and 4 in y, 7 and 8 in z.
        let rows = 0b11 << (8 * 3) | 0b11 << (8 * 4);
        assert_eq!(masks, [[0; 8], [0, 0, 0, 0, 0, 0, 0, rows], [0; 8], [rows, 0, 0, 0, 0, 0, 0, 0]]);
    }

    #[test]
    fn of_a_full_block_the_faces_are_left() {
        let outside = outer([u64::MAX; 8]);
        let inner: u64 = (1..7).map(|y| 0b0111_1110 << (8 * y)).sum();
        assert_eq!(outside[0], u64::MAX);
        assert_eq!(outside[3], !inner);
        assert_eq!(outside.iter().map(|w| w.count_ones()).sum::<u32>(), 512 - 216);
    }
}
