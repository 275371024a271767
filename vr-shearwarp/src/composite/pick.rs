//! One value a ray: the largest sample, the smallest, or the mean.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{LANES, Operator, splat};

use super::cells::{Columns, Edges, values};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use crate::codes::Code;

/// Texels hold (value, weight, 0, 0) until they are classified; weight 0 where no sample was.
pub(crate) struct Pick<'a, P> {
    pub(crate) voxels: &'a [P],
    /// One that picks, among codes, which ascend with stored numbers.
    pub(crate) operator: Operator,
}

/// A ray that only touches the volume still meets a value.
const MIN_SHARE: f32 = 1e-6;

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

    /// The depth of the sample that was picked.
    fn finish(&self, seen: &Seen<'_>, _: &mut [f32; 4]) -> f64 {
        seen.depth_of_slice()
    }
}
