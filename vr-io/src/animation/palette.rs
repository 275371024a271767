//! The colours of a GIF, chosen for all frames together: a palette of its own for each frame would make still parts flicker.

use std::collections::{HashMap, HashSet};

/// Number of colours; one more index says that a pixel is as before.
pub(super) const COLORS: usize = 255;

/// Bits of a channel by which colours are counted.
const BITS: u32 = 6;

/// Count of the colours of all frames, in cells of the colour space: its size does not depend on how many there are.
pub(super) struct ColorCount {
    /// Number of pixels and sum of their colours, of each cell.
    cells: Vec<(u64, [u64; 3])>,
    /// All colours, as long as a palette can hold them.
    few: Option<HashSet<[u8; 3]>>,
    /// The most common colour of the first frame: the background, which must stay as it is.
    common: Option<[u8; 3]>,
}

impl ColorCount {
    pub fn new() -> Self {
        Self { cells: vec![(0, [0; 3]); 1 << (3 * BITS)], few: Some(HashSet::new()), common: None }
    }

    /// Counts the pixels of a frame.
    pub fn add(&mut self, pixels: &[[u8; 3]]) {
        for pixel in pixels {
            let (count, sum) = &mut self.cells[cell_of(*pixel)];
            *count += 1;
            sum.iter_mut().zip(pixel).for_each(|(sum, &c)| *sum += u64::from(c));
        }
        if let Some(few) = &mut self.few {
            // Neighbours are alike: most are seen at once.
            let mut last = None;
            for pixel in pixels.iter().filter(|&&p| last.replace(p) != Some(p)) {
                few.insert(*pixel);
                if few.len() > COLORS {
                    self.few = None;
                    break;
                }
            }
        }
        if self.common.is_none() {
            let mut counts = HashMap::new();
            pixels.iter().for_each(|p| *counts.entry(*p).or_insert(0usize) += 1);
            self.common = counts.into_iter().max_by_key(|&(color, count)| (count, color)).map(|(color, _)| color);
        }
    }

    /// Returns the palette: all colours where they are few, else the background, the ends of the colours in every direction, without which
    /// no mixture reaches them, and the means of groups of colours that are alike.
    pub fn palette(&self) -> Vec<[u8; 3]> {
        if let Some(few) = &self.few {
            let mut colors: Vec<[u8; 3]> = few.iter().copied().collect();
            colors.sort_unstable();
            return colors;
        }
        // A cell counts by the root of its pixels: a highlight is small, and seen.
        let occupied = self.cells.iter().filter(|(count, _)| *count > 0);
        let samples: Vec<Sample> = occupied
            .map(|&(count, sum)| Sample {
                color: sum.map(|sum| sum as f64 / count as f64),
                weight: (count as f64).sqrt(),
            })
            .collect();
        let mut colors: Vec<[u8; 3]> = self.common.into_iter().chain(ends(&samples)).collect();
        colors.sort_unstable();
        colors.dedup();
        let means = group_means(samples, COLORS - colors.len());
        colors.extend(means);
        colors.sort_unstable();
        colors.dedup();
        colors
    }
}

/// Colours of a cell: their mean, and how much they count.
#[derive(Clone, Copy)]
struct Sample {
    color: [f64; 3],
    weight: f64,
}

fn rounded(color: [f64; 3]) -> [u8; 3] {
    color.map(|c| (c + 0.5) as u8)
}

/// Farthest colours along the axes and the diagonals.
fn ends(samples: &[Sample]) -> impl Iterator<Item = [u8; 3]> {
    const DIRECTIONS: [[f64; 3]; 7] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [1.0, -1.0, 1.0],
        [-1.0, 1.0, 1.0],
    ];
    let both = DIRECTIONS.into_iter().flat_map(|d| [d, d.map(|c| -c)]);
    both.filter_map(|direction| {
        let along = |s: &Sample| (0..3).map(|c| s.color[c] * direction[c]).sum::<f64>();
        samples.iter().max_by(|a, b| along(a).total_cmp(&along(b))).map(|sample| rounded(sample.color))
    })
}

/// Colours that are alike.
struct Group {
    samples: Vec<Sample>,
    mean: [f64; 3],
    /// Component that differs most, and the sum of its squared differences, each times what it counts.
    spread: (usize, f64),
}

impl Group {
    fn new(samples: Vec<Sample>) -> Self {
        let weight: f64 = samples.iter().map(|s| s.weight).sum();
        let sum = |of: &dyn Fn(&Sample) -> f64| samples.iter().map(|s| s.weight * of(s)).sum::<f64>();
        let mean: [f64; 3] = std::array::from_fn(|c| sum(&|s| s.color[c]) / weight);
        let spreads = [0, 1, 2].map(|c| (c, sum(&|s| (s.color[c] - mean[c]) * (s.color[c] - mean[c]))));
        let spread = spreads.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        Self { samples, mean, spread }
    }
}

/// Divides colours into at most `count` groups, always that of the largest spread at its mean (after Wan, Prusinkiewicz and Wong 1990), and
/// returns the means of the groups.
fn group_means(samples: Vec<Sample>, count: usize) -> Vec<[u8; 3]> {
    if samples.is_empty() || count == 0 {
        return Vec::new();
    }
    let mut groups = vec![Group::new(samples)];
    while groups.len() < count {
        let widest = (0..groups.len()).max_by(|&a, &b| groups[a].spread.1.total_cmp(&groups[b].spread.1)).unwrap_or(0);
        let Group { samples, mean, spread: (axis, spread) } = groups.swap_remove(widest);
        let (below, above): (Vec<Sample>, Vec<Sample>) =
            samples.iter().copied().partition(|s| s.color[axis] < mean[axis]);
        if spread <= 0.0 || below.is_empty() || above.is_empty() {
            // The group of the largest spread has none: so has every other.
            groups.push(Group { samples, mean, spread: (axis, 0.0) });
            break;
        }
        groups.extend([Group::new(below), Group::new(above)]);
    }
    groups.into_iter().map(|group| rounded(group.mean)).collect()
}

/// Index of the cell that a colour is in.
pub(super) fn cell_of(color: [u8; 3]) -> usize {
    color.iter().fold(0, |cell, &c| (cell << BITS) | usize::from(c >> (8 - BITS)))
}

/// Number of cells.
pub(super) const CELLS: usize = 1 << (3 * BITS);
