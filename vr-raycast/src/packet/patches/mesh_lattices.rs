//! Lattices of the blocks of an adaptive mesh, made for those that can be seen.

use std::sync::OnceLock;

use vr_core::amr::{AmrGrid, AmrLattice, AmrStencil};
use vr_core::cancel;
use vr_core::parallel::collect;

/// Samples of blocks with those beside them, kept with the mesh: each made when it can first be seen.
#[derive(Debug, Default)]
pub(crate) struct MeshLattices {
    values: Vec<OnceLock<Option<AmrLattice>>>,
    /// Samples that gradients are made of.
    differences: Vec<OnceLock<AmrLattice>>,
}

impl MeshLattices {
    pub(crate) fn new(grid: &AmrGrid) -> Self {
        let count = grid.blocks().len();
        let values = (0..count).map(|_| OnceLock::new()).collect();
        Self { values, differences: (0..count).map(|_| OnceLock::new()).collect() }
    }

    /// Makes those of blocks that are seen, and of those of the next coarser level below them; those for gradients, too, if these are asked for.
    pub(crate) fn make(&self, grid: &AmrGrid, has_gradients: bool, is_seen: impl Fn(usize) -> bool) {
        let samples = grid.samples();
        let mut is_wanted: Vec<bool> = (0..self.values.len()).map(is_seen).collect();
        for number in (0..is_wanted.len()).filter(|&number| is_wanted[number]).collect::<Vec<_>>() {
            // Corners, edges and faces of the block: where it is the rim of its level. What is not found here is looked up when it is met.
            for i in (0..27).filter(|&i| i != 13) {
                let dims = grid.blocks()[number].dims;
                let place = |a: usize, side: usize| [0, dims[a] as i32 / 2, dims[a] as i32 - 1][side];
                let cell = [place(0, i % 3), place(1, i / 3 % 3), place(2, i / 9)];
                if let Some(coarser) = samples.coarser_block(number, cell) {
                    is_wanted[coarser] = true;
                }
            }
        }
        cancel::claim("the lattices of the adaptive mesh", self.missing_bytes(grid, has_gradients, &is_wanted));
        collect(is_wanted.len(), |number| {
            if is_wanted[number] {
                self.values[number].get_or_init(|| samples.lattice(number));
                if has_gradients {
                    self.differences[number].get_or_init(|| samples.difference_lattice(number));
                }
            }
        });
    }

    /// Bytes that the lattices of wanted blocks take which have not been made.
    fn missing_bytes(&self, grid: &AmrGrid, has_gradients: bool, is_wanted: &[bool]) -> u64 {
        let samples = grid.samples();
        let of_block = |number: usize| {
            let values = if self.values[number].get().is_none() { samples.lattice_bytes(number) } else { 0 };
            let has_differences = !has_gradients || self.differences[number].get().is_some();
            values + if has_differences { 0 } else { samples.difference_lattice_bytes(number) }
        };
        (0..is_wanted.len()).filter(|&number| is_wanted[number]).map(of_block).sum()
    }

    /// Samples that gradients in a block are made of, with a border of one more than the block's lattice has; `None` if they have not been collected.
    #[inline]
    pub(crate) fn differences(&self, number: usize) -> Option<&AmrLattice> {
        self.differences[number].get()
    }

    /// Numbers of samples of a block's lattice, and these; those of the block itself where they serve. `None` if it has not been made.
    #[inline]
    pub(crate) fn of<'a>(&'a self, grid: &'a AmrGrid, number: usize) -> Option<([usize; 3], &'a [f32])> {
        Some(match self.values[number].get()? {
            Some(lattice) => (lattice.dims, &lattice.values),
            None => {
                let block = &grid.blocks()[number];
                (block.dims, &block.values)
            }
        })
    }
}

/// Samples that gradients at the eight samples of a lattice from `low` on are made of, from a lattice with a border of one more; true if none is missing.
#[inline]
pub(crate) fn stencil(differences: &AmrLattice, low: [i32; 3], out: &mut AmrStencil) -> bool {
    let (row, layer) = (differences.dims[0], differences.dims[0] * differences.dims[1]);
    let [x, y, z] = low.map(|i| i as usize);
    // From one sample below to two above.
    let Some(values) = differences.values.get(z * layer + y * row + x..) else { return false };
    let Some(values) = values.get(..3 * layer + 2 * row + 3) else { return false };
    for i in 0..4 {
        let begin = (1 + (i >> 1)) * layer + (1 + (i & 1)) * row;
        let four = &values[begin..begin + 4];
        (out[8 + i], out[2 * i], out[2 * i + 1], out[12 + i]) = (four[0], four[1], four[2], four[3]);
    }
    let mut pair = |to: usize, begin: usize| out[to..to + 2].copy_from_slice(&values[begin..begin + 2]);
    for i in 0..2 {
        let z = (1 + i) * layer + 1;
        pair(16 + 2 * i, z);
        pair(20 + 2 * i, z + 3 * row);
        let y = (1 + i) * row + 1;
        pair(24 + 2 * i, y);
        pair(28 + 2 * i, y + 3 * layer);
    }
    true
}
