//! Leaps of rays over blocks in which nothing can be seen.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use rayon::prelude::*;
use vr_kernels::ranges::{BlockRange, LevelRanges, RangeBlocks};
use vr_kernels::vector::{Cells, LANES, pick, splat};

use super::setup::Packet;
use crate::leap::{Visibility, VisibleBlocks, chessboard_distances};
use crate::step_map::{CLEAR, StepMap};

/// Chessboard distance of each block, in blocks, to the nearest one in which something is visible: 0 in that one.
///
/// All blocks nearer than that are invisible, so a ray in the middle of them moves on freely: a proximity cloud (Cohen & Sheffer
/// 1994, "Proximity clouds, an acceleration technique for 3D grid traversal").
#[derive(Clone, Debug)]
pub(crate) struct Distances {
    pub(crate) shift: u32,
    blocks: [usize; 3],
    distance: Vec<u8>,
}

impl Distances {
    /// Finds the distances for the blocks of a volume; `None` where none is invisible, so that there is nothing to leap over.
    ///
    /// # Panics
    /// Panics if the blocks' edge is not a power of two.
    pub(crate) fn new(ranges: &RangeBlocks, visibility: &Visibility<f32>) -> Option<Self> {
        let of = |range: &BlockRange| if visibility.shows_block(range) { 0 } else { u8::MAX };
        let distance = ranges.ranges().par_iter().with_min_len(1 << 12).map(of).collect();
        Self::spread(ranges.edge(), ranges.blocks(), distance)
    }

    /// Finds the distances from ranges in bytes, which must be exact: each possible range is tested once, for a table.
    pub(crate) fn of_levels(levels: &LevelRanges, visibility: &Visibility<f32>) -> Option<Self> {
        const N: usize = LevelRanges::LAST as usize + 1;
        let mut table = vec![u8::MAX; N * N];
        for low in 0..=LevelRanges::LAST {
            for high in low..=LevelRanges::LAST {
                let bounds = levels.bounds([low, high]);
                if visibility.shows(bounds.0, bounds.1) {
                    table[usize::from(low) * N + usize::from(high)] = 0;
                }
            }
        }
        let of = |&[low, high]: &[u8; 2]| table[usize::from(low) * N + usize::from(high)];
        let distance = levels.ranges().par_iter().with_min_len(1 << 12).map(of).collect();
        Self::spread(LevelRanges::EDGE, levels.blocks(), distance)
    }

    /// Takes the distances from a map of steps, which knows them.
    pub(crate) fn of_steps(map: &StepMap) -> Option<Self> {
        let of = |&byte: &u8| if byte < CLEAR { 0 } else { byte - CLEAR + 1 };
        let distance: Vec<u8> = map.bytes().iter().map(of).collect();
        let leaps = distance.iter().any(|&d| d > 0);
        leaps.then(|| Self { shift: StepMap::EDGE.trailing_zeros(), blocks: map.blocks(), distance })
    }

    /// Makes the distances of blocks that are 0 where something is visible, and 255 elsewhere.
    fn spread(edge: usize, blocks: [usize; 3], mut distance: Vec<u8>) -> Option<Self> {
        assert!(edge.is_power_of_two(), "blocks are found by shifting");
        if distance.iter().all(|&d| d == 0) {
            return None;
        }
        chessboard_distances(blocks, &mut distance);
        Some(Self { shift: edge.trailing_zeros(), blocks, distance })
    }

    /// Returns the visible blocks, of twice the edge, of a volume with the given voxels along x, y, z.
    pub(crate) fn visible(&self, dims: [usize; 3]) -> VisibleBlocks {
        VisibleBlocks::of_halves(dims, 1 << self.shift, &self.distance, 1)
    }

    /// Returns the distances of the blocks of sixteen cells.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> i32x16<S> {
        let index = block_index(cells, self.shift, self.blocks);
        let mut distance = [0i32; LANES];
        for i in 0..LANES {
            distance[i] = i32::from(*self.distance.get(index[i] as u32 as usize).unwrap_or(&0));
        }
        i32x16::load_array(simd, distance)
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
        Self { shift, edge, per_index, sign, face, margin: largest * MARGIN }
    }

    /// Prepares a packet for leaps by distances, if there are any.
    #[inline(always)]
    pub(crate) fn over<'a>(
        simd: S,
        distances: Option<&'a Distances>,
        packet: &Packet,
        dims: [usize; 3],
    ) -> Option<(&'a Distances, Self)> {
        let distances = distances?;
        Some((distances, Self::new(simd, distances.shift, packet, dims)))
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

    /// Returns the number of whole steps, at least one, to the first that can be beyond that box.
    #[inline(always)]
    pub(crate) fn steps(&self, simd: S, position: [f32x16<S>; 3], cells: &Cells<S>, distance: i32x16<S>) -> f32x16<S> {
        let kept = [
            position[0] + self.sign[0] * self.margin,
            position[1] + self.sign[1] * self.margin,
            position[2] + self.sign[2] * self.margin,
        ];
        let whole: f32x16<S> = self.exit(simd, kept, cells, distance.to_float()).to_int::<i32x16<S>>().to_float();
        whole + 1.0
    }
}
