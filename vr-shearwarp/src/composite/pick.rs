//! One value a ray: the largest sample, the smallest, or the mean.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::{Calibration, Compositing};
use vr_kernels::vector::{LANES, pick, splat};

use super::cells::{Columns, Edges, STEPS_F32, values};
use super::kernel::{Added, Chunk, Kernel, Row};
use crate::codes::Code;

/// Which code a ray is left with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    Largest,
    Smallest,
    Mean,
}

impl Choice {
    /// The choice that an operator makes among codes, which ascend with stored numbers: `None` where light is integrated.
    pub(crate) fn of(compositing: Compositing, calibration: Calibration) -> Option<Self> {
        // A negative slope turns the order of values round.
        let ascending = calibration.slope > 0.0;
        match compositing {
            Compositing::Maximum => Some(if ascending { Self::Largest } else { Self::Smallest }),
            Compositing::Minimum => Some(if ascending { Self::Smallest } else { Self::Largest }),
            Compositing::Average => Some(Self::Mean),
            _ => None,
        }
    }
}

/// Texels hold (value, weight, 0, 0) until they are classified; weight 0 where no sample was.
pub(crate) struct Pick<'a, P> {
    pub(crate) voxels: &'a [P],
    pub(crate) choice: Choice,
}

/// A ray that only touches the volume still meets a value.
const LEAST_SHARE: f32 = 1e-6;

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
        let so_far = f32x16::load_array_ref(simd, row.sixteen(0, at.x));
        let weight = f32x16::load_array_ref(simd, row.sixteen(1, at.x));
        let counts = f32x16::load_array_ref(simd, &STEPS_F32).simd_lt(splat(simd, at.n as f32));
        let share = match shares {
            Some(shares) => f32x16::load_array_ref(simd, shares).max(splat(simd, LEAST_SHARE)),
            None => splat(simd, 1.0),
        };
        let share = pick(counts, share, splat(simd, 0.0));
        let first = counts & weight.simd_eq(splat(simd, 0.0));
        let chosen = match self.choice {
            Choice::Largest => pick(first | (counts & value.simd_gt(so_far)), value, so_far),
            Choice::Smallest => pick(first | (counts & value.simd_lt(so_far)), value, so_far),
            Choice::Mean => so_far + value * share,
        };
        *row.sixteen(0, at.x) = chosen.to_array();
        *row.sixteen(1, at.x) = (weight + share).to_array();
        Added { samples: at.n as u32, closed: 0 }
    }
}
