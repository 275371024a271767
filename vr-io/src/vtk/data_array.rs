//! The DataArray of VTK's XML: numbers as text, in base64, or appended at the end of the file; as they are, or in compressed blocks.

use std::ops::Range;

use roxmltree::Node;

use crate::decode::numbers_as_f64;
use crate::error::{FileErrorKind, shown};
use crate::scalar::ScalarType;

use super::coded::{Coded, CodedError, Compressor, read_range};
use super::words::{self, BadWord};
use super::xml::Store;

/// An array of which only the description has been read.
#[derive(Clone, Debug)]
pub(crate) struct DataArray {
    /// The name, fit for a line.
    pub name: String,
    pub scalar: ScalarType,
    /// Numbers per point or cell.
    pub components: usize,
    form: Form,
}

#[derive(Clone, Debug)]
enum Form {
    /// Places of words in the file.
    Ascii(Vec<Range<u64>>),
    /// Place of digits in the file.
    Base64(Range<u64>),
    /// Offset in the appended data.
    Appended(u64),
}

/// The arrays of numbers in a section of a piece, such as PointData, by their names.
pub(crate) fn named_arrays<'d, 't>(section: Node<'d, 't>) -> impl Iterator<Item = (String, Node<'d, 't>)> {
    let is_number = |n: &Node<'_, '_>| n.has_tag_name("DataArray") && n.attribute("type") != Some("String");
    section.children().filter(is_number).map(|n| (shown(n.attribute("Name").unwrap_or_default()), n))
}

impl DataArray {
    /// Reads the description of an array.
    pub fn new(node: Node<'_, '_>) -> Result<Self, FileErrorKind> {
        let name = shown(node.attribute("Name").unwrap_or("Points"));
        let wrong = |attribute: &str, found: &str, allowed: &str| {
            FileErrorKind::field(format!("array {name}, {attribute}"), found, allowed)
        };
        let scalar = node.attribute("type").unwrap_or_default();
        // Float32, UInt8, …
        let known = ScalarType::from_name(&scalar.to_ascii_lowercase())
            .filter(|_| scalar.ends_with(|c: char| c.is_ascii_digit()));
        let scalar = known.ok_or_else(|| wrong("type", scalar, "must be Int8 to UInt64, Float32 or Float64"))?;
        let components = components(node).ok_or_else(|| {
            let found = node.attribute("NumberOfComponents").unwrap_or_default();
            wrong("NumberOfComponents", found, "must be a whole number")
        })?;
        // Text between elements that say more about the array is blank.
        let texts = node.children().filter(|n| n.is_text() && n.text().is_some_and(|t| !t.trim_ascii().is_empty()));
        let places = texts.map(|n| {
            let (range, text) = (n.range(), &n.document().input_text()[n.range()]);
            let blank = text.len() - text.trim_ascii_start().len();
            let start = (range.start + blank) as u64;
            start..start + text.trim_ascii().len() as u64
        });
        let form = match node.attribute("format") {
            None | Some("ascii") => Form::Ascii(places.collect()),
            Some("binary") => Form::Base64({ places }.next().unwrap_or_default()),
            Some("appended") => {
                let offset = node.attribute("offset").unwrap_or_default();
                let parsed = offset.trim().parse().map_err(|_| wrong("offset", offset, "must be a whole number"));
                Form::Appended(parsed?)
            }
            Some(other) => return Err(wrong("format", other, "must be ascii, binary or appended")),
        };
        Ok(Self { name, scalar, components, form })
    }

