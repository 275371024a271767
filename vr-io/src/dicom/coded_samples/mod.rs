//! Small frames in this folder, and the picture that they hold: its numbers follow from a formula. CharLS wrote those in JPEG-LS,
//! OpenJPEG those in JPEG 2000.

use super::image::{Numbers, Shape};
use crate::scalar::ScalarType;

pub const COLUMNS: usize = 24;
pub const ROWS: usize = 17;

/// Ramps with a little texture, and two flat corners; the numbers of a pixel together.
pub fn picture(bits: u32, samples: usize) -> Vec<i32> {
    let max = (1 << bits) - 1;
    let number = |x: i32, y: i32, c: i32| match (x, y) {
        (..9, ..6) => max / 5,
        (17.., 11..) => max - c,
        _ => (x * max / 30 + y * max / 40 + c * max / 9 + (x * 7 + y * 13 + c * 5) % 11) % (max + 1),
    };
    let (columns, rows, samples) = (COLUMNS as i32, ROWS as i32, samples as i32);
    (0..rows).flat_map(|y| (0..columns).flat_map(move |x| (0..samples).map(move |c| number(x, y, c)))).collect()
}

/// Header of such a frame.
pub fn shape(bits: u32, samples: usize, scalar: ScalarType) -> Shape {
    let numbers = Numbers { scalar, shift: 0, bits, needs_masking: false };
    Shape { rows: ROWS, columns: COLUMNS, samples, planar: false, numbers }
}

/// The numbers of a decoded frame.
pub fn numbers(decoded: &[u8], scalar: ScalarType) -> Vec<i32> {
    let words = || decoded.as_chunks().0.iter();
    match scalar {
        ScalarType::U8 => decoded.iter().map(|&x| x.into()).collect(),
        ScalarType::I16 => words().map(|b| i16::from_le_bytes(*b).into()).collect(),
        _ => words().map(|b| u16::from_le_bytes(*b).into()).collect(),
    }
}

/// Decodes a thousand damaged versions of a frame, the same ones each time: each gives a frame of its size, or an error in one line.
pub fn survive(coded: &[u8], shape: &Shape, decode: impl Fn(&[u8], &Shape) -> std::io::Result<Vec<u8>>) {
    // Marsaglia's xorshift.
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % below
    };
    for _ in 0..1000 {
        let mut bytes = coded.to_vec();
        for _ in 0..=random(3) {
            // Half of the damage is in what tells how to read the rest.
            let end = if random(2) == 0 { bytes.len() } else { bytes.len().min(100) };
            let at = random(end);
            match random(8) {
                0 => bytes.truncate(at.max(1)),
                1 => drop(bytes.drain(at..(at + 1 + random(4)).min(end))),
                2..5 => bytes[at] ^= 1 << random(8),
                _ => bytes[at] = [0, 1, 0x7f, 0xff, random(256) as u8][random(5)],
            }
            if bytes.is_empty() {
                break;
            }
        }
        match decode(&bytes, shape) {
            Ok(decoded) => assert_eq!(decoded.len() as u64, shape.frame_bytes()),
            Err(e) => assert!(!e.to_string().contains('\n'), "{e}"),
        }
    }
}
