//! Blocks of an adaptive mesh as patches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::amr::{AmrCentring, AmrGrid, AmrLattice, AmrSamples};
use vr_core::{IndexRay, Ray};
use vr_kernels::vector::{LANES, Lanes, Stage, Stencils, splat};

use super::lanes::{LaneSteps, PatchPlace, WorldRay};
use super::march::{Patches, Place};
use super::mesh_lattices::MeshLattices;
use super::mesh_paces::MeshPaces;
use super::steps::{Batch, Part};

/// Data of a block that lanes need: made once for a mesh.
#[derive(Clone, Debug)]
pub(crate) struct MeshBlock {
    pub(super) place: PatchPlace,
    /// First and last place of its lattice whose samples are the level's own, as far as that does not depend on the samples.
    inner: [[i32; 3]; 2],
    /// Edges of the smallest cells, in those of the block's: factors from gradients per sample to gradients of one unit.
    slope: [f32; 3],
}

impl MeshBlock {
    pub(crate) fn all_of(grid: &AmrGrid) -> Vec<Self> {
        let samples = grid.samples();
        let unit = gradient_length(grid);
        let shift = AmrLattice::border(grid.centring()) as f64;
        let of = |(number, block): (usize, &vr_core::amr::AmrBlock)| {
            let spacing = grid.spacing_of(block.level);
            Self {
                place: PatchPlace { origin: samples.first_place(number), rate: spacing.recip(), shift },
                inner: match grid.centring() {
                    AmrCentring::Points => samples.inner(number),
                    AmrCentring::Cells => [[0; 3], block.dims.map(|n| n as i32)],
                },
                slope: (unit / spacing).as_vec3().to_array(),
            }
        };
        grid.blocks().iter().enumerate().map(of).collect()
    }
}

/// World length that gradients are counted in.
pub(super) fn gradient_length(grid: &AmrGrid) -> f64 {
    grid.finest_spacing().min_element()
}

/// Adaptive mesh, and the pace of rays in it.
#[derive(Clone, Copy)]
pub(crate) struct MeshPatches<'a> {
    pub(crate) grid: &'a AmrGrid,
    pub(crate) samples: AmrSamples<'a>,
    pub(crate) lattices: &'a MeshLattices,
    pub(crate) blocks: &'a [MeshBlock],
    pub(crate) paces: &'a MeshPaces,
    pub(crate) unit: f64,
}

