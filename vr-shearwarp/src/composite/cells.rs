//! A run of cells under neighbouring texels: which cell a texel lies in, where in it, and what value is there.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, u8x64};
use vr_kernels::vector::{LANES, pick, splat};

/// Numbers of voxels that are interpolated: codes of values, or lengths of gradients.
pub(crate) trait Interpolated: Copy {
    fn to_f32(self) -> f32;
}

impl Interpolated for f32 {
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }
}

/// A run of cells of one row: the edges along it, and how much each counts for this row of texels.
#[derive(Clone, Copy)]
pub(crate) struct Edges<const N: usize> {
    /// First voxel of each edge. What lies behind its end can be read, but is not its own.
    pub(crate) at: [usize; N],
    /// The last cell, counted from the first.
    pub(crate) last: usize,
    /// Weight of each edge, by linear interpolation; their sum is 1.
    pub(crate) weights: [f32; N],
    /// Weight of each edge for values, and for voxels that are classified: the same, or all on one edge where the nearest voxel is taken.
    pub(crate) of_voxels: [f32; N],
}

/// Positions of texels on a run: texel i at `first + begin + i·scale` cells from its begin, `scale` ≤ 1¼.
#[derive(Clone, Copy)]
pub(crate) struct Columns {
    pub(crate) first: usize,
    pub(crate) begin: f32,
    pub(crate) scale: f32,
    /// True if values, and voxels that are classified, are those of the nearest voxel.
    pub(crate) nearest: bool,
}

/// Cells of sixteen texels: `first + cell[i]` from the run's begin, and the place in each.
pub(crate) struct Places<S: Simd> {
    pub(crate) first: usize,
    pub(crate) cell: [i32; LANES],
    /// Weight of the right end of the cell, by linear interpolation.
    pub(crate) weight: f32x16<S>,
    /// The same for values, and for voxels that are classified.
    pub(crate) of_voxels: f32x16<S>,
}

/// Weight of the far end between two voxels where the nearest is taken; half way it is the far one.
#[inline(always)]
pub(crate) fn nearest(weight: f32) -> f32 {
    if weight >= 0.5 { 1.0 } else { 0.0 }
}

