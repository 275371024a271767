//! Linear along each axis.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, f32x16};

use super::Kernel;

/// Means of two texels along y, and of those along x. A constant texture gives that constant, to the bit.
pub(super) struct Bilinear;

impl Kernel<2> for Bilinear {
    #[inline(always)]
    fn weights<S: Simd>(simd: S, t: f32x16<S>) -> [f32x16<S>; 2] {
        [f32x16::splat(simd, 1.0) - t, t]
    }

    /// a + t·(b − a): the first weight is not read.
    #[inline(always)]
    fn blend<S: Simd>(
        simd: S,
        taps: [&[[f32; 4]; 2]; 2],
        x: &[f32x16<S>; 2],
        y: &[f32x16<S>; 2],
        lane: usize,
    ) -> f32x4<S> {
        let above = f32x8::from_slice(simd, taps[0].as_flattened());
        let below = f32x8::from_slice(simd, taps[1].as_flattened());
        let (left, right) = (above + (below - above) * y[1].as_array()[lane]).split();
        left + (right - left) * x[1].as_array()[lane]
    }
}
