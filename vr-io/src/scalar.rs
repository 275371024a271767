//! The voxel types that files hold.

use serde::{Deserialize, Serialize};
use vr_core::{ParameterError, VoxelType};

/// The type of the voxels in a file. Memory holds five of them (see [`VoxelType`]); the others are converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", rename_all = "lowercase")]
pub enum ScalarType {
    /// Unsigned 8-bit integers.
    U8,
    /// Signed 8-bit integers.
    I8,
    /// Unsigned 16-bit integers.
    U16,
    /// Signed 16-bit integers.
    I16,
    /// Unsigned 32-bit integers.
    U32,
    /// Signed 32-bit integers.
    I32,
    /// Unsigned 64-bit integers.
    U64,
    /// Signed 64-bit integers.
    I64,
    /// 32-bit floats.
    F32,
    /// 64-bit floats.
    F64,
}

impl ScalarType {
    /// Every type.
    pub const ALL: [Self; 10] =
        [Self::U8, Self::I8, Self::U16, Self::I16, Self::U32, Self::I32, Self::U64, Self::I64, Self::F32, Self::F64];

    /// Bytes per number.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// `u8`, `i8`, … `f64`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// The type of a short name (`u8`), or of a long one as file names have it (`uint8`, `float32`, `float`, `double`).
    pub fn from_name(name: &str) -> Option<Self> {
        let long = |t: &Self| match t.name().as_bytes()[0] {
            b'u' => t.name().replacen('u', "uint", 1),
            b'i' => t.name().replacen('i', "int", 1),
            _ => t.name().replacen('f', "float", 1),
        };
        match name {
            "float" => Some(Self::F32),
            "double" => Some(Self::F64),
            _ => Self::ALL.into_iter().find(|t| t.name() == name || long(t) == name),
        }
    }
}

impl TryFrom<String> for ScalarType {
    type Error = ParameterError;

    fn try_from(name: String) -> Result<Self, ParameterError> {
        let allowed = "must be u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64";
        Self::from_name(&name).ok_or_else(|| ParameterError::new("volume.type", name, allowed))
    }
}

impl From<VoxelType> for ScalarType {
    fn from(t: VoxelType) -> Self {
        match t {
            VoxelType::U8 => Self::U8,
            VoxelType::I8 => Self::I8,
            VoxelType::U16 => Self::U16,
            VoxelType::I16 => Self::I16,
            VoxelType::F32 => Self::F32,
        }
    }
}

impl std::fmt::Display for ScalarType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Byte order: the byte of a number that comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Endian {
    /// The lowest one, as on x86-64.
    #[default]
    Little,
    /// The highest one.
    Big,
}

impl Endian {
    /// The order of the machine that runs this.
    pub const NATIVE: Self = if cfg!(target_endian = "big") { Self::Big } else { Self::Little };
}

impl std::fmt::Display for Endian {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Little => "little-endian",
            Self::Big => "big-endian",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_short_and_long() {
        for t in ScalarType::ALL {
            assert_eq!(ScalarType::from_name(t.name()), Some(t));
        }
        assert_eq!(ScalarType::from_name("uint16"), Some(ScalarType::U16));
        assert_eq!(ScalarType::from_name("int64"), Some(ScalarType::I64));
        assert_eq!(ScalarType::from_name("float64"), Some(ScalarType::F64));
        assert_eq!(ScalarType::from_name("quaternion"), None);
    }
}
