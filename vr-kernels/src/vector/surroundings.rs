//! Voxels of sixteen cells and those a voxel beyond their faces: what differences across the cells' corners are made of.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::Voxel;

use super::LANES;
use super::field::{Field, Pairs, TwoRows};

/// Voxels of sixteen cells and those around; staged, for there is one load a row and no gather.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Surroundings<T> {
    /// Four x-neighbours, from the one before the cell on, in its rows (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1).
    quads: [[[T; 4]; LANES]; 4],
    /// Pairs of x-neighbours in the rows beyond its faces: y − 1 at z and z + 1, y + 2 at z and z + 1, z − 1 at y and y + 1, z + 2 at y and y + 1.
    beyond: [TwoRows<T>; 4],
}

impl<T: Voxel> Default for Surroundings<T> {
    #[inline(always)]
    fn default() -> Self {
        let none = T::default();
        Self { quads: [[[none; 4]; LANES]; 4], beyond: [[[[none; 2]; LANES]; 2]; 4] }
    }
}

impl<T: Pairs> Surroundings<T> {
    /// Returns four planes of voxels across an axis: the one before the cells, their lower and their upper faces, and the one behind. Of each the voxels at (0, 0), (1, 0), (0, 1) and
    /// (1, 1) of the two other axes, in their order. Beyond a face of the volume lies that face's plane again.
    #[inline(always)]
    pub fn planes<S: Simd>(&self, simd: S, axis: usize) -> [[f32x16<S>; 4]; 4] {
        let [a, b, c, d] = [
            T::quads(simd, &self.quads[0]),
            T::quads(simd, &self.quads[1]),
            T::quads(simd, &self.quads[2]),
            T::quads(simd, &self.quads[3]),
        ];
        match axis {
            0 => {
                [[a[0], b[0], c[0], d[0]], [a[1], b[1], c[1], d[1]], [a[2], b[2], c[2], d[2]], [a[3], b[3], c[3], d[3]]]
            }
            1 => [self.beyond(simd, 0), [a[1], a[2], c[1], c[2]], [b[1], b[2], d[1], d[2]], self.beyond(simd, 1)],
            _ => [self.beyond(simd, 2), [a[1], a[2], b[1], b[2]], [c[1], c[2], d[1], d[2]], self.beyond(simd, 3)],
        }
    }

    #[inline(always)]
    fn beyond<S: Simd>(&self, simd: S, which: usize) -> [f32x16<S>; 4] {
        let [[l0, r0], [l1, r1]] = T::split(simd, &self.beyond[which]);
        [l0, r0, l1, r1]
    }
}

impl<T: Pairs> Field<'_, T> {
    /// Loads the voxels of sixteen cells and those around.
    #[inline(always)]
    pub fn surround<S: Simd>(&self, simd: S, [x, y, z]: [i32x16<S>; 3], around: &mut Surroundings<T>) {
        let (zero, one) = (i32x16::splat(simd, 0), i32x16::splat(simd, 1));
        let row = i32x16::splat(simd, self.stride[0] as i32);
        let slice = i32x16::splat(simd, self.stride[1] as i32);
        let last = |axis: usize| i32x16::splat(simd, self.last_cell[axis]);
        let at = self.offsets([x, y, z]);
        // Rows of four begin a voxel before the cell; at the first and the last cell of a row they are the row's own first and last four, to be moved.
        let (first, end) = (x.simd_le(zero), x.simd_ge(last(0)));
        let start = at - first.select(zero, end.select(one + one, one));
        // Rows beyond a face of the volume are those of the face.
        let before_y = at - y.simd_gt(zero).select(row, zero);
        let behind_y = at + y.simd_lt(last(1)).select(row, zero);
        let before_z = at - z.simd_gt(zero).select(slice, zero);
        let behind_z = at + z.simd_lt(last(2)).select(slice, zero);
        let [r0, r1, r2, r3] = self.rows;
        // Equally long, and said so: one check serves all.
        let len = r0.len();
        let (r1, r2, r3) = (&r1[..len], &r2[..len], &r3[..len]);
        let [q0, q1, q2, q3] = &mut around.quads;
        if self.stride[0] < 4 {
            let (at, x) = (at.to_array(), x.to_array());
            let last = self.last_cell[0] + 1;
            for i in 0..LANES {
                for k in 0..4 {
                    let neighbour = (x[i] + k - 1).clamp(0, last);
                    let (o, k) = ((at[i] + neighbour - x[i]) as u32 as usize, k as usize);
                    (q0[i][k], q1[i][k], q2[i][k], q3[i][k]) = (r0[o], r1[o], r2[o], r3[o]);
                }
            }
        } else {
            let start = start.to_array();
            for i in 0..LANES {
                let o = start[i] as u32 as usize;
                q0[i].copy_from_slice(&r0[o..o + 4]);
                q1[i].copy_from_slice(&r1[o..o + 4]);
                q2[i].copy_from_slice(&r2[o..o + 4]);
                q3[i].copy_from_slice(&r3[o..o + 4]);
            }
            let first = first.to_bitmask() as u32;
            let mut moved = first | end.to_bitmask() as u32;
            while moved != 0 {
                let i = moved.trailing_zeros() as usize;
                moved &= moved - 1;
                let is_first = first >> i & 1 == 1;
                for quad in [&mut q0[i], &mut q1[i], &mut q2[i], &mut q3[i]] {
                    let [a, b, c, d] = *quad;
                    *quad = if is_first { [a, a, b, c] } else { [b, c, d, d] };
                }
            }
        }
        let [a, b, c, d] = &mut around.beyond;
        pairs([r0, r2], before_y.to_array(), a);
        pairs([r1, r3], behind_y.to_array(), b);
        pairs([r0, r1], before_z.to_array(), c);
        pairs([r2, r3], behind_z.to_array(), d);
    }
}

