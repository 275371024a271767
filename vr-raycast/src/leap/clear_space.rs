//! Blocks in which nothing can be seen, and such cells of the others.

use vr_core::parallel::{collect, each_part};
use vr_core::{Filter, GridVolume, with_grid};
use vr_kernels::ranges::{LevelRanges, Leveled, VisibleLevels};

use super::{VisibleBlocks, chessboard_distances};

/// Space in which nothing can be seen, block by block and cell by cell.
///
/// Blocks know how far all blocks around are like them: a ray in the middle of clear ones moves on freely (Cohen & Sheffer 1994, "Proximity clouds, an
/// acceleration technique for 3D grid traversal"). At a surface half of the cells of visible blocks are clear, and it is there that most samples of an opaque
/// scene would be taken: so these blocks have a bit for each cell.
#[derive(Clone, Debug)]
pub(crate) struct ClearSpace {
    shift: u32,
    blocks: [usize; 3],
    /// A code for each block, x fastest. Above 0 it is the chessboard distance, in blocks, of one that is clear throughout to the nearest one that is not; below 0
    /// [`Self::VISIBLE_BLOCK`] less the same distance of one that is visible throughout; 0 for others.
    codes: Vec<i8>,
    /// Clear cells of the blocks whose code is 0, a bit for each, x fastest; 0 for other blocks.
    cells: Vec<u64>,
}

impl ClearSpace {
    /// Cells along the edge of blocks whose cells are known.
    pub(crate) const EDGE: usize = 4;
    /// Code of clear cells of blocks with visible ones.
    pub(crate) const CLEAR_CELL: i32 = -1;
    /// Code of visible blocks, before the distance is subtracted.
    pub(crate) const VISIBLE_BLOCK: i32 = -1;

    /// True if the voxels at the corners of a cell bound the field in it, so that the cells of a volume can be told apart: under the narrow filters, where no voxel is
    /// missing.
    pub(crate) fn knows_cells(volume: &GridVolume) -> bool {
        matches!(volume.filter(), Filter::Nearest | Filter::Trilinear) && volume.vacuum_cells().is_none()
    }

    /// Finds the clear cells of a volume. `shows(from, to)` is true if a stored number may be visible anywhere from `from` to `to`, ends included.
    ///
    /// # Panics
    /// Panics if the voxels do not tell: see [`Self::knows_cells`].
    pub(crate) fn of_cells(volume: &GridVolume, shows: impl Fn(f64, f64) -> bool) -> Self {
        assert!(Self::knows_cells(volume), "the corners of a cell bound the field in it");
        let range = volume.value_stats().range.unwrap_or_default();
        let range = (f64::from(range.0), f64::from(range.1));
        let visible = VisibleLevels::new(range, volume.voxel_type().is_integer(), shows);
        let levels = LevelRanges::of_volume(volume);
        // A level may fall short by less than its width, unless it is a number of the voxels'.
        let slack = if LevelRanges::are_exact(volume) { 0.0 } else { levels.stored(1) - levels.stored(0) };
        let uniform = |block: usize| {
            let [low, high] = levels.ranges()[block].map(|level| levels.stored(level));
            let (low, high) = (low - slack, high + slack);
            if !visible.any(low, high) { Some(u64::MAX) } else { visible.all(low, high).then_some(0) }
        };
        let blocks = levels.blocks();
        let mut masks = vec![0; blocks.iter().product()];
        with_grid!(volume.values(), grid => {
            let rows = CellRows { samples: grid.samples(), dims: grid.dims(), visible: &visible };
            each_part(masks.chunks_mut(blocks[0]), |row, masks| {
                let first = row * blocks[0];
                let known = (first..first + blocks[0]).map(uniform);
                rows.fill([row % blocks[1], row / blocks[1]], known, masks);
            });
        });
        Self::of_masks(Self::EDGE, blocks, masks)
    }

    /// Takes over blocks of `edge`³ cells, x fastest, whose cells are not known: clear ones, and others, which count as visible throughout.
    ///
    /// # Panics
    /// Panics if the edge is not a power of two.
    pub(crate) fn of_blocks(edge: usize, blocks: [usize; 3], is_clear: impl Fn(usize) -> bool + Sync) -> Self {
        let mask = |block| if is_clear(block) { u64::MAX } else { 0 };
        Self::of_masks(edge, blocks, collect(blocks.iter().product(), mask))
    }

