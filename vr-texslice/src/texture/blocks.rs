//! A texture of values in compressed blocks, each texel decoded as it is fetched.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Cells, LANES, Lanes, Shade};

use super::{Lit, Texture};
use crate::compression::Compressed;

/// Values of a compressed volume, linear along each axis.
pub(crate) struct Blocks<'a>(pub(crate) &'a Compressed);

/// The eight texels around each of sixteen places, x fastest.
pub(crate) struct Decoded([Lanes; 8]);

impl Default for Decoded {
    fn default() -> Self {
        Self([Lanes::ZERO; 8])
    }
}

impl Texture for Blocks<'_> {
    type Stage = Decoded;
    const LIGHT: bool = false;

    fn dims(&self) -> [usize; 3] {
        self.0.dims()
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, _: S, at: &Cells<S>, stage: &mut Decoded) {
        let [x, y, z] = [at.cell[0].to_array(), at.cell[1].to_array(), at.cell[2].to_array()];
        for i in 0..LANES {
            let corners = self.0.cell([x[i], y[i], z[i]].map(|c| c as u32 as usize));
            for (lanes, value) in stage.0.iter_mut().zip(corners) {
                lanes.0[i] = value;
            }
        }
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Decoded) -> [f32x16<S>; 4] {
        let [tx, ty, tz] = at.fraction;
        let [c0, c1, c2, c3, c4, c5, c6, c7] = &stage.0;
        let pair = |a: &Lanes, b: &Lanes| a.load(simd) + tx * (b.load(simd) - a.load(simd));
        let (f00, f10, f01, f11) = (pair(c0, c1), pair(c2, c3), pair(c4, c5), pair(c6, c7));
        let (f0, f1) = (f00 + ty * (f10 - f00), f01 + ty * (f11 - f01));
        [f0 + tz * (f1 - f0); 4]
    }

    /// By gradients of what the blocks hold: those of a smooth field are as rough as its levels.
    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, at: &Cells<S>, with: &Lit<'_>, light: &mut [Lanes; 4], _: &mut Decoded) {
        let at: [[f32; LANES]; 3] = std::array::from_fn(|a| {
            let (cell, fraction) = (at.cell[a].to_array(), at.fraction[a].to_array());
            std::array::from_fn(|i| cell[i] as f32 + fraction[i])
        });
        shade_by_gradients(simd, &at, with, light, |at| self.0.gradient_at(at));
    }
}

/// Shades light at places by gradients per index step, found one by one.
#[inline(always)]
pub(crate) fn shade_by_gradients<S: Simd>(
    simd: S,
    at: &[[f32; LANES]; 3],
    with: &Lit<'_>,
    light: &mut [Lanes; 4],
    gradient_at: impl Fn([f32; 3]) -> [f32; 3],
) {
    let mut gradient = [Lanes::ZERO; 3];
    // False for NaN, which is vacuum.
    for i in (0..LANES).filter(|&i| light[3].0[i] > 0.0) {
        let found = gradient_at([at[0][i], at[1][i], at[2][i]]);
        (0..3).for_each(|a| gradient[a].0[i] = found[a]);
    }
    Shade { shading: with.shading, lights: with.lights }.apply_to_gradients(simd, &gradient, light);
}