/// Blocks that sixteen lanes are in.
pub(crate) struct MeshLanes<'a> {
    pub(super) number: [usize; LANES],
    /// Samples of their lattices.
    pub(super) values: [&'a [f32]; LANES],
    /// Last place of each lattice that has samples behind it.
    last: [[i32; LANES]; 3],
    /// Samples that gradients are made of; `None` where they are asked for one by one.
    pub(super) differences: [Option<&'a AmrLattice>; LANES],
    /// First and last place whose samples are the level's own, where values do not tell it: between points.
    pub(super) inner: [[[i32; 3]; 2]; LANES],
    /// Samples from one y to the next, and from one z.
    pub(super) strides: [[i32; LANES]; 2],
    slope: [Lanes; 3],
}

impl<'a> Patches for MeshPatches<'a> {
    type Lanes = MeshLanes<'a>;
    type Around = Stencils;

    fn nowhere(&self) -> MeshLanes<'a> {
        MeshLanes {
            number: [0; LANES],
            values: [&[0.0; 2]; LANES],
            last: [[0; LANES]; 3],
            differences: [None; LANES],
            inner: [[[0; 3]; 2]; LANES],
            strides: [[0; LANES]; 2],
            slope: [Lanes::ZERO; 3],
        }
    }

    fn parts(&self, ray: Ray, part: IndexRay) -> impl Iterator<Item = Part> {
        let (paces, offset) = (self.paces, part.offset);
        let parts = self.grid.parts_along(&ray, [part.start + offset, part.end + offset]).by_blocks(&paces.whole);
        let parts = parts.map(move |found| {
            let (step, is_seen) = match found.brick {
                Some(brick) => paces.of_bricks[brick],
                None => paces.of_blocks[found.block],
            };
            Part { from: found.from - offset, to: found.to - offset, patch: found.block, step, is_seen }
        });
        joined(parts)
    }

    #[inline]
    fn enter(&self, within: &mut MeshLanes<'a>, steps: &mut LaneSteps, lane: usize, ray: &WorldRay, batch: &Batch) {
        let block = &self.blocks[batch.patch];
        steps.set(lane, ray, batch, self.unit, &block.place);
        within.number[lane] = batch.patch;
        // Blocks without a lattice are none that can be seen.
        let (dims, values) = self.lattices.of(self.grid, batch.patch).unwrap_or(([2, 1, 1], &[f32::NAN; 2]));
        within.values[lane] = values;
        within.differences[lane] = self.lattices.differences(batch.patch);
        within.inner[lane] = block.inner;
        for a in 0..3 {
            within.last[a][lane] = dims[a] as i32 - 2;
            within.slope[a].0[lane] = block.slope[a];
        }
        within.strides[0][lane] = dims[0] as i32;
        within.strides[1][lane] = (dims[0] * dims[1]) as i32;
    }

    #[inline(always)]
    fn fetch<S: Simd>(
        &self,
        simd: S,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: f32x16<S>,
        _: u32,
        stage: &mut Stage<f32>,
    ) -> Place<S> {
        let place = place(simd, within, steps, number);
        let [x, y, z] = place.low;
        let [row, layer] = [i32x16::load_array(simd, within.strides[0]), i32x16::load_array(simd, within.strides[1])];
        let first = z * layer + y * row + x;
        let offsets =
            [first.to_array(), (first + row).to_array(), (first + layer).to_array(), (first + layer + row).to_array()];
        for lane in 0..LANES {
            let values = within.values[lane];
            // A slice of two: one check, where two indices take two.
            let pair = |row: usize| -> [f32; 2] {
                let at = offsets[row][lane] as u32 as usize;
                std::array::from_fn(|i| values[at..at + 2][i])
            };
            stage.put(lane, [pair(0), pair(1), pair(2), pair(3)]);
        }
        place
    }

    #[inline(always)]
    fn complete<S: Simd>(
        &self,
        simd: S,
        within: &MeshLanes<'a>,
        steps: &LaneSteps,
        number: f32x16<S>,
        place: &Place<S>,
        live: u32,
        value: f32x16<S>,
    ) -> f32x16<S> {
        let is_known = value.abs().simd_le(splat(simd, f32::MAX));
        let lanes = live & !(is_known.to_bitmask() as u32);
        if lanes == 0 {
            return value;
        }
        let low = [place.low[0].to_array(), place.low[1].to_array(), place.low[2].to_array()];
        let fraction = [place.fraction[0].to_array(), place.fraction[1].to_array(), place.fraction[2].to_array()];
        let mut value = Lanes::new(value);
        self.complete_at_rim(within, steps, &number.to_array(), (&low, &fraction), lanes, &mut value);
        value.load(simd)
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
            let fraction = [place.fraction[0].to_array(), place.fraction[1].to_array(), place.fraction[2].to_array()];
            self.rim_gradients(within, steps, &number.to_array(), (&low, &fraction), rims, &mut gradient);
        }
        gradient
    }
}

/// Parts that touch made one, where they are in one patch and alike.
fn joined(parts: impl Iterator<Item = Part>) -> impl Iterator<Item = Part> {
    let mut parts = parts.peekable();
    std::iter::from_fn(move || {
        let mut part = parts.next()?;
        let goes_on = |next: &Part, part: &Part| {
            next.from == part.to && (next.patch, next.step, next.is_seen) == (part.patch, part.step, part.is_seen)
        };
        while let Some(next) = parts.next_if(|next| goes_on(next, &part)) {
            part.to = next.to;
        }
        Some(part)
    })
}

/// Places of the lanes' samples.
#[inline(always)]
fn place<S: Simd>(simd: S, within: &MeshLanes<'_>, steps: &LaneSteps, number: f32x16<S>) -> Place<S> {
    let zero = i32x16::splat(simd, 0);
    let at = [
        steps.base[0].load(simd) + number * steps.delta[0].load(simd),
        steps.base[1].load(simd) + number * steps.delta[1].load(simd),
        steps.base[2].load(simd) + number * steps.delta[2].load(simd),
    ];
    let low: [i32x16<S>; 3] = [
        at[0].to_int::<i32x16<S>>().max(zero).min(i32x16::load_array(simd, within.last[0])),
        at[1].to_int::<i32x16<S>>().max(zero).min(i32x16::load_array(simd, within.last[1])),
        at[2].to_int::<i32x16<S>>().max(zero).min(i32x16::load_array(simd, within.last[2])),
    ];
    let fraction = [
        at[0] - low[0].to_float::<f32x16<S>>(),
        at[1] - low[1].to_float::<f32x16<S>>(),
        at[2] - low[2].to_float::<f32x16<S>>(),
    ];
    Place { low, fraction }
}
