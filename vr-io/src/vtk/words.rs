//! Numbers written as words, between blanks.

use std::str::FromStr;

use crate::decode::{Scalar, with_scalar};
use crate::scalar::{Endian, ScalarType};

/// A word that is no number.
pub(super) struct BadWord {
    /// Byte of the text at which it begins.
    pub at: usize,
    pub word: String,
}

/// All numbers of a text.
pub(super) fn numbers<T>(text: &[u8], parse: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, BadWord> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words
        .map(|word| {
            str::from_utf8(word).ok().and_then(&parse).ok_or_else(|| BadWord {
                at: word.as_ptr().addr() - text.as_ptr().addr(),
                word: String::from_utf8_lossy(word).into_owned(),
            })
        })
        .collect()
}

/// The numbers of all words, if they are as many as that.
pub(crate) fn exactly<'w, T: FromStr, const N: usize>(words: impl Iterator<Item = &'w str>) -> Option<[T; N]> {
    let numbers: Option<Vec<T>> = words.map(|word| word.parse().ok()).collect();
    numbers?.try_into().ok()
}

/// The bytes of all numbers of a text.
pub(super) fn bytes(text: &[u8], scalar: ScalarType, endian: Endian) -> Result<Vec<u8>, BadWord> {
    let mut bytes = with_scalar!(scalar, S => {
        let stored: Vec<S> = numbers(text, <S as Scalar>::parse)?;
        bytemuck::cast_slice::<S, u8>(&stored).to_vec()
    });
    if endian != Endian::NATIVE {
        bytes.chunks_exact_mut(scalar.bytes()).for_each(<[u8]>::reverse);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_bytes_of_their_type() {
        let of = |text: &str, scalar, endian| bytes(text.as_bytes(), scalar, endian).map_err(|e| (e.at, e.word));
        assert_eq!(of(" 1\n-2\t", ScalarType::I16, Endian::Big).unwrap(), [0, 1, 0xff, 0xfe]);
        assert_eq!(of("1 -2", ScalarType::I16, Endian::Little).unwrap(), [1, 0, 0xfe, 0xff]);
        assert_eq!(of("0.5", ScalarType::F32, Endian::Big).unwrap(), [0x3f, 0, 0, 0]);
        assert_eq!(of("1 256 3", ScalarType::U8, Endian::Big).unwrap_err(), (2, "256".to_owned()));
    }
}
