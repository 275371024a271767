//! Smallest depth of anything that a view may show, tile by tile.

use rayon::prelude::*;
use vr_core::image_order::ImageSample;
use vr_kernels::vector::LANES;

use crate::projection::{Footprint, TILE};

/// Depths along the view before which nothing can be seen, per tile of 4×4 pixels; +∞ where nothing can be seen at all.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NearDepths {
    size: [u32; 2],
    across: u32,
    depth: Vec<f64>,
}

impl NearDepths {
    /// Returns the depths of a view of so many pixels, in which nothing can be seen yet.
    pub(crate) fn nothing(size: [u32; 2]) -> Self {
        let [across, down] = size.map(|n| n.div_ceil(TILE));
        Self { size, across, depth: vec![f64::INFINITY; (across * down) as usize] }
    }

    /// Returns the depth of the tile of a pixel.
    pub(crate) fn at(&self, [x, y]: [u32; 2]) -> f64 {
        self.depth[(y / TILE * self.across + x / TILE) as usize]
    }

    /// Returns the depth of the tile of a ray. Beyond the view's pixels anything is possible: no box was projected there.
    pub(crate) fn at_spot(&self, spot: &ImageSample) -> f64 {
        let within = |x: f64, size: u32| x >= 0.0 && x < f64::from(size);
        if within(spot.x, self.size[0]) && within(spot.y, self.size[1]) {
            self.at([spot.x as u32, spot.y as u32])
        } else {
            0.0
        }
    }

    /// Returns the depths of the rays of a packet, +∞ for those that it lacks; `None` if none of them can see anything.
    pub(crate) fn at_spots(&self, spots: &[ImageSample]) -> Option<[f64; LANES]> {
        let mut nearest = [f64::INFINITY; LANES];
        for (nearest, spot) in nearest.iter_mut().zip(spots) {
            *nearest = self.at_spot(spot);
        }
        nearest.iter().any(|&depth| depth < f64::INFINITY).then_some(nearest)
    }

    /// True if nothing can be seen in the pixels of the view from `low` to `high`, both included.
    pub(crate) fn is_clear(&self, low: [u32; 2], high: [u32; 2]) -> bool {
        let [left, right] = [low[0] / TILE, high[0] / TILE].map(|x| x as usize);
        let mut rows = low[1] / TILE..=high[1] / TILE;
        rows.all(|row| {
            let tiles = (row * self.across) as usize;
            self.depth[tiles + left..=tiles + right].iter().all(|&depth| depth == f64::INFINITY)
        })
    }

    /// Returns all tiles.
    pub(crate) fn whole(&mut self) -> Band<'_> {
        Band { first: 0, across: self.across, depth: &mut self.depth }
    }

    /// Returns bands of so many rows of tiles, the last of fewer.
    pub(crate) fn bands(&mut self, rows: u32) -> impl IndexedParallelIterator<Item = Band<'_>> {
        let across = self.across;
        let band = move |(i, depth)| Band { first: i as u32 * rows, across, depth };
        self.depth.par_chunks_mut((across * rows) as usize).enumerate().map(band)
    }
}

/// Some rows of tiles.
pub(crate) struct Band<'a> {
    /// First row of the band.
    first: u32,
    across: u32,
    depth: &'a mut [f64],
}

impl Band<'_> {
    /// Returns the rows of a footprint in the band, counted from its first.
    fn rows(&self, footprint: &Footprint) -> std::ops::Range<u32> {
        let end = self.first + self.depth.len() as u32 / self.across;
        let low = footprint.low[1].max(self.first);
        low - self.first..(footprint.high[1] + 1).min(end).max(low) - self.first
    }

    fn tiles(&self, row: u32, footprint: &Footprint) -> std::ops::Range<usize> {
        let start = (row * self.across) as usize;
        start + footprint.low[0] as usize..start + footprint.high[0] as usize + 1
    }

    /// True if a box would change anything: false where all tiles have something nearer already. (The test for hidden points.)
    pub(crate) fn shows(&self, footprint: &Footprint) -> bool {
        self.rows(footprint).any(|row| self.depth[self.tiles(row, footprint)].iter().any(|&d| d > footprint.depth))
    }

    /// Adds a box of which something can be seen.
    pub(crate) fn put(&mut self, footprint: &Footprint) {
        for row in self.rows(footprint) {
            let tiles = self.tiles(row, footprint);
            for depth in &mut self.depth[tiles] {
                *depth = depth.min(footprint.depth);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_clear_where_no_box_is() {
        let mut near = NearDepths::nothing([50, 30]);
        assert!(near.is_clear([0, 0], [49, 29]));
        // Pixels 12 to 19 of rows 8 to 11.
        near.whole().put(&Footprint { low: [3, 2], high: [4, 2], depth: 7.0 });
        for (low, high) in [([0, 0], [11, 29]), ([20, 8], [49, 11]), ([0, 0], [49, 7]), ([0, 12], [49, 29])] {
            assert!(near.is_clear(low, high), "{low:?}");
        }
        for (low, high) in [([0, 0], [49, 29]), ([19, 11], [40, 29]), ([12, 8], [12, 8]), ([0, 0], [12, 8])] {
            assert!(!near.is_clear(low, high), "{low:?}");
        }
    }
}
