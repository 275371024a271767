//! Leaps of rays over blocks in which nothing can be seen.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_kernels::vector::{Cells, LANES, pick, splat};

use super::setup::Packet;
use crate::leap::ClearSpace;

impl ClearSpace {
    /// Returns the codes of the blocks of sixteen cells; [`Self::CLEAR_CELL`] for clear cells of blocks with visible ones, and 0 for the visible cells of these.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> i32x16<S> {
        let (blocks, masks) = self.codes();
        let [x, y, z] = cells.cell;
        let index = block_index(cells, self.shift(), self.blocks());
        let bit = (((z & 3) << 4) | ((y & 3) << 2) | (x & 3)).to_array();
        let mut codes = [0; LANES];
        for i in 0..LANES {
            let index = index[i] as u32 as usize;
            if index < blocks.len() {
                codes[i] = i32::from(blocks[index]) + (masks[index] >> bit[i] & 1) as i32 * Self::CLEAR_CELL;
            }
        }
        i32x16::load_array(simd, codes)
    }
}

/// Returns the index of the block of `1 << shift` cells that each cell lies in.
#[inline(always)]
pub(crate) fn block_index<S: Simd>(cells: &Cells<S>, shift: u32, blocks: [usize; 3]) -> [i32; LANES] {
    let [x, y, z] = cells.cell;
    let (nx, ny) = (blocks[0] as i32, blocks[1] as i32);
    (((z >> shift) * ny + (y >> shift)) * nx + (x >> shift)).to_array()
}

/// Solver for the points at which a packet's rays leave boxes of blocks.
pub(crate) struct Leaper<S: Simd> {
    shift: u32,
    edge: f32,
    /// Steps per index unit, axis by axis; a large number where a ray is parallel.
    per_index: [f32x16<S>; 3],
    /// Direction along each axis: +1 where a ray goes up, −1 where it goes down.
    sign: [f32x16<S>; 3],
    /// Offset, in blocks, from the number of a block to the face behind the one by which the ray leaves it, against its direction; a block further off where
    /// the ray is parallel, which may lie in a face for all of its length.
    face: [f32x16<S>; 3],
    /// Margin kept from the face, since positions are rounded.
    margin: f32,
    /// Smallest number of steps that take any ray of the packet through a block along an axis.
    steps_per_block: f32,
}

/// Margin as a fraction of the largest index: eight times the error of positions along a ray in f32.
const MARGIN: f32 = 1.0 / (1 << 20) as f32;

impl<S: Simd> Leaper<S> {
    #[inline(always)]
    /// Prepares a packet for leaps out of boxes of blocks of `1 << shift` cells.
    pub(crate) fn new(simd: S, shift: u32, packet: &Packet, dims: [usize; 3]) -> Self {
        let one = splat(simd, 1.0);
        let delta = [packet.delta[0].load(simd), packet.delta[1].load(simd), packet.delta[2].load(simd)];
        let zero = splat(simd, 0.0);
        let (mut per_index, mut sign, mut face) = ([zero; 3], [zero; 3], [zero; 3]);
        for a in 0..3 {
            let up = delta[a].simd_gt(zero);
            let parallel = delta[a].abs().simd_lt(splat(simd, 1e-30));
            sign[a] = pick(up, one, -one);
            face[a] = pick(up | parallel, zero, one);
            per_index[a] = pick(parallel, sign[a] * 1e30, one / pick(parallel, one, delta[a]));
        }
        let largest = dims.into_iter().max().unwrap_or(0) as f32;
        let edge = (1u32 << shift) as f32;
        let fastest = delta[0].abs().max(delta[1].abs()).max(delta[2].abs()).to_array();
        let steps_per_block = edge / fastest.into_iter().fold(f32::MIN_POSITIVE, f32::max);
        Self { shift, edge, per_index, sign, face, margin: largest * MARGIN, steps_per_block }
    }

