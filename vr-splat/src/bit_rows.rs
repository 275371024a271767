//! Which voxels or cells of a layer are meant, a bit each, row by row.

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
    width: usize,
    stride: usize,
    words: Vec<u64>,
}

impl BitRows {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let stride = width.div_ceil(64);
        Self { width, stride, words: vec![0; stride * height] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, x: usize, y: usize) {
        self.words[y * self.stride + x / 64] |= 1 << (x % 64);
    }

    #[inline(always)]
    pub(crate) fn is_set(&self, x: usize, y: usize) -> bool {
        self.words[y * self.stride + x / 64] >> (x % 64) & 1 == 1
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
            for c in (0..self.width).filter(|&c| row[c / 64] >> (c % 64) & 1 == 1) {
                for x in (c + 1).saturating_sub(near[0])..=(c + near[0]).min(nx - 1) {
                    wide[x / 64] |= 1 << (x % 64);
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
        let mut runs = Vec::new();
        for y in 0..self.words.len() / self.stride {
            let row = self.row(y);
            let mut x = 0;
            while x < self.width {
                // Past zeros, a word at a time.
                let rest = row[x / 64] >> (x % 64);
                if rest == 0 {
                    x = (x / 64 + 1) * 64;
                    continue;
                }
                x += rest.trailing_zeros() as usize;
                let start = x;
                while x < self.width && self.is_set(x, y) {
                    x += 1;
                }
                runs.push(Run { x: start as u16, y: y as u16, length: (x - start) as u16 });
            }
        }
        runs.shrink_to_fit();
        runs
    }
}
