//! Index of the triangles of a mesh, by which rays find them.

use glam::DVec3;

use crate::box_tree::{Bounds, BoxTree, LocalLine};
use crate::ray::Ray;
use crate::triangle_mesh::TriangleMesh;

/// A tree of boxes around the triangles of a mesh: it tells which of them a ray may meet, the nearer ones first.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Ray, TriangleIndex, TriangleMesh};
///
/// let mesh = TriangleMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]])?;
/// let index = TriangleIndex::new(&mesh);
/// let mut visited = Vec::new();
/// let ray = Ray { origin: DVec3::new(0.2, 0.2, 5.0), direction: DVec3::NEG_Z };
/// index.visit(&ray, [0.0, f64::INFINITY], |triangle| {
///     visited.push(triangle);
///     None
/// });
/// assert_eq!(visited, [0]);
/// # Ok::<(), vr_core::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TriangleIndex {
    tree: BoxTree,
}

impl TriangleIndex {
    /// The index of a mesh. It depends on the mesh alone, not on the number of threads.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let bounds = |triangle: usize| {
            let [a, b, c] = mesh.corners(triangle);
            Bounds { low: a.min(b).min(c), high: a.max(b).max(c) }
        };
        let key = |triangle: usize| {
            let Bounds { low, high } = bounds(triangle);
            (0.5 * low + 0.5 * high, 0.5 * (high - low).length())
        };
        Self { tree: BoxTree::new(mesh.triangles().len(), mesh.bounds(), key, bounds) }
    }

    /// Visits every triangle that a ray may meet between two world distances, and a few others. A visit may tell the distance of a hit: from then on,
    /// triangles that are farther may be left out.
    pub fn visit(&self, ray: &Ray, between: [f64; 2], visit: impl FnMut(usize) -> Option<f64>) {
        let origin: DVec3 = ray.origin - self.tree.middle();
        self.tree.nearest_along(&LocalLine { origin, direction: ray.direction, ends: between }, visit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_many_is_found() {
        // Weyl's sequences are spread enough.
        let mut state = 0.5f64;
        let mut number = move || {
            state = (state * 997.618_033_988_75 + 0.414_213_562_37).fract();
            state
        };
        let mut place = |size: f64| DVec3::new(number(), number(), number()) * size;
        let mut positions = Vec::new();
        for i in 0..300 {
            let corner = place(1.0);
            // A few large ones among many small ones.
            let size = if i % 50 == 0 { 1.0 } else { 0.1 };
            positions.extend([corner, corner + place(size), corner + place(size)]);
        }
        let triangles: Vec<[u32; 3]> = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh::new(positions, triangles).unwrap();
        let index = TriangleIndex::new(&mesh);
        // Cramer's rule, for all triangles alike.
        let distance = |ray: &Ray, triangle: usize| {
            let [a, b, c] = mesh.corners(triangle);
            let matrix = glam::DMat3::from_cols(b - a, c - a, -ray.direction);
            let [u, v, t] = (matrix.inverse() * (ray.origin - a)).to_array();
            (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
        };
        let (mut hits, mut visits) = (0, 0);
        for _ in 0..500 {
            let origin = place(3.0) - 1.0;
            let ray = Ray { origin, direction: (place(1.0) - origin).normalize() };
            let expected = (0..300).filter_map(|i| distance(&ray, i)).fold(f64::INFINITY, f64::min);
            let mut found = f64::INFINITY;
            index.visit(&ray, [0.0, f64::INFINITY], |triangle| {
                visits += 1;
                let hit = distance(&ray, triangle)?;
                found = found.min(hit);
                Some(hit)
            });
            assert_eq!(found, expected);
            hits += usize::from(found.is_finite());
        }
        assert!(hits > 50 && visits < 500 * 150, "{hits} {visits}");
    }
}
