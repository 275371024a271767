//! Voxels in a memory type, owned or mapped, and the conversion of the other types.

use vr_core::{AnyGrid, Calibration, GridError, Placement, UniformGrid, ValueFrame, Voxel};

use crate::decode::Scalar;
use crate::mapped::MappedVoxels;

/// Voxels of one type: in memory, or in their file.
pub(crate) enum Stored<T> {
    Owned(Vec<T>),
    Mapped(MappedVoxels<T>),
}

impl<T: Scalar> AsRef<[T]> for Stored<T> {
    fn as_ref(&self) -> &[T] {
        match self {
            Self::Owned(v) => v,
            Self::Mapped(m) => m.as_ref(),
        }
    }
}

/// Voxels of any of the five types that memory holds.
pub(crate) enum Voxels {
    U8(Stored<u8>),
    I8(Stored<i8>),
    U16(Stored<u16>),
    I16(Stored<i16>),
    F32(Stored<f32>),
    /// Numbers of a wider type, in a frame in which f32 keeps their digits.
    Framed(Vec<f32>, ValueFrame),
}

impl Voxels {
    pub fn into_grid(
        self,
        dims: [usize; 3],
        placement: Placement,
        calibration: Calibration,
    ) -> Result<AnyGrid, GridError> {
        fn grid<T: Voxel + Scalar>(
            dims: [usize; 3],
            samples: Stored<T>,
            placement: Placement,
            calibration: Calibration,
        ) -> Result<AnyGrid, GridError>
        where
            AnyGrid: From<UniformGrid<T>>,
        {
            Ok(UniformGrid::new(dims, samples, placement, calibration)?.into())
        }
        match self {
            Self::U8(s) => grid(dims, s, placement, calibration),
            Self::I8(s) => grid(dims, s, placement, calibration),
            Self::U16(s) => grid(dims, s, placement, calibration),
            Self::I16(s) => grid(dims, s, placement, calibration),
            Self::F32(s) => grid(dims, s, placement, calibration),
            Self::Framed(s, frame) => {
                let Calibration { slope, intercept } = calibration;
                let framed = frame.calibration(calibration).ok_or(GridError::Calibration { slope, intercept })?;
                grid(dims, Stored::Owned(s), placement, framed)
            }
        }
    }

    pub fn is_mapped(&self) -> bool {
        matches!(
            self,
            Self::U8(Stored::Mapped(_))
                | Self::I8(Stored::Mapped(_))
                | Self::U16(Stored::Mapped(_))
                | Self::I16(Stored::Mapped(_))
                | Self::F32(Stored::Mapped(_))
        )
    }
}

/// Brings voxels to a memory type.
pub(crate) trait Remember: Scalar {
    /// True if memory holds this type as it is.
    const IS_MEMORY_TYPE: bool;
    /// Converts voxels to a memory type. Integers that fit one exactly become that one, everything else floats; a note says
    /// how many were rounded.
    fn remember(samples: Stored<Self>, notes: &mut Vec<String>) -> Voxels;
}

macro_rules! as_it_is {
    ($($t:ty => $variant:ident),*) => {$(
        impl Remember for $t {
            const IS_MEMORY_TYPE: bool = true;
            fn remember(samples: Stored<Self>, _: &mut Vec<String>) -> Voxels {
                Voxels::$variant(samples)
            }
        }
    )*};
}
as_it_is!(u8 => U8, i8 => I8, u16 => U16, i16 => I16, f32 => F32);

macro_rules! wide_integer {
    ($($t:ty),*) => {$(
        impl Remember for $t {
            const IS_MEMORY_TYPE: bool = false;
            fn remember(samples: Stored<Self>, notes: &mut Vec<String>) -> Voxels {
                let s = samples.as_ref();
                let name = stringify!($t);
                let low = s.iter().copied().min().unwrap_or(0);
                let high = s.iter().copied().max().unwrap_or(0);
                macro_rules! narrow {
                    ($to:ident, $variant:ident) => {
                        if let (Ok(_), Ok(_)) = ($to::try_from(low), $to::try_from(high)) {
                            notes.push(format!("{name} voxels from {low} to {high} are held as {}", stringify!($to)));
                            return Voxels::$variant(Stored::Owned(s.iter().map(|&x| x as $to).collect()));
                        }
                    };
                }
                narrow!(u8, U8);
                narrow!(i8, I8);
                narrow!(u16, U16);
                narrow!(i16, I16);
                let floats: Vec<f32> = s.iter().map(|&x| x as f32).collect();
                // Through i128, since casts from float saturate: u64::MAX rounds up to 2^64 and must not count as exact.
                let rounded = s.iter().zip(&floats).filter(|&(&x, &f)| i128::from(x) != f as i128).count();
                if rounded > 0
                    && let Some(frame) = ValueFrame::of_range(low as f64, high as f64).filter(ValueFrame::has_offset)
                {
                    notes.push(framed_note(name, frame, low as f64, high as f64));
                    return Voxels::Framed(s.iter().map(|&x| frame.stored(x as f64)).collect(), frame);
                }
                notes.push(float_note(name, rounded, s.len()));
                Voxels::F32(Stored::Owned(floats))
            }
        }
    )*};
}
wide_integer!(u32, i32, u64, i64);

