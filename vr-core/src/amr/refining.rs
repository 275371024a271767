//! Adaptive meshes of functions.

use std::collections::VecDeque;

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::error::AmrError;
use super::grid::AmrGrid;
use super::level::{plus, times};

/// Largest number of cells of a sampled mesh.
const MAX_CELLS: usize = 1 << 31;

/// Blocks that an adaptive mesh of a function is made of.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
///
/// // A ball in a box of 2×2×2 blocks; blocks that its surface may pass are refined twice.
/// let sampling = AmrSampling {
///     origin: DVec3::NEG_ONE,
///     edge: 1.0,
///     blocks: [2; 3],
///     block_cells: [8; 3],
///     ratios: vec![[2; 3]; 2],
///     centring: AmrCentring::Cells,
/// };
/// let distance = |p: DVec3| p.length() - 0.7;
/// let near = |low: DVec3, high: DVec3| distance(0.5 * (low + high)).abs() < 0.5 * (high - low).length();
/// let grid = AmrGrid::refining(&sampling, |p| distance(p) as f32, |low, high, _| near(low, high))?;
/// assert_eq!(grid.levels(), 3);
/// assert!(grid.leaf_cells(2) < 64 * 64 * 64, "the corners of the box stay coarse");
/// # Ok::<(), vr_core::amr::AmrError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AmrSampling {
    /// Lowest corner of the box, in world units.
    pub origin: DVec3,
    /// Edge of a block of level 0, in world units; it is a cube.
    pub edge: f64,
    /// Numbers of blocks of level 0 along x, y and z.
    pub blocks: [usize; 3],
    /// Numbers of cells of every block.
    pub block_cells: [usize; 3],
    /// Refinement ratios from each level to the next; that many levels are made at most, and one more.
    pub ratios: Vec<[u32; 3]>,
    /// Place of the values.
    pub centring: AmrCentring,
}

impl AmrGrid {
    /// Samples a function: a block for which `refine`, called with its lowest and highest corner and its level, is true, is divided into blocks of the
    /// next level, as many as the refinement ratio says. Levels to which nothing was refined are left out.
    ///
    /// # Errors
    /// [`AmrError`] for sizes of 0, too many cells, and as for [`AmrGrid::new`].
    pub fn refining(
        sampling: &AmrSampling,
        value: impl Fn(DVec3) -> f32,
        refine: impl Fn(DVec3, DVec3, usize) -> bool,
    ) -> Result<Self, AmrError> {
        let &AmrSampling { origin, edge, blocks, block_cells, centring, .. } = sampling;
        let wrong_size = || AmrError::BlockSize { found: block_cells };
        // Blocks of the next level cover whole cells.
        for (level, &ratio) in sampling.ratios.iter().enumerate() {
            if (0..3).any(|a| ratio[a] == 0 || !block_cells[a].is_multiple_of(ratio[a] as usize)) {
                return Err(AmrError::Ratio { level, found: ratio });
            }
        }
        if blocks.contains(&0) || block_cells.iter().any(|n| !(1..=256).contains(n)) {
            return Err(wrong_size());
        }
        let cells = block_cells.map(|n| n as i64);
        let count: usize = block_cells.iter().product();
        let spacing = DVec3::splat(edge) / DVec3::from_array(block_cells.map(|n| n as f64));
        let (middle, beyond) = (0.5 * (1 - centring.beyond()) as f64, centring.beyond() as usize);
        let dims = block_cells.map(|n| n + beyond);

        // Level by level: where each block lies, counted in blocks.
        let too_many = |n: usize| n.checked_mul(count).is_none_or(|all| all > MAX_CELLS);
        if too_many(blocks.iter().try_fold(1usize, |n, &b| n.checked_mul(b)).ok_or_else(wrong_size)?) {
            return Err(wrong_size());
        }
        let first = super::check::each_index([0; 3], blocks.map(|n| n as i64));
        let mut waiting: VecDeque<(usize, [i64; 3])> = first.map(|at| (0, at)).collect();
        let (mut made, mut step, mut level_of_step) = (Vec::new(), spacing, 0);
        while let Some((level, at)) = waiting.pop_front() {
            if level > level_of_step {
                step /= DVec3::from_array(sampling.ratios[level - 1].map(f64::from));
                level_of_step = level;
            }
            let first = times(at, cells);
            let world = |i: [i64; 3]| origin + step * DVec3::from_array(i.map(|i| i as f64));
            let samples = super::check::each_index(first, plus(first, dims.map(|n| n as i64)));
            let values = samples.map(|i| value(world(i) + step * middle)).collect();
            made.push(AmrBlock { level, first, dims, values });
            let Some(&ratio) = sampling.ratios.get(level) else { continue };
            if refine(world(first), world(plus(first, cells)), level) {
                let ratio = ratio.map(i64::from);
                let children = super::check::each_index(times(at, ratio), times(plus(at, [1; 3]), ratio));
                waiting.extend(children.map(|at| (level + 1, at)));
            }
            if too_many(made.len() + waiting.len()) {
                return Err(wrong_size());
            }
        }
        let levels = made.iter().map(|b| b.level).max().unwrap_or(0);
        let mut ratios = sampling.ratios.clone();
        ratios.truncate(levels);
        Self::new(origin, spacing, ratios, made, centring)
    }
}
