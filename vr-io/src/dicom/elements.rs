//! The data set of a file: elements of tag, length and value, some of them sequences of further data sets (DICOM PS3.5 2024, section 7).
//!
//! Lengths are held against the end of what encloses them before anything is allocated, nesting has a bound, and values that are not needed
//! (the patient's among them) are passed over unread.

use std::borrow::Cow;
use std::io::{self, BufReader, Read};

use super::element_header::{ElementHeader, Headers, ItemHeader, ValueType};
use super::tags::{self, Tag};
use crate::error::{FieldError, FileErrorKind};
use crate::regular_file::RegularFile;

/// Sequences within sequences; real files have four.
const MAX_DEPTH: usize = 32;
/// Bytes of a value that is kept: more than 40,000 numbers in text.
const MAX_VALUE: u64 = 1 << 20;

/// Elements of a data set, in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Elements {
    big_endian: bool,
    list: Vec<(Tag, Value)>,
}

#[derive(Debug)]
enum Value {
    Bytes(Vec<u8>),
    Items(Vec<Elements>),
}

impl Elements {
    fn bytes(&self, tag: Tag) -> Option<&[u8]> {
        self.list.iter().find_map(|(t, value)| match value {
            Value::Bytes(bytes) if *t == tag && !bytes.is_empty() => Some(bytes.as_slice()),
            _ => None,
        })
    }

    /// Data sets of a sequence; none where it is absent.
    pub fn items(&self, tag: Tag) -> &[Elements] {
        self.list
            .iter()
            .find_map(|(t, value)| match value {
                Value::Items(items) if *t == tag => Some(items.as_slice()),
                _ => None,
            })
            .unwrap_or_default()
    }

    /// Text without its padding; `None` where it is absent or empty.
    pub fn text(&self, tag: Tag) -> Option<Cow<'_, str>> {
        let bytes = self.bytes(tag)?.trim_ascii();
        let end = bytes.iter().rposition(|&c| c != 0 && c != b' ')? + 1;
        Some(String::from_utf8_lossy(&bytes[..end]))
    }

    /// Numbers in text (types DS and IS), of which there must be `count`, or any number where that is `None`.
    pub fn numbers(&self, tag: Tag, count: Option<usize>) -> Result<Option<Vec<f64>>, FieldError> {
        let Some(text) = self.text(tag) else { return Ok(None) };
        let numbers: Option<Vec<f64>> =
            text.split('\\').map(|w| w.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let wrong = || match count {
            Some(1) => FieldError::new(tag.name(), &text, "must be a finite number"),
            Some(n) => FieldError::new(tag.name(), &text, format!("must be {n} finite numbers")),
            None => FieldError::new(tag.name(), &text, "must be finite numbers"),
        };
        numbers.filter(|n| count.is_none_or(|c| c == n.len())).map(Some).ok_or_else(wrong)
    }

    /// First of the numbers in a text.
    pub fn number(&self, tag: Tag) -> Result<Option<f64>, FieldError> {
        Ok(self.numbers(tag, None)?.and_then(|n| n.first().copied()))
    }

    /// Integer in text (type IS).
    pub fn integer(&self, tag: Tag) -> Result<Option<i64>, FieldError> {
        let Some(text) = self.text(tag) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| FieldError::new(tag.name(), &text, "must be an integer"))
    }

    /// Unsigned 16-bit integer.
    pub fn u16(&self, tag: Tag) -> Result<Option<u16>, FieldError> {
        let Some(bytes) = self.bytes(tag) else { return Ok(None) };
        match bytes.first_chunk() {
            Some(b) => Ok(Some(if self.big_endian { u16::from_be_bytes(*b) } else { u16::from_le_bytes(*b) })),
            None => {
                Err(FieldError::new(tag.name(), format_args!("{} byte", bytes.len()), "must be an integer of 16 bits"))
            }
        }
    }

    /// First unsigned 32-bit integer; `None` where it is absent or too short.
    pub fn u32(&self, tag: Tag) -> Option<u32> {
        let bytes = self.bytes(tag)?.first_chunk()?;
        Some(if self.big_endian { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) })
    }

    /// True if an overlay lies in the bits of the voxels that these do not use.
    pub fn has_overlay_in_voxels(&self) -> bool {
        let placed = self.list.iter().map(|&(tag, _)| tag).filter(|&tag| tag.is_overlay_position());
        placed.into_iter().any(|tag| self.u16(tag).is_ok_and(|bit| bit.unwrap_or(0) > 0))
    }

    pub fn has(&self, tag: Tag) -> bool {
        self.list.iter().any(|&(t, _)| t == tag)
    }
}

