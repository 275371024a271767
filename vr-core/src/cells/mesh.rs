//! A mesh of tetrahedra with values.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::adjacency::neighbours;
use super::error::CellError;
use super::repair::{CellRepairs, sound_cells};
use super::vertex_gradients::vertex_gradients;
use crate::box_tree::{Bounds, BoxTree};
use crate::cancel;
use crate::derived::Derived;
use crate::limits::{MAX_COORDINATE, MAX_STEPS_AWAY, is_length};

/// Values of a mesh of cells, in f64.
#[derive(Clone, Debug, PartialEq)]
pub enum CellValues {
    /// One for each vertex; the field is linear in each cell, and continuous.
    Vertices(Vec<f64>),
    /// One for each cell; the field is constant in each cell, and jumps between them.
    Cells(Vec<f64>),
}

/// A volume of tetrahedra, each with the values of its vertices or a value of its own; what no cell covers is vacuum.
///
/// Cells may have any order and orientation: inverted ones are turned; flat ones, repeated ones and those without a finite value are left out
/// ([`repairs`](Self::repairs) counts them). They should not overlap: in what several cover, that one is seen which holds the place deepest.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::cells::{CellMesh, CellValues};
/// use vr_core::{Field, Volume};
///
/// let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let mesh = CellMesh::new(vertices, vec![[0, 1, 2, 3]], CellValues::Vertices(vec![0.0, 1.0, 2.0, 3.0]))?;
/// assert_eq!(mesh.value(DVec3::new(0.25, 0.25, 0.25)), Some(1.5));
/// assert_eq!(mesh.value(DVec3::ONE), None, "outside of the cell");
/// assert_eq!(Volume::from(mesh).value_range(), Some((0.0, 3.0)));
/// # Ok::<(), vr_core::cells::CellError>(())
/// ```
#[derive(Clone, Debug)]
pub struct CellMesh {
    vertices: Vec<DVec3>,
    cells: Vec<[u32; 4]>,
    neighbours: Vec<[u32; 4]>,
    values: CellValues,
    bounds: (DVec3, DVec3),
    range: (f64, f64),
    spacing: f64,
    repairs: CellRepairs,
    /// Tree of the cells' boxes, made when first asked for, then kept; likewise the gradients at vertices.
    tree: OnceLock<BoxTree>,
    gradients: OnceLock<Vec<DVec3>>,
    derived: Arc<Derived>,
}

impl CellMesh {
    /// A mesh of cells that each name four vertices.
    ///
    /// # Errors
    /// [`CellError`] for no cell that has a volume and finite values, lists of different lengths, a vertex that does not exist, a position that is not
    /// finite or beyond 10³⁰, cells too small, too large or too far away for arithmetic.
    pub fn new(vertices: Vec<DVec3>, cells: Vec<[u32; 4]>, values: CellValues) -> Result<Self, CellError> {
        for (what, found) in [("cells", cells.len()), ("vertices", vertices.len())] {
            if u32::try_from(found).is_ok_and(|n| n < u32::MAX) {
                continue;
            }
            return Err(CellError::TooMany { what, found });
        }
        let (what, found, expected) = match &values {
            CellValues::Vertices(values) => ("vertices", values.len(), vertices.len()),
            CellValues::Cells(values) => ("cells", values.len(), cells.len()),
        };
        if found != expected {
            return Err(CellError::Length { what, found, expected });
        }
        for (number, cell) in cells.iter().enumerate() {
            if let Some(&found) = cell.iter().find(|&&v| v as usize >= vertices.len()) {
                return Err(CellError::Vertex { cell: number, found, vertices: vertices.len() });
            }
        }
        if let Some(vertex) = vertices.iter().position(|p| !p.abs().cmplt(DVec3::splat(MAX_COORDINATE)).all()) {
            return Err(CellError::Position { vertex, found: vertices[vertex].to_array() });
        }

        let (sound, numbers, mut repairs) = sound_cells(&vertices, &cells, &values);
        if sound.is_empty() {
            return Err(CellError::Empty { found: cells.len() });
        }
        let values = match values {
            CellValues::Cells(values) => CellValues::Cells(numbers.iter().map(|&n| values[n as usize]).collect()),
            vertices => vertices,
        };
        let (neighbours, crowded) = neighbours(&sound);
        repairs.crowded_faces = crowded;
        let mut mesh = Self {
            vertices,
            cells: sound,
            neighbours,
            values,
            bounds: (DVec3::ZERO, DVec3::ZERO),
            range: (0.0, 0.0),
            spacing: 0.0,
            repairs,
            tree: OnceLock::new(),
            gradients: OnceLock::new(),
            derived: Arc::default(),
        };
        mesh.measure()?;
        Ok(mesh)
    }

