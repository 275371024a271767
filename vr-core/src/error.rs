//! Errors of the parts of a scene, and of a render.

use crate::cancel::{Cancelled, Stopped};
use crate::memory::MemoryError;
use crate::unsupported::Unsupported;

/// An error of a uniform grid.
///
/// # Examples
/// ```
/// use vr_core::{Calibration, GridError, Placement, UniformGrid};
///
/// let placement = Placement::from_spacing([1.0; 3])?;
/// let error = UniformGrid::new([2, 2, 2], vec![0u8; 7], placement, Calibration::default()).unwrap_err();
/// assert_eq!(error, GridError::Length { dims: [2; 3], expected: 8, found: 7 });
/// assert_eq!(error.to_string(), "dims [2, 2, 2]: found 7 values, must be 8, the product of the dims");
/// # Ok::<(), GridError>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// Too few voxels on an axis, or too many altogether.
    #[error("dims {dims:?}: every axis must have 2 to 2147483647 voxels, and their product must fit in memory")]
    Dims {
        /// Voxels along x, y, z.
        dims: [usize; 3],
    },
    /// Data that do not fill the grid.
    #[error("dims {dims:?}: found {found} values, must be {expected}, the product of the dims")]
    Length {
        /// Voxels along x, y, z.
        dims: [usize; 3],
        /// Their product.
        expected: usize,
        /// Number of values given.
        found: usize,
    },
    /// A spacing that is not positive and finite, or beyond what arithmetic can keep.
    #[error("spacing of axis {axis}: found {found}, must be positive and finite, 1e-24 to 1e24")]
    Spacing {
        /// 0, 1 or 2.
        axis: usize,
        /// The number found.
        found: f64,
    },
    /// A direction matrix that is singular or not finite.
    #[error(
        "direction matrix with columns {axes:?} is singular: the three axes must be linearly independent and finite"
    )]
    Direction {
        /// Its columns.
        axes: [[f64; 3]; 3],
    },
    /// An origin that is not finite, or so far away that positions in f64 do not tell points of a voxel apart.
    #[error(
        "origin {found:?}: must be finite, and at most 1e12 steps (of the smallest spacing) from the world's origin"
    )]
    Origin {
        /// The origin found.
        found: [f64; 3],
    },
    /// A calibration that cannot be inverted.
    #[error("calibration slope {slope}, intercept {intercept}: both must be finite and the slope not 0")]
    Calibration {
        /// Value per stored unit.
        slope: f64,
        /// Value of stored 0.
        intercept: f64,
    },
}

/// An error of a triangle mesh.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{MeshError, TriangleMesh};
///
/// let error = TriangleMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[1, 2, 3]]).unwrap_err();
/// assert_eq!(error, MeshError::Vertex { triangle: 0, found: 3, vertices: 3 });
/// assert_eq!(error.to_string(), "triangle 0: found vertex 3; there are 3, counted from 0");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangles.
    #[error("found no triangle: a surface must have at least one")]
    Empty,
    /// More triangles than can be counted in 32 bits.
    #[error("found {found} triangles: a surface may have at most 4294967295")]
    TooMany {
        /// Number found.
        found: usize,
    },
    /// A position that is not finite, or too far away.
    #[error("vertex {vertex}: found the position {found:?}; coordinates must be finite and smaller than 1e100")]
    Position {
        /// Number of the vertex, from 0.
        vertex: usize,
        /// Its position.
        found: [f64; 3],
    },
    /// A triangle that names a vertex that the mesh does not have.
    #[error("triangle {triangle}: found vertex {found}; there are {vertices}, counted from 0")]
    Vertex {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// Number of the vertex that it names.
        found: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Normals or colours that are not one for each vertex.
    #[error("found {found} {what} for {vertices} vertices: each must have one")]
    Length {
        /// Name of the list that is too long or too short.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A colour that is negative or not finite.
    #[error("vertex {vertex}: found the colour {found:?}, must be finite and not negative")]
    Color {
        /// Number of the vertex, from 0.
        vertex: usize,
        /// Its colour.
        found: [f32; 3],
    },
}

/// An error of scattered points.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{PointError, PointKernel, PointSet};
///
/// let error = PointSet::new(vec![DVec3::ZERO], vec![-1.0], vec![1.0], vec![1.0], PointKernel::Cone).unwrap_err();
/// assert_eq!(error, PointError::Radius { point: 0, found: -1.0 });
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PointError {
    /// No points.
    #[error("found no point: there must be at least one")]
    Empty,
    /// More points than can be counted in 32 bits.
    #[error("found {found} points: there may be at most 4294967295")]
    TooMany {
        /// Number found.
        found: usize,
    },
    /// Radii, weights, values or colours that are not one for each point.
    #[error("found {found} {what} for {points} points: each must have one")]
    Length {
        /// Name of the list that is too long or too short.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Number of points.
        points: usize,
    },
    /// A position that is not finite, or too far away.
    #[error("point {point}: found the position {found:?}; coordinates must be finite and smaller than 1e30")]
    Position {
        /// Number of the point, from 0.
        point: usize,
        /// Its position.
        found: [f64; 3],
    },
    /// A radius that is not positive, too small or too large.
    #[error("point {point}: found the radius {found}, must be between 1e-30 and 1e30")]
    Radius {
        /// Number of the point, from 0.
        point: usize,
        /// Its radius.
        found: f32,
    },
    /// A weight that a mean cannot divide by.
    #[error(
        "point {point}: found the weight {found}, must be positive where values or colours are mixed by a weighted mean"
    )]
    Weight {
        /// Number of the point, from 0.
        point: usize,
        /// Its weight.
        found: f32,
    },
    /// A colour that is not one.
    #[error("point {point}: found the colour {found:?}, must be linear light between 0 and 1")]
    Color {
        /// Number of the point, from 0.
        point: usize,
        /// Its red, green and blue.
        found: [f32; 3],
    },
    /// A weight or value that is not finite.
    #[error("point {point}: found the {what} {found}, must be finite")]
    Number {
        /// `weight` or `value`.
        what: &'static str,
        /// Number of the point, from 0.
        point: usize,
        /// The number.
        found: f32,
    },
}

