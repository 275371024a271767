//! The field of filters of four taps an axis, at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, u32x16};
use vr_core::filter::Lattice;
use vr_core::{Filter, Voxel};

use super::field::{Cells, Pairs};
use super::taps::{AxisWeights, base, tap_slopes, tap_weights};
use super::{LANES, Lanes, splat, transpose};

/// The voxels under a filter of four taps an axis, seen from the sixteen rows of a block of 4³ voxels: one offset serves all.
#[derive(Clone, Copy, Debug)]
pub struct WideField<'a, T> {
    /// Rows of the block, y faster than z: all equally long. Of an axis of fewer than four voxels, the last one is there again, without a weight.
    rows: [&'a [T]; 16],
    /// Number of voxels from one y and one z to the next.
    stride: [i32; 2],
    /// The last cell of each axis.
    last_cell: [i32; 3],
    filter: Filter,
}

/// Voxels around sixteen places: four x-neighbours of each, row by row. Staged, for there is one load a row and no gather.
#[repr(align(64))]
pub struct BlockStage<T>([[[T; 4]; LANES]; 16]);

impl<T: Voxel> Default for BlockStage<T> {
    #[inline(always)]
    fn default() -> Self {
        Self([[[T::default(); 4]; LANES]; 16])
    }
}

/// Offsets of the blocks of voxels around sixteen places.
#[derive(Default)]
pub struct Offsets([u32; LANES]);

/// Four numbers for each place: those of the x-neighbours, front to back summed over the rows of their blocks.
type Columns<S> = [f32x16<S>; 4];

/// A voxel type whose blocks of 4³ can be summed.
///
/// Sums go over y and z first, and along x at last. So floats, of which a row of four is a vector of its own, are turned once a place and not once a row;
/// integers are staged, and taken apart sixteen places at a time.
pub trait Blocks: Pairs {
    /// Buffer of voxels between their fetch and their use.
    type Stage: Default;

    /// Keeps what the sums over the blocks at these offsets need.
    fn fetch(rows: &[&[Self]; 16], offset: [u32; LANES], stage: &mut Self::Stage);

    /// Σₖ zₖ Σⱼ yⱼ fᵢⱼₖ for the four i, by weights along y and z.
    fn columns<S: Simd>(simd: S, rows: &[&[Self]; 16], stage: &Self::Stage, weights: [&[Lanes; 4]; 2]) -> Columns<S>;

    /// The sums of [`columns`](Self::columns) by weights along y and z; by slopes along y and weights along z; and by weights along y and slopes along z.
    fn slope_columns<S: Simd>(
        simd: S,
        rows: &[&[Self]; 16],
        stage: &Self::Stage,
        weights: [&[Lanes; 4]; 2],
        slopes: [&[Lanes; 4]; 2],
    ) -> [Columns<S>; 3];
}

