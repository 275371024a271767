//! Ranges of blocks of cells and of ever larger ones: the min-max octree of Lacroute & Levoy (1994, fast classification).

use std::sync::Arc;

use vr_core::parallel::each_part;
use vr_core::{AnyGrid, GridVolume, UniformGrid};
use vr_kernels::bits::{WORD, clip};
use vr_kernels::ranges::LevelRanges;

use super::dense::Layout;
use super::{Rule, VisibleLevels};

/// Cells along the edge of a block.
pub(crate) const EDGE: usize = LevelRanges::EDGE;

/// Range of each block of 4³ cells and of each 2³ of what is below. It does not depend on the transfer function.
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    levels: Arc<LevelRanges>,
    /// Ranges of the blocks in place of those in `levels`: for floats, where an upper level of 0 says that nothing is above the smallest value.
    own: Option<Vec<[u8; 2]>>,
    /// True if voxels are missing.
    missing: bool,
    /// From the second finest to the one node of all.
    coarser: Vec<Nodes>,
    /// True if levels are the stored integers themselves.
    exact: bool,
}

#[derive(Clone, Debug)]
struct Nodes {
    size: [usize; 3],
    ranges: Vec<[u8; 2]>,
}

impl Pyramid {
    /// Pyramid of a volume, whose ranges of blocks are kept with it.
    pub fn new(volume: &GridVolume) -> Self {
        let levels = LevelRanges::of_volume(volume);
        let missing = volume.vacuum_cells().is_some();
        let own = match volume.values() {
            AnyGrid::F32(grid) => Some(float_ranges(grid, &levels, missing)),
            _ => None,
        };
        let mut coarser: Vec<Nodes> = Vec::new();
        let mut size = levels.blocks();
        while size != [1; 3] {
            let below = coarser.last().map_or(own.as_deref().unwrap_or(levels.ranges()), |nodes| &nodes.ranges);
            let nodes = halved(size, below);
            size = nodes.size;
            coarser.push(nodes);
        }
        Self { levels, own, missing, coarser, exact: LevelRanges::are_exact(volume) }
    }

    fn finest(&self) -> &[[u8; 2]] {
        self.own.as_deref().unwrap_or(self.levels.ranges())
    }

    /// The stored numbers that a block of two levels may hold.
    fn stored(&self, levels: [u8; 2], integer: bool) -> (f64, f64) {
        let [low, high] = levels.map(|level| self.levels.stored(level));
        if self.exact || (self.own.is_some() && levels == [0, 0]) {
            return (low, high);
        }
        // A little more than the slack, for the rounding of the sums.
        let slack = 1.001 * LevelRanges::SLACK * (self.levels.stored(1) - self.levels.stored(0));
        // Corners are integers: rounded inward, air that is one number stays one.
        if integer { ((low - slack).ceil(), (high + slack).floor()) } else { (low - slack, high + slack) }
    }

    /// The blocks that may be visible: from the coarsest nodes to the finest; where a node is all or nothing, so is what is below.
    pub fn visible(&self, rule: Rule<'_>) -> VisibleBlocks {
        let decide = Decision::new(self, rule);
        let mut above = Vec::new();
        let mut size_above = [1; 3];
        let finest = (self.levels.blocks(), self.finest());
        let levels = self.coarser.iter().rev().map(|n| (n.size, &n.ranges[..])).chain([finest]);
        for (size, ranges) in levels {
            let mut states = vec![HIDDEN; ranges.len()];
            each_part(states.chunks_mut(size[0]).zip(ranges.chunks(size[0])), |row, (states, ranges)| {
                let (y, z) = (row % size[1], row / size[1]);
                let row_above = (z / 2 * size_above[1] + y / 2) * size_above[0];
                // The coarsest has nothing above.
                let above: &[u8] = if above.is_empty() { &[] } else { &above[row_above..] };
                for (x, (state, &range)) in states.iter_mut().zip(*ranges).enumerate() {
                    *state = match above.get(x / 2).copied().unwrap_or(PARTLY) {
                        PARTLY => decide.state(range),
                        // Not where nothing is.
                        WHOLE if range == LevelRanges::NOTHING => HIDDEN,
                        known => known,
                    };
                }
            });
            (above, size_above) = (states, size);
        }
        VisibleBlocks { size: self.levels.blocks(), states: above, missing: self.missing }
    }

