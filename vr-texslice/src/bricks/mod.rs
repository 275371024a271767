//! The volume in bricks: textures of some cells each, with the layer of texels that neighbours share, kept within a budget.

mod brick;
mod lattice;
mod pool;

pub(crate) use brick::{BrickKey, BrickSource};
pub(crate) use lattice::BrickLattice;
pub(crate) use pool::Pool;
