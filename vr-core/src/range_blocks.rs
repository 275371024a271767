//! Ranges of the reconstructed field, block by block: for all who leap, cull or skip.

use rayon::prelude::*;

use crate::filter::{Filter, Reconstruction};
use crate::sampler::Sampler;
use crate::volume::{SamplerVisitor, UniformVolume};
use crate::voxel::Voxel;

/// Smallest and largest value of the field in each block of `edge`³ cells, in stored units.
///
/// The ranges hold for the *reconstructed* field: the support is widened for the wider filters, and the overshoot of
/// Catmull-Rom is bounded. Blocks are closed: neighbours share the samples on their common face.
#[derive(Clone, Debug)]
pub struct RangeBlocks {
    edge: usize,
    blocks: [usize; 3],
    ranges: Vec<BlockRange>,
}

/// What is known of the field in one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockRange {
    /// Lower bound of the field; above `high` if all of the block is vacuum.
    pub low: f32,
    /// Upper bound of the field.
    pub high: f32,
    /// Whether a part of the block is vacuum.
    pub vacuum: bool,
}

impl BlockRange {
    /// Whether the field exists nowhere in the block.
    pub fn is_empty(&self) -> bool {
        self.low > self.high
    }
}

impl RangeBlocks {
    pub(crate) fn of_field(volume: &UniformVolume, filter: Filter, edge: usize) -> Self {
        assert!(edge > 0, "blocks have at least one cell");
        let cells = volume.dims().map(|n| n - 1);
        let blocks = cells.map(|n| n.div_ceil(edge));
        volume.with_sampler(filter, Builder { edge, cells, blocks })
    }

    /// Cells along the edge of a block.
    pub fn edge(&self) -> usize {
        self.edge
    }

    /// Blocks along x, y, z.
    pub fn blocks(&self) -> [usize; 3] {
        self.blocks
    }

    /// The ranges, x fastest.
    pub fn ranges(&self) -> &[BlockRange] {
        &self.ranges
    }

    /// The range of one block.
    pub fn at(&self, block: [usize; 3]) -> BlockRange {
        self.ranges[(block[2] * self.blocks[1] + block[1]) * self.blocks[0] + block[0]]
    }
}

struct Builder {
    edge: usize,
    cells: [usize; 3],
    blocks: [usize; 3],
}

impl SamplerVisitor for Builder {
    type Output = RangeBlocks;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> RangeBlocks {
        let [bx, by, _] = self.blocks;
        let ranges = (0..self.blocks.iter().product::<usize>())
            .into_par_iter()
            .map(|b| self.range(&sampler, [b % bx, b / bx % by, b / (bx * by)]))
            .collect();
        RangeBlocks { edge: self.edge, blocks: self.blocks, ranges }
    }
}

impl Builder {
    fn range<T: Voxel, F: Reconstruction>(&self, sampler: &Sampler<'_, T, F>, block: [usize; 3]) -> BlockRange {
        let first: [usize; 3] = block.map(|b| b * self.edge);
        let end: [usize; 3] = std::array::from_fn(|a| (first[a] + self.edge).min(self.cells[a]));
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        let mut vacuum = false;
        let mut widen = |cell_first: [usize; 3], cell_end: [usize; 3]| {
            let (l, h) = corner_range(sampler, cell_first, cell_end);
            low = low.min(l);
            high = high.max(h);
        };
        match sampler.vacuum() {
            None => widen(first, end),
            // Cell by cell, the vacuum left out.
            Some(cells) => {
                for z in first[2]..end[2] {
                    for y in first[1]..end[1] {
                        for x in first[0]..end[0] {
                            if cells.is_vacuum([x, y, z]) {
                                vacuum = true;
                            } else {
                                widen([x, y, z], [x + 1, y + 1, z + 1]);
                            }
                        }
                    }
                }
            }
        }
        BlockRange { low, high, vacuum }
    }
}

/// Bounds of the field over the closed cells `first .. end`.
fn corner_range<T: Voxel, F: Reconstruction>(
    sampler: &Sampler<'_, T, F>,
    first: [usize; 3],
    end: [usize; 3],
) -> (f32, f32) {
    let lattice = sampler.lattice();
    let reach = F::FILTER.reach();
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    // Mirrored and repeated samples beyond the box are inside the clamped range, too: one step mirrors into it.
    let span = |a: usize| first[a].saturating_sub(reach)..=(end[a] + reach).min(lattice.dims[a] - 1);
    for z in span(2) {
        for y in span(1) {
            for x in span(0) {
                let s = lattice.samples[lattice.offset(x, y, z)].to_f32();
                low = low.min(s);
                high = high.max(s);
            }
        }
    }
    // Σ|w| of one axis: 1 where no weight is negative, at most 5/4 for Catmull-Rom (at t = ½).
    let gain: f32 = if F::FILTER == Filter::CatmullRom { 1.25 * 1.25 * 1.25 } else { 1.0 };
    let (centre, radius) = (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
    // Kernels in f32 round: a few units in the last place of the largest sample, 64 products deep.
    let slack = 16.0 * f32::EPSILON * low.abs().max(high.abs());
    if gain == 1.0 && F::FILTER.reach() == 0 {
        (low - slack, high + slack)
    } else {
        (centre - gain * radius - slack, centre + gain * radius + slack)
    }
}
