//! Depths at which opaque surfaces end rays: those of pixels, from their layer, and those of texels.

use glam::{DVec2, DVec3};
use vr_core::Layer;

use crate::ray_distances::RayDistances;
use crate::sheet::{linear_weights, mean_of_sheet, tolerance};
use crate::slices::Slices;

/// Depths at which surfaces end the rays of a pass; +∞ where they do not, −∞ where a ray ends before the volume begins.
#[derive(Debug)]
pub(crate) struct SurfaceDepths {
    /// Row by row of the screen.
    pub(crate) pixels: Vec<f32>,
    /// Row by row of the intermediate image.
    pub(crate) texels: Vec<f32>,
    /// First and last depth of the volume.
    pub(crate) ends: [f32; 2],
    /// Largest difference of two depths that are one surface.
    pub(crate) tolerance: f32,
}

impl SurfaceDepths {
    /// Depths of a layer of `width` × `height` pixels. A texel's is linear between the pixels around it that lie on the same surface as the nearest.
    pub(crate) fn new(layer: &Layer, [width, height]: [u32; 2], slices: &Slices, distances: &RayDistances) -> Self {
        let f = &slices.factorization;
        let (to_texels, ends) = (f.texels_of_screen(), slices.depths);
        let [columns, rows] = [width, height].map(|n| n as usize);
        // Whatever lies behind the volume, or before it, is there to the last bit.
        let cut = |depth: f64| match depth {
            d if d >= ends[1] => f32::INFINITY,
            d if d <= ends[0] => f32::NEG_INFINITY,
            d => d as f32,
        };
        let of_pixel = |i: usize| {
            let screen = DVec2::new((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5);
            let texel = to_texels * screen.extend(1.0);
            // Rays of other passes have no depth along this axis.
            if texel.z <= 0.0 || layer.depth(i) == f64::INFINITY {
                return f32::INFINITY;
            }
            distances.depth(screen, texel.truncate() / texel.z, layer.depth(i)) as f32
        };
        let exact: Vec<f32> = (0..columns * rows).map(of_pixel).collect();
        let to_screen = to_texels.inverse();
        // Voxels from pixel to pixel, in the middle of the image.
        let middle = 0.5 * DVec2::new(f.size[0] as f64, f.size[1] as f64);
        let pixel = |off: f64| {
            let at = to_screen * (middle + off).extend(1.0);
            at.truncate() / at.z
        };
        let pitch = f.spacing * std::f64::consts::SQRT_2 / (pixel(1.0) - pixel(0.0)).length();
        let tolerance_of_pixels = tolerance(pitch.max(f.spacing));
        let between = |at: DVec3| -> f32 {
            if at.z <= 0.0 {
                return f32::INFINITY;
            }
            let at =
                (at.truncate() / at.z - 0.5).clamp(DVec2::ZERO, DVec2::new((columns - 1) as f64, (rows - 1) as f64));
            // `as` rounds down.
            let [x, y] = [at.x as usize, at.y as usize];
            let weights = linear_weights([(at.x - x as f64) as f32, (at.y - y as f64) as f32]);
            let (right, below) = ((x + 1).min(columns - 1), (y + 1).min(rows - 1));
            let depths = [(x, y), (right, y), (x, below), (right, below)].map(|(x, y)| exact[y * columns + x]);
            let nearest = (0..4).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
            if depths[nearest] == f32::INFINITY {
                return f32::INFINITY;
            }
            mean_of_sheet(depths, weights, tolerance_of_pixels).unwrap_or(f32::INFINITY)
        };
        let mut texels = Vec::with_capacity(f.size[0] * f.size[1]);
        for y in 0..f.size[1] {
            let row = (0..f.size[0]).map(|x| cut(between(to_screen * DVec3::new(x as f64, y as f64, 1.0)).into()));
            texels.extend(row);
        }
        let pixels = exact.into_iter().map(|depth| cut(depth.into())).collect();
        Self { pixels, texels, ends: ends.map(|d| d as f32), tolerance: tolerance(f.spacing) }
    }

    /// True if two depths are of the same surface, or both outside the volume on the same side.
    #[inline]
    pub(crate) fn agree(&self, a: f32, b: f32) -> bool {
        let [front, back] = self.ends;
        (a.clamp(front, back) - b.clamp(front, back)).abs() <= self.tolerance
    }
}
