//! Tight runs, and the voxels that they touch packed one behind the other.

use vr_core::RenderError;
use vr_core::parallel::{collect, each_part};
use vr_kernels::bits::{WORD, count_ones, count_runs, ones};

use super::PAD;
use super::dense::{Dense, Layout};
use super::masks::CellMasks;
use super::pyramid::VisibleBlocks;
use super::runs::{Run, Runs, edges, running_sums, split_by_rows};
use super::{Leveled, Rule};

/// Set of stored voxels, in the order layer, row, column: those that visible cells touch. Several arrays can be packed alike.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    layout: Layout,
    /// Words of a row of voxels.
    words: usize,
    /// A bit for each voxel.
    masks: Vec<u64>,
    /// Begin of each row of voxels, and the end of the last.
    starts: Vec<u32>,
}

/// The runs of the cells that may be visible under `rule`, exactly, and which voxels they need.
///
/// Only the cells of `blocks` are looked at, which must come from the same rule.
///
/// # Errors
/// [`RenderError::TooLarge`] for more voxels or runs than u32 counts.
pub(crate) fn packed<const N: usize, T: Leveled>(
    dense: &Dense<'_, T>,
    blocks: &VisibleBlocks,
    rule: Rule<'_>,
) -> Result<(Runs<N>, Packing), RenderError> {
    let layout = dense.layout;
    let cells = CellMasks::new::<N, T>(dense, blocks, rule);
    let packing = Packing::new::<N>(layout, &cells)?;
    let runs = packing.runs::<N>(&cells)?;
    Ok((runs, packing))
}

impl Packing {
    fn new<const N: usize>(layout: Layout, cells: &CellMasks) -> Result<Self, RenderError> {
        let [nu, nv, nw] = layout.size;
        let words = nu.div_ceil(WORD);
        let mut masks = vec![0u64; words * nv * nw];
        let mut counts = vec![0u32; nv * nw];
        let (rows, layers) = (layout.cell_rows(), layout.cell_layers::<N>());
        let layers_of_voxels = masks.chunks_mut(words * nv).zip(counts.chunks_mut(nv));
        each_part(layers_of_voxels, |k, (masks, counts)| {
            for (v, (mask, count)) in masks.chunks_exact_mut(words).zip(counts.iter_mut()).enumerate() {
                // The rows of cells of which this row of voxels is an edge.
                for [dv, dk] in edges::<N>() {
                    if v < dv || k < dk || v - dv >= rows || k - dk >= layers {
                        continue;
                    }
                    let mut carry = 0;
                    let row = cells.row(&layout, k - dk, v - dv);
                    for (i, mask) in mask.iter_mut().enumerate() {
                        let word = row.get(i).copied().unwrap_or(0);
                        // A cell has the voxels on its left and on its right.
                        *mask |= word | word << 1 | carry;
                        carry = word >> (WORD - 1);
                    }
                }
                *count = count_ones(mask) as u32;
            }
        });
        let starts = running_sums("voxels of a run-length encoded volume", counts.into_iter())?;
        Ok(Self { layout, words, masks, starts })
    }

    fn runs<const N: usize>(&self, cells: &CellMasks) -> Result<Runs<N>, RenderError> {
        let layout = &self.layout;
        let (rows, layers) = (layout.cell_rows(), layout.cell_layers::<N>());
        let counts: Vec<u32> =
            collect(rows * layers, |row| count_runs(cells.row(layout, row / rows, row % rows)) as u32);
        let starts = running_sums("runs of a run-length encoded volume", counts.into_iter())?;
        let empty = Run { start: 0, len: 0, at: [0; N] };
        let mut runs = vec![empty; starts[rows * layers] as usize];
        each_part(split_by_rows(&mut runs, &starts, rows), |k, runs| {
            let mut runs = runs.iter_mut();
            for v in 0..rows {
                let row = cells.row(layout, k, v);
                let mut ranks = edges::<N>().map(|[dv, dk]| self.ranks(k + dk, v + dv));
                for ((start, len), run) in ones(row).zip(&mut runs) {
                    let at = ranks.each_mut().map(|ranks| ranks.at(start));
                    *run = Run { start: start as u32, len: len as u32, at };
                }
            }
        });
        Ok(Runs::new(*layout, starts, runs))
    }

    fn mask(&self, k: usize, v: usize) -> &[u64] {
        let at = (k * self.layout.size[1] + v) * self.words;
        &self.masks[at..at + self.words]
    }

    fn ranks(&self, k: usize, v: usize) -> Ranks<'_> {
        Ranks { mask: self.mask(k, v), word: 0, before: self.starts[k * self.layout.size[1] + v] }
    }

    /// Number of stored voxels.
    pub fn stored(&self) -> usize {
        self.starts[self.starts.len() - 1] as usize
    }

    /// Codes of the stored ones of an array of all voxels, and [`PAD`] defaults behind them.
    pub fn pack<T: Leveled, P: Copy + Default + Send>(
        &self,
        dense: &Dense<'_, T>,
        code: impl Fn(T) -> P + Sync,
    ) -> Vec<P> {
        debug_assert_eq!(dense.layout, self.layout);
        self.fill(&|voxel, to| {
            let samples = dense.row(voxel, to.len());
            for (to, &sample) in to.iter_mut().zip(samples) {
                *to = code(sample);
            }
        })
    }

    /// Fills an array run by run of stored voxels, which begin at a voxel (u, v, k), with [`PAD`] defaults behind them.
    pub fn fill<P: Copy + Default + Send>(&self, run: &(dyn Fn([usize; 3], &mut [P]) + Sync)) -> Vec<P> {
        let mut voxels = vec![P::default(); self.stored() + PAD];
        let nv = self.layout.size[1];
        each_part(split_by_rows(&mut voxels, &self.starts, nv), |k, voxels| {
            let mut voxels = std::mem::take(voxels);
            for v in 0..nv {
                for (u, len) in ones(self.mask(k, v)) {
                    let (now, later) = voxels.split_at_mut(len);
                    run([u, v, k], now);
                    voxels = later;
                }
            }
        });
        voxels
    }
}

/// Counts the stored voxels before each of growing columns of a row.
struct Ranks<'a> {
    mask: &'a [u64],
    word: usize,
    /// Stored voxels before `word`, from the first row on.
    before: u32,
}

impl Ranks<'_> {
    /// Index of the stored column `u`; columns must be asked for in their order.
    #[inline]
    fn at(&mut self, u: usize) -> u32 {
        while self.word < u / WORD {
            self.before += self.mask[self.word].count_ones();
            self.word += 1;
        }
        let left = self.mask[self.word] & ((1 << (u % WORD)) - 1);
        self.before + left.count_ones()
    }
}
