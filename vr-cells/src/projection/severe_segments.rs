//! Segments of a cell that take more than one step.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{LANES, splat};

use super::samples::{Numbers, SPARE, Samples};
use super::segment_light::LightTable;
use super::steps::Segments;

/// Segments of a cell that are added in parts, put together so that no lane waits for a severe neighbour.
pub(super) struct SevereSegments {
    /// Samples, places in the table at both ends, distance at the first, and length.
    numbers: [u32; 2 * LANES],
    rows: [[f32; 2 * LANES]; 4],
    pub(super) count: usize,
}

impl SevereSegments {
    /// None.
    pub(super) fn new() -> Self {
        Self { numbers: [SPARE; 2 * LANES], rows: [[0.0; 2 * LANES]; 4], count: 0 }
    }

    /// Keeps those of sixteen segments that are severe, where there is room for all.
    #[inline(always)]
    pub(super) fn keep<S: Simd>(&mut self, numbers: &Numbers, segments: &Segments<S>, severe: mask32x16<S>) {
        let Segments { ends: [from, to], near, length } = segments;
        let rows = [from.to_array(), to.to_array(), near.to_array(), length.to_array()];
        let mut left = severe.to_bitmask();
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            self.numbers[self.count] = numbers[i];
            for k in 0..4 {
                self.rows[k][self.count] = rows[k][i];
            }
            self.count += 1;
        }
    }

    /// Adds the first sixteen.
    #[inline(always)]
    pub(super) fn flush<S: Simd>(&mut self, simd: S, light: &LightTable<'_>, samples: &mut Samples) {
        let (numbers, _) = self.numbers.as_chunks::<LANES>();
        let mut rows = [splat(simd, 0.0); 4];
        for k in 0..4 {
            rows[k] = f32x16::load_array_ref(simd, &self.rows[k].as_chunks::<LANES>().0[0]);
        }
        let [from, to, near, length] = rows;
        let segments = Segments { ends: [from, to], near, length };
        light.add_parts(simd, samples, &numbers[0], &segments);
        self.count = self.count.saturating_sub(LANES);
        self.numbers.copy_within(LANES.., 0);
        (0..4).for_each(|k| self.rows[k].copy_within(LANES.., 0));
    }

    /// Adds what is left, before the next cell.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&mut self, simd: S, light: &LightTable<'_>, samples: &mut Samples) {
        if self.count > 0 {
            self.numbers[self.count..].fill(SPARE);
            (0..4).for_each(|k| self.rows[k][self.count..].fill(0.0));
            self.flush(simd, light, samples);
        }
    }
}
