//! Field of scattered points at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::{PointKernel, PointMixing, PointSet};
use vr_kernels::vector::{Cells, LANES, Lanes, Shade, StepOptics, opacity_of_depth, pick, splat};

use super::cells::{Carried, NearPoint, PointCells};
use super::even_ramps::EvenRamps;
use crate::packet::fields::{PacketField, StepKinds, cells_of};

/// Field of scattered points.
#[derive(Clone, Copy)]
pub(super) struct PointField<'a> {
    pub(super) cells: &'a PointCells,
    pub(super) kernel: PointKernel,
    /// One over the kernel's integral: W(0) of the cubic spline and the cone; of the Gaussian, what its exponentials are multiplied by.
    pub(super) factor: f32,
    /// Combination of the values.
    pub(super) mixing: PointMixing,
    /// True if the points have colours.
    pub(super) has_colors: bool,
    /// Places that stand for values in the tables; `None` where values do.
    pub(super) ramps: Option<&'a EvenRamps>,
}

/// Samples at the places that were fetched last.
pub(super) struct PointStage {
    /// Values as tables number them.
    values: Lanes,
    /// 1 where there are any.
    exists: Lanes,
    /// The mean of the values, and its weight without the kernel's factor; of sums neither is known.
    mean: Lanes,
    weight: Lanes,
}

impl Default for PointStage {
    fn default() -> Self {
        Self { values: Lanes::ZERO, exists: Lanes::ZERO, mean: Lanes::ZERO, weight: Lanes::ZERO }
    }
}

/// Sums of a mean at sixteen places. Each point adds its difference from one of them, the base: what all points share is the mean to the last bit, and its
/// gradient is 0.
struct MeanSums<S: Simd, const N: usize> {
    base: [f32x16<S>; N],
    sum: [f32x16<S>; N],
    weight: f32x16<S>,
    /// 1 where a point is near.
    exists: f32x16<S>,
}

impl<S: Simd, const N: usize> MeanSums<S, N> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        Self { base: [zero; N], sum: [zero; N], weight: zero, exists: zero }
    }

    /// Adds what a point carries, by its weight at the places that it reaches.
    #[inline(always)]
    fn add(&mut self, simd: S, carried: [f32; N], weight: f32x16<S>, inside: mask32x16<S>) {
        let weight = pick(inside, weight.max(splat(simd, 0.0)), splat(simd, 0.0));
        let is_first = inside & self.exists.simd_le(splat(simd, 0.0));
        self.exists = pick(inside, splat(simd, 1.0), self.exists);
        self.weight += weight;
        for c in 0..N {
            self.base[c] = pick(is_first, splat(simd, carried[c]), self.base[c]);
            self.sum[c] += weight * (splat(simd, carried[c]) - self.base[c]);
        }
    }

    /// The means; the base where all kernels vanish by rounding.
    #[inline(always)]
    fn means(&self, simd: S) -> [f32x16<S>; N] {
        let per_weight = reciprocal_of_weight(simd, self.weight);
        let mut means = self.base;
        for c in 0..N {
            means[c] += self.sum[c] * per_weight;
        }
        means
    }
}

/// One over a weight; 0 over one that has vanished by rounding.
#[inline(always)]
fn reciprocal_of_weight<S: Simd>(simd: S, weight: f32x16<S>) -> f32x16<S> {
    let one = splat(simd, 1.0);
    let has_weight = weight.simd_gt(splat(simd, f32::MIN_POSITIVE));
    pick(has_weight, one / pick(has_weight, weight, one), splat(simd, 0.0))
}

/// Part in means of points that have none.
const NOTHING: Carried = Carried { weight: 0.0, value: 0.0, color: [0.0; 3] };

/// −ln of a Gaussian at its radius, and the Gaussian there.
const GAUSSIAN: f32 = 4.5;
const GAUSSIAN_EDGE: f32 = 0.011_108_997;

impl<'a> PointField<'a> {
    /// Field of the values of a set, as they are and without its colours.
    pub(super) fn of_values(points: &PointSet, cells: &'a PointCells) -> Self {
        let kernel = points.kernel();
        // W(t) over the same without its factor, at a place where neither is small.
        let factor = kernel.at(0.0) / if kernel == PointKernel::Gaussian { 1.0 - libm::exp(-4.5) } else { 1.0 };
        Self { cells, kernel, factor: factor as f32, mixing: points.mixing(), has_colors: false, ramps: None }
    }
}

