//! Cells that may be visible, a bit each.

use vr_core::parallel::each_part;
use vr_kernels::bits::WORD;

use super::dense::{Dense, Layout};
use super::pyramid::{EDGE, VisibleBlocks};
use super::runs::edges;
use super::{Leveled, Rule, VisibleLevels};

/// A bit for each cell, row by row of cells, layer by layer.
pub(crate) struct CellMasks {
    /// Words of a row.
    pub words: usize,
    bits: Vec<u64>,
}

impl CellMasks {
    /// Mask of the cells with `N` edges. Looks at those of blocks that may be visible and are not visible throughout.
    pub fn new<const N: usize, T: Leveled>(dense: &Dense<'_, T>, blocks: &VisibleBlocks, rule: Rule<'_>) -> Self {
        let layout = &dense.layout;
        let words = (layout.size[0] - 1).div_ceil(WORD);
        let rows = layout.cell_rows();
        let mut bits = vec![0u64; words * rows * layout.cell_layers::<N>()];
        each_part(bits.chunks_mut(words * rows), |k, bits| {
            let (mut may, mut all) = (vec![0; words], vec![0; words]);
            for (row_of_blocks, bits) in bits.chunks_mut(words * EDGE).enumerate() {
                blocks.mark::<N>(layout, k, row_of_blocks, [&mut may, &mut all]);
                for (i, (&may, &all)) in may.iter().zip(&all).enumerate().filter(|(_, (may, _))| **may != 0) {
                    for (row, bits) in bits.chunks_exact_mut(words).enumerate() {
                        let v = row_of_blocks * EDGE + row;
                        bits[i] = visible_cells::<N, T>(dense, rule, [i, v, k], may, all, blocks.missing());
                    }
                }
            }
        });
        Self { words, bits }
    }

    /// The cells of a row.
    pub fn row(&self, layout: &Layout, layer: usize, row: usize) -> &[u64] {
        let i = (layer * layout.cell_rows() + row) * self.words;
        &self.bits[i..i + self.words]
    }
}

/// The visible ones of the up to 64 cells of word `i` of a row, given those that may be and those that are.
#[inline]
fn visible_cells<const N: usize, T: Leveled>(
    dense: &Dense<'_, T>,
    rule: Rule<'_>,
    [i, v, k]: [usize; 3],
    may: u64,
    all: u64,
    missing: bool,
) -> u64 {
    let ask = may & !all;
    if ask == 0 && !missing {
        return all;
    }
    let first = i * WORD;
    let cells = (dense.layout.size[0] - 1 - first).min(WORD);
    // The voxels of the cells' edges: one more than there are cells.
    let edges = edges::<N>().map(|[dv, dk]| dense.row([first, v + dv, k + dk], cells + 1));
    let seen = match rule {
        _ if ask == 0 => 0,
        Rule::Everything => ask,
        Rule::Interpolated(visibility) => interpolated(edges, visibility, ask),
        Rule::Classified(visibility) => classified(edges, visibility, ask),
    };
    let seen = all | seen;
    if missing { seen & !vacuum(edges) } else { seen }
}

/// The cells among those asked for with anything visible between their smallest and their largest corner.
fn interpolated<const N: usize, T: Leveled>(edges: [&[T]; N], visibility: &VisibleLevels, ask: u64) -> u64 {
    let voxels = edges[0].len();
    let mut low = [edges[0][0]; WORD + 1];
    low[..voxels].copy_from_slice(edges[0]);
    let mut high = low;
    // Over the edges, then over the neighbours along u: vector code in the samples' own type.
    for edge in &edges[1..] {
        for ((low, high), &s) in low.iter_mut().zip(&mut high).zip(*edge) {
            *low = if s < *low { s } else { *low };
            *high = if s > *high { s } else { *high };
        }
    }
    for u in 0..WORD {
        low[u] = if low[u + 1] < low[u] { low[u + 1] } else { low[u] };
        high[u] = if high[u + 1] > high[u] { high[u + 1] } else { high[u] };
    }
    by_blocks(ask, |u| visibility.between(low[u], high[u]))
}

/// The cells among those asked for with a corner that is visible itself.
fn classified<const N: usize, T: Leveled>(edges: [&[T]; N], visibility: &VisibleLevels, ask: u64) -> u64 {
    let voxels = edges[0].len();
    by_blocks(ask, |u| {
        // Where a block ends within a row, nothing is.
        u + 1 < voxels && edges.iter().any(|edge| visibility.at(edge[u]) || visibility.at(edge[u + 1]))
    })
}

/// The bits among those asked for that `see` sets. Whole blocks are asked for, and those at the row's end beyond it.
#[inline(always)]
fn by_blocks(ask: u64, see: impl Fn(usize) -> bool) -> u64 {
    let mut left = ask;
    let mut seen = 0;
    while left != 0 {
        let block = left.trailing_zeros() as usize / EDGE * EDGE;
        let mut bits = 0;
        for u in 0..EDGE {
            bits |= u64::from(see(block + u)) << u;
        }
        seen |= bits << block;
        left &= !(((1 << EDGE) - 1) << block);
    }
    seen & ask
}

/// The cells with a corner that is missing.
fn vacuum<const N: usize, T: Leveled>(edges: [&[T]; N]) -> u64 {
    let mut missing = [false; WORD + 1];
    for edge in edges {
        for (missing, s) in missing.iter_mut().zip(edge) {
            *missing |= s.is_missing();
        }
    }
    (0..WORD).fold(0, |bits, u| bits | u64::from(missing[u] | missing[u + 1]) << u)
}
