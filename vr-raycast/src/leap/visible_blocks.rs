//! Blocks that can be seen.

use vr_core::Real;
use vr_core::parallel::each_part;
use vr_kernels::ranges::RangeBlocks;

use super::{Visibility, reach};

/// Set of the blocks in which anything can be visible, a bit for each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct VisibleBlocks {
    grid: BlockGrid,
    /// Words, row after row, x fastest; each row begins a new word, lowest bit first. Bits beyond a row's end are 0.
    words: Vec<u64>,
}

/// Blocks laid over the cells of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlockGrid {
    /// Blocks along x, y, z.
    pub(crate) blocks: [usize; 3],
    /// Cells along the edge of a block.
    pub(crate) edge: usize,
    /// Half the width of a beam, in blocks.
    pub(crate) reach: f64,
}

impl BlockGrid {
    /// Lays blocks over a volume with the given voxels along x, y, z.
    pub(crate) fn new(dims: [usize; 3], edge: usize) -> Self {
        Self { blocks: dims.map(|n| (n - 1).div_ceil(edge)), edge, reach: reach(dims) / edge as f64 }
    }

    /// Returns the number of blocks.
    pub(crate) fn len(&self) -> usize {
        self.blocks.iter().product()
    }

    /// Returns the position of a block in an array of all of them, x fastest.
    #[inline(always)]
    pub(crate) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.blocks[1] + y) * self.blocks[0] + x
    }
}

impl VisibleBlocks {
    /// Tests each block of a volume with the given voxels along x, y, z.
    pub(crate) fn new<R: Real>(dims: [usize; 3], ranges: &RangeBlocks, visibility: &Visibility<R>) -> Self {
        let grid = BlockGrid::new(dims, ranges.edge());
        debug_assert_eq!(grid.blocks, ranges.blocks());
        let across = grid.blocks[0];
        let mut words = vec![0u64; across.div_ceil(64) * grid.blocks[1] * grid.blocks[2]];
        // Rows of a task.
        const ROWS: usize = 64;
        let tasks = words.chunks_mut(ROWS * across.div_ceil(64)).zip(ranges.ranges().chunks(ROWS * across));
        each_part(tasks, |_, (words, ranges)| {
            for (words, ranges) in words.chunks_mut(across.div_ceil(64)).zip(ranges.chunks(across)) {
                for (word, ranges) in words.iter_mut().zip(ranges.chunks(64)) {
                    for (bit, range) in ranges.iter().enumerate() {
                        *word |= u64::from(visibility.shows_block(range)) << bit;
                    }
                }
            }
        });
        Self { grid, words }
    }

    /// Makes the set from a function of the block.
    pub(crate) fn from_fn(dims: [usize; 3], edge: usize, visible: impl Fn([usize; 3]) -> bool) -> Self {
        let grid = BlockGrid::new(dims, edge);
        let mut made = Self::clear(grid);
        for z in 0..grid.blocks[2] {
            for y in 0..grid.blocks[1] {
                for x in 0..grid.blocks[0] {
                    let word = made.row_start(y, z) + x / 64;
                    made.words[word] |= u64::from(visible([x, y, z])) << (x % 64);
                }
            }
        }
        made
    }

    /// Makes the empty set.
    pub(crate) fn clear(grid: BlockGrid) -> Self {
        Self { grid, words: vec![0; grid.blocks[0].div_ceil(64) * grid.blocks[1] * grid.blocks[2]] }
    }

    /// Makes the set from bytes, x fastest, of blocks of half the edge, of which those below `limit` are visible: a block is visible where any of its parts is.
    pub(crate) fn of_halves(dims: [usize; 3], half: usize, bytes: &[u8], limit: u8) -> Self {
        let [nx, ny, nz] = BlockGrid::new(dims, half).blocks;
        let mut made = Self::clear(BlockGrid::new(dims, 2 * half));
        let parts = |b: usize, n: usize| 2 * b..(2 * b + 2).min(n);
        let mut least = vec![u8::MAX; nx];
        for z in 0..made.grid.blocks[2] {
            for y in 0..made.grid.blocks[1] {
                least.fill(u8::MAX);
                for (z, y) in parts(z, nz).flat_map(|z| parts(y, ny).map(move |y| (z, y))) {
                    let row = &bytes[(z * ny + y) * nx..][..nx];
                    least.iter_mut().zip(row).for_each(|(least, &byte)| *least = byte.min(*least));
                }
                let start = made.row_start(y, z);
                for (x, pair) in least.chunks(2).enumerate() {
                    let visible = pair.iter().any(|&b| b < limit);
                    made.words[start + x / 64] |= u64::from(visible) << (x % 64);
                }
            }
        }
        made
    }

    /// Returns the blocks of twice the edge, in a volume with the given voxels along x, y, z, that are visible: where any of their parts is.
    pub(crate) fn coarser(&self, dims: [usize; 3]) -> Self {
        let parts = |b: usize, a: usize| 2 * b..(2 * b + 2).min(self.grid.blocks[a]);
        Self::from_fn(dims, 2 * self.grid.edge, |[x, y, z]| {
            parts(z, 2).any(|z| parts(y, 1).any(|y| parts(x, 0).any(|x| self.at([x, y, z]))))
        })
    }

