//! Walks, which cut the part of a ray inside the volume into steps. One small file each.

mod block_ray;
mod cells;
mod cut;
mod lattice;
mod listed;
mod local;
mod sequence;
mod stretched;
mod visible_steps;

pub(crate) use block_ray::BlockRay;
#[cfg(feature = "classics")]
pub(crate) use cells::cell_steps;
pub(crate) use cut::{SKIN, SLIVER, cut_steps, cut_walk};
pub(crate) use lattice::{Lattice, SequenceWalk};
pub(crate) use listed::ListedWalk;
pub(crate) use sequence::StepSequence;
pub(crate) use stretched::{StretchSteps, stretched_walk};
pub(crate) use visible_steps::VisibleSteps;

use vr_core::IndexRay;

use crate::leap::Leaper;
use crate::run::Steps;
use crate::step_map::StepMap;
use cells::cell_walk;
use local::LocalWalk;

/// Steps of the rays of a frame.
pub(crate) struct Walks<'a> {
    pub(crate) kind: WalkKind<'a>,
    /// World length of a step where all are alike, or of the longest where steps end at cell faces; +∞ if they end there only.
    pub(crate) step: f64,
    /// World length of the smallest voxel edge.
    pub(crate) voxel: f64,
    pub(crate) dims: [usize; 3],
}

/// Rule that sets the lengths of steps.
pub(crate) enum WalkKind<'a> {
    /// Steps of one length, without those in which nothing is visible.
    Lattice(Option<&'a dyn Leaper>),
    /// Steps as long as the medium in each place allows.
    Local(&'a StepMap),
    /// Steps from cell to cell.
    Cells,
    /// Steps that a classic acceleration sets.
    #[cfg(feature = "classics")]
    Classic(crate::classics::WalkKind<'a>),
}

impl Walks<'_> {
    /// Begins the walk of a ray, from step `start` on. `backwards`: from its far end; `before`: steps before what is visible that are walked,
    /// too.
    pub(crate) fn along(&self, ray: IndexRay, start: u32, before: u32, backwards: bool) -> Walk<'_> {
        let &Self { ref kind, step, voxel, dims } = self;
        match *kind {
            WalkKind::Lattice(leaper) => {
                let lattice = Lattice::new(ray.start, ray.end, step);
                let visible = VisibleSteps::new(lattice, start, before, &ray, leaper);
                Walk::Lattice(SequenceWalk::new(lattice, visible, backwards))
            }
            WalkKind::Local(map) => Walk::Local(LocalWalk::new(map, ray, voxel)),
            WalkKind::Cells => Walk::Listed(cell_walk(&ray, dims, step, start, backwards)),
            #[cfg(feature = "classics")]
            WalkKind::Classic(kind) => kind.along(ray, self, start, backwards),
        }
    }
}

/// Walk along one ray.
pub(crate) enum Walk<'a> {
    /// Walk in steps of one length, without those in which nothing is visible.
    Lattice(SequenceWalk<'a, Lattice>),
    /// Steps as long as the medium in each place allows.
    Local(LocalWalk<'a>),
    /// Walk over cells or voxels, found beforehand.
    Listed(ListedWalk),
    /// Walk in long steps where the medium is nearly the same.
    #[cfg(feature = "classics")]
    Homogeneous(crate::classics::HomogeneousWalk<'a>),
    /// Walk over the steps that all rays of a view share.
    #[cfg(feature = "classics")]
    Template(crate::classics::TemplateWalk<'a>),
}

impl Walk<'_> {
    /// Fills the next run; returns false if the walk is at its end.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        match self {
            Self::Lattice(walk) => walk.next(steps),
            Self::Local(walk) => walk.next(steps),
            Self::Listed(walk) => walk.next(steps),
            #[cfg(feature = "classics")]
            Self::Homogeneous(walk) => walk.next(steps),
            #[cfg(feature = "classics")]
            Self::Template(walk) => walk.next(steps),
        }
    }

    /// Returns the index-space positions of the last run's samples, where they do not lie on the ray.
    pub(crate) fn places(&mut self) -> Option<&[[f64; 3]]> {
        match self {
            Self::Listed(walk) => walk.places(),
            #[cfg(feature = "classics")]
            Self::Template(walk) => walk.places(),
            _ => None,
        }
    }

    /// Returns values that stand for the samples of the last run's steps, NaN for steps that have none; `None` if none has.
    #[cfg(feature = "classics")]
    pub(crate) fn means(&self) -> Option<&[f32; crate::run::RUN]> {
        if let Self::Homogeneous(walk) = self { walk.means() } else { None }
    }

    /// Returns the number of steps left out so far because nothing in them is visible; 0 where it is not known.
    pub(crate) fn skipped(&self) -> u64 {
        match self {
            Self::Lattice(walk) => walk.skipped(),
            #[cfg(feature = "classics")]
            Self::Template(walk) => walk.skipped(),
            _ => 0,
        }
    }
}
