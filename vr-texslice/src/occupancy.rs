//! Blocks of cells in which something can be visible.

use std::sync::Arc;

use vr_core::GridVolume;
use vr_kernels::ranges::RangeBlocks;

use crate::bricks::BrickLattice;
use crate::compression::Compressed;

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
            Some(compressed) => Self::Compressed(compressed, BrickLattice::new(volume.dims(), edge)),
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

    /// True if something is visible in a block, by what is visible between two stored numbers.
    pub(crate) fn shows(&self, block: [usize; 3], visible: impl Fn(f32, f32) -> bool) -> bool {
        let range = match self {
            Self::Volume(ranges) => ranges.at(block),
            Self::Compressed(compressed, lattice) => compressed.range(&lattice.cells_of(block)),
        };
        !range.is_empty() && visible(range.low, range.high)
    }
}

/// One bit a block of [`Occupancy::EDGE`]³ cells: whether any value in it is visible.
#[derive(Clone, Debug)]
pub(crate) struct Occupancy {
    /// Along each axis of the texture.
    blocks: [usize; 3],
    visible: Vec<bool>,
}

impl Occupancy {
    /// Cells along the edge of a block: eight samples of sixteen pixels touch eight blocks of that size or fewer, at pixels and slices as far apart as
    /// voxels.
    pub(crate) const EDGE: usize = 8;

    /// Occupancy of a volume's ranges, by what is visible between two stored numbers; texture coordinate c is the index along axis `axes[c]`. `None` where
    /// something is visible in every block.
    pub(crate) fn new(ranges: &FieldRanges<'_>, axes: [usize; 3], visible: impl Fn(f32, f32) -> bool) -> Option<Self> {
        let blocks = axes.map(|a| ranges.blocks()[a]);
        let mut all = Vec::with_capacity(blocks.iter().product());
        for z in 0..blocks[2] {
            for y in 0..blocks[1] {
                for x in 0..blocks[0] {
                    let mut at = [0; 3];
                    (at[axes[0]], at[axes[1]], at[axes[2]]) = (x, y, z);
                    all.push(ranges.shows(at, &visible));
                }
            }
        }
        (!all.iter().all(|&v| v)).then_some(Self { blocks, visible: all })
    }

    /// True if nothing is visible in a box of cells, given by its first and last cell along each axis.
    pub(crate) fn is_empty(&self, cells: [[usize; 2]; 3]) -> bool {
        let [x, y, z] = cells.map(|[low, high]| low / Self::EDGE..high / Self::EDGE + 1);
        z.into_iter().all(|z| {
            y.clone().all(|y| {
                let row = (z * self.blocks[1] + y) * self.blocks[0];
                self.visible[row + x.start..row + x.end].iter().all(|v| !v)
            })
        })
    }
}
