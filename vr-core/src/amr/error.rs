//! Errors of an adaptive mesh.

/// An error of a block-structured adaptive mesh. Blocks are counted from 0, in the order in which they were given.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::amr::{AmrBlock, AmrCentring, AmrError, AmrGrid};
///
/// let block = |level, first| AmrBlock { level, first, dims: [4; 3], values: vec![0.0; 64] };
/// let new = |blocks| AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![[2; 3]], blocks, AmrCentring::Cells);
/// let error = new(vec![block(0, [0; 3]), block(1, [6, 0, 0])]).unwrap_err();
/// assert_eq!(error, AmrError::Outside { block: 1, level: 1, cell: [4, 0, 0] });
/// assert_eq!(
///     error.to_string(),
///     "block 1 of level 1 covers the cell [4, 0, 0] of level 0, where that level has no block: each level must lie within the one before"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AmrError {
    /// No block at all, or none of a level.
    #[error(
        "found no block of level {level}, of {levels} levels that the refinement ratios make: each must have at least one"
    )]
    NoBlocks {
        /// The level without blocks.
        level: usize,
        /// Number of levels.
        levels: usize,
    },
    /// More levels than there can be.
    #[error("found {found} levels: there may be at most {max}")]
    Levels {
        /// Number found.
        found: usize,
        /// Largest number.
        max: usize,
    },
    /// More blocks than can be counted.
    #[error("found {found} blocks: there may be at most 4294967294")]
    TooManyBlocks {
        /// Number found.
        found: usize,
    },
    /// A refinement ratio that refines nothing, or too much.
    #[error("refinement ratio from level {level} to {}: found {found:?}; each must be 1 to 1024, and at least one of them 2 or more", level + 1)]
    Ratio {
        /// The coarser level.
        level: usize,
        /// Ratios along x, y and z.
        found: [u32; 3],
    },
    /// Cells of a size that arithmetic cannot keep.
    #[error("spacing of level {level}: found {found:?}; must be 1e-24 to 1e24 along each axis")]
    Spacing {
        /// The level.
        level: usize,
        /// Edges of a cell.
        found: [f64; 3],
    },
    /// An origin that is not finite or so far away that positions in f64 do not tell cells apart.
    #[error(
        "origin: found {found:?}; must be finite, and the mesh at most 1e12 of its finest cells from the world's origin"
    )]
    Origin {
        /// The origin.
        found: [f64; 3],
    },
    /// A block of a level that does not exist.
    #[error("block {block}: found level {found}; there are {levels}, counted from 0")]
    Level {
        /// Number of the block.
        block: usize,
        /// Its level.
        found: usize,
        /// Number of levels.
        levels: usize,
    },
    /// A block without cells.
    #[error("block {block}: found the size {dims:?}; a block of {} must have at least {min} along each axis", centring.name())]
    Dims {
        /// Number of the block.
        block: usize,
        /// Its size.
        dims: [usize; 3],
        /// Place of the values.
        centring: super::AmrCentring,
        /// Smallest size of an axis.
        min: usize,
    },
    /// Values that are not one for each cell or point.
    #[error("block {block}: found {found} values for a size of {dims:?}: each place must have one")]
    Length {
        /// Number of the block.
        block: usize,
        /// Number of values.
        found: usize,
        /// Its size.
        dims: [usize; 3],
    },
    /// A block beyond the indices that f64 tells apart.
    #[error(
        "block {block}: found the first index {first:?} and the size {dims:?}, beyond 2^50 cells of the finest level"
    )]
    Extent {
        /// Number of the block.
        block: usize,
        /// Its first index.
        first: [i64; 3],
        /// Its size.
        dims: [usize; 3],
    },
    /// A block that covers parts of coarser cells.
    #[error(
        "block {block} of level {level}: found the first index {first:?} and {cells:?} cells; both must be multiples of the ratio {ratio:?}, so that \
         it covers whole cells of level {}", level - 1
    )]
    Misaligned {
        /// Number of the block.
        block: usize,
        /// Its level.
        level: usize,
        /// Its first index.
        first: [i64; 3],
        /// Numbers of its cells.
        cells: [usize; 3],
        /// Refinement ratio of its level to the one before.
        ratio: [u32; 3],
    },
    /// A block that reaches beyond the blocks of the level before.
    #[error(
        "block {block} of level {level} covers the cell {cell:?} of level {}, where that level has no block: each level must lie within the one before",
        level - 1
    )]
    Outside {
        /// Number of the block.
        block: usize,
        /// Its level.
        level: usize,
        /// Cell of the level before.
        cell: [i64; 3],
    },
    /// Two blocks of a level that cover the same cell with different values.
    #[error(
        "blocks {} and {} of level {level} both cover the cell {cell:?}, with the values {} and {}: blocks of one level must not overlap, or be equal where they do",
        blocks[0], blocks[1], values[0], values[1]
    )]
    Overlap {
        /// Numbers of the blocks.
        blocks: [usize; 2],
        /// Their level.
        level: usize,
        /// Lattice index of the cell, or of the point.
        cell: [i64; 3],
        /// Their values, as text, since values without a number are never equal.
        values: [String; 2],
    },
    /// No finite value.
    #[error("found no finite value among {found}: there must be at least one")]
    NoValue {
        /// Number of values.
        found: usize,
    },
    /// A mesh without a volume between its outermost values.
    #[error("along {}, there is but one layer of values: there must be at least two", ["x", "y", "z"][*axis])]
    Flat {
        /// The axis: 0, 1 or 2.
        axis: usize,
    },
    /// A sampling that cannot be made.
    #[error("blocks of {found:?} cells: must be 1 to 256 along each axis, and all together at most 2^31 cells")]
    BlockSize {
        /// Numbers asked for.
        found: [usize; 3],
    },
}
