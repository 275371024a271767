//! Packets along their rays in steps as long as what is in each place allows.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::elementary::opacity_of_depth;
use super::field::{Cells, Field, Pairs, Stage, cells, inside};
use super::lanes::{LANES, Lanes, pick, splat};
use super::march::Marched;
use super::setup::Packet;
use super::sums::Sums;
use super::table::Rows;
use crate::pace::{CLEAR, PaceMap};

/// What all packets of a frame march through. Distances are in voxels: lengths of the smallest voxel edge.
#[derive(Clone, Copy)]
pub(crate) struct LocalMedium<'a, T> {
    pub(crate) field: Field<'a, T>,
    pub(crate) dims: [usize; 3],
    /// Emission and extinction per [`THIN`] of a voxel, as light and opacity of so thin a step.
    pub(crate) rows: Rows<'a>,
    pub(crate) map: &'a PaceMap,
    /// Voxels of the step that each byte of the map asks for; 0 for those that leap.
    pub(crate) lengths: &'a [f32; 256],
    /// A ray ends when no more than this could be added to any component.
    pub(crate) negligible: f32,
}

/// The step, in voxels, whose light and opacity are tabulated: so thin that they are emission and extinction themselves, to 10⁻⁶ where κ
/// is 2 a voxel; and yet an opaque medium has a finite κ, of 2²⁰ a voxel.
pub(crate) const THIN: f64 = 1.0 / (1 << 20) as f64;

/// Voxels by which the block at a distance is looked up further on: more than positions are rounded by, and so a ray that stands on a face
/// finds the block that it enters.
const NUDGE: f32 = 2e-3;
/// Voxels at the end of a ray that nobody misses: distances in f32 are hardly known better.
const REST: f32 = 1e-4;

/// Takes the packet's rays to their ends. The packet was set up for steps of one voxel, sampled at their begin. `most`: the largest
/// light, or opacity, that can come from behind, by what is left clear.
#[inline(always)]
pub(crate) fn local_march<S: Simd, T: Pairs>(
    simd: S,
    medium: &LocalMedium<'_, T>,
    packet: &Packet,
    most: &Lanes,
    stage: &mut Stage<T>,
) -> Marched {
    let ray = Ray::new(simd, medium, packet);
    let never = splat(simd, f32::NEG_INFINITY);
    let negligible = splat(simd, medium.negligible);
    let most = most.load(simd);
    let mut at = packet.first.load(simd);
    let mut end = packet.end.load(simd) + packet.ratio.load(simd) - REST;
    let mut sums = Sums::new(simd);
    let mut half_length = splat(simd, 0.0);
    let mut samples = 0;
    loop {
        let live = at.simd_lt(end);
        if live.all_false() {
            break;
        }
        let place = ray.place(simd, medium, at + NUDGE);
        let pace = Paces::of(simd, medium, &place.cells);
        let leaping = live & pace.byte.simd_ge(i32x16::splat(simd, i32::from(CLEAR)));
        let walking = live & !leaping;
        if leaping.any_true() {
            let out = at + NUDGE + ray.leaves(simd, &place, pace.byte - i32::from(CLEAR));
            at = pick(leaping, out, at);
            // A sample costs three looks: it waits until half of the rays want one.
            if 2 * walking.to_bitmask().count_ones() < live.to_bitmask().count_ones() {
                continue;
            }
        }
        // Of rays that do not walk, or have ended: nothing, and nothing that is not a number.
        let length = pick(walking, pace.length.min(end - at), splat(simd, 0.0));
        samples += walking.to_bitmask().count_ones();
        let middle = ray.place(simd, medium, at + length * 0.5);
        let value = medium.field.value(simd, &middle.cells, stage);
        let light = of_length(simd, medium.rows.at(simd, value), length);
        let crossing = sums.add(simd, walking, at, light);
        if crossing.any_true() {
            half_length = pick(crossing, length, half_length);
        }
        at = pick(walking, at + length, at);
        let done = (sums.clear(simd) * most).simd_le(negligible);
        end = pick(done, never, end);
    }
    let left = end.simd_gt(never);
    let hits = mask32x16::from_bitmask(simd, u64::from(packet.hits));
    let [begin, share] = sums.half(simd);
    let half = begin.load(simd) + share.load(simd) * half_length;
    Marched {
        rgba: sums.rgba().map(Lanes::of),
        first: Lanes::of(sums.first()),
        half: [Lanes::of(half), Lanes::ZERO],
        samples,
        terminated: (hits & !left).to_bitmask() as u32,
    }
}

