//! Gradients of grids: one by one, and of sixteen places at once.

use fearless_simd::Simd;
use glam::DVec3;
use vr_core::{GradientMethod, GridVolume, Shading};
use vr_kernels::vector::{AnyField, LANES, Lanes, Shade, Stage, StepOptics, central_differences};
use vr_kernels::with_any;

use crate::kernel::{Shape, SplatKernel};
use crate::kernel_sum::KernelSum;
use crate::splatter::Splatter;

/// Source of gradients.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Gradients {
    /// Central differences at the voxels.
    CentralDifferences,
    /// The field of the grid's filter.
    Filter,
    /// The sum of kernels that were asked for in its place.
    KernelSum(KernelSum),
}

impl Gradients {
    /// The source that a shading asks for, of voxels that a renderer spreads by its kernel.
    pub(crate) fn new(shading: &Shading, renderer: &Splatter, volume: &GridVolume) -> Self {
        let own = SplatKernel::new(Shape::of_filter(volume.filter()));
        match shading.gradient {
            GradientMethod::CentralDifferences => Self::CentralDifferences,
            GradientMethod::Analytic if renderer.kernel == own => Self::Filter,
            GradientMethod::Analytic => Self::KernelSum(KernelSum::new(&renderer.kernel)),
        }
    }

    /// Gradient per index step at a place in a grid, in stored units.
    pub(crate) fn at(&self, volume: &GridVolume, place: [f64; 3]) -> [f64; 3] {
        match self {
            Self::CentralDifferences => volume.central_differences_at(place),
            Self::Filter => volume.stored_and_gradient_at(place).1,
            Self::KernelSum(sum) => sum.gradient_at(volume, place),
        }
    }
}

/// Gradient in value per world unit of one per index step in stored units.
pub(crate) fn world_gradient(volume: &GridVolume, per_index: [f64; 3]) -> DVec3 {
    volume.placement().gradient_to_world(DVec3::from(per_index)) * volume.calibration().slope
}

/// A grid, as its gradients are looked up.
pub(crate) struct GridGradients<'a> {
    source: Gradients,
    volume: &'a GridVolume,
    field: AnyField<'a>,
}

impl<'a> GridGradients<'a> {
    /// The gradients that a shading asks for, of voxels that a renderer spreads by its kernel.
    pub(crate) fn new(shading: &Shading, renderer: &Splatter, volume: &'a GridVolume) -> Self {
        Self { source: Gradients::new(shading, renderer, volume), volume, field: AnyField::of_volume(volume) }
    }

    /// True if gradients are those that vectors take from the voxels.
    pub(crate) fn are_central_differences(&self) -> bool {
        matches!(self.source, Gradients::CentralDifferences)
    }

    /// Shades light at places in index space by central differences, its extinction times the factors on steps first where such are given, then its colours by
    /// `tint`.
    #[inline(always)]
    pub(crate) fn shade<S: Simd>(
        &self,
        simd: S,
        shade: Shade<'_>,
        place: &[Lanes; 3],
        modulated: Option<&StepOptics>,
        light: &mut [Lanes; 4],
        tint: impl FnOnce(&mut [Lanes; 4]),
    ) {
        let at = with_any!(&self.field, f => cells(f.last_cell, place));
        let none = [Lanes::ZERO; 3];
        match modulated {
            Some(optics) => {
                let gradients =
                    with_any!(&self.field, f => central_differences(simd, f, &at, &none, &mut Stage::default()));
                shade.apply_by(simd, &gradients, Some(optics), light, tint);
            }
            None => {
                tint(light);
                with_any!(&self.field, f => shade.apply(simd, f, &at, &none, light, &mut Stage::default()));
            }
        }
    }

    /// The gradient per index step, in stored units, at the place of one of the lanes, or the nearest one that is in the grid.
    pub(crate) fn of_lane(&self, place: &[Lanes; 3], lane: usize) -> [f64; 3] {
        let dims = self.volume.dims();
        let last = |a: usize| (dims[a] - 1) as f64;
        self.source.at(self.volume, std::array::from_fn(|a| f64::from(place[a].0[lane]).clamp(0.0, last(a))))
    }

    /// Magnitude in value per world unit of a gradient per index step.
    pub(crate) fn magnitude(&self, per_index: [f64; 3]) -> f64 {
        world_gradient(self.volume, per_index).length()
    }
}

/// Cells of places in index space, and fractions in them.
#[inline(always)]
fn cells(last: [i32; 3], place: &[Lanes; 3]) -> [[Lanes; 3]; 2] {
    let mut at = [[Lanes::ZERO; 3]; 2];
    for a in 0..3 {
        for i in 0..LANES {
            let x = place[a].0[i].max(0.0).min((last[a] + 1) as f32);
            let cell = (x as i32).min(last[a]) as f32;
            (at[0][a].0[i], at[1][a].0[i]) = (cell, x - cell);
        }
    }
    at
}
