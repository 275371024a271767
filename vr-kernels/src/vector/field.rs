//! The trilinear field at sixteen places.

use super::surroundings::Surroundings;
use super::{LANES, splat, transpose};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i8x64, i16x32, i32x16, u8x64, u16x32, u32x16};
use vr_core::Voxel;
use vr_core::filter::Lattice;

/// The voxels, seen from the four corners of a cell's face x = 0: one offset serves all four.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a, T> {
    /// Rows (y, z), (y + 1, z), (y, z + 1), (y + 1, z + 1): all equally long.
    pub(super) rows: [&'a [T]; 4],
    /// Number of voxels from one y and one z to the next.
    pub(super) stride: [u32; 2],
    /// The last cell of each axis.
    pub last_cell: [i32; 3],
}

/// Pairs of x-neighbours of sixteen places, for two rows y and y + 1.
pub type TwoRows<T> = [[[T; 2]; LANES]; 2];

/// The pairs of the faces z and z + 1; staged, for there is one load a pair and no gather. And room for the voxels around, where gradients need them.
#[repr(align(64))]
pub struct Stage<T> {
    faces: [TwoRows<T>; 2],
    /// Voxels of cells and those around.
    pub around: Surroundings<T>,
}

impl<T: Voxel> Default for Stage<T> {
    #[inline(always)]
    fn default() -> Self {
        Self { faces: [[[[T::default(); 2]; LANES]; 2]; 2], around: Surroundings::default() }
    }
}

impl<T: Pairs> Stage<T> {
    /// Puts the eight voxels around the place of a lane: four pairs of x-neighbours, y faster than z.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, [p00, p10, p01, p11]: [[T; 2]; 4]) {
        let [[s0, s1], [s2, s3]] = &mut self.faces;
        (s0[lane], s1[lane], s2[lane], s3[lane]) = (p00, p10, p01, p11);
    }

    /// The trilinear field at fractions of the staged cells: f = Σ w f over their corners.
    #[inline(always)]
    pub fn trilinear<S: Simd>(&self, simd: S, [tx, ty, tz]: [f32x16<S>; 3]) -> f32x16<S> {
        let [[a00, b00], [a10, b10]] = T::split(simd, &self.faces[0]);
        let [[a01, b01], [a11, b11]] = T::split(simd, &self.faces[1]);
        let (f00, f10) = (a00 + tx * (b00 - a00), a10 + tx * (b10 - a10));
        let (f01, f11) = (a01 + tx * (b01 - a01), a11 + tx * (b11 - a11));
        let f0 = f00 + ty * (f10 - f00);
        let f1 = f01 + ty * (f11 - f01);
        f0 + tz * (f1 - f0)
    }
}

/// A voxel type whose pairs can be taken apart.
pub trait Pairs: Voxel {
    /// The left and the right voxels of two staged rows, as floats.
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2];

    /// The first to the fourth voxels of a staged row, as floats.
    fn quads<S: Simd>(simd: S, row: &[[Self; 4]; LANES]) -> [f32x16<S>; 4];
}

// The closures and iterators of std are not inlined for certain, and what is not inlined loses its instructions: hence the plain
// lines below.

impl Pairs for u8 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let pairs: u16x32<S> = u8x64::from_slice(simd, rows.as_flattened().as_flattened()).bitcast();
        let (y0, y1) = pairs.widen();
        [[small(y0 & 0xff), small(y0 >> 8)], [small(y1 & 0xff), small(y1 >> 8)]]
    }

    #[inline(always)]
    fn quads<S: Simd>(simd: S, row: &[[Self; 4]; LANES]) -> [f32x16<S>; 4] {
        let x: u32x16<S> = u8x64::from_slice(simd, row.as_flattened()).bitcast();
        [small(x & 0xff), small((x >> 8) & 0xff), small((x >> 16) & 0xff), small(x >> 24)]
    }
}

impl Pairs for i8 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let pairs: i16x32<S> = i8x64::from_slice(simd, rows.as_flattened().as_flattened()).bitcast();
        let (y0, y1) = pairs.widen();
        [[((y0 << 24) >> 24).to_float(), (y0 >> 8).to_float()], [((y1 << 24) >> 24).to_float(), (y1 >> 8).to_float()]]
    }

    #[inline(always)]
    fn quads<S: Simd>(simd: S, row: &[[Self; 4]; LANES]) -> [f32x16<S>; 4] {
        let x: i32x16<S> = i8x64::from_slice(simd, row.as_flattened()).bitcast();
        [((x << 24) >> 24).to_float(), ((x << 16) >> 24).to_float(), ((x << 8) >> 24).to_float(), (x >> 24).to_float()]
    }
}

