//! Voxels of 16-bit floats (IEEE 754-2008, binary16), which become 32-bit floats: every one of them is one exactly.

use std::path::Path;

use crate::layout::Layout;
use crate::payload::Payload;
use crate::read::ReadOptions;
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};
use crate::voxels::Voxels;

/// Note of a file with such voxels.
pub(crate) const NOTE: &str = "16-bit floats in the file are held as 32-bit floats, exactly";

/// The floats that `payload`, described as u16, holds.
pub(crate) fn source(payload: Payload, header: &Path, layout: &Layout, options: &ReadOptions) -> Source {
    let files = payload.segments.iter().map(|s| s.path.clone()).collect();
    let encoding = payload.encoding.name();
    // All numbers as one row; what the layout picks is picked of the floats.
    let total = layout.total;
    let row = Layout {
        dims: [total, 1, 1],
        strides: [1, total, total],
        offset: 0,
        total,
        frames: 1,
        components: 1,
        is_color: false,
    };
    let (header, options) = (header.to_path_buf(), options.clone());
    let decode = Box::new(move |notes: &mut Vec<String>| {
        Ok(match payload.load(&header, &row, &options, notes)? {
            Voxels::U16(bits) => bits.as_ref().iter().flat_map(|&b| widen(b).to_le_bytes()).collect(),
            // No u16 becomes anything else; if one did, the length would be refused.
            _ => Vec::new(),
        })
    });
    Decoded { decode, scalar: ScalarType::F32, endian: Endian::Little, encoding, files }.into()
}

/// The number that 16 bits stand for: sign, 5 bits of exponent, 10 of fraction.
pub(crate) fn widen(bits: u16) -> f32 {
    let sign = u32::from(bits >> 15) << 31;
    let (exponent, fraction) = (u32::from(bits >> 10 & 0x1f), u32::from(bits & 0x3ff));
    let magnitude = match exponent {
        // Zero and the subnormals: the fraction counts units of 2⁻²⁴.
        0 => (fraction as f32 * f32::from_bits(103 << 23)).to_bits(),
        0x1f => 0xff << 23 | fraction << 13,
        // The bias is 15 there and 127 here.
        _ => (exponent + 112) << 23 | fraction << 13,
    };
    f32::from_bits(sign | magnitude)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_numbers() {
        for (bits, number) in [
            (0x0000, 0.0),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 2f32.powi(-24)),
            (0x8001, -(2f32.powi(-24))),
            (0x03ff, 1023.0 * 2f32.powi(-24)),
            (0x0400, 2f32.powi(-14)),
            (0x3555, 0.333_251_95),
            (0xfc00, f32::NEG_INFINITY),
        ] {
            assert_eq!(widen(bits), number, "{bits:#x}");
        }
        assert!(widen(0x7e00).is_nan());
        assert!(widen(0x8000).is_sign_negative());
    }
}
