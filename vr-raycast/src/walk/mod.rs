//! Walks: how the part of a ray inside the volume is cut into steps. One small file each.

mod lattice;
mod local;

pub(crate) use lattice::{Lattice, LatticeWalk};
pub(crate) use local::LocalWalk;

use crate::run::Steps;

/// A walk along one ray.
#[derive(Clone, Debug)]
pub(crate) enum Walk<'a> {
    /// Steps of one length.
    Lattice(LatticeWalk),
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
}
