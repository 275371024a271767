//! Blocks of cells in which something can be visible.

use vr_kernels::ranges::RangeBlocks;

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
    pub(crate) fn new(ranges: &RangeBlocks, axes: [usize; 3], visible: impl Fn(f32, f32) -> bool) -> Option<Self> {
        let blocks = axes.map(|a| ranges.blocks()[a]);
        let mut all = Vec::with_capacity(blocks.iter().product());
        for z in 0..blocks[2] {
            for y in 0..blocks[1] {
                for x in 0..blocks[0] {
                    let mut at = [0; 3];
                    (at[axes[0]], at[axes[1]], at[axes[2]]) = (x, y, z);
                    let range = ranges.at(at);
                    all.push(!range.is_empty() && visible(range.low, range.high));
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