/// The element that holds the voxels; its value is not read here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelElement {
    pub tag: Tag,
    /// True for numbers in words of 16 bits (type OW).
    pub words: bool,
    /// Offset of the value in the stream of the data set: the file, or what a deflated one inflates to.
    pub offset: u64,
    /// Bytes of the value; `None` for encapsulated frames.
    pub length: Option<u32>,
}

/// Something that can be read, and passed over faster than read.
pub(super) trait Skip: Read {
    fn skip(&mut self, bytes: u64) -> io::Result<()>;
}

impl Skip for &mut BufReader<RegularFile> {
    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        (**self).skip(bytes)
    }
}

impl Skip for BufReader<RegularFile> {
    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        self.seek_relative(i64::try_from(bytes).map_err(io::Error::other)?)
    }
}

/// Reader without `Seek`: it skips by reading.
pub(super) struct Forward<R>(pub R);

impl<R: Read> Read for Forward<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.0.read(out)
    }
}

impl<R: Read> Skip for Forward<R> {
    fn skip(&mut self, bytes: u64) -> io::Result<()> {
        match io::copy(&mut self.0.by_ref().take(bytes), &mut io::sink())? {
            n if n == bytes => Ok(()),
            _ => Err(io::ErrorKind::UnexpectedEof.into()),
        }
    }
}

/// End of a data set.
#[derive(Clone, Copy)]
enum End {
    /// At this position.
    At(u64),
    /// At an item delimiter, and before this position.
    Delimiter(u64),
}

impl End {
    fn bound(self) -> u64 {
        match self {
            Self::At(end) | Self::Delimiter(end) => end,
        }
    }
}

/// Reader of a data set.
pub(super) struct DataSetReader<R> {
    source: R,
    position: u64,
}

impl<R: Skip> DataSetReader<R> {
    /// Starts at a position of the stream.
    pub fn new(source: R, position: u64) -> Self {
        Self { source, position }
    }

    pub fn position(&self) -> u64 {
        self.position
    }

    /// Reads one element, which is no sequence.
    pub fn read_one(&mut self, headers: Headers, end: u64) -> Result<Elements, FileErrorKind> {
        let at = self.position;
        let ElementHeader { tag, length, size, .. } = headers.element(&mut self.source).map_err(|_| cut_off(at))?;
        self.position += size;
        let length = length.map(u64::from).filter(|length| self.position + length <= end);
        let length = length.ok_or_else(|| cut_off(at))?;
        let mut elements = Elements::default();
        if tag.is_kept() {
            elements.list.push((tag, Value::Bytes(self.value(tag, length)?)));
        } else {
            self.skip(length)?;
        }
        Ok(elements)
    }

    /// Reads the elements up to `end`, or up to the one with the voxels.
    pub fn read(&mut self, headers: Headers, end: u64) -> Result<(Elements, Option<PixelElement>), FileErrorKind> {
        self.data_set(headers, End::At(end), true, 0)
    }

