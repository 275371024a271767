//! Boxes around the visible blocks.

use vr_core::IndexRay;

use super::polyhedron::Slab;
use crate::leap::BlockGrid;
use crate::leap::{Leaper, VisibleBlocks};

/// Up to [`MOST`] disjoint, axis-parallel boxes that hold all visible blocks.
///
/// The first one bounds them all. Then the box that gains most is cut by a plane, and both parts shrink to what they hold, for as long as
/// that saves a part of the whole that is worth another box to test.
#[derive(Clone, Debug)]
pub(crate) struct Boxes {
    /// Boxes in cells, larger than their blocks by a beam's reach.
    boxes: Vec<[Slab; 3]>,
}

/// Largest number of boxes: each ray is cut by all of them.
const MOST: usize = 8;
/// Fraction of the bounding box's volume that a cut must save.
const WORTH: f64 = 1.0 / 64.0;

/// Box of the blocks `low .. high` along each axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extent {
    low: [usize; 3],
    high: [usize; 3],
}

impl Extent {
    const NONE: Self = Self { low: [usize::MAX; 3], high: [0; 3] };

    fn volume(&self) -> f64 {
        (0..3).map(|a| self.high[a].saturating_sub(self.low[a]) as f64).product()
    }

    fn joined(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|a| self.low[a].min(other.low[a])),
            high: std::array::from_fn(|a| self.high[a].max(other.high[a])),
        }
    }
}

/// Box, and the best two to put in its place.
struct Candidate {
    whole: Extent,
    parts: [Extent; 2],
}

impl Candidate {
    fn new(blocks: &VisibleBlocks, region: &Extent) -> Self {
        let slabs = slabs(blocks, region);
        let union = |slabs: &[Extent]| slabs.iter().fold(Extent::NONE, |all, s| all.joined(s));
        let whole = union(&slabs[0]);
        let mut best = (whole.volume(), [whole, Extent::NONE]);
        for slabs in &slabs {
            // What lies from each slab on.
            let mut behind = slabs.clone();
            for i in (1..slabs.len()).rev() {
                behind[i - 1] = behind[i - 1].joined(&behind[i]);
            }
            let mut before = Extent::NONE;
            for i in 1..slabs.len() {
                before = before.joined(&slabs[i - 1]);
                let volume = before.volume() + behind[i].volume();
                if volume < best.0 {
                    best = (volume, [before, behind[i]]);
                }
            }
        }
        Self { whole, parts: best.1 }
    }

    fn saving(&self) -> f64 {
        self.whole.volume() - self.parts[0].volume() - self.parts[1].volume()
    }
}

/// Returns the extent of the visible blocks in each slab, one block thick, of a region, along each axis.
fn slabs(blocks: &VisibleBlocks, region: &Extent) -> [Vec<Extent>; 3] {
    let Extent { low, high } = *region;
    let mut slabs: [Vec<Extent>; 3] = std::array::from_fn(|a| vec![Extent::NONE; high[a] - low[a]]);
    let words = blocks.words_per_row();
    let cut = |word: u64, i: usize| {
        let bits = |x: usize| if x >= 64 { u64::MAX } else { (1u64 << x) - 1 };
        word & bits(high[0].saturating_sub(64 * i)) & !bits(low[0].saturating_sub(64 * i))
    };
    // The blocks of a row, once per line of words, joined over y and over z.
    let mut over_z = vec![0u64; words * (high[1] - low[1])];
    for z in low[2]..high[2] {
        let mut over_y = vec![0u64; words];
        for y in low[1]..high[1] {
            for (i, &word) in blocks.row(y, z).iter().enumerate() {
                let word = cut(word, i);
                if word != 0 {
                    over_y[i] |= word;
                    over_z[(y - low[1]) * words + i] |= word;
                    let first = 64 * i + word.trailing_zeros() as usize;
                    let last = 64 * i + 63 - word.leading_zeros() as usize;
                    let here = Extent { low: [first, y, z], high: [last + 1, y + 1, z + 1] };
                    slabs[1][y - low[1]] = slabs[1][y - low[1]].joined(&here);
                    slabs[2][z - low[2]] = slabs[2][z - low[2]].joined(&here);
                }
            }
        }
        for x in set_bits(&over_y) {
            let slab = &mut slabs[0][x - low[0]];
            (slab.low[0], slab.high[0]) = (x, x + 1);
            (slab.low[2], slab.high[2]) = (slab.low[2].min(z), z + 1);
        }
    }
    for (y, row) in over_z.chunks(words).enumerate() {
        let y = y + low[1];
        for x in set_bits(row) {
            let slab = &mut slabs[0][x - low[0]];
            (slab.low[1], slab.high[1]) = (slab.low[1].min(y), y + 1);
        }
    }
    slabs
}

