//! Fields that packets march through.
//!
//! The marches are generic over the field, and each instance of them is large: so there is one for each type of voxels under the trilinear filter, which is
//! what most scenes are, and *one* for all else ([`FilteredField`]), which asks what the voxels and the filter are at every sixteen samples.

mod by_type;
mod colors;
mod filtered;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_kernels::vector::{Cells, Field, LANES, Lanes, Pairs, Shade, Stage, StepOptics, central_differences};

pub(crate) use filtered::{FilteredField, FilteredStage, can_sample};

/// Kinds of steps in which fields of a type are marched. No march in another kind is compiled for the type.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepKinds {
    /// Steps of one length, with one sample each.
    pub(crate) has_lattice: bool,
    /// Steps that the data of a grid determine, and integrals over steps.
    pub(crate) has_grid_steps: bool,
    /// Steps listed for each ray, of fields that jump.
    pub(crate) has_lists: bool,
}

impl StepKinds {
    /// Steps through grids.
    pub(crate) const OF_GRIDS: Self = Self { has_lattice: true, has_grid_steps: true, has_lists: false };
    /// Steps through scattered points, whose means jump.
    pub(crate) const OF_POINTS: Self = Self { has_lattice: true, has_grid_steps: false, has_lists: true };
    /// Listed steps alone.
    pub(crate) const LISTED: Self = Self { has_lattice: false, has_grid_steps: false, has_lists: true };
}

/// Field that packets march through, as sixteen samples see it.
pub(crate) trait PacketField {
    /// Buffer of voxels between their fetch and their use: a wide load from narrow stores takes its time, which the fetch of the next step hides.
    type Stage: Default;

    /// Steps in which fields of this kind are marched.
    const STEPS: StepKinds = StepKinds::OF_GRIDS;

    /// True if places have colours that multiply their light.
    #[inline(always)]
    fn has_colors(&self) -> bool {
        false
    }

    /// Sets the kinds of the steps whose places are fetched next, where lists of steps have kinds.
    #[inline(always)]
    fn set_kinds(&self, _: &mut Self::Stage, _: &[u16; LANES]) {}

    /// Fetches what the values at places need.
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Self::Stage);

    /// Returns the values at places that were fetched last.
    fn value<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Self::Stage) -> f32x16<S>;

    /// Returns the light of places that were fetched last; those without a field, which no cells tell, are clear.
    #[inline(always)]
    fn outside_vacuum<S: Simd>(&self, _: S, light: [f32x16<S>; 4], _: &Self::Stage) -> [f32x16<S>; 4] {
        light
    }

    /// Returns the lanes, among some, whose places (fetched last) have a field; lattices of cells tell that elsewhere.
    #[inline(always)]
    fn has_field<S: Simd>(&self, _: S, lanes: mask32x16<S>, _: &Self::Stage) -> mask32x16<S> {
        lanes
    }

    /// Returns the gradients at places, per index step, and how they change over steps of an extent, where they are followed: `at` and `step` are those of
    /// [`central_differences`]; `stage` is used up.
    fn gradients<S: Simd>(
        &self,
        simd: S,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        stage: &mut Self::Stage,
    ) -> [[Lanes; 3]; 2];

    /// Changes the light of steps by the colours of places and, where the scene is shaded, by the gradients at them: opacity first, where there are `optics`
    /// to make it anew from, and then what is reflected. `at` and `step` are those of [`Shade::apply`]; `stage` is used up.
    #[expect(clippy::too_many_arguments, reason = "what `Shade::apply` takes")]
    fn look<S: Simd>(
        &self,
        simd: S,
        shade: Option<Shade<'_>>,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        optics: Option<&StepOptics>,
        light: &mut [Lanes; 4],
        stage: &mut Self::Stage,
    );
}

/// Returns cells and fractions that are kept as lanes.
#[inline(always)]
pub(super) fn cells_of<S: Simd>(simd: S, [cell, fraction]: &[[Lanes; 3]; 2]) -> Cells<S> {
    Cells {
        cell: [
            cell[0].load(simd).to_int::<i32x16<S>>(),
            cell[1].load(simd).to_int::<i32x16<S>>(),
            cell[2].load(simd).to_int::<i32x16<S>>(),
        ],
        fraction: [fraction[0].load(simd), fraction[1].load(simd), fraction[2].load(simd)],
    }
}

impl<T: Pairs> PacketField for Field<'_, T> {
    type Stage = Stage<T>;

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Stage<T>) {
        Self::fetch(self, simd, at, stage);
    }

    #[inline(always)]
    fn value<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Stage<T>) -> f32x16<S> {
        Self::value(self, simd, at, stage)
    }

    #[inline(always)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        at: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        stage: &mut Stage<T>,
    ) -> [[Lanes; 3]; 2] {
        central_differences(simd, self, at, step, stage)
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
        stage: &mut Stage<T>,
    ) {
        let Some(shade) = shade else { return };
        match optics {
            Some(optics) => shade.apply_modulated(simd, self, at, step, optics, light, stage),
            None => shade.apply(simd, self, at, step, light, stage),
        }
    }
}

#[cfg(test)]
mod tests;
