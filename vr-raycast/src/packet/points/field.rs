//! Field of scattered points at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::PointKernel;
use vr_kernels::vector::{Cells, LANES, Lanes, Shade, StepOptics, opacity_of_depth, pick, splat};

use super::cells::{NearPoint, PointCells};
use crate::packet::fields::PacketField;

/// Field of scattered points.
#[derive(Clone, Copy)]
pub(super) struct PointField<'a> {
    pub(super) cells: &'a PointCells,
    pub(super) kernel: PointKernel,
    /// One over the kernel's integral: W(0) of the cubic spline and the cone; of the Gaussian, what its exponentials are multiplied by.
    pub(super) factor: f32,
}

/// Values at the places that were fetched last, and 1 where there are any.
pub(super) struct PointStage {
    values: Lanes,
    exists: Lanes,
}

impl Default for PointStage {
    fn default() -> Self {
        Self { values: Lanes::ZERO, exists: Lanes::ZERO }
    }
}

/// −ln of a Gaussian at its radius, and the Gaussian there.
const GAUSSIAN: f32 = 4.5;
const GAUSSIAN_EDGE: f32 = 0.011_108_997;

impl PointField<'_> {
    /// Calls `add` with each point near sixteen places: the vectors from it to them, the squares of their lengths in radii, and the lanes in the support.
    #[inline(always)]
    fn each_near<S: Simd>(
        &self,
        simd: S,
        at: &Cells<S>,
        mut add: impl FnMut(&NearPoint, [f32x16<S>; 3], f32x16<S>, mask32x16<S>),
    ) {
        for level in &self.cells.levels {
            // Offsets from the lower corners of the lists' cells, and the numbers of these.
            let (mut offset, mut index) = ([splat(simd, 0.0); 3], at.cell[2]);
            let shift = level.shift;
            for a in 0..3 {
                let rest: f32x16<S> = (at.cell[a] & ((1 << shift) - 1)).to_float();
                offset[a] = (rest + at.fraction[a]) * self.cells.edges[a];
            }
            let [nx, ny, _] = level.cells.map(|n| n as i32);
            index = ((index >> shift) * ny + (at.cell[1] >> shift)) * nx + (at.cell[0] >> shift);
            let cells = index.to_array();
            let mut left = u32::MAX >> (32 - LANES);
            while left != 0 {
                // All lanes in the cell of the first that is left.
                let cell = cells[left.trailing_zeros() as usize];
                let here = index.simd_eq(fearless_simd::i32x16::splat(simd, cell));
                left &= !(here.to_bitmask() as u32);
                for point in level.of(cell as u32 as usize) {
                    let from = [offset[0] - point.offset[0], offset[1] - point.offset[1], offset[2] - point.offset[2]];
                    let square = (from[0] * from[0] + from[1] * from[1] + from[2] * from[2]) * point.per_square;
                    let inside = here & square.simd_lt(splat(simd, 1.0));
                    if inside.any_true() {
                        add(point, from, square, inside);
                    }
                }
            }
        }
    }

    /// Kernel without its factor, by the square of the distance in radii: below 1.
    #[inline(always)]
    fn kernel<S: Simd>(&self, simd: S, square: f32x16<S>) -> f32x16<S> {
        let one = splat(simd, 1.0);
        match self.kernel {
            PointKernel::CubicSpline => {
                let t = square.sqrt();
                let u = one - t;
                pick(t.simd_le(splat(simd, 0.5)), one - square * u * 6.0, u * u * u * 2.0)
            }
            PointKernel::Gaussian => one - opacity_of_depth(simd, square * GAUSSIAN) - GAUSSIAN_EDGE,
            PointKernel::Cone => one - square.sqrt(),
        }
    }

    /// Slope over distance of the kernel without its factor, in radii.
    #[inline(always)]
    fn slope<S: Simd>(&self, simd: S, square: f32x16<S>) -> f32x16<S> {
        let one = splat(simd, 1.0);
        let tiny = splat(simd, f32::MIN_POSITIVE);
        match self.kernel {
            PointKernel::CubicSpline => {
                let t = square.sqrt();
                let u = one - t;
                pick(t.simd_le(splat(simd, 0.5)), t * 18.0 - 12.0, u * u * -6.0 / t.max(tiny))
            }
            PointKernel::Gaussian => (one - opacity_of_depth(simd, square * GAUSSIAN)) * (-2.0 * GAUSSIAN),
            // None in the middle of a cone.
            PointKernel::Cone => {
                let is_middle = square.simd_le(splat(simd, 0.0));
                pick(is_middle, splat(simd, 0.0), splat(simd, -1.0) / pick(is_middle, one, square).sqrt())
            }
        }
    }

    #[inline(never)]
    fn sample<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut PointStage) {
        simd.vectorize(
            #[inline(always)]
            || {
                let zero = splat(simd, 0.0);
                let (mut sum, mut exists) = (zero, zero);
                self.each_near(
                    simd,
                    at,
                    #[inline(always)]
                    |point, _, square, inside| {
                        let added = self.kernel(simd, square) * point.amplitude;
                        sum += pick(inside, added, zero);
                        exists = pick(inside, splat(simd, 1.0), exists);
                    },
                );
                stage.values = Lanes::new(sum * self.factor);
                stage.exists = Lanes::new(exists);
            },
        );
    }
}

