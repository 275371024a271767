//! Lists of what touches each tile of a picture.

use vr_core::cancel;

/// First and behind the last tile along both axes.
pub(crate) type TileRange = [[u32; 2]; 2];

/// Calls `visit` with each tile of a range.
pub(crate) fn each_tile([x, y]: TileRange, across: u32, visit: &mut dyn FnMut(usize)) {
    for row in y[0]..y[1] {
        (x[0]..x[1]).for_each(|column| visit((row * across + column) as usize));
    }
}

/// Items by tile.
pub(crate) struct TileLists {
    /// Items of tile t are `items[first[t]..first[t + 1]]`.
    first: Vec<usize>,
    items: Vec<u32>,
}

impl TileLists {
    /// The lists of items with their ranges, each in the order of the items; `None` if they have more than `most` entries.
    pub(crate) fn new(
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
        cancel::claim("the lists of what touches each tile", (first[first.len() - 1] * size_of::<u32>()) as u64);
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
    pub(crate) fn of(&self, tile: usize) -> &[u32] {
        &self.items[self.first[tile]..self.first[tile + 1]]
    }
}
