//! Checks of the input of an adaptive mesh.

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::error::AmrError;
use super::grid::AmrGrid;
use super::level::{divided, plus};
use crate::limits::is_length;

/// Largest number of levels: 2³² cells of the finest one along the edge of a coarsest.
const MAX_LEVELS: usize = 32;
/// Largest refinement ratio along an axis.
const MAX_RATIO: u32 = 1024;
/// Largest lattice index, in cells of the finest level: f64 keeps eighths of a cell there.
const MAX_INDEX: i64 = 1 << 50;

/// Edges of a cell and cells of the finest level along them, of each level.
pub(super) struct Lattices {
    pub(super) spacing: Vec<DVec3>,
    pub(super) to_finest: Vec<[i64; 3]>,
}

/// Checks spacing and ratios.
pub(super) fn lattices(spacing: DVec3, ratios: &[[u32; 3]]) -> Result<Lattices, AmrError> {
    let levels = ratios.len() + 1;
    if levels > MAX_LEVELS {
        return Err(AmrError::Levels { found: levels, max: MAX_LEVELS });
    }
    let mut edges = vec![spacing];
    for (level, &found) in ratios.iter().enumerate() {
        if found.iter().any(|r| !(1..=MAX_RATIO).contains(r)) || found == [1; 3] {
            return Err(AmrError::Ratio { level, found });
        }
        edges.push(edges[level] / DVec3::from_array(found.map(f64::from)));
    }
    for (level, edge) in edges.iter().enumerate() {
        if !edge.to_array().into_iter().all(is_length) {
            return Err(AmrError::Spacing { level, found: edge.to_array() });
        }
    }
    let mut to_finest = vec![[1i64; 3]; levels];
    for level in (0..ratios.len()).rev() {
        let finer = to_finest[level + 1];
        for a in 0..3 {
            let product = finer[a].checked_mul(i64::from(ratios[level][a])).filter(|&p| p < MAX_INDEX);
            to_finest[level][a] = product.ok_or(AmrError::Ratio { level, found: ratios[level] })?;
        }
    }
    Ok(Lattices { spacing: edges, to_finest })
}

/// Checks each block by itself.
pub(super) fn blocks(
    blocks: &[AmrBlock],
    ratios: &[[u32; 3]],
    lattices: &Lattices,
    centring: AmrCentring,
) -> Result<(), AmrError> {
    if blocks.len() >= u32::MAX as usize {
        return Err(AmrError::TooManyBlocks { found: blocks.len() });
    }
    let levels = ratios.len() + 1;
    let mut is_present = vec![false; levels];
    for (number, block) in blocks.iter().enumerate() {
        let &AmrBlock { level, first, dims, .. } = block;
        if level >= levels {
            return Err(AmrError::Level { block: number, found: level, levels });
        }
        is_present[level] = true;
        let min = 1 + centring.beyond() as usize;
        if dims.iter().any(|&n| n < min) {
            return Err(AmrError::Dims { block: number, dims, centring, min });
        }
        let count = dims[0].checked_mul(dims[1]).and_then(|n| n.checked_mul(dims[2]));
        if count != Some(block.values.len()) {
            return Err(AmrError::Length { block: number, found: block.values.len(), dims });
        }
        for a in 0..3 {
            let end = i64::try_from(dims[a]).ok().and_then(|n| first[a].checked_add(n));
            let finest = |at: i64| at.checked_mul(lattices.to_finest[level][a]).is_some_and(|i| i.abs() < MAX_INDEX);
            if !(finest(first[a]) && end.is_some_and(finest)) {
                return Err(AmrError::Extent { block: number, first, dims });
            }
        }
        if level > 0 {
            let (ratio, cells) = (ratios[level - 1], block.cells(centring));
            let is_whole =
                |a: usize| first[a].rem_euclid(i64::from(ratio[a])) == 0 && cells[a].is_multiple_of(ratio[a] as usize);
            if !(0..3).all(is_whole) {
                return Err(AmrError::Misaligned { block: number, level, first, cells, ratio });
            }
        }
    }
    match is_present.iter().position(|p| !p) {
        Some(level) => Err(AmrError::NoBlocks { level, levels }),
        None => Ok(()),
    }
}

/// Checks that blocks of one level have equal values where they overlap; returns the number of values that are there twice, but for the layers of points
/// that neighbours share, in which the first block's hold. `numbers` are those by which the caller knows the blocks.
pub(super) fn overlaps(grid: &AmrGrid, numbers: &[usize]) -> Result<usize, AmrError> {
    let mut repeated = 0;
    for (level, lattice) in grid.levels.iter().enumerate() {
        for number in lattice.blocks.clone() {
            let block = &grid.blocks[number];
            let mut others = Vec::new();
            lattice.index.each_near(block, |other| others.push(other));
            others.sort_unstable();
            others.dedup();
            for other in others.into_iter().take_while(|&other| other < number) {
                let earlier = &grid.blocks[other];
                let from: [i64; 3] = std::array::from_fn(|a| block.first[a].max(earlier.first[a]));
                let to: [i64; 3] = std::array::from_fn(|a| block.end()[a].min(earlier.end()[a]));
                // Points share faces, edges and corners.
                if (0..3).any(|a| to[a] - from[a] <= grid.centring.beyond()) {
                    continue;
                }
                for at in each_index(from, to) {
                    let values = [earlier, block].map(|b| b.offset(at).map_or(f32::NAN, |o| b.values[o]));
                    if values[0] != values[1] && !values.iter().all(|v| v.is_nan()) {
                        let values = values.map(|v| v.to_string());
                        let blocks = [other, number].map(|n| numbers[n]);
                        return Err(AmrError::Overlap { blocks, level, cell: at, values });
                    }
                    repeated += 1;
                }
            }
        }
    }
    Ok(repeated)
}

/// Checks that every block lies within the level before.
pub(super) fn nesting(grid: &AmrGrid, numbers: &[usize]) -> Result<(), AmrError> {
    for (level, lattice) in grid.levels.iter().enumerate().skip(1) {
        for number in lattice.blocks.clone() {
            let block = &grid.blocks[number];
            let from = divided(block.first, lattice.ratio);
            let size = block.cells(grid.centring).map(|n| n as i64);
            let to = plus(from, divided(size, lattice.ratio));
            let mut at = from;
            while at[2] < to[2] {
                let Some(holder) = grid.holder_of_cell(level - 1, at) else {
                    return Err(AmrError::Outside { block: numbers[number], level, cell: at });
                };
                // On to the end of the block that has been found, then to the next row.
                let coarser = &grid.blocks[holder];
                at[0] = coarser.first[0] + coarser.cells(grid.centring)[0] as i64;
                if at[0] >= to[0] {
                    at = [from[0], at[1] + 1, at[2]];
                }
                if at[1] >= to[1] {
                    at = [from[0], from[1], at[2] + 1];
                }
            }
        }
    }
    Ok(())
}

/// All indices of a box, `to` excluded, x fastest.
pub(super) fn each_index(from: [i64; 3], to: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (from[2]..to[2]).flat_map(move |z| (from[1]..to[1]).flat_map(move |y| (from[0]..to[0]).map(move |x| [x, y, z])))
}
