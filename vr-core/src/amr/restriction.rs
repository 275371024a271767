//! Values of coarse cells that finer ones cover.

use super::block::AmrCentring;
use super::check::each_index;
use super::grid::AmrGrid;
use super::level::{divided, plus, times};

/// Gives every coarse cell that finer ones cover their mean, from the finest level on; NaN if one of them has no value. The mean of the
/// middles of the fine cells is the middle of the coarse one: what is linear stays so. Coarse points take the value of the fine point in the same
/// place.
pub(super) fn restrict(grid: &mut AmrGrid) {
    for level in (1..grid.levels.len()).rev() {
        for number in grid.levels[level].blocks.clone() {
            match grid.centring {
                AmrCentring::Cells => restrict_cells(grid, level, number),
                AmrCentring::Points => restrict_points(grid, level, number),
            }
        }
    }
}

fn restrict_cells(grid: &mut AmrGrid, level: usize, number: usize) {
    let ratio = grid.levels[level].ratio;
    let children = ratio.iter().product::<i64>() as f64;
    let block = &grid.blocks[number];
    let (from, to) = (divided(block.first, ratio), divided(block.end(), ratio));
    let mean = |cell: [i64; 3]| {
        let first = times(cell, ratio);
        let values = each_index(first, plus(first, ratio)).filter_map(|at| block.offset(at));
        values.map(|offset| f64::from(block.values[offset])).sum::<f64>() / children
    };
    let means: Vec<([i64; 3], f32)> = each_index(from, to).map(|cell| (cell, mean(cell) as f32)).collect();
    for (cell, mean) in means {
        grid.set_all(level - 1, cell, mean);
    }
}

fn restrict_points(grid: &mut AmrGrid, level: usize, number: usize) {
    let ratio = grid.levels[level].ratio;
    let block = &grid.blocks[number];
    let (from, to) = (divided(block.first, ratio), divided(block.end().map(|e| e - 1), ratio));
    let same = |point: [i64; 3]| block.offset(times(point, ratio)).map_or(f32::NAN, |offset| block.values[offset]);
    let points = each_index(from, plus(to, [1; 3]));
    let values: Vec<([i64; 3], f32)> = points.map(|point| (point, same(point))).collect();
    for (point, value) in values {
        grid.set_all(level - 1, point, value);
    }
}

/// Gives the points that blocks of a level share the value of the first block that has them.
pub(super) fn unify_points(grid: &mut AmrGrid) {
    for level in 0..grid.levels.len() {
        for number in grid.levels[level].blocks.clone() {
            let block = &grid.blocks[number];
            let (from, to) = (block.first, block.end());
            let on_rim = |at: &[i64; 3]| (0..3).any(|a| at[a] == from[a] || at[a] == to[a] - 1);
            let shared: Vec<(usize, f32)> = each_index(from, to)
                .filter(on_rim)
                .filter_map(|at| Some((block.offset(at)?, grid.sample(level, at) as f32)))
                .collect();
            for (offset, value) in shared {
                grid.blocks[number].values[offset] = value;
            }
        }
    }
}