impl Pairs for u16 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let y0: u32x16<S> = u16x32::from_slice(simd, rows[0].as_flattened()).bitcast();
        let y1: u32x16<S> = u16x32::from_slice(simd, rows[1].as_flattened()).bitcast();
        [[small(y0 & 0xffff), small(y0 >> 16)], [small(y1 & 0xffff), small(y1 >> 16)]]
    }

    #[inline(always)]
    fn quads<S: Simd>(simd: S, row: &[[Self; 4]; LANES]) -> [f32x16<S>; 4] {
        let (low, high) = row.as_flattened().split_at(2 * LANES);
        let low: u32x16<S> = u16x32::from_slice(simd, low).bitcast();
        let high: u32x16<S> = u16x32::from_slice(simd, high).bitcast();
        let (x, y) = (low.unzip_low(high), low.unzip_high(high));
        [small(x & 0xffff), small(x >> 16), small(y & 0xffff), small(y >> 16)]
    }
}

impl Pairs for i16 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let y0: i32x16<S> = i16x32::from_slice(simd, rows[0].as_flattened()).bitcast();
        let y1: i32x16<S> = i16x32::from_slice(simd, rows[1].as_flattened()).bitcast();
        [[((y0 << 16) >> 16).to_float(), (y0 >> 16).to_float()], [((y1 << 16) >> 16).to_float(), (y1 >> 16).to_float()]]
    }

    #[inline(always)]
    fn quads<S: Simd>(simd: S, row: &[[Self; 4]; LANES]) -> [f32x16<S>; 4] {
        let (low, high) = row.as_flattened().split_at(2 * LANES);
        let low: i32x16<S> = i16x32::from_slice(simd, low).bitcast();
        let high: i32x16<S> = i16x32::from_slice(simd, high).bitcast();
        let (x, y) = (low.unzip_low(high), low.unzip_high(high));
        [((x << 16) >> 16).to_float(), (x >> 16).to_float(), ((y << 16) >> 16).to_float(), (y >> 16).to_float()]
    }
}

impl Pairs for f32 {
    #[inline(always)]
    fn split<S: Simd>(simd: S, rows: &TwoRows<Self>) -> [[f32x16<S>; 2]; 2] {
        let (y0, y1) = (rows[0].as_flattened(), rows[1].as_flattened());
        let (a0, b0) = (f32x16::from_slice(simd, &y0[..LANES]), f32x16::from_slice(simd, &y0[LANES..]));
        let (a1, b1) = (f32x16::from_slice(simd, &y1[..LANES]), f32x16::from_slice(simd, &y1[LANES..]));
        [[a0.unzip_low(b0), a0.unzip_high(b0)], [a1.unzip_low(b1), a1.unzip_high(b1)]]
    }

    #[inline(always)]
    fn quads<S: Simd>(simd: S, row: &[[Self; 4]; LANES]) -> [f32x16<S>; 4] {
        let mut rows = [f32x4::splat(simd, 0.0); LANES];
        for i in 0..LANES {
            rows[i] = f32x4::load_array_ref(simd, &row[i]);
        }
        transpose(rows)
    }
}

/// Converts numbers below 2³¹: signed conversion is what every machine has.
#[inline(always)]
fn small<S: Simd>(x: u32x16<S>) -> f32x16<S> {
    x.bitcast::<i32x16<S>>().to_float()
}

/// Positions, cell by cell.
pub struct Cells<S: Simd> {
    /// Number of the cell, axis by axis.
    pub cell: [i32x16<S>; 3],
    /// Fraction in it.
    pub fraction: [f32x16<S>; 3],
}

impl<'a, T: Voxel> Field<'a, T> {
    /// The field of a lattice of fewer than 2³¹ voxels.
    pub fn new(lattice: &Lattice<'a, T>) -> Self {
        let [nx, ny, _] = lattice.dims;
        let samples = lattice.samples;
        let (row, slice) = (nx, nx * ny);
        let len = samples.len() - slice - row;
        Self {
            rows: [0, row, slice, slice + row].map(|o| &samples[o..o + len]),
            stride: [row as u32, slice as u32],
            last_cell: lattice.dims.map(|n| n as i32 - 2),
        }
    }
}

