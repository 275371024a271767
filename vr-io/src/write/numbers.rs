//! Numbers of a grid as they go into a file: as they are stored, or as calibrated values.

use std::io::{self, Write};
use std::ops::Range;

use vr_core::{AnyGrid, Calibration, GridVolume, ValueFrame, Voxel, with_grid};

use crate::scalar::ScalarType;

/// Numbers of a grid, of the type that a file holds.
#[derive(Clone, Copy)]
pub(super) struct Numbers<'a> {
    grid: &'a AnyGrid,
    calibration: Calibration,
    scalar: ScalarType,
}

impl<'a> Numbers<'a> {
    /// The stored numbers in their type, for a file that holds the calibration beside them.
    pub fn stored(grid: &'a GridVolume) -> Self {
        Self { grid: grid.values(), calibration: Calibration::default(), scalar: grid.voxel_type().into() }
    }

    /// The calibrated values, for a file that holds no calibration: in the type of the stored numbers or another integer type of
    /// at least its width where all of them are whole numbers that fit, else as 32-bit floats, or 64-bit ones where 32 bits
    /// would lose digits.
    pub fn values(grid: &'a GridVolume) -> Self {
        let calibration = grid.calibration();
        Self { grid: grid.values(), calibration, scalar: value_type(grid) }
    }

    /// Values if `calibrated`, else stored numbers.
    pub fn new(grid: &'a GridVolume, calibrated: bool) -> Self {
        if calibrated { Self::values(grid) } else { Self::stored(grid) }
    }

    /// Type in the file.
    pub fn scalar(&self) -> ScalarType {
        self.scalar
    }

    /// The same numbers as a type of which the caller knows that it holds them.
    pub fn with_scalar(self, scalar: ScalarType) -> Self {
        Self { scalar, ..self }
    }

    /// Number of voxels.
    pub fn count(&self) -> usize {
        with_grid!(self.grid, g => g.samples().len())
    }

    /// Bytes in the file.
    pub fn bytes(&self) -> u64 {
        self.count() as u64 * self.scalar.bytes() as u64
    }

    /// Writes all of them, little-endian.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        self.write_part(0..self.count(), out)
    }

    /// Writes some of them, little-endian.
    pub fn write_part(&self, voxels: Range<usize>, out: &mut dyn Write) -> io::Result<()> {
        with_grid!(self.grid, g => put_as(&g.samples()[voxels], self.calibration, self.scalar, out))
    }
}

/// Type of a file that holds the calibrated values of a grid.
fn value_type(grid: &GridVolume) -> ScalarType {
    let stored = ScalarType::from(grid.voxel_type());
    let Calibration { slope, intercept } = grid.calibration();
    let Some((low, high)) = grid.value_range() else { return stored };
    if grid.calibration() == Calibration::default() {
        return stored;
    }
    let whole = |x: f64| x.fract() == 0.0;
    if grid.voxel_type().is_integer() && whole(slope) && whole(intercept) {
        let integers = [
            (ScalarType::U8, 0.0, 255.0),
            (ScalarType::I8, -128.0, 127.0),
            (ScalarType::U16, 0.0, 65535.0),
            (ScalarType::I16, -32768.0, 32767.0),
        ];
        let wide = |t: ScalarType| t.bytes() >= stored.bytes();
        let mut fitting = integers.iter().filter(|(t, min, max)| wide(*t) && *min <= low && high <= *max).map(|x| x.0);
        let own = fitting.clone().find(|&t| t == stored);
        if let Some(fit) = own.or_else(|| fitting.next()) {
            return fit;
        }
    }
    let largest = low.abs().max(high.abs());
    let loses = ValueFrame::of_range(low, high).is_some_and(|frame| frame.has_offset());
    let beyond = largest > f64::from(f32::MAX) || (largest > 0.0 && largest < f64::from(f32::MIN_POSITIVE));
    if loses || beyond { ScalarType::F64 } else { ScalarType::F32 }
}

/// A number that files hold.
trait Number: Copy {
    fn append(self, out: &mut Vec<u8>);
}

macro_rules! number {
    ($($t:ty),*) => {$(
        impl Number for $t {
            fn append(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
        }
    )*};
}
number!(u8, i8, u16, i16, f32, f64);

fn put_as<T: Voxel>(
    samples: &[T],
    calibration: Calibration,
    scalar: ScalarType,
    out: &mut dyn Write,
) -> io::Result<()> {
    let is_identity = calibration == Calibration::default();
    let value = |s: T| if is_identity { s.to_f32().into() } else { calibration.value(s.to_f32().into()) };
    match scalar {
        ScalarType::U8 => put(samples, out, |s| value(s) as u8),
        ScalarType::I8 => put(samples, out, |s| value(s) as i8),
        ScalarType::U16 => put(samples, out, |s| value(s) as u16),
        ScalarType::I16 => put(samples, out, |s| value(s) as i16),
        ScalarType::F32 => put(samples, out, |s| value(s) as f32),
        ScalarType::F64 => put(samples, out, value),
        other => unreachable!("no writer asks for {other}"),
    }
}

fn put<T: Copy, N: Number>(samples: &[T], out: &mut dyn Write, number: impl Fn(T) -> N) -> io::Result<()> {
    const CHUNK: usize = 1 << 14;
    let mut bytes = Vec::with_capacity(CHUNK * size_of::<N>());
    for chunk in samples.chunks(CHUNK) {
        bytes.clear();
        chunk.iter().for_each(|&s| number(s).append(&mut bytes));
        out.write_all(&bytes)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Filter, Placement, UniformGrid};

    fn written(samples: Vec<i16>, slope: f64, intercept: f64) -> (ScalarType, Vec<u8>) {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([2; 3], samples, placement, Calibration { slope, intercept }).unwrap();
        let grid = GridVolume::new(grid.into(), Filter::default());
        let mut bytes = Vec::new();
        Numbers::values(&grid).write(&mut bytes).unwrap();
        (Numbers::values(&grid).scalar(), bytes)
    }

    #[test]
    fn whole_values_stay_integers() {
        let stored = vec![0, 1, 2, 3, 4, 5, 6, 4095];
        let (scalar, bytes) = written(stored.clone(), 1.0, -1024.0);
        assert_eq!(scalar, ScalarType::I16);
        assert_eq!(bytes[..2], (-1024i16).to_le_bytes());
        assert_eq!(bytes[14..], 3071i16.to_le_bytes());
        assert_eq!(written(stored.clone(), 10.0, 0.0).0, ScalarType::U16);
        assert_eq!(written(stored.clone(), 100.0, 0.0).0, ScalarType::F32);
        assert_eq!(written(stored.clone(), 0.5, 0.0).0, ScalarType::F32);
        // 24 bits do not tell these values apart.
        assert_eq!(written(stored, 0.001, 1e6).0, ScalarType::F64);
    }
}
