//! Blocks of an adaptive mesh as patches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::amr::{AmrGrid, AmrSamples};
use vr_core::{Field, IndexRay, Ray};
use vr_kernels::vector::{LANES, Lanes, Stage, Stencils, splat};

use super::lanes::{LaneSteps, PatchPlace, WorldRay};
use super::march::{Patches, Place};
use super::mesh_paces::MeshPaces;
use super::steps::{Batch, Part};

/// Data of a block that lanes need: made once for a mesh.
#[derive(Clone, Debug)]
pub(crate) struct MeshBlock {
    place: PatchPlace,
    /// First and last place whose samples are the block's own.
    inner: [[i32; 3]; 2],
    /// Samples from one y to the next, and from one z.
    strides: [i32; 2],
    /// Edges of the smallest cells, in those of the block's: factors from gradients per sample to gradients of one unit.
    slope: [f32; 3],
}

impl MeshBlock {
    pub(crate) fn all_of(grid: &AmrGrid) -> Vec<Self> {
        let samples = grid.samples();
        let unit = gradient_unit(grid);
        let of = |(number, block): (usize, &vr_core::amr::AmrBlock)| {
            let spacing = grid.spacing_of(block.level);
            Self {
                // One more than the place, so that cutting off the fraction rounds down.
                place: PatchPlace { origin: samples.first_place(number), rate: spacing.recip(), shift: 1.0 },
                inner: samples.inner(number),
                strides: [block.dims[0] as i32, (block.dims[0] * block.dims[1]) as i32],
                slope: (unit / spacing).as_vec3().to_array(),
            }
        };
        grid.blocks().iter().enumerate().map(of).collect()
    }
}

/// World length that gradients are counted in.
fn gradient_unit(grid: &AmrGrid) -> f64 {
    grid.finest_spacing().min_element()
}

/// Adaptive mesh, and the pace of rays in it.
#[derive(Clone, Copy)]
pub(crate) struct MeshPatches<'a> {
    pub(crate) grid: &'a AmrGrid,
    pub(crate) samples: AmrSamples<'a>,
    pub(crate) blocks: &'a [MeshBlock],
    pub(crate) paces: &'a MeshPaces,
    pub(crate) unit: f64,
}

/// Blocks that sixteen lanes are in.
pub(crate) struct MeshLanes<'a> {
    number: [usize; LANES],
    values: [&'a [f32]; LANES],
    first: [[i32; LANES]; 3],
    last: [[i32; LANES]; 3],
    strides: [[i32; LANES]; 2],
    slope: [Lanes; 3],
}

impl<'a> Patches for MeshPatches<'a> {
    type Lanes = MeshLanes<'a>;
    type Around = Stencils;

    fn nowhere(&self) -> MeshLanes<'a> {
        MeshLanes {
            number: [0; LANES],
            values: [&[]; LANES],
            first: [[0; LANES]; 3],
            last: [[0; LANES]; 3],
            strides: [[0; LANES]; 2],
            slope: [Lanes::ZERO; 3],
        }
    }

    fn parts(&self, ray: Ray, part: IndexRay) -> impl Iterator<Item = Part> {
        let (paces, offset) = (self.paces, part.offset);
        let parts = self.grid.parts_along(&ray, [part.start + offset, part.end + offset]).by_blocks(&paces.whole);
        parts.map(move |found| {
            let (step, is_seen) = match found.brick {
                Some(brick) => paces.of_bricks[brick],
                None => paces.of_blocks[found.block],
            };
            Part { from: found.from - offset, to: found.to - offset, patch: found.block, step, is_seen }
        })
    }

    #[inline]
    fn enter(&self, within: &mut MeshLanes<'a>, steps: &mut LaneSteps, lane: usize, ray: &WorldRay, batch: &Batch) {
        let block = &self.blocks[batch.patch];
        steps.set(lane, ray, batch, self.unit, &block.place);
        within.number[lane] = batch.patch;
        within.values[lane] = &self.grid.blocks()[batch.patch].values;
        for a in 0..3 {
            within.first[a][lane] = block.inner[0][a];
            within.last[a][lane] = block.inner[1][a];
            within.slope[a].0[lane] = block.slope[a];
        }
        within.strides[0][lane] = block.strides[0];
        within.strides[1][lane] = block.strides[1];
    }

    #[inline(always)]
    fn fetch<S: Simd>(
        &self,
        simd: S,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: f32x16<S>,
        live: u32,
        stage: &mut Stage<f32>,
    ) -> Place<S> {
        let place = place(simd, steps, number);
        let [x, y, z] = place.low;
        let (first, last) = (&within.first, &within.last);
        let is_inner = (x.simd_ge(i32x16::load_array(simd, first[0])) & x.simd_le(i32x16::load_array(simd, last[0])))
            & (y.simd_ge(i32x16::load_array(simd, first[1])) & y.simd_le(i32x16::load_array(simd, last[1])))
            & (z.simd_ge(i32x16::load_array(simd, first[2])) & z.simd_le(i32x16::load_array(simd, last[2])));
        let [row, layer] = [i32x16::load_array(simd, within.strides[0]), i32x16::load_array(simd, within.strides[1])];
        let offset = (z * layer + y * row + x).to_array();
        let inner = is_inner.to_bitmask() as u32 & live;
        for lane in 0..LANES {
            if inner >> lane & 1 == 1 {
                let values = &within.values[lane][offset[lane] as u32 as usize..];
                let (row, layer) = (within.strides[0][lane] as usize, within.strides[1][lane] as usize);
                // A slice of two: one check, where two indices take two.
                let pair = |at: usize| -> [f32; 2] { std::array::from_fn(|i| values[at..at + 2][i]) };
                stage.put(lane, [pair(0), pair(row), pair(layer), pair(layer + row)]);
            }
        }
        let outer = live & !inner;
        if outer != 0 {
            let low = [x.to_array(), y.to_array(), z.to_array()];
            self.gather(within, steps, &number.to_array(), &low, outer, stage);
        }
        place
    }

    #[inline(always)]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: f32x16<S>,
        place: &Place<S>,
        live: u32,
        stencils: &mut Stencils,
    ) -> [Lanes; 3] {
        let low = [place.low[0].to_array(), place.low[1].to_array(), place.low[2].to_array()];
        let rims = self.gather_stencils(within, &low, live, stencils);
        let [x, y, z] = stencils.gradients(simd, place.fraction);
        let slope = &within.slope;
        let mut gradient = [
            Lanes::new(x * slope[0].load(simd)),
            Lanes::new(y * slope[1].load(simd)),
            Lanes::new(z * slope[2].load(simd)),
        ];
        if rims != 0 {
            self.rim_gradients(steps, &number.to_array(), rims, &mut gradient);
        }
        gradient
    }
}