impl PacketField for PointField<'_> {
    type Stage = PointStage;

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut PointStage) {
        self.sample(simd, at, stage);
    }

    #[inline(always)]
    fn value<S: Simd>(&self, simd: S, _: &Cells<S>, stage: &PointStage) -> f32x16<S> {
        stage.values.load(simd)
    }

    #[inline(always)]
    fn outside_vacuum<S: Simd>(&self, simd: S, [r, g, b, a]: [f32x16<S>; 4], stage: &PointStage) -> [f32x16<S>; 4] {
        let (zero, exists) = (splat(simd, 0.0), stage.exists.load(simd).simd_gt(splat(simd, 0.0)));
        [pick(exists, r, zero), pick(exists, g, zero), pick(exists, b, zero), pick(exists, a, zero)]
    }

    /// Gradients per world unit; they are not followed.
    #[inline(never)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        [cell, fraction]: &[[Lanes; 3]; 2],
        _: &[Lanes; 3],
        _: &mut PointStage,
    ) -> [[Lanes; 3]; 2] {
        let mut found = [[Lanes::ZERO; 3]; 2];
        simd.vectorize(
            #[inline(always)]
            || {
                let zero = splat(simd, 0.0);
                let at = Cells {
                    cell: [cell[0].load(simd).to_int(), cell[1].load(simd).to_int(), cell[2].load(simd).to_int()],
                    fraction: [fraction[0].load(simd), fraction[1].load(simd), fraction[2].load(simd)],
                };
                let mut sum = [zero; 3];
                self.each_near(
                    simd,
                    &at,
                    #[inline(always)]
                    |point, from, square, inside| {
                        let slope = self.slope(simd, square) * (point.amplitude * point.per_square);
                        let slope = pick(inside, slope, zero);
                        for a in 0..3 {
                            sum[a] += from[a] * slope;
                        }
                    },
                );
                let unit = self.factor / self.cells.spacing as f32;
                found[0] = [Lanes::new(sum[0] * unit), Lanes::new(sum[1] * unit), Lanes::new(sum[2] * unit)];
            },
        );
        found
    }

    #[inline(always)]
    fn look<S: Simd>(
        &self,
        simd: S,
        shade: Option<Shade<'_>>,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        optics: Option<&StepOptics>,
        light: &mut [Lanes; 4],
        stage: &mut PointStage,
    ) {
        let Some(shade) = shade else { return };
        let gradients = self.gradients(simd, at, step, stage);
        shade.apply_by(simd, &gradients, optics, light, |_| ());
    }
}
