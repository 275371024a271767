//! Tiles of a picture's samples.

use vr_core::View;

use crate::tile_lists::TileRange;

/// Samples along the edge of a tile at most.
pub(super) const MAX_SIDE: u32 = 64;

/// A picture in tiles of whole pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiling {
    /// Pixels of the picture.
    pub(super) pixels: [u32; 2],
    /// Samples along the edge of a pixel.
    pub(super) per_pixel: u32,
    /// Pixels along the edge of a tile.
    pub(super) side: u32,
    pub(super) tiles: [u32; 2],
}

impl Tiling {
    /// The tiles of a view; `None` if a pixel has more samples than a tile may have.
    pub(super) fn new(view: &View) -> Option<Self> {
        let per_pixel = view.supersampling;
        let side = MAX_SIDE / per_pixel;
        (side > 0).then(|| Self { pixels: view.size, per_pixel, side, tiles: view.size.map(|n| n.div_ceil(side)) })
    }

    /// Samples along the edge of a tile.
    pub(super) fn samples(&self) -> u32 {
        self.side * self.per_pixel
    }

    /// Number of tiles.
    pub(super) fn count(&self) -> u32 {
        self.tiles[0] * self.tiles[1]
    }

    /// The first pixel of a tile, and its pixels along both axes.
    pub(super) fn pixels_of(&self, tile: u32) -> ([u32; 2], [u32; 2]) {
        let first = [tile % self.tiles[0] * self.side, tile / self.tiles[0] * self.side];
        (first, [0, 1].map(|a| self.side.min(self.pixels[a] - first[a])))
    }

    /// Tiles in which a box has samples; `None` if it has none.
    pub(super) fn touched(&self, [low, high]: [[f64; 2]; 2]) -> Option<TileRange> {
        let side = f64::from(self.samples());
        let mut range = [[0; 2]; 2];
        for a in 0..2 {
            let count = f64::from(self.pixels[a] * self.per_pixel);
            let first = (low[a] - 0.5).ceil().max(0.0);
            let last = (high[a] - 0.5).floor().min(count - 1.0);
            if first > last {
                return None;
            }
            range[a] = [(first / side) as u32, (last / side) as u32 + 1];
        }
        Some(range)
    }
}