/// Light and opacity of homogeneous steps of any length, from those of thin ones.
///
/// α = 1 − e^(−τ), and light is q·h·α/τ.
#[inline(always)]
fn of_length<S: Simd>(simd: S, thin: [f32x16<S>; 4], length: f32x16<S>) -> [f32x16<S>; 4] {
    let times = length * (1.0 / THIN) as f32;
    let tau = thin[3] * times;
    let alpha = opacity_of_depth(simd, tau);
    let nothing = tau.simd_le(splat(simd, 0.0));
    let weight = pick(nothing, splat(simd, 1.0), alpha / pick(nothing, splat(simd, 1.0), tau)) * times;
    [thin[0] * weight, thin[1] * weight, thin[2] * weight, alpha]
}

/// What the map says of sixteen places.
struct Paces<S: Simd> {
    byte: i32x16<S>,
    /// In voxels.
    length: f32x16<S>,
}

impl<S: Simd> Paces<S> {
    #[inline(always)]
    fn of<T>(simd: S, medium: &LocalMedium<'_, T>, cells: &Cells<S>) -> Self {
        const SHIFT: u32 = PaceMap::EDGE.trailing_zeros();
        let [x, y, z] = cells.cell;
        let [nx, ny, _] = medium.map.blocks();
        let (nx, ny) = (i32x16::splat(simd, nx as i32), i32x16::splat(simd, ny as i32));
        let index = (((z >> SHIFT) * ny + (y >> SHIFT)) * nx + (x >> SHIFT)).to_array();
        let bytes = medium.map.bytes();
        let (mut byte, mut length) = ([0i32; LANES], [0f32; LANES]);
        for i in 0..LANES {
            let b = bytes.get(index[i] as u32 as usize).copied().unwrap_or(0);
            byte[i] = i32::from(b);
            length[i] = medium.lengths[usize::from(b)];
        }
        Self { byte: i32x16::load_array(simd, byte), length: f32x16::load_array(simd, length) }
    }
}

/// A place on each ray.
struct Place<S: Simd> {
    position: [f32x16<S>; 3],
    cells: Cells<S>,
}

/// The rays, by voxels from the middle.
struct Ray<S: Simd> {
    base: [f32x16<S>; 3],
    delta: [f32x16<S>; 3],
    /// Voxels along the ray per index unit, axis by axis; a large number where a ray is parallel.
    per_index: [f32x16<S>; 3],
    /// +1 where a ray goes up the axis, −1 where it goes down.
    sign: [f32x16<S>; 3],
    /// 1 where a ray leaves a block by its upper face.
    upper: [f32x16<S>; 3],
    most: [f32; 3],
}

impl<S: Simd> Ray<S> {
    #[inline(always)]
    fn new<T>(simd: S, medium: &LocalMedium<'_, T>, packet: &Packet) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let delta = [packet.delta[0].load(simd), packet.delta[1].load(simd), packet.delta[2].load(simd)];
        let (mut per_index, mut sign, mut upper) = ([zero; 3], [zero; 3], [zero; 3]);
        for a in 0..3 {
            let up = delta[a].simd_ge(zero);
            let parallel = delta[a].abs().simd_lt(splat(simd, 1e-30));
            sign[a] = pick(up, one, -one);
            upper[a] = pick(up, one, zero);
            per_index[a] = pick(parallel, sign[a] * 1e30, one / pick(parallel, one, delta[a]));
        }
        Self {
            base: [packet.base[0].load(simd), packet.base[1].load(simd), packet.base[2].load(simd)],
            delta,
            per_index,
            sign,
            upper,
            most: medium.dims.map(|n| (n - 1) as f32),
        }
    }

    #[inline(always)]
    fn place<T>(&self, simd: S, medium: &LocalMedium<'_, T>, at: f32x16<S>) -> Place<S> {
        let position = [
            inside(simd, self.base[0] + at * self.delta[0], self.most[0]),
            inside(simd, self.base[1] + at * self.delta[1], self.most[1]),
            inside(simd, self.base[2] + at * self.delta[2], self.most[2]),
        ];
        Place { position, cells: cells(simd, position, medium.field.last_cell) }
    }

    /// How far it is, from a place, to where the ray leaves the cube of blocks up to `radius` around.
    #[inline(always)]
    fn leaves(&self, simd: S, place: &Place<S>, radius: i32x16<S>) -> f32x16<S> {
        const SHIFT: u32 = PaceMap::EDGE.trailing_zeros();
        let radius: f32x16<S> = radius.to_float();
        let mut voxels = splat(simd, 1e9);
        for a in 0..3 {
            let block: f32x16<S> = (place.cells.cell[a] >> SHIFT).to_float();
            let face = (block + self.upper[a] + self.sign[a] * radius) * PaceMap::EDGE as f32;
            voxels = voxels.min((face - place.position[a]) * self.per_index[a]);
        }
        voxels.max(splat(simd, 0.0))
    }
}