    /// Prepares a packet for leaps over clear space, if there is any.
    #[inline(always)]
    pub(crate) fn over<'a>(
        simd: S,
        space: Option<&'a ClearSpace>,
        packet: &Packet,
        dims: [usize; 3],
    ) -> Option<(&'a ClearSpace, Self)> {
        let space = space?;
        Some((space, Self::new(simd, space.shift(), packet, dims)))
    }

    /// Returns the steps from a position to the point where it leaves the box of blocks nearer than `distance` to its own.
    #[inline(always)]
    pub(crate) fn exit(&self, simd: S, position: [f32x16<S>; 3], cells: &Cells<S>, distance: f32x16<S>) -> f32x16<S> {
        let mut steps = splat(simd, 1e6);
        for a in 0..3 {
            let block: f32x16<S> = (cells.cell[a] >> self.shift).to_float();
            let face = (block + self.face[a] + self.sign[a] * distance) * self.edge;
            steps = steps.min((face - position[a]) * self.per_index[a]);
        }
        steps.max(splat(simd, 0.0))
    }

    /// Returns the steps from a position to the point where it leaves its node of so many cells an edge, a power of two.
    #[cfg(feature = "classics")]
    #[inline(always)]
    pub(crate) fn to_node_exit(
        &self,
        simd: S,
        position: [f32x16<S>; 3],
        cells: &Cells<S>,
        edge: f32x16<S>,
    ) -> f32x16<S> {
        let mut steps = splat(simd, 1e6);
        let per_edge = splat(simd, 1.0) / edge;
        for a in 0..3 {
            let cell: f32x16<S> = cells.cell[a].to_float();
            let face = ((cell * per_edge).floor() + self.face[a] + self.sign[a]) * edge;
            steps = steps.min((face - position[a]) * self.per_index[a]);
        }
        steps.max(splat(simd, 0.0))
    }

    /// Returns the steps from a position to the next face of a cell.
    #[inline(always)]
    pub(crate) fn to_face(&self, position: [f32x16<S>; 3], cells: &Cells<S>) -> f32x16<S> {
        let mut steps = self.ahead(0, position, cells);
        for a in 1..3 {
            steps = steps.min(self.ahead(a, position, cells));
        }
        steps
    }

    /// Returns the steps from a position to the next face of the voxel that it is nearest to.
    #[inline(always)]
    pub(crate) fn to_voxel_face(&self, simd: S, position: [f32x16<S>; 3], cells: &Cells<S>) -> f32x16<S> {
        let (zero, one, half) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, 0.5));
        let mut steps = splat(simd, 1e6);
        for a in 0..3 {
            let cell: f32x16<S> = cells.cell[a].to_float();
            let voxel = cell + pick(cells.fraction[a].simd_ge(half), one, zero);
            steps = steps.min((voxel - 0.5 + self.face[a] + self.sign[a] - position[a]) * self.per_index[a]);
        }
        steps
    }

    #[inline(always)]
    fn ahead(&self, a: usize, position: [f32x16<S>; 3], cells: &Cells<S>) -> f32x16<S> {
        let cell: f32x16<S> = cells.cell[a].to_float();
        (cell + self.face[a] + self.sign[a] - position[a]) * self.per_index[a]
    }

    /// Returns the number of whole steps, at least one, to the first that can be beyond the box of blocks nearer than a distance, or beyond the cell where that is
    /// [`ClearSpace::CLEAR_CELL`].
    #[inline(always)]
    pub(crate) fn steps(&self, simd: S, position: [f32x16<S>; 3], cells: &Cells<S>, distance: i32x16<S>) -> f32x16<S> {
        let (one, edge) = (splat(simd, 1.0), splat(simd, self.edge));
        let is_cell = distance.simd_lt(0);
        let reach = pick(is_cell, one, distance.to_float::<f32x16<S>>() * edge);
        let edge = pick(is_cell, one, edge);
        let corner_bits = is_cell.select(i32x16::splat(simd, -1), i32x16::splat(simd, -(1 << self.shift)));
        let mut steps = splat(simd, 1e6);
        for a in 0..3 {
            let corner: f32x16<S> = (cells.cell[a] & corner_bits).to_float();
            let face = corner + self.face[a] * edge + self.sign[a] * reach;
            let kept = position[a] + self.sign[a] * self.margin;
            steps = steps.min((face - kept) * self.per_index[a]);
        }
        let whole: f32x16<S> = steps.max(splat(simd, 0.0)).to_int::<i32x16<S>>().to_float();
        whole + 1.0
    }

    /// Returns a number of steps after which all `live` rays are in visible blocks still, if codes put them there.
    #[inline(always)]
    pub(crate) fn visible_steps(&self, simd: S, live: mask32x16<S>, codes: i32x16<S>) -> u32 {
        let clear = i32x16::splat(simd, ClearSpace::VISIBLE_BLOCK - i32::from(i8::MAX));
        let nearest = live.select(codes, clear).to_array().into_iter().fold(i32::MIN, i32::max);
        // Of the blocks nearer than the distance, the ray may have left its own already. The cast makes 0 of what is negative.
        ((ClearSpace::VISIBLE_BLOCK - nearest - 1) as f32 * self.steps_per_block) as u32
    }
}
