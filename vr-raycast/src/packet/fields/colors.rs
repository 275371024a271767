//! Light in the colours of voxels.

use fearless_simd::Simd;
use vr_kernels::vector::{Lanes, Stage, VoxelColors};

use super::cells_of;

/// Multiplies light by the colours of its places.
///
/// Its own function: most packets have none.
#[inline(never)]
pub(super) fn tint<S: Simd>(
    simd: S,
    colors: &VoxelColors<'_>,
    place: &[[Lanes; 3]; 2],
    light: &mut [Lanes; 4],
    stage: &mut Stage<u16>,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let color = colors.in_cells(simd, &cells_of(simd, place), stage);
            for c in 0..3 {
                light[c] = Lanes::new(light[c].load(simd) * color[c]);
            }
        },
    );
}
