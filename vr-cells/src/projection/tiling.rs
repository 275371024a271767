//! Tiles of a picture's samples, and lists of what touches each.

use vr_core::View;

/// Samples along the edge of a tile at most.
pub(super) const MAX_SIDE: u32 = 64;

/// First and behind the last tile along both axes.
pub(super) type TileRange = [[u32; 2]; 2];

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

/// Calls `visit` with each tile of a range.
pub(super) fn each_tile([x, y]: TileRange, across: u32, visit: &mut dyn FnMut(usize)) {
    for row in y[0]..y[1] {
        (x[0]..x[1]).for_each(|column| visit((row * across + column) as usize));
    }
}

/// Items by tile.
pub(super) struct TileLists {
    /// Items of tile t are `items[first[t]..first[t + 1]]`.
    first: Vec<usize>,
    items: Vec<u32>,
}

impl TileLists {
    /// The lists of items with their ranges, each in the order of the items; `None` if they have more than `most` entries.
    pub(super) fn new(
        tiles: [u32; 2],
        ranges: impl Iterator<Item = (u32, TileRange)> + Clone,
        most: usize,
    ) -> Option<Self> {
        // Count, then fill.
        let mut first = vec![0usize; (tiles[0] * tiles[1]) as usize + 1];
        for (_, range) in ranges.clone() {
            each_tile(range, tiles[0], &mut |tile| first[tile + 1] += 1);
        }
        for tile in 1..first.len() {
            first[tile] += first[tile - 1];
        }
        if first[first.len() - 1] > most {
            return None;
        }
        let mut next = first.clone();
        let mut items = vec![0; first[first.len() - 1]];
        for (item, range) in ranges {
            each_tile(range, tiles[0], &mut |tile| {
                items[next[tile]] = item;
                next[tile] += 1;
            });
        }
        Some(Self { first, items })
    }

    /// Items of a tile.
    pub(super) fn of(&self, tile: usize) -> &[u32] {
        &self.items[self.first[tile]..self.first[tile + 1]]
    }
}
