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

/// Appends numbers of `bits` bits, little endian in a type of 8 or 16 bits. The top one is the sign where the type has one: codecs differ in
/// whether they repeat it.
pub(super) fn pack(numbers: impl Iterator<Item = i32>, bits: u32, scalar: ScalarType, out: &mut Vec<u8>) {
    let spare = 32 - bits;
    let signed = |x: i32| (x << spare >> spare).to_le_bytes();
    let unsigned = |x: i32| (x.cast_unsigned() << spare >> spare).to_le_bytes();
    match scalar {
        ScalarType::I8 => out.extend(numbers.map(|x| signed(x)[0])),
        ScalarType::U8 => out.extend(numbers.map(|x| unsigned(x)[0])),
        ScalarType::I16 => out.extend(numbers.flat_map(|x| [signed(x)[0], signed(x)[1]])),
        _ => out.extend(numbers.flat_map(|x| [unsigned(x)[0], unsigned(x)[1]])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_is_the_top_bit_of_the_code() {
        let packed = |scalar, numbers: [i32; 3]| {
            let mut out = Vec::new();
            pack(numbers.into_iter(), 12, scalar, &mut out);
            out
        };
        // 2047, −2048 and −1, with the sign repeated and without.
        for numbers in [[0x7ff, 0x800, 0xfff], [0x7ff, -0x800, -1]] {
            assert_eq!(packed(ScalarType::I16, numbers), [0xff, 7, 0, 0xf8, 0xff, 0xff]);
            assert_eq!(packed(ScalarType::U16, numbers), [0xff, 7, 0, 8, 0xff, 0xf]);
        }
    }
}
