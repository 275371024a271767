//! The vector engine: packets of sixteen rays, one a lane, on whatever vectors the machine has.

mod elementary;
mod engine;
mod field;
mod lanes;
mod leap;
mod level;
mod local;
mod march;
mod setup;
mod shade;
mod sums;
mod table;

pub(crate) use engine::{PacketEngine, PacketFrame};
pub(crate) use shade::PacketShading;
