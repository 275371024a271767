//! Hexahedra and other shapes of cells, split into tetrahedra.
//!
//! A cell is split into cones from its vertex of the lowest number over the faces that do not have it, and a face into triangles from its vertex of the lowest
//! number (Dompierre, Labbé, Vallet & Camarero 1999). The triangles of a face depend on the numbers of its vertices alone, so that two cells that
//! share a face are split alike there, and no crack opens between them.

/// A shape of cell, its vertices in the order of VTK.
///
/// # Examples
/// ```
/// use vr_core::cells::split::Shape;
///
/// let mut tetrahedra = Vec::new();
/// Shape::Hexahedron.split(&[0, 1, 2, 3, 4, 5, 6, 7], &mut tetrahedra);
/// assert_eq!(tetrahedra.len(), 6);
/// assert!(tetrahedra.iter().all(|t| t.contains(&0)), "cones from the lowest vertex");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Four vertices.
    Tetrahedron,
    /// Four vertices of the base around it, and the apex.
    Pyramid,
    /// Three vertices of each of two triangles.
    Wedge,
    /// Four vertices around the lower face, then the four above them.
    Hexahedron,
    /// A box: its vertices with x fastest.
    Voxel,
}

impl Shape {
    /// Number of vertices.
    pub fn vertices(self) -> usize {
        match self {
            Self::Tetrahedron => 4,
            Self::Pyramid => 5,
            Self::Wedge => 6,
            Self::Hexahedron | Self::Voxel => 8,
        }
    }

    /// Faces, each counterclockwise seen from outside.
    fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron => &[&[1, 2, 3], &[0, 3, 2], &[0, 1, 3], &[0, 2, 1]],
            Self::Pyramid => &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            Self::Wedge => &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]],
            Self::Hexahedron => {
                &[&[0, 4, 7, 3], &[1, 2, 6, 5], &[0, 1, 5, 4], &[3, 7, 6, 2], &[0, 3, 2, 1], &[4, 5, 6, 7]]
            }
            Self::Voxel => &[&[0, 4, 6, 2], &[1, 3, 7, 5], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 2, 3, 1], &[4, 5, 7, 6]],
        }
    }

    /// Appends the tetrahedra of a cell with these vertices. Vertices that are named twice, as those of a hexahedron with a collapsed edge, make fewer.
    ///
    /// # Panics
    /// If the number of vertices is another than that of the shape.
    pub fn split(self, cell: &[u32], out: &mut Vec<[u32; 4]>) {
        assert_eq!(cell.len(), self.vertices(), "vertices of a {self:?}");
        if self == Self::Tetrahedron {
            out.push([cell[0], cell[1], cell[2], cell[3]]);
            return;
        }
        let mut around = [0; 4];
        let apex = lowest(cell);
        for face in self.faces() {
            for (to, &i) in around.iter_mut().zip(*face) {
                *to = cell[i];
            }
            split_face(apex, &around[..face.len()], out);
        }
    }
}

/// Appends the tetrahedra of a convex polyhedron of any faces, each with its vertices counterclockwise seen from outside.
///
/// # Examples
/// ```
/// use vr_core::cells::split::split_polyhedron;
///
/// let mut tetrahedra = Vec::new();
/// let octahedron: [&[u32]; 8] =
///     [&[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4], &[1, 0, 5], &[2, 1, 5], &[3, 2, 5], &[0, 3, 5]];
/// split_polyhedron(&octahedron, &mut tetrahedra);
/// assert_eq!(tetrahedra.len(), 4);
/// ```
pub fn split_polyhedron(faces: &[&[u32]], out: &mut Vec<[u32; 4]>) {
    let Some(apex) = faces.iter().flat_map(|face| face.iter().copied()).min() else { return };
    for face in faces {
        split_face(apex, face, out);
    }
}

/// Appends the cones from an apex over the triangles of a face, none if the face has the apex.
fn split_face(apex: u32, face: &[u32], out: &mut Vec<[u32; 4]>) {
    if face.contains(&apex) {
        return;
    }
    let first = face.iter().position(|&v| v == lowest(face)).unwrap_or(0);
    let at = |k: usize| face[(first + k) % face.len()];
    for k in 1..face.len().saturating_sub(1) {
        let [a, b, c] = [at(0), at(k), at(k + 1)];
        if a != b && b != c && c != a {
            // Seen from the apex, which is inside, the face is clockwise.
            out.push([a, c, b, apex]);
        }
    }
}

fn lowest(cell: &[u32]) -> u32 {
    cell.iter().copied().min().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// A unit shape: every vertex once, and its volume.
    fn unit(shape: Shape) -> (Vec<DVec3>, f64) {
        let at = |list: &[[f64; 3]]| list.iter().map(|&p| DVec3::from(p)).collect();
        match shape {
            Shape::Tetrahedron => (at(&[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]), 1.0 / 6.0),
            Shape::Pyramid => {
                (at(&[[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0.5, 0.5, 1.]]), 1.0 / 3.0)
            }
            // The normal of its first triangle points outwards.
            Shape::Wedge => {
                (at(&[[0., 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.], [0., 1., 1.], [1., 0., 1.]]), 0.5)
            }
            Shape::Hexahedron => (
                at(&[
                    [0., 0., 0.],
                    [1., 0., 0.],
                    [1., 1., 0.],
                    [0., 1., 0.],
                    [0., 0., 1.],
                    [1., 0., 1.],
                    [1., 1., 1.],
                    [0., 1., 1.],
                ]),
                1.0,
            ),
            Shape::Voxel => {
                ((0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect(), 1.0)
            }
        }
    }

    /// Whatever the numbers of the vertices, the parts are positive and fill the shape.
    #[test]
    fn parts_fill_the_shape() {
        for shape in [Shape::Tetrahedron, Shape::Pyramid, Shape::Wedge, Shape::Hexahedron, Shape::Voxel] {
            let (at, volume) = unit(shape);
            let n = at.len() as u32;
            for turn in 0..n {
                for stride in [1u32, 3, 5, 7]
                    .into_iter()
                    .filter(|&s| (2..=n).all(|d| !(n.is_multiple_of(d) && s.is_multiple_of(d))))
                {
                    let cell: Vec<u32> = (0..n).map(|i| (i * stride + turn) % n).collect();
                    let place = |v: u32| at[cell.iter().position(|&c| c == v).unwrap()];
                    let mut parts = Vec::new();
                    shape.split(&cell, &mut parts);
                    let volumes: Vec<f64> = parts
                        .iter()
                        .map(|t| {
                            let [a, b, c, d] = t.map(place);
                            (b - a).cross(c - a).dot(d - a) / 6.0
                        })
                        .collect();
                    assert!(volumes.iter().all(|&v| v > 1e-12), "{shape:?} {cell:?}: {volumes:?}");
                    assert!((volumes.iter().sum::<f64>() - volume).abs() < 1e-12, "{shape:?} {cell:?}: {volumes:?}");
                }
            }
        }
    }

    #[test]
    fn collapsed_edges_make_fewer_parts() {
        let mut parts = Vec::new();
        Shape::Hexahedron.split(&[0, 1, 2, 3, 0, 1, 2, 7], &mut parts);
        assert!(!parts.is_empty() && parts.len() < 6, "{parts:?}");
    }
}
