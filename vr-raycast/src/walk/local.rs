//! Walk in steps as long as the medium in each place allows.

use vr_core::IndexRay;

use super::BlockRay;
use crate::run::Steps;
use crate::step_map::{BlockStep, StepMap};

/// Walk from block to block: over clear ones, and through the rest in steps of the length that the block of their begin asks for.
#[derive(Clone, Debug)]
pub(crate) struct LocalWalk<'a> {
    map: &'a StepMap,
    ray: BlockRay,
}

impl<'a> LocalWalk<'a> {
    /// Begins a walk along a ray whose part in the volume is not empty. `voxel` is the world length of the smallest voxel edge.
    pub(crate) fn new(map: &'a StepMap, ray: IndexRay, voxel: f64) -> Self {
        Self { map, ray: BlockRay::new(ray, map.blocks(), StepMap::EDGE, voxel) }
    }

    /// Fills the next run; returns false at the end of the ray.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        while self.ray.goes_on(steps) {
            let block = self.ray.block();
            match self.map.at(block) {
                BlockStep::Leap(radius) => self.ray.leap(cube(block, radius)),
                BlockStep::Step(length) => self.ray.step(f64::from(length), steps),
                BlockStep::CutStep(length) => {
                    let face = self.ray.to_face(self.map.faces());
                    self.ray.step(f64::from(length).min(face), steps);
                }
            }
        }
        steps.len > 0
    }
}

/// Returns the faces of the cube of blocks up to `radius` around one.
fn cube(block: [usize; 3], radius: u8) -> impl Fn(usize) -> [f64; 2] {
    let radius = f64::from(radius);
    move |a| [block[a] as f64 - radius, block[a] as f64 + radius + 1.0]
}
