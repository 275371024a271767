//! Lattices of the blocks of an adaptive mesh, made for those that can be seen.

use std::sync::OnceLock;

use vr_core::amr::{AmrGrid, AmrLattice};
use vr_core::parallel::collect;

/// Samples of blocks with those beside them, kept with the mesh: each made when it can first be seen.
#[derive(Debug, Default)]
pub(crate) struct MeshLattices(Vec<OnceLock<Option<AmrLattice>>>);

impl MeshLattices {
    pub(crate) fn new(grid: &AmrGrid) -> Self {
        Self(grid.blocks().iter().map(|_| OnceLock::new()).collect())
    }

    /// Makes those of blocks that are seen.
    pub(crate) fn make(&self, grid: &AmrGrid, is_seen: impl Fn(usize) -> bool + Sync) {
        let samples = grid.samples();
        collect(self.0.len(), |number| {
            if is_seen(number) {
                self.0[number].get_or_init(|| samples.lattice(number));
            }
        });
    }

    /// Numbers of samples of a block's lattice, and these; those of the block itself where they serve. `None` if it has not been made.
    #[inline]
    pub(crate) fn of<'a>(&'a self, grid: &'a AmrGrid, number: usize) -> Option<([usize; 3], &'a [f32])> {
        Some(match self.0[number].get()? {
            Some(lattice) => (lattice.dims, &lattice.values),
            None => {
                let block = &grid.blocks()[number];
                (block.dims, &block.values)
            }
        })
    }
}
