//! Linear along each axis.

use super::{Filter, Lattice, Reconstruction};
use crate::real::Real;
use crate::voxel::Voxel;

/// Linear along each axis: f = Σ wᵢ(x) wⱼ(y) wₖ(z) fᵢⱼₖ over the eight corners of the cell, w₀(t) = 1 − t, w₁(t) = t.
#[derive(Clone, Copy, Debug)]
pub struct Trilinear;

/// a + t (b − a): exact at t = 0, and one rounding from b at t = 1.
#[inline(always)]
fn lerp<R: Real>(t: R, a: R, b: R) -> R {
    a + t * (b - a)
}

/// The cell's corners, x fastest, and the position in it.
#[inline(always)]
fn corners<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> ([R; 8], [R; 3]) {
    let (x, tx) = lattice.cell(0, p[0]);
    let (y, ty) = lattice.cell(1, p[1]);
    let (z, tz) = lattice.cell(2, p[2]);
    let row = lattice.dims[0];
    let slice = row * lattice.dims[1];
    let o = lattice.offset(x, y, z);
    let s = lattice.samples;
    let at = |i: usize| R::from_f32(s[i].to_f32());
    // The last one first: its check covers the others.
    let c7 = at(o + slice + row + 1);
    let c = [at(o), at(o + 1), at(o + row), at(o + row + 1), at(o + slice), at(o + slice + 1), at(o + slice + row), c7];
    (c, [tx, ty, tz])
}

impl Reconstruction for Trilinear {
    const FILTER: Filter = Filter::Trilinear;

    #[inline(always)]
    fn value<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> R {
        let (c, [tx, ty, tz]) = corners(lattice, p);
        let y0 = lerp(ty, lerp(tx, c[0], c[1]), lerp(tx, c[2], c[3]));
        let y1 = lerp(ty, lerp(tx, c[4], c[5]), lerp(tx, c[6], c[7]));
        lerp(tz, y0, y1)
    }

    #[inline(always)]
    fn value_and_gradient<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> (R, [R; 3]) {
        let (c, [tx, ty, tz]) = corners(lattice, p);
        let (x00, x10) = (lerp(tx, c[0], c[1]), lerp(tx, c[2], c[3]));
        let (x01, x11) = (lerp(tx, c[4], c[5]), lerp(tx, c[6], c[7]));
        let (y0, y1) = (lerp(ty, x00, x10), lerp(ty, x01, x11));
        let dx = lerp(tz, lerp(ty, c[1] - c[0], c[3] - c[2]), lerp(ty, c[5] - c[4], c[7] - c[6]));
        let dy = lerp(tz, x10 - x00, x11 - x01);
        (lerp(tz, y0, y1), [dx, dy, y1 - y0])
    }
}
