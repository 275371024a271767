//! Blocks in which nothing can be seen, and how far a ray leaps over them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::RangeBlocks;
use vr_core::transfer::BakedTransfer;

use super::field::Cells;
use super::lanes::{LANES, pick, splat};
use super::setup::Packet;

/// Per block the chessboard distance, in blocks, to the nearest one in which something is visible: 0 in that one.
///
/// All blocks nearer than that are invisible, so a ray in the middle of them moves on freely: a proximity cloud (Cohen & Sheffer
/// 1994, "Proximity clouds, an acceleration technique for 3D grid traversal").
#[derive(Clone, Debug)]
pub(crate) struct Distances {
    shift: u32,
    blocks: [usize; 3],
    distance: Vec<u8>,
}

/// Visibility of table entries, summed up: a range is asked for with two look-ups.
struct Visible {
    /// Visible entries before each one.
    before: Vec<u32>,
    origin: f32,
    per_unit: f32,
}

impl Visible {
    fn new(table: &BakedTransfer<f32>) -> Self {
        let mut before = vec![0];
        for entry in table.entries() {
            let visible = entry.iter().any(|&x| x != 0.0);
            before.push(before[before.len() - 1] + u32::from(visible));
        }
        Self { before, origin: table.origin(), per_unit: table.per_unit() }
    }

    /// Whether the table shows anything for any number in the range, as it rounds and interpolates.
    fn any(&self, low: f32, high: f32) -> bool {
        let last = self.before.len() - 2;
        let index = |stored: f32| ((stored - self.origin) * self.per_unit).max(0.0);
        // One entry more on both sides: a sample may lie an ulp outside the range of its corners.
        let from = (index(low) - 0.01).max(0.0) as usize;
        let to = (index(high) + 1.01) as usize + 1;
        self.before[to.min(last) + 1] > self.before[from.min(last)]
    }
}

impl Distances {
    /// Of the blocks of a volume under a table; `None` where no block is invisible, so that there is nothing to leap over.
    ///
    /// # Panics
    /// If the blocks' edge is not a power of two.
    pub(crate) fn new(ranges: &RangeBlocks, table: &BakedTransfer<f32>) -> Option<Self> {
        assert!(ranges.edge().is_power_of_two(), "blocks are found by shifting");
        let visible = Visible::new(table);
        let of = |r: &vr_core::BlockRange| if visible.any(r.low, r.high) { 0 } else { u8::MAX };
        let distance: Vec<u8> = ranges.ranges().iter().map(of).collect();
        if distance.iter().all(|&d| d == 0) {
            return None;
        }
        let mut all = Self { shift: ranges.edge().trailing_zeros(), blocks: ranges.blocks(), distance };
        all.spread();
        Some(all)
    }

    /// Two sweeps over rows, each from the rows before it (Borgefors 1986, "Distance transformations in digital images"): exact for
    /// the chessboard distance.
    fn spread(&mut self) {
        let [nx, ny, nz] = self.blocks;
        let mut near = vec![u8::MAX; nx];
        for backwards in [false, true] {
            for row in 0..ny * nz {
                let row = if backwards { ny * nz - 1 - row } else { row };
                let (y, z) = (row % ny, row / ny);
                near.fill(u8::MAX);
                // The rows that the sweep has been at: three of the slice before, one of this one.
                let done = |y: usize, z: usize| (z * ny + y) * nx;
                let slice = if backwards { (z + 1 < nz).then_some(z + 1) } else { z.checked_sub(1) };
                let beside = if backwards { (y + 1 < ny).then_some(y + 1) } else { y.checked_sub(1) };
                let of_slice = (y.saturating_sub(1)..=(y + 1).min(ny - 1)).filter_map(|y| slice.map(|z| done(y, z)));
                for first in of_slice.chain(beside.map(|y| done(y, z))) {
                    for (n, &d) in near.iter_mut().zip(&self.distance[first..first + nx]) {
                        *n = d.min(*n);
                    }
                }
                let here = &mut self.distance[done(y, z)..][..nx];
                for x in 0..nx {
                    let around = near[x.saturating_sub(1)].min(near[x]).min(near[(x + 1).min(nx - 1)]);
                    here[x] = here[x].min(around.saturating_add(1));
                }
                for i in 1..nx {
                    let (from, to) = if backwards { (nx - i, nx - 1 - i) } else { (i - 1, i) };
                    here[to] = here[to].min(here[from].saturating_add(1));
                }
            }
        }
    }