/// Places of the lanes' samples.
#[inline(always)]
fn place<S: Simd>(simd: S, steps: &LaneSteps, number: f32x16<S>) -> Place<S> {
    let zero = splat(simd, 0.0);
    let at = [
        (steps.base[0].load(simd) + number * steps.delta[0].load(simd)).max(zero),
        (steps.base[1].load(simd) + number * steps.delta[1].load(simd)).max(zero),
        (steps.base[2].load(simd) + number * steps.delta[2].load(simd)).max(zero),
    ];
    let whole: [i32x16<S>; 3] = [at[0].to_int(), at[1].to_int(), at[2].to_int()];
    let fraction = [
        at[0] - whole[0].to_float::<f32x16<S>>(),
        at[1] - whole[1].to_float::<f32x16<S>>(),
        at[2] - whole[2].to_float::<f32x16<S>>(),
    ];
    Place { low: [whole[0] - 1, whole[1] - 1, whole[2] - 1], fraction }
}

impl<'a> MeshPatches<'a> {
    /// Stages the samples of lanes that are not among those of their blocks alone.
    #[inline(never)]
    fn gather(
        &self,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: &[f32; LANES],
        low: &[[i32; LANES]; 3],
        lanes: u32,
        stage: &mut Stage<f32>,
    ) {
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let low = [low[0][lane], low[1][lane], low[2][lane]];
            let block = within.number[lane];
            let c = self.samples.corners(block, low).unwrap_or_else(|| {
                let at = steps.world_at(lane, number[lane]);
                let fraction = || (at - self.blocks[block].place.origin) * self.blocks[block].place.rate - low_of(low);
                let value = self.samples.value_at_rim(block, low, fraction()).or_else(|| self.grid.value(at));
                [value.map_or(f32::NAN, |value| value as f32); 8]
            });
            stage.put(lane, [[c[0], c[1]], [c[2], c[3]], [c[4], c[5]], [c[6], c[7]]]);
        }
    }

    /// Stages what gradients of lanes are made of; returns the lanes at the rim of a level, of which that does not hold.
    #[inline(never)]
    fn gather_stencils(
        &self,
        within: &MeshLanes<'a>,
        low: &[[i32; LANES]; 3],
        lanes: u32,
        stencils: &mut Stencils,
    ) -> u32 {
        let mut rims = 0;
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let low = [low[0][lane], low[1][lane], low[2][lane]];
            if !self.samples.stencil(within.number[lane], low, stencils.of_lane(lane)) {
                rims |= 1 << lane;
            }
        }
        rims
    }

    /// Fills the gradients of lanes that the field itself is asked for.
    #[inline(never)]
    fn rim_gradients(&self, steps: &LaneSteps, number: &[f32; LANES], lanes: u32, gradient: &mut [Lanes; 3]) {
        let unit = gradient_unit(self.grid);
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let found = self.grid.gradient(steps.world_at(lane, number[lane])).unwrap_or_default() * unit;
            for a in 0..3 {
                gradient[a].0[lane] = found[a] as f32;
            }
        }
    }
}

fn low_of(low: [i32; 3]) -> glam::DVec3 {
    glam::DVec3::from_array(low.map(f64::from))
}
