//! Lines and numbers of a legacy VTK file, one after the other.

use std::ops::Range;

use crate::error::{FileErrorKind, shown};
use crate::points::numbers;
use crate::scalar::{Endian, ScalarType};

/// Numbers in the file, not looked at yet.
pub(super) struct Array {
    pub name: String,
    pub scalar: ScalarType,
    pub numbers: usize,
    at: Range<usize>,
}

/// A place in the file.
#[derive(Clone, Copy)]
pub(super) struct Scan<'a> {
    bytes: &'a [u8],
    pub at: usize,
    pub binary: bool,
}

impl<'a> Scan<'a> {
    /// The begin of a file, which is text until it says otherwise.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, binary: false }
    }

    /// The next line that is not empty, without blanks around it.
    pub fn line(&mut self) -> Option<String> {
        while self.at < self.bytes.len() {
            let rest = &self.bytes[self.at..];
            let end = rest.iter().position(|&c| c == b'\n').unwrap_or(rest.len());
            self.at = (self.at + end + 1).min(self.bytes.len());
            let line = rest[..end].trim_ascii();
            if !line.is_empty() {
                return Some(String::from_utf8_lossy(line).into_owned());
            }
        }
        None
    }

    /// Place of that line: its number in text, the byte after it in binary files.
    pub fn place(&self) -> String {
        if self.binary {
            format!("byte {}", self.at)
        } else {
            format!("line {}", self.line_of(self.at.saturating_sub(1)))
        }
    }

    fn line_of(&self, at: usize) -> usize {
        1 + self.bytes[..at].iter().filter(|&&c| c == b'\n').count()
    }

    pub fn skip_paragraph(&mut self) {
        while let Some(end) = self.bytes[self.at..].iter().position(|&c| c == b'\n') {
            let line = &self.bytes[self.at..self.at + end];
            self.at += end + 1;
            if line.trim_ascii().is_empty() {
                return;
            }
        }
        self.at = self.bytes.len();
    }

    /// Passes over the numbers of an array, which must all be there.
    pub fn array(&mut self, name: &str, scalar: &str, numbers: usize) -> Result<Array, FileErrorKind> {
        let packed = scalar.eq_ignore_ascii_case("bit");
        let scalar = type_of(scalar).ok_or_else(|| {
            FileErrorKind::field(
                self.place(),
                scalar,
                "must be a type of numbers, like float, double, int or vtktypeint64",
            )
        })?;
        let begin = self.at;
        let end = if self.binary {
            let length = if packed { Some(numbers.div_ceil(8)) } else { numbers.checked_mul(scalar.bytes()) };
            length.and_then(|length| begin.checked_add(length)).filter(|&end| end <= self.bytes.len())
        } else {
            self.after_words(numbers)
        };
        let short = || {
            let found = format!("{} bytes left", self.bytes.len() - begin);
            FileErrorKind::field(
                format!("array {}", shown(name)),
                found,
                format!("{numbers} numbers of {scalar} are to follow"),
            )
        };
        self.at = end.ok_or_else(short)?;
        Ok(Array { name: shown(&unescaped(name)), scalar, numbers, at: begin..self.at })
    }

    /// End of the next `count` words.
    fn after_words(&self, count: usize) -> Option<usize> {
        let mut at = self.at;
        for _ in 0..count {
            at += self.bytes[at..].iter().position(|c| !c.is_ascii_whitespace())?;
            at += self.bytes[at..].iter().position(u8::is_ascii_whitespace).unwrap_or(self.bytes.len() - at);
        }
        Some(at)
    }

    pub fn numbers(&self, array: &Array) -> Result<Vec<f64>, FileErrorKind> {
        let bytes = &self.bytes[array.at.clone()];
        if self.binary {
            return Ok(numbers::numbers(bytes, array.scalar, Endian::Big));
        }
        let words = bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let number = |word: &[u8]| str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        words
            .map(|word| {
                number(word).ok_or_else(|| {
                    let at = array.at.start + word.as_ptr().addr() - bytes.as_ptr().addr();
                    let place = format!("line {}, array {}", self.line_of(at), array.name);
                    FileErrorKind::field(place, String::from_utf8_lossy(word), "must be a number")
                })
            })
            .collect()
    }
}

/// The type of a name; of bits, that of the bytes that hold them.
fn type_of(name: &str) -> Option<ScalarType> {
    Some(match name.to_ascii_lowercase().as_str() {
        "bit" | "unsigned_char" => ScalarType::U8,
        "char" | "signed_char" => ScalarType::I8,
        "unsigned_short" => ScalarType::U16,
        "short" => ScalarType::I16,
        "unsigned_int" => ScalarType::U32,
        // What VTK calls an id, it writes as an int.
        "int" | "vtkidtype" => ScalarType::I32,
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => ScalarType::U64,
        "long" | "long_long" | "vtktypeint64" => ScalarType::I64,
        "float" => ScalarType::F32,
        "double" => ScalarType::F64,
        _ => return None,
    })
}

/// A name as people know it: in the file, blanks and others are written as `%20`.
fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name;
    while let Some((before, after)) = rest.split_once('%') {
        bytes.extend_from_slice(before.as_bytes());
        match after.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(b'%');
                rest = after;
            }
        }
    }
    bytes.extend_from_slice(rest.as_bytes());
    String::from_utf8_lossy(&bytes).into_owned()
}
