//! Sets of voxels or cells of a layer, a bit each, row by row.

use vr_kernels::bits::{WORD, ones};

/// Voxels in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) x: u16,
    pub(crate) y: u16,
    pub(crate) length: u16,
}

/// Rows of bits.
#[derive(Clone, Default)]
pub(crate) struct BitRows {
    stride: usize,
    words: Vec<u64>,
}

impl BitRows {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let stride = width.div_ceil(WORD);
        Self { stride, words: vec![0; stride * height] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, x: usize, y: usize) {
        self.words[y * self.stride + x / WORD] |= 1 << (x % WORD);
    }

    #[inline(always)]
    pub(crate) fn is_set(&self, x: usize, y: usize) -> bool {
        self.words[y * self.stride + x / WORD] >> (x % WORD) & 1 == 1
    }

    pub(crate) fn add(&mut self, other: &Self) {
        for (a, b) in self.words.iter_mut().zip(&other.words) {
            *a |= b;
        }
    }

    pub(crate) fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.stride..][..self.stride]
    }

    /// From cells to the voxels (one more each way) that lie fewer than `near` cells away: voxel i serves cells i − near to i + near − 1.
    pub(crate) fn to_voxels(&self, near: [usize; 3], [nx, ny]: [usize; 2]) -> Self {
        let mut voxels = Self::new(nx, ny);
        let height = self.words.len() / self.stride;
        let mut wide = vec![0u64; voxels.stride];
        for cell in 0..height {
            let row = self.row(cell);
            if row.iter().all(|&w| w == 0) {
                continue;
            }
            wide.fill(0);
            // Cell c is served by voxels c + 1 − near to c + near.
            for (first, length) in ones(row) {
                for x in (first + 1).saturating_sub(near[0])..(first + length + near[0]).min(nx) {
                    wide[x / WORD] |= 1 << (x % WORD);
                }
            }
            for y in (cell + 1).saturating_sub(near[1])..=(cell + near[1]).min(ny - 1) {
                for (a, b) in voxels.words[y * voxels.stride..].iter_mut().zip(&wide) {
                    *a |= b;
                }
            }
        }
        voxels
    }

    pub(crate) fn runs(&self) -> Vec<Run> {
        let rows = self.words.chunks_exact(self.stride).enumerate();
        let run = |y: usize, (x, length): (usize, usize)| Run { x: x as u16, y: y as u16, length: length as u16 };
        let mut runs: Vec<Run> = rows.flat_map(|(y, row)| ones(row).map(move |ones| run(y, ones))).collect();
        runs.shrink_to_fit();
        runs
    }
}
