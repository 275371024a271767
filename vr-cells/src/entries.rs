//! Faces of a mesh's surface through which rays enter it, sorted into tiles of the picture.

use vr_core::cells::{FACES, NO_CELL};
use vr_core::{CellMesh, Projection, View};

use crate::camera_space::{CameraSpace, CameraVertex};

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
    /// Faces of tile t are `order[first[t]..first[t + 1]]`.
    first: Vec<u32>,
    order: Vec<u32>,
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
        let seen = match view.camera.projection {
            Projection::Orthographic { height } => height,
            Projection::Perspective { fov } => 2.0 * (0.5 * fov.to_radians()).tan(),
        };
        let per_unit = height / seen;
        let tiles = view.size.map(|n| n.div_ceil(TILE));
        // The tiles that a face touches, with a pixel to spare.
        let touched = |face: &SurfaceFace| -> Option<[[u32; 2]; 2]> {
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
        // Count, then fill.
        let mut first = vec![0u32; (tiles[0] * tiles[1]) as usize + 1];
        let each = |range: &[[u32; 2]; 2], visit: &mut dyn FnMut(usize)| {
            for y in range[1][0]..range[1][1] {
                for x in range[0][0]..range[0][1] {
                    visit((y * tiles[0] + x) as usize);
                }
            }
        };
        for range in ranges.iter().flatten() {
            each(range, &mut |tile| first[tile + 1] += 1);
        }
        for tile in 1..first.len() {
            first[tile] += first[tile - 1];
        }
        let mut next = first.clone();
        let mut order = vec![0; first[first.len() - 1] as usize];
        let mut everywhere = Vec::new();
        for (face, range) in ranges.iter().enumerate() {
            match range {
                Some(range) => each(range, &mut |tile| {
                    order[next[tile] as usize] = face as u32;
                    next[tile] += 1;
                }),
                None => everywhere.push(face as u32),
            }
        }
        Self { faces, first, order, everywhere, across: tiles[0] }
    }

    /// Faces that a ray through this place of the picture, in pixels, may enter by.
    pub(crate) fn near(&self, x: f64, y: f64) -> impl Iterator<Item = SurfaceFace> + '_ {
        let tile = (y as u32 / TILE * self.across + x as u32 / TILE) as usize;
        let here = &self.order[self.first[tile] as usize..self.first[tile + 1] as usize];
        here.iter().chain(&self.everywhere).map(|&face| self.faces[face as usize])
    }
}
