//! A dataset of numbers in one run.

use crate::decode::numbers_as_f64;
use crate::error::FileErrorKind;
use crate::scalar::{Endian, ScalarType};

use super::damaged;
use super::window::{Window, word};

/// A dataset of numbers in one run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlainDataset {
    /// Numbers along each axis, the last of which runs fastest.
    pub shape: Vec<u64>,
    pub scalar: ScalarType,
    endian: Endian,
    /// Place of the first number.
    at: u64,
}

impl PlainDataset {
    /// Reads the three messages that describe a dataset; `None` for one of another form.
    pub(super) fn new(space: &[u8], kind: &[u8], layout: &[u8]) -> Option<Self> {
        let (scalar, endian) = type_of(kind)?;
        Some(Self { shape: shape_of(space)?, scalar, endian, at: place_of(layout)? })
    }

    pub(super) fn numbers(&self, window: &mut Window) -> Result<Vec<f64>, FileErrorKind> {
        let size = self.scalar.bytes() as u64;
        let length = self.shape.iter().try_fold(size, |n, &axis| n.checked_mul(axis));
        let length = length.ok_or_else(|| damaged(self.at, "more numbers than can be counted"))?;
        Ok(numbers_as_f64(&window.bytes(self.at, length)?, self.scalar, self.endian))
    }
}

/// Sizes of the axes (IV.A.2.b).
fn shape_of(space: &[u8]) -> Option<Vec<u64>> {
    let (&version, &axes) = (space.first()?, space.get(1)?);
    let begin = match version {
        1 => 8,
        2 => 4,
        _ => return None,
    };
    (0..usize::from(axes)).map(|axis| word(space, begin + 8 * axis)).collect()
}

/// Type and byte order (IV.A.2.d), of whole numbers and IEEE's.
fn type_of(kind: &[u8]) -> Option<(ScalarType, Endian)> {
    let (&class, &bits) = (kind.first()?, kind.get(1)?);
    let size = u32::from_le_bytes(*kind.get(4..)?.first_chunk()?);
    let endian = if bits & 1 == 0 { Endian::Little } else { Endian::Big };
    // Version in the upper half.
    let scalar = match (class & 0x0f, size, bits & 8 != 0) {
        (0, 1, false) => ScalarType::U8,
        (0, 1, true) => ScalarType::I8,
        (0, 2, false) => ScalarType::U16,
        (0, 2, true) => ScalarType::I16,
        (0, 4, false) => ScalarType::U32,
        (0, 4, true) => ScalarType::I32,
        (0, 8, false) => ScalarType::U64,
        (0, 8, true) => ScalarType::I64,
        // Place and size of the exponent, then of the mantissa.
        (1, 4, _) if kind.get(12..16)? == [23, 8, 0, 23] => ScalarType::F32,
        (1, 8, _) if kind.get(12..16)? == [52, 11, 0, 52] => ScalarType::F64,
        _ => return None,
    };
    Some((scalar, endian))
}

/// Place of the numbers (IV.A.2.i); `None` for those in chunks or within the header, and for those that were never written.
fn place_of(layout: &[u8]) -> Option<u64> {
    const IN_ONE_RUN: u8 = 1;
    let at = match *layout {
        [1 | 2, _, IN_ONE_RUN, ..] => word(layout, 8)?,
        [3, IN_ONE_RUN, ..] => word(layout, 2)?,
        _ => return None,
    };
    (at != u64::MAX).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_of_all_versions() {
        let place = 0x1234u64.to_le_bytes();
        let old = [&[2, 4, 1, 0, 0, 0, 0, 0][..], &place, &[0; 16]].concat();
        assert_eq!(place_of(&old), Some(0x1234));
        assert_eq!(place_of(&[&[3, 1][..], &place, &[0; 8]].concat()), Some(0x1234));
        assert_eq!(place_of(&[&[3, 1][..], &[0xff; 8], &[0; 8]].concat()), None);
        assert_eq!(place_of(&[&[3, 2][..], &place].concat()), None);
        assert_eq!(place_of(&old[..9]), None);
    }

    #[test]
    fn types_and_shapes() {
        let float = [0x11, 0x21, 31, 0, 4, 0, 0, 0, 0, 0, 32, 0, 23, 8, 0, 23, 127, 0, 0, 0];
        assert_eq!(type_of(&float), Some((ScalarType::F32, Endian::Big)));
        assert_eq!(type_of(&[0x10, 8, 0, 0, 2, 0, 0, 0, 0, 0, 16, 0]), Some((ScalarType::I16, Endian::Little)));
        assert_eq!(type_of(&[0x13, 0, 0, 0, 2, 0, 0, 0]), None);
        let space = [&[1u8, 2, 0, 0, 0, 0, 0, 0][..], &3u64.to_le_bytes(), &5u64.to_le_bytes()].concat();
        assert_eq!(shape_of(&space), Some(vec![3, 5]));
        assert_eq!(shape_of(&space[..20]), None);
    }
}
