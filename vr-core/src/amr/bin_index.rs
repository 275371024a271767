//! Blocks of a level by their place.

use super::block::AmrBlock;

/// Bins over the box of a level's blocks, each with the blocks that reach into it: a place is looked up in about one step.
///
/// There are no more bins than a few for each block and one for 64 values, wherever the blocks are.
#[derive(Clone, Debug)]
pub(super) struct BinIndex {
    /// Lowest lattice index of a block.
    low: [i64; 3],
    /// Bins are 2ˢ indices wide.
    shift: [u32; 3],
    bins: [usize; 3],
    /// Blocks of bin b are `items[starts[b]..starts[b + 1]]`, ascending.
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl BinIndex {
    /// The index of at least one block, numbered from `from` on.
    pub(super) fn new(blocks: &[AmrBlock], from: usize) -> Self {
        let low = [0, 1, 2].map(|a| blocks.iter().map(|b| b.first[a]).min().unwrap_or(0));
        let high = [0, 1, 2].map(|a| blocks.iter().map(|b| b.end()[a]).max().unwrap_or(1));
        let extent: [u64; 3] = std::array::from_fn(|a| (high[a] - low[a]) as u64);
        // Bins begin as large as the mean block, and are widened until they are few enough.
        let mean = |a: usize| blocks.iter().map(|b| b.dims[a] as u64).sum::<u64>() / blocks.len() as u64;
        let mut shift = [0, 1, 2].map(|a| mean(a).max(1).next_power_of_two().trailing_zeros());
        let values: usize = blocks.iter().map(|b| b.values.len()).sum();
        let max = (8 * blocks.len() + values / 64 + 64) as u128;
        let count = |shift: [u32; 3], a: usize| (extent[a] >> shift[a]) as usize + 1;
        while (0..3).map(|a| count(shift, a) as u128).product::<u128>() > max {
            let widest = (0..3).max_by_key(|&a| count(shift, a)).unwrap_or(0);
            shift[widest] += 1;
        }
        let bins = [0, 1, 2].map(|a| count(shift, a));
        let mut made = Self { low, shift, bins, starts: Vec::new(), items: Vec::new() };

        // Count the blocks of each bin, then list them.
        let mut starts = vec![0u32; bins.iter().product::<usize>() + 1];
        for block in blocks {
            made.each_bin(block, |bin| starts[bin + 1] += 1);
        }
        for bin in 1..starts.len() {
            starts[bin] += starts[bin - 1];
        }
        let mut next = starts.clone();
        let mut items = vec![0u32; starts[starts.len() - 1] as usize];
        for (number, block) in blocks.iter().enumerate() {
            made.each_bin(block, |bin| {
                items[next[bin] as usize] = (from + number) as u32;
                next[bin] += 1;
            });
        }
        (made.starts, made.items) = (starts, items);
        made
    }

    /// Calls `visit` with the number of every bin that a block reaches into.
    fn each_bin(&self, block: &AmrBlock, mut visit: impl FnMut(usize)) {
        let from = [0, 1, 2].map(|a| ((block.first[a] - self.low[a]) >> self.shift[a]) as usize);
        let to = [0, 1, 2].map(|a| ((block.end()[a] - 1 - self.low[a]) >> self.shift[a]) as usize);
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    visit((z * self.bins[1] + y) * self.bins[0] + x);
                }
            }
        }
    }

    /// Blocks that may hold a lattice index, ascending.
    #[inline]
    pub(super) fn around(&self, at: [i64; 3]) -> &[u32] {
        let mut bin = [0usize; 3];
        for a in 0..3 {
            // A negative difference becomes a number beyond any bin.
            bin[a] = (at[a].wrapping_sub(self.low[a]) as u64 >> self.shift[a]) as usize;
            if bin[a] >= self.bins[a] {
                return &[];
            }
        }
        let bin = (bin[2] * self.bins[1] + bin[1]) * self.bins[0] + bin[0];
        &self.items[self.starts[bin] as usize..self.starts[bin + 1] as usize]
    }

    /// Calls `visit` with the blocks that share a bin with a block, some of them more than once.
    pub(super) fn each_near(&self, block: &AmrBlock, mut visit: impl FnMut(usize)) {
        self.each_bin(block, |bin| {
            for &other in &self.items[self.starts[bin] as usize..self.starts[bin + 1] as usize] {
                visit(other as usize);
            }
        });
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.items)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_every_block_and_stays_small() {
        let block = |first: [i64; 3], dims: [usize; 3]| AmrBlock {
            level: 0,
            first,
            dims,
            values: vec![0.0; dims.iter().product()],
        };
        // Far apart, so that a bin for each place between would be far too many.
        let blocks =
            [block([-5, 0, 3], [4, 2, 9]), block([1 << 40, -(1 << 45), 0], [3, 3, 3]), block([-1, 0, 3], [40, 1, 2])];
        let index = BinIndex::new(&blocks, 7);
        assert!(index.bytes() < 4000, "{}", index.bytes());
        for (number, block) in blocks.iter().enumerate() {
            for corner in [block.first, block.end().map(|e| e - 1)] {
                assert!(index.around(corner).contains(&(7 + number as u32)));
            }
        }
        assert!(index.around([-6, 0, 3]).is_empty() && index.around([i64::MIN; 3]).is_empty());
    }
}
