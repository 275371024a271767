//! Types that all volume renderers here share: volumes and the filters that make fields of them, transfer functions and their
//! optics, cameras and rays, and the interface of renderers.
//!
//! A scene is drawn in four steps: a [`Volume`] and a [`TransferFunction`] make a [`Scene`]; a [`Renderer`] prepares it; the
//! [`Prepared`] scene renders a [`View`]; out comes a [`Frame`]. The correct pixel is defined once:
//!
//! * a [`UniformGrid`] has its voxels at lattice points and fills the box from the first to the last one; outside is vacuum;
//! * the field is what its [`Filter`] reconstructs from the voxels, in calibrated values;
//! * the transfer function turns a value into extinction κ and emission q, and a pixel is ∫ q e^(−τ) ds with α = 1 − e^(−τ)
//!   along the ray through its centre, in premultiplied linear light and without the background.
//!
//! A volume may as well be scattered points ([`PointSet`]): the field is the sum of what their kernels spread, and vacuum is where no
//! support reaches.
//!
//! # Example
//! A homogeneous slab of four unit distances, along one ray:
//! ```
//! use vr_core::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let placement = Placement::from_spacing([1.0, 1.0, 2.0])?;
//! let grid = UniformGrid::new([2, 2, 3], vec![7u8; 12], placement, Calibration::default())?;
//! let opacity = 0.1; // of one unit distance
//! let transfer = TransferFunction::new(vec![ControlPoint::new(0.0, [1.0; 3], opacity)], OpacityRule::Power, 1.0)?;
//! let scene = Scene::new(Volume::from(grid), transfer);
//!
//! let camera = Camera::framing(scene.volume.bounds(), 0.0, 0.0, None);
//! let ray = Rays::new(&View::new(camera, [1, 1]))?.at(0.5, 0.5);
//! let grid = scene.volume.grid().expect("it is one");
//! let inside = IndexRay::new(&ray, grid.placement(), grid.dims(), &Clip::default(), f64::INFINITY).expect("it hits");
//! let tau = scene.transfer.extinction_at(7.0) * inside.length();
//! let alpha = optics::opacity_of_depth(tau);
//! assert!((alpha - (1.0 - 0.9f64.powi(4))).abs() < 1e-15);
//! # Ok(())
//! # }
//! ```
//!
//! # Features
//! * `serde`: the values that scene files and reports hold (words, options, control points, clipping), with serde.

pub mod amr;
mod any_grid;
pub mod bound;
mod box_tree;
mod camera;
pub mod cancel;
pub mod cells;
mod central_differences;
mod classification;
mod clip_error;
pub mod clock;
mod color_grid;
mod compositing;
mod configurable;
mod control;
mod derived;
mod documented;
mod error;
pub mod field;
pub mod filter;
mod floor;
mod frame;
mod grid;
mod grid_volume;
pub mod image_order;
pub mod labels;
mod lazy;
mod limits;
pub mod memory;
mod missing;
mod model;
mod number_text;
pub mod optics;
mod option_table;
mod options;
pub mod parallel;
pub mod phantom;
mod placement;
mod point_field;
mod point_kernel;
mod point_mean;
mod point_mixing;
mod point_set;
mod probe;
mod ray;
mod real;
pub mod rectilinear;
mod renderer;
pub mod resample;
mod sampler;
pub mod scattering;
mod scene;
mod shading;
mod stats;
mod stored_at;
mod stretch;
mod surfaces;
pub mod transfer;
mod triangle_index;
mod triangle_mesh;
pub mod turning;
mod uncertainty;
mod unsupported;
mod value_frame;
mod view;
mod volume;
mod voxel;

pub use amr::AmrGrid;
pub use any_grid::AnyGrid;
pub use camera::{Camera, Projection};
pub use cells::CellMesh;
pub use central_differences::{gradient_and_turn, gradient_at_sample, gradient_between_samples};
pub use classification::Classification;
pub use color_grid::{ColorGrid, ColorValue};
pub use compositing::Compositing;
pub use configurable::{Configurable, StudiedRenderer};
pub use control::{Control, ThreadError};
pub use derived::Derived;
pub use documented::{ConvergenceClaim, ConvergenceOrders, Documented, DocumentedError, HardCaseErrors, NamedSetting};
pub use error::{GridError, MeshError, OptionError, ParameterError, PointError, RenderError};
pub use field::Field;
pub use filter::Filter;
pub use frame::Frame;
pub use grid::{Calibration, UniformGrid, ValueStats, sample_count};
pub use grid_volume::{GridVolume, LatticeVisitor, SamplerVisitor};
pub use missing::VacuumCells;
pub use model::{ContinuousModel, DiscreteModel, Medium, MediumBounds, Model, SegmentTerm};
pub use number_text::number_text;
pub use option_table::{DeclaredOption, OptionTable};
pub use options::{NumberRange, OptionKind, OptionSpec, OptionValue, Options};
pub use placement::Placement;
pub use point_field::{PointCrossing, PointCrossings};
pub use point_kernel::PointKernel;
pub use point_mixing::PointMixing;
pub use point_set::PointSet;
pub use probe::{Probe, ProbedSample, ProbedStep};
pub use ray::{IndexRay, Ray, RayPacket, Rays};
pub use real::Real;
pub use rectilinear::RectilinearGrid;
pub use renderer::{DrawnPixels, MIN_MAX_ERROR, Prepared, Rendered, Renderer};
pub use sampler::Sampler;
pub use scene::{MaxRadiance, Scene};
pub use shading::{GradientMethod, Light, RayLight, RayShading, Shading, factor_at};
pub use stats::{Counts, RenderStats};
pub use surfaces::{FacetHit, Layer, SurfaceTracer, Surfaces};
pub use transfer::{ControlPoint, OpacityRule, TransferFunction};
pub use triangle_index::TriangleIndex;
pub use triangle_mesh::TriangleMesh;
pub use uncertainty::Uncertainty;
pub use unsupported::{Feature, Unsupported};
pub use value_frame::ValueFrame;
pub use view::{Clip, Plane, View};
pub use volume::Volume;
pub use voxel::{Voxel, VoxelType};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