    /// Makes the codes of blocks, from bits of the clear cells of each.
    fn of_masks(edge: usize, blocks: [usize; 3], mut cells: Vec<u64>) -> Self {
        assert!(edge.is_power_of_two(), "blocks are found by shifting");
        let distances = |alike: u64| {
            let mut distance: Vec<u8> = cells.iter().map(|&mask| if mask == alike { u8::MAX } else { 0 }).collect();
            chessboard_distances(blocks, &mut distance);
            distance.into_iter().map(|d| i32::from(d).min(i32::from(i8::MAX)))
        };
        let code = |(clear, visible)| match (clear, visible) {
            (0, 0) => 0,
            (0, visible) => (Self::VISIBLE_BLOCK - visible) as i8,
            (clear, _) => clear as i8,
        };
        let codes: Vec<i8> = distances(u64::MAX).zip(distances(0)).map(code).collect();
        cells.iter_mut().zip(&codes).filter(|(_, code)| **code != 0).for_each(|(mask, _)| *mask = 0);
        Self { shift: edge.trailing_zeros(), blocks, codes, cells }
    }

    /// Returns the base 2 logarithm of the number of cells along the edge of a block.
    pub(crate) fn shift(&self) -> u32 {
        self.shift
    }

    /// Returns the numbers of blocks along x, y, z.
    pub(crate) fn blocks(&self) -> [usize; 3] {
        self.blocks
    }

    /// Returns the codes of all blocks, and the clear cells of those whose code is 0.
    #[inline(always)]
    pub(crate) fn codes(&self) -> (&[i8], &[u64]) {
        (&self.codes, &self.cells[..self.codes.len()])
    }

    /// True if anything is clear.
    pub(crate) fn has_any(&self) -> bool {
        self.codes.iter().any(|&code| code >= 0)
    }

    /// Returns the visible blocks, of twice the edge, of a volume with the given voxels along x, y, z.
    pub(crate) fn visible_blocks(&self, dims: [usize; 3]) -> VisibleBlocks {
        let bytes: Vec<u8> = self.codes.iter().map(|&code| u8::from(code > 0)).collect();
        VisibleBlocks::of_halves(dims, 1 << self.shift, &bytes, 1)
    }
}

/// Rows of cells along x, whose ranges of values tell whether they are clear.
struct CellRows<'a, T> {
    samples: &'a [T],
    dims: [usize; 3],
    visible: &'a VisibleLevels,
}

