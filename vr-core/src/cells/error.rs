//! Errors of a mesh of cells.

/// An error of a mesh of cells.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::cells::{CellError, CellMesh, CellValues};
///
/// let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
/// let error = CellMesh::new(vertices, vec![[0, 1, 2, 3]], CellValues::Vertices(vec![0.0; 3])).unwrap_err();
/// assert_eq!(error, CellError::Vertex { cell: 0, found: 3, vertices: 3 });
/// assert_eq!(error.to_string(), "cell 0: found vertex 3; there are 3, counted from 0");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CellError {
    /// No cell, or none that has a volume and finite values.
    #[error("found no cell with a volume and finite values among {found}: a mesh must have at least one")]
    Empty {
        /// Number of cells given.
        found: usize,
    },
    /// More cells or vertices than can be counted.
    #[error("found {found} {what}: a mesh may have at most 4294967294")]
    TooMany {
        /// `cells` or `vertices`.
        what: &'static str,
        /// Number found.
        found: usize,
    },
    /// A position that is not finite, or too far away.
    #[error("vertex {vertex}: found the position {found:?}; coordinates must be finite and smaller than 1e30")]
    Position {
        /// Number of the vertex, from 0.
        vertex: usize,
        /// Its position.
        found: [f64; 3],
    },
    /// A cell that names a vertex that the mesh does not have.
    #[error("cell {cell}: found vertex {found}; there are {vertices}, counted from 0")]
    Vertex {
        /// Number of the cell, from 0.
        cell: usize,
        /// Number of the vertex that it names.
        found: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Values that are not one for each vertex or cell.
    #[error("found {found} values for {expected} {what}: each must have one")]
    Length {
        /// `cells` or `vertices`.
        what: &'static str,
        /// Number found.
        found: usize,
        /// Number of cells or vertices.
        expected: usize,
    },
    /// Cells that lie so far from the world's origin, beside their size, that positions in f64 do not tell their corners apart, or whose size is beyond
    /// what arithmetic can keep.
    #[error(
        "cells of the mean size {size}: must be 1e-24 to 1e24, and the mesh at most 1e12 such sizes from the world's origin"
    )]
    Size {
        /// Mean edge of a cube of six cells.
        size: f64,
    },
}
