//! Samples inside the outline of a cell.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, u32x16};
use vr_kernels::vector::LANES;

use super::outline::Outline;
use super::samples::{COUNT, Numbers, ROW, SPARE, Samples, bits, boxed};
use super::screen_mesh::ScreenVertex;
use super::tiling::MAX_SIDE;

/// Numbers of samples of a tile, one after the other whatever row they are in.
pub(super) struct CellSamples {
    numbers: Box<[u32; COUNT + LANES]>,
    pub(super) count: usize,
    /// First sample of each row, and the first one beyond the last.
    spans: [[f64; SPANS]; 2],
}

/// Rows of a tile, and as many as are found beyond.
const SPANS: usize = MAX_SIDE as usize + ROWS_AT_ONCE;

/// Sixteen numbers in a row.
const IN_A_ROW: Numbers = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Rows of an edge that are found at once, and their places below the first.
const ROWS_AT_ONCE: usize = 8;
const DOWN: [f64; ROWS_AT_ONCE] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Number of centres of samples before a place on an axis, of those of a tile.
#[inline(always)]
fn centres_before(place: f64, count: u32) -> u32 {
    let before = place - 0.5;
    // Without `clamp` and `ceil`, which care for NaN and call a function where the machine has none.
    let most = f64::from(count);
    let before = if before > 0.0 { before } else { 0.0 };
    let before = if before < most { before } else { most };
    let whole = before as u32;
    whole + u32::from(f64::from(whole) < before)
}

/// Part of a sample within which the crossing of an edge counts as near to a centre.
const DOUBTFUL: f64 = 1e-6;

/// Numbers of centres before an edge in some rows, by sides of the centres: on the vertices' lattice both products are exact, and so is the sign.
#[inline(never)]
fn exact_counts(
    before: [f64; ROWS_AT_ONCE],
    row: u32,
    [[x, y], [to_x, to_y]]: [[f64; 2]; 2],
    most: f64,
) -> [f64; ROWS_AT_ONCE] {
    std::array::from_fn(|i| {
        let nearest = libm::floor(before[i] + 0.5);
        if (before[i] - nearest).abs() >= DOUBTFUL {
            return libm::ceil(before[i]);
        }
        let below = f64::from(row) + i as f64 + 0.5 - y;
        let is_before = (nearest + 0.5 - x) * (to_y - y) < below * (to_x - x);
        (nearest + f64::from(u8::from(is_before))).min(most)
    })
}

impl CellSamples {
    /// None.
    pub(super) fn new() -> Self {
        Self { numbers: boxed(0), count: 0, spans: [[0.0; SPANS]; 2] }
    }

    /// Finds the open samples inside an outline.
    ///
    /// The place at which an edge crosses a row follows from the ends of the edge alone, and is exact if a sample is near: two cells that share the edge get the
    /// same place, so that each sample of the row belongs to one of them. One edge on the left and one on the right cross each row.
    #[inline(always)]
    pub(super) fn find<S: Simd>(
        &mut self,
        simd: S,
        outline: &Outline,
        corners: &[ScreenVertex; 4],
        size: [u32; 2],
        samples: &Samples,
    ) {
        let most = f64::from(size[0]);
        let down = f64x8::load_array_ref(simd, &DOWN);
        let mut rows = [u32::MAX, 0];
        for edge in &outline.edges[..outline.count] {
            let [a, b] = edge.ends.map(|i| corners[i].at);
            // Going up, the inside is on the right.
            let (side, [x, y], [to_x, to_y]) = if a[1] > b[1] { (0, b, a) } else { (1, a, b) };
            let (first, end) = (centres_before(y, size[1]), centres_before(to_y, size[1]));
            if first >= end {
                continue;
            }
            let slope = (to_x - x) / (to_y - y);
            for row in (first..end).step_by(ROWS_AT_ONCE) {
                let crossing = (down + (f64::from(row) + 0.5 - y)) * slope + (x - 0.5);
                let before = crossing.max(f64x8::splat(simd, 0.0)).min(f64x8::splat(simd, most));
                let mut whole = before.ceil();
                // The rows below are another edge's.
                let is_on_edge = down.simd_lt(f64x8::splat(simd, f64::from(end - row)));
                // A centre that is met, or nearly: rounding must not tell the side, because other edges may lie in the same line.
                let off = crossing - (crossing + 0.5).floor();
                let is_inside = (crossing - before).abs().simd_lt(f64x8::splat(simd, 0.5));
                let doubtful = off.abs().simd_lt(f64x8::splat(simd, DOUBTFUL)) & is_on_edge & is_inside;
                if doubtful.any_true() {
                    let ends = [[x, y], [to_x, to_y]];
                    whole = f64x8::load_array_ref(simd, &exact_counts(before.to_array(), row, ends, most));
                }
                let row = row as usize % MAX_SIDE as usize;
                let spans = &mut self.spans[side][row..row + ROWS_AT_ONCE];
                is_on_edge.select(whole, f64x8::from_slice(simd, spans)).store_slice(spans);
            }
            rows = [rows[0].min(first), rows[1].max(end)];
        }
        self.count = 0;
        for row in rows[0]..rows[1] {
            let [from, to] = [0, 1].map(|side| self.spans[side][row as usize % MAX_SIDE as usize] as u32);
            if from < to {
                let (span, first) = (bits(from, to), row << ROW);
                let mut open = span & samples.open(row);
                if open == span {
                    self.push(simd, first + from, to - from);
                } else {
                    // Runs of open samples.
                    while open != 0 {
                        let start = open.trailing_zeros();
                        let length = (!(open >> start)).trailing_zeros();
                        self.push(simd, first + start, length);
                        open &= !bits(start, start + length);
                    }
                }
            }
        }
        if self.count > 0 {
            // Lanes that are left over.
            let last = self.numbers[self.count - 1] | SPARE;
            u32x16::splat(simd, last).store_slice(&mut self.numbers[self.count..self.count + LANES]);
        }
    }

