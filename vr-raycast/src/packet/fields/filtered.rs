//! Field of any voxels under any filter, with gradients of either kind and with colours.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::filter::Lattice;
use vr_core::{ColorGrid, Filter, GradientMethod, GridVolume};
use vr_kernels::vector::{
    AnyField, AxisWeights, ByType, Cells, LANES, Lanes, Shade, Stage, StepOptics, VoxelColors, WideField,
    central_differences,
};

use super::PacketField;
use super::by_type::{
    AnyStage, AnyWideField, OfType, block_gradients, block_values, cell_gradients, cell_values, nearest_values,
    with_type,
};
use super::cells_of;
use super::colors::tint;
use crate::packet::engine::with_voxels;

/// Field of any voxels under any filter, with gradients of either kind and with colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilteredField<'a> {
    /// The voxels, for central differences and for filters of a cell.
    voxels: AnyField<'a>,
    sampling: Sampling<'a>,
    gradient: GradientMethod,
    colors: Option<VoxelColors<'a>>,
}

/// Source of the values.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "a frame has one: a box would save nothing")]
enum Sampling<'a> {
    /// The nearest voxel.
    Nearest,
    /// The eight voxels of a cell.
    Cell,
    /// Blocks of 4³ voxels, or of coefficients.
    Block(AnyWideField<'a>),
}

/// Stage of a [`FilteredField`].
pub(crate) struct FilteredStage {
    /// Places that were sampled last, where gradients are the filter's own.
    sampled: Places,
    /// Weights at those places, of a filter of four taps an axis.
    weights: AxisWeights,
    /// Values there.
    values: Lanes,
    voxels: AnyStage,
    colors: Stage<u16>,
}

impl Default for FilteredStage {
    fn default() -> Self {
        Self {
            // Nowhere: nothing has been sampled.
            sampled: Places([[Lanes([f32::NAN; LANES]); 3]; 2]),
            weights: [[Lanes::ZERO; 4]; 3],
            values: Lanes::ZERO,
            voxels: AnyStage::default(),
            colors: Stage::default(),
        }
    }
}

/// Cells and fractions in them.
struct Places([[Lanes; 3]; 2]);

impl Places {
    fn is(&self, other: &[[Lanes; 3]; 2]) -> bool {
        self.0.as_flattened().iter().zip(other.as_flattened()).all(|(a, b)| a.0 == b.0)
    }

    #[inline(never)]
    fn set<S: Simd>(&mut self, simd: S, at: &Cells<S>) {
        simd.vectorize(
            #[inline(always)]
            || {
                for a in 0..3 {
                    self.0[0][a] = Lanes::new(at.cell[a].to_float());
                    self.0[1][a] = Lanes::new(at.fraction[a]);
                }
            },
        );
    }
}

/// True if packets can sample the field of a volume: rows of four voxels fit into it, where the filter takes them.
pub(crate) fn can_sample(volume: &GridVolume) -> bool {
    volume.filter().reach() == 0 || volume.dims()[0] >= 4
}

/// True if a volume is sampled by kernels of its type: it is trilinear, without colours, and its gradients are central differences.
fn is_plain(volume: &GridVolume, colors: Option<&ColorGrid>, gradient: GradientMethod) -> bool {
    volume.filter() == Filter::Trilinear && colors.is_none() && gradient == GradientMethod::CentralDifferences
}

impl<'a> FilteredField<'a> {
    /// Returns the field of a volume, with the colours of its voxels, if they have any; `None` where a [`Field`](vr_kernels::vector::Field) of the voxels' type is all that it takes,
    /// and of a volume that [packets cannot sample](can_sample).
    pub(crate) fn new(volume: &'a GridVolume, colors: Option<&'a ColorGrid>, gradient: GradientMethod) -> Option<Self> {
        if is_plain(volume, colors, gradient) {
            return None;
        }
        let sampled = Self::of_grid(volume, gradient)?;
        Some(Self { colors: colors.map(VoxelColors::new), ..sampled })
    }

