//! Stages of fragments: fetched from a texture, classified, blended.

mod blend;
mod brick_fetcher;
mod bricks;
mod chunk;
mod classify;
mod march;
mod picture;
mod state;
mod steepness;
mod step;
mod tiles;
mod waiting;
mod whole_slices;

pub(crate) use bricks::Bricked;
pub(crate) use chunk::{Chunk, SampleSet};
pub(crate) use classify::Classifier;
pub(crate) use march::Pass;
pub(crate) use state::State;
pub(crate) use steepness::Steepness;
pub(crate) use tiles::{PacketScene, Pixel, draw_tiles};
pub(crate) use whole_slices::draw_slices;
