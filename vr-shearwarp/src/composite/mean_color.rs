//! Mean colours of rays.

use fearless_simd::Simd;
use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use vr_kernels::vector::{LANES, Operator, splat};

use super::by_gradient::tints;
use super::cells::{Columns, Edges};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use super::pick::MIN_SHARE;

/// Texels hold sums of red, green and blue, and the weight that these are to be divided by.
pub(crate) struct MeanColor<'a> {
    /// Colours of voxels, channel by channel.
    pub(crate) colors: [&'a [u16]; 3],
}

impl Kernel for MeanColor<'_> {
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
        let tint = tints::<S, N, UNIT>(simd, &self.colors, edges, &places);
        let counts = at.taking(simd, shares);
        let share =
            shares.map_or(splat(simd, 1.0), |shares| f32x16::load_array_ref(simd, shares).max(splat(simd, MIN_SHARE)));
        let weight = f32x16::load_array_ref(simd, row.lanes(3, at.x));
        let mut after = weight;
        for c in 0..3 {
            let sum = f32x16::load_array_ref(simd, row.lanes(c, at.x));
            let [next, sum_of_weights] = Operator::Average.choose(simd, [sum, weight], [tint[c], share], counts);
            *row.lanes(c, at.x) = next.to_array();
            after = sum_of_weights;
        }
        *row.lanes(3, at.x) = after.to_array();
        Added { samples: at.n as u32, closed: 0 }
    }

    /// A mean is nowhere.
    fn finish(&self, _: &Seen<'_>, _: &mut [f32; 4]) -> f64 {
        f64::INFINITY
    }
}
