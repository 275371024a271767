//! Codes of encoded voxels: one or two bytes for the stored number.

use crate::composite::cells::Interpolated;
use vr_core::{GridVolume, VoxelType};

/// Between stored numbers and codes: integers are their own codes, but for a shift of negative ones; floats are rounded to 65536 levels of
/// their range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Codes {
    /// The stored number of code 0.
    pub(crate) origin: f64,
    /// Stored units from code to code.
    pub(crate) spacing: f64,
    /// True if one byte holds a code.
    pub(crate) bytes: bool,
    /// Smallest and largest stored number of the volume.
    pub(crate) range: [f64; 2],
}

impl Codes {
    pub(crate) fn of(volume: &GridVolume) -> Self {
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let range = [f64::from(low), f64::from(high)];
        let (origin, spacing, bytes) = match volume.voxel_type() {
            VoxelType::U8 => (0.0, 1.0, true),
            VoxelType::I8 => (-128.0, 1.0, true),
            VoxelType::U16 => (0.0, 1.0, false),
            VoxelType::I16 => (-32768.0, 1.0, false),
            VoxelType::F32 => {
                let span = range[1] - range[0];
                (range[0], if span > 0.0 { span / f64::from(u16::MAX) } else { 1.0 }, false)
            }
        };
        Self { origin, spacing, bytes, range }
    }

    /// The stored number of a code, or of what lies between two.
    pub(crate) fn stored(&self, code: f64) -> f64 {
        self.origin + self.spacing * code
    }

    /// The code of a stored number, or the place between two codes.
    pub(crate) fn exact(&self, stored: f64) -> f64 {
        (stored - self.origin) / self.spacing
    }

    /// Smallest and largest code of the volume.
    pub(crate) fn ends(&self) -> [f64; 2] {
        self.range.map(|stored| self.exact(stored))
    }

    /// The code of a stored number; of NaN, 0.
    #[inline(always)]
    pub(crate) fn code(&self, stored: f32) -> u16 {
        // `as` saturates.
        ((f64::from(stored) - self.origin) / self.spacing + 0.5) as u16
    }
}

/// First entry of tables of codes: code c has its row at (c − first) >> shift. Bytes have a row each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Begin {
    pub(crate) first: usize,
    pub(crate) shift: u32,
}

/// A code in memory.
pub(crate) trait Code: Interpolated + Default + Send + Sync + 'static {
    /// A table of light and opacity that is as long as any for this type of code: an index that cannot be beyond it is not tested.
    type Table: Send + Sync + 'static;
    #[cfg(test)]
    fn of(code: u16) -> Self;
    /// Row of a code in a table of codes.
    fn place(self, begin: Begin) -> usize;
    /// A table, and nothing in the rest of it.
    fn table(rows: impl Iterator<Item = [f32; 4]>) -> Box<Self::Table>;
    /// A row; beyond the table's length it starts anew.
    fn row(table: &Self::Table, i: usize) -> &[f32; 4];
    /// The last row's number.
    const LAST: usize;
}

macro_rules! code {
    ($t:ty, $length:literal) => {
        impl Interpolated for $t {
            #[inline(always)]
            fn to_f32(self) -> f32 {
                self.into()
            }
        }
        impl Code for $t {
            type Table = [[f32; 4]; $length];
            #[cfg(test)]
            fn of(code: u16) -> Self {
                code as Self
            }
            const LAST: usize = $length - 1;
            fn table(rows: impl Iterator<Item = [f32; 4]>) -> Box<Self::Table> {
                let mut all = vec![[0.0; 4]; $length];
                // The last one stays nothing.
                all[..$length - 1].iter_mut().zip(rows).for_each(|(to, row)| *to = row);
                all.try_into().expect("as many as there are")
            }
            #[inline(always)]
            fn row(table: &Self::Table, i: usize) -> &[f32; 4] {
                &table[i % $length]
            }
            #[inline(always)]
            fn place(self, begin: Begin) -> usize {
                // A byte is its own place.
                if size_of::<Self>() == 1 {
                    usize::from(self)
                } else {
                    usize::from(self).wrapping_sub(begin.first) >> begin.shift
                }
            }
        }
    };
}
code!(u8, 2048);
code!(u16, 16384);