/// Loads pairs of x-neighbours from two rows, which are equally long.
#[inline(always)]
fn pairs<T: Copy>([a, b]: [&[T]; 2], at: [i32; LANES], [to_a, to_b]: &mut TwoRows<T>) {
    let b = &b[..a.len()];
    for i in 0..LANES {
        let o = at[i] as u32 as usize;
        to_a[i].copy_from_slice(&a[o..o + 2]);
        to_b[i].copy_from_slice(&b[o..o + 2]);
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use vr_core::filter::Lattice;

    use super::*;

    /// The planes across every axis of every cell, voxel by voxel; also where rows have fewer than four voxels.
    fn check<T: Pairs>(dims: [usize; 3], of: impl Fn(u8) -> T) {
        let count = dims.iter().product::<usize>();
        let samples: Vec<T> = (0..count).map(|i| of(((i * 37 + 11) % 101) as u8)).collect();
        let field = Field::new(&Lattice { samples: &samples, dims });
        let cells: Vec<[usize; 3]> = (0..dims[2] - 1)
            .flat_map(|z| (0..dims[1] - 1).flat_map(move |y| (0..dims[0] - 1).map(move |x| [x, y, z])))
            .collect();
        for some in cells.chunks(LANES) {
            let lane = |i: usize| some[i.min(some.len() - 1)];
            let found = dispatch!(Level::new(), simd => {
                let mut around = Surroundings::<T>::default();
                let cell: [i32x16<_>; 3] = std::array::from_fn(|a| {
                    i32x16::load_array(simd, std::array::from_fn(|i| lane(i)[a] as i32))
                });
                field.surround(simd, cell, &mut around);
                [0, 1, 2].map(|axis| around.planes(simd, axis).map(|plane| plane.map(|voxels| voxels.to_array())))
            });
            for i in 0..LANES {
                for axis in 0..3 {
                    for plane in 0..4 {
                        for corner in 0..4 {
                            let [b, c] = [[1, 2], [0, 2], [0, 1]][axis];
                            let mut place = lane(i);
                            place[axis] = (place[axis] + plane).saturating_sub(1).min(dims[axis] - 1);
                            place[b] += corner & 1;
                            place[c] += corner >> 1;
                            let [x, y, z] = place;
                            let voxel = samples[(z * dims[1] + y) * dims[0] + x].to_f32();
                            assert_eq!(found[axis][plane][corner][i], voxel, "{dims:?}: {:?}, axis {axis}", lane(i));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn planes_are_the_voxels_around() {
        for dims in [[2, 2, 2], [3, 2, 4], [4, 3, 2], [5, 4, 3], [9, 5, 6]] {
            check(dims, |x| x);
            check(dims, |x| x as i8 - 50);
            check(dims, |x| u16::from(x) * 600);
            check(dims, |x| i16::from(x) * 600 - 30_000);
            check(dims, |x| f32::from(x) - 0.5);
        }
    }
}
