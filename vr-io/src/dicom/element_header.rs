//! Headers of elements and of items: tag, type and length (DICOM PS3.5 2024, sections 7.1 and 7.5).

use std::io::{self, Read};

use super::tags::{self, Tag};
use crate::scalar::Endian;

/// Group of items and of the delimiters that end them.
const ITEMS: u16 = 0xfffe;
/// Length that is not told: a delimiter ends the value.
const UNDEFINED: u32 = u32::MAX;
/// Types with a length of 16 bits (7.1.2).
const SHORT: [&[u8; 2]; 21] = [
    b"AE", b"AS", b"AT", b"CS", b"DA", b"DS", b"DT", b"FD", b"FL", b"IS", b"LO", b"LT", b"PN", b"SH", b"SL", b"SS",
    b"ST", b"TM", b"UI", b"UL", b"US",
];
/// Types with two reserved bytes and a length of 32 bits.
const LONG: [&[u8; 2]; 12] = [b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UR", b"UT", b"UV"];

/// Coding of elements' headers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Headers {
    /// Little endian, types from the dictionary.
    Implicit,
    /// Little endian with types.
    Explicit,
    /// Big endian with types; retired in 2006.
    ExplicitBig,
}

/// Type of a value (value representation), as far as it matters here: kept values are read by their tags.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueType {
    /// SQ: items, each of them a data set.
    Sequence,
    /// OW: words of 16 bits.
    Words,
    /// UN, and types that the standard does not have.
    Unknown,
    Other,
}

/// Header of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ElementHeader {
    pub tag: Tag,
    pub value_type: ValueType,
    /// Bytes of the value; `None` where a delimiter ends it.
    pub length: Option<u32>,
    /// Bytes of the header itself.
    pub size: u64,
}

/// Header of an item of a sequence, or what ends one of them; of eight bytes in every coding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ItemHeader {
    /// An item of that many bytes; `None` where a delimiter ends it.
    Item(Option<u32>),
    ItemEnd,
    SequenceEnd,
    /// Something that does not belong into a sequence.
    NoItem,
}

impl Headers {
    /// Byte order of headers and numbers.
    pub fn endian(self) -> Endian {
        if self == Self::ExplicitBig { Endian::Big } else { Endian::Little }
    }

    /// Reads the header of an element, or a delimiter as if it were one.
    pub fn element(self, source: &mut (impl Read + ?Sized)) -> io::Result<ElementHeader> {
        let [group, element, a, b] = self.words(source)?;
        let tag = Tag(group, element);
        let header = |value_type, length, size| ElementHeader {
            tag,
            value_type,
            length: (length != UNDEFINED).then_some(length),
            size,
        };
        if group == ITEMS {
            return Ok(header(ValueType::Unknown, self.long(a, b), 8));
        }
        if self == Self::Implicit {
            let value_type = match tag {
                tags::PIXEL_DATA => ValueType::Words,
                _ if tag.is_sequence() => ValueType::Sequence,
                _ => ValueType::Unknown,
            };
            return Ok(header(value_type, self.long(a, b), 8));
        }
        let letters = if self == Self::ExplicitBig { a.to_be_bytes() } else { a.to_le_bytes() };
        if SHORT.contains(&&letters) {
            return Ok(header(ValueType::Other, b.into(), 8));
        }
        let value_type = match &letters {
            b"SQ" => ValueType::Sequence,
            b"OW" => ValueType::Words,
            other if LONG.contains(&other) => ValueType::Other,
            _ => ValueType::Unknown,
        };
        let [a, b] = self.words(source)?;
        Ok(header(value_type, self.long(a, b), 12))
    }

    /// Reads the header of an item, or a delimiter.
    pub fn item(self, source: &mut (impl Read + ?Sized)) -> io::Result<ItemHeader> {
        let [group, element, a, b] = self.words(source)?;
        let length = self.long(a, b);
        Ok(match (Tag(group, element), length) {
            (tags::ITEM, _) => ItemHeader::Item((length != UNDEFINED).then_some(length)),
            (tags::ITEM_END, 0) => ItemHeader::ItemEnd,
            (tags::SEQUENCE_END, _) => ItemHeader::SequenceEnd,
            _ => ItemHeader::NoItem,
        })
    }

    /// Reads numbers of 16 bits.
    fn words<const N: usize>(self, source: &mut (impl Read + ?Sized)) -> io::Result<[u16; N]> {
        let mut bytes = [[0; 2]; N];
        source.read_exact(bytes.as_flattened_mut())?;
        Ok(bytes.map(if self == Self::ExplicitBig { u16::from_be_bytes } else { u16::from_le_bytes }))
    }

