//! Gradients at sixteen places, from samples that have been staged.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};

use super::{LANES, splat, transpose};

/// Samples that the gradients at sixteen places are made of: the eight around each, x fastest; then for each axis four beyond the lower face across it and
/// four beyond the upper one, in the order of the other two axes.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Stencils([[f32; 32]; LANES]);

impl Default for Stencils {
    fn default() -> Self {
        Self([[0.0; 32]; LANES])
    }
}

impl Stencils {
    /// Samples of one place, to be filled.
    #[inline(always)]
    pub fn of_lane(&mut self, lane: usize) -> &mut [f32; 32] {
        &mut self.0[lane]
    }

    /// Four samples of all places, from one on.
    #[inline(always)]
    fn four<S: Simd>(&self, simd: S, first: usize) -> [f32x16<S>; 4] {
        let mut rows = [f32x4::splat(simd, 0.0); LANES];
        for (row, samples) in rows.iter_mut().zip(&self.0) {
            *row = f32x4::from_slice(simd, &samples[first..first + 4]);
        }
        transpose(rows)
    }

    /// Gradients per sample: central differences at the eight samples, interpolated trilinearly.
    ///
    /// Interpolated along the axis first are the differences, which are zero to the last bit where the field is constant.
    #[inline(always)]
    pub fn gradients<S: Simd>(&self, simd: S, t: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let one = splat(simd, 1.0);
        let (lower, upper) = (self.four(simd, 0), self.four(simd, 4));
        // The corners of the faces across each axis, in the order of the two others.
        let below = [
            [lower[0], lower[2], upper[0], upper[2]],
            [lower[0], lower[1], upper[0], upper[1]],
            [lower[0], lower[1], lower[2], lower[3]],
        ];
        let above = [
            [lower[1], lower[3], upper[1], upper[3]],
            [lower[2], lower[3], upper[2], upper[3]],
            [upper[0], upper[1], upper[2], upper[3]],
        ];
        let mut gradient = [splat(simd, 0.0); 3];
        for a in 0..3 {
            let [b, c] = [[1, 2], [0, 2], [0, 1]][a];
            let (back, on) = ((one - t[a]) * 0.5, t[a] * 0.5);
            let (before, behind) = (self.four(simd, 8 + 8 * a), self.four(simd, 12 + 8 * a));
            let mut corner = [splat(simd, 0.0); 4];
            for i in 0..4 {
                corner[i] = back * (above[a][i] - before[i]) + on * (behind[i] - below[a][i]);
            }
            let rows = [corner[0] + t[b] * (corner[1] - corner[0]), corner[2] + t[b] * (corner[3] - corner[2])];
            gradient[a] = rows[0] + t[c] * (rows[1] - rows[0]);
        }
        gradient
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// Central differences of a trilinear function are its slopes.
    #[test]
    fn gradients_of_trilinear_functions_are_exact() {
        let f = |[x, y, z]: [f32; 3]| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z + 4.0 * x * y * z;
        let mut samples = [0.0; 32];
        for (i, sample) in samples.iter_mut().enumerate() {
            let (t, u, beyond) = ((i & 1) as f32, (i >> 1 & 1) as f32, if i & 4 == 0 { -1.0 } else { 2.0 });
            *sample = f(match i {
                0..8 => [t, u, (i >> 2) as f32],
                8..16 => [beyond, t, u],
                16..24 => [t, beyond, u],
                _ => [t, u, beyond],
            });
        }
        let mut stencils = Stencils::default();
        *stencils.of_lane(5) = samples;
        let [x, y, z] = [0.25, 0.5, 0.75];
        let got = dispatch!(Level::new(), simd => {
            stencils.gradients(simd, [splat(simd, x), splat(simd, y), splat(simd, z)]).map(|g| g[5])
        });
        let want = [2.0 + 4.0 * y * z, -3.0 + 4.0 * x * z, 0.5 + 4.0 * x * y];
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-6), "{got:?} for {want:?}");
    }
}
