//! The intermediate image, and how its rows are shared out.

use std::sync::Mutex;

use crate::composite::{Band, Line};

/// The intermediate image. Its memory is kept from picture to picture.
#[derive(Default)]
pub(crate) struct IntermediateImage {
    size: [usize; 2],
    texels: Vec<[f32; 4]>,
    /// Depths of what texels see.
    depths: Vec<f32>,
    links: Vec<u16>,
    lines: Vec<Line>,
}

/// Largest number of rows of a band: what they hold stays in the cache while all slices pass.
const MAX_ROWS: usize = 8;
/// Bands a thread, so that no thread waits long for the last one.
const BANDS: usize = 6;
/// Cost of a row besides its samples, in samples.
const ROW: u64 = 64;

impl IntermediateImage {
    /// Gives the image a size. Its content then has no meaning: compositing empties each band before it draws.
    pub(crate) fn resize(&mut self, size: [usize; 2]) {
        let [width, height] = size;
        self.size = size;
        self.texels.resize(width * height, [0.0; 4]);
        self.depths.resize(width * height, f32::INFINITY);
        self.links.resize((width + 1) * height, 0);
        self.lines.resize(height, Line::EMPTY);
    }

    pub(crate) fn size(&self) -> [usize; 2] {
        self.size
    }

    pub(crate) fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// Depth of what each texel sees; infinite where it sees nothing.
    pub(crate) fn depths(&self) -> &[f32] {
        &self.depths
    }

    pub(crate) fn texels_mut(&mut self) -> &mut [[f32; 4]] {
        &mut self.texels
    }

    pub(crate) fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Bands of rows, cut so that each costs about the same if rows cost what they did `before`: for that many threads (Lacroute 1996,
    /// *Analysis of a parallel volume rendering system based on the shear-warp factorization*). A row belongs to one band, and what becomes
    /// of it does not depend on which. `stops`: depths at which surfaces end the texels' rays; empty where there are none.
    pub(crate) fn bands<'a>(
        &'a mut self,
        before: &[u32],
        mut stops: &'a [f32],
        threads: usize,
    ) -> Vec<Mutex<Band<'a>>> {
        let [width, height] = self.size;
        // A picture of another height tells about the row at the same part of it.
        let cost = |y: usize| ROW + before.get(y * before.len() / height.max(1)).map_or(0, |&c| u64::from(c));
        let all: u64 = (0..height).map(cost).sum();
        let share = (all / (threads * BANDS) as u64).max(1);
        let (mut texels, mut links, mut lines) = (&mut self.texels[..], &mut self.links[..], &mut self.lines[..]);
        let mut depths = &mut self.depths[..];
        let mut bands = Vec::new();
        let mut first = 0;
        while first < height {
            let (mut rows, mut sum) = (0, 0);
            while first + rows < height && rows < MAX_ROWS && sum < share {
                sum += cost(first + rows);
                rows += 1;
            }
            let (own_texels, other_texels) = texels.split_at_mut(rows * width);
            let (own_depths, other_depths) = depths.split_at_mut(rows * width);
            let (own_stops, other_stops) = stops.split_at((rows * width).min(stops.len()));
            let (own_links, other_links) = links.split_at_mut(rows * (width + 1));
            let (own_lines, other_lines) = lines.split_at_mut(rows);
            bands.push(Mutex::new(Band {
                first,
                width,
                texels: own_texels,
                depths: own_depths,
                stops: own_stops,
                links: own_links,
                lines: own_lines,
            }));
            (texels, depths, stops, links, lines) = (other_texels, other_depths, other_stops, other_links, other_lines);
            first += rows;
        }
        bands
    }

    /// Smallest rectangle around what was drawn on: first column, first row, and those behind the last.
    pub(crate) fn drawn(&self) -> [usize; 4] {
        self.rectangle(|line| line.drawn)
    }

    /// The same around the texels that have a depth.
    pub(crate) fn seen(&self) -> [usize; 4] {
        self.rectangle(|line| line.seen)
    }

    /// Smallest rectangle around a part of each line.
    fn rectangle(&self, of: impl Fn(&Line) -> [u32; 2]) -> [usize; 4] {
        let mut all = [usize::MAX, usize::MAX, 0, 0];
        for (y, line) in self.lines.iter().enumerate() {
            let [first, end] = of(line).map(|x| x as usize);
            if first < end {
                all = [all[0].min(first), all[1].min(y), all[2].max(end), y + 1];
            }
        }
        if all[2] == 0 { [0; 4] } else { all }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_are_all_rows_and_share_the_cost() {
        for threads in [1, 2, 7] {
            let mut image = IntermediateImage::default();
            image.resize([5, 100]);
            let before: Vec<u32> = (0..100).map(|y| if y < 10 { 10_000 } else { 0 }).collect();
            let bands = image.bands(&before, &[], threads);
            let bands: Vec<_> = bands.into_iter().map(|b| b.into_inner().unwrap()).collect();
            let mut next = 0;
            for band in &bands {
                assert_eq!(band.first, next);
                assert_eq!((band.texels.len(), band.links.len()), (band.lines.len() * 5, band.lines.len() * 6));
                next += band.lines.len();
            }
            assert_eq!(next, 100);
            // The costly rows are not all in one band.
            assert!(bands.iter().filter(|b| b.first < 10).count() >= 5);
        }
    }
}
