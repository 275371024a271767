//! A frame that a codec decodes, held against the header of its image before and packed as the header says after.

use std::io;

use super::image::Shape;
use crate::encoding::invalid;
use crate::scalar::ScalarType;

/// Size that the code of a frame states by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CodedFrame {
    pub columns: usize,
    pub rows: usize,
    /// Numbers a pixel.
    pub samples: usize,
    /// Bits of a number.
    pub bits: u32,
}

impl CodedFrame {
    /// Refuses a frame that differs from the header, before anything is allocated for it.
    pub fn check(&self, shape: &Shape) -> io::Result<()> {
        let Self { columns, rows, samples, bits } = *self;
        if (columns, rows) != (shape.columns, shape.rows) {
            let allowed = format!("not {}x{} as Columns and Rows say", shape.columns, shape.rows);
            return Err(invalid(format!("{columns}x{rows} pixels, {allowed}")));
        }
        let room = shape.numbers.scalar.bytes() as u32 * 8;
        // The codecs that are read end at 16 bits, and a header of more says that they are not the numbers of the frame.
        if samples != shape.samples || bits > room || room > 16 {
            let allowed = format!("not {} of up to {room} as the header says", shape.samples);
            return Err(invalid(format!("{samples} samples of {bits} bits a pixel, {allowed}")));
        }
        Ok(())
    }
}

/// Puts the planes of components together: little endian, the numbers of a pixel side by side, in a type of 8 or 16 bits. `number` gives one of
/// `bits` bits. The top one is the sign where the type has one: codecs differ in whether they repeat it.
pub(super) fn pack<T: Copy>(planes: &[&[T]], number: impl Fn(T) -> i32, bits: u32, scalar: ScalarType) -> Vec<u8> {
    let spare = 32 - bits;
    let low_bytes = |x: i32| match scalar {
        ScalarType::I8 | ScalarType::I16 => (x << spare >> spare).to_le_bytes(),
        _ => (x.cast_unsigned() << spare >> spare).to_le_bytes(),
    };
    let mut out = vec![0; planes.iter().map(|plane| plane.len()).sum::<usize>() * scalar.bytes()];
    for (c, plane) in planes.iter().enumerate() {
        let numbers = plane.iter().map(|&x| low_bytes(number(x)));
        if scalar.bytes() == 1 {
            let places = out.iter_mut().skip(c).step_by(planes.len());
            places.zip(numbers).for_each(|(to, [low, ..])| *to = low);
        } else {
            let places = out.as_chunks_mut().0.iter_mut().skip(c).step_by(planes.len());
            places.zip(numbers).for_each(|(to, [low, high, ..])| *to = [low, high]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_is_the_top_bit_of_the_code() {
        // 2047, −2048 and −1, with the sign repeated and without.
        for numbers in [[0x7ff, 0x800, 0xfff], [0x7ff, -0x800, -1]] {
            let packed = |scalar| pack(&[&numbers], |x| x, 12, scalar);
            assert_eq!(packed(ScalarType::I16), [0xff, 7, 0, 0xf8, 0xff, 0xff]);
            assert_eq!(packed(ScalarType::U16), [0xff, 7, 0, 8, 0xff, 0xf]);
        }
    }

    #[test]
    fn numbers_of_a_pixel_stand_side_by_side() {
        let planes = [[1u16, 2].as_slice(), &[3, 4], &[5, 0xff]];
        assert_eq!(pack(&planes, i32::from, 8, ScalarType::U8), [1, 3, 5, 2, 4, 0xff]);
        assert_eq!(pack(&planes, i32::from, 8, ScalarType::I16), [1, 0, 3, 0, 5, 0, 2, 0, 4, 0, 0xff, 0xff]);
    }
}
