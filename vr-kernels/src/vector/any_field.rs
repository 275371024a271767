//! Fields of voxels of any type.

use vr_core::filter::Lattice;
use vr_core::{AnyGrid, GridVolume};

use super::Field;

/// One of five things, by the type of the voxels in it.
#[derive(Clone, Copy, Debug)]
pub enum ByType<A, B, C, D, E> {
    /// Unsigned bytes.
    U8(A),
    /// Signed bytes.
    I8(B),
    /// Unsigned numbers of 16 bits.
    U16(C),
    /// Signed numbers of 16 bits.
    I16(D),
    /// Floats of 32 bits.
    F32(E),
}

/// Cells of voxels of any type.
pub type AnyField<'a> = ByType<Field<'a, u8>, Field<'a, i8>, Field<'a, u16>, Field<'a, i16>, Field<'a, f32>>;

impl<'a> AnyField<'a> {
    /// Returns the voxels of a volume of fewer than 2³¹ of them; beside missing ones, the values that stand for these.
    pub fn of_volume(volume: &'a GridVolume) -> Self {
        let dims = volume.dims();
        match volume.values() {
            AnyGrid::U8(grid) => Self::U8(Field::new(&Lattice { samples: grid.samples(), dims })),
            AnyGrid::I8(grid) => Self::I8(Field::new(&Lattice { samples: grid.samples(), dims })),
            AnyGrid::U16(grid) => Self::U16(Field::new(&Lattice { samples: grid.samples(), dims })),
            AnyGrid::I16(grid) => Self::I16(Field::new(&Lattice { samples: grid.samples(), dims })),
            AnyGrid::F32(grid) => {
                let samples = volume.filled_floats().unwrap_or(grid.samples());
                Self::F32(Field::new(&Lattice { samples, dims }))
            }
        }
    }
}

/// Runs code for what a `ByType` holds, whatever its type.
#[macro_export]
macro_rules! with_any {
    ($any:expr, $thing:ident => $body:expr) => {
        match $any {
            $crate::vector::ByType::U8($thing) => $body,
            $crate::vector::ByType::I8($thing) => $body,
            $crate::vector::ByType::U16($thing) => $body,
            $crate::vector::ByType::I16($thing) => $body,
            $crate::vector::ByType::F32($thing) => $body,
        }
    };
}
