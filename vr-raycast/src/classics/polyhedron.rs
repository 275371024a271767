//! A convex polyhedron around the visible blocks.

use vr_core::IndexRay;

use crate::leap::{Leaper, VisibleBlocks};

/// The polyhedron of 26 faces that fits the visible blocks most closely: between two planes in each of 13 directions, those of
/// the faces, edges and corners of a cube.
///
/// PARC (Avila, Sobierajski & Kaufman 1992, "Towards a comprehensive volume visualization system") projects the faces of a coarse polygon
/// model of the visible voxels into a depth buffer, which holds for each pixel where its ray enters and where it leaves. Of a convex
/// model, those two places are where the ray meets its half spaces; so they are found here per ray, without a buffer, for any
/// projection and from inside. Hollows of the model, which the buffer skips no more than this does, stay inside.
#[derive(Clone, Debug)]
pub(crate) struct Polyhedron {
    /// Pairs of planes, one for each direction, between which everything visible lies; in cells, a beam's reach
    /// larger than the blocks. Nothing is visible where the first one is empty.
    slabs: [Slab; NORMALS.len()],
}

/// Normals of the planes, half of them: the others are their opposites.
const NORMALS: [[i8; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [1, -1, -1],
];

/// The space between two parallel planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slab {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Slab {
    /// Keeps the s of a part with low ≤ x + s·slope ≤ high.
    #[inline(always)]
    pub(super) fn cut(&self, x: f64, slope: f64, part: &mut (f64, f64)) {
        if slope == 0.0 {
            // Parallel: all or nothing. 0/0 would be NaN.
            if !(self.low <= x && x <= self.high) {
                part.1 = f64::NEG_INFINITY;
            }
            return;
        }
        let (a, b) = ((self.low - x) / slope, (self.high - x) / slope);
        part.0 = part.0.max(a.min(b));
        part.1 = part.1.min(a.max(b));
    }
}

/// Returns the first and the last visible block of a row.
fn ends(row: &[u64]) -> Option<(usize, usize)> {
    let first = row.iter().position(|w| *w != 0)?;
    let last = row.iter().rposition(|w| *w != 0)?;
    let low = row[first].trailing_zeros() as usize;
    let high = 63 - row[last].leading_zeros() as usize;
    Some((first * 64 + low, last * 64 + high))
}

impl Polyhedron {
    /// Fits the polyhedron around visible blocks.
    pub(crate) fn new(blocks: &VisibleBlocks) -> Self {
        let grid = blocks.grid();
        let mut slabs = [Slab { low: f64::INFINITY, high: f64::NEG_INFINITY }; NORMALS.len()];
        for z in 0..grid.blocks[2] {
            for y in 0..grid.blocks[1] {
                let Some((first, last)) = ends(blocks.row(y, z)) else { continue };
                // The corners of the row's part between its first and its last visible block.
                let corners = [[first, last + 1], [y, y + 1], [z, z + 1]].map(|pair| pair.map(|c| c as f64));
                for (slab, normal) in slabs.iter_mut().zip(NORMALS) {
                    let (mut min, mut max) = (0.0, 0.0);
                    for a in 0..3 {
                        let [x0, x1] = corners[a].map(|c| c * f64::from(normal[a]));
                        min += x0.min(x1);
                        max += x0.max(x1);
                    }
                    slab.low = slab.low.min(min);
                    slab.high = slab.high.max(max);
                }
            }
        }
        for (slab, normal) in slabs.iter_mut().zip(NORMALS) {
            let edge = grid.edge as f64;
            let reach = grid.reach * normal.iter().map(|n| f64::from(n.abs())).sum::<f64>();
            *slab = Slab { low: (slab.low - reach) * edge, high: (slab.high + reach) * edge };
        }
        Self { slabs }
    }
}

impl Leaper for Polyhedron {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        if self.slabs[0].low > self.slabs[0].high {
            return None;
        }
        let mut part = (ray.start.max(from), ray.end);
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        for (slab, normal) in self.slabs.iter().zip(NORMALS) {
            let along = |v: [f64; 3]| (0..3).map(|a| f64::from(normal[a]) * v[a]).sum::<f64>();
            slab.cut(along(origin), along(direction), &mut part);
        }
        (part.0 <= part.1 && part.1 > from).then_some(part)
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_several_words_have_ends() {
        for visible in [vec![], vec![3], vec![63, 64], vec![1, 70], vec![128]] {
            let mut row = [0u64; 3];
            visible.iter().for_each(|&x: &usize| row[x / 64] |= 1 << (x % 64));
            assert_eq!(ends(&row), visible.first().copied().zip(visible.last().copied()));
        }
    }

    #[test]
    fn a_block_is_its_own_hull_and_nothing_has_none() {
        let one = Polyhedron::new(&VisibleBlocks::from_fn([17; 3], 4, |b| b == [1, 2, 3]));
        let axes = [[4.0, 8.0], [8.0, 12.0], [12.0, 16.0]];
        for (slab, [low, high]) in one.slabs.iter().zip(axes) {
            assert!((slab.low - low).abs() < 1e-4 && (slab.high - high).abs() < 1e-4, "{slab:?}");
        }
        // x + y, x − y.
        assert!((one.slabs[3].low - 12.0).abs() < 1e-4 && (one.slabs[4].high - 0.0).abs() < 1e-4);
        let nothing = Polyhedron::new(&VisibleBlocks::from_fn([17; 3], 4, |_| false));
        assert!(nothing.slabs[0].low > nothing.slabs[0].high);
    }
}
