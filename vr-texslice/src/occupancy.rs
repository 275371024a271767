//! Blocks of cells in which something can be visible.

use std::sync::Arc;

use vr_core::GridVolume;
use vr_kernels::ranges::{BlockRange, RangeBlocks};

use crate::bricks::BrickLattice;
use crate::compression::Compressed;
use crate::layout::Layout;

/// Bounds of the field that a texture holds, in blocks of so many cells along an edge.
pub(crate) enum FieldRanges<'a> {
    /// The volume's own field.
    Volume(Arc<RangeBlocks>),
    /// The decoded field, which is off by half a level: the volume's numbers do not bound it.
    Compressed(&'a Compressed, BrickLattice),
}

impl<'a> FieldRanges<'a> {
    pub(crate) fn new(volume: &GridVolume, compressed: Option<&'a Compressed>, edge: usize) -> Self {
        match compressed {
            Some(compressed) => Self::Compressed(compressed, BrickLattice::new(volume.dims(), edge, Layout::VOLUME)),
            None => Self::Volume(RangeBlocks::of_volume(volume, edge)),
        }
    }

    /// Blocks along x, y, z.
    fn blocks(&self) -> [usize; 3] {
        match self {
            Self::Volume(ranges) => ranges.blocks(),
            Self::Compressed(_, lattice) => lattice.count(),
        }
    }

    /// Bounds of the field in a block.
    fn at(&self, block: [usize; 3]) -> BlockRange {
        match self {
            Self::Volume(ranges) => ranges.at(block),
            Self::Compressed(compressed, lattice) => compressed.range(&lattice.cells_of(block)),
        }
    }

    /// True if something is visible in the blocks that lie between two of them, ends included; of `segments`, if that may be between values on either side of
    /// vacuum, too.
    pub(crate) fn show(&self, [x, y, z]: [[usize; 2]; 3], segments: bool, visible: impl Fn(f32, f32) -> bool) -> bool {
        let mut all = NOTHING;
        for (z, y) in (z[0]..=z[1]).flat_map(|z| (y[0]..=y[1]).map(move |y| (z, y))) {
            for x in x[0]..=x[1] {
                let range = self.at([x, y, z]);
                if !range.is_empty() && visible(range.low, range.high) {
                    return true;
                }
                all = hull(&all, &range);
            }
        }
        segments && is_visible_across(&all, visible)
    }
}

/// A block without a field.
const NOTHING: BlockRange = BlockRange { low: f32::INFINITY, high: f32::NEG_INFINITY, vacuum: false };

/// Bounds of the field in two blocks.
fn hull(a: &BlockRange, b: &BlockRange) -> BlockRange {
    BlockRange { low: a.low.min(b.low), high: a.high.max(b.high), vacuum: a.vacuum || b.vacuum }
}

/// True if something is visible on a segment through blocks of these bounds though nothing is in any of them. Where the field goes on from block to block, no value
/// between two of its own is new to it; but a segment may begin on one side of vacuum, and end on the other.
fn is_visible_across(all: &BlockRange, visible: impl Fn(f32, f32) -> bool) -> bool {
    all.vacuum && !all.is_empty() && visible(all.low, all.high)
}

/// Something that a picture may show of a block.
#[derive(Clone, Copy)]
pub(crate) enum Shown<'a> {
    /// Samples whose values are visible, by what is between two stored numbers.
    Samples(&'a (dyn Fn(f32, f32) -> bool + Sync)),
    /// Segments between such values.
    Segments(&'a (dyn Fn(f32, f32) -> bool + Sync)),
    /// The largest value times a sign.
    Largest(f32),
}

/// Visibility of blocks of [`Occupancy::EDGE`]³ cells.
pub(crate) struct Occupancy<'a> {
    /// Along each axis of the texture.
    blocks: [usize; 3],
    /// For each block, 1 if anything in it is visible, and 0 if nothing is; for an extreme, the largest value times the sign.
    bounds: Vec<f32>,
    /// Blocks in which segments may pass vacuum.
    gaps: Option<Gaps<'a>>,
}

/// Bounds of the field in each block, and what is visible of it.
struct Gaps<'a> {
    ranges: Vec<BlockRange>,
    visible: &'a (dyn Fn(f32, f32) -> bool + Sync),
}

impl<'a> Occupancy<'a> {
    /// Cells along the edge of a block: eight samples of sixteen pixels touch eight blocks of that size or fewer, at pixels and slices as far apart as
    /// voxels.
    pub(crate) const EDGE: usize = 8;

