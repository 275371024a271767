//! Blocks that begin or end within a coarser cell, grown to whole ones.
//!
//! A mesh wants blocks that cover whole cells of the level before. Some programs cut a level into blocks where it suits them: what a block lacks of a
//! coarser cell is then in its neighbours. Where it is in none, the coarser cell has the word there, as it has in the file.

use vr_core::amr::AmrBlock;

/// Outcome of growing blocks.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Aligned {
    /// Blocks that were grown.
    pub grown: usize,
    /// Values that came from coarser cells.
    pub from_coarser: usize,
}

/// Times that a level may grow, so that no ratio makes much of little.
const MAX_GROWTH: usize = 64;

/// Grows the blocks of cells to whole cells of the level before; blocks that would grow beyond measure stay, and are refused with their ratio.
pub(super) fn align(blocks: Vec<AmrBlock>, ratios: &[[u32; 3]]) -> (Vec<AmrBlock>, Aligned) {
    let mut aligned = Aligned::default();
    let is_cut = |block: &AmrBlock| {
        let ratio = block.level.checked_sub(1).and_then(|l| ratios.get(l)).copied().unwrap_or([1; 3]);
        (0..3).any(|a| block.first[a] % i64::from(ratio[a]) != 0 || block.dims[a] as i64 % i64::from(ratio[a]) != 0)
    };
    if !blocks.iter().any(is_cut) {
        return (blocks, aligned);
    }
    let mut out: Vec<AmrBlock> = Vec::new();
    // From coarse to fine: a block may need what a coarser one was given.
    let mut order: Vec<usize> = (0..blocks.len()).collect();
    order.sort_by_key(|&i| blocks[i].level);
    let mut grown: Vec<Option<AmrBlock>> = vec![None; blocks.len()];
    for &i in &order {
        let block = &blocks[i];
        let same = |j: &usize| blocks[*j].level == block.level && *j != i;
        let before = |j: &usize| blocks[*j].level + 1 == block.level;
        let total: usize =
            order.iter().filter(|j| blocks[**j].level == block.level).map(|&j| blocks[j].values.len()).sum();
        let Some(mut larger) = is_cut(block).then(|| Larger::new(block, ratios[block.level - 1], total)).flatten()
        else {
            continue;
        };
        larger.take(block);
        for j in order.iter().filter(|j| same(j)) {
            larger.take(&blocks[*j]);
        }
        for j in order.iter().filter(|j| before(j)) {
            aligned.from_coarser +=
                larger.take_coarser(grown[*j].as_ref().unwrap_or(&blocks[*j]), ratios[block.level - 1]);
        }
        aligned.grown += 1;
        grown[i] = Some(larger.block);
    }
    for (block, larger) in blocks.into_iter().zip(grown) {
        out.push(larger.unwrap_or(block));
    }
    (out, aligned)
}

/// A block that grows.
struct Larger {
    block: AmrBlock,
    /// True for values that are known.
    known: Vec<bool>,
}

impl Larger {
    /// The smallest box of whole coarser cells around a block; `None` for one beyond measure.
    fn new(block: &AmrBlock, ratio: [u32; 3], total: usize) -> Option<Self> {
        let (mut first, mut dims) = ([0; 3], [0; 3]);
        for a in 0..3 {
            let ratio = i64::from(ratio[a]);
            let end = block.first[a].checked_add(i64::try_from(block.dims[a]).ok()?)?;
            first[a] = block.first[a].div_euclid(ratio).checked_mul(ratio)?;
            let last = end.checked_add(ratio - 1)?.div_euclid(ratio).checked_mul(ratio)?;
            dims[a] = usize::try_from(last.checked_sub(first[a])?).ok()?;
        }
        let count = super::amr_file::count_of(dims, 1).filter(|&n| n <= total.saturating_mul(MAX_GROWTH))?;
        let block = AmrBlock { level: block.level, first, dims, values: vec![f32::NAN; count] };
        Some(Self { block, known: vec![false; count] })
    }