/// Cells and fractions of positions inside the box.
#[inline(always)]
pub fn cells<S: Simd>(simd: S, position: [f32x16<S>; 3], last_cell: [i32; 3]) -> Cells<S> {
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
    /// Offsets of the first voxels of sixteen cells.
    #[inline(always)]
    pub(super) fn offsets<S: Simd>(&self, [x, y, z]: [i32x16<S>; 3]) -> i32x16<S> {
        z * self.stride[1] as i32 + y * self.stride[0] as i32 + x
    }

    /// Loads the voxels around sixteen places into a stage.
    #[inline(always)]
    pub fn fetch<S: Simd>(&self, _: S, at: &Cells<S>, stage: &mut Stage<T>) {
        let offset = self.offsets(at.cell).to_array();
        let [r0, r1, r2, r3] = self.rows;
        // Equally long, and said so: one check serves the four.
        let len = r0.len();
        let (r1, r2, r3) = (&r1[..len], &r2[..len], &r3[..len]);
        let [[s0, s1], [s2, s3]] = &mut stage.faces;
        for i in 0..LANES {
            let o = offset[i] as u32 as usize;
            // A slice of two: one check, where two indices take two.
            s0[i].copy_from_slice(&r0[o..o + 2]);
            s1[i].copy_from_slice(&r1[o..o + 2]);
            s2[i].copy_from_slice(&r2[o..o + 2]);
            s3[i].copy_from_slice(&r3[o..o + 2]);
        }
    }

    /// The field at places whose voxels have been staged.
    #[inline(always)]
    pub fn value<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Stage<T>) -> f32x16<S> {
        stage.trilinear(simd, at.fraction)
    }
}

impl<T: Pairs> Field<'_, T> {
    /// Staged voxels at the corners of the cells' lower and upper face across an axis: for each, those at (0, 0), (1, 0), (0, 1) and (1, 1) of the two
    /// other axes, in their order.
    #[inline(always)]
    pub fn faces<S: Simd>(&self, simd: S, axis: usize, stage: &Stage<T>) -> [[f32x16<S>; 4]; 2] {
        let [[a00, b00], [a10, b10]] = T::split(simd, &stage.faces[0]);
        let [[a01, b01], [a11, b11]] = T::split(simd, &stage.faces[1]);
        match axis {
            0 => [[a00, a10, a01, a11], [b00, b10, b01, b11]],
            1 => [[a00, b00, a01, b01], [a10, b10, a11, b11]],
            _ => [[a00, b00, a10, b10], [a01, b01, a11, b11]],
        }
    }

    /// The voxels nearest to sixteen places; in the middle between two, the one of higher index.
    #[inline(always)]
    pub fn nearest<S: Simd>(&self, simd: S, at: &Cells<S>) -> [f32; LANES] {
        let (zero, one, half) = (i32x16::splat(simd, 0), i32x16::splat(simd, 1), splat(simd, 0.5));
        let [x, y, z] = at.fraction;
        let (x, y, z) = (x.simd_ge(half), y.simd_ge(half), z.simd_ge(half));
        let offset = (self.offsets(at.cell) + x.select(one, zero)).to_array();
        let row = (y.select(one, zero) + z.select(one + one, zero)).to_array();
        let mut values = [0.0; LANES];
        for i in 0..LANES {
            values[i] = self.rows[(row[i] & 3) as usize][offset[i] as u32 as usize].to_f32();
        }
        values
    }

    /// Gradients per index step of the trilinear field itself, at places whose voxels have been staged.
    #[inline(always)]
    pub fn slopes<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Stage<T>) -> [f32x16<S>; 3] {
        let [tx, ty, tz] = at.fraction;
        let ([x0, x1], [y0, y1]) = (self.faces(simd, 0, stage), self.faces(simd, 1, stage));
        let [[z00, z10, z01, z11], [w00, w10, w01, w11]] = self.faces(simd, 2, stage);
        [
            bilinear([x1[0] - x0[0], x1[1] - x0[1], x1[2] - x0[2], x1[3] - x0[3]], [ty, tz]),
            bilinear([y1[0] - y0[0], y1[1] - y0[1], y1[2] - y0[2], y1[3] - y0[3]], [tx, tz]),
            bilinear([w00 - z00, w10 - z10, w01 - z01, w11 - z11], [tx, ty]),
        ]
    }
}

/// Bilinear interpolation between numbers at (0, 0), (1, 0), (0, 1) and (1, 1).
#[inline(always)]
pub(super) fn bilinear<S: Simd>([v00, v10, v01, v11]: [f32x16<S>; 4], [t, u]: [f32x16<S>; 2]) -> f32x16<S> {
    let (row_0, row_1) = (v00 + t * (v10 - v00), v01 + t * (v11 - v01));
    row_0 + u * (row_1 - row_0)
}

/// Clamps positions into the box, 0 to `max`: rounding may carry them past a face.
#[inline(always)]
pub fn inside<S: Simd>(simd: S, position: f32x16<S>, max: f32) -> f32x16<S> {
    position.max(splat(simd, 0.0)).min(splat(simd, max))
}
