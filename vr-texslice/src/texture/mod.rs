//! Textures: what is fetched at a fragment, sixteen fragments at a time.

mod blocks;
mod brick;
mod interpolant;
mod light;
mod sliced;
mod voxels;

pub(crate) use blocks::Blocks;
pub(crate) use brick::{BrickPart, Decoded, InBrick};
pub(crate) use light::visit_light;
pub(crate) use sliced::{InSlices, on_slices};
pub(crate) use voxels::{Relief, Voxels};

use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Cells, Lanes, cells, inside};

/// A texture, as fragments see it.
pub(crate) trait Texture: Sync {
    /// Buffer of texels between their fetch and their use: a wide load from narrow stores takes its time, and that of another fragment's fetch hides
    /// it.
    type Stage: Default;
    /// True if texels are light and opacity; else they are values.
    const LIGHT: bool;

    /// Texels along each axis.
    fn dims(&self) -> [usize; 3];

    /// Places of samples by their positions, which rounding may have carried past a face.
    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, position: [f32x16<S>; 3]) -> Cells<S> {
        self.place_between(simd, position)
    }

    /// Fetches what places need.
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Self::Stage);

    /// Interpolates what was fetched: light and opacity, or a value as the first of four.
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Self::Stage) -> [f32x16<S>; 4];

    /// Places of points between samples, where only the gradient is read; in a stack these lie between its slices.
    #[inline(always)]
    fn place_between<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> Cells<S> {
        let dims = self.dims();
        let max = dims.map(|n| (n - 1) as f32);
        let position = [inside(simd, x, max[0]), inside(simd, y, max[1]), inside(simd, z, max[2])];
        cells(simd, position, dims.map(|n| n as i32 - 2))
    }

    /// Gradients per step of texture coordinates at places, of the lanes in `wanted`; those of other lanes are of no use. Zero of textures that hold light:
    /// gradients were looked at when they were made.
    fn gradient<S: Simd>(&self, simd: S, at: &Cells<S>, wanted: u32, stage: &mut Self::Stage) -> [Lanes; 3];
}

/// Work on a texture of whatever type.
pub(crate) trait TextureVisitor {
    type Output;

    fn visit<X: Texture>(self, texture: X) -> Self::Output;
}
