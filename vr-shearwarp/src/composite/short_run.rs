//! Samples of short runs of texels, composited four at a time: where runs are short, most of sixteen lanes would do nothing.
//!
//! Each texel goes through the same operations in the same order as among sixteen, so that it does not matter how many it comes with.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, i32x4};
use vr_kernels::vector::share_to_level;

use super::cells::{Columns, Edges};
use super::half::note_half;
use super::kernel::{Added, Chunk, Row};
use super::over::{BY_TABLE, Over};
use crate::codes::Code;

const FOUR: usize = 4;
/// Largest number of texels of a short run.
pub(super) const MAX_SHORT: usize = 2 * FOUR;

const STEPS: [f32; FOUR] = [0., 1., 2., 3.];

/// Four rows as four columns.
#[inline(always)]
fn transposed<S: Simd>([a, b, c, d]: [f32x4<S>; FOUR]) -> [f32x4<S>; FOUR] {
    let (low, high) = (a.zip_low(c), b.zip_low(d));
    let (later_low, later_high) = (a.zip_high(c), b.zip_high(d));
    [low.zip_low(high), low.zip_high(high), later_low.zip_low(later_high), later_low.zip_high(later_high)]
}

impl<P: Code, const PRE_CLASSIFIED: bool, const SHADING: u8> Over<'_, P, PRE_CLASSIFIED, SHADING> {
    /// Adds samples as [`Kernel::add`](super::kernel::Kernel::add) does, for up to [`MAX_SHORT`] whole samples, a texel a cell.
    #[inline(always)]
    pub(super) fn short_run<S: Simd, const N: usize>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: &Chunk,
        row: &mut Row<'_>,
    ) -> Added {
        let mut all = Added { samples: 0, closed: 0 };
        for part in [0, FOUR] {
            if part >= at.n {
                break;
            }
            let n = (at.n - part).min(FOUR);
            let columns = Columns { first: columns.first + part, ..columns };
            let samples = if PRE_CLASSIFIED {
                self.four_of_voxels(simd, edges, columns, n)
            } else {
                self.four_of_values(simd, edges, columns, n)
            };
            let added = self.composite_four(simd, transposed(samples), &Chunk { x: at.x + part, n, ..*at }, row);
            all.samples += added.samples;
            all.closed |= added.closed << part;
        }
        all
    }

    #[inline(always)]
    fn four_of_values<S: Simd, const N: usize>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        n: usize,
    ) -> [f32x4<S>; FOUR] {
        let (mut left, mut right) = (f32x4::splat(simd, 0.0), f32x4::splat(simd, 0.0));
        for e in 0..N {
            let edge = &self.voxels[edges.at[e] + columns.first..][..FOUR + 1];
            let voxels = |from: usize| f32x4::from_fn(simd, |i| edge[from + i].to_f32());
            left += voxels(0) * edges.of_voxels[e];
            right += voxels(1) * edges.of_voxels[e];
        }
        let value = left + (right - left) * columns.of_voxels();
        let nothing = f32x4::splat(simd, P::LAST as f32);
        let place = (value * self.optics.scale + self.optics.bias).max(0.0).min(nothing);
        let counts = f32x4::load_array_ref(simd, &STEPS).simd_lt(n as f32);
        let place: i32x4<S> = counts.select(place, nothing).to_int();
        let place = place.to_array();
        let mut samples = place.map(|i| f32x4::load_array_ref(simd, P::row(&self.lengths.table, i as u32 as usize)));
        if SHADING == BY_TABLE {
            for (i, sample) in samples[..n].iter_mut().enumerate() {
                *sample = self.lit(simd, edges, columns.first + i, columns.begin, *sample);
            }
        }
        samples
    }

    #[inline(always)]
    fn four_of_voxels<S: Simd, const N: usize>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        n: usize,
    ) -> [f32x4<S>; FOUR] {
        let nothing = f32x4::splat(simd, 0.0);
        let column = |i: usize| {
            let mut sum = nothing;
            for e in 0..N {
                let at = edges.at[e] + columns.first + i;
                let mut row = f32x4::load_array_ref(simd, self.row(&self.lengths.table, self.voxels[at]));
                if SHADING == BY_TABLE {
                    row = self.lit_voxel(simd, row, self.normals[at]);
                }
                sum += row * edges.of_voxels[e];
            }
            sum
        };
        let mut samples = [nothing; FOUR];
        let mut left = column(0);
        for (i, sample) in samples[..n].iter_mut().enumerate() {
            let right = column(i + 1);
            *sample = left + (right - left) * columns.of_voxels();
            left = right;
        }
        samples
    }

    #[inline(always)]
    fn composite_four<S: Simd>(
        &self,
        simd: S,
        [r, g, b, alpha]: [f32x4<S>; FOUR],
        at: &Chunk,
        row: &mut Row<'_>,
    ) -> Added {
        let mine = (1 << at.n) - 1;
        let opacity: &mut [f32; FOUR] = row.several(3, at.x);
        let before = f32x4::load_array_ref(simd, opacity);
        let open = before.simd_lt(self.termination);
        let clear = open.select(1.0 - before, f32x4::splat(simd, 0.0));
        let after = before + alpha * clear;
        let closed = (open & after.simd_ge(self.termination)).to_bitmask() as u32 & mine;
        let mut share = clear;
        if closed != 0 && self.level < 1.0 {
            share = clear * share_to_level(simd, clear, alpha, self.level).0;
            *opacity = after.min(self.level).to_array();
        } else {
            *opacity = after.to_array();
        }
        let crossing = before.simd_lt(self.half) & after.simd_ge(self.half);
        if crossing.any_true() {
            note_half(crossing.to_bitmask() as u32, at.x, &before.to_array(), &alpha.to_array(), at.slice, row);
        }
        for (component, light) in [r, g, b].into_iter().enumerate() {
            let sum: &mut [f32; FOUR] = row.several(component, at.x);
            *sum = (f32x4::load_array_ref(simd, sum) + light * share).to_array();
        }
        Added { samples: (open.to_bitmask() as u32 & mine).count_ones(), closed }
    }
}
