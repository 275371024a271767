//! Walks: how the part of a ray inside the volume is cut into steps. One small file each.

mod lattice;

pub(crate) use lattice::{Lattice, LatticeWalk};

use crate::run::Steps;

/// A walk along one ray.
#[derive(Clone, Debug)]
pub(crate) enum Walk {
    /// Steps of one length.
    Lattice(LatticeWalk),
}

impl Walk {
    /// Fills the next run; false where the walk is at its end.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        match self {
            Self::Lattice(walk) => walk.next(steps),
        }
    }
}