    /// Occupancy by a volume's ranges; texture coordinate c is the index along axis `axes[c]`. `None` where something is visible in every block.
    pub(crate) fn new(ranges: &FieldRanges<'_>, axes: [usize; 3], shown: Shown<'a>) -> Option<Self> {
        let blocks = axes.map(|a| ranges.blocks()[a]);
        let mut all = Vec::with_capacity(blocks.iter().product());
        for z in 0..blocks[2] {
            for y in 0..blocks[1] {
                for x in 0..blocks[0] {
                    let mut at = [0; 3];
                    (at[axes[0]], at[axes[1]], at[axes[2]]) = (x, y, z);
                    all.push(ranges.at(at));
                }
            }
        }
        let bound = |range: &BlockRange| match shown {
            Shown::Largest(_) if range.is_empty() => f32::NEG_INFINITY,
            Shown::Largest(sign) => (range.low * sign).max(range.high * sign),
            Shown::Samples(visible) | Shown::Segments(visible) => {
                f32::from(u8::from(!range.is_empty() && visible(range.low, range.high)))
            }
        };
        let bounds: Vec<f32> = all.iter().map(bound).collect();
        if !matches!(shown, Shown::Largest(_)) && bounds.iter().all(|&bound| bound > 0.0) {
            return None;
        }
        let gaps = match shown {
            Shown::Segments(visible) if all.iter().any(|range| range.vacuum) => Some(Gaps { ranges: all, visible }),
            _ => None,
        };
        Some(Self { blocks, bounds, gaps })
    }

    /// True if nothing in a box of cells, given by its first and last cell along each axis, is above `floor`: 0, or the extreme so far.
    pub(crate) fn is_empty(&self, cells: [[usize; 2]; 3], floor: f32) -> bool {
        let [x, y, z] = cells.map(|[low, high]| low / Self::EDGE..high / Self::EDGE + 1);
        let rows = || z.clone().flat_map(|z| y.clone().map(move |y| (z * self.blocks[1] + y) * self.blocks[0]));
        let none = rows().all(|row| self.bounds[row + x.start..row + x.end].iter().all(|&bound| bound <= floor));
        none && self.gaps.as_ref().is_none_or(|Gaps { ranges, visible }| {
            let touched = rows().flat_map(|row| &ranges[row + x.start..row + x.end]);
            !is_visible_across(&touched.fold(NOTHING, |all, range| hull(&all, range)), visible)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume};

    /// Values of 0 before a wall of missing ones, and of 2 behind it.
    fn walled() -> Volume {
        let value = |i: usize| [0.0, f32::NAN, 2.0][usize::from(i / 81 > 10) + usize::from(i / 81 > 16)];
        let samples: Vec<f32> = (0..9 * 9 * 33).map(value).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        UniformGrid::new([9, 9, 33], samples, placement, Calibration::default()).unwrap().into()
    }

    #[test]
    fn a_segment_across_vacuum_shows_what_is_between_its_ends() {
        let volume = walled();
        let grid = volume.grid().unwrap();
        let ranges = FieldRanges::new(grid, None, Occupancy::EDGE);
        let one = |low: f32, high: f32| low <= 1.0 && 1.0 <= high;
        let samples = Occupancy::new(&ranges, [0, 1, 2], Shown::Samples(&one)).unwrap();
        let segments = Occupancy::new(&ranges, [0, 1, 2], Shown::Segments(&one)).unwrap();
        let along = |z: [usize; 2]| [[0, 7], [0, 7], z];
        for z in [[0, 7], [0, 10], [8, 16], [8, 15], [16, 31], [0, 31]] {
            assert!(samples.is_empty(along(z), 0.0), "{z:?}");
            // Blocks 0 and 1 hold nothing but 0, and 2 and 3 nothing but 2: vacuum is in blocks 1 and 2.
            let across = z[0] < 16 && z[1] >= 16;
            assert_eq!(segments.is_empty(along(z), 0.0), !across, "{z:?}");
            let blocks = along(z).map(|[low, high]| [low / Occupancy::EDGE, high / Occupancy::EDGE]);
            assert_eq!(ranges.show(blocks, true, one), !segments.is_empty(along(z), 0.0), "{z:?}");
            assert!(!ranges.show(blocks, false, one), "{z:?}");
        }
    }

    #[test]
    fn an_extreme_is_not_above_what_blocks_hold() {
        let volume = walled();
        let ranges = FieldRanges::new(volume.grid().unwrap(), None, Occupancy::EDGE);
        let largest = Occupancy::new(&ranges, [0, 1, 2], Shown::Largest(1.0)).unwrap();
        let smallest = Occupancy::new(&ranges, [0, 1, 2], Shown::Largest(-1.0)).unwrap();
        let [before, behind] = [[[0, 7], [0, 7], [0, 7]], [[0, 7], [0, 7], [24, 31]]];
        assert!(!largest.is_empty(before, -1.0) && largest.is_empty(before, 1.0) && !largest.is_empty(behind, 1.0));
        assert!(!smallest.is_empty(before, -1.0) && smallest.is_empty(behind, -1.0));
    }
}
