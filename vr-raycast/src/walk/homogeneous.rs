//! Long steps where the medium is nearly the same, short ones elsewhere.

use vr_core::IndexRay;

use crate::homogeneity::{Homogeneity, Node};
use crate::run::{RUN, Steps};

/// Walks a ray from node to node: over what is clear, through what is homogeneous in one step, and through the rest in short steps.
#[derive(Clone, Debug)]
pub(crate) struct HomogeneousWalk<'a> {
    map: &'a Homogeneity,
    ray: IndexRay,
    /// World length of a short step.
    step: f64,
    at: f64,
    number: u32,
    /// A distance that no one sees, and that carries a position across a face that it lies on.
    nudge: f64,
}

/// Of a voxel: beyond what rounding does to a position, and far below any step.
const NUDGE: f64 = 1e-6;
/// Of a ray's length: a rest shorter than this is rounding.
const SLIVER: f64 = 1e-12;

impl<'a> HomogeneousWalk<'a> {
    /// Along a ray whose part in the volume is not empty. `voxel`: world length of the smallest voxel edge.
    pub(crate) fn new(map: &'a Homogeneity, ray: IndexRay, step: f64, voxel: f64) -> Self {
        Self { map, ray, step, at: ray.start, number: 0, nudge: NUDGE * voxel }
    }

    /// Fills the next run; false at the end of the ray.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        let end = self.ray.end - SLIVER * self.ray.length();
        while steps.len < RUN && self.at < end {
            let block = self.block(self.at + self.nudge);
            let length = match self.map.at(block) {
                Node::Clear(level) => {
                    self.at = self.leaves(block, level).max(self.at + self.nudge);
                    continue;
                }
                Node::Homogeneous(level) => (self.leaves(block, level) - self.at).max(self.step),
                Node::Mixed => self.step,
            };
            let length = length.min(self.ray.end - self.at);
            steps.push(self.at, length, self.number);
            self.number += 1;
            self.at += length;
        }
        steps.len > 0
    }

    fn block(&self, distance: f64) -> [usize; 3] {
        let position = self.ray.at(distance).to_array();
        // `as` saturates: below the first block lies the first.
        let edge = Homogeneity::EDGE as f64;
        std::array::from_fn(|a| ((position[a] / edge) as usize).min(self.map.blocks()[a] - 1))
    }

    /// Where the ray leaves the node of 2^level blocks an edge around a block.
    fn leaves(&self, block: [usize; 3], level: u32) -> f64 {
        let (origin, direction) = (self.ray.origin.to_array(), self.ray.direction.to_array());
        let along = |a: usize| {
            let first = block[a] >> level << level;
            let face = match direction[a] {
                d if d > 0.0 => first + (1 << level),
                d if d < 0.0 => first,
                _ => return f64::INFINITY,
            };
            ((face * Homogeneity::EDGE) as f64 - origin[a]) / direction[a]
        };
        along(0).min(along(1)).min(along(2))
    }
}