impl<T: Leveled> CellRows<'_, T> {
    /// Fills a row of blocks along x with masks of clear cells, but for those that are `known`.
    fn fill(&self, [y, z]: [usize; 2], known: impl Iterator<Item = Option<u64>>, masks: &mut [u64]) {
        const N: usize = ClearSpace::EDGE;
        let mut mixed = Vec::new();
        for (x, (mask, known)) in masks.iter_mut().zip(known).enumerate() {
            match known {
                Some(known) => *mask = known,
                None => mixed.push(x),
            }
        }
        let (Some(&first), Some(&last)) = (mixed.first(), mixed.last()) else { return };
        let xs = first * N..(last * N + N + 1).min(self.dims[0]);
        // The smallest and the largest of the four voxels beside each other in y and z, at each x.
        let (mut low, mut high) = (Vec::with_capacity(xs.len()), Vec::with_capacity(xs.len()));
        for row in 0..N * N {
            let at = |a: usize, block: usize, i: usize| (block * N + i).min(self.dims[a] - 1);
            for corner in 0..4 {
                let (y, z) = (at(1, y, row % N + corner % 2), at(2, z, row / N + corner / 2));
                let voxels = &self.samples[(z * self.dims[1] + y) * self.dims[0]..][xs.clone()];
                if corner == 0 {
                    low.clear();
                    low.extend_from_slice(voxels);
                    high.clear();
                    high.extend_from_slice(voxels);
                    continue;
                }
                low.iter_mut().zip(voxels).for_each(|(low, &s)| *low = if s < *low { s } else { *low });
                high.iter_mut().zip(voxels).for_each(|(high, &s)| *high = if s > *high { s } else { *high });
            }
            // Two of these make a cell. Beyond the volume there is none, and the last voxel stands for it.
            for &x in &mixed {
                let mut bits = 0;
                for i in 0..N {
                    let [a, b] = [0, 1].map(|k| (x * N + i + k).min(self.dims[0] - 1) - xs.start);
                    let least = if low[b] < low[a] { low[b] } else { low[a] };
                    let most = if high[b] > high[a] { high[b] } else { high[a] };
                    bits |= u64::from(!self.visible.between(least, most)) << i;
                }
                masks[x] |= bits << (N * row);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume, Voxel};

    fn volume<T: Voxel>(dims: [usize; 3], samples: Vec<T>) -> Volume
    where
        Volume: From<UniformGrid<T>>,
    {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into()
    }

    /// Cells of a volume with so many voxels, and their blocks.
    fn cells(dims: [usize; 3]) -> impl Iterator<Item = ([usize; 3], [usize; 3])> {
        let [nx, ny, nz] = dims.map(|n| n - 1);
        (0..nx * ny * nz)
            .map(move |i| [i % nx, i / nx % ny, i / (nx * ny)])
            .map(|cell| (cell, cell.map(|c| c / ClearSpace::EDGE)))
    }

    /// True if the space says that a cell is clear.
    fn is_clear(space: &ClearSpace, cell: [usize; 3], block: [usize; 3]) -> bool {
        let index = |[x, y, z]: [usize; 3], n: [usize; 3]| (z * n[1] + y) * n[0] + x;
        let (code, mask) = (space.codes[index(block, space.blocks)], space.cells[index(block, space.blocks)]);
        code > 0 || mask >> index(cell.map(|c| c % ClearSpace::EDGE), [ClearSpace::EDGE; 3]) & 1 == 1
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// Cells are clear where nothing between the smallest and the largest of their voxels shows: all of those of bytes, and no others of any numbers.
        #[test]
        fn cells_are_clear_where_nothing_in_them_shows(
            dims in prop::array::uniform3(2usize..14),
            seed in any::<u32>(),
            flat in 0u32..4,
            (from, width) in (0u8..250, 0u8..60),
        ) {
            let [nx, ny, nz] = dims;
            let voxel = |i: usize| {
                let at = [i % nx, i / nx % ny, i / (nx * ny)].map(|c| c as u32 >> flat);
                ((at[0].wrapping_mul(73) ^ at[1].wrapping_mul(151) ^ at[2].wrapping_mul(199)).wrapping_add(seed).wrapping_mul(2_654_435_761) >> 24) as u8
            };
            let bytes: Vec<u8> = (0..nx * ny * nz).map(voxel).collect();
            let floats: Vec<f32> = bytes.iter().map(|&b| f32::from(b)).collect();
            let (low, high) = (f64::from(from), f64::from(from) + f64::from(width));
            let shows = |a: f64, b: f64| b >= low && a <= high;
            let of = |volume: &Volume| ClearSpace::of_cells(volume.grid().unwrap(), shows);
            let (exact, rounded) = (of(&volume(dims, bytes.clone())), of(&volume(dims, floats)));
            for (cell, block) in cells(dims) {
                let corner = |k: usize| [cell[0] + k % 2, cell[1] + k / 2 % 2, cell[2] + k / 4];
                let voxels = (0..8).map(corner).map(|[x, y, z]| f64::from(bytes[(z * ny + y) * nx + x]));
                let (least, most) = voxels.fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
                prop_assert_eq!(is_clear(&exact, cell, block), !shows(least, most), "{:?}", cell);
                prop_assert!(!is_clear(&rounded, cell, block) || !shows(least, most), "{:?}", cell);
            }
            let any = cells(dims).any(|(cell, block)| is_clear(&exact, cell, block));
            prop_assert_eq!(exact.has_any(), any);
        }
    }

    #[test]
    fn blocks_know_how_far_they_are_from_others() {
        // One voxel of 8 × 1 × 1 blocks shows: two blocks have cells that do.
        let mut samples = vec![0u8; 33 * 5 * 5];
        samples[(2 * 5 + 2) * 33 + 16] = 9;
        let shows = |_: f64, to: f64| to > 5.0;
        let space = ClearSpace::of_cells(volume([33, 5, 5], samples).grid().unwrap(), shows);
        assert_eq!((space.blocks(), space.codes().0), ([8, 1, 1], &[3, 2, 1, 0, 0, 1, 2, 3][..]));
        assert_eq!(space.codes().1.iter().map(|mask| (!mask).count_ones() % 64).sum::<u32>(), 8);
        let blocks = ClearSpace::of_blocks(8, [5, 1, 1], |block| block == 0);
        assert_eq!(blocks.codes().0, [1, -2, -3, -4, -5]);
        assert!(blocks.has_any() && !ClearSpace::of_blocks(8, [5, 1, 1], |_| false).has_any());
    }
}