    /// Takes what a block of the same level knows.
    fn take(&mut self, from: &AmrBlock) {
        let low = [0, 1, 2].map(|a| self.block.first[a].max(from.first[a]));
        let high = [0, 1, 2].map(|a| end(&self.block, a).min(end(from, a)));
        if (0..3).any(|a| low[a] >= high[a]) {
            return;
        }
        for z in low[2]..high[2] {
            for y in low[1]..high[1] {
                for x in low[0]..high[0] {
                    let at = index(&self.block, [x, y, z]);
                    if !self.known[at] {
                        self.block.values[at] = from.values[index(from, [x, y, z])];
                        self.known[at] = true;
                    }
                }
            }
        }
    }

    /// Takes values of coarser cells where none is known; returns their number.
    fn take_coarser(&mut self, from: &AmrBlock, ratio: [u32; 3]) -> usize {
        let [nx, ny, _] = self.block.dims;
        let mut taken = 0;
        for i in 0..self.known.len() {
            if self.known[i] {
                continue;
            }
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            let cell = [0, 1, 2].map(|a| (self.block.first[a] + at[a] as i64).div_euclid(i64::from(ratio[a])));
            if (0..3).all(|a| (from.first[a]..end(from, a)).contains(&cell[a])) {
                self.block.values[i] = from.values[index(from, cell)];
                self.known[i] = true;
                taken += 1;
            }
        }
        taken
    }
}

/// Index of the first cell behind a block.
fn end(block: &AmrBlock, axis: usize) -> i64 {
    block.first[axis] + block.dims[axis] as i64
}

/// Place of a cell among the values of a block that holds it.
fn index(block: &AmrBlock, cell: [i64; 3]) -> usize {
    let [x, y, z] = [0, 1, 2].map(|a| (cell[a] - block.first[a]) as usize);
    x + block.dims[0] * (y + block.dims[1] * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(level: usize, first: [i64; 3], dims: [usize; 3], value: f32) -> AmrBlock {
        AmrBlock { level, first, dims, values: vec![value; dims.iter().product()] }
    }

    #[test]
    fn neighbours_fill_a_cell_that_a_block_lacks() {
        let blocks = vec![
            block(0, [0; 3], [4, 1, 1], 1.0),
            block(1, [0; 3], [3, 2, 2], 2.0),
            block(1, [3, 0, 0], [3, 2, 2], 3.0),
        ];
        let (grown, aligned) = align(blocks.clone(), &[[2; 3]]);
        assert_eq!(aligned, Aligned { grown: 2, from_coarser: 0 });
        assert_eq!(
            (grown[1].first, grown[1].dims, &grown[1].values[..4]),
            ([0; 3], [4, 2, 2], &[2.0, 2.0, 2.0, 3.0][..])
        );
        assert_eq!(
            (grown[2].first, grown[2].dims, &grown[2].values[..4]),
            ([2, 0, 0], [4, 2, 2], &[2.0, 3.0, 3.0, 3.0][..])
        );
        // Where there is no neighbour, the coarser cell has the word.
        let (grown, aligned) = align(blocks[..2].to_vec(), &[[2; 3]]);
        assert_eq!((aligned.from_coarser, &grown[1].values[..4]), (4, &[2.0, 2.0, 2.0, 1.0][..]));
        // Whole ones stay as they are.
        let whole = vec![block(0, [0; 3], [4, 1, 1], 1.0), block(1, [-2, 0, 0], [4, 2, 2], 1.0)];
        assert_eq!(align(whole.clone(), &[[2; 3]]), (whole, Aligned::default()));
    }

    #[test]
    fn no_ratio_makes_much_of_little() {
        let blocks = vec![block(0, [0; 3], [1; 3], 1.0), block(1, [0; 3], [1; 3], 2.0)];
        assert_eq!(align(blocks.clone(), &[[u32::MAX; 3]]), (blocks, Aligned::default()));
    }
}