macro_rules! staged_blocks {
    ($($voxel:ty),*) => {$(
        impl Blocks for $voxel {
            type Stage = BlockStage<Self>;

            #[inline(always)]
            fn fetch(rows: &[&[Self]; 16], offset: [u32; LANES], stage: &mut BlockStage<Self>) {
                // Equally long, and said so: one check serves the sixteen.
                let len = rows[0].len();
                let rows = equally_long(rows, len);
                for i in 0..LANES {
                    let o = offset[i] as usize;
                    for r in 0..16 {
                        stage.0[r][i].copy_from_slice(&rows[r][o..o + 4]);
                    }
                }
            }

            #[inline(always)]
            fn columns<S: Simd>(
                simd: S,
                _: &[&[Self]; 16],
                stage: &BlockStage<Self>,
                [y, z]: [&[Lanes; 4]; 2],
            ) -> Columns<S> {
                let mut sum = [splat(simd, 0.0); 4];
                for k in 0..4 {
                    let mut plane = [splat(simd, 0.0); 4];
                    for j in 0..4 {
                        add(&mut plane, y[j].load(simd), Self::quads(simd, &stage.0[4 * k + j]));
                    }
                    add(&mut sum, z[k].load(simd), plane);
                }
                sum
            }

            #[inline(always)]
            fn slope_columns<S: Simd>(
                simd: S,
                _: &[&[Self]; 16],
                stage: &BlockStage<Self>,
                [y, z]: [&[Lanes; 4]; 2],
                [dy, dz]: [&[Lanes; 4]; 2],
            ) -> [Columns<S>; 3] {
                let mut sums = [[splat(simd, 0.0); 4]; 3];
                for k in 0..4 {
                    let mut planes = [[splat(simd, 0.0); 4]; 2];
                    for j in 0..4 {
                        let row = Self::quads(simd, &stage.0[4 * k + j]);
                        add(&mut planes[0], y[j].load(simd), row);
                        add(&mut planes[1], dy[j].load(simd), row);
                    }
                    let (weight, slope) = (z[k].load(simd), dz[k].load(simd));
                    add(&mut sums[0], weight, planes[0]);
                    add(&mut sums[1], weight, planes[1]);
                    add(&mut sums[2], slope, planes[0]);
                }
                sums
            }
        }
    )*};
}
staged_blocks!(u8, i8, u16, i16);

/// The same rows, which the compiler knows to be of one length then.
#[inline(always)]
fn equally_long<'a, T>(rows: &[&'a [T]; 16], len: usize) -> [&'a [T]; 16] {
    let mut same = *rows;
    for r in 0..16 {
        same[r] = &rows[r][..len];
    }
    same
}

/// Adds numbers times a weight.
#[inline(always)]
fn add<S: Simd>(sum: &mut Columns<S>, weight: f32x16<S>, numbers: Columns<S>) {
    for i in 0..4 {
        sum[i] += weight * numbers[i];
    }
}

impl Blocks for f32 {
    type Stage = Offsets;

    #[inline(always)]
    fn fetch(_: &[&[Self]; 16], offset: [u32; LANES], stage: &mut Offsets) {
        stage.0 = offset;
    }

    #[inline(always)]
    fn columns<S: Simd>(
        simd: S,
        rows: &[&[Self]; 16],
        Offsets(offset): &Offsets,
        [y, z]: [&[Lanes; 4]; 2],
    ) -> Columns<S> {
        let rows = equally_long(rows, rows[0].len());
        let zero = f32x4::splat(simd, 0.0);
        let mut sums = [zero; LANES];
        for i in 0..LANES {
            let o = offset[i] as usize;
            let mut sum = zero;
            for k in 0..4 {
                let mut plane = zero;
                for j in 0..4 {
                    plane += f32x4::from_slice(simd, &rows[4 * k + j][o..o + 4]) * y[j].0[i];
                }
                sum += plane * z[k].0[i];
            }
            sums[i] = sum;
        }
        transpose(sums)
    }

    #[inline(always)]
    fn slope_columns<S: Simd>(
        simd: S,
        rows: &[&[Self]; 16],
        Offsets(offset): &Offsets,
        [y, z]: [&[Lanes; 4]; 2],
        [dy, dz]: [&[Lanes; 4]; 2],
    ) -> [Columns<S>; 3] {
        let rows = equally_long(rows, rows[0].len());
        let zero = f32x4::splat(simd, 0.0);
        let (mut sums, mut along_y, mut along_z) = ([zero; LANES], [zero; LANES], [zero; LANES]);
        for i in 0..LANES {
            let o = offset[i] as usize;
            let (mut sum, mut sum_y, mut sum_z) = (zero, zero, zero);
            for k in 0..4 {
                let (mut plane, mut plane_y) = (zero, zero);
                for j in 0..4 {
                    let row = f32x4::from_slice(simd, &rows[4 * k + j][o..o + 4]);
                    plane += row * y[j].0[i];
                    plane_y += row * dy[j].0[i];
                }
                sum += plane * z[k].0[i];
                sum_y += plane_y * z[k].0[i];
                sum_z += plane * dz[k].0[i];
            }
            (sums[i], along_y[i], along_z[i]) = (sum, sum_y, sum_z);
        }
        [transpose(sums), transpose(along_y), transpose(along_z)]
    }
}

