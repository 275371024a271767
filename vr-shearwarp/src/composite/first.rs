//! The first sample of a texel that reaches a threshold.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{LANES, pick, splat};

use super::cells::{Columns, Edges, values};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use crate::codes::Code;
use crate::isosurface::Isosurface;

/// Texels that have met the surface are opaque; their colours are those of the surface.
pub(crate) struct First<'a, P> {
    pub(crate) voxels: &'a [P],
    /// −1 where larger values have smaller stored numbers.
    pub(crate) sign: f32,
    /// The threshold among codes, times `sign`.
    pub(crate) threshold: f32,
    pub(crate) surface: Isosurface<'a>,
}

impl<P: Code> Kernel for First<'_, P> {
    const CLOSES: bool = true;

    #[inline(always)]
    fn add<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: Chunk,
        shares: Option<&[f32; LANES]>,
        row: &mut Row<'_>,
    ) -> Added {
        let places = columns.places::<S, UNIT>(simd, edges.last);
        let value: f32x16<S> = values::<S, P, N, UNIT>(simd, self.voxels, edges, &places);
        let opacity = row.lanes(3, at.x);
        let before = f32x16::load_array_ref(simd, opacity);
        let open = at.taking(simd, shares) & before.simd_le(splat(simd, 0.0));
        let reached = open & (value * self.sign).simd_ge(splat(simd, self.threshold));
        if reached.any_true() {
            *opacity = pick(reached, splat(simd, 1.0), before).to_array();
            row.note(simd, at.x, reached, at.slice);
        }
        Added { samples: (open.to_bitmask() as u32).count_ones(), closed: reached.to_bitmask() as u32 }
    }

    /// The surface between the sample and the one before it.
    fn finish(&self, seen: &Seen<'_>, texel: &mut [f32; 4]) -> f64 {
        let (rgba, depth) = self.surface.met(seen);
        *texel = rgba.map(|x| x as f32);
        depth
    }
}