fn set_bits(words: &[u64]) -> impl Iterator<Item = usize> + '_ {
    words.iter().enumerate().flat_map(|(i, &word)| {
        let mut left = word;
        std::iter::from_fn(move || {
            let bit = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (bit < 64).then_some(64 * i + bit)
        })
    })
}

impl Boxes {
    /// Finds the boxes around visible blocks.
    pub(crate) fn new(blocks: &VisibleBlocks) -> Self {
        let grid = blocks.grid();
        let mut found = vec![Candidate::new(blocks, &Extent { low: [0; 3], high: grid.blocks })];
        let worth = WORTH * found[0].whole.volume();
        while found.len() < MOST {
            let gains = found.iter().map(Candidate::saving).enumerate();
            let (i, gain) = gains.max_by(|a, b| a.1.total_cmp(&b.1)).expect("one at least");
            if gain <= worth {
                break;
            }
            let [a, b] = found.swap_remove(i).parts.map(|part| Candidate::new(blocks, &part));
            found.extend([a, b]);
        }
        let boxes = found.iter().map(|c| c.whole).filter(|w| w.volume() > 0.0).map(|w| in_cells(&w, &grid)).collect();
        Self { boxes }
    }

    /// Appends the part of a ray in each box, in no order.
    fn parts<'a>(&'a self, ray: &'a IndexRay) -> impl Iterator<Item = (f64, f64)> + 'a {
        self.boxes.iter().filter_map(|slabs| {
            let mut part = (ray.start, ray.end);
            for (a, slab) in slabs.iter().enumerate() {
                slab.cut(ray.origin[a], ray.direction[a], &mut part);
            }
            (part.0 <= part.1).then_some(part)
        })
    }
}

fn in_cells(blocks: &Extent, grid: &BlockGrid) -> [Slab; 3] {
    let edge = grid.edge as f64;
    std::array::from_fn(|a| Slab {
        low: (blocks.low[a] as f64 - grid.reach) * edge,
        high: (blocks.high[a] as f64 + grid.reach) * edge,
    })
}

impl Leaper for Boxes {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        let ahead = || self.parts(ray).filter(|part| part.1 > from);
        let (begin, mut end) = ahead().reduce(|a, b| if b.0 < a.0 { b } else { a })?;
        // Boxes overlap by their thickness where they touch.
        while let Some(part) = ahead().find(|part| part.0 <= end && part.1 > end) {
            end = part.1;
        }
        Some((begin.max(from), end))
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        size_of_val(&self.boxes[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_clusters_and_a_bar_are_three_boxes() {
        let near = |b: [usize; 3], c: [usize; 3]| (0..3).all(|a| b[a].abs_diff(c[a]) <= 1);
        let seen = |b: [usize; 3]| near(b, [3, 3, 3]) || near(b, [90, 12, 20]) || (b[1] == 28 && b[2] == 2);
        let blocks = VisibleBlocks::from_fn([101, 31, 31], 1, seen);
        let boxes = Boxes::new(&blocks);
        let mut sizes: Vec<_> = boxes.boxes.iter().map(|b| b.map(|s| (s.high - s.low).round() as usize)).collect();
        sizes.sort();
        assert_eq!(sizes, [[3, 3, 3], [3, 3, 3], [100, 1, 1]]);
        assert!(Boxes::new(&VisibleBlocks::from_fn([9; 3], 1, |_| false)).boxes.is_empty());
    }
}