    fn data_set(
        &mut self,
        headers: Headers,
        end: End,
        keep: bool,
        depth: usize,
    ) -> Result<(Elements, Option<PixelElement>), FileErrorKind> {
        if depth > MAX_DEPTH {
            let allowed = format!("must be at most {MAX_DEPTH} deep");
            return Err(FileErrorKind::field("nested sequences", format_args!("{depth} levels"), allowed));
        }
        let mut elements = Elements { big_endian: headers == Headers::ExplicitBig, list: Vec::new() };
        while self.position < end.bound() {
            let at = self.position;
            let ElementHeader { tag, value_type, length, size } =
                headers.element(&mut self.source).map_err(|_| cut_off(at))?;
            self.position += size;
            if tag == tags::ITEM_END && matches!(end, End::Delimiter(_)) {
                return Ok((elements, None));
            }
            if tag.0 == tags::ITEM.0 {
                return Err(FileErrorKind::field(
                    format!("byte {at}"),
                    format_args!("a delimiter {tag}"),
                    "must be an element of the data set",
                ));
            }
            let is_pixels = [tags::PIXEL_DATA, tags::FLOAT_PIXEL_DATA, tags::DOUBLE_FLOAT_PIXEL_DATA].contains(&tag);
            if depth == 0 && is_pixels {
                let words = value_type == ValueType::Words;
                let pixels = PixelElement { tag, words, offset: self.position, length };
                return Ok((elements, Some(pixels)));
            }
            let keep = keep && tag.is_kept();
            // Where a sequence is called unknown, its content is implicit (PS3.5, 6.2.2, note 2).
            let inner = if value_type == ValueType::Unknown { Headers::Implicit } else { headers };
            let Some(length) = length else {
                let items = self.sequence(tag, inner, None, end.bound(), keep, depth)?;
                if keep {
                    elements.list.push((tag, Value::Items(items)));
                }
                continue;
            };
            let value_end = self.position + u64::from(length);
            if value_end > end.bound() {
                let found = format_args!("a length of {length} bytes");
                let allowed = format!(
                    "only {} bytes are left there: the file is cut off or damaged",
                    end.bound().saturating_sub(self.position)
                );
                return Err(FileErrorKind::field(tag.name(), found, allowed));
            }
            if keep && value_type == ValueType::Sequence {
                let items = self.sequence(tag, inner, Some(value_end), value_end, true, depth)?;
                elements.list.push((tag, Value::Items(items)));
            } else if keep {
                elements.list.push((tag, Value::Bytes(self.value(tag, length.into())?)));
            } else {
                self.skip(length.into())?;
            }
        }
        match end {
            End::Delimiter(_) => Err(cut_off(self.position)),
            End::At(_) => Ok((elements, None)),
        }
    }

    /// Items up to `end`, or up to a delimiter where there is no end.
    fn sequence(
        &mut self,
        tag: Tag,
        headers: Headers,
        end: Option<u64>,
        bound: u64,
        keep: bool,
        depth: usize,
    ) -> Result<Vec<Elements>, FileErrorKind> {
        let mut items = Vec::new();
        while end.is_none_or(|end| self.position < end) {
            let at = self.position;
            let header = headers.item(&mut self.source).map_err(|_| cut_off(at))?;
            self.position += 8;
            if self.position > bound {
                return Err(cut_off(at));
            }
            match header {
                ItemHeader::SequenceEnd => break,
                ItemHeader::ItemEnd => {
                    return Err(FileErrorKind::field(tag.name(), "the end of an item", "must be an item, or the end"));
                }
                ItemHeader::NoItem => {
                    let allowed = "must be an item or the end of a sequence: the file is damaged";
                    return Err(FileErrorKind::field(format!("byte {at}"), "no item", allowed));
                }
                ItemHeader::Item(length) => {
                    let item_end = length.map(|length| self.position + u64::from(length));
                    if item_end.is_some_and(|end| end > bound) {
                        return Err(cut_off(at));
                    }
                    match item_end {
                        // Not needed, or a fragment of a picture.
                        Some(_) if !keep => self.skip(length.unwrap_or(0).into())?,
                        Some(item_end) => items.push(self.data_set(headers, End::At(item_end), keep, depth + 1)?.0),
                        None => {
                            let item = self.data_set(headers, End::Delimiter(bound), keep, depth + 1)?.0;
                            if keep {
                                items.push(item);
                            }
                        }
                    }
                }
            }
        }
        Ok(items)
    }

