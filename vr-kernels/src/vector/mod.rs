//! Vector code that several renderers share: sixteen numbers at once, on whatever vectors the machine has.
//!
//! No bit of a result depends on the instructions: nothing is fused, and logarithm and exponential are our own. What is not inlined loses its
//! instructions in silence; so all here is, and must be called from where a level's instructions are on ([`run`]).

mod any_field;
mod chords;
mod elementary;
mod field;
mod lanes;
mod level;
mod modulation;
mod operator;
mod rows;
mod segments;
mod shade;
mod stencils;
mod sums;
mod surroundings;
mod table;
mod taps;
mod uneven_gradient;
mod voxel_colors;
mod wide_field;

pub use any_field::{AnyField, ByType};
pub use chords::Chords;
pub use elementary::{
    depth_of_opacity, exp, ln, opacity_of_depth, source_weight, source_weight_and_opacity, step_of_thickness,
};
pub use field::{Cells, Field, Pairs, Stage, TwoRows, cells, inside};
pub use lanes::Lanes;
pub use level::{Vectorized, baseline, run};
pub use modulation::{Modulation, RowMixture, StepOptics};
pub use operator::Operator;
pub use rows::{packed, packed_rows, rows_at, rows_of, transpose, transpose_packed};
pub use segments::SegmentTable;
pub use shade::{PacketLight, PacketLights, PacketShading, SeenLights, Shade, central_differences, power_of, reflect};
pub use stencils::Stencils;
pub use sums::{Sums, share_of_half, share_to_level};
pub use surroundings::Surroundings;
pub use table::{OpticsTable, Rows, TablePlaces, step_light};
pub use taps::AxisWeights;
pub use voxel_colors::VoxelColors;
pub use wide_field::{BlockStage, Blocks, Offsets, WideField};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

/// Number of lanes: those of the widest vector.
pub const LANES: usize = 16;

/// The same number in all lanes.
#[inline(always)]
pub fn splat<S: Simd>(simd: S, x: f32) -> f32x16<S> {
    f32x16::splat(simd, x)
}

/// `a` where the mask is set, `b` elsewhere.
#[inline(always)]
pub fn pick<S: Simd>(mask: mask32x16<S>, a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    mask.select(a, b)
}
