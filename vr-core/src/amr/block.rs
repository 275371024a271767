//! Blocks of values, as they come from files.

/// Place of the values in the cells of an adaptive mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AmrCentring {
    /// One in the middle of each cell.
    Cells,
    /// One at each corner of the cells; neighbouring blocks share a layer of points.
    Points,
}

impl AmrCentring {
    /// Word in messages and descriptions: `cells` or `points`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cells => "cells",
            Self::Points => "points",
        }
    }

    /// Number of elements of a cell along an axis: parts in which the field is one trilinear function.
    pub(super) fn elements(self) -> i64 {
        match self {
            Self::Cells => 2,
            Self::Points => 1,
        }
    }

    /// Number of values beyond the number of cells along an axis.
    pub(super) fn beyond(self) -> i64 {
        match self {
            Self::Cells => 0,
            Self::Points => 1,
        }
    }
}

/// Box of values on the lattice of a level.
///
/// # Examples
/// ```
/// use vr_core::amr::{AmrBlock, AmrCentring};
///
/// // Four cells of level 1, the first of which has the index (2, 0, 0) there.
/// let block = AmrBlock { level: 1, first: [2, 0, 0], dims: [4, 1, 1], values: vec![0.5, 0.6, f32::NAN, 0.8] };
/// assert_eq!(block.cells(AmrCentring::Cells), [4, 1, 1]);
/// assert_eq!(block.cells(AmrCentring::Points), [3, 0, 0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AmrBlock {
    /// Its level; 0 is the coarsest.
    pub level: usize,
    /// Index of its first cell or point in the level's lattice.
    pub first: [i64; 3],
    /// Numbers of cells or points along x, y and z.
    pub dims: [usize; 3],
    /// Values, x fastest; NaN for none.
    pub values: Vec<f32>,
}

impl AmrBlock {
    /// Numbers of cells along x, y and z.
    pub fn cells(&self, centring: AmrCentring) -> [usize; 3] {
        self.dims.map(|n| n.saturating_sub(centring.beyond() as usize))
    }

    /// Index behind the last value of each axis.
    pub(super) fn end(&self) -> [i64; 3] {
        std::array::from_fn(|a| self.first[a] + self.dims[a] as i64)
    }

    /// Place of a lattice index in the values; `None` outside.
    #[inline]
    pub(super) fn offset(&self, at: [i64; 3]) -> Option<usize> {
        let mut local = [0usize; 3];
        for a in 0..3 {
            // A negative difference becomes a number beyond any size.
            local[a] = at[a].wrapping_sub(self.first[a]) as usize;
            if local[a] >= self.dims[a] {
                return None;
            }
        }
        Some((local[2] * self.dims[1] + local[1]) * self.dims[0] + local[0])
    }

    /// True if it holds the values of a box of lattice indices, `from` and `to` included.
    #[inline]
    pub(super) fn holds(&self, from: [i64; 3], to: [i64; 3]) -> bool {
        (0..3).all(|a| self.first[a] <= from[a] && to[a] < self.first[a] + self.dims[a] as i64)
    }
}