impl PointField<'_> {
    /// Calls `add` with each point near sixteen places, and its part in means where these are asked for: the vectors from it to them, the squares of their
    /// lengths in radii, and the lanes in the support.
    #[inline(always)]
    fn each_near<S: Simd, const MEANS: bool>(
        &self,
        simd: S,
        at: &Cells<S>,
        mut add: impl FnMut(&NearPoint, &Carried, [f32x16<S>; 3], f32x16<S>, mask32x16<S>),
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
                let cell = cell as u32 as usize;
                let carried = if MEANS { level.carried(cell) } else { &[] };
                for (i, point) in level.of(cell).iter().enumerate() {
                    let from = [offset[0] - point.offset[0], offset[1] - point.offset[1], offset[2] - point.offset[2]];
                    let square = (from[0] * from[0] + from[1] * from[1] + from[2] * from[2]) * point.per_square;
                    let inside = here & square.simd_lt(splat(simd, 1.0));
                    if inside.any_true() {
                        add(point, if MEANS { &carried[i] } else { &NOTHING }, from, square, inside);
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
            || match self.mixing {
                PointMixing::Sum => self.sample_sums(simd, at, stage),
                PointMixing::Mean => self.sample_means(simd, at, stage),
            },
        );
    }

    #[inline(always)]
    fn sample_sums<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut PointStage) {
        let zero = splat(simd, 0.0);
        let (mut sum, mut exists) = (zero, zero);
        self.each_near::<S, false>(
            simd,
            at,
            #[inline(always)]
            |point, _, _, square, inside| {
                let added = self.kernel(simd, square) * point.amplitude;
                sum += pick(inside, added, zero);
                exists = pick(inside, splat(simd, 1.0), exists);
            },
        );
        stage.values = self.numbered(simd, sum * self.factor);
        stage.exists = Lanes::new(exists);
    }

    #[inline(always)]
    fn sample_means<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut PointStage) {
        let mut sums = MeanSums::<S, 1>::new(simd);
        self.each_near::<S, true>(
            simd,
            at,
            #[inline(always)]
            |_, carried, _, square, inside| {
                sums.add(simd, [carried.value], self.kernel(simd, square) * carried.weight, inside);
            },
        );
        let [mean] = sums.means(simd);
        (stage.mean, stage.weight) = (Lanes::new(mean), Lanes::new(sums.weight));
        stage.values = self.numbered(simd, mean);
        stage.exists = Lanes::new(sums.exists);
    }

    /// Values as tables number them.
    #[inline(always)]
    fn numbered<S: Simd>(&self, simd: S, value: f32x16<S>) -> Lanes {
        match self.ramps {
            Some(ramps) => ramps.places(simd, value),
            None => Lanes::new(value),
        }
    }

    /// Multiplies light by the colours of places, the weighted means of those of the points.
    #[inline(never)]
    fn tint<S: Simd>(&self, simd: S, place: &[[Lanes; 3]; 2], light: &mut [Lanes; 4]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut sums = MeanSums::<S, 3>::new(simd);
                self.each_near::<S, true>(
                    simd,
                    &cells_of(simd, place),
                    #[inline(always)]
                    |_, carried, _, square, inside| {
                        sums.add(simd, carried.color, self.kernel(simd, square) * carried.weight, inside);
                    },
                );
                let color = sums.means(simd);
                for c in 0..3 {
                    light[c] = Lanes::new(light[c].load(simd) * color[c]);
                }
            },
        );
    }

    /// Gradient of a sum in units of the spacing, without the kernel's factor.
    #[inline(always)]
    fn sum_gradient<S: Simd>(&self, simd: S, at: &Cells<S>) -> [f32x16<S>; 3] {
        self.rise::<S, false>(
            simd,
            at,
            #[inline(always)]
            |slope, point, _| slope * (point.amplitude * point.per_square),
        )
    }

    /// Gradient of a mean in units of the spacing, (Σ w (v − mean) ∇W) / Σ w W by the quotient rule.
    #[inline(always)]
    fn mean_gradient<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &PointStage) -> [f32x16<S>; 3] {
        let mean = stage.mean.load(simd);
        let rise = self.rise::<S, true>(
            simd,
            at,
            #[inline(always)]
            |slope, point, carried| {
                let apart = splat(simd, carried.value) - mean;
                slope * (carried.weight * point.per_square) * apart
            },
        );
        let per_weight = reciprocal_of_weight(simd, stage.weight.load(simd));
        [rise[0] * per_weight, rise[1] * per_weight, rise[2] * per_weight]
    }

    /// Sum of the vectors from the points near sixteen places, each by what `weigh` makes of the kernel's slope over distance there.
    #[inline(always)]
    fn rise<S: Simd, const MEANS: bool>(
        &self,
        simd: S,
        at: &Cells<S>,
        weigh: impl Fn(f32x16<S>, &NearPoint, &Carried) -> f32x16<S>,
    ) -> [f32x16<S>; 3] {
        let zero = splat(simd, 0.0);
        let mut rise = [zero; 3];
        self.each_near::<S, MEANS>(
            simd,
            at,
            #[inline(always)]
            |point, carried, from, square, inside| {
                let weight = pick(inside, weigh(self.slope(simd, square), point, carried), zero);
                for a in 0..3 {
                    rise[a] += from[a] * weight;
                }
            },
        );
        rise
    }
}

impl PacketField for PointField<'_> {
    type Stage = PointStage;

    /// A mean begins and ends with its vacuum.
    const STEPS: StepKinds = StepKinds::OF_POINTS;

    #[inline(always)]
    fn has_colors(&self) -> bool {
        self.has_colors
    }

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

    #[inline(always)]
    fn has_field<S: Simd>(&self, simd: S, lanes: mask32x16<S>, stage: &PointStage) -> mask32x16<S> {
        lanes & stage.exists.load(simd).simd_gt(splat(simd, 0.0))
    }

    /// Gradients per world unit; they are not followed.
    #[inline(never)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        place: &[[Lanes; 3]; 2],
        _: &[Lanes; 3],
        stage: &mut PointStage,
    ) -> [[Lanes; 3]; 2] {
        let mut found = [[Lanes::ZERO; 3]; 2];
        simd.vectorize(
            #[inline(always)]
            || {
                let at = cells_of(simd, place);
                let (gradient, factor) = match self.mixing {
                    PointMixing::Sum => (self.sum_gradient(simd, &at), self.factor),
                    PointMixing::Mean => (self.mean_gradient(simd, &at, stage), 1.0),
                };
                let unit = factor / self.cells.spacing as f32;
                found[0] =
                    [Lanes::new(gradient[0] * unit), Lanes::new(gradient[1] * unit), Lanes::new(gradient[2] * unit)];
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
        let tint = |light: &mut [Lanes; 4]| {
            if self.has_colors {
                self.tint(simd, at, light);
            }
        };
        let Some(shade) = shade else {
            tint(light);
            return;
        };
        let gradients = self.gradients(simd, at, step, stage);
        shade.apply_by(simd, &gradients, optics, light, tint);
    }
}
