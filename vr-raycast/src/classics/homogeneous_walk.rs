//! Walk in long steps where the medium is nearly the same, and in short ones elsewhere.

use vr_core::IndexRay;

use super::homogeneity::{Homogeneity, Node};
use crate::run::{RUN, Steps};
use crate::walk::BlockRay;

/// Walk from node to node: over clear ones, through homogeneous ones in one step, and through the rest in short steps.
///
/// Back to front, it hands out the runs of the walk from the front, last run first: where steps end depends on where they began.
#[derive(Clone, Debug)]
pub(crate) struct HomogeneousWalk<'a> {
    map: &'a Homogeneity,
    ray: BlockRay,
    /// World length of a short step.
    step: f64,
    /// Values of the last run's steps that are crossed at the mean of a node; NaN for the others, which sample the field.
    means: [f32; RUN],
    /// True if the last run has any of those.
    has_means: bool,
    /// Runs that are not handed out yet, from the front; `None` for a walk that begins there.
    left: Option<Vec<MeanRun>>,
}

/// Run of steps, and its means if it has any.
type MeanRun = (Steps, Option<[f32; RUN]>);

impl<'a> HomogeneousWalk<'a> {
    /// Begins a walk along a ray whose part in the volume is not empty, from its far end if `backwards`. `voxel` is the world length of the
    /// smallest voxel edge.
    pub(crate) fn new(map: &'a Homogeneity, ray: IndexRay, step: f64, voxel: f64, backwards: bool) -> Self {
        let mut walk = Self {
            map,
            ray: BlockRay::new(ray, map.blocks(), Homogeneity::EDGE, voxel),
            step,
            means: [f32::NAN; RUN],
            has_means: false,
            left: None,
        };
        if backwards {
            let (mut steps, mut runs) = (Steps::new(), Vec::new());
            while walk.walk_on(&mut steps) {
                runs.push((steps.clone(), walk.means().copied()));
            }
            walk.left = Some(runs);
        }
        walk
    }

    /// Fills the next run; false at the end of the ray.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        let Some(left) = &mut self.left else { return self.walk_on(steps) };
        let Some((run, means)) = left.pop() else { return false };
        *steps = run;
        self.has_means = means.is_some();
        self.means = means.unwrap_or(self.means);
        true
    }

    /// Fills the next run from the front.
    fn walk_on(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        self.has_means = false;
        while self.ray.goes_on(steps) {
            let block = self.ray.block();
            if let Some((level, mean)) = self.map.mean_at(block) {
                let length = self.ray.to_exit(node(block, level));
                // A shorter one would be no longer than one that samples the field.
                if length >= self.step {
                    (self.means[steps.len], self.has_means) = (mean, true);
                    self.ray.step(length, steps);
                    continue;
                }
            }
            self.means[steps.len] = f32::NAN;
            match self.map.at(block) {
                Node::Clear(level) => self.ray.leap(node(block, level)),
                Node::Homogeneous(level) => self.ray.step(self.ray.to_exit(node(block, level)).max(self.step), steps),
                Node::Mixed => self.ray.step(self.step, steps),
            }
        }
        steps.len > 0
    }

    /// Returns the values of the last run's steps that stand for samples, NaN for those that do not; `None` if none does.
    pub(crate) fn means(&self) -> Option<&[f32; RUN]> {
        self.has_means.then_some(&self.means)
    }
}

/// Returns the faces of the node of 2^level blocks an edge around a block.
fn node(block: [usize; 3], level: u32) -> impl Fn(usize) -> [f64; 2] {
    move |a| {
        let first = block[a] >> level << level;
        [first as f64, (first + (1 << level)) as f64]
    }
}
