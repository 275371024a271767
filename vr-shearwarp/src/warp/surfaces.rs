//! Interpolation that keeps to one side of the outline of an opaque surface.
//!
//! Texels end where the surface along their own rays is, pixels where it is along theirs. A pixel beside an outline takes the texels alone whose
//! surface is its own (joint bilateral upsampling: Kopf et al. 2007), so that no light of the other side leaks over.

use super::Warp;
use crate::sheet::linear_weights;

impl Warp<'_> {
    /// Weights of the four texels around a position, for a pixel: those under linear interpolation; where only some of the texels end at the pixel's
    /// own surface, of those alone.
    pub(super) fn weights_for(&self, pixel: usize, [column, row]: [i32; 2], at: [f32; 2]) -> [f32; 4] {
        let linear = linear_weights(at);
        let Some(surfaces) = self.surfaces else { return linear };
        let stop = surfaces.pixels[pixel];
        let mut weights = linear;
        for (i, weight) in weights.iter_mut().enumerate() {
            let agrees = self.index_of([column + (i & 1) as i32, row + (i >> 1) as i32]);
            if !agrees.is_some_and(|texel| surfaces.agree(surfaces.texels[texel], stop)) {
                *weight = 0.0;
            }
        }
        let sum: f32 = weights.iter().sum();
        if sum > 0.0 { weights.map(|w| w / sum) } else { linear }
    }

    /// The mean of the texels that end at the pixel's own surface; `None` where all `N`² around the position do, and the filter may take them.
    pub(super) fn beside_outline<const N: usize>(
        &self,
        pixel: usize,
        [column, row]: [i32; 2],
        at: [f32; 2],
    ) -> Option<[f32; 4]> {
        let surfaces = self.surfaces?;
        let stop = surfaces.pixels[pixel];
        let before = (N / 2) as i32 - 1;
        let disagrees = |i: i32, j: i32| {
            let texel = self.index_of([column - before + i, row - before + j]);
            texel.is_some_and(|texel| !surfaces.agree(surfaces.texels[texel], stop))
        };
        if !(0..N as i32).any(|j| (0..N as i32).any(|i| disagrees(i, j))) {
            return None;
        }
        let weights = self.weights_for(pixel, [column, row], at);
        let mut mean = [0.0; 4];
        for (i, weight) in weights.into_iter().enumerate() {
            if let Some(texel) = self.index_of([column + (i & 1) as i32, row + (i >> 1) as i32]) {
                let texel = self.texture.pixels[texel];
                mean = std::array::from_fn(|c| mean[c] + weight * texel[c]);
            }
        }
        Some(mean)
    }

    /// Index of a texel; `None` outside the texture.
    pub(super) fn index_of(&self, [column, row]: [i32; 2]) -> Option<usize> {
        let [width, height] = self.texture.size;
        // What is negative wraps around, to beyond any size.
        let (x, y) = (column as u32 as usize, row as u32 as usize);
        (x < width && y < height).then_some(y * width + x)
    }
}
