//! Words that both kinds of files share: types, byte orders and encodings.

use crate::scalar::{Endian, ScalarType};

/// The type that words like `unsigned short` name.
pub(super) fn scalar_type<'w>(words: impl IntoIterator<Item = &'w str>) -> Option<ScalarType> {
    let words: Vec<String> = words.into_iter().map(str::to_lowercase).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    Some(match words.as_slice() {
        // A byte alone is unsigned; `char` is its old name.
        ["byte" | "char" | "ubyte"] | ["unsigned", "byte" | "char"] => ScalarType::U8,
        ["signed", "byte" | "char"] => ScalarType::I8,
        ["short"] | ["signed", "short"] => ScalarType::I16,
        ["ushort"] | ["unsigned", "short"] => ScalarType::U16,
        ["int"] | ["signed", "int"] => ScalarType::I32,
        ["uint"] | ["unsigned", "int"] => ScalarType::U32,
        ["hyper"] | ["signed", "hyper"] => ScalarType::I64,
        ["float"] => ScalarType::F32,
        ["double"] => ScalarType::F64,
        _ => return None,
    })
}

/// The types, as messages list them.
pub(super) const TYPES: &str = "must be byte, short or int, signed or unsigned, float or double";

/// Encoding of numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Form {
    pub binary: bool,
    /// Byte order, if it is named.
    pub endian: Option<Endian>,
}

impl Form {
    /// Changes the form as a word says; false for other words.
    pub fn set(&mut self, word: &str) -> bool {
        match word.to_lowercase().as_str() {
            "msb" => self.endian = Some(Endian::Big),
            "lsb" => self.endian = Some(Endian::Little),
            "binary" | "ieee" => self.binary = true,
            "ascii" | "text" => self.binary = false,
            _ => return false,
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_of_types() {
        let of = |words: &str| scalar_type(words.split_whitespace());
        assert_eq!(of("byte"), Some(ScalarType::U8));
        assert_eq!(of("signed byte"), Some(ScalarType::I8));
        assert_eq!(of("short"), Some(ScalarType::I16));
        assert_eq!(of("Unsigned Short"), Some(ScalarType::U16));
        assert_eq!(of("unsigned float"), None);
        assert_eq!(of("string"), None);
    }
}
