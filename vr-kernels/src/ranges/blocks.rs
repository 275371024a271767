//! Ranges of the reconstructed field, block by block: for renderers that leap over, cull or skip empty space.

use std::sync::{Arc, Mutex};

use vr_core::filter::{Filter, Reconstruction, Trilinear};
use vr_core::parallel::{each, locked};
use vr_core::{GridVolume, Sampler, SamplerVisitor, VacuumCells, Voxel};

/// Smallest and largest value of the field in each block of `edge`³ cells, in stored units.
///
/// The ranges hold for the *reconstructed* field: the support is widened for the wider filters, and the overshoot of
/// Catmull-Rom is bounded. Blocks are closed: neighbours share the voxels on their common face.
#[derive(Clone, Debug)]
pub struct RangeBlocks {
    edge: usize,
    blocks: [usize; 3],
    ranges: Vec<BlockRange>,
}

/// Bounds of the field in one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockRange {
    /// Lower bound of the field; above `high` if all of the block is vacuum.
    pub low: f32,
    /// Upper bound of the field.
    pub high: f32,
    /// True if a part of the block is vacuum.
    pub vacuum: bool,
}

impl BlockRange {
    /// Bounds of a trilinear field between two stored numbers: wider by what kernels in f32 round.
    pub fn of_trilinear([low, high]: [f32; 2]) -> Self {
        let (low, high) = bounds::<Trilinear>(low, high);
        Self { low, high, vacuum: false }
    }

    /// True if the field exists nowhere in the block.
    pub fn is_empty(&self) -> bool {
        self.low > self.high
    }
}

impl RangeBlocks {
    /// Ranges of a volume's field in blocks of `edge`³ cells; made once and kept with the volume.
    pub fn of_volume(volume: &GridVolume, edge: usize) -> Arc<Self> {
        volume.derived().get((volume.filter(), edge), || {
            let (blocks, ranges) = block_ranges(volume, edge, |range| range);
            Self { edge, blocks, ranges }
        })
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

/// Blocks along x, y, z of `edge`³ cells, and what `keep` keeps of the range of each, x fastest: a row of them at a time is all that
/// is held in full.
pub(crate) fn block_ranges<K: Copy + Send>(
    volume: &GridVolume,
    edge: usize,
    keep: impl Fn(BlockRange) -> K + Sync,
) -> ([usize; 3], Vec<K>) {
    assert!(edge > 0, "blocks have at least one cell");
    let cells = volume.dims().map(|n| n - 1);
    let blocks = cells.map(|n| n.div_ceil(edge));
    let nothing = BlockRange { low: f32::INFINITY, high: f32::NEG_INFINITY, vacuum: true };
    let mut kept = vec![keep(nothing); blocks.iter().product()];
    let rows: Vec<_> = kept.chunks_mut(blocks[0]).map(Mutex::new).collect();
    let put = |row: usize, ranges: &[BlockRange]| {
        for (kept, &range) in locked(&rows[row]).iter_mut().zip(ranges) {
            *kept = keep(range);
        }
    };
    volume.with_sampler(Builder { edge, cells, blocks, put: &put });
    drop(rows);
    (blocks, kept)
}

struct Builder<'a> {
    edge: usize,
    cells: [usize; 3],
    blocks: [usize; 3],
    /// Takes the ranges of a row of blocks along x.
    put: &'a (dyn Fn(usize, &[BlockRange]) + Sync),
}

impl SamplerVisitor for Builder<'_> {
    type Output = ();

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        let [bx, by, bz] = self.blocks;
        let nothing = BlockRange { low: f32::INFINITY, high: f32::NEG_INFINITY, vacuum: true };
        each(by * bz, &|row| {
            let mut ranges = vec![nothing; bx];
            let (y, z) = (row % by, row / by);
            match sampler.vacuum() {
                None => self.row(&sampler, [y, z], &mut ranges),
                Some(vacuum) => {
                    for (x, range) in ranges.iter_mut().enumerate() {
                        *range = self.with_vacuum(&sampler, vacuum, [x, y, z]);
                    }
                }
            }
            (self.put)(row, &ranges);
        });
    }
}

