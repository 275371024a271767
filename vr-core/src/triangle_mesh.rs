//! Surfaces: triangles in the world that share vertices.

use glam::DVec3;

use crate::error::MeshError;

/// A surface of triangles in the world, open or closed; only its numbers are checked, not its topology.
///
/// A mesh has at least one triangle. A triangle without area is allowed and invisible.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::TriangleMesh;
///
/// let square = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let mesh = TriangleMesh::new(square, vec![[0, 1, 2], [0, 2, 3]])?.with_colors(vec![[1.0, 0.0, 0.0]; 4])?;
/// assert_eq!(mesh.triangles().len(), 2);
/// assert!(mesh.normals().is_none());
/// # Ok::<(), vr_core::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    colors: Option<Vec<[f32; 3]>>,
}

/// Upper bound of coordinates, so that products of three of them are finite.
const MAX_COORDINATE: f64 = 1e100;

impl TriangleMesh {
    /// A surface of vertices at world positions, and triangles of three vertices each, counted from 0.
    ///
    /// # Errors
    /// A position that is not finite, or beyond 10¹⁰⁰; a triangle that names a vertex that there is not; no triangle, or 2³² of them or more.
    pub fn new(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        if u32::try_from(triangles.len()).is_err() {
            return Err(MeshError::TooMany { found: triangles.len() });
        }
        let wrong = |p: &DVec3| !p.abs().cmplt(DVec3::splat(MAX_COORDINATE)).all();
        if let Some(vertex) = positions.iter().position(wrong) {
            return Err(MeshError::Position { vertex, found: positions[vertex].to_array() });
        }
        let missing = |&v: &u32| v as usize >= positions.len();
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&found) = corners.iter().find(|v| missing(v)) {
                return Err(MeshError::Vertex { triangle, found, vertices: positions.len() });
            }
        }
        Ok(Self { positions, triangles, normals: None, colors: None })
    }

    /// The same with a normal at each vertex, of any length, to be interpolated in between. A normal that is zero or not finite
    /// counts as absent.
    ///
    /// # Errors
    /// More or fewer normals than vertices.
    pub fn with_normals(self, normals: Vec<[f32; 3]>) -> Result<Self, MeshError> {
        self.one_each("normals", normals.len())?;
        Ok(Self { normals: Some(normals), ..self })
    }

    /// The same with a colour at each vertex, in linear RGB, to be interpolated in between.
    ///
    /// # Errors
    /// More or fewer colours than vertices; a component that is negative or not finite.
    pub fn with_colors(self, colors: Vec<[f32; 3]>) -> Result<Self, MeshError> {
        self.one_each("colours", colors.len())?;
        let wrong = |c: &[f32; 3]| c.iter().any(|&x| !(x >= 0.0 && x.is_finite()));
        if let Some(vertex) = colors.iter().position(wrong) {
            return Err(MeshError::Color { vertex, found: colors[vertex] });
        }
        Ok(Self { colors: Some(colors), ..self })
    }

    fn one_each(&self, what: &'static str, found: usize) -> Result<(), MeshError> {
        let vertices = self.positions.len();
        if found == vertices { Ok(()) } else { Err(MeshError::Length { what, found, vertices }) }
    }

    /// World positions of the vertices.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The vertices of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// A normal at each vertex, where there are any.
    pub fn normals(&self) -> Option<&[[f32; 3]]> {
        self.normals.as_deref()
    }

    /// A colour at each vertex in linear RGB, where there are any.
    pub fn colors(&self) -> Option<&[[f32; 3]]> {
        self.colors.as_deref()
    }

    /// World positions of a triangle's corners.
    ///
    /// # Panics
    /// Panics if there is no such triangle.
    #[inline]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.positions[v as usize])
    }

    /// Lower and upper corner of the world box around the triangles.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let corners = self.triangles.iter().flatten().map(|&v| self.positions[v as usize]);
        corners.fold(none, |(low, high), p| (low.min(p), high.max(p)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Vec<DVec3> {
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::splat(9.0)]
    }

    #[test]
    fn bounds_are_those_of_the_triangles() {
        let mesh = TriangleMesh::new(corner(), vec![[0, 1, 2]]).unwrap();
        assert_eq!(mesh.bounds(), (DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0)), "vertex 3 is of no triangle");
    }

    #[test]
    fn refuses_what_makes_no_surface() {
        assert_eq!(TriangleMesh::new(corner(), vec![]), Err(MeshError::Empty));
        let beyond = TriangleMesh::new(corner(), vec![[0, 1, 2], [0, 4, 1]]);
        assert_eq!(beyond, Err(MeshError::Vertex { triangle: 1, found: 4, vertices: 4 }));
        for x in [f64::NAN, f64::NEG_INFINITY, 1e101] {
            let wrong = TriangleMesh::new(vec![DVec3::ZERO, DVec3::new(0.0, x, 0.0)], vec![[0, 0, 1]]);
            assert!(matches!(wrong, Err(MeshError::Position { vertex: 1, .. })), "{wrong:?}");
        }
        let mesh = TriangleMesh::new(corner(), vec![[0, 1, 2]]).unwrap();
        assert!(matches!(mesh.clone().with_normals(vec![[0.0; 3]; 3]), Err(MeshError::Length { found: 3, .. })));
        assert!(matches!(mesh.clone().with_colors(vec![[0.0; 3]; 5]), Err(MeshError::Length { found: 5, .. })));
        for x in [-0.1, f32::NAN, f32::INFINITY] {
            let colors = vec![[0.0; 3], [0.0; 3], [0.0, x, 0.0], [0.0; 3]];
            assert!(matches!(mesh.clone().with_colors(colors), Err(MeshError::Color { vertex: 2, .. })));
        }
    }
}
