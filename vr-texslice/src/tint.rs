//! Colours of voxels at fragments.

use fearless_simd::Simd;
use vr_core::ColorGrid;
use vr_kernels::vector::{Lanes, VoxelColors, inside};

use crate::draw::{Chunk, SampleSet};
use crate::fragments::Fragments;
use crate::layout::Layout;
use crate::texture::on_slices;

/// Colours of voxels, in the coordinates of slices.
pub(crate) struct Tint<'a> {
    colors: VoxelColors<'a>,
    layout: Layout,
    /// Index of the last texel along the last axis of texture coordinates.
    last: f32,
}

impl<'a> Tint<'a> {
    pub(crate) fn new(colors: &'a ColorGrid, layout: Layout) -> Self {
        let last = (layout.turned(colors.values().dims())[2] - 1) as f32;
        Self { colors: VoxelColors::new(colors), layout, last }
    }

    /// Colours of the samples `j` behind these, where the texture is read for them; or in the middle of the segments that end at them.
    fn at<S: Simd>(&self, simd: S, rays: &Fragments, which: SampleSet<'_>, segments: bool, j: usize) -> [Lanes; 3] {
        let mut place = [Lanes::ZERO; 3];
        simd.vectorize(
            #[inline(always)]
            || {
                let [x, y, mut z] = if segments { which.middle(simd, rays, j) } else { which.position(simd, rays, j) };
                if let Some(per_layer) = self.layout.per_layer.filter(|_| !segments) {
                    z = on_slices(simd, inside(simd, z, self.last), per_layer as f32, self.last);
                }
                place = self.layout.turned_back([Lanes::new(x), Lanes::new(y), Lanes::new(z)]);
            },
        );
        self.colors.at(simd, &place)
    }

    /// Multiplies the light of a chunk's samples by their colours.
    pub(crate) fn multiply<S: Simd>(
        &self,
        simd: S,
        rays: &Fragments,
        which: SampleSet<'_>,
        segments: bool,
        chunk: &mut Chunk,
    ) {
        for j in 0..chunk.len {
            let tint = self.at(simd, rays, which, segments, j);
            for (light, tint) in chunk.light[j].iter_mut().zip(tint) {
                for (light, tint) in light.0.iter_mut().zip(tint.0) {
                    *light *= tint;
                }
            }
        }
    }

    /// Puts the colours of samples in the place of a chunk's light: of what is averaged, which has no other.
    pub(crate) fn put<S: Simd>(&self, simd: S, rays: &Fragments, which: SampleSet<'_>, chunk: &mut Chunk) {
        for j in 0..chunk.len {
            let [r, g, b] = self.at(simd, rays, which, false, j);
            chunk.light[j] = [r, g, b, Lanes::ZERO];
        }
    }
}
