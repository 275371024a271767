//! Levels of an adaptive mesh.

use std::ops::Range;

use glam::DVec3;

use super::bin_index::BinIndex;

/// Lattice of a level, and the blocks on it.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// Edges of a cell, in world units.
    pub(super) spacing: DVec3,
    /// Edges of an element, in world units.
    pub(super) edge: DVec3,
    /// Elements per world unit.
    pub(super) rate: DVec3,
    /// Refinement ratio of the level before to this one; 1 for level 0.
    pub(super) ratio: [i64; 3],
    /// Cells of the finest level along the edges of a cell of this one.
    pub(super) to_finest: [i64; 3],
    /// Numbers of its blocks.
    pub(super) blocks: Range<usize>,
    /// Its blocks by place.
    pub(super) index: BinIndex,
}

/// Component-wise quotient, rounded down, by numbers above 0.
#[inline]
pub(super) fn divided(at: [i64; 3], by: [i64; 3]) -> [i64; 3] {
    // Ratios are powers of two as a rule, and divisions take ten times as long.
    std::array::from_fn(|a| {
        if by[a] & (by[a] - 1) == 0 { at[a] >> by[a].trailing_zeros() } else { at[a].div_euclid(by[a]) }
    })
}

/// Component-wise product.
#[inline]
pub(super) fn times(at: [i64; 3], by: [i64; 3]) -> [i64; 3] {
    std::array::from_fn(|a| at[a] * by[a])
}

/// Component-wise sum.
#[inline]
pub(super) fn plus(at: [i64; 3], by: [i64; 3]) -> [i64; 3] {
    std::array::from_fn(|a| at[a] + by[a])
}

/// Offsets of the eight corners of a unit cube, x fastest.
#[inline]
pub(super) fn corner(number: usize) -> [i64; 3] {
    [number & 1, number >> 1 & 1, number >> 2 & 1].map(|bit| bit as i64)
}
