//! A uniform grid whose voxel type is known at run time only.

use crate::grid::UniformGrid;

/// A uniform grid of any voxel type.
///
/// # Examples
/// ```
/// use vr_core::{AnyGrid, Calibration, Placement, UniformGrid, with_grid};
///
/// // A reader learns the type of the voxels from the file's header.
/// let placement = Placement::from_spacing([1.0; 3])?;
/// let grid = AnyGrid::from(UniformGrid::new([2, 2, 3], vec![0i16; 12], placement, Calibration::default())?);
/// assert!(matches!(grid, AnyGrid::I16(_)));
/// assert_eq!(with_grid!(&grid, g => g.dims()), [2, 2, 3]);
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug)]
pub enum AnyGrid {
    /// Unsigned 8-bit integers.
    U8(UniformGrid<u8>),
    /// Signed 8-bit integers.
    I8(UniformGrid<i8>),
    /// Unsigned 16-bit integers.
    U16(UniformGrid<u16>),
    /// Signed 16-bit integers.
    I16(UniformGrid<i16>),
    /// 32-bit floats.
    F32(UniformGrid<f32>),
}

/// Runs one expression for the voxel type that an [`AnyGrid`] holds: `with_grid!(any, g => g.dims())`.
#[macro_export]
macro_rules! with_grid {
    ($any:expr, $grid:ident => $body:expr) => {
        match $any {
            $crate::AnyGrid::U8($grid) => $body,
            $crate::AnyGrid::I8($grid) => $body,
            $crate::AnyGrid::U16($grid) => $body,
            $crate::AnyGrid::I16($grid) => $body,
            $crate::AnyGrid::F32($grid) => $body,
        }
    };
}

macro_rules! any_grid_from {
    ($($t:ty => $variant:ident),*) => {$(
        impl From<UniformGrid<$t>> for AnyGrid {
            fn from(grid: UniformGrid<$t>) -> Self {
                Self::$variant(grid)
            }
        }
    )*};
}
any_grid_from!(u8 => U8, i8 => I8, u16 => U16, i16 => I16, f32 => F32);
