//! Shading of sixteen samples: gradients by central differences, and the light that they reflect.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use glam::DVec3;

use super::field::{Cells, Field, Pairs, Stage};
use super::{LANES, Lanes, ln, opacity_of_depth, pick, splat};
use vr_core::{Light, Placement, Shading};

/// Shading, the same for all rays.
#[derive(Clone, Debug)]
pub struct PacketShading {
    /// Coefficients.
    pub shading: Arc<Shading>,
    /// The lights.
    pub lights: Vec<Light>,
    /// Matrix from gradients per index step to world gradients, but for their length.
    pub to_world: [[f32; 3]; 3],
}

impl PacketShading {
    /// Shading for gradients of a grid whose axes are taken in this order.
    pub fn new(shading: Arc<Shading>, lights: &[Light], placement: &Placement, axes: [usize; 3]) -> Self {
        let (matrix, _) = placement.scaled_gradient_matrix(1.0);
        let to_world = std::array::from_fn(|row| axes.map(|a| matrix.col(a)[row] as f32));
        Self { shading, lights: lights.to_vec(), to_world }
    }
}

/// The lights as the rays of a packet see them.
#[derive(Clone, Debug, Default)]
pub struct PacketLights {
    lights: Vec<PacketLight>,
    /// Directions of the rays that they were made for.
    directions: Option<[[f64; LANES]; 3]>,
}

#[derive(Clone, Debug)]
struct PacketLight {
    /// Unit vectors towards the light.
    to_light: [Lanes; 3],
    /// Unit vectors between light and eye; zero where they are opposite.
    half: [Lanes; 3],
    color: [f32; 3],
}

impl PacketLights {
    /// Makes them for rays of these (unit) directions, unless they are for those already.
    pub fn look_along(&mut self, lights: &[Light], directions: &[[f64; LANES]; 3]) {
        if self.directions.as_ref() == Some(directions) {
            return;
        }
        self.directions = Some(*directions);
        self.lights.clear();
        self.lights.extend(lights.iter().map(|light| {
            let mut seen = PacketLight {
                to_light: [Lanes::ZERO; 3],
                half: [Lanes::ZERO; 3],
                color: light.color.map(|c| c as f32),
            };
            for i in 0..LANES {
                let to_eye = -DVec3::new(directions[0][i], directions[1][i], directions[2][i]);
                let to_light = light.direction.map_or(to_eye, DVec3::normalize);
                let half = (to_light + to_eye).normalize_or_zero();
                for a in 0..3 {
                    seen.to_light[a].0[i] = to_light[a] as f32;
                    seen.half[a].0[i] = half[a] as f32;
                }
            }
            seen
        }));
    }
}

/// Shading and lights for the samples of a packet.
#[derive(Clone, Copy)]
pub struct Shade<'a> {
    /// Shading, the same for all rays.
    pub shading: &'a PacketShading,
    /// Lights as the rays of this packet see them.
    pub lights: &'a PacketLights,
}

