//! A texture of values in compressed blocks, each texel decoded as it is fetched.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::GradientMethod;
use vr_kernels::vector::{Cells, LANES, Lanes};

use super::Texture;
use super::interpolant::slopes;
use crate::compression::Compressed;

/// Values of a compressed volume, linear along each axis.
pub(crate) struct Blocks<'a> {
    pub(crate) compressed: &'a Compressed,
    pub(crate) method: GradientMethod,
}

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
        self.compressed.dims()
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, _: S, at: &Cells<S>, stage: &mut Decoded) {
        let [x, y, z] = [at.cell[0].to_array(), at.cell[1].to_array(), at.cell[2].to_array()];
        for i in 0..LANES {
            let corners = self.compressed.cell([x[i], y[i], z[i]].map(|c| c as u32 as usize));
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

    /// Gradients of what the blocks hold: those of a smooth field are as rough as its levels.
    #[inline(always)]
    fn gradient<S: Simd>(&self, simd: S, at: &Cells<S>, wanted: u32, stage: &mut Decoded) -> [Lanes; 3] {
        if self.method == GradientMethod::Analytic {
            self.fetch(simd, at, stage);
            return slopes(simd, at, |axis| {
                let step = 1 << axis;
                let [b, c] = [[2, 4], [1, 4], [1, 2]][axis];
                let corner = |i: usize| stage.0[i].load(simd);
                let face = |first: usize| [corner(first), corner(first + b), corner(first + c), corner(first + b + c)];
                [face(0), face(step)]
            });
        }
        differences(at, wanted, [0; 3], |at| self.compressed.gradient_at(at))
    }
}

/// Gradients per index step of some lanes, found one by one at the volume's own positions: places are counted from the cell `first` on.
#[inline(always)]
pub(super) fn differences<S: Simd>(
    at: &Cells<S>,
    wanted: u32,
    first: [usize; 3],
    gradient_at: impl Fn([f32; 3]) -> [f32; 3],
) -> [Lanes; 3] {
    let at: [[f32; LANES]; 3] = std::array::from_fn(|a| {
        let (cell, fraction) = (at.cell[a].to_array(), at.fraction[a].to_array());
        std::array::from_fn(|i| (cell[i] + first[a] as i32) as f32 + fraction[i])
    });
    let mut gradient = [Lanes::ZERO; 3];
    for i in (0..LANES).filter(|i| wanted >> i & 1 == 1) {
        let found = gradient_at([at[0][i], at[1][i], at[2][i]]);
        (0..3).for_each(|a| gradient[a].0[i] = found[a]);
    }
    gradient
}
