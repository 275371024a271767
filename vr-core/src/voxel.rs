//! Voxel types that a grid can hold in memory.

/// Type of the voxels of a grid.
///
/// # Examples
/// ```
/// use vr_core::VoxelType;
///
/// assert_eq!((VoxelType::I16.bytes(), VoxelType::I16.to_string()), (2, "i16".to_owned()));
/// assert!(VoxelType::U8.is_integer() && !VoxelType::F32.is_integer());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum VoxelType {
    /// Unsigned 8-bit integers.
    U8,
    /// Signed 8-bit integers.
    I8,
    /// Unsigned 16-bit integers.
    U16,
    /// Signed 16-bit integers.
    I16,
    /// 32-bit floats.
    F32,
}

impl VoxelType {
    /// Bytes per voxel.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::F32 => 4,
        }
    }

    /// True for the four integer types.
    pub fn is_integer(self) -> bool {
        self != Self::F32
    }

    /// Name: `u8`, `i8`, `u16`, `i16` or `f32`.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::F32 => "f32",
        }
    }
}

impl std::fmt::Display for VoxelType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

mod sealed {
    pub trait Sealed {}
}

/// A voxel type. Sealed: kernels are instantiated for exactly these five.
///
/// # Examples
/// ```
/// use vr_core::{Voxel, VoxelType};
///
/// fn mean<T: Voxel>(voxels: &[T]) -> f32 {
///     let present = voxels.iter().filter(|v| !v.is_missing());
///     present.clone().map(|v| v.to_f32()).sum::<f32>() / present.count() as f32
/// }
/// assert_eq!(mean(&[1u8, 2]), 1.5);
/// assert_eq!(mean(&[1.0, f32::NAN, 4.0]), 2.5);
/// assert_eq!(<i16 as Voxel>::TYPE, VoxelType::I16);
/// ```
pub trait Voxel: Copy + PartialOrd + Default + Send + Sync + std::fmt::Debug + sealed::Sealed + 'static {
    /// The type as a value.
    const TYPE: VoxelType;
    /// The stored number; exact.
    fn to_f32(self) -> f32;
    /// True if the voxel is NaN or infinite, which only floats can be.
    fn is_missing(self) -> bool;
    /// A copy of the voxels in which infinite ones are NaN.
    fn infinite_to_nan(samples: &[Self]) -> Vec<Self> {
        samples.to_vec()
    }
}

macro_rules! voxel {
    ($t:ty, $name:ident) => {
        impl sealed::Sealed for $t {}
        impl Voxel for $t {
            const TYPE: VoxelType = VoxelType::$name;
            #[inline(always)]
            fn to_f32(self) -> f32 {
                self.into()
            }
            #[inline(always)]
            fn is_missing(self) -> bool {
                false
            }
        }
    };
}
voxel!(u8, U8);
voxel!(i8, I8);
voxel!(u16, U16);
voxel!(i16, I16);

impl sealed::Sealed for f32 {}
impl Voxel for f32 {
    const TYPE: VoxelType = VoxelType::F32;
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }
    #[inline(always)]
    fn is_missing(self) -> bool {
        !self.is_finite()
    }
    fn infinite_to_nan(samples: &[Self]) -> Vec<Self> {
        samples.iter().map(|&x| if x.is_infinite() { f32::NAN } else { x }).collect()
    }
}
