//! An adaptive mesh of blocks.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use super::bin_index::BinIndex;
use super::block::{AmrBlock, AmrCentring};
use super::bricks::Bricks;
use super::check::{self, Lattices, each_index};
use super::error::AmrError;
use super::level::{Level, plus, times};
use super::neighbors::Neighbors;
use super::restriction::{restrict, unify_points};
use crate::box_tree::{Bounds, BoxTree};
use crate::derived::Derived;
use crate::limits::{MAX_COORDINATE, MAX_STEPS_AWAY};

/// A block-structured adaptive mesh. The [module's page](super) defines its field.
///
/// It takes the memory of its blocks, and a few bytes for each block besides.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};
/// use vr_core::{Field, Volume};
///
/// // 4³ unit cells with the values of x in their middles; the lower half in x is refined once more.
/// let x = |first: f32, step: f32, n: [usize; 3]| (0..n.iter().product()).map(|i| first + step * (i % n[0]) as f32).collect();
/// let coarse = AmrBlock { level: 0, first: [0; 3], dims: [4; 3], values: x(0.5, 1.0, [4; 3]) };
/// let fine = AmrBlock { level: 1, first: [0; 3], dims: [4, 8, 8], values: x(0.25, 0.5, [4, 8, 8]) };
/// let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![[2; 3]], vec![coarse, fine], AmrCentring::Cells)?;
/// assert_eq!((grid.leaf_cells(0), grid.leaf_cells(1)), (32, 256));
/// // Exact for linear data, across the boundary between the levels at x = 2, too.
/// for x in [0.6, 1.9, 2.0, 2.1] {
///     assert!((grid.value(DVec3::new(x, 1.3, 2.0)).unwrap() - x).abs() < 1e-6);
/// }
/// assert_eq!(grid.value(DVec3::new(3.6, 2.0, 2.0)), None, "beyond the middles of the outermost cells");
/// # Ok::<(), vr_core::amr::AmrError>(())
/// ```
#[derive(Clone, Debug)]
pub struct AmrGrid {
    pub(super) origin: DVec3,
    pub(super) levels: Vec<Level>,
    pub(super) blocks: Vec<AmrBlock>,
    pub(super) centring: AmrCentring,
    bounds: (DVec3, DVec3),
    /// The same as nodes of the finest level.
    inner_nodes: [[i64; 3]; 2],
    range: (f32, f32),
    leaf_cells: Vec<usize>,
    repeated: usize,
    missing: usize,
    /// Tree of the blocks' boxes, made when first asked for, then kept.
    tree: OnceLock<BoxTree>,
    /// Ranges of parts of blocks, likewise.
    bricks: OnceLock<Bricks>,
    /// Blocks beside each other, likewise.
    neighbors: OnceLock<Neighbors>,
    derived: Arc<Derived>,
}

impl AmrGrid {
    /// A mesh of blocks. `origin` is the corner of cell 0 of every level (or point 0), `spacing` are the edges of a cell of level 0, and
    /// `ratios` tell into how many cells of the next level a cell of each level is divided along each axis.
    ///
    /// Values of coarse cells under finer ones become their mean; infinite values become NaN, which is none.
    ///
    /// # Errors
    /// [`AmrError`] for no block, a level without one, a ratio that does not refine, blocks that cover parts of coarser cells, that reach beyond the
    /// level before or overlap with different values, sizes that do not fit the values, no finite value, and numbers beyond arithmetic.
    pub fn new(
        origin: DVec3,
        spacing: DVec3,
        ratios: Vec<[u32; 3]>,
        mut blocks: Vec<AmrBlock>,
        centring: AmrCentring,
    ) -> Result<Self, AmrError> {
        let lattices = check::lattices(spacing, &ratios)?;
        check::blocks(&blocks, &ratios, &lattices, centring)?;
        let values: usize = blocks.iter().map(|b| b.values.len()).sum();
        let mut finite = 0;
        for value in blocks.iter_mut().flat_map(|b| &mut b.values) {
            if value.is_finite() { finite += 1 } else { *value = f32::NAN }
        }
        if finite == 0 {
            return Err(AmrError::NoValue { found: values });
        }

        // Blocks of one level stand together.
        let mut numbered: Vec<(usize, AmrBlock)> = blocks.into_iter().enumerate().collect();
        numbered.sort_by_key(|(_, block)| block.level);
        let (numbers, blocks): (Vec<usize>, Vec<AmrBlock>) = numbered.into_iter().unzip();
        let Lattices { spacing, to_finest } = lattices;
        let level = |level: usize| {
            let range = blocks.partition_point(|b| b.level < level)..blocks.partition_point(|b| b.level <= level);
            let ratio = if level > 0 { ratios[level - 1].map(i64::from) } else { [1; 3] };
            let index = BinIndex::new(&blocks[range.clone()], range.start);
            let (edge, rate) =
                (spacing[level] / centring.elements() as f64, centring.elements() as f64 / spacing[level]);
            Level { spacing: spacing[level], edge, rate, ratio, to_finest: to_finest[level], blocks: range, index }
        };
        let levels: Vec<Level> = (0..spacing.len()).map(level).collect();
        let mut grid = Self {
            origin,
            levels,
            blocks,
            centring,
            bounds: (DVec3::ZERO, DVec3::ZERO),
            inner_nodes: [[0; 3]; 2],
            range: (0.0, 0.0),
            leaf_cells: Vec::new(),
            repeated: 0,
            missing: values - finite,
            tree: OnceLock::new(),
            bricks: OnceLock::new(),
            neighbors: OnceLock::new(),
            derived: Arc::default(),
        };
        grid.repeated = check::overlaps(&grid, &numbers)?;
        check::nesting(&grid, &numbers)?;
        grid.measure()?;
        if centring == AmrCentring::Points {
            unify_points(&mut grid);
        }
        restrict(&mut grid);
        grid.count_leaves();
        Ok(grid)
    }

