//! Walks: how the part of a ray inside the volume is cut into steps. One small file each.

mod lattice;
mod local;
mod vicinity;
mod visible_steps;

pub(crate) use lattice::{Lattice, LatticeWalk};
pub(crate) use local::LocalWalk;
pub(crate) use vicinity::{Vicinity, VicinityFlags};
pub(crate) use visible_steps::VisibleSteps;

use crate::run::Steps;

/// A walk along one ray.
pub(crate) enum Walk<'a> {
    /// Steps of one length, but for those in which nothing is visible.
    Lattice(LatticeWalk<'a>),
    /// Steps as long as what is in each place allows.
    Local(LocalWalk<'a>),
}

impl Walk<'_> {
    /// Fills the next run; false where the walk is at its end.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        match self {
            Self::Lattice(walk) => walk.next(steps),
            Self::Local(walk) => walk.next(steps),
        }
    }

    /// Steps left out so far because nothing in them is visible; 0 where nobody knows how many there would have been.
    pub(crate) fn skipped(&self) -> u64 {
        match self {
            Self::Lattice(walk) => walk.skipped(),
            Self::Local(_) => 0,
        }
    }
}