const STEPS: [i32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
pub(crate) const STEPS_F32: [f32; LANES] = [0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.];

/// Sixteen texels lie in fewer cells than this, the last one's right end included: the first is at most a cell in, and fifteen steps are 19 cells.
pub(super) const SPAN: usize = 2 * LANES;

/// Texels at once, at most [`LANES`], that lie between so many columns wherever in its cell the first one lies; `scale` as in [`Columns`].
pub(crate) fn texels_between(columns: usize, scale: f64) -> usize {
    // The first one is less than a cell in, and the last one has a column to its right. `as` rounds down.
    (((columns - 2) as f64 / scale) as usize + 1).min(LANES)
}

impl Columns {
    /// Weight of the right end of its cell at the first texel, for values, and for voxels that are classified.
    #[inline(always)]
    pub(super) fn of_voxels(&self) -> f32 {
        if self.nearest { nearest(self.begin) } else { self.begin }
    }

    /// `UNIT`: a texel a cell.
    #[inline(always)]
    pub(crate) fn places<S: Simd, const UNIT: bool>(&self, simd: S, last: usize) -> Places<S> {
        if UNIT {
            let [weight, of_voxels] = [self.begin, self.of_voxels()].map(|weight| splat(simd, weight));
            return Places { first: self.first, cell: STEPS, weight, of_voxels };
        }
        let position = f32x16::load_array_ref(simd, &STEPS_F32) * self.scale + self.begin;
        let last = splat(simd, (last - self.first) as f32);
        let cell: i32x16<S> = position.max(splat(simd, 0.0)).min(last).to_int();
        let weight = position - cell.to_float::<f32x16<S>>();
        let mut of_voxels = weight;
        if self.nearest {
            of_voxels = pick(weight.simd_ge(splat(simd, 0.5)), splat(simd, 1.0), splat(simd, 0.0));
        }
        Places { first: self.first, cell: cell.to_array(), weight, of_voxels }
    }
}

impl<S: Simd> Places<S> {
    /// Classified voxels at sixteen columns from the first one on, interpolated to the texels; for those that lie between these columns.
    #[inline(always)]
    pub(crate) fn between<const UNIT: bool>(&self, simd: S, columns: f32x16<S>) -> f32x16<S> {
        let [left, right] = self.beside::<UNIT>(simd, columns);
        left + (right - left) * self.of_voxels
    }

    /// Weights of what is at the left of texels (0), or at the right.
    #[inline(always)]
    pub(crate) fn weight_beside(&self, simd: S, right: usize) -> f32x16<S> {
        if right == 0 { splat(simd, 1.0) - self.weight } else { self.weight }
    }

    /// Weights of classified voxels at the left of texels (0), or at the right.
    #[inline(always)]
    pub(crate) fn weight_of_voxels(&self, simd: S, right: usize) -> f32x16<S> {
        if right == 0 { splat(simd, 1.0) - self.of_voxels } else { self.of_voxels }
    }

    /// Numbers at sixteen columns from the first one on, as they are at the left and at the right of texels.
    #[inline(always)]
    pub(crate) fn beside<const UNIT: bool>(&self, simd: S, columns: f32x16<S>) -> [f32x16<S>; 2] {
        if UNIT {
            return [columns, columns.slide::<1>(splat(simd, 0.0))];
        }
        let bytes = i32x16::load_array_ref(simd, &self.cell) * 0x0404_0404 + 0x0302_0100;
        let left: f32x16<S> = columns.swizzle_dyn(bytes.bitcast::<u8x64<S>>());
        [left, columns.swizzle_dyn((bytes + 0x0404_0404).bitcast::<u8x64<S>>())]
    }
}

/// The values, as codes, at sixteen texels: bilinear in a layer (N = 2), trilinear between two (N = 4), or those of the nearest voxels.
#[inline(always)]
pub(crate) fn values<S: Simd, P: Interpolated, const N: usize, const UNIT: bool>(
    simd: S,
    voxels: &[P],
    edges: &Edges<N>,
    places: &Places<S>,
) -> f32x16<S> {
    weighted::<S, P, N, UNIT>(simd, voxels, (&edges.at, &edges.of_voxels), places, places.of_voxels)
}

/// Numbers of voxels at sixteen texels, by linear interpolation whatever is taken of values.
#[inline(always)]
pub(crate) fn interpolated<S: Simd, P: Interpolated, const N: usize, const UNIT: bool>(
    simd: S,
    voxels: &[P],
    edges: &Edges<N>,
    places: &Places<S>,
) -> f32x16<S> {
    weighted::<S, P, N, UNIT>(simd, voxels, (&edges.at, &edges.weights), places, places.weight)
}

/// Weighted means of the voxels around sixteen texels.
#[inline(always)]
fn weighted<S: Simd, P: Interpolated, const N: usize, const UNIT: bool>(
    simd: S,
    voxels: &[P],
    (at, weights): (&[usize; N], &[f32; N]),
    places: &Places<S>,
    of_right: f32x16<S>,
) -> f32x16<S> {
    let (mut left, mut right) = (splat(simd, 0.0), splat(simd, 0.0));
    if UNIT {
        for n in 0..N {
            let edge = &voxels[at[n] + places.first..][..LANES + 1];
            let (mut a, mut b) = ([0.0; LANES], [0.0; LANES]);
            for i in 0..LANES {
                a[i] = edge[i].to_f32();
                b[i] = edge[i + 1].to_f32();
            }
            left += f32x16::load_array_ref(simd, &a) * weights[n];
            right += f32x16::load_array_ref(simd, &b) * weights[n];
        }
    } else {
        // Across the edges first, for all cells that sixteen texels can lie in; then along them.
        let (mut near, mut far) = (left, right);
        for n in 0..N {
            let edge = &voxels[at[n] + places.first..][..SPAN];
            let (mut a, mut b) = ([0.0; LANES], [0.0; LANES]);
            for i in 0..LANES {
                a[i] = edge[i].to_f32();
                b[i] = edge[i + LANES].to_f32();
            }
            near += f32x16::load_array_ref(simd, &a) * weights[n];
            far += f32x16::load_array_ref(simd, &b) * weights[n];
        }
        // Four bytes of each.
        let bytes = i32x16::load_array_ref(simd, &places.cell) * 0x0404_0404 + 0x0302_0100;
        left = near.concat_swizzle_dyn(far, bytes.bitcast::<u8x64<S>>());
        right = near.concat_swizzle_dyn(far, (bytes + 0x0404_0404).bitcast::<u8x64<S>>());
    }
    left + of_right * (right - left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_lie_between_the_columns() {
        for columns in [LANES, SPAN] {
            for scale in [1e-9, 0.3, 0.93, 1.0, 1.1, 1.25] {
                let n = texels_between(columns, scale);
                // The first one just before the end of its cell, and as many as can be.
                let last_right = |n: usize| (1.0 - 1e-9 + (n - 1) as f64 * scale).floor() as usize + 1;
                assert!(n >= 1 && last_right(n) < columns, "{columns} {scale}: {n}");
                assert!(n == LANES || last_right(n + 1) >= columns, "{columns} {scale}: {n}");
            }
        }
        assert_eq!([texels_between(LANES, 1.0), texels_between(LANES, 1.25), texels_between(SPAN, 1.25)], [15, 12, 16]);
    }
}