impl Shade<'_> {
    /// Shades light of sixteen samples: c becomes c·(ka + kd Σ L|n·l|), and ks Σ L|n·h|^p times opacity is added. Where the gradient is
    /// zero, it stays. Its own function: there are samples that need no shading, and instances of it for each kernel would be many.
    #[inline(never)]
    pub fn apply<S: Simd, T: Pairs>(
        &self,
        simd: S,
        field: &Field<'_, T>,
        at: &[[Lanes; 3]; 2],
        light: &mut [Lanes; 4],
        stage: &mut Stage<T>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.apply_here(simd, field, at, light, stage),
        );
    }

    #[inline(always)]
    fn apply_here<S: Simd, T: Pairs>(
        &self,
        simd: S,
        field: &Field<'_, T>,
        at: &[[Lanes; 3]; 2],
        light: &mut [Lanes; 4],
        stage: &mut Stage<T>,
    ) {
        // World gradients, normalised.
        let g = gradient(simd, field, at, stage);
        let m = &self.shading.to_world;
        let world = |row: [f32; 3]| g[0] * row[0] + g[1] * row[1] + g[2] * row[2];
        let w = [world(m[0]), world(m[1]), world(m[2])];
        // Scaled by its largest component, so that the square neither underflows nor overflows.
        let zero = splat(simd, 0.0);
        let largest = w[0].abs().max(w[1].abs()).max(w[2].abs());
        let flat = largest.simd_le(zero);
        let one = splat(simd, 1.0);
        let scale = one / pick(flat, one, largest);
        let n = [w[0] * scale, w[1] * scale, w[2] * scale];
        let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        let norm = one / pick(flat, one, square).sqrt();
        // The factor on the colour and the light that is added, summed over the lights.
        let shading = &self.shading.shading;
        let (ambient, diffuse) = (shading.ambient as f32, shading.diffuse as f32);
        let (specular, power) = (shading.specular as f32, shading.power as f32);
        let mut factor = [splat(simd, ambient); 3];
        let mut added = [zero; 3];
        for seen in &self.lights.lights {
            let along = |v: &[Lanes; 3]| {
                let dot = n[0] * v[0].load(simd) + n[1] * v[1].load(simd) + n[2] * v[2].load(simd);
                (dot * norm).abs().min(one)
            };
            let facing = along(&seen.to_light) * diffuse;
            // x^p = e^(p ln x).
            let highlight = ln(simd, along(&seen.half).max(splat(simd, f32::MIN_POSITIVE))).min(zero) * -power;
            let highlight = (one - opacity_of_depth(simd, highlight)) * specular;
            for c in 0..3 {
                factor[c] += facing * seen.color[c];
                added[c] += highlight * seen.color[c];
            }
        }
        let alpha = light[3].load(simd);
        for c in 0..3 {
            let old = light[c].load(simd);
            light[c] = Lanes::new(pick(flat, old, old * factor[c] + added[c] * alpha));
        }
    }
}

/// Gradients per index step: central differences at the voxels, one-sided at the faces of the box, interpolated trilinearly. Positions
/// are the numbers of the cells (whole numbers), and fractions in them.
///
/// Interpolation commutes with shifts by whole voxels. So a component is the difference of two interpolations, a voxel on and a voxel
/// back, with weights (1 − t)/w₀ and t/w₁ along the axis, w the voxels that each difference spans; beyond a face lies the last voxel
/// again. Planes of voxels are interpolated across the axis first, and subtracted then: where the field is constant, the gradient is
/// zero to the last bit, and nothing is shaded by what rounding leaves.
#[inline(always)]
fn gradient<S: Simd, T: Pairs>(
    simd: S,
    field: &Field<'_, T>,
    [cell, fraction]: &[[Lanes; 3]; 2],
    stage: &mut Stage<T>,
) -> [f32x16<S>; 3] {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let cell = [cell[0].load(simd), cell[1].load(simd), cell[2].load(simd)];
    let t = [fraction[0].load(simd), fraction[1].load(simd), fraction[2].load(simd)];
    let mut gradient = [zero; 3];
    for a in 0..3 {
        let last = splat(simd, field.last_cell[a] as f32);
        let (first, at_last) = (cell[a].simd_le(zero), cell[a].simd_ge(last));
        let half = splat(simd, 0.5);
        let (back, on) = ((one - t[a]) * pick(first, one, half), t[a] * pick(at_last, one, half));
        // The planes at either end of the cell a voxel on, and a voxel back.
        let mut planes = [[zero; 2]; 2];
        for (planes, shift) in planes.iter_mut().zip([1.0, -1.0]) {
            let mut shifted = cell;
            shifted[a] = (cell[a] + shift).max(zero).min(last);
            let cells = Cells {
                cell: [
                    shifted[0].to_int::<i32x16<S>>(),
                    shifted[1].to_int::<i32x16<S>>(),
                    shifted[2].to_int::<i32x16<S>>(),
                ],
                fraction: t,
            };
            field.fetch(simd, &cells, stage);
            let mut weights = [[one - t[0], t[0]], [one - t[1], t[1]], [one - t[2], t[2]]];
            weights[a] = [one, zero];
            planes[0] = field.weighted(simd, &weights, stage);
            weights[a] = [zero, one];
            planes[1] = field.weighted(simd, &weights, stage);
        }
        // Beyond the upper face the upper plane is there twice, beyond the lower one the lower.
        let [[on_low, on_high], [back_low, back_high]] = planes;
        let low = pick(at_last, on_high, on_low) - back_low;
        let high = on_high - pick(first, back_low, back_high);
        gradient[a] = back * low + on * high;
    }
    gradient
}
