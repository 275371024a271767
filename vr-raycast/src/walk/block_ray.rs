//! Ray among blocks of cells: the block that it is in, the points where it leaves boxes of blocks, and the steps that it has taken.

use vr_core::IndexRay;

use crate::run::{RUN, Steps};

/// State of a walk from block to block.
#[derive(Clone, Debug)]
pub(crate) struct BlockRay {
    ray: IndexRay,
    /// Blocks along x, y, z, and cells along their edge.
    blocks: [usize; 3],
    edge: f64,
    at: f64,
    /// Distance from which on the rest of the ray is rounding.
    end: f64,
    number: u32,
    /// Distance too small to be seen that carries a position across a face that it lies on.
    nudge: f64,
}

/// Nudge as a fraction of a voxel: beyond the rounding of a position, and far below any step.
const NUDGE: f64 = 1e-6;
/// Fraction of a ray's length below which a rest is rounding.
const SLIVER: f64 = 1e-12;

impl BlockRay {
    /// Begins a walk at the begin of a ray whose part in the volume is not empty. `voxel` is the world length of the smallest voxel edge.
    pub(crate) fn new(ray: IndexRay, blocks: [usize; 3], edge: usize, voxel: f64) -> Self {
        let end = ray.end - SLIVER * ray.length();
        Self { ray, blocks, edge: edge as f64, at: ray.start, end, number: 0, nudge: NUDGE * voxel }
    }

    /// True if there is room in a run, and a part of the ray is left.
    pub(crate) fn goes_on(&self, steps: &Steps) -> bool {
        steps.len < RUN && self.at < self.end
    }

    /// Returns the block that the ray is about to cross.
    pub(crate) fn block(&self) -> [usize; 3] {
        let position = self.ray.at(self.at + self.nudge).to_array();
        // `as` saturates: below the first block lies the first.
        std::array::from_fn(|a| ((position[a] / self.edge) as usize).min(self.blocks[a] - 1))
    }

    /// Returns the distance to the point where the ray leaves a box of blocks. `faces`: the lower and the upper one across an axis, in blocks.
    pub(crate) fn to_exit(&self, faces: impl Fn(usize) -> [f64; 2]) -> f64 {
        self.exit(faces) - self.at
    }

    /// Returns the distance to the next face across any axis, of those that lie so far behind each sample.
    pub(crate) fn to_face(&self, behind: &[f64]) -> f64 {
        let (origin, direction) = (self.ray.origin.to_array(), self.ray.direction.to_array());
        let position = self.ray.at(self.at + self.nudge).to_array();
        let mut nearest = f64::INFINITY;
        for a in (0..3).filter(|&a| direction[a] != 0.0) {
            for shift in behind {
                let x = position[a] - shift;
                let face = shift + if direction[a] > 0.0 { x.floor() + 1.0 } else { x.ceil() - 1.0 };
                nearest = nearest.min((face - origin[a]) / direction[a]);
            }
        }
        (nearest - self.at).max(self.nudge)
    }

    /// Goes on to the point where the ray leaves a box of blocks, without a step.
    pub(crate) fn leap(&mut self, faces: impl Fn(usize) -> [f64; 2]) {
        self.at = self.exit(faces).max(self.at + self.nudge);
    }

    /// Takes a step, no further than to the ray's end.
    pub(crate) fn step(&mut self, length: f64, steps: &mut Steps) {
        let length = length.min(self.ray.end - self.at);
        steps.push(self.at, length, self.number);
        self.number += 1;
        self.at += length;
    }

    fn exit(&self, faces: impl Fn(usize) -> [f64; 2]) -> f64 {
        let (origin, direction) = (self.ray.origin.to_array(), self.ray.direction.to_array());
        let along = |a: usize| {
            let [lower, upper] = faces(a);
            let face = match direction[a] {
                d if d > 0.0 => upper,
                d if d < 0.0 => lower,
                _ => return f64::INFINITY,
            };
            (face * self.edge - origin[a]) / direction[a]
        };
        along(0).min(along(1)).min(along(2))
    }
}