impl Builder<'_> {
    /// The first cell of a block along an axis, and the one behind its last.
    fn cells_of(&self, axis: usize, block: usize) -> (usize, usize) {
        let first = block * self.edge;
        (first, (first + self.edge).min(self.cells[axis]))
    }

    /// Computes the ranges of a row of blocks without vacuum: first over y and z, voxel by voxel along x, which is vector code in the
    /// voxels' own type; then over the x of each block.
    fn row<T: Voxel, F: Reconstruction>(
        &self,
        sampler: &Sampler<'_, T, F>,
        [y, z]: [usize; 2],
        out: &mut [BlockRange],
    ) {
        let lattice = sampler.lattice();
        let width = lattice.dims[0];
        let span = |axis: usize, block: usize| {
            let (first, end) = self.cells_of(axis, block);
            support::<F>(first, end, lattice.dims[axis])
        };
        // Smallest and largest voxel over y and z, at each x.
        let (mut low, mut high): (Vec<T>, Vec<T>) = (Vec::new(), Vec::new());
        for z in span(2, z) {
            for y in span(1, y) {
                let start = lattice.offset(0, y, z);
                let samples = &lattice.samples[start..start + width];
                if low.is_empty() {
                    low.extend_from_slice(samples);
                    high.extend_from_slice(samples);
                    continue;
                }
                for ((low, high), &s) in low.iter_mut().zip(&mut high).zip(samples) {
                    *low = if s < *low { s } else { *low };
                    *high = if s > *high { s } else { *high };
                }
            }
        }
        // Smallest and largest over the x of each block.
        for (x, range) in out.iter_mut().enumerate() {
            let span = span(0, x);
            let min = low[span.clone()].iter().fold(f32::INFINITY, |a, s| a.min(s.to_f32()));
            let max = high[span].iter().fold(f32::NEG_INFINITY, |a, s| a.max(s.to_f32()));
            let (low, high) = bounds::<F>(min, max);
            *range = BlockRange { low, high, vacuum: false };
        }
    }

    /// The range of a block of a volume with holes: cell by cell, the vacuum left out.
    fn with_vacuum<T: Voxel, F: Reconstruction>(
        &self,
        sampler: &Sampler<'_, T, F>,
        vacuum: &VacuumCells,
        block: [usize; 3],
    ) -> BlockRange {
        let [xs, ys, zs] = std::array::from_fn(|a| {
            let (first, end) = self.cells_of(a, block[a]);
            first..end
        });
        let mut range = BlockRange { low: f32::INFINITY, high: f32::NEG_INFINITY, vacuum: false };
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    if vacuum.is_vacuum([x, y, z]) {
                        range.vacuum = true;
                        continue;
                    }
                    let (low, high) = bounds_of_cell(sampler, [x, y, z]);
                    range.low = range.low.min(low);
                    range.high = range.high.max(high);
                }
            }
        }
        range
    }
}

/// The voxels of an axis that the field in the cells `first .. end` depends on.
///
/// Mirrored and repeated voxels beyond the box are among them, too: one step mirrors into the box.
fn support<F: Reconstruction>(first: usize, end: usize, samples: usize) -> std::ops::Range<usize> {
    let reach = F::FILTER.reach();
    first.saturating_sub(reach)..(end + reach + 1).min(samples)
}

fn bounds_of_cell<T: Voxel, F: Reconstruction>(sampler: &Sampler<'_, T, F>, cell: [usize; 3]) -> (f32, f32) {
    let lattice = sampler.lattice();
    let span = |a: usize| support::<F>(cell[a], cell[a] + 1, lattice.dims[a]);
    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
    for z in span(2) {
        for y in span(1) {
            for x in span(0) {
                let s = lattice.samples[lattice.offset(x, y, z)].to_f32();
                low = low.min(s);
                high = high.max(s);
            }
        }
    }
    bounds::<F>(low, high)
}

/// Bounds of a field whose support has the smallest and the largest voxel given.
pub(crate) fn bounds<F: Reconstruction>(low: f32, high: f32) -> (f32, f32) {
    // Kernels in f32 round: a few units in the last place of the largest voxel, 64 products deep.
    let slack = 16.0 * f32::EPSILON * low.abs().max(high.abs());
    match F::FILTER {
        // What is the same everywhere stays what it is: a + t·(b − a) rounds nothing where a = b. So air that is one stored number is clear
        // under a ramp that begins there.
        Filter::Nearest | Filter::Trilinear if low == high => (low, high),
        Filter::Nearest | Filter::Trilinear => (low - slack, high + slack),
        filter => {
            // Σ|w| of one axis: 1 where no weight is negative, at most 5/4 for Catmull-Rom (at t = ½).
            let gain: f32 = if filter == Filter::CatmullRom { 1.25 * 1.25 * 1.25 } else { 1.0 };
            let (centre, radius) = (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
            (centre - gain * radius - slack, centre + gain * radius + slack)
        }
    }
}