impl<'a, T: Blocks> WideField<'a, T> {
    /// The field of a lattice of fewer than 2³¹ voxels (of the B-spline: of its coefficients) under a filter; `None` under one of fewer taps, and of a
    /// lattice that is too narrow along x for rows of four.
    pub fn new(lattice: &Lattice<'a, T>, filter: Filter) -> Option<Self> {
        let [nx, ny, nz] = lattice.dims;
        if filter.reach() == 0 || nx < 4 {
            return None;
        }
        let samples = lattice.samples;
        let start = |r: usize| ((r >> 2).min(nz - 1) * ny + (r & 3).min(ny - 1)) * nx;
        let len = samples.len() - start(15);
        Some(Self {
            rows: std::array::from_fn(|r| &samples[start(r)..start(r) + len]),
            stride: [nx as i32, (nx * ny) as i32],
            last_cell: lattice.dims.map(|n| n as i32 - 2),
            filter,
        })
    }

    /// Fetches the voxels around sixteen places.
    #[inline(always)]
    pub fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut T::Stage) {
        let [x, y, z] = [
            base(simd, at.cell[0], self.last_cell[0]),
            base(simd, at.cell[1], self.last_cell[1]),
            base(simd, at.cell[2], self.last_cell[2]),
        ];
        let offset: u32x16<S> = (z * self.stride[1] + y * self.stride[0] + x).bitcast();
        T::fetch(&self.rows, offset.to_array(), stage);
    }

    /// Weights of the voxels around sixteen places.
    #[inline(always)]
    pub fn weights<S: Simd>(&self, simd: S, at: &Cells<S>, weights: &mut AxisWeights) {
        tap_weights(simd, self.filter, self.last_cell, at, weights);
    }

    /// Derivatives of the weights by the places.
    #[inline(always)]
    pub fn slopes<S: Simd>(&self, simd: S, at: &Cells<S>, slopes: &mut AxisWeights) {
        tap_slopes(simd, self.filter, self.last_cell, at, slopes);
    }

    /// The field at places whose voxels have been fetched: f = Σ xᵢ yⱼ zₖ fᵢⱼₖ.
    #[inline(always)]
    pub fn value<S: Simd>(&self, simd: S, [x, y, z]: &AxisWeights, stage: &T::Stage) -> f32x16<S> {
        along_x(simd, x, T::columns(simd, &self.rows, stage, [y, z]))
    }

    /// Gradients per index step at places whose voxels have been fetched, the filter's own, from weights and their derivatives.
    #[inline(always)]
    pub fn gradient<S: Simd>(
        &self,
        simd: S,
        [x, y, z]: &AxisWeights,
        [dx, dy, dz]: &AxisWeights,
        stage: &T::Stage,
    ) -> [f32x16<S>; 3] {
        let [values, along_y, along_z] = T::slope_columns(simd, &self.rows, stage, [y, z], [dy, dz]);
        [along_x(simd, dx, values), along_x(simd, x, along_y), along_x(simd, x, along_z)]
    }
}

