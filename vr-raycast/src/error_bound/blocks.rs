//! Ranges of the medium, block by block.

use vr_core::GridVolume;
use vr_kernels::ranges::RangeBlocks;

use super::optics::{Extremes, Optics};

/// Cells along the edge of a block: large enough that all blocks together are a few hundredths of a volume of bytes.
pub(super) const EDGE: usize = 8;

/// Range of the field in every block, and its content under the current transfer function.
#[derive(Clone, Debug)]
pub(super) struct Blocks {
    counts: [usize; 3],
    /// Range of stored numbers of each block; low above high if the block is all vacuum.
    ranges: Vec<[f32; 2]>,
    states: Vec<State>,
}

/// Content of a block, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// Nothing that can be seen.
    Clear,
    /// Something that can be seen, and no vacuum.
    Filled,
    /// Something that can be seen, and some vacuum.
    Holed,
}

impl Blocks {
    pub(super) fn new(volume: &GridVolume, optics: &Optics) -> Self {
        let blocks = RangeBlocks::of_volume(volume, EDGE);
        let state = |b: &vr_kernels::ranges::BlockRange| {
            if b.is_empty() || is_clear(optics, b.low.into(), b.high.into()) {
                State::Clear
            } else if b.vacuum {
                State::Holed
            } else {
                State::Filled
            }
        };
        Self {
            counts: blocks.blocks(),
            ranges: blocks.ranges().iter().map(|b| [b.low, b.high]).collect(),
            states: blocks.ranges().iter().map(state).collect(),
        }
    }

    pub(super) fn index(&self, block: [usize; 3]) -> usize {
        (block[2] * self.counts[1] + block[1]) * self.counts[0] + block[0]
    }

    pub(super) fn state(&self, index: usize) -> State {
        self.states[index]
    }

    /// Returns bounds of the stored numbers of a block; the lower above the upper if it is all vacuum.
    pub(super) fn range(&self, index: usize) -> [f64; 2] {
        self.ranges[index].map(f64::from)
    }

    /// Extremes of the medium in a block that is filled.
    pub(super) fn extremes(&self, index: usize, optics: &Optics) -> Extremes {
        let [low, high] = self.ranges[index];
        optics.extremes(f64::from(low) - optics.knot_error, f64::from(high) + optics.knot_error)
    }
}

/// True if nothing can be seen of stored numbers from `low` to `high`, ends included.
pub(super) fn is_clear(optics: &Optics, low: f64, high: f64) -> bool {
    if low == high {
        let (rate, source) = optics.exactly(low);
        return rate == 0.0 && (!optics.emits || source == [0.0; 3]);
    }
    optics.is_clear(low - optics.knot_error, high + optics.knot_error)
}
