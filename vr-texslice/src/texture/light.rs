//! Textures of light and opacity: four floats a texel, or two, or a byte that a palette turns into four.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};
use vr_kernels::vector::{Cells, LANES, Lanes, transpose};

use super::{Texture, TextureVisitor};
use crate::classified::LightTexels;
use crate::palette::CODES;

/// Store of the light and opacity of texels.
trait Texels: Sync {
    /// (r, g, b, α) of a texel.
    fn at(&self, texel: usize) -> [f32; 4];
}

/// Red, green, blue and opacity.
struct Rgba<'a>(&'a [[f32; 4]]);

impl Texels for Rgba<'_> {
    #[inline(always)]
    fn at(&self, texel: usize) -> [f32; 4] {
        self.0[texel]
    }
}

/// Luminance and opacity.
struct Luminance<'a>(&'a [[f32; 2]]);

impl Texels for Luminance<'_> {
    #[inline(always)]
    fn at(&self, texel: usize) -> [f32; 4] {
        let [light, alpha] = self.0[texel];
        [light, light, light, alpha]
    }
}

/// Indices into a palette.
struct Indices<'a> {
    texels: &'a [u8],
    palette: &'a [[f32; 4]],
}

impl Texels for Indices<'_> {
    #[inline(always)]
    fn at(&self, texel: usize) -> [f32; 4] {
        self.palette[usize::from(self.texels[texel])]
    }
}

/// Indices into a palette for each level of the gradient's magnitude.
struct SteepIndices<'a> {
    texels: &'a [u8],
    levels: &'a [u8],
    palette: &'a [[f32; 4]],
}

impl Texels for SteepIndices<'_> {
    #[inline(always)]
    fn at(&self, texel: usize) -> [f32; 4] {
        // A palette that changes nowhere has one level, and all texels are on it.
        self.palette[usize::from(self.levels[texel]) * CODES + usize::from(self.texels[texel])]
    }
}

/// Texels that a palette colours, and the light that each reflects.
struct Shaded<'a, X> {
    colors: X,
    /// Factors on the three colours, and the three lights that are added to an opaque texel.
    reflections: &'a [[f32; 6]],
}

impl<X: Texels> Texels for Shaded<'_, X> {
    #[inline(always)]
    fn at(&self, texel: usize) -> [f32; 4] {
        let [r, g, b, alpha] = self.colors.at(texel);
        let [fr, fg, fb, ar, ag, ab] = self.reflections[texel];
        [r * fr + alpha * ar, g * fg + alpha * ag, b * fb + alpha * ab, alpha]
    }
}

/// Hands over a texture of light; the palette is that of indices.
///
/// # Panics
/// Panics if there are indices, and no palette: a bug in the caller.
pub(crate) fn visit_light<V: TextureVisitor>(
    texels: &LightTexels,
    palette: Option<&[[f32; 4]]>,
    dims: [usize; 3],
    visitor: V,
) -> V::Output {
    match texels {
        LightTexels::Rgba(texels) => visitor.visit(Light { texels: Rgba(texels), dims }),
        LightTexels::Luminance(texels) => visitor.visit(Light { texels: Luminance(texels), dims }),
        LightTexels::Indices { indices: texels, levels, reflections } => {
            let palette = palette.expect("indices have a palette");
            let reflections = reflections.as_deref();
            match levels {
                None => visit_palette(Indices { texels, palette }, reflections, dims, visitor),
                Some(levels) => visit_palette(SteepIndices { texels, levels, palette }, reflections, dims, visitor),
            }
        }
    }
}

/// Hands over a texture of texels that a palette colours, shaded where there are reflections.
fn visit_palette<X: Texels, V: TextureVisitor>(
    colors: X,
    reflections: Option<&[[f32; 6]]>,
    dims: [usize; 3],
    visitor: V,
) -> V::Output {
    match reflections {
        None => visitor.visit(Light { texels: colors, dims }),
        Some(reflections) => visitor.visit(Light { texels: Shaded { colors, reflections }, dims }),
    }
}

/// Light and opacity, linear along each axis.
struct Light<X> {
    texels: X,
    dims: [usize; 3],
}

/// The first of the eight texels around each of sixteen places.
#[derive(Default)]
pub(crate) struct Corners([i32; LANES]);

impl<X: Texels> Texture for Light<X> {
    type Stage = Corners;
    const LIGHT: bool = true;

    fn dims(&self) -> [usize; 3] {
        self.dims
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, _: S, at: &Cells<S>, stage: &mut Corners) {
        let [nx, ny, _] = self.dims.map(|n| n as i32);
        stage.0 = (at.cell[2] * (nx * ny) + at.cell[1] * nx + at.cell[0]).to_array();
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Corners) -> [f32x16<S>; 4] {
        let [nx, ny, _] = self.dims;
        let (row, slice) = (nx, nx * ny);
        let [tx, ty, tz] = [at.fraction[0].to_array(), at.fraction[1].to_array(), at.fraction[2].to_array()];
        let mut rows = [f32x4::splat(simd, 0.0); LANES];
        for i in 0..LANES {
            let o = stage.0[i] as u32 as usize;
            let mut sum = f32x4::splat(simd, 0.0);
            // Pairs along x, then the four of them, in the order of the scalar textures.
            for (corner, wy, wz) in [
                (o, 1.0 - ty[i], 1.0 - tz[i]),
                (o + row, ty[i], 1.0 - tz[i]),
                (o + slice, 1.0 - ty[i], tz[i]),
                (o + slice + row, ty[i], tz[i]),
            ] {
                let low = f32x4::load_array_ref(simd, &self.texels.at(corner));
                let high = f32x4::load_array_ref(simd, &self.texels.at(corner + 1));
                sum += (low + (high - low) * tx[i]) * (wy * wz);
            }
            rows[i] = sum;
        }
        transpose(rows)
    }

    fn gradient<S: Simd>(&self, _: S, _: &Cells<S>, _: u32, _: &mut Corners) -> [Lanes; 3] {
        [Lanes::ZERO; 3]
    }
}
