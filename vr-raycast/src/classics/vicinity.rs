//! Vicinity flag, by which coarse steps tell where fine ones are needed.

use vr_core::IndexRay;

use crate::leap::{BlockGrid, Leaper, VisibleBlocks};

/// Vicinity flag of each block: set for those that hold something visible, and for the 26 around each.
///
/// A coarse step is as long as the edge of a block, along the axis on which the ray is fastest. So from a point in a block whose flag is not
/// set, it ends in that block or in one of the 26 around it, none of which is visible, and so does all that lies between. Where the flag is
/// set, what the next coarse step crosses is sampled.
#[derive(Clone, Debug)]
pub(crate) struct Vicinity {
    flags: VisibleBlocks,
}

impl Vicinity {
    /// Sets the flag around visible blocks.
    pub(crate) fn new(visible: &VisibleBlocks) -> Self {
        Self { flags: visible.dilated() }
    }
}

impl Leaper for Vicinity {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        let BlockGrid { blocks, edge, reach } = self.flags.grid();
        let (origin, direction) = ((ray.origin / edge as f64).to_array(), (ray.direction / edge as f64).to_array());
        let fastest = direction.into_iter().map(f64::abs).fold(0.0, f64::max);
        // Samples may be taken a rounding beside the ray.
        let coarse = (1.0 - 2.0 * reach) / fastest;
        let mut at = from.max(ray.start);
        while at < ray.end {
            let end = at + coarse;
            if end <= at {
                // Rounding takes all of a coarse step: no flag says anything of it.
                return Some((at, ray.end));
            }
            // The cast turns what rounding carried below 0 into 0.
            let block = std::array::from_fn(|a| ((origin[a] + at * direction[a]) as usize).min(blocks[a] - 1));
            if self.flags.at(block) {
                return Some((at, end.min(ray.end)));
            }
            at = end;
        }
        None
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        self.flags.grid().len().div_ceil(8)
    }
}
