//! Faces of a mesh's surface through which rays enter it, sorted into tiles of the picture.

use vr_core::cells::{FACES, NO_CELL};
use vr_core::{CellMesh, View};

use crate::camera_space::{CameraSpace, CameraVertex};
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
    /// Faces that reach beside or behind the eye: all tiles have them.
    everywhere: Vec<u32>,
    across: u32,
}

impl<'a> Entries<'a> {
    pub(crate) fn new<const N: usize>(
        faces: &'a [SurfaceFace],
        mesh: &CellMesh,
        vertices: &[CameraVertex<N>],
        camera: &CameraSpace,
        view: &View,
    ) -> Self {
        let [width, height] = view.size.map(f64::from);
        let per_unit = height / view.camera.projection.height();
        let tiles = view.size.map(|n| n.div_ceil(TILE));
        // The tiles that a face touches, with a pixel to spare.
        let touched = |face: &SurfaceFace| -> Option<TileRange> {
            let cell = mesh.cells()[face.cell as usize];
            let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for i in FACES[usize::from(face.across)] {
                let [x, y] = camera.projected(vertices[cell[i] as usize].at)?;
                let at = [0.5 * width + x * per_unit, 0.5 * height - y * per_unit];
                for a in 0..2 {
                    (low[a], high[a]) = (low[a].min(at[a]), high[a].max(at[a]));
                }
            }
            let tile = |x: f64, a: usize| (x / f64::from(TILE)).clamp(0.0, f64::from(tiles[a])) as u32;
            Some([0, 1].map(|a| [tile(low[a] - 1.0, a), tile(high[a] + 1.0 + f64::from(TILE), a)]))
        };
        let ranges: Vec<_> = faces.iter().map(touched).collect();
        let placed = ranges.iter().enumerate().filter_map(|(face, range)| Some((face as u32, (*range)?)));
        let lists = TileLists::new(tiles, placed, usize::MAX).expect("any number is allowed");
        let everywhere = (0u32..).zip(&ranges).filter(|(_, range)| range.is_none()).map(|(face, _)| face).collect();
        Self { faces, lists, everywhere, across: tiles[0] }
    }

    /// Faces that a ray through this place of the picture, in pixels, may enter by.
    pub(crate) fn near(&self, x: f64, y: f64) -> impl Iterator<Item = SurfaceFace> + '_ {
        let tile = (y as u32 / TILE * self.across + x as u32 / TILE) as usize;
        self.lists.of(tile).iter().chain(&self.everywhere).map(|&face| self.faces[face as usize])
    }
}
