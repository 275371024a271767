//! Colours of a palette mixed by place, so that a gradient shows no bands.
//!
//! Ordered dithering for any palette, after Thomas Knoll's patent of 1999 (US 6,606,166, expired): for each colour, 16 entries of the palette
//! are chosen one after the other, each to make up for the error of those before; sorted by brightness, a threshold matrix picks one of
//! them by place. What a pixel becomes depends on its colour and place alone, so that still parts of an animation are still: error
//! diffusion would let them crawl.

use std::collections::HashMap;

use super::palette::{CELLS, cell_of};

/// Number of entries that mix to a colour.
const MIXED: usize = 16;

/// Bayer's threshold matrix of order 4.
const THRESHOLDS: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

/// Colours that are remembered at once.
const MAX_REMEMBERED: usize = 1 << 20;

/// No entry is known yet.
const UNKNOWN: u16 = u16::MAX;

/// A palette with what is known of its mixtures.
pub(super) struct Ditherer {
    palette: Vec<[u8; 3]>,
    exact: HashMap<[u8; 3], u8>,
    /// The entry nearest to the middle of each cell of the colour space.
    nearest: Vec<u16>,
    mixtures: HashMap<[u8; 3], [u8; MIXED]>,
}

impl Ditherer {
    /// A ditherer for a palette of 1 to 256 colours.
    pub fn new(palette: Vec<[u8; 3]>) -> Self {
        let exact = palette.iter().enumerate().map(|(i, &color)| (color, i as u8)).collect();
        Self { palette, exact, nearest: vec![UNKNOWN; CELLS], mixtures: HashMap::new() }
    }

    /// Returns the entry for a colour at a place.
    pub fn entry(&mut self, color: [u8; 3], [x, y]: [usize; 2]) -> u8 {
        if let Some(&entry) = self.exact.get(&color) {
            return entry;
        }
        let threshold = usize::from(THRESHOLDS[y % 4][x % 4]);
        if let Some(mixture) = self.mixtures.get(&color) {
            return mixture[threshold];
        }
        if self.mixtures.len() >= MAX_REMEMBERED {
            self.mixtures.clear();
        }
        let mixture = self.mixture(color);
        self.mixtures.insert(color, mixture);
        mixture[threshold]
    }

    /// The entries that mix to a colour, from dark to bright.
    fn mixture(&mut self, color: [u8; 3]) -> [u8; MIXED] {
        let mut error = [0i32; 3];
        let mut mixture = [0; MIXED];
        for chosen in &mut mixture {
            let wanted = std::array::from_fn(|c| (i32::from(color[c]) + error[c]).clamp(0, 255) as u8);
            *chosen = self.nearest(wanted);
            let got = self.palette[usize::from(*chosen)];
            for c in 0..3 {
                error[c] += i32::from(color[c]) - i32::from(got[c]);
            }
        }
        mixture.sort_by_key(|&entry| (brightness(self.palette[usize::from(entry)]), entry));
        mixture
    }

    fn nearest(&mut self, color: [u8; 3]) -> u8 {
        let cell = cell_of(color);
        if self.nearest[cell] == UNKNOWN {
            // The middle, for all colours of the cell; what is wrong by it, the next entry makes up for.
            let middle = color.map(|c| c & !3 | 2);
            let nearest = (0..self.palette.len()).min_by_key(|&i| distance(self.palette[i], middle));
            self.nearest[cell] = nearest.unwrap_or(0) as u16;
        }
        self.nearest[cell] as u8
    }
}

/// Luma of sRGB, times 1000.
fn brightness([r, g, b]: [u8; 3]) -> u32 {
    299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b)
}

/// Squared distance, by weights near those of the eye.
fn distance(a: [u8; 3], b: [u8; 3]) -> i32 {
    let d: [i32; 3] = std::array::from_fn(|c| i32::from(a[c]) - i32::from(b[c]));
    2 * d[0] * d[0] + 4 * d[1] * d[1] + 3 * d[2] * d[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mixtures_mean_the_colour() {
        let mut ditherer = Ditherer::new(vec![[0; 3], [255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]]);
        for color in [[128, 128, 128], [180, 30, 40], [10, 10, 10], [60, 200, 60]] {
            let mut sum = [0i32; 3];
            for (x, y) in (0..16).map(|i| (i % 4, i / 4)) {
                let entry = ditherer.entry(color, [x, y]);
                (0..3).for_each(|c| sum[c] += i32::from(ditherer.palette[usize::from(entry)][c]));
            }
            // The error that is left over is one entry's, of sixteen.
            for c in 0..3 {
                assert!((sum[c] / 16 - i32::from(color[c])).abs() <= 24, "{color:?} {sum:?}");
            }
        }
        assert_eq!(ditherer.entry([255, 0, 0], [3, 1]), 1, "an entry stands for itself");
    }
}
