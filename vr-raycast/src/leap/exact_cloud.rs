//! Proximity clouds in the exact Euclidean metric.

use vr_core::IndexRay;
use vr_core::parallel::{each_part, join};

use super::{BlockGrid, Leaper, Region, Regions, VisibleBlocks, next_interval};

/// Proximity cloud: each block stores the Euclidean distance, in block edges, to the nearest block of the other kind, from surface to surface,
/// so that a ball of that radius around *any* point of the block is all of the block's own kind (Cohen & Sheffer 1994, "Proximity clouds",
/// with an exact distance in place of their city block; 0 where the two touch).
///
/// Boxes that are Δ blocks apart along an axis leave max(|Δ| − 1, 0) between them: the least |Δ + e| for e in {−1, 0, 1}. So the gap is
/// the distance to the other kind *grown by one block*. Its square is found axis by axis, as min over k of what lies k away plus
/// k² (Saito & Toriwaki 1994, "New algorithms for Euclidean distance transformation of an n-dimensional digitized picture"), which ends
/// where k² alone exceeds what is known, and goes along whole rows of blocks at once.
#[derive(Clone, Debug)]
pub(crate) struct ExactCloud {
    grid: BlockGrid,
    /// Distance of each block, [`PER_BLOCK`] to a block's edge, rounded down, and [`VISIBLE`] where it can be seen.
    distances: Vec<u16>,
}

/// Bit that is set for a block that can be seen.
const VISIBLE: u16 = 0x8000;
/// Largest distance that is stored: 255.99 blocks.
const FAR: u16 = 0x7fff;
/// Number of stored units per block edge.
const PER_BLOCK: f32 = 128.0;
/// Square of a distance that is larger than any: whole numbers up to 2²⁴ are exact in f32.
const NONE: f32 = (1 << 24) as f32;

impl ExactCloud {
    /// Computes the distances between visible and clear blocks.
    pub(crate) fn new(blocks: &VisibleBlocks) -> Self {
        let grid = blocks.grid();
        let clear = blocks.inverted();
        let (mut distances, to_clear) =
            join(|| stored(&squares(&blocks.dilated()), 0), || stored(&squares(&clear.dilated()), VISIBLE));
        blocks.for_each_beyond(&clear, |i| distances[i] = to_clear[i]);
        Self { grid, distances }
    }
}

/// Returns the numbers that are stored for squares of distances.
fn stored(squares: &[f32], flag: u16) -> Vec<u16> {
    // Rounded down twice over: by the cast, and by a unit that makes up for the root's rounding up.
    let of = |&square: &f32| {
        let exact = square.sqrt() * PER_BLOCK;
        flag | if square == 0.0 { 0 } else { (exact as u16).saturating_sub(1).min(FAR) }
    };
    squares.iter().map(of).collect()
}

/// Returns the square of each block's Euclidean distance from the nearest one of a set, centre to centre; [`NONE`] if the set is empty.
fn squares(set: &VisibleBlocks) -> Vec<f32> {
    let BlockGrid { blocks: [w, h, d], .. } = set.grid();
    let mut along_x = vec![NONE; w * h * d];
    each_row(&mut along_x, w, |row, out| {
        let bits = set.row(row % h, row / h);
        let is_set = |x: usize| bits[x / 64] >> (x % 64) & 1 == 1;
        let mut steps = f32::INFINITY;
        for x in 0..w {
            steps = if is_set(x) { 0.0 } else { steps + 1.0 };
            out[x] = (steps * steps).min(NONE);
        }
        steps = f32::INFINITY;
        for x in (0..w).rev() {
            steps = if is_set(x) { 0.0 } else { steps + 1.0 };
            out[x] = out[x].min(steps * steps);
        }
    });
    let mut along_y = along_x.clone();
    each_row(&mut along_y, w, |row, out| {
        let slice = &along_x[row / h * h * w..][..h * w];
        nearest(out, row % h, h, |y| &slice[y * w..][..w]);
    });
    let mut all = along_y.clone();
    each_row(&mut all, w, |row, out| {
        nearest(out, row / h, d, |z| &along_y[(z * h + row % h) * w..][..w]);
    });
    all
}

/// Calls `work` with the number of each row of `w` entries, and the row.
fn each_row(entries: &mut [f32], w: usize, work: impl Fn(usize, &mut [f32]) + Sync) {
    // Rows of a task.
    const ROWS: usize = 64;
    each_part(entries.chunks_mut(ROWS * w), |part, entries| {
        entries.chunks_mut(w).enumerate().for_each(|(row, out)| work(part * ROWS + row, out));
    });
}

/// Lowers a row, the `at`-th of `n`, to the least of each row plus the square of its distance.
fn nearest<'a>(out: &mut [f32], at: usize, n: usize, row: impl Fn(usize) -> &'a [f32]) {
    for k in 1..n {
        let square = (k * k) as f32;
        if out.iter().all(|&o| o <= square) {
            return;
        }
        let rows = [at.checked_sub(k), Some(at + k).filter(|&i| i < n)];
        if rows == [None; 2] {
            return;
        }
        for i in rows.into_iter().flatten() {
            for (o, &r) in out.iter_mut().zip(row(i)) {
                let through = r + square;
                *o = if through < *o { through } else { *o };
            }
        }
    }
}

impl Regions for ExactCloud {
    #[inline(always)]
    fn is_visible(&self, index: usize) -> bool {
        self.distances[index] & VISIBLE != 0
    }

    #[inline(always)]
    fn around(&self, _: [usize; 3], index: usize) -> Region {
        Region::Ball(f64::from(self.distances[index] & FAR) / f64::from(PER_BLOCK))
    }
}

impl Leaper for ExactCloud {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        next_interval(self.grid, self, ray, from)
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        size_of_val(&self.distances[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        /// Distances agree with those of every pair of blocks.
        #[test]
        fn distances_are_the_least_gaps(
            dims in prop::array::uniform3(2usize..9),
            seeds in prop::collection::vec(prop::array::uniform3(0usize..8), 0..5),
        ) {
            let blocks = VisibleBlocks::from_fn(dims, 1, |b| seeds.contains(&b));
            let cloud = ExactCloud::new(&blocks);
            let n = blocks.grid().blocks;
            let all = || (0..n.iter().product()).map(|i: usize| [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])]);
            for (i, block) in all().enumerate() {
                let gap = |other: [usize; 3]| {
                    let square = |a: usize| block[a].abs_diff(other[a]).saturating_sub(1).pow(2) as f64;
                    (square(0) + square(1) + square(2)).sqrt()
                };
                let others = all().filter(|&o| blocks.at(o) != blocks.at(block));
                let least = others.map(gap).fold(f64::INFINITY, f64::min);
                prop_assert_eq!(cloud.is_visible(i), blocks.at(block));
                let Region::Ball(found) = cloud.around(block, i) else { unreachable!() };
                if least.is_finite() {
                    prop_assert!(found <= least && found > least - 0.02, "{found} for {least}");
                } else {
                    prop_assert!(found > 255.0);
                }
            }
        }
    }
}
