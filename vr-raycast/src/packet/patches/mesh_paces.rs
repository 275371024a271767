//! Paces of rays in the bricks of an adaptive mesh, found once for a scene.

use vr_core::amr::AmrGrid;

use crate::pace::Pace;

/// Paces in the bricks of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct MeshPaces {
    /// Length of a step, and true if something can be seen, brick by brick.
    pub(super) of_bricks: Vec<(f64, bool)>,
    /// The same of blocks all bricks of which have one pace.
    pub(super) of_blocks: Vec<(f64, bool)>,
    /// Ranges of the values of these blocks; `None` for the others.
    pub(super) whole: Vec<Option<[f32; 2]>>,
}

impl MeshPaces {
    pub(crate) fn new(grid: &AmrGrid, pace: &Pace<f32>) -> Self {
        let mut of_bricks = Vec::with_capacity(grid.brick_count());
        let (mut of_blocks, mut whole) = (Vec::new(), Vec::new());
        for (number, block) in grid.blocks().iter().enumerate() {
            let spacing = grid.mean_spacing_of(block.level);
            let first = of_bricks.len();
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for (_, range) in grid.brick_ranges(number) {
                of_bricks.push((pace.lengths.of(range, spacing), pace.shows(range)));
                (low, high) = (low.min(range[0]), high.max(range[1]));
            }
            let own = of_bricks.get(first).copied().unwrap_or((spacing, true));
            of_blocks.push(own);
            whole.push(of_bricks[first..].iter().all(|pace| *pace == own).then_some([low, high]));
        }
        Self { of_bricks, of_blocks, whole }
    }

    /// True if something in a block can be seen.
    pub(crate) fn is_seen(&self, grid: &AmrGrid, block: usize) -> bool {
        grid.brick_ranges(block).any(|(brick, _)| self.of_bricks[brick].1)
    }
}