    /// Returns the layout of the blocks.
    pub(crate) fn grid(&self) -> BlockGrid {
        self.grid
    }

    /// Returns the number of words of a row.
    pub(crate) fn words_per_row(&self) -> usize {
        self.grid.blocks[0].div_ceil(64)
    }

    fn row_start(&self, y: usize, z: usize) -> usize {
        (z * self.grid.blocks[1] + y) * self.words_per_row()
    }

    /// Returns the bits of a row.
    pub(crate) fn row(&self, y: usize, z: usize) -> &[u64] {
        let start = self.row_start(y, z);
        &self.words[start..start + self.words_per_row()]
    }

    /// True if a block can be seen.
    #[inline(always)]
    pub(crate) fn at(&self, [x, y, z]: [usize; 3]) -> bool {
        self.words[self.row_start(y, z) + x / 64] >> (x % 64) & 1 == 1
    }

    /// Returns the blocks that are not visible.
    pub(crate) fn inverted(&self) -> Self {
        let mut made = Self { grid: self.grid, words: self.words.iter().map(|w| !w).collect() };
        made.trim();
        made
    }

    /// Returns the blocks that are visible or have a visible neighbour, across faces, edges and corners.
    pub(crate) fn dilated(&self) -> Self {
        let Self { grid, words } = self;
        let per_row = self.words_per_row();
        let mut along_x = Vec::with_capacity(words.len());
        for row in words.chunks(per_row) {
            for (i, &w) in row.iter().enumerate() {
                let below = if i > 0 { row[i - 1] >> 63 } else { 0 };
                let above = if i + 1 < per_row { row[i + 1] << 63 } else { 0 };
                along_x.push(w | w << 1 | w >> 1 | below | above);
            }
        }
        let slice = per_row * grid.blocks[1];
        let mut along_y = along_x.clone();
        for (out, from) in along_y.chunks_mut(slice).zip(along_x.chunks(slice)) {
            spread(out, from, per_row);
        }
        let mut all = along_y.clone();
        spread(&mut all, &along_y, slice);
        let mut made = Self { grid: *grid, words: all };
        made.trim();
        made
    }

    /// Clears the bits beyond the ends of rows.
    fn trim(&mut self) {
        let used = self.grid.blocks[0] % 64;
        if used > 0 {
            let per_row = self.words_per_row();
            for last in self.words.iter_mut().skip(per_row - 1).step_by(per_row) {
                *last &= (1 << used) - 1;
            }
        }
    }

    /// Calls `each` with the index of every block that is in `self` and not in `other`; returns true if there was one.
    pub(crate) fn for_each_beyond(&self, other: &Self, mut each: impl FnMut(usize)) -> bool {
        let (per_row, across) = (self.words_per_row(), self.grid.blocks[0]);
        let mut any = false;
        for (i, (a, b)) in self.words.iter().zip(&other.words).enumerate() {
            let mut left = a & !b;
            any |= left != 0;
            let first = i / per_row * across + i % per_row * 64;
            while left != 0 {
                each(first + left.trailing_zeros() as usize);
                left &= left - 1;
            }
        }
        any
    }
}

/// Joins each entry with those `stride` before and behind it.
fn spread(out: &mut [u64], from: &[u64], stride: usize) {
    for (o, f) in out.iter_mut().zip(&from[stride.min(from.len())..]) {
        *o |= f;
    }
    for (o, f) in out.iter_mut().skip(stride).zip(from) {
        *o |= f;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dilation_and_inversion_are_what_they_say() {
        // Rows of more than one word.
        let dims = [71, 6, 5];
        let seen = |[x, y, z]: [usize; 3]| (x * 7 + y * 5 + z * 3) % 41 == 0 || x == 63;
        let blocks = VisibleBlocks::from_fn(dims, 1, seen);
        let (dilated, inverted) = (blocks.dilated(), blocks.inverted());
        let n = blocks.grid().blocks;
        let mut clear = 0;
        for z in 0..n[2] {
            for y in 0..n[1] {
                for x in 0..n[0] {
                    let around = |i: usize, n: usize| i.saturating_sub(1)..=(i + 1).min(n - 1);
                    let near =
                        around(z, n[2]).any(|z| around(y, n[1]).any(|y| around(x, n[0]).any(|x| seen([x, y, z]))));
                    assert_eq!(dilated.at([x, y, z]), near);
                    assert_eq!(inverted.at([x, y, z]), !seen([x, y, z]));
                    clear += usize::from(!seen([x, y, z]));
                }
            }
        }
        let mut found = 0;
        assert!(inverted.for_each_beyond(&VisibleBlocks::clear(inverted.grid), |i| {
            let [w, h, _] = n;
            assert!(!seen([i % w, i / w % h, i / (w * h)]));
            found += 1;
        }));
        assert_eq!(found, clear);
        assert!(!blocks.for_each_beyond(&blocks, |_| {}));
    }
}