    fn value(&mut self, tag: Tag, length: u64) -> Result<Vec<u8>, FileErrorKind> {
        if length > MAX_VALUE {
            let allowed = format!("must be at most {MAX_VALUE} bytes");
            return Err(FileErrorKind::field(tag.name(), format_args!("{length} bytes"), allowed));
        }
        let mut bytes = Vec::new();
        self.source.by_ref().take(length).read_to_end(&mut bytes)?;
        self.position += length;
        if (bytes.len() as u64) < length { Err(cut_off(self.position)) } else { Ok(bytes) }
    }

    fn skip(&mut self, bytes: u64) -> Result<(), FileErrorKind> {
        self.source.skip(bytes).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => cut_off(self.position),
            _ => e.into(),
        })?;
        self.position += bytes;
        Ok(())
    }
}

fn cut_off(at: u64) -> FileErrorKind {
    FileErrorKind::field("data set", format_args!("its end at byte {at}"), "the file is cut off or damaged there")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dicom::sample::{element, item, sequence_of_unknown_length};

    fn read(bytes: &[u8]) -> Result<(Elements, Option<PixelElement>), FileErrorKind> {
        DataSetReader::new(Forward(bytes), 0).read(Headers::Explicit, bytes.len() as u64)
    }

    #[test]
    fn stops_at_the_voxels_and_knows_where_they_are() {
        let mut bytes = element(tags::PATIENT_NAME, b"PN", b"Nobody");
        bytes.extend(element(tags::ROWS, b"US", &7u16.to_le_bytes()));
        bytes.extend(element(tags::PIXEL_DATA, b"OW", &[1, 2, 3, 4]));
        let (elements, pixels) = read(&bytes).unwrap();
        assert_eq!(elements.u16(tags::ROWS), Ok(Some(7)));
        assert!(!elements.has(tags::PATIENT_NAME));
        let pixels = pixels.unwrap();
        assert_eq!((pixels.offset, pixels.length, pixels.words), (bytes.len() as u64 - 4, Some(4), true));
    }

    #[test]
    fn enters_sequences_of_both_kinds_and_skips_the_others() {
        let spacing = element(tags::PIXEL_SPACING, b"DS", b"2\\3 ");
        let inner = element(tags::PIXEL_MEASURES_SEQUENCE, b"SQ", &item(&spacing));
        let mut bytes = sequence_of_unknown_length(tags::REFERENCED_IMAGE_SEQUENCE, &spacing);
        bytes.extend(sequence_of_unknown_length(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, &inner));
        let (elements, _) = read(&bytes).unwrap();
        assert!(!elements.has(tags::REFERENCED_IMAGE_SEQUENCE));
        let shared = &elements.items(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE)[0];
        let measures = &shared.items(tags::PIXEL_MEASURES_SEQUENCE)[0];
        assert_eq!(measures.numbers(tags::PIXEL_SPACING, Some(2)), Ok(Some(vec![2.0, 3.0])));
    }

    #[test]
    fn refuses_what_lies_about_lengths() {
        let mut claim = element(tags::SERIES_DESCRIPTION, b"UT", b"abc");
        claim[8..12].copy_from_slice(&0xffff_fff0u32.to_le_bytes());
        assert!(read(&claim).unwrap_err().to_string().contains("a length of 4294967280 bytes; only 4 bytes are left"));
        let bytes = sequence_of_unknown_length(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, &[]);
        for cut in 1..bytes.len() {
            assert!(read(&bytes[..cut]).is_err(), "{cut}");
        }
    }

    #[test]
    fn nesting_has_a_bound() {
        let opening = sequence_of_unknown_length(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, &[])[..20].repeat(100_000);
        let message = read(&opening).unwrap_err().to_string();
        assert!(message.contains("at most 32 deep"), "{message}");
    }
}