    /// Memory that it takes beyond what the volume keeps.
    pub fn bytes(&self) -> usize {
        let nodes = self.coarser.iter().map(|n| n.ranges.len()).sum::<usize>() + self.own.as_ref().map_or(0, Vec::len);
        nodes * size_of::<[u8; 2]>()
    }
}

fn halved(size: [usize; 3], ranges: &[[u8; 2]]) -> Nodes {
    let half = size.map(|n| n.div_ceil(2));
    // An empty range is what changes no other.
    let mut nodes = vec![LevelRanges::NOTHING; half.iter().product()];
    for (row, ranges) in ranges.chunks_exact(size[0]).enumerate() {
        let (y, z) = (row % size[1], row / size[1]);
        let at = (z / 2 * half[1] + y / 2) * half[0];
        for (x, range) in ranges.iter().enumerate() {
            let node = &mut nodes[at + x / 2];
            *node = [node[0].min(range[0]), node[1].max(range[1])];
        }
    }
    Nodes { size: half, ranges: nodes }
}

/// Ranges of blocks of floats, over the values that are not missing; an upper level is 0 only where none is above the smallest of all.
///
/// The ranges of [`LevelRanges`] will not do where much is air of one number and a ramp begins at it: with their slack, air would be visible. Nor
/// where samples are missing: they leave out cells that are vacuum in space, of which a square in a layer may be whole.
fn float_ranges(grid: &UniformGrid<f32>, levels: &LevelRanges, missing: bool) -> Vec<[u8; 2]> {
    let (dims, samples) = (grid.dims(), grid.samples());
    let [bx, by, _] = levels.blocks();
    let (origin, spacing) = (levels.stored(0), levels.stored(1) - levels.stored(0));
    let level = |x: f32| (f64::from(x) - origin) / spacing;
    let mut ranges = levels.ranges().to_vec();
    each_part(ranges.chunks_mut(bx), |row, ranges| {
        let span = |axis: usize, block: usize| block * EDGE..(block * EDGE + EDGE + 1).min(dims[axis]);
        for (x, range) in ranges.iter_mut().enumerate() {
            if !missing && range[1] > 0 {
                continue;
            }
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for z in span(2, row / by) {
                for y in span(1, row % by) {
                    for x in span(0, x) {
                        // Of a number and NaN these take the number.
                        let s = samples[(z * dims[1] + y) * dims[0] + x];
                        (low, high) = (low.min(s), high.max(s));
                    }
                }
            }
            if low <= high {
                // `as` saturates.
                *range = [level(low).floor() as u8, level(high).ceil() as u8];
            }
        }
    });
    ranges
}

/// Nothing in the block is visible.
const HIDDEN: u8 = 0;
/// Something may be.
const PARTLY: u8 = 1;
/// Every cell is, unless a corner is missing.
const WHOLE: u8 = 2;

/// Visibility of each range of levels: bounds that grow with the lower level, looked up.
struct Decision {
    /// For each lower level the smallest upper one so that something may be visible; 256 if there is none.
    reach: [u16; 256],
    /// For each lower level the end of the upper ones so that everything is.
    solid: [u16; 256],
}

