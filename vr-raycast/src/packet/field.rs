//! The trilinear field at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i8x64, i16x32, i32x16, u8x64, u16x32, u32x16};
use vr_core::Voxel;
use vr_core::filter::Lattice;

use super::lanes::{LANES, splat};

/// The samples, seen from the four corners of a cell's face x = 0: one offset serves all four.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field<'a, T> {
    /// Rows (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1): all equally long.
    rows: [&'a [T]; 4],
    /// Samples from one y and one z to the next.
    pub(crate) stride: [u32; 2],
    /// The last cell of each axis.
    pub(crate) last_cell: [i32; 3],
}

/// Pairs of x-neighbours of sixteen places, for two rows y and y + 1.
type TwoRows<T> = [[[T; 2]; LANES]; 2];

/// The pairs of the faces z and z + 1; staged, for there is one load a pair and no gather.
#[repr(align(64))]
pub(crate) struct Stage<T>([TwoRows<T>; 2]);

impl<T: Voxel> Stage<T> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self([[[[T::default(); 2]; LANES]; 2]; 2])
    }
}

/// A voxel type whose pairs can be taken apart.
pub(crate) trait Pairs: Voxel {
    /// The left and the right samples of two staged rows, as floats.
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2];
}

impl Pairs for u8 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let pairs: u16x32<S> = u8x64::from_slice(simd, rows.as_flattened().as_flattened()).bitcast();
        let (y0, y1) = pairs.widen();
        [y0, y1].map(
            #[inline(always)]
            |v| [(v & 0xff).bitcast::<i32x16<S>>().to_float(), (v >> 8).bitcast::<i32x16<S>>().to_float()],
        )
    }
}

impl Pairs for i8 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let pairs: i16x32<S> = i8x64::from_slice(simd, rows.as_flattened().as_flattened()).bitcast();
        let (y0, y1) = pairs.widen();
        [y0, y1].map(
            #[inline(always)]
            |v| [((v << 24) >> 24).to_float(), (v >> 8).to_float()],
        )
    }
}

impl Pairs for u16 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        [0, 1].map(
            #[inline(always)]
            |y: usize| {
                let v: u32x16<S> = u16x32::from_slice(simd, rows[y].as_flattened()).bitcast();
                [(v & 0xffff).bitcast::<i32x16<S>>().to_float(), (v >> 16).bitcast::<i32x16<S>>().to_float()]
            },
        )
    }
}

impl Pairs for i16 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        [0, 1].map(
            #[inline(always)]
            |y: usize| {
                let v: i32x16<S> = i16x32::from_slice(simd, rows[y].as_flattened()).bitcast();
                [((v << 16) >> 16).to_float(), (v >> 16).to_float()]
            },
        )
    }
}

impl Pairs for f32 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        [0, 1].map(
            #[inline(always)]
            |y: usize| {
                let pairs = rows[y].as_flattened();
                let low = f32x16::from_slice(simd, &pairs[..LANES]);
                let high = f32x16::from_slice(simd, &pairs[LANES..]);
                [low.unzip_low(high), low.unzip_high(high)]
            },
        )
    }
}

/// Positions, cell by cell.
pub(crate) struct Cells<S: Simd> {
    /// Number of the cell, axis by axis.
    pub(crate) cell: [i32x16<S>; 3],
    /// Fraction in it.
    pub(crate) fraction: [f32x16<S>; 3],
}

impl<'a, T: Voxel> Field<'a, T> {
    /// `None` where offsets do not fit into 31 bits.
    pub(crate) fn new(lattice: &Lattice<'a, T>) -> Option<Self> {
        let [nx, ny, _] = lattice.dims;
        let samples = lattice.samples;
        if samples.len() > i32::MAX as usize {
            return None;
        }
        let (row, slice) = (nx, nx * ny);
        let len = samples.len() - slice - row;
        Some(Self {
            rows: [0, row, slice, slice + row].map(|o| &samples[o..o + len]),
            stride: [row as u32, slice as u32],
            last_cell: lattice.dims.map(|n| n as i32 - 2),
        })
    }
}

/// Cells and fractions of positions inside the box.
#[inline(always)]
pub(crate) fn cells<S: Simd>(simd: S, position: [f32x16<S>; 3], last_cell: [i32; 3]) -> Cells<S> {
    let cell: [i32x16<S>; 3] = [
        position[0].to_int::<i32x16<S>>().min(i32x16::splat(simd, last_cell[0])),
        position[1].to_int::<i32x16<S>>().min(i32x16::splat(simd, last_cell[1])),
        position[2].to_int::<i32x16<S>>().min(i32x16::splat(simd, last_cell[2])),
    ];
    let fraction = [
        position[0] - cell[0].to_float::<f32x16<S>>(),
        position[1] - cell[1].to_float::<f32x16<S>>(),
        position[2] - cell[2].to_float::<f32x16<S>>(),
    ];
    Cells { cell, fraction }
}

impl<T: Pairs> Field<'_, T> {
    /// The field in cells, by f = Σ w f over their corners.
    #[inline(always)]
    pub(crate) fn value<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Stage<T>) -> f32x16<S> {
        let [tx, ty, tz] = at.fraction;
        let row = i32x16::splat(simd, self.stride[0] as i32);
        let slice = i32x16::splat(simd, self.stride[1] as i32);
        let offset = (at.cell[2] * slice + at.cell[1] * row + at.cell[0]).to_array();
        let [r0, r1, r2, r3] = self.rows;
        let [[s0, s1], [s2, s3]] = &mut stage.0;
        for i in 0..LANES {
            let o = offset[i] as u32 as usize;
            // One check: the four rows are equally long.
            if let (Some(a), Some(b), Some(c), Some(d)) =
                (r0.get(o..o + 2), r1.get(o..o + 2), r2.get(o..o + 2), r3.get(o..o + 2))
            {
                s0[i] = [a[0], a[1]];
                s1[i] = [b[0], b[1]];
                s2[i] = [c[0], c[1]];
                s3[i] = [d[0], d[1]];
            }
        }
        let [[a00, b00], [a10, b10]] = T::split(simd, &stage.0[0]);
        let [[a01, b01], [a11, b11]] = T::split(simd, &stage.0[1]);
        let (f00, f10) = (a00 + tx * (b00 - a00), a10 + tx * (b10 - a10));
        let (f01, f11) = (a01 + tx * (b01 - a01), a11 + tx * (b11 - a11));
        let f0 = f00 + ty * (f10 - f00);
        let f1 = f01 + ty * (f11 - f01);
        f0 + tz * (f1 - f0)
    }
}

/// Clamps positions into the box: rounding may carry them past a face.
#[inline(always)]
pub(crate) fn inside<S: Simd>(simd: S, position: f32x16<S>, most: f32) -> f32x16<S> {
    position.max(splat(simd, 0.0)).min(splat(simd, most))
}
