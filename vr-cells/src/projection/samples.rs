//! Samples of a tile: what cells have added to each so far.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, mask32x16};
use vr_core::Counts;
use vr_kernels::vector::{LANES, rows_of, splat, transpose};

use super::tile::Painter;
use super::tiling::MAX_SIDE;
use crate::accumulators::Seen;

/// Samples of a tile at most.
pub(super) const COUNT: usize = (MAX_SIDE * MAX_SIDE) as usize;
/// Bits of a sample's number below those of its row.
pub(super) const ROW: u32 = MAX_SIDE.trailing_zeros();
/// Added to the number of a sample for a lane that has none: such numbers have samples of their own, which are opaque and in no picture.
pub(super) const SPARE: u32 = COUNT as u32;

/// Numbers of sixteen samples, no two of which are the same but for spare ones.
pub(super) type Numbers = [u32; LANES];

/// Samples of a tile, row by row.
pub(super) struct Samples {
    /// Light and transmittance, four numbers a sample.
    sums: Box<[f32; SUMS]>,
    /// Distance at which half of what is behind is hidden.
    pub(super) depths: Box<[f32; 2 * COUNT]>,
    /// Samples of each row that are not opaque, and the number of all of them.
    open: [u64; MAX_SIDE as usize],
    pub(super) open_count: u32,
    /// Number of samples in the picture.
    count: u32,
}

/// Light and transmittance of sixteen samples.
#[derive(Clone, Copy)]
pub(super) struct Sums<S: Simd> {
    pub(super) light: [f32x16<S>; 3],
    pub(super) clear: f32x16<S>,
}

/// Numbers of all samples, and of spare ones.
const SUMS: usize = 8 * COUNT;

/// First of a sample's four numbers: without a check, because the lower bits of any number are good for one.
#[inline(always)]
fn first_sum(number: u32) -> usize {
    (4 * number as usize) & (SUMS - 4)
}

/// An array on the heap.
pub(super) fn boxed<T: Copy, const N: usize>(value: T) -> Box<[T; N]> {
    vec![value; N].try_into().unwrap_or_else(|_| unreachable!("as many as there are"))
}

impl Samples {
    /// Samples of a tile of a size that have met nothing.
    pub(super) fn new([width, height]: [u32; 2]) -> Self {
        let mut sums = boxed(0.0);
        sums[..4 * COUNT].iter_mut().skip(3).step_by(4).for_each(|clear| *clear = 1.0);
        let mut open = [0; MAX_SIDE as usize];
        open[..height as usize].fill(bits(0, width));
        let count = width * height;
        Self { sums, depths: boxed(f32::INFINITY), open, open_count: count, count }
    }

    /// Samples of a row that are not opaque.
    #[inline(always)]
    pub(super) fn open(&self, row: u32) -> u64 {
        self.open[row as usize]
    }

    /// True if there is a sample that is opaque.
    #[inline(always)]
    pub(super) fn has_opaque(&self) -> bool {
        self.open_count < self.count
    }

    /// True if there is a sample that is not opaque in some columns of some rows.
    #[inline(always)]
    pub(super) fn has_open(&self, [columns, rows]: [[u32; 2]; 2]) -> bool {
        let open = self.open[rows[0] as usize..rows[1] as usize].iter().fold(0, |all, row| all | row);
        open & bits(columns[0], columns[1]) != 0
    }

    /// Light and transmittance of some samples.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, numbers: &Numbers) -> Sums<S> {
        let mut rows = [f32x4::splat(simd, 0.0); LANES];
        for i in 0..LANES {
            let first = first_sum(numbers[i]);
            rows[i] = f32x4::from_slice(simd, &self.sums[first..first + 4]);
        }
        let [red, green, blue, clear] = transpose(rows);
        Sums { light: [red, green, blue], clear }
    }

    /// Replaces light and transmittance of some samples.
    #[inline(always)]
    pub(super) fn store<S: Simd>(&mut self, numbers: &Numbers, sums: &Sums<S>) {
        let [red, green, blue] = sums.light;
        let rows = rows_of([red, green, blue, sums.clear]);
        for i in 0..LANES {
            let first = first_sum(numbers[i]);
            rows[i].store_slice(&mut self.sums[first..first + 4]);
        }
    }

    /// Notes which samples have become opaque, by their transmittances before and after a cell: none is clearer than `min_clear`.
    #[inline(always)]
    pub(super) fn close_dark<S: Simd>(
        &mut self,
        simd: S,
        numbers: &Numbers,
        [before, after]: [f32x16<S>; 2],
        min_clear: f32,
    ) {
        let least = splat(simd, min_clear);
        let dark = before.simd_gt(least) & after.simd_le(least);
        if dark.any_true() {
            self.close(numbers, dark);
        }
    }

    #[inline(never)]
    fn close<S: Simd>(&mut self, numbers: &Numbers, dark: mask32x16<S>) {
        for (i, &number) in numbers.iter().enumerate() {
            if dark.test(i) && number < SPARE {
                self.open[(number >> ROW) as usize] &= !(1 << (number % MAX_SIDE));
                self.open_count -= 1;
            }
        }
    }

    /// The pixels of the tile, which has its first one at a place of the picture.
    pub(super) fn pixels(
        &self,
        painter: &Painter<'_>,
        first: [u32; 2],
        pixels: [u32; 2],
        counts: &mut Counts,
    ) -> Vec<Seen> {
        let n = painter.tiling.per_pixel;
        let share = 1.0 / f64::from(n * n);
        let mut seen = Vec::with_capacity((pixels[0] * pixels[1]) as usize);
        for y in 0..pixels[1] {
            for x in 0..pixels[0] {
                let number = ((first[1] + y) * painter.view.size[0] + first[0] + x) as usize;
                let mut mean = Seen { rgba: [0.0; 4], depth: f64::INFINITY };
                for k in 0..n * n {
                    let [column, row] = [x * n + k % n, y * n + k / n];
                    let sample = ((row << ROW) + column) as usize;
                    let [r, g, b, clear] = [0, 1, 2, 3].map(|c| f64::from(self.sums[4 * sample + c]));
                    let alpha = 1.0 - clear;
                    counts.rays += u64::from(alpha > 0.0);
                    counts.terminated += u64::from(clear <= f64::from(painter.min_clear));
                    let seen = Seen { rgba: [r, g, b, alpha], depth: f64::from(self.depths[sample]) };
                    let seen = seen.before(painter.layer, number);
                    (0..4).for_each(|c| mean.rgba[c] += seen.rgba[c] * share);
                    mean.depth = mean.depth.min(seen.depth);
                }
                seen.push(mean);
            }
        }
        seen
    }
}

/// Bits from one up to before another, of which there is at least one.
#[inline(always)]
pub(super) fn bits(from: u32, to: u32) -> u64 {
    (u64::MAX << from) & (u64::MAX >> (64 - to))
}