    /// Bytes that it keeps.
    pub(crate) fn bytes(&self) -> usize {
        self.distance.len()
    }

    /// Distance to what is visible from the blocks of sixteen cells.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> i32x16<S> {
        let [x, y, z] = cells.cell;
        let (nx, ny) = (self.blocks[0] as i32, self.blocks[1] as i32);
        let shift = self.shift;
        let index = (((z >> shift) * ny + (y >> shift)) * nx + (x >> shift)).to_array();
        let mut distance = [0i32; LANES];
        for i in 0..LANES {
            distance[i] = i32::from(*self.distance.get(index[i] as u32 as usize).unwrap_or(&0));
        }
        i32x16::load_array(simd, distance)
    }
}

/// How a packet's rays leave boxes of blocks.
pub(crate) struct Leaper<S: Simd> {
    shift: u32,
    edge: f32,
    /// Steps per index unit, axis by axis; a large number where a ray is parallel.
    per_index: [f32x16<S>; 3],
    /// +1 where a ray goes up the axis, −1 where it goes down.
    sign: [f32x16<S>; 3],
    /// From the block's number to the face that the ray leaves it by, in blocks, but for the distance.
    face: [f32x16<S>; 3],
    /// Kept from the face, for positions are rounded.
    margin: f32,
}

/// Of the largest index: what positions along a ray can be off by in f32, eight times over.
const MARGIN: f32 = 1.0 / (1 << 20) as f32;

impl<S: Simd> Leaper<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, distances: &Distances, packet: &Packet, dims: [usize; 3]) -> Self {
        let one = splat(simd, 1.0);
        let delta = [packet.delta[0].load(simd), packet.delta[1].load(simd), packet.delta[2].load(simd)];
        let up = delta.map(
            #[inline(always)]
            |d| d.simd_gt(splat(simd, 0.0)),
        );
        let zero = splat(simd, 0.0);
        let (mut per_index, mut sign, mut face) = ([zero; 3], [zero; 3], [zero; 3]);
        for a in 0..3 {
            let parallel = delta[a].abs().simd_lt(splat(simd, 1e-30));
            sign[a] = pick(up[a], one, -one);
            face[a] = pick(up[a], zero, one);
            per_index[a] = pick(parallel, sign[a] * 1e30, one / pick(parallel, one, delta[a]));
        }
        let largest = dims.into_iter().max().unwrap_or(0) as f32;
        let edge = (1u32 << distances.shift) as f32;
        Self { shift: distances.shift, edge, per_index, sign, face, margin: largest * MARGIN }
    }

    /// Whole steps, at least one, from a position in an invisible block to the first that can be beyond all blocks nearer than
    /// `distance`.
    #[inline(always)]
    pub(crate) fn steps(&self, simd: S, position: [f32x16<S>; 3], cells: &Cells<S>, distance: i32x16<S>) -> f32x16<S> {
        let distance: f32x16<S> = distance.to_float();
        let mut steps = splat(simd, 1e6);
        for a in 0..3 {
            let block: f32x16<S> = (cells.cell[a] >> self.shift).to_float();
            let face = (block + self.face[a] + self.sign[a] * distance) * self.edge - self.sign[a] * self.margin;
            steps = steps.min((face - position[a]) * self.per_index[a]);
        }
        let whole: f32x16<S> = steps.max(splat(simd, 0.0)).to_int::<i32x16<S>>().to_float();
        whole + 1.0
    }
}
