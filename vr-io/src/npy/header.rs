//! The line before the numbers of a `.npy` file: a dictionary of Python, of which three entries matter.

use crate::error::FileErrorKind;
use crate::scalar::{Endian, ScalarType};

const MAGIC: &[u8] = b"\x93NUMPY";

/// True if the beginning of a file is that of NumPy's format.
pub(crate) fn is_npy(head: &[u8]) -> bool {
    head.starts_with(MAGIC)
}

/// Entries of the dictionary.
#[derive(Debug)]
pub(crate) struct Header {
    /// Type of the numbers.
    pub element: Element,
    pub endian: Endian,
    /// True if the first index of the shape runs fastest, not the last.
    pub by_column: bool,
    pub shape: Vec<u64>,
    /// Bytes up to the numbers.
    pub length: usize,
}

/// Type of the numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Element {
    Number(ScalarType),
    /// 16-bit floats.
    Half,
}

impl Header {
    /// Reads the header from the first bytes of a file.
    pub fn parse(bytes: &[u8]) -> Result<Self, FileErrorKind> {
        let cut = || FileErrorKind::field("header", format!("{} bytes", bytes.len()), "the header must be whole");
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| {
            let found = String::from_utf8_lossy(&bytes[..bytes.len().min(MAGIC.len())]).into_owned();
            FileErrorKind::field("magic", found, "must be \\x93NUMPY")
        })?;
        let (version, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
        let (length, rest) = match version[0] {
            1 => rest.split_first_chunk().map(|(n, rest)| (usize::from(u16::from_le_bytes(*n)), rest)),
            2 | 3 => rest.split_first_chunk().map(|(n, rest)| (u32::from_le_bytes(*n) as usize, rest)),
            other => return Err(FileErrorKind::field("version", other, "must be 1, 2 or 3")),
        }
        .ok_or_else(cut)?;
        let before = bytes.len() - rest.len();
        let text = String::from_utf8_lossy(rest.get(..length).ok_or_else(cut)?);

        let (element, endian) = element(entry(&text, "descr")?)?;
        let by_column = match entry(&text, "fortran_order")? {
            "True" => true,
            "False" => false,
            other => return Err(FileErrorKind::field("fortran_order", other, "must be True or False")),
        };
        let shape = entry(&text, "shape")?;
        let sizes: Option<Vec<u64>> =
            shape.split(',').map(str::trim).filter(|n| !n.is_empty()).map(|n| n.parse().ok()).collect();
        let shape = sizes.ok_or_else(|| FileErrorKind::field("shape", shape, "must be sizes of 64 bits"))?;
        Ok(Self { element, endian, by_column, shape, length: before + length })
    }

    /// The shape as Python writes it, without brackets.
    pub fn shape_text(&self) -> String {
        self.shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
    }
}

/// Value of a key of the header's dictionary: a word, or the text in quotes or brackets.
fn entry<'h>(header: &'h str, key: &str) -> Result<&'h str, FileErrorKind> {
    let missing =
        || FileErrorKind::field(key, header.trim(), "the header must hold 'descr', 'fortran_order' and 'shape'");
    let (_, after) = header.split_once(&format!("'{key}'")).ok_or_else(missing)?;
    let value = after.trim_start().strip_prefix(':').ok_or_else(missing)?.trim_start();
    let end = |value: &'h str, stop: &[char]| value.find(stop).map(|end| &value[..end]);
    match value.chars().next() {
        Some('\'') => end(&value[1..], &['\'']),
        Some('(') => end(&value[1..], &[')']),
        _ => end(value, &[',', '}']).map(str::trim_end),
    }
    .ok_or_else(missing)
}

/// `<f4`.
fn element(descr: &str) -> Result<(Element, Endian), FileErrorKind> {
    let endian = match descr.chars().next() {
        Some('>') => Endian::Big,
        Some('<' | '|') => Endian::Little,
        _ => Endian::NATIVE,
    };
    let scalar = match descr.trim_start_matches(['<', '>', '|', '=']) {
        "f2" => return Ok((Element::Half, endian)),
        "f4" => ScalarType::F32,
        "f8" => ScalarType::F64,
        "i1" => ScalarType::I8,
        // Truth values are bytes, 0 or 1.
        "u1" | "b1" => ScalarType::U8,
        "i2" => ScalarType::I16,
        "u2" => ScalarType::U16,
        "i4" => ScalarType::I32,
        "u4" => ScalarType::U32,
        "i8" => ScalarType::I64,
        "u8" => ScalarType::U64,
        _ => return Err(FileErrorKind::field("descr", descr, "must be a real number type: b1, f2, f4, f8, i1 … u8")),
    };
    Ok((Element::Number(scalar), endian))
}
