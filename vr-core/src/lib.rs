//! Stub.
mod central_differences;
pub mod error;
pub mod filter;
mod grid;
mod missing;
pub mod optics;
pub mod phantom;
mod placement;
mod range_blocks;
mod real;
mod sampler;
pub mod transfer;
mod volume;
mod voxel;

pub use central_differences::{gradient_at_sample, gradient_between_samples};
pub use error::{GridError, OptionError, ParameterError, RenderError};
pub use filter::Filter;
pub use grid::{Calibration, Census, UniformGrid, sample_count};
pub use missing::VacuumCells;
pub use placement::Placement;
pub use range_blocks::{BlockRange, RangeBlocks};
pub use real::Real;
pub use sampler::Sampler;
pub use transfer::{ControlPoint, OpacityRule, TransferFunction};
pub use volume::{AnyGrid, Geometry, LatticeVisitor, SamplerVisitor, UniformVolume, Volume};
pub use voxel::{Voxel, VoxelType};
