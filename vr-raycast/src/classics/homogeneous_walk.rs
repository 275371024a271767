//! Walk in long steps where the medium is nearly the same, and in short ones elsewhere.

use vr_core::IndexRay;

use super::homogeneity::{Homogeneity, Node};
use crate::run::Steps;
use crate::walk::BlockRay;

/// Walk from node to node: over clear ones, through homogeneous ones in one step, and through the rest in short steps.
#[derive(Clone, Debug)]
pub(crate) struct HomogeneousWalk<'a> {
    map: &'a Homogeneity,
    ray: BlockRay,
    /// World length of a short step.
    step: f64,
}

impl<'a> HomogeneousWalk<'a> {
    /// Begins a walk along a ray whose part in the volume is not empty. `voxel` is the world length of the smallest voxel edge.
    pub(crate) fn new(map: &'a Homogeneity, ray: IndexRay, step: f64, voxel: f64) -> Self {
        Self { map, ray: BlockRay::new(ray, map.blocks(), Homogeneity::EDGE, voxel), step }
    }

    /// Fills the next run; false at the end of the ray.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        while self.ray.goes_on(steps) {
            let block = self.ray.block();
            match self.map.at(block) {
                Node::Clear(level) => self.ray.leap(node(block, level)),
                Node::Homogeneous(level) => self.ray.step(self.ray.to_exit(node(block, level)).max(self.step), steps),
                Node::Mixed => self.ray.step(self.step, steps),
            }
        }
        steps.len > 0
    }
}

/// Returns the faces of the node of 2^level blocks an edge around a block.
fn node(block: [usize; 3], level: u32) -> impl Fn(usize) -> [f64; 2] {
    move |a| {
        let first = block[a] >> level << level;
        [first as f64, (first + (1 << level)) as f64]
    }
}