impl Decision {
    fn new(pyramid: &Pyramid, rule: Rule<'_>) -> Self {
        let (mut reach, mut solid) = ([0; 256], [256; 256]);
        if let Rule::Interpolated(visibility) | Rule::Classified(visibility) = rule {
            for low in 0..=u8::MAX {
                let holds = |high: u8, ask: fn(&VisibleLevels, f64, f64) -> bool| {
                    let (low, high) = pyramid.stored([low, high], visibility.is_integer());
                    ask(visibility, low, high)
                };
                let min_level = |hold: &dyn Fn(u8) -> bool| {
                    // Levels below `low` are no upper ones.
                    let (mut from, mut to) = (u16::from(low), 256);
                    while from < to {
                        let middle = from.midpoint(to);
                        if hold(middle as u8) { to = middle } else { from = middle + 1 }
                    }
                    from
                };
                reach[usize::from(low)] = min_level(&|high| holds(high, VisibleLevels::any));
                solid[usize::from(low)] = min_level(&|high| !holds(high, VisibleLevels::all));
            }
        }
        Self { reach, solid }
    }

    #[inline]
    fn state(&self, [low, high]: [u8; 2]) -> u8 {
        if low > high || self.reach[usize::from(low)] > u16::from(high) {
            HIDDEN
        } else if self.solid[usize::from(low)] > u16::from(high) {
            WHOLE
        } else {
            PARTLY
        }
    }
}

/// The blocks of 4³ cells that may be visible.
#[derive(Clone, Debug)]
pub(crate) struct VisibleBlocks {
    size: [usize; 3],
    states: Vec<u8>,
    missing: bool,
}

impl VisibleBlocks {
    /// True if anything in a block may be visible.
    #[cfg(test)]
    pub fn may(&self, [x, y, z]: [usize; 3]) -> bool {
        self.states[(z * self.size[1] + y) * self.size[0] + x] != HIDDEN
    }

    /// Number of blocks that may be visible.
    pub fn count(&self) -> usize {
        self.states.iter().filter(|&&s| s != HIDDEN).count()
    }

    /// Number of blocks.
    pub fn total(&self) -> usize {
        self.states.len()
    }

    /// True if a block that may be visible has any of the voxels from the first to the one before the last along x, y and z.
    pub fn touch(&self, samples: [[usize; 2]; 3]) -> bool {
        // A sample between two blocks belongs to both.
        let [xs, ys, zs] = std::array::from_fn(|a| {
            let [first, end] = samples[a];
            first.saturating_sub(1) / EDGE..end.div_ceil(EDGE).min(self.size[a])
        });
        zs.into_iter().any(|z| {
            ys.clone().any(|y| {
                let row = (z * self.size[1] + y) * self.size[0];
                self.states[row + xs.start..row + xs.end].iter().any(|&state| state != HIDDEN)
            })
        })
    }

    /// True if voxels of the volume are missing.
    pub fn missing(&self) -> bool {
        self.missing
    }

    /// Marks the cells of four rows of a layer (`N = 2`) or slab (`N = 4`), those of the row of blocks `row`: in `may` those in a block
    /// that may be visible, in `all` those in one that is visible throughout.
    pub fn mark<const N: usize>(&self, layout: &Layout, layer: usize, row: usize, [may, all]: [&mut [u64]; 2]) {
        may.fill(0);
        all.fill(0);
        let strides = [1, self.size[0], self.size[0] * self.size[1]];
        let [su, sv, sw] = layout.axes.map(|a| strides[a]);
        let [nu, _, nw] = layout.axes.map(|a| self.size[a]);
        // A layer between two blocks belongs to both.
        let first = if N == 2 && layer > 0 { (layer - 1) / EDGE } else { layer / EDGE };
        for block in first..(layer / EDGE + 1).min(nw) {
            let at = row * sv + block * sw;
            for (u, state) in self.states[at..].iter().step_by(su).take(nu).enumerate() {
                let (word, bits) = (u * EDGE / WORD, ((1 << EDGE) - 1) << (u * EDGE % WORD));
                if *state != HIDDEN {
                    may[word] |= bits;
                }
                if *state == WHOLE {
                    all[word] |= bits;
                }
            }
        }
        clip(may, layout.size[0] - 1);
        clip(all, layout.size[0] - 1);
    }
}
