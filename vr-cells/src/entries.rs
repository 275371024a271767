//! Faces of a mesh's surface through which rays enter it, sorted into tiles of the picture.

use glam::DVec3;
use vr_core::cells::{FACES, NO_CELL};
use vr_core::{CellMesh, View};

use crate::camera_space::CameraVertex;
use crate::screen::Screen;
use crate::tile_lists::{TileLists, TileRange};

/// Pixels along the edge of a tile.
pub(crate) const TILE: u32 = 16;

/// A face of the surface: a cell, and the vertex across.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceFace {
    pub(crate) cell: u32,
    pub(crate) across: u8,
}

/// Returns the faces that only one cell has.
pub(crate) fn surface(mesh: &CellMesh) -> Vec<SurfaceFace> {
    let mut faces = Vec::new();
    for (cell, neighbours) in mesh.neighbours().iter().enumerate() {
        for (across, &neighbour) in neighbours.iter().enumerate() {
            if neighbour == NO_CELL {
                faces.push(SurfaceFace { cell: cell as u32, across: across as u8 });
            }
        }
    }
    faces
}

/// Faces by tile.
pub(crate) struct Entries<'a> {
    faces: &'a [SurfaceFace],
    lists: TileLists,
    /// Faces of the cells around the eye, by one of which each ray's line comes into its first cell: all tiles have them.
    around_eye: Vec<SurfaceFace>,
    across: u32,
}

impl<'a> Entries<'a> {
    pub(crate) fn new<const N: usize>(
        faces: &'a [SurfaceFace],
        mesh: &CellMesh,
        vertices: &[CameraVertex<N>],
        view: &View,
    ) -> Self {
        let screen = Screen::new(view, 1, mesh.mean_spacing());
        let tiles = view.size.map(|n| n.div_ceil(TILE));
        // The tiles that a face touches, with a pixel to spare. What lies behind the eye is met by no ray: those that begin inside do so in a cell.
        let touched = |face: &SurfaceFace| -> Option<TileRange> {
            let cell = mesh.cells()[face.cell as usize];
            let [low, high] =
                screen.box_around(&FACES[usize::from(face.across)].map(|i| &vertices[cell[i] as usize]))?;
            let tile = |x: f64, a: usize| (x / f64::from(TILE)).clamp(0.0, f64::from(tiles[a])) as u32;
            Some([0, 1].map(|a| [tile(low[a] - 1.0, a), tile(high[a] + 1.0 + f64::from(TILE), a)]))
        };
        let ranges: Vec<_> = faces.iter().map(touched).collect();
        let placed = ranges.iter().enumerate().filter_map(|(face, range)| Some((face as u32, (*range)?)));
        let lists = TileLists::new(tiles, placed, usize::MAX).expect("any number is allowed");
        let is_behind = screen.perspective && vertices.iter().any(|v| !screen.is_ahead(v.at[2]));
        let around_eye = if is_behind { around_eye(mesh, vertices) } else { Vec::new() };
        Self { faces, lists, around_eye, across: tiles[0] }
    }

    /// Faces that a ray through this place of the picture, in pixels, may enter by.
    pub(crate) fn near(&self, x: f64, y: f64) -> impl Iterator<Item = SurfaceFace> + '_ {
        let tile = (y as u32 / TILE * self.across + x as u32 / TILE) as usize;
        self.lists.of(tile).iter().map(|&face| self.faces[face as usize]).chain(self.around_eye.iter().copied())
    }
}

/// Part of a cell's volume by which the eye may be outside of it, of which rounding makes some.
const ROUNDING: f64 = 1e-9;

/// Returns all faces of the cells that the eye is in, or on the surface of.
fn around_eye<const N: usize>(mesh: &CellMesh, vertices: &[CameraVertex<N>]) -> Vec<SurfaceFace> {
    let holds_eye = |names: &[u32; 4]| {
        let corners = names.map(|v| DVec3::from_array(vertices[v as usize].at));
        let (low, high) =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &c| (low.min(c), high.max(c)));
        let margin = DVec3::splat(ROUNDING * (high - low).max_element());
        if (low - margin).cmpgt(DVec3::ZERO).any() || (high + margin).cmplt(DVec3::ZERO).any() {
            return false;
        }
        // The volumes between the eye and each face have the sign of the cell's.
        let volume = |[a, b, c, d]: [DVec3; 4]| (b - a).cross(c - a).dot(d - a);
        let whole = volume(corners);
        (0..4).all(|i| {
            let mut with_eye = corners;
            with_eye[i] = DVec3::ZERO;
            volume(with_eye) * whole.signum() >= -ROUNDING * whole.abs()
        })
    };
    let cells = (0u32..).zip(mesh.cells()).filter(|(_, names)| holds_eye(names)).map(|(cell, _)| cell);
    cells.flat_map(|cell| (0..4).map(move |across| SurfaceFace { cell, across })).collect()
}