    /// Finds the box of the values.
    fn measure(&mut self) -> Result<(), AmrError> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut inner = [[i64::MAX; 3], [i64::MIN; 3]];
        for number in 0..self.blocks.len() {
            let [first, last] = self.nodes_of_values(number);
            let level = self.blocks[number].level;
            let to_finest = self.levels[level].to_finest;
            for a in 0..3 {
                inner[0][a] = inner[0][a].min(first[a] * to_finest[a]);
                inner[1][a] = inner[1][a].max(last[a] * to_finest[a]);
            }
            (low, high) = (low.min(self.position(level, first)), high.max(self.position(level, last)));
        }
        self.inner_nodes = inner;
        let finest = self.finest_spacing();
        let away = (low.abs().max(high.abs()) / finest).max_element();
        let is_near = self.origin.abs().cmplt(DVec3::splat(MAX_COORDINATE)).all() && away < MAX_STEPS_AWAY;
        if !is_near {
            return Err(AmrError::Origin { found: self.origin.to_array() });
        }
        if let Some(axis) = (0..3).find(|&a| high[a] - low[a] <= 0.5 * finest[a]) {
            return Err(AmrError::Flat { axis });
        }
        self.bounds = (low, high);
        Ok(())
    }

    /// Counts the leaves of each level, and finds the range of their values.
    fn count_leaves(&mut self) {
        let mut counts = vec![0; self.levels.len()];
        self.each_leaf(|level, _| counts[level] += 1);
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        // Means of finer cells lie between them: the values of covered cells need not be left out.
        for &value in self.blocks.iter().flat_map(|b| &b.values).filter(|v| !v.is_nan()) {
            (low, high) = (low.min(value), high.max(value));
        }
        self.leaf_cells = counts;
        self.range = (low, high);
    }

    /// Calls `each` with the level and the value of every cell that no finer ones cover: the value of its first corner, where points have the values. NaN for
    /// none.
    pub fn each_leaf(&self, mut each: impl FnMut(usize, f32)) {
        for (number, block) in self.blocks.iter().enumerate() {
            let cells = block.cells(self.centring).map(|n| n as i64);
            for cell in each_index(block.first, plus(block.first, cells)) {
                // Of several blocks with the same cell, the first.
                let is_own = self.holder_of_cell(block.level, cell) == Some(number);
                if is_own && !self.is_covered(block.level, cell) {
                    each(block.level, block.offset(cell).map_or(f32::NAN, |offset| block.values[offset]));
                }
            }
        }
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        self.levels.len()
    }

    /// All blocks, those of coarser levels first. Values under finer cells are the means of these.
    pub fn blocks(&self) -> &[AmrBlock] {
        &self.blocks
    }

    /// The blocks of a level.
    ///
    /// # Panics
    /// Panics if there is no such level; likewise the functions below.
    pub fn blocks_of(&self, level: usize) -> &[AmrBlock] {
        &self.blocks[self.levels[level].blocks.clone()]
    }

    /// Place of the values.
    pub fn centring(&self) -> AmrCentring {
        self.centring
    }

    /// World position of the corner of cell 0, or of point 0, of every level.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Edges of a cell of a level, in world units.
    pub fn spacing_of(&self, level: usize) -> DVec3 {
        self.levels[level].spacing
    }

    /// Mean edge of the cells of a level, in world units.
    pub fn mean_spacing_of(&self, level: usize) -> f64 {
        self.levels[level].spacing.element_sum() / 3.0
    }

    /// Edges of a cell of the finest level.
    pub fn finest_spacing(&self) -> DVec3 {
        self.levels[self.levels.len() - 1].spacing
    }

    /// Number of cells of a level along the edges of a cell of the level before; 1 for level 0.
    pub fn ratio_of(&self, level: usize) -> [u32; 3] {
        self.levels[level].ratio.map(|r| r as u32)
    }

    /// Number of cells of a level that no finer ones cover.
    pub fn leaf_cells(&self, level: usize) -> usize {
        self.leaf_cells[level]
    }

    /// Number of values that two blocks of one level both have; they are equal.
    pub fn repeated_values(&self) -> usize {
        self.repeated
    }

    /// Number of values that were not finite.
    pub fn missing_values(&self) -> usize {
        self.missing
    }

    /// Number of cells along each axis that a uniform grid over the same box would need to be as fine everywhere.
    pub fn finest_dims(&self) -> [u64; 3] {
        let finest = |a: usize, at: i64, level: usize| at * self.levels[level].to_finest[a];
        let beyond = self.centring.beyond();
        [0, 1, 2].map(|a| {
            let low = self.blocks.iter().map(|b| finest(a, b.first[a], b.level)).min().unwrap_or(0);
            let high = self.blocks.iter().map(|b| finest(a, b.end()[a] - beyond, b.level)).max().unwrap_or(0);
            (high - low) as u64
        })
    }

    /// Bytes of memory that it takes, without what renderers derive from it.
    pub fn bytes(&self) -> usize {
        let blocks: usize = self.blocks.iter().map(|b| size_of_val(b) + size_of_val(&*b.values)).sum();
        size_of_val(self) + blocks + self.levels.iter().map(|l| size_of_val(l) + l.index.bytes()).sum::<usize>()
    }

    /// Corners of the smallest box around the outermost values: middles of cells, or points.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Smallest and largest value.
    pub fn value_range(&self) -> (f64, f64) {
        (self.range.0.into(), self.range.1.into())
    }

    /// Mean edge of the finest cells, in world units.
    pub fn mean_spacing(&self) -> f64 {
        self.mean_spacing_of(self.levels.len() - 1)
    }

    /// Structures that others derive from the mesh and keep with it.
    pub fn derived(&self) -> &Derived {
        &self.derived
    }

    /// World position of a lattice node of a level: nodes are the corners of elements, two for each cell with a value in its middle.
    pub(super) fn position(&self, level: usize, node: [i64; 3]) -> DVec3 {
        self.origin + DVec3::from_array(node.map(|n| n as f64)) * self.levels[level].edge
    }

    /// Lattice nodes of a block's first and last value.
    fn nodes_of_values(&self, number: usize) -> [[i64; 3]; 2] {
        let block = &self.blocks[number];
        [block.first, block.end().map(|e| e - 1)].map(|at| match self.centring {
            AmrCentring::Cells => at.map(|i| 2 * i + 1),
            AmrCentring::Points => at,
        })
    }

    /// Nodes of the finest level at the corners of the [`bounds`](Self::bounds).
    pub(super) fn inner_nodes(&self) -> [[i64; 3]; 2] {
        self.inner_nodes
    }

    /// Lattice nodes at the lowest and highest corner of a block's cells.
    pub(super) fn nodes_of_block(&self, number: usize) -> [[i64; 3]; 2] {
        let block = &self.blocks[number];
        let elements = self.centring.elements();
        let end: [i64; 3] = std::array::from_fn(|a| block.first[a] + block.cells(self.centring)[a] as i64);
        [block.first, end].map(|at| times(at, [elements; 3]))
    }

    /// Ranges of parts of blocks.
    pub(super) fn bricks(&self) -> &Bricks {
        self.bricks.get_or_init(|| Bricks::new(self))
    }

    /// Blocks beside each other.
    pub(super) fn neighbors(&self) -> &Neighbors {
        self.neighbors.get_or_init(|| Neighbors::new(self))
    }

    /// Tree of the boxes that the cells of blocks fill.
    pub(super) fn tree(&self) -> &BoxTree {
        self.tree.get_or_init(|| {
            let around = |number: usize| {
                let [low, high] = self.nodes_of_block(number).map(|n| self.position(self.blocks[number].level, n));
                Bounds { low, high }
            };
            let key = |number: usize| {
                let Bounds { low, high } = around(number);
                (0.5 * low + 0.5 * high, 0.5 * (high - low).max_element())
            };
            let reach = self.levels[0].spacing;
            let all = (self.bounds.0 - reach, self.bounds.1 + reach);
            BoxTree::new(self.blocks.len(), all, key, around)
        })
    }
}
