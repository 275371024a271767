//! Walks: how the part of a ray inside the volume is cut into steps. One small file each.

mod block_ray;
mod cells;
mod homogeneous;
mod lattice;
mod listed;
mod local;
mod vicinity;
mod visible_steps;
mod voxels;

pub(crate) use cells::cell_walk;
pub(crate) use homogeneous::HomogeneousWalk;
pub(crate) use lattice::{Lattice, LatticeWalk};
pub(crate) use listed::ListedWalk;
pub(crate) use local::LocalWalk;
pub(crate) use vicinity::{Vicinity, VicinityFlags};
pub(crate) use visible_steps::VisibleSteps;
pub(crate) use voxels::voxel_walk;

use crate::run::Steps;

/// A walk along one ray.
pub(crate) enum Walk<'a> {
    /// Steps of one length, but for those in which nothing is visible.
    Lattice(LatticeWalk<'a>),
    /// Steps as long as what is in each place allows.
    Local(LocalWalk<'a>),
    /// Cells or voxels, found beforehand.
    Listed(ListedWalk),
    /// Long steps where the medium is nearly the same.
    Homogeneous(HomogeneousWalk<'a>),
}

impl Walk<'_> {
    /// Fills the next run; false where the walk is at its end.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        match self {
            Self::Lattice(walk) => walk.next(steps),
            Self::Local(walk) => walk.next(steps),
            Self::Listed(walk) => walk.next(steps),
            Self::Homogeneous(walk) => walk.next(steps),
        }
    }

    /// Index-space positions of the last run's samples, where they do not lie on the ray.
    pub(crate) fn places(&self) -> Option<&[[f64; 3]]> {
        match self {
            Self::Lattice(_) | Self::Local(_) | Self::Homogeneous(_) => None,
            Self::Listed(walk) => walk.places(),
        }
    }

    /// Steps left out so far because nothing in them is visible; 0 where nobody knows how many there would have been.
    pub(crate) fn skipped(&self) -> u64 {
        match self {
            Self::Lattice(walk) => walk.skipped(),
            Self::Local(_) | Self::Listed(_) | Self::Homogeneous(_) => 0,
        }
    }
}
