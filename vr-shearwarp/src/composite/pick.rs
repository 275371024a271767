//! One value a ray: the largest sample, the smallest, or the mean.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::ColorGrid;
use vr_kernels::vector::{LANES, Operator, splat};

use super::cells::{Columns, Edges, values};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use crate::codes::Code;

/// Texels hold (value, weight, 0, 0) until they are classified, extremes when all slices are through; weight 0 where no sample was.
pub(crate) struct Pick<'a, P> {
    pub(crate) voxels: &'a [P],
    /// One that picks, among codes, which ascend with stored numbers.
    pub(crate) operator: Operator,
    pub(crate) light: PickedLight<'a>,
}

/// Light and opacity of values that are picked.
#[derive(Clone, Copy)]
pub(crate) struct PickedLight<'a> {
    /// Light and opacity of a code.
    pub(crate) of_code: &'a (dyn Fn(f64) -> [f64; 4] + Sync),
    /// Colours of voxels; `None` where they have none.
    pub(crate) colors: Option<&'a ColorGrid>,
}

impl PickedLight<'_> {
    /// Light and opacity of a code in a colour.
    fn tinted(&self, code: f64, [r, g, b]: [f64; 3]) -> [f32; 4] {
        let [red, green, blue, alpha] = (self.of_code)(code);
        [red * r, green * g, blue * b, alpha].map(|x| x as f32)
    }

    /// Classifies means: sums of values and their weights become light, in the mean colour of the ray, whose sums and weights texels hold where voxels have colours.
    pub(crate) fn of_means(&self, means: &[[f32; 4]], texels: &mut [[f32; 4]]) {
        for (&[value, weight, ..], texel) in means.iter().zip(texels) {
            if weight > 0.0 {
                let [r, g, b, of_colors] = texel.map(f64::from);
                let tint = if self.colors.is_some() { [r, g, b].map(|sum| sum / of_colors) } else { [1.0; 3] };
                *texel = self.tinted(f64::from(value) / f64::from(weight), tint);
            }
        }
    }
}

/// A ray that only touches the volume still meets a value.
pub(super) const MIN_SHARE: f32 = 1e-6;

impl<P: Code> Kernel for Pick<'_, P> {
    const CLOSES: bool = false;

    #[inline(always)]
    fn add<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: Chunk,
        shares: Option<&[f32; LANES]>,
        row: &mut Row<'_>,
    ) -> Added {
        let places = columns.places::<S, UNIT>(simd, edges.last);
        let value: f32x16<S> = values::<S, P, N, UNIT>(simd, self.voxels, edges, &places);
        let so_far =
            [f32x16::load_array_ref(simd, row.lanes(0, at.x)), f32x16::load_array_ref(simd, row.lanes(1, at.x))];
        let counts = at.taking(simd, shares);
        let share =
            shares.map_or(splat(simd, 1.0), |shares| f32x16::load_array_ref(simd, shares).max(splat(simd, MIN_SHARE)));
        let [chosen, weight] = self.operator.choose(simd, so_far, [value, share], counts);
        *row.lanes(0, at.x) = chosen.to_array();
        *row.lanes(1, at.x) = weight.to_array();
        if let Operator::Extreme { .. } = self.operator {
            let first = so_far[1].simd_le(splat(simd, 0.0));
            let changed = counts & (first | (chosen - so_far[0]).abs().simd_gt(splat(simd, 0.0)));
            row.note(simd, at.x, changed, at.slice);
        }
        Added { samples: at.n as u32, closed: 0 }
    }

    /// The depth of the sample that was picked, whose light the texel gets.
    fn finish(&self, seen: &Seen<'_>, texel: &mut [f32; 4]) -> f64 {
        let depth = seen.depth_of_slice();
        let tint = self.light.colors.map(|colors| colors.color(seen.index(depth, colors.values().dims())));
        *texel = self.light.tinted(texel[0].into(), tint.unwrap_or([1.0; 3]));
        depth
    }
}
