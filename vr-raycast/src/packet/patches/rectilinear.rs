//! Boxes of a rectilinear grid as patches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::rectilinear::{Axis, RectilinearGrid};
use vr_core::{IndexRay, Ray};
use vr_kernels::vector::{Cells, Field, LANES, Lanes, Stage, splat};

use super::axis_table::AxisTable;
use super::lanes::{LaneSteps, PatchPlace, WorldRay};
use super::march::{Patches, Place};
use super::merged::Merged;
use super::rectilinear_paces::RectilinearPaces;
use super::steps::{Batch, Part};

/// Rectilinear grid, whose patches are boxes of one reach of each axis, and the pace of rays in it.
#[derive(Clone, Copy)]
pub(crate) struct RectilinearPatches<'a> {
    grid: &'a RectilinearGrid,
    field: Field<'a, f32>,
    tables: &'a [AxisTable; 3],
    paces: &'a RectilinearPaces,
    /// Unit of lengths of steps.
    unit: f64,
}

/// Reaches that sixteen lanes are in: for each axis ...
pub(crate) struct ReachLanes {
    /// the number of the first cell,
    first: [[i32; LANES]; 3],
    /// that of the first bin in the table,
    start: [[i32; LANES]; 3],
    /// the number of bins,
    bins: [Lanes; 3],
    /// and a mask of the lanes whose reaches are uneven.
    uneven: [u32; 3],
}

/// Bits of a patch's number for each axis.
const BITS: u32 = usize::BITS / 3;

impl<'a> RectilinearPatches<'a> {
    pub(crate) fn new(
        grid: &'a RectilinearGrid,
        tables: &'a [AxisTable; 3],
        paces: &'a RectilinearPaces,
        unit: f64,
    ) -> Self {
        let field = Field::new(&Lattice { samples: grid.stored(), dims: grid.dims() });
        Self { grid, field, tables, paces, unit }
    }

    /// True if packets can number the samples of a grid, and its patches.
    pub(crate) fn can_number(grid: &RectilinearGrid) -> bool {
        let is_few = |axis: usize| grid.bricks().segments(axis).len() < 1 << BITS;
        grid.dims().iter().product::<usize>() <= i32::MAX as usize && (0..3).all(is_few)
    }

    /// Makes the tables of a grid's axes, or returns those that are kept with it.
    pub(crate) fn tables(grid: &RectilinearGrid) -> std::sync::Arc<[AxisTable; 3]> {
        let is_analytic = grid.gradient_method() == vr_core::GradientMethod::Analytic;
        grid.derived().get(is_analytic, || AxisTable::all_of(grid, Self::gradient_length(grid)))
    }

    /// World length that gradients are counted in.
    pub(crate) fn gradient_length(grid: &RectilinearGrid) -> f64 {
        grid.axes().iter().map(Axis::smallest_step).fold(f64::INFINITY, f64::min)
    }
}