/// A value of a scene or view that is out of range: the field, the value found, and the allowed values.
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// let points = vec![ControlPoint::new(0.0, [1.0; 3], 1.5)];
/// let error = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap_err();
/// assert_eq!(error.field, "transfer.points[0].opacity");
/// assert_eq!(error.to_string(), "transfer.points[0].opacity: found 1.5; must be in [0, 1]");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field}: found {found}; {allowed}")]
pub struct ParameterError {
    /// The field, as scene files name it: `camera.up`, `transfer.points[3].opacity`.
    pub field: String,
    /// The value found.
    pub found: String,
    /// Values that would be right.
    pub allowed: &'static str,
}

impl ParameterError {
    /// A wrong value in a field.
    pub fn new(field: impl Into<String>, found: impl std::fmt::Debug, allowed: &'static str) -> Self {
        Self { field: field.into(), found: format!("{found:?}"), allowed }
    }
}

/// Reason why there is no picture.
///
/// # Examples
/// ```
/// use vr_core::{Feature, ParameterError, RenderError, Unsupported};
///
/// fn advice(error: &RenderError) -> &'static str {
///     match error {
///         RenderError::Unsupported(_) => "choose another renderer",
///         RenderError::Parameter(_) | RenderError::Option(_) => "correct the value",
///         _ => "try again",
///     }
/// }
/// let perspective = Unsupported { renderer: "slicer", feature: Feature::Perspective, what: "perspective".into() };
/// assert_eq!(advice(&perspective.into()), "choose another renderer");
/// assert_eq!(advice(&ParameterError::new("image.size", [0, 9], "must be positive").into()), "correct the value");
/// ```
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// This renderer cannot draw what the scene or the view asks for.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// A camera, a clip plane, a size… out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Settings of the renderer that are out of range or do not go together.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The caller set the cancel flag.
    #[error("cancelled")]
    Cancelled,
    /// Too little memory for what is derived from the volume.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// Too little memory for what the caller asked.
    #[error("{what} needs {bytes} bytes, more than the limit of {limit}")]
    TooLarge {
        /// Name of the memory that would have been allocated.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// Largest size that is allowed.
        limit: u64,
    },
}

impl From<Cancelled> for RenderError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<Stopped> for RenderError {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Cancelled(cancelled) => cancelled.into(),
            Stopped::Memory(refused) => refused.into(),
        }
    }
}

/// An option that a renderer does not have, or a value that it does not take.
///
/// # Examples
/// ```
/// use vr_core::{DeclaredOption, OptionError, OptionTable, Options};
///
/// #[derive(Clone, Default)]
/// struct Marcher { skip: bool }
/// let skip = DeclaredOption::switch("skip", "leave out what is empty", |m: &Marcher| m.skip, |m, on| m.skip = on);
/// let table = OptionTable::new("marcher", [skip]);
/// let error = table.configure(&Marcher::default(), &Options::new().with("skipp", true)).err().unwrap();
/// assert!(matches!(&error, OptionError::Unknown { nearest: Some("skip"), .. }));
/// assert_eq!(error.to_string(), "renderer marcher has no option 'skipp'; did you mean 'skip'?");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionError {
    /// No option of this name.
    #[error("renderer {renderer} has no option '{key}'{}", hint(.nearest))]
    Unknown {
        /// Name of the renderer.
        renderer: &'static str,
        /// The name given.
        key: String,
        /// The known name nearest to it.
        nearest: Option<&'static str>,
    },
    /// A value of the wrong type or out of range.
    #[error("option '{key}' of renderer {renderer}: found {found}; {allowed}")]
    Value {
        /// Name of the renderer.
        renderer: &'static str,
        /// The option.
        key: String,
        /// The value given.
        found: String,
        /// Values that would be right.
        allowed: String,
    },
}

fn hint(nearest: &Option<&'static str>) -> String {
    nearest.map_or_else(String::new, |n| format!("; did you mean '{n}'?"))
}
