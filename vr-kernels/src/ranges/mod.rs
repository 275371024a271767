//! Ranges of the field of a grid, block by block.

mod blocks;
mod levels;

pub use blocks::{BlockRange, RangeBlocks};
pub use levels::LevelRanges;
