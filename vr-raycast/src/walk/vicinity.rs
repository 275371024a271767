//! Coarse steps that look at a flag.

use std::ops::Range;

use vr_core::IndexRay;

use super::Lattice;
use crate::leap::{BlockGrid, VisibleBlocks};

/// The vicinity flag: set for blocks that hold something visible, and for the 26 around each.
#[derive(Clone, Debug)]
pub(crate) struct VicinityFlags(VisibleBlocks);

impl VicinityFlags {
    pub(crate) fn new(visible: &VisibleBlocks) -> Self {
        Self(visible.dilated())
    }
}

/// The lattice steps of a ray that lie in the vicinity of what is visible, found by coarse steps.
///
/// A coarse step is as many lattice steps as fit into the edge of a block, along the axis on which the ray is fastest. So from a point in a block
/// whose flag is not set, it ends in that block or in one of the 26 around it, none of which is visible, and so does all that lies between. Where
/// the flag is set, the next coarse step's worth of lattice steps is taken one by one.
#[derive(Clone, Debug)]
pub(crate) struct Vicinity<'a> {
    flags: &'a VicinityFlags,
    lattice: Lattice,
    /// In blocks.
    origin: [f64; 3],
    /// Blocks per world unit.
    direction: [f64; 3],
    /// Lattice steps in a coarse one.
    coarse: u32,
    /// The lattice step that the next coarse one begins with.
    at: u32,
}

impl<'a> Vicinity<'a> {
    /// Along a ray, from a lattice step on.
    pub(crate) fn new(flags: &'a VicinityFlags, lattice: Lattice, ray: &IndexRay, first: u32) -> Self {
        let BlockGrid { edge, reach, .. } = flags.0.grid();
        let (origin, direction) = ((ray.origin / edge as f64).to_array(), (ray.direction / edge as f64).to_array());
        let fastest = direction.into_iter().map(f64::abs).fold(0.0, f64::max);
        // Samples may be taken a rounding beside the ray. `as` turns what is beyond any count into the largest one.
        let coarse = ((1.0 - 2.0 * reach) / (fastest * lattice.length)) as u32;
        Self { flags, lattice, origin, direction, coarse, at: first }
    }

    /// The next lattice steps near something visible.
    pub(crate) fn next(&mut self) -> Option<Range<u32>> {
        // A single lattice step is longer than a block: no flag says anything of it.
        if self.coarse == 0 {
            let all = self.at..self.lattice.count;
            self.at = self.lattice.count;
            return Some(all).filter(|all| !all.is_empty());
        }
        while self.at < self.lattice.count {
            let first = self.at;
            self.at = first.saturating_add(self.coarse).min(self.lattice.count);
            if self.is_set(self.lattice.begin(first)) {
                return Some(first..self.at);
            }
        }
        None
    }

    fn is_set(&self, s: f64) -> bool {
        let blocks = self.flags.0.grid().blocks;
        self.flags.0.at(std::array::from_fn(|a| {
            // The cast turns what rounding carried below 0 into 0.
            ((self.origin[a] + s * self.direction[a]) as usize).min(blocks[a] - 1)
        }))
    }
}