#[inline(always)]
fn along_x<S: Simd>(simd: S, x: &[Lanes; 4], [a, b, c, d]: Columns<S>) -> f32x16<S> {
    ((x[0].load(simd) * a + x[1].load(simd) * b) + x[2].load(simd) * c) + x[3].load(simd) * d
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::cells;
    use fearless_simd::{Level, dispatch};
    use vr_core::filter::{BSpline, CatmullRom, Gaussian, Reconstruction};

    /// Largest difference from the scalar filter in the same precision, in units of the largest voxel: the order of a few sums, and (Gaussian) an exponential
    /// that is good to 10⁻⁷. Derivatives are sums of terms several times as large, which cancel.
    const ROUNDING: f32 = 1e-6;

    fn check<T: Blocks, F: Reconstruction>(dims: [usize; 3], of: impl Fn(usize) -> T) {
        let samples: Vec<T> = (0..dims.iter().product()).map(of).collect();
        let lattice = Lattice { samples: &samples[..], dims };
        let largest = samples.iter().map(|s| s.to_f32().abs()).fold(0.0, f32::max);
        let field = WideField::new(&lattice, F::FILTER).unwrap();
        // Sixteen places at a time all over the box, its faces and corners among them.
        let place = |i: usize, a: usize| {
            let share = [i % 5, i / 5 % 5, i / 25][a] as f32 / 4.0 + if i % 3 == 1 { 0.037 } else { 0.0 };
            share.min(1.0) * (dims[a] - 1) as f32
        };
        for group in 0..8 {
            let at: [[f32; LANES]; 3] =
                std::array::from_fn(|a| std::array::from_fn(|i| place((group * LANES + i).min(124), a)));
            let (value, gradient) = dispatch!(Level::new(), simd => {
                let position = at.each_ref().map(|x| f32x16::load_array_ref(simd, x));
                let at = cells(simd, position, dims.map(|n| n as i32 - 2));
                let mut stage = T::Stage::default();
                field.fetch(simd, &at, &mut stage);
                let (mut weights, mut slopes) = ([[Lanes::ZERO; 4]; 3], [[Lanes::ZERO; 4]; 3]);
                field.weights(simd, &at, &mut weights);
                field.slopes(simd, &at, &mut slopes);
                let gradient = field.gradient(simd, &weights, &slopes, &stage).map(|g| g.to_array());
                (field.value(simd, &weights, &stage).to_array(), gradient)
            });
            for i in 0..LANES {
                let (want, slope) = F::value_and_gradient(&lattice, [at[0][i], at[1][i], at[2][i]]);
                assert!(
                    (value[i] - want).abs() <= ROUNDING * largest,
                    "{} at {at:?} {i}: {}, not {want}",
                    F::FILTER,
                    value[i]
                );
                for a in 0..3 {
                    let off = (gradient[a][i] - slope[a]).abs();
                    assert!(
                        off <= 4.0 * ROUNDING * largest,
                        "{} {dims:?} {i} {a}: {} for {}",
                        F::FILTER,
                        gradient[a][i],
                        slope[a]
                    );
                }
            }
        }
    }

    fn check_types<F: Reconstruction>() {
        for dims in [[4, 2, 3], [5, 6, 4], [9, 5, 7]] {
            check::<u8, F>(dims, |i| (i * 7919 % 251) as u8);
            check::<i8, F>(dims, |i| (i * 7919 % 251) as u8 as i8);
            check::<u16, F>(dims, |i| (i * 7919 % 65521) as u16);
            check::<i16, F>(dims, |i| (i * 7919 % 65521) as u16 as i16);
            check::<f32, F>(dims, |i| (i * 7919 % 251) as f32 * 0.37 - 40.0);
        }
    }

    #[test]
    fn values_and_gradients_are_those_of_the_filter() {
        check_types::<BSpline>();
        check_types::<CatmullRom>();
        check_types::<Gaussian>();
    }

    #[test]
    fn narrow_lattices_and_filters_of_fewer_taps_are_left_to_others() {
        let samples = [0u8; 4 * 4 * 4];
        assert!(WideField::new(&Lattice { samples: &samples[..48], dims: [3, 4, 4] }, Filter::BSpline).is_none());
        assert!(WideField::new(&Lattice { samples: &samples, dims: [4, 4, 4] }, Filter::Trilinear).is_none());
    }
}