impl Patches for RectilinearPatches<'_> {
    type Lanes = ReachLanes;
    type Around = Stage<f32>;

    fn nowhere(&self) -> ReachLanes {
        ReachLanes {
            first: [[0; LANES]; 3],
            start: [[0; LANES]; 3],
            // Bins are numbered from 0.
            bins: [Lanes([1.0; LANES]); 3],
            uneven: [0; 3],
        }
    }

    fn parts(&self, ray: Ray, part: IndexRay) -> impl Iterator<Item = Part> {
        let origin = ray.origin + ray.direction * part.offset;
        let parts = self.grid.parts_along(origin, ray.direction, [part.start, part.end]);
        let paces = self.paces;
        Merged::new(parts.map(|found| {
            let (step, is_seen) = paces.of(found.brick, found.spacing);
            let [x, y, z] = [0, 1, 2].map(|a| self.tables[a].reach_of(found.segments[a]));
            Part { from: found.from, to: found.to, patch: x | y << BITS | z << (2 * BITS), step, is_seen }
        }))
    }

    #[inline]
    fn enter(&self, within: &mut ReachLanes, steps: &mut LaneSteps, lane: usize, ray: &WorldRay, batch: &Batch) {
        let mut place = PatchPlace { origin: DVec3::ZERO, rate: DVec3::ZERO, shift: 0.0 };
        for a in 0..3 {
            let number = batch.patch >> (BITS * a as u32) & ((1 << BITS) - 1);
            let reach = self.tables[a].reach(number);
            (place.origin[a], place.rate[a]) = (reach.origin, reach.rate);
            within.first[a][lane] = reach.first;
            within.start[a][lane] = reach.start;
            within.bins[a].0[lane] = reach.bins as f32;
            within.uneven[a] = within.uneven[a] & !(1 << lane) | u32::from(!reach.is_even) << lane;
        }
        steps.set(lane, ray, batch, self.unit, &place);
    }

    #[inline(always)]
    fn fetch<S: Simd>(
        &self,
        simd: S,
        within: &ReachLanes,
        steps: &LaneSteps,
        number: f32x16<S>,
        live: u32,
        stage: &mut Stage<f32>,
    ) -> Place<S> {
        let (mut low, mut fraction) = ([i32x16::splat(simd, 0); 3], [splat(simd, 0.0); 3]);
        for a in 0..3 {
            let bins = within.bins[a].load(simd);
            let mut x = (steps.base[a].load(simd) + number * steps.delta[a].load(simd)).max(splat(simd, 0.0)).min(bins);
            // Bins of even reaches are cells.
            if within.uneven[a] & live != 0 {
                let bin: i32x16<S> = x.min(bins - 1.0).to_int();
                x = self.tables[a].to_cells(simd, x, bin + i32x16::load_array(simd, within.start[a]));
            }
            let first = i32x16::load_array(simd, within.first[a]);
            let cell = (x.to_int::<i32x16<S>>() + first).min(i32x16::splat(simd, self.field.last_cell[a]));
            fraction[a] = x - (cell - first).to_float::<f32x16<S>>();
            low[a] = cell;
        }
        let cells = Cells { cell: low, fraction };
        self.field.fetch(simd, &cells, stage);
        Place { low, fraction }
    }

    #[inline(always)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        _: &ReachLanes,
        _: &LaneSteps,
        _: f32x16<S>,
        place: &Place<S>,
        _: u32,
        stage: &mut Stage<f32>,
    ) -> [Lanes; 3] {
        let cell = [&place.low[0], &place.low[1], &place.low[2]].map(|low| low.to_array());
        let fraction = [Lanes::new(place.fraction[0]), Lanes::new(place.fraction[1]), Lanes::new(place.fraction[2])];
        let mut gradient = [Lanes::ZERO; 3];
        self.fill_gradients(simd, &cell, &fraction, &mut gradient, stage);
        gradient
    }
}

impl RectilinearPatches<'_> {
    /// Fills gradients at places. Its own function: there are samples that need none.
    #[inline(never)]
    fn fill_gradients<S: Simd>(
        &self,
        simd: S,
        cell: &[[i32; LANES]; 3],
        fraction: &[Lanes; 3],
        gradient: &mut [Lanes; 3],
        stage: &mut Stage<f32>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let cell = [
                    i32x16::load_array(simd, cell[0]),
                    i32x16::load_array(simd, cell[1]),
                    i32x16::load_array(simd, cell[2]),
                ];
                let factors = [
                    self.tables[0].slopes_at(simd, cell[0]),
                    self.tables[1].slopes_at(simd, cell[1]),
                    self.tables[2].slopes_at(simd, cell[2]),
                ];
                let fraction = [fraction[0].load(simd), fraction[1].load(simd), fraction[2].load(simd)];
                let [x, y, z] = self.field.uneven_gradients(simd, &Cells { cell, fraction }, &factors, stage);
                *gradient = [Lanes::new(x), Lanes::new(y), Lanes::new(z)];
            },
        );
    }
}
