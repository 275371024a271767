//! A mesh on the screen: places of its vertices on a fine lattice, and the side from which each face is seen.

use vr_core::CellMesh;
use vr_core::cells::{CellValues, FACES};

use crate::camera_space::CameraVertex;

use crate::screen::Screen;

/// Places of the lattice across the largest cell: differences of places within a cell have exact products in f64, so that the side of a line on which a place lies is
/// never in doubt, and two cells that share a face agree.
const PLACES: f64 = 67_108_864.0;
/// Smallest extent in samples that the lattice is made for: that of a tile.
const MIN_EXTENT: f64 = 64.0;
/// Extent of a cell in samples up to which its arithmetic is exact.
pub(super) const MAX_EXTENT: f64 = 4096.0;

/// A vertex on the screen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ScreenVertex {
    /// Place in samples; NaN if it cannot be projected.
    pub(super) at: [f64; 2],
    /// A number that is linear on the screen along any plane: the depth, or its reciprocal in perspective.
    pub(super) depth: f64,
    /// Place of its value in the table, times the reciprocal of the depth in perspective: linear on the screen along any plane, too.
    pub(super) value: f64,
}

/// Sides from which the faces of a cell are seen: bit i for the front of the face across from vertex i, bit 4 + i for its back, none of both for a face
/// that is seen from its edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Facing(pub(super) u8);

impl Facing {
    /// True if a face turns its outside to the eye.
    pub(super) fn is_front(self, face: usize) -> bool {
        self.0 >> face & 1 != 0
    }

    /// True if a face turns its outside away from the eye.
    pub(super) fn is_back(self, face: usize) -> bool {
        self.0 >> (face + 4) & 1 != 0
    }
}

/// Twice the area of a triangle of places; its sign changes, and no digit, if two places are swapped.
#[inline(always)]
pub(super) fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// A mesh on the screen.
pub(super) struct ScreenMesh<'a> {
    pub(super) mesh: &'a CellMesh,
    pub(super) vertices: Vec<ScreenVertex>,
    pub(super) perspective: bool,
    /// Places of the cells' own values in the table, if they have such.
    of_cells: Option<Vec<f64>>,
    facing: Vec<Facing>,
    ranges: Vec<[f32; 2]>,
}

impl<'a> ScreenMesh<'a> {
    /// Bytes that each vertex takes.
    pub(super) const BYTES_PER_VERTEX: usize = size_of::<ScreenVertex>();

    /// Bytes that each cell takes: the place of its own value, its range and the sides that are seen; and its extent, meanwhile.
    pub(super) const BYTES_PER_CELL: usize =
        size_of::<f64>() + size_of::<[f32; 2]>() + size_of::<Facing>() + size_of::<f32>();

    /// The mesh on a screen; `place` tells where in a table a value stands.
    pub(super) fn new(
        mesh: &'a CellMesh,
        camera: &[CameraVertex<1>],
        screen: &Screen,
        place: impl Fn(f64) -> f64 + Sync,
    ) -> Self {
        let project = |i: usize| {
            let CameraVertex { at, attributes } = camera[i];
            let depth = if screen.perspective { 1.0 / at[2] } else { at[2] };
            let on_screen = if screen.is_ahead(at[2]) { screen.project(at) } else { [f64::NAN; 2] };
            let value = place(attributes[0]) * if screen.perspective { depth } else { 1.0 };
            ScreenVertex { at: on_screen, depth, value }
        };
        let mut vertices: Vec<ScreenVertex> = (0..camera.len()).map(project).collect();
        let per_sample = lattice(mesh, &vertices);
        for vertex in &mut vertices {
            vertex.at = vertex.at.map(|x| (x * per_sample).round() / per_sample);
        }
        let of_cells = match mesh.values() {
            CellValues::Cells(values) => Some(values.iter().map(|&v| place(v)).collect()),
            CellValues::Vertices(_) => None,
        };
        let face = |names: [u32; 3]| -> f64 {
            let area = area(names.map(|v| vertices[v as usize].at));
            if area.is_nan() { solid_angle(names, camera) } else { -area }
        };
        let facing = vr_core::parallel::collect(mesh.cells().len(), |cell| {
            let names = mesh.cells()[cell];
            let mut bits = 0;
            for (i, corners) in FACES.iter().enumerate() {
                let outward = face(corners.map(|k| names[k]));
                bits |= u8::from(outward > 0.0) << i | u8::from(outward < 0.0) << (i + 4);
            }
            Facing(bits)
        });
        let ranges = vr_core::parallel::collect(mesh.cells().len(), |cell| {
            let places = mesh.corner_values(cell).map(|v| place(v) as f32);
            let pick = |pick: fn(f32, f32) -> f32| pick(pick(places[0], places[1]), pick(places[2], places[3]));
            [pick(f32::min), pick(f32::max)]
        });
        Self { mesh, vertices, perspective: screen.perspective, of_cells, facing, ranges }
    }

    /// Corners of a cell, as the values of the cell are.
    #[inline]
    pub(super) fn corners(&self, cell: usize) -> [ScreenVertex; 4] {
        let mut corners = self.mesh.cells()[cell].map(|v| self.vertices[v as usize]);
        if let Some(values) = &self.of_cells {
            for corner in &mut corners {
                corner.value = if self.perspective { values[cell] * corner.depth } else { values[cell] };
            }
        }
        corners
    }

    /// Sides from which the faces of a cell are seen.
    pub(super) fn facing(&self, cell: usize) -> Facing {
        self.facing[cell]
    }

    /// Lowest and highest place in the table of a cell's values.
    pub(super) fn range(&self, cell: usize) -> [f32; 2] {
        self.ranges[cell]
    }
}

/// Places of the lattice for each sample: a power of two.
fn lattice(mesh: &CellMesh, vertices: &[ScreenVertex]) -> f64 {
    let extents = vr_core::parallel::collect(mesh.cells().len(), |cell| {
        let at = mesh.cells()[cell].map(|v| vertices[v as usize].at);
        // Comparisons with NaN are false: cells around the eye do not count.
        let from_first = |a: usize| at.iter().map(|p| (p[a] - at[0][a]).abs()).fold(0.0, f64::max);
        (2.0 * from_first(0).max(from_first(1))).min(MAX_EXTENT) as f32
    });
    let largest = f64::from(extents.into_iter().fold(0.0, f32::max)).max(MIN_EXTENT);
    PLACES / libm::exp2(libm::log2(largest).ceil())
}

/// Six times the volume under a face as seen from the eye: positive if it turns counterclockwise. The same digits whatever vertex is named first.
fn solid_angle(names: [u32; 3], camera: &[CameraVertex<1>]) -> f64 {
    let mut sorted = names;
    sorted.sort_unstable();
    let [a, b, c] = sorted.map(|v| camera[v as usize].at);
    let volume =
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
    let even = names == sorted || [names[1], names[2], names[0]] == sorted || [names[2], names[0], names[1]] == sorted;
    if even { volume } else { -volume }
}