    /// Joins the two words of a number of 32 bits.
    fn long(self, first: u16, second: u16) -> u32 {
        let (high, low) = if self == Self::ExplicitBig { (first, second) } else { (second, first) };
        u32::from(high) << 16 | u32::from(low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(headers: Headers, mut bytes: &[u8]) -> ElementHeader {
        let header = headers.element(&mut bytes).unwrap();
        assert!(bytes.is_empty(), "{bytes:?}");
        header
    }

    fn header(tag: Tag, value_type: ValueType, length: Option<u32>, size: u64) -> ElementHeader {
        ElementHeader { tag, value_type, length, size }
    }

    #[test]
    fn headers_of_every_form() {
        use ValueType::{Other, Sequence, Unknown, Words};
        let (little, big) = (Headers::Explicit, Headers::ExplicitBig);
        assert_eq!(element(little, b"\x28\0\x10\0US\x02\x01"), header(tags::ROWS, Other, Some(0x102), 8));
        assert_eq!(element(big, b"\0\x28\0\x10US\x01\x02"), header(tags::ROWS, Other, Some(0x102), 8));
        // A length of 16 bits is never undefined.
        assert_eq!(element(little, b"\x28\0\x10\0US\xff\xff"), header(tags::ROWS, Other, Some(0xffff), 8));
        let pixels = b"\xe0\x7f\x10\0OW\0\0\x04\x03\x02\x01";
        assert_eq!(element(little, pixels), header(tags::PIXEL_DATA, Words, Some(0x1020304), 12));
        let pixels = b"\x7f\xe0\0\x10OB\0\0\x01\x02\x03\x04";
        assert_eq!(element(big, pixels), header(tags::PIXEL_DATA, Other, Some(0x1020304), 12));
        let groups = b"\0\x52\x30\x92SQ\0\0\xff\xff\xff\xff";
        assert_eq!(element(little, groups), header(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, Sequence, None, 12));
        for unknown in [b"UN", b"ZZ", b"\xff\xfe"] {
            let bytes = [&b"\x09\0\x10\x10"[..], unknown, b"\0\0\x08\0\0\0"].concat();
            assert_eq!(element(little, &bytes), header(Tag(9, 0x1010), Unknown, Some(8), 12));
        }
        let implicit = Headers::Implicit;
        assert_eq!(element(implicit, b"\x28\0\x10\0\x02\0\0\0"), header(tags::ROWS, Unknown, Some(2), 8));
        assert_eq!(element(implicit, b"\xe0\x7f\x10\0\x02\0\0\0"), header(tags::PIXEL_DATA, Words, Some(2), 8));
        let groups = header(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, Sequence, Some(4), 8);
        assert_eq!(element(implicit, b"\0\x52\x30\x92\x04\0\0\0"), groups);
        for headers in [little, implicit] {
            assert_eq!(element(headers, b"\xfe\xff\x0d\xe0\0\0\0\0"), header(tags::ITEM_END, Unknown, Some(0), 8));
        }
    }

    #[test]
    fn items_and_their_ends() {
        let item = |headers: Headers, mut bytes: &[u8]| headers.item(&mut bytes).unwrap();
        assert_eq!(item(Headers::Explicit, b"\xfe\xff\0\xe0\x04\0\0\0"), ItemHeader::Item(Some(4)));
        assert_eq!(item(Headers::ExplicitBig, b"\xff\xfe\xe0\0\0\0\0\x04"), ItemHeader::Item(Some(4)));
        assert_eq!(item(Headers::Implicit, b"\xfe\xff\0\xe0\xff\xff\xff\xff"), ItemHeader::Item(None));
        assert_eq!(item(Headers::Implicit, b"\xfe\xff\x0d\xe0\0\0\0\0"), ItemHeader::ItemEnd);
        assert_eq!(item(Headers::Implicit, b"\xfe\xff\x0d\xe0\x01\0\0\0"), ItemHeader::NoItem);
        assert_eq!(item(Headers::Implicit, b"\xfe\xff\xdd\xe0\0\0\0\0"), ItemHeader::SequenceEnd);
        assert_eq!(item(Headers::Implicit, b"\x28\0\x10\0\x02\0\0\0"), ItemHeader::NoItem);
        assert!(Headers::Explicit.item(&mut &b"\xfe\xff\0\xe0\x04\0\0"[..]).is_err());
    }
}
