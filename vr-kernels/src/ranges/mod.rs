//! Ranges of the field of a grid, block by block, and whether anything in a range of values can be seen.

mod blocks;
mod levels;
mod visibility;
mod visible_levels;

pub use blocks::{BlockRange, RangeBlocks};
pub use levels::LevelRanges;
pub use visibility::{LightVisibility, Visibility, VisibleValues};
pub use visible_levels::{Leveled, Scale, VisibleLevels};
