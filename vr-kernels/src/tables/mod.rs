//! Transfer functions in tables.

mod baked;
mod grid;
mod preintegrated;
mod range;

pub use baked::{BakedTransfer, TableError};
pub(crate) use grid::lone_walls;
pub use preintegrated::{PreIntegrated, PreIntegratedRow, TablePlace, WALL_DEPTH};
pub use range::{beyond_f32, resolves_extinction, round_outward, rounding_in_f32, rounding_over, table_range};
