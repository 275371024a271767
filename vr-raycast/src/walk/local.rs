//! Steps as long as what is in each place allows.

use vr_core::IndexRay;

use crate::pace::{Pace, PaceMap};
use crate::run::{RUN, Steps};

/// Walks a ray from block to block: over what is clear, and through the rest in steps of the length that the block of their begin asks for.
#[derive(Clone, Debug)]
pub(crate) struct LocalWalk<'a> {
    map: &'a PaceMap,
    ray: IndexRay,
    at: f64,
    number: u32,
    /// A distance that no one sees, and that carries a position across a face that it lies on.
    nudge: f64,
}

/// Of a voxel: beyond what rounding does to a position, and far below any step.
const NUDGE: f64 = 1e-6;
/// Of a ray's length: a rest shorter than this is rounding.
const SLIVER: f64 = 1e-12;

impl<'a> LocalWalk<'a> {
    /// Along a ray whose part in the volume is not empty. `voxel`: world length of the smallest voxel edge.
    pub(crate) fn new(map: &'a PaceMap, ray: IndexRay, voxel: f64) -> Self {
        Self { map, ray, at: ray.start, number: 0, nudge: NUDGE * voxel }
    }

    /// Fills the next run; false at the end of the ray.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        let end = self.ray.end - SLIVER * self.ray.length();
        while steps.len < RUN && self.at < end {
            let block = self.block(self.at + self.nudge);
            match self.map.at(block) {
                Pace::Leap(radius) => self.at = self.leaves(block, usize::from(radius)).max(self.at + self.nudge),
                Pace::Step(length) => {
                    let length = f64::from(length).min(self.ray.end - self.at);
                    steps.push(self.at, length, self.number);
                    self.number += 1;
                    self.at += length;
                }
            }
        }
        steps.len > 0
    }

    fn block(&self, distance: f64) -> [usize; 3] {
        let position = self.ray.at(distance).to_array();
        // `as` saturates: below the first block lies the first.
        std::array::from_fn(|a| ((position[a] / PaceMap::EDGE as f64) as usize).min(self.map.blocks()[a] - 1))
    }

    /// Where the ray leaves the cube of blocks up to `radius` around one.
    fn leaves(&self, block: [usize; 3], radius: usize) -> f64 {
        let (origin, direction) = (self.ray.origin.to_array(), self.ray.direction.to_array());
        let along = |a: usize| {
            let edge = PaceMap::EDGE as f64;
            let face = match direction[a] {
                d if d > 0.0 => (block[a] + radius + 1) as f64 * edge,
                d if d < 0.0 => (block[a] as f64 - radius as f64) * edge,
                _ => return f64::INFINITY,
            };
            (face - origin[a]) / direction[a]
        };
        along(0).min(along(1)).min(along(2))
    }
}
