//! Cubic convolution (Keys 1981, *Cubic convolution interpolation for digital image processing*, IEEE Trans. ASSP 29(6), a = −½).

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};

use super::Kernel;

/// Four taps along each axis: passes through the texels, has a continuous gradient, reproduces quadratics.
pub(super) struct Cubic;

impl Kernel<4> for Cubic {
    /// Keys' u(s) at s = 1 + t, t, 1 − t, 2 − t:
    /// ½t(t(2 − t) − 1), ½(t²(3t − 5) + 2), ½t(t(4 − 3t) + 1), ½t²(t − 1).
    #[inline(always)]
    fn weights<S: Simd>(simd: S, t: f32x16<S>) -> [f32x16<S>; 4] {
        let c = f32x16::splat(simd, 0.0);
        let (one, two, three) = (c + 1.0, c + 2.0, c + 3.0);
        let half = t * 0.5;
        [
            half * (t * (two - t) - one),
            t * half * (three * t - (c + 5.0)) + one,
            half * (t * (c + 4.0 - three * t) + one),
            t * half * (t - one),
        ]
    }

    /// Cut off where the filter overshoots: colour below 0, opacity outside [0, 1]. What is not a number becomes 0.
    #[inline(always)]
    fn blend<S: Simd>(
        simd: S,
        taps: [&[[f32; 4]; 4]; 4],
        x: &[f32x16<S>; 4],
        y: &[f32x16<S>; 4],
        lane: usize,
    ) -> f32x4<S> {
        let mut sum = f32x16::splat(simd, 0.0);
        for j in 0..4 {
            sum += f32x16::from_slice(simd, taps[j].as_flattened()) * y[j].as_array()[lane];
        }
        let (left, right) = sum.split();
        let ((a, b), (c, d)) = (left.split(), right.split());
        let sum = (a * x[0].as_array()[lane] + b * x[1].as_array()[lane])
            + (c * x[2].as_array()[lane] + d * x[3].as_array()[lane]);
        // Not `max`: it leaves open which of two zeros it returns.
        let zero = f32x4::splat(simd, 0.0);
        let max = f32x4::load_array(simd, [f32::MAX, f32::MAX, f32::MAX, 1.0]);
        sum.simd_gt(zero).select(sum.min(max), zero)
    }
}
