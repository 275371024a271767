//! Cells of a block that can be seen.

use std::sync::Arc;

use vr_core::filter::Lattice;
use vr_core::{LatticeVisitor, Voxel};

/// Test that returns true if anything between two stored numbers, ends included, can be seen, by the kernels that the picture is drawn with.
pub(crate) type Sight = Arc<dyn Fn(f32, f32) -> bool + Send + Sync>;

/// Cells along the edge of a block.
pub(crate) const EDGE: usize = 8;

/// Cells along the edge of what is known of a block: its own, and one more on each side.
const KNOWN: usize = EDGE + 2;

/// The cells of a block that can be seen, and those of the cells around it.
///
/// A bit for each cell: a word per layer in z, in it ten bits per row in y, in that a bit per cell in x. Cells beyond the volume
/// cannot be seen. 160 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CellMask([u128; KNOWN]);

/// Sides that rays come from: per axis, true if from below and true if from above.
pub(crate) type Sides = [[bool; 2]; 3];

impl CellMask {
    /// Returns the cells that a ray from some sides may meet first: those that can be seen, but for those where all neighbours on these sides
    /// can be, too. A ray that meets such a cell has met one of these neighbours before.
    ///
    /// Cells are given as steps along x, y and z from the block's first cell.
    pub(crate) fn front(&self, sides: Sides) -> impl Iterator<Item = [usize; 3]> + '_ {
        (1..=EDGE).flat_map(move |z| {
            let layer = self.0[z];
            let neighbours =
                [[layer << 1, layer >> 1], [layer << KNOWN, layer >> KNOWN], [self.0[z - 1], self.0[z + 1]]];
            let mut behind = u128::MAX;
            for axis in 0..3 {
                for side in 0..2 {
                    behind &= if sides[axis][side] { neighbours[axis][side] } else { u128::MAX };
                }
            }
            let mut rest = layer & !behind & OWN;
            std::iter::from_fn(move || {
                let bit = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
                rest &= rest - 1;
                Some([bit % KNOWN - 1, bit / KNOWN - 1, z - 1])
            })
        })
    }
}

/// The cells of a layer that are the block's own.
const OWN: u128 = {
    let row = ((1 << EDGE) - 1) << 1;
    let (mut own, mut y) = (0, 1);
    while y <= EDGE {
        own |= row << (KNOWN * y);
        y += 1;
    }
    own
};

/// Looks into a block, given by its coordinates.
///
/// For filters whose field in a cell stays within the cell's own eight samples.
pub(crate) struct LookInto<'a> {
    pub(crate) block: [usize; 3],
    pub(crate) sight: &'a Sight,
}

impl LatticeVisitor for LookInto<'_> {
    type Output = CellMask;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> CellMask {
        visible_cells(&lattice, self.block, self.sight)
    }
}

/// Finds the cells in and around a block that can be seen. Vacuum counts as the voxels that stand in for the missing ones.
fn visible_cells<T: Voxel>(lattice: &Lattice<'_, T>, block: [usize; 3], sight: &Sight) -> CellMask {
    // The first cell that is there and the one behind the last, counted from the one before the block.
    let ends: [(usize, usize); 3] = std::array::from_fn(|a| {
        let cells = lattice.dims[a] - 1;
        let first = block[a] * EDGE;
        (usize::from(first == 0), (cells + 1 - first).min(KNOWN))
    });
    let [(x0, x1), (y0, y1), (z0, z1)] = ends;
    let at = |a: usize, i: usize| block[a] * EDGE + i - 1;
    let join = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
    let mut mask = [0; KNOWN];
    // Smallest and largest corner of the 2×2 ones around each cell, of the last two layers of samples.
    let mut layers = [[[(0.0f32, 0.0f32); KNOWN]; KNOWN]; 2];
    for z in z0..=z1 {
        let mut rows = [[(0.0f32, 0.0f32); KNOWN]; KNOWN + 1];
        for y in y0..=y1 {
            let start = lattice.offset(at(0, x0), at(1, y), at(2, z));
            let samples = &lattice.samples[start..=start + (x1 - x0)];
            for (pair, range) in samples.windows(2).zip(&mut rows[y][x0..x1]) {
                let (a, b) = (pair[0].to_f32(), pair[1].to_f32());
                *range = (a.min(b), a.max(b));
            }
        }
        for y in y0..y1 {
            for x in x0..x1 {
                layers[z % 2][y][x] = join(rows[y][x], rows[y + 1][x]);
            }
        }
        if z == z0 {
            continue;
        }
        for y in y0..y1 {
            for x in x0..x1 {
                let (low, high) = join(layers[0][y][x], layers[1][y][x]);
                // What a kernel's interpolation rounds by, as in the ranges of blocks; between equal numbers it does not.
                let slack = if low == high { 0.0 } else { 16.0 * f32::EPSILON * low.abs().max(high.abs()) };
                mask[z - 1] |= u128::from(sight(low - slack, high + slack)) << (KNOWN * y + x);
            }
        }
    }
    CellMask(mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Sides = [[true; 2]; 3];

    fn masks(dims: [usize; 3], ones: &[[usize; 3]], blocks: &[[usize; 3]]) -> Vec<CellMask> {
        let mut samples = vec![0.0f32; dims.iter().product()];
        for p in ones {
            samples[(p[2] * dims[1] + p[1]) * dims[0] + p[0]] = 1.0;
        }
        let sight: Sight = Arc::new(|_, high| high > 0.5);
        let lattice = Lattice { samples: &samples, dims };
        blocks.iter().map(|&block| visible_cells(&lattice, block, &sight)).collect()
    }

    #[test]
    fn cells_around_a_sample_are_seen() {
        let blocks = [[0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1]];
        let masks = masks([12, 9, 11], &[[9, 4, 8]], &blocks);
        // Cells 8 and 9 in x, 3 and 4 in y, 7 and 8 in z.
        let front = |i: usize| masks[i].front(ALL).collect::<Vec<_>>();
        assert_eq!((front(0), front(2)), (vec![], vec![]));
        assert_eq!(front(1), [[0, 3, 7], [1, 3, 7], [0, 4, 7], [1, 4, 7]]);
        assert_eq!(front(3), [[0, 3, 0], [1, 3, 0], [0, 4, 0], [1, 4, 0]]);
        // From above in x alone, from below in z alone.
        let from_x: Vec<_> = masks[1].front([[false, true], [false; 2], [false; 2]]).collect();
        assert_eq!(from_x, [[1, 3, 7], [1, 4, 7]]);
        assert_eq!(masks[3].front([[false; 2], [false; 2], [true, false]]).count(), 0, "the block before hides them");
    }

    #[test]
    fn of_what_is_solid_the_faces_of_the_volume_are_left() {
        let dims = [9, 17, 9];
        let every: Vec<[usize; 3]> = (0..9 * 17 * 9).map(|i| [i % 9, i / 9 % 17, i / (9 * 17)]).collect();
        let masks = masks(dims, &every, &[[0, 0, 0], [0, 1, 0]]);
        for (i, mask) in masks.iter().enumerate() {
            let faces = |sides: Sides| mask.front(sides).count();
            assert_eq!(faces([[true, false], [false; 2], [false; 2]]), 64);
            assert_eq!(faces([[false; 2], [true, false], [false; 2]]), [64, 0][i]);
            assert_eq!(faces([[true, false], [true, false], [false, true]]), [64 + 2 * 56 - 7, 64 + 56][i]);
        }
    }
}