    /// Adds numbers that follow one another.
    #[inline(always)]
    fn push<S: Simd>(&mut self, simd: S, first: u32, length: u32) {
        let mut done = 0;
        while done < length {
            let numbers = u32x16::load_array_ref(simd, &IN_A_ROW) + u32x16::splat(simd, first + done);
            let at = self.count + done as usize;
            numbers.store_slice(&mut self.numbers[at..at + LANES]);
            done += LANES as u32;
        }
        self.count += length as usize;
    }

    /// Sixteen of them, from one on; behind the last, spare ones.
    #[inline(always)]
    pub(super) fn sixteen(&self, first: usize) -> &Numbers {
        self.numbers[first..first + LANES].try_into().unwrap_or(&IN_A_ROW)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::super::outline::RimEdge;
    use super::super::screen_mesh::Facing;
    use super::*;

    /// The outline of a cell whose first three corners hide the fourth, or are hidden by it.
    fn outline(corners: &[ScreenVertex; 4]) -> Outline {
        let facings = [0b1000_0111, 0b0111_1000].map(Facing);
        facings.into_iter().find_map(|facing| Outline::new(corners, facing)).expect("a cell with an area")
    }

    #[test]
    fn triangles_around_a_place_share_its_samples() {
        // Fans around places on and beside the centres of samples, with corners on others and beyond the tile.
        let size = [40, 37];
        for middle in [[19.5, 17.5], [20.25, 17.5], [20.1, 16.9]] {
            let rim = [[0.5, 0.5], [38.5, -9.5], [57.5, 0.25], [39.5, 45.0], [19.5, 60.5], [-0.5, 40.5], [-30.0, 17.5]];
            let samples = Samples::new(size);
            let mut inside = CellSamples::new();
            let mut hits = vec![0; COUNT];
            for i in 0..rim.len() {
                let [b, c] = [rim[i], rim[(i + 1) % rim.len()]];
                let at = [middle, b, c, [0, 1].map(|a: usize| (middle[a] + b[a] + c[a]) / 3.0)];
                let corners = at.map(|at| ScreenVertex { at, depth: 1.0, value: 0.0 });
                let outline = outline(&corners);
                dispatch!(Level::new(), simd => inside.find(simd, &outline, &corners, size, &samples));
                for first in (0..inside.count).step_by(LANES) {
                    let numbers = inside.sixteen(first);
                    numbers.iter().filter(|&&n| n < SPARE).for_each(|&n| hits[n as usize] += 1);
                    let is_inside = |e: &RimEdge, n: u32| {
                        e.line.at([f64::from(n % MAX_SIDE) + 0.5, f64::from(n / MAX_SIDE) + 0.5]) > -1e-9
                    };
                    assert!(numbers.iter().all(|&n| outline.edges.iter().all(|e| is_inside(e, n % SPARE))));
                }
            }
            for y in 0..size[1] {
                let row = &hits[(y << ROW) as usize..][..size[0] as usize];
                // The fan covers the picture but for its lowest corner on the left.
                assert!(
                    row.iter().all(|&n| n <= 1) && (y > 30 || row.iter().all(|&n| n == 1)),
                    "{middle:?}, row {y}: {row:?}"
                );
            }
        }
    }
}
