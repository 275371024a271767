//! Gradients at sixteen places of a field whose samples lie at uneven distances.

use fearless_simd::{Simd, f32x16};

use super::field::{Cells, Field, Pairs, Stage, bilinear};
use super::splat;

impl<T: Pairs> Field<'_, T> {
    /// Gradients interpolated between those at the samples around, which are sums of the rises below and above each. `factors`: for each axis, those of the
    /// rises below and above the sample under the place, and below and above the sample over it; the rise beyond the first or the last sample has factor 0.
    ///
    /// Interpolated across the axis first are planes of samples, as in the gradients of [`Shade`](super::Shade): where the field is constant, the
    /// gradient is zero to the last bit. `stage` is used up.
    #[inline(always)]
    pub fn uneven_gradients<S: Simd>(
        &self,
        simd: S,
        at: &Cells<S>,
        factors: &[[f32x16<S>; 4]; 3],
        stage: &mut Stage<T>,
    ) -> [f32x16<S>; 3] {
        let (one, t) = (splat(simd, 1.0), at.fraction);
        let mut gradient = [splat(simd, 0.0); 3];
        self.surround(simd, at.cell, &mut stage.around);
        for a in 0..3 {
            let [b, c] = [[1, 2], [0, 2], [0, 1]][a];
            let [below, low, high, above] = stage.around.planes(simd, a);
            let (below, low) = (bilinear(below, [t[b], t[c]]), bilinear(low, [t[b], t[c]]));
            let (high, above) = (bilinear(high, [t[b], t[c]]), bilinear(above, [t[b], t[c]]));
            // The rises between the planes, and their shares in the gradient.
            let back = one - t[a];
            let [low_below, low_above, high_below, high_above] = factors[a];
            gradient[a] = (low - below) * (back * low_below)
                + (high - low) * (back * low_above + t[a] * high_below)
                + (above - high) * (t[a] * high_above);
        }
        gradient
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::prelude::*;
    use fearless_simd::{Level, dispatch, i32x16};
    use vr_core::filter::Lattice;

    use super::*;

    /// Slopes of a trilinear function of the positions are exact, in the middle and at the faces.
    #[test]
    fn gradients_of_trilinear_functions_are_exact() {
        let places = [[0.0f32, 1.0, 3.0, 3.5], [0.0, 0.25, 0.75, 2.0], [-1.0, 0.0, 4.0, 4.5]];
        let f = |[x, y, z]: [f32; 3]| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z + 0.25 * x * y * z;
        let samples: Vec<f32> =
            (0..64).map(|i| f([places[0][i % 4], places[1][i / 4 % 4], places[2][i / 16]])).collect();
        let field = Field::new(&Lattice { samples: &samples, dims: [4; 3] });
        // Those of a parabola through three places, or of a line through two.
        let of = |axis: usize, k: usize| {
            let width = |k: usize| places[axis][k + 1] - places[axis][k];
            match k {
                0 => [0.0, 1.0 / width(0)],
                3 => [1.0 / width(2), 0.0],
                k => [
                    width(k) / width(k - 1) / (width(k) + width(k - 1)),
                    width(k - 1) / width(k) / (width(k) + width(k - 1)),
                ],
            }
        };
        for cell in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
            let t = [0.25f32, 0.5, 0.75];
            let at: [f32; 3] = std::array::from_fn(|a| {
                let places = &places[a][cell[a]..];
                places[0] + t[a] * (places[1] - places[0])
            });
            let got = dispatch!(Level::new(), simd => {
                let splat_all = |row: [f32; 4]| row.map(|x| splat(simd, x));
                let factors = [0, 1, 2].map(|a| {
                    let [low, high] = [of(a, cell[a]), of(a, cell[a] + 1)];
                    splat_all([low[0], low[1], high[0], high[1]])
                });
                let cells = Cells { cell: cell.map(|c| i32x16::splat(simd, c as i32)), fraction: t.map(|t| splat(simd, t)) };
                field.uneven_gradients(simd, &cells, &factors, &mut Stage::default()).map(|g| g[5])
            });
            let [x, y, z] = at;
            let want = [2.0 + 0.25 * y * z, -3.0 + 0.25 * x * z, 0.5 + 0.25 * x * y];
            assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-5), "{got:?} for {want:?}");
        }
    }
}
