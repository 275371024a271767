//! Decoding of bytes, or words of text, to numbers.

use bytemuck::Pod;

use crate::scalar::{Endian, ScalarType};

/// A number type of a file.
pub(crate) trait Scalar: Pod + PartialOrd + Send + Sync + 'static {
    /// Appends the numbers that whole groups of bytes stand for.
    fn append(bytes: &[u8], endian: Endian, out: &mut Vec<Self>);
    /// The number that a word stands for.
    fn parse(word: &str) -> Option<Self>;
}

macro_rules! scalar {
    ($($t:ty),*) => {$(
        impl Scalar for $t {
            fn append(bytes: &[u8], endian: Endian, out: &mut Vec<Self>) {
                let groups = bytes.as_chunks().0.iter();
                // The machine's own order is copied as it is.
                if endian == Endian::NATIVE {
                    let start = out.len();
                    out.resize(start + groups.len(), <$t>::default());
                    let copied = bytemuck::cast_slice_mut(&mut out[start..]);
                    copied.copy_from_slice(&bytes[..copied.len()]);
                    return;
                }
                match endian {
                    Endian::Little => out.extend(groups.map(|b| <$t>::from_le_bytes(*b))),
                    Endian::Big => out.extend(groups.map(|b| <$t>::from_be_bytes(*b))),
                }
            }
            fn parse(word: &str) -> Option<Self> {
                word.parse().ok()
            }
        }
    )*};
}
scalar!(u8, i8, u16, i16, u32, i32, u64, i64, f32, f64);

/// Runs one expression for the type that a [`crate::ScalarType`] names: `with_scalar!(scalar, S => f::<S>())`.
macro_rules! with_scalar {
    ($scalar:expr, $s:ident => $body:expr) => {
        match $scalar {
            $crate::ScalarType::U8 => with_scalar!(@ $s = u8, $body),
            $crate::ScalarType::I8 => with_scalar!(@ $s = i8, $body),
            $crate::ScalarType::U16 => with_scalar!(@ $s = u16, $body),
            $crate::ScalarType::I16 => with_scalar!(@ $s = i16, $body),
            $crate::ScalarType::U32 => with_scalar!(@ $s = u32, $body),
            $crate::ScalarType::I32 => with_scalar!(@ $s = i32, $body),
            $crate::ScalarType::U64 => with_scalar!(@ $s = u64, $body),
            $crate::ScalarType::I64 => with_scalar!(@ $s = i64, $body),
            $crate::ScalarType::F32 => with_scalar!(@ $s = f32, $body),
            $crate::ScalarType::F64 => with_scalar!(@ $s = f64, $body),
        }
    };
    (@ $s:ident = $t:ty, $body:expr) => {{
        type $s = $t;
        $body
    }};
}
pub(crate) use with_scalar;

/// The numbers that whole groups of bytes stand for. Integers beyond 2⁵³ are rounded.
#[allow(clippy::unnecessary_cast, reason = "one of the ten types is f64")]
pub(crate) fn numbers_as_f64(bytes: &[u8], scalar: ScalarType, endian: Endian) -> Vec<f64> {
    with_scalar!(scalar, S => {
        let mut stored: Vec<S> = Vec::with_capacity(bytes.len() / size_of::<S>());
        S::append(bytes, endian, &mut stored);
        stored.into_iter().map(|x| x as f64).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_byte_orders() {
        let mut out = Vec::new();
        i16::append(&[0xfe, 0xff, 0x01, 0x00], Endian::Little, &mut out);
        i16::append(&[0xff, 0xfe, 0x00, 0x01], Endian::Big, &mut out);
        assert_eq!(out, [-2, 1, -2, 1]);
    }

    #[test]
    fn words_out_of_range_are_no_numbers() {
        assert_eq!(u8::parse("255"), Some(255));
        assert_eq!(u8::parse("256"), None);
        assert_eq!(u8::parse("-1"), None);
        assert!(f32::parse("nan").unwrap().is_nan());
    }
}