    /// Finds the box, the range of values and the size of the cells.
    fn measure(&mut self) -> Result<(), CellError> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut least, mut largest, mut volume) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for (number, cell) in self.cells.iter().enumerate() {
            let corners = self.corners(number);
            for at in corners {
                (low, high) = (low.min(at), high.max(at));
            }
            let [a, b, c, d] = corners;
            volume += (b - a).cross(c - a).dot(d - a);
            let mut take = |value: f64| (least, largest) = (least.min(value), largest.max(value));
            match &self.values {
                CellValues::Vertices(values) => cell.iter().for_each(|&v| take(values[v as usize])),
                CellValues::Cells(values) => take(values[number]),
            }
        }
        // Six tetrahedra make a cube.
        let size = (volume / self.cells.len() as f64).cbrt();
        let away = low.abs().max(high.abs()).max_element();
        let is_near = away / size < MAX_STEPS_AWAY;
        if !is_length(size) || !is_near {
            return Err(CellError::Size { size });
        }
        (self.bounds, self.range, self.spacing) = ((low, high), (least, largest), size);
        Ok(())
    }

    /// Positions of the vertices.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Vertices of each cell: the fourth lies on the side from which the first three are clockwise, so that the volume is positive.
    pub fn cells(&self) -> &[[u32; 4]] {
        &self.cells
    }

    /// The cell across the face across from each vertex of each cell, [`NO_CELL`](super::NO_CELL) at the surface.
    pub fn neighbours(&self) -> &[[u32; 4]] {
        &self.neighbours
    }

    /// The values, of vertices or of the cells that are left.
    pub fn values(&self) -> &CellValues {
        &self.values
    }

    /// Number of cells that were put right or left out.
    pub fn repairs(&self) -> &CellRepairs {
        &self.repairs
    }

    /// Lowest and highest corner of the smallest box around all cells.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Smallest and largest value of a cell.
    pub fn value_range(&self) -> (f64, f64) {
        self.range
    }

    /// Edge of a cube of six cells of the mean volume, in world units.
    pub fn mean_spacing(&self) -> f64 {
        self.spacing
    }

    /// Gradients at the vertices, per world unit: means of those of the cells around them, weighted by volume. `None` for values of cells.
    pub fn gradients(&self) -> Option<&[DVec3]> {
        match &self.values {
            CellValues::Vertices(values) => {
                Some(self.gradients.get_or_init(|| {
                    // Beside them, the sums over the cells around each vertex, and the volumes of these.
                    let bytes = self.vertices.len() * (2 * size_of::<DVec3>() + size_of::<f64>());
                    cancel::claim("the gradients at vertices", bytes as u64);
                    vertex_gradients(&self.vertices, &self.cells, values)
                }))
            }
            CellValues::Cells(_) => None,
        }
    }

    /// Structures that others derive from the mesh and keep with it.
    pub fn derived(&self) -> &Derived {
        &self.derived
    }

    /// Positions of the four corners of a cell.
    pub fn corners(&self, cell: usize) -> [DVec3; 4] {
        self.cells[cell].map(|v| self.vertices[v as usize])
    }

    /// Values at the four corners of a cell.
    pub fn corner_values(&self, cell: usize) -> [f64; 4] {
        match &self.values {
            CellValues::Vertices(values) => self.cells[cell].map(|v| values[v as usize]),
            CellValues::Cells(values) => [values[cell]; 4],
        }
    }

    /// Tree of the cells' boxes.
    pub(super) fn tree(&self) -> &BoxTree {
        self.tree.get_or_init(|| {
            let around = |cell: usize| {
                let corners = self.corners(cell);
                let least = corners.into_iter().fold(DVec3::INFINITY, DVec3::min);
                Bounds { low: least, high: corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max) }
            };
            let key = |cell: usize| {
                let Bounds { low, high } = around(cell);
                (0.5 * low + 0.5 * high, 0.5 * (high - low).max_element())
            };
            BoxTree::new(self.cells.len(), self.bounds, key, around)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> (Vec<DVec3>, Vec<[u32; 4]>) {
        (vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2, 3]])
    }

    #[test]
    fn bad_input_is_refused_in_words() {
        let (vertices, cells) = tetrahedron();
        let new = |vertices: &[DVec3], cells: &[[u32; 4]], values| {
            CellMesh::new(vertices.to_vec(), cells.to_vec(), values).unwrap_err().to_string()
        };
        let ones = |n| CellValues::Vertices(vec![1.0; n]);
        assert_eq!(new(&vertices, &cells, ones(3)), "found 3 values for 4 vertices: each must have one");
        let cell_values = CellValues::Cells(vec![]);
        assert_eq!(new(&vertices, &cells, cell_values), "found 0 values for 1 cells: each must have one");
        assert!(new(&vertices, &[], ones(4)).starts_with("found no cell with a volume and finite values among 0"));
        assert!(new(&vertices, &cells, CellValues::Vertices(vec![f64::NAN; 4])).contains("among 1"));
        let mut far = vertices.clone();
        far[2].y = f64::NAN;
        assert!(new(&far, &cells, ones(4)).starts_with("vertex 2: found the position"));
        let small: Vec<_> = vertices.iter().map(|&p| p * 1e-30).collect();
        assert!(new(&small, &cells, ones(4)).starts_with("cells of the mean size 0.0"));
        let away: Vec<_> = vertices.iter().map(|&p| p + 1e14).collect();
        assert!(new(&away, &cells, ones(4)).contains("from the world's origin"));
    }

    #[test]
    fn inverted_cells_are_turned() {
        let (vertices, _) = tetrahedron();
        let mesh = CellMesh::new(vertices, vec![[0, 2, 1, 3]], CellValues::Cells(vec![7.0])).unwrap();
        assert_eq!(mesh.cells(), [[0, 2, 3, 1]]);
        assert_eq!(mesh.repairs().inverted, 1);
        assert_eq!(mesh.mean_spacing(), 1.0, "six of them make a cube");
    }
}