impl Remember for f64 {
    const IS_MEMORY_TYPE: bool = false;
    fn remember(samples: Stored<Self>, notes: &mut Vec<String>) -> Voxels {
        let s = samples.as_ref();
        let floats: Vec<f32> = s.iter().map(|&x| x as f32).collect();
        // NaN differs from itself and is not rounded; what overflows f32 becomes infinite, which is.
        let rounded = s.iter().zip(&floats).filter(|&(&x, &f)| !x.is_nan() && x != f64::from(f)).count();
        let finite = || s.iter().copied().filter(|x| x.is_finite());
        let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        if rounded > 0
            && low <= high
            && let Some(frame) = ValueFrame::of_range(low, high)
        {
            notes.push(framed_note("f64", frame, low, high));
            return Voxels::Framed(s.iter().map(|&x| frame.stored(x)).collect(), frame);
        }
        notes.push(float_note("f64", rounded, s.len()));
        Voxels::F32(Stored::Owned(floats))
    }
}

fn float_note(name: &str, rounded: usize, of: usize) -> String {
    match rounded {
        0 => format!("{name} voxels are held as f32, all of them exactly"),
        n => format!("{name} voxels are held as f32: {n} of {of} were rounded"),
    }
}

/// Note on numbers from `low` to `high` that are carried in a frame.
fn framed_note(name: &str, frame: ValueFrame, low: f64, high: f64) -> String {
    let beyond = low.abs().max(high.abs()) > f64::from(f32::MAX);
    let range = if beyond { format!(" from {low:.6e} to {high:.6e}, beyond f32,") } else { String::new() };
    let held = if frame.has_offset() {
        "f32 distances from one of them, to seven digits of their range"
    } else {
        "f32 multiples of a power of two, to seven digits of the largest"
    };
    format!("{name} voxels{range} are held as {held}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remember<T: Remember>(v: Vec<T>) -> (Voxels, String) {
        let mut notes = Vec::new();
        let s = T::remember(Stored::Owned(v), &mut notes);
        (s, notes.join("; "))
    }

    #[test]
    fn integers_take_the_smallest_type_that_holds_them() {
        assert!(matches!(remember(vec![0i32, 255]).0, Voxels::U8(_)));
        assert!(matches!(remember(vec![-1i32, 127]).0, Voxels::I8(_)));
        assert!(matches!(remember(vec![0u64, 256]).0, Voxels::U16(_)));
        assert!(matches!(remember(vec![-1024i64, 3071]).0, Voxels::I16(_)));
        assert!(matches!(remember(vec![0u32, 65536]).0, Voxels::F32(_)));
    }

    #[test]
    fn says_what_was_rounded() {
        assert!(remember(vec![0i32, 1 << 24]).1.contains("exactly"));
        assert!(remember(vec![0i32, (1 << 24) + 1]).1.contains("1 of 2 were rounded"));
        assert!(remember(vec![u64::MAX, 0]).1.contains("1 of 2 were rounded"));
        assert!(remember(vec![0.1f64, 0.5, f64::NAN]).1.contains("1 of 3 were rounded"));
    }

    #[test]
    fn digits_far_from_zero_are_kept() {
        let values = vec![1e7 + 0.25, 1e7 + 0.26, f64::NAN, 1e7 + 0.5, 1e7, 1e7 + 0.75, 1e7 + 0.1, 1e7 + 0.3];
        let (samples, note) = remember(values.clone());
        assert!(note.contains("distances"), "{note}");
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let calibration = Calibration { slope: 3.0, intercept: 1.0 };
        let AnyGrid::F32(grid) = samples.into_grid([2; 3], placement, calibration).unwrap() else { panic!("floats") };
        for (stored, value) in grid.samples().iter().zip(values) {
            let (got, wanted) = (grid.calibration().value(f64::from(*stored)), calibration.value(value));
            assert!((got - wanted).abs() < 1e-6 || wanted.is_nan(), "{got} {wanted}");
        }
    }
}
