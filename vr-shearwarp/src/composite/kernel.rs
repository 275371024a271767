//! Operations on samples: compositing, or picking the largest, say.

use fearless_simd::Simd;
use vr_kernels::vector::LANES;

use super::cells::{Columns, Edges};

/// Operation on the samples under texels of one row, in one run of cells.
pub(crate) trait Kernel: Sync {
    /// True if texels can become opaque.
    const CLOSES: bool;

    /// Texels at once: at most [`LANES`].
    const AT_ONCE: usize;

    /// Adds a sample to each of the `n` texels from (x, y) on. `UNIT`: a texel a cell. A sample stands for its
    /// share of the distance between slices, or for all of it. Texels that are opaque are left as they are.
    fn add<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: Chunk,
        shares: Option<&[f32; LANES]>,
        row: &mut Row<'_>,
    ) -> Added;
}

/// Result of adding samples to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Added {
    /// Number of texels that took one.
    pub(crate) samples: u32,
    /// A bit for each that became opaque by it.
    pub(crate) closed: u32,
}

/// Up to sixteen neighbouring texels.
#[derive(Clone, Copy)]
pub(crate) struct Chunk {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) n: usize,
}

/// A row of texels while it is worked on: all reds, all greens, all blues, all opacities, each with room for a vector behind the last.
pub(crate) struct Row<'a>([&'a mut [f32]; 4]);

impl<'a> Row<'a> {
    /// Numbers that a row of that many texels takes.
    pub(crate) fn length(width: usize) -> usize {
        4 * (width + LANES)
    }

    #[inline(always)]
    pub(crate) fn new(planes: &'a mut [f32]) -> Self {
        let stride = planes.len() / 4;
        let (r, rest) = planes.split_at_mut(stride);
        let (g, rest) = rest.split_at_mut(stride);
        let (b, a) = rest.split_at_mut(stride);
        Self([r, g, b, a])
    }

    /// Number of texels.
    pub(crate) fn width(&self) -> usize {
        self.0[0].len() - LANES
    }

    /// One component of that many texels, from x on: at most [`LANES`].
    #[inline(always)]
    pub(crate) fn several<const COUNT: usize>(&mut self, component: usize, x: usize) -> &mut [f32; COUNT] {
        (&mut self.0[component][x..x + COUNT]).try_into().expect("as many as asked for")
    }

    /// One component of sixteen texels, from x on.
    #[inline(always)]
    pub(crate) fn lanes(&mut self, component: usize, x: usize) -> &mut [f32; LANES] {
        self.several(component, x)
    }

    /// The texels, one after another.
    pub(crate) fn write(&self, texels: &mut [[f32; 4]]) {
        let [r, g, b, a] = self.0.each_ref().map(|plane| &plane[..texels.len()]);
        for (i, texel) in texels.iter_mut().enumerate() {
            *texel = [r[i], g[i], b[i], a[i]];
        }
    }
}
