//! Cells by the tiles of the picture that they touch.

use vr_core::CellMesh;

use crate::camera_space::CameraVertex;
use crate::tile_lists::{TileLists, TileRange};

use super::screen::Screen;

/// Pixels along the edge of a tile.
const TILE: u32 = 16;
/// Tiles of a cell at most: a larger one is looked at in every tile.
const MAX_TILES: u32 = 64;
/// Pixels by which a cell's box is larger than the cell.
const MARGIN: f64 = 0.01;

/// Cells by tile.
pub(super) struct Bins {
    lists: TileLists,
    /// Cells of every tile.
    wide: Vec<u32>,
    /// Lowest and highest corner of each cell's box, in pixels.
    boxes: Vec<[[f32; 2]; 2]>,
    across: u32,
}

/// A box that holds no place.
const NOWHERE: [[f32; 2]; 2] = [[f32::INFINITY; 2], [f32::NEG_INFINITY; 2]];

impl Bins {
    /// The bins of those cells that `is_seen` tells.
    pub(super) fn new<const N: usize>(
        mesh: &CellMesh,
        vertices: &[CameraVertex<N>],
        screen: &Screen,
        is_seen: impl Fn(usize) -> bool + Sync,
    ) -> Self {
        let size = screen.size.map(f64::from);
        let bounds = |cell: usize| {
            let corners = mesh.cells()[cell].map(|v| &vertices[v as usize]);
            let [low, high] = screen.bounds(&corners)?;
            let meets = (0..2).all(|a| high[a] >= 0.0 && low[a] <= size[a]);
            let grown = [
                low.map(|x| (x - MARGIN).max(-1.0) as f32),
                [0, 1].map(|a| (high[a] + MARGIN).min(size[a] + 1.0) as f32),
            ];
            (meets && is_seen(cell)).then_some(grown)
        };
        let boxes = vr_core::parallel::collect(mesh.cells().len(), |cell| bounds(cell).unwrap_or(NOWHERE));
        let tiles = screen.size.map(|n| n.div_ceil(TILE));
        // Tiles from `low` up to before `high`.
        let range = |[low, high]: &[[f32; 2]; 2]| {
            let tile = |x: f32, a: usize| ((x.max(0.0) as u32) / TILE).min(tiles[a] - 1);
            [0, 1].map(|a| [tile(low[a], a), tile(high[a], a) + 1])
        };
        let area = |[x, y]: TileRange| (x[1] - x[0]) * (y[1] - y[0]);
        let placed =
            boxes.iter().enumerate().filter(|(_, b)| b[0][0] <= b[1][0]).map(|(cell, b)| (cell as u32, range(b)));
        let wide = placed.clone().filter(|p| area(p.1) > MAX_TILES).map(|p| p.0).collect();
        let lists = TileLists::new(tiles, placed.filter(|p| area(p.1) <= MAX_TILES), usize::MAX);
        Self { lists: lists.expect("any number is allowed"), wide, boxes, across: tiles[0] }
    }

    /// Cells whose box holds a place of the picture, in pixels.
    pub(super) fn near(&self, [x, y]: [f64; 2]) -> impl Iterator<Item = u32> + '_ {
        let tile = (y as u32 / TILE * self.across + x as u32 / TILE) as usize;
        let at = [x as f32, y as f32];
        self.lists.of(tile).iter().chain(&self.wide).copied().filter(move |&cell| {
            let [low, high] = self.boxes[cell as usize];
            (0..2).all(|a| low[a] <= at[a] && at[a] <= high[a])
        })
    }
}