    /// The encoding in a word: `ascii`, `base64`, `raw`, `zlib`, `lz4` or `lzma`.
    pub fn encoding(&self, store: &Store) -> &'static str {
        match (&self.form, store.compressor) {
            (Form::Ascii(_), _) => "ascii",
            (_, Some(Compressor::Zlib)) => "zlib",
            (_, Some(Compressor::Lz4)) => "lz4",
            (_, Some(Compressor::Lzma)) => "lzma",
            (Form::Appended(_), None) if !store.appended.base64 => "raw",
            _ => "base64",
        }
    }

    /// All its numbers, of which there must be `count`.
    pub fn numbers(&self, count: usize, store: &Store) -> Result<Vec<f64>, FileErrorKind> {
        match &self.form {
            Form::Ascii(places) => {
                let text = self.text(places, store)?;
                let numbers = words::numbers(&text, |word| word.parse().ok()).map_err(|e| self.bad_word(&e))?;
                self.counted(numbers.len(), count)?;
                Ok(numbers)
            }
            _ => Ok(numbers_as_f64(&self.bytes(count, store)?, self.scalar, store.endian)),
        }
    }

    /// The bytes of all its numbers, of which there must be `count`, in the byte order of the file.
    pub fn bytes(&self, count: usize, store: &Store) -> Result<Vec<u8>, FileErrorKind> {
        if let Form::Ascii(places) = &self.form {
            let text = self.text(places, store)?;
            let bytes = words::bytes(&text, self.scalar, store.endian).map_err(|e| self.bad_word(&e))?;
            self.counted(bytes.len() / self.scalar.bytes(), count)?;
            return Ok(bytes);
        }
        let (mut coded, length) = (self.coded(store)?, self.length(count)?);
        let bytes = match store.compressor {
            None => coded.plain(length, store.sizes),
            Some(compressor) => coded.unpacked(length, store.sizes, compressor),
        };
        bytes.map_err(|e| self.damaged(e))
    }

    /// Place of the numbers in the file, `count` of them, where they are there as they are.
    pub fn place_in_file(&self, count: usize, store: &Store) -> Result<Option<u64>, FileErrorKind> {
        match self.form {
            Form::Appended(_) if store.compressor.is_none() && !store.appended.base64 => {
                let place = self.coded(store)?.place_of_plain(self.length(count)?, store.sizes);
                place.map(Some).map_err(|e| self.damaged(e))
            }
            _ => Ok(None),
        }
    }

    fn coded(&self, store: &Store) -> Result<Coded, FileErrorKind> {
        let (at, base64) = match &self.form {
            Form::Ascii(_) => (0..0, false),
            Form::Base64(at) => (at.clone(), true),
            Form::Appended(offset) => {
                let Range { start, end } = store.appended.at;
                let from = start.checked_add(*offset).filter(|&from| from < end).ok_or_else(|| {
                    let allowed = format!("must be within the {} bytes of AppendedData", end - start);
                    FileErrorKind::field(format!("array {}, offset", self.name), offset, allowed)
                })?;
                (from..end, store.appended.base64)
            }
        };
        Ok(Coded::open(&store.path, at, base64)?)
    }

    fn text(&self, places: &[Range<u64>], store: &Store) -> Result<Vec<u8>, FileErrorKind> {
        let mut text = Vec::new();
        for at in places {
            text.extend(read_range(&store.path, at)?);
            text.push(b' ');
        }
        Ok(text)
    }

    fn length(&self, count: usize) -> Result<u64, FileErrorKind> {
        let length = (count as u64).checked_mul(self.scalar.bytes() as u64);
        length.ok_or_else(|| self.wrong(format!("{count} numbers"), "must be fewer"))
    }

    fn counted(&self, found: usize, count: usize) -> Result<(), FileErrorKind> {
        if found == count {
            return Ok(());
        }
        Err(self.wrong(format!("{found} numbers"), format!("the sizes of its piece need {count}")))
    }

    fn bad_word(&self, bad: &BadWord) -> FileErrorKind {
        self.wrong(&bad.word, format!("must be a number of type {}", self.scalar))
    }

    fn damaged(&self, error: CodedError) -> FileErrorKind {
        match error {
            CodedError::Io(e) => e.into(),
            CodedError::Wrong(found, allowed) => self.wrong(found, allowed),
        }
    }

    fn wrong(&self, found: impl std::fmt::Display, allowed: impl Into<String>) -> FileErrorKind {
        FileErrorKind::field(format!("array {}", self.name), found, allowed)
    }
}

/// Numbers per point or cell; `None` where the file does not tell it in digits.
fn components(node: Node<'_, '_>) -> Option<usize> {
    match node.attribute("NumberOfComponents").map(str::trim) {
        None | Some("" | "0") => Some(1),
        Some(text) => text.parse().ok(),
    }
}