    /// Returns the field of a volume, whatever it takes; `None` of one that [packets cannot sample](can_sample).
    pub(crate) fn of_grid(volume: &'a GridVolume, gradient: GradientMethod) -> Option<Self> {
        let filter = volume.filter();
        let sampling = match filter {
            Filter::Nearest => Sampling::Nearest,
            Filter::Trilinear => Sampling::Cell,
            Filter::BSpline => {
                let lattice = Lattice { samples: volume.spline_coefficients(), dims: volume.dims() };
                Sampling::Block(ByType::F32(WideField::new(&lattice, filter)?))
            }
            Filter::CatmullRom | Filter::Gaussian => {
                with_voxels!(volume, lattice => Sampling::Block(OfType::wide_field(WideField::new(&lattice, filter)?)))
            }
        };
        Some(Self { voxels: AnyField::of_volume(volume), sampling, gradient, colors: None })
    }

    /// Writes the values at places, from voxels that are staged on the way.
    ///
    /// Its own function, as the others here are: the marches call it from many places.
    #[inline(never)]
    fn sample<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut FilteredStage) {
        let FilteredStage { sampled, weights, values, voxels, .. } = stage;
        if self.gradient == GradientMethod::Analytic {
            sampled.set(simd, at);
        }
        match &self.sampling {
            Sampling::Nearest => with_type!(&self.voxels, voxels, (field, [mut] _typed) => {
                nearest_values(simd, field, at, values);
            }),
            Sampling::Cell => with_type!(&self.voxels, voxels, (field, [mut] typed) => {
                cell_values(simd, field, at, typed, values);
            }),
            Sampling::Block(blocks) => with_type!(blocks, voxels, (field, [mut] typed) => {
                block_values(simd, field, at, weights, typed, values);
            }),
        }
    }
}

impl PacketField for FilteredField<'_> {
    type Stage = FilteredStage;

    #[inline(always)]
    fn has_colors(&self) -> bool {
        self.colors.is_some()
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut FilteredStage) {
        self.sample(simd, at, stage);
    }

    #[inline(always)]
    fn value<S: Simd>(&self, simd: S, _: &Cells<S>, stage: &FilteredStage) -> f32x16<S> {
        stage.values.load(simd)
    }

    #[inline(always)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        place: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        stage: &mut FilteredStage,
    ) -> [[Lanes; 3]; 2] {
        if self.gradient == GradientMethod::CentralDifferences {
            return with_type!(&self.voxels, stage.voxels, (field, [mut] typed) => {
                central_differences(simd, field, place, step, &mut typed.cells)
            });
        }
        // The filter's own gradients are not followed.
        let mut found = [[Lanes::ZERO; 3]; 2];
        let at = &cells_of(simd, place);
        // What was sampled for another place must be fetched anew.
        if !stage.sampled.is(place) {
            self.sample(simd, at, stage);
        }
        match &self.sampling {
            // The field is constant around each voxel.
            Sampling::Nearest => {}
            Sampling::Cell => with_type!(&self.voxels, stage.voxels, (field, [] typed) => {
                cell_gradients(simd, field, at, typed, &mut found[0]);
            }),
            Sampling::Block(blocks) => with_type!(blocks, stage.voxels, (field, [] typed) => {
                block_gradients(simd, field, at, &stage.weights, typed, &mut found[0]);
            }),
        }
        found
    }

    #[inline(never)]
    fn look<S: Simd>(
        &self,
        simd: S,
        shade: Option<Shade<'_>>,
        place: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        optics: Option<&StepOptics>,
        light: &mut [Lanes; 4],
        stage: &mut FilteredStage,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let gradients = shade.map(|_| self.gradients(simd, place, step, stage));
                let mut in_colors = |light: &mut [Lanes; 4]| {
                    if let Some(colors) = &self.colors {
                        tint(simd, colors, place, light, &mut stage.colors);
                    }
                };
                match (shade, gradients) {
                    (Some(shade), Some(gradients)) => shade.apply_by(simd, &gradients, optics, light, in_colors),
                    _ => in_colors(light),
                }
            },
        );
    }
}
