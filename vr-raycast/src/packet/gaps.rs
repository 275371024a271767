//! Cells without a field, for sixteen places at once.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::VacuumCells;
use vr_kernels::vector::{Cells, LANES, Lanes, pick, splat};

/// Those of some lanes whose places have a field.
#[inline(always)]
pub(crate) fn there<S: Simd>(
    simd: S,
    vacuum: Option<&VacuumCells>,
    place: &Cells<S>,
    lanes: mask32x16<S>,
) -> mask32x16<S> {
    let Some(vacuum) = vacuum else { return lanes };
    let cell = [place.cell[0].to_array(), place.cell[1].to_array(), place.cell[2].to_array()];
    let fraction = [place.fraction[0].to_array(), place.fraction[1].to_array(), place.fraction[2].to_array()];
    let exists = existing(vacuum, &cell, &fraction);
    lanes & exists.load(simd).simd_gt(splat(simd, 0.0))
}

/// Returns the light of places that have a field; the others, in holes, are clear. (Masks of lanes would take registers from volumes without any.)
#[inline(always)]
pub(crate) fn outside_holes<S: Simd>(
    simd: S,
    vacuum: Option<&VacuumCells>,
    place: &Cells<S>,
    lanes: mask32x16<S>,
    light: [f32x16<S>; 4],
) -> [f32x16<S>; 4] {
    if vacuum.is_none() {
        return light;
    }
    let (exists, zero) = (there(simd, vacuum, place, lanes), splat(simd, 0.0));
    let [r, g, b, a] = light;
    [pick(exists, r, zero), pick(exists, g, zero), pick(exists, b, zero), pick(exists, a, zero)]
}

/// 1 for each place that has a field, 0 for the others.
#[inline(never)]
fn existing(vacuum: &VacuumCells, cell: &[[i32; LANES]; 3], fraction: &[[f32; LANES]; 3]) -> Lanes {
    let mut exists = Lanes::ZERO;
    for i in 0..LANES {
        let at = [cell[0][i], cell[1][i], cell[2][i]];
        let is_on_face = (0..3).any(|a| fraction[a][i] == 0.0);
        // A face belongs to the cells on both of its sides.
        let is_vacuum = vacuum.is_vacuum(at.map(|x| x as usize))
            || is_on_face && vacuum.contains([0, 1, 2].map(|a| at[a] as f32 + fraction[a][i]));
        exists.0[i] = if is_vacuum { 0.0 } else { 1.0 };
    }
    exists
}
