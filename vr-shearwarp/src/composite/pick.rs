//! One value a ray: the largest sample, the smallest, or the mean.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{LANES, Operator, pick, splat};

use super::cells::{Columns, Edges, STEPS_F32, values};
use super::kernel::{Added, Chunk, Kernel, PLACE, Row, Seen};
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
    const AT_ONCE: usize = LANES;

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
        let mut counts = f32x16::load_array_ref(simd, &STEPS_F32).simd_lt(splat(simd, at.n as f32));
        let mut share = splat(simd, 1.0);
        if let Some(shares) = shares {
            let shares = f32x16::load_array_ref(simd, shares);
            counts &= shares.simd_ge(splat(simd, 0.0));
            share = shares.max(splat(simd, MIN_SHARE));
        }
        let [chosen, weight] = self.operator.choose(simd, so_far, [value, share], counts);
        *row.lanes(0, at.x) = chosen.to_array();
        *row.lanes(1, at.x) = weight.to_array();
        if let Operator::Extreme { .. } = self.operator {
            let first = so_far[1].simd_le(splat(simd, 0.0));
            let changed = counts & (first | (chosen - so_far[0]).abs().simd_gt(splat(simd, 0.0)));
            let places = row.lanes(PLACE, at.x);
            *places = pick(changed, splat(simd, at.slice), f32x16::load_array_ref(simd, places)).to_array();
        }
        Added { samples: at.n as u32, closed: 0 }
    }

    /// The depth of the sample that was picked.
    fn finish(&self, seen: &Seen<'_>, _: &mut [f32; 4]) -> f64 {
        seen.depth_of_slice()
    }
}
