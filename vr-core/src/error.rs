//! What can be wrong with the parts of a scene, and with a render.

use crate::unsupported::Unsupported;

/// A grid that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// Too few samples on an axis, or too many altogether.
    #[error("dims {dims:?}: every axis needs 2 to 2147483647 samples, and their product must fit in memory")]
    Dims {
        /// Samples along x, y, z.
        dims: [usize; 3],
    },
    /// Data that do not fill the grid.
    #[error("dims {dims:?} need {expected} samples, found {found}")]
    Length {
        /// Samples along x, y, z.
        dims: [usize; 3],
        /// Their product.
        expected: usize,
        /// Samples given.
        found: usize,
    },
    /// A spacing that is not positive and finite, or beyond what arithmetic can keep.
    #[error("spacing of axis {axis} is {found}: must be positive and finite, 1e-24 to 1e24")]
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

/// A surface that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangles.
    #[error("no triangle: a surface needs one at least")]
    Empty,
    /// More triangles than can be counted in 32 bits.
    #[error("{found} triangles: there may be 4294967295")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// A position that is not finite, or too far away.
    #[error("vertex {vertex} is at {found:?}: coordinates must be finite and smaller than 1e100")]
    Position {
        /// Which vertex, from 0.
        vertex: usize,
        /// Its position.
        found: [f64; 3],
    },
    /// A triangle of a vertex that there is not.
    #[error("triangle {triangle} has vertex {found}: there are {vertices}, counted from 0")]
    Vertex {
        /// Which triangle, from 0.
        triangle: usize,
        /// Its vertex.
        found: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// Normals or colours that are not one for each vertex.
    #[error("{found} {what} for {vertices} vertices: each must have one")]
    Length {
        /// What there are more or fewer of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A colour that is none.
    #[error("vertex {vertex} has the colour {found:?}: must be finite and not negative")]
    Color {
        /// Which vertex, from 0.
        vertex: usize,
        /// Its colour.
        found: [f32; 3],
    },
}

/// Scattered points that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PointError {
    /// No points.
    #[error("no point: there must be one at least")]
    Empty,
    /// More points than can be counted in 32 bits.
    #[error("{found} points: there may be 4294967295")]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// Radii, weights or values that are not one for each point.
    #[error("{found} {what} for {points} points: each must have one")]
    Length {
        /// What there are more or fewer of.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many points there are.
        points: usize,
    },
    /// A position that is not finite, or too far away.
    #[error("point {point} is at {found:?}: coordinates must be finite and smaller than 1e30")]
    Position {
        /// Which point, from 0.
        point: usize,
        /// Its position.
        found: [f64; 3],
    },
    /// A radius that is none.
    #[error("point {point} has the radius {found}: must be positive, between 1e-30 and 1e30")]
    Radius {
        /// Which point, from 0.
        point: usize,
        /// Its radius.
        found: f32,
    },
    /// A weight or value that is not finite.
    #[error("point {point} has the {what} {found}: must be finite")]
    Number {
        /// `weight` or `value`.
        what: &'static str,
        /// Which point, from 0.
        point: usize,
        /// The number.
        found: f32,
    },
}

/// A part of a scene or view that makes no sense: which field, what was found, what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{field}: found {found}; {allowed}")]
pub struct ParameterError {
    /// The field, as scene files name it: `camera.up`, `transfer.points[3].opacity`.
    pub field: String,
    /// The value found.
    pub found: String,
    /// What would be right.
    pub allowed: &'static str,
}

impl ParameterError {
    /// A wrong value in a field.
    pub fn new(field: impl Into<String>, found: impl std::fmt::Debug, allowed: &'static str) -> Self {
        Self { field: field.into(), found: format!("{found:?}"), allowed }
    }
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// This renderer cannot draw what the scene or the view asks for.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// A camera, a clip plane, a size… that makes no sense.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// Settings of the renderer that make no sense.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// Somebody set the cancel flag.
    #[error("cancelled")]
    Cancelled,
    /// Too little memory for what was asked.
    #[error("{what} needs {bytes} bytes, more than the limit of {limit}")]
    TooLarge {
        /// What would have been allocated.
        what: &'static str,
        /// Its size.
        bytes: u64,
        /// The most that is allowed.
        limit: u64,
    },
}

/// An option that a renderer does not have, or a value that it does not take.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionError {
    /// No option of this name.
    #[error("renderer {renderer} has no option '{key}'{}", hint(.nearest))]
    Unknown {
        /// Which renderer.
        renderer: &'static str,
        /// The name given.
        key: String,
        /// The known name most like it.
        nearest: Option<&'static str>,
    },
    /// A value of the wrong type or out of range.
    #[error("option '{key}' of renderer {renderer}: found {found}; {allowed}")]
    Value {
        /// Which renderer.
        renderer: &'static str,
        /// The option.
        key: String,
        /// The value given.
        found: String,
        /// What is allowed.
        allowed: String,
    },
}

fn hint(nearest: &Option<&'static str>) -> String {
    nearest.map_or_else(String::new, |n| format!("; did you mean '{n}'?"))
}
