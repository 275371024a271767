//! A grid with labels at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::DVec3;
use vr_core::labels::LabelledGrid;
use vr_kernels::vector::{Cells, LANES, Lanes, Shade, StepOptics, splat};

use super::bands::Bands;
use crate::packet::fields::{FilteredField, FilteredStage, PacketField, StepKinds};

/// Grid with labels: its values are places in the table of all bands.
#[derive(Clone, Copy)]
pub(super) struct LabelField<'a> {
    pub(super) grid: FilteredField<'a>,
    pub(super) labelled: &'a LabelledGrid,
    pub(super) bands: &'a Bands,
}

/// Stage of a [`LabelField`].
pub(super) struct LabelStage {
    grid: FilteredStage,
    /// Bands of the lanes.
    bands: [u16; LANES],
    /// Their places, as of [`TablePlaces`](vr_kernels::vector::TablePlaces).
    origin: Lanes,
    per_unit: Lanes,
    first: Lanes,
    last: Lanes,
}

impl Default for LabelStage {
    fn default() -> Self {
        Self {
            grid: FilteredStage::default(),
            // None has been set.
            bands: [u16::MAX; LANES],
            origin: Lanes::ZERO,
            per_unit: Lanes::ZERO,
            first: Lanes::ZERO,
            last: Lanes::ZERO,
        }
    }
}

impl LabelField<'_> {
    /// Gradients at places, in solid styles those of the given lanes alone.
    #[inline(always)]
    fn gradients_of<S: Simd>(
        &self,
        simd: S,
        lanes: u32,
        place: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        stage: &mut LabelStage,
    ) -> [[Lanes; 3]; 2] {
        let mut gradients = self.grid.gradients(simd, place, step, &mut stage.grid);
        self.set_solid_gradients((&stage.bands, lanes), place, &mut gradients);
        gradients
    }

    /// Sets the gradients of lanes in solid styles, per index step of the grid and in its stored numbers. They are not followed over a step.
    #[inline(never)]
    fn set_solid_gradients(
        &self,
        (bands, lanes): (&[u16; LANES], u32),
        place: &[[Lanes; 3]; 2],
        gradients: &mut [[Lanes; 3]; 2],
    ) {
        let (placement, slope) = (self.labelled.volume().placement(), self.labelled.volume().calibration().slope);
        let to_index = placement.axes().transpose();
        for lane in (0..LANES).filter(|&lane| lanes >> lane & 1 == 1 && self.bands.is_solid(bands[lane])) {
            let index = std::array::from_fn(|a| f64::from(place[0][a].0[lane]) + f64::from(place[1][a].0[lane]));
            let code = self.bands.codes[usize::from(bands[lane])];
            let world = self.labelled.region_gradient_at(placement.to_world(DVec3::from_array(index)), code);
            let stored = to_index * world / slope;
            for a in 0..3 {
                gradients[0][a].0[lane] = stored[a] as f32;
                gradients[1][a].0[lane] = 0.0;
            }
        }
    }
}

impl PacketField for LabelField<'_> {
    type Stage = LabelStage;
    const STEPS: StepKinds = StepKinds::LISTED;

    #[inline(always)]
    fn set_kinds(&self, stage: &mut LabelStage, kinds: &[u16; LANES]) {
        for lane in 0..LANES {
            if stage.bands[lane] == kinds[lane] {
                continue;
            }
            let places = &self.bands.places[usize::from(kinds[lane])];
            stage.bands[lane] = kinds[lane];
            stage.origin.0[lane] = places.origin;
            stage.per_unit.0[lane] = places.per_unit;
            stage.first.0[lane] = places.first;
            stage.last.0[lane] = places.last;
        }
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut LabelStage) {
        self.grid.fetch(simd, at, &mut stage.grid);
    }

    #[inline(always)]
    fn value<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &LabelStage) -> f32x16<S> {
        let number = self.grid.value(simd, at, &stage.grid);
        let place = (number - stage.origin.load(simd)) * stage.per_unit.load(simd);
        place.max(splat(simd, 0.0)).min(stage.last.load(simd)) + stage.first.load(simd)
    }

    #[inline(always)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        place: &[[Lanes; 3]; 2],
        step: &[Lanes; 3],
        stage: &mut LabelStage,
    ) -> [[Lanes; 3]; 2] {
        self.gradients_of(simd, u32::MAX, place, step, stage)
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
        stage: &mut LabelStage,
    ) {
        let Some(shade) = shade else { return };
        simd.vectorize(
            #[inline(always)]
            || {
                // A region's gradient costs as much as many samples, and a clear sample reflects nothing.
                let seen = light[3].load(simd).simd_gt(splat(simd, 0.0)).to_bitmask() as u32;
                let gradients = self.gradients_of(simd, seen, place, step, stage);
                shade.apply_by(simd, &gradients, optics, light, |_| ());
            },
        );
    }
}
