//! Small files for tests, written by hand.

use super::tags::{self, Tag};

/// An element in explicit little endian, padded to an even length.
pub fn element(tag: Tag, vr: &[u8; 2], value: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(tag.0.to_le_bytes());
    bytes.extend(tag.1.to_le_bytes());
    bytes.extend(vr);
    let padded = value.len() + value.len() % 2;
    if matches!(vr, b"OB" | b"OW" | b"OF" | b"OD" | b"SQ" | b"UN" | b"UT") {
        bytes.extend([0, 0]);
        bytes.extend((padded as u32).to_le_bytes());
    } else {
        bytes.extend((padded as u16).to_le_bytes());
    }
    bytes.extend(value);
    bytes.resize(bytes.len() + padded - value.len(), if matches!(vr, b"UI" | b"OB") { 0 } else { b' ' });
    bytes
}

/// An item of known length.
pub fn item(content: &[u8]) -> Vec<u8> {
    [&[0xfe, 0xff, 0, 0xe0][..], &(content.len() as u32).to_le_bytes(), content].concat()
}

/// A sequence with one item, both of unknown length.
pub fn sequence_of_unknown_length(tag: Tag, content: &[u8]) -> Vec<u8> {
    let mut bytes = element(tag, b"SQ", b"");
    bytes[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    bytes.extend([0xfe, 0xff, 0, 0xe0, 0xff, 0xff, 0xff, 0xff]);
    bytes.extend(content);
    bytes.extend([0xfe, 0xff, 0x0d, 0xe0, 0, 0, 0, 0]);
    bytes.extend([0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]);
    bytes
}

/// Preamble and meta information.
pub fn meta(transfer_syntax: &str) -> Vec<u8> {
    let group = element(tags::TRANSFER_SYNTAX_UID, b"UI", transfer_syntax.as_bytes());
    let length = element(Tag(2, 0), b"UL", &(group.len() as u32).to_le_bytes());
    [&[0; 128][..], b"DICM", &length, &group].concat()
}

pub const EXPLICIT: &str = "1.2.840.10008.1.2.1";

/// A file of elements, later ones in place of earlier ones with their tag, and sorted.
pub struct Sample {
    pub transfer_syntax: String,
    elements: Vec<(Tag, [u8; 2], Vec<u8>)>,
}

impl Sample {
    /// An axial slice of 3 by 2 voxels of i16 at a height, with spacing 0.5 along rows and 0.75 down columns: `first`, `first` + 1, …
    pub fn slice(z: f64, first: i16) -> Self {
        let voxels: Vec<u8> = (first..first + 6).flat_map(i16::to_le_bytes).collect();
        Self { transfer_syntax: EXPLICIT.into(), elements: Vec::new() }
            .text(tags::MODALITY, "CT")
            .text(tags::SERIES_INSTANCE_UID, "1.2.3")
            .text(tags::SERIES_NUMBER, "7")
            .text(tags::PATIENT_NAME, "Secret^Person")
            .text(tags::IMAGE_POSITION_PATIENT, &format!("10\\20\\{z}"))
            .text(tags::IMAGE_ORIENTATION_PATIENT, "1\\0\\0\\0\\1\\0")
            .text(tags::PIXEL_SPACING, "0.75\\0.5")
            .short(tags::SAMPLES_PER_PIXEL, 1)
            .text(tags::PHOTOMETRIC_INTERPRETATION, "MONOCHROME2")
            .short(tags::ROWS, 2)
            .short(tags::COLUMNS, 3)
            .short(tags::BITS_ALLOCATED, 16)
            .short(tags::BITS_STORED, 16)
            .short(tags::HIGH_BIT, 15)
            .short(tags::PIXEL_REPRESENTATION, 1)
            .set(tags::PIXEL_DATA, b"OW", voxels)
    }

    pub fn set(mut self, tag: Tag, vr: &[u8; 2], value: Vec<u8>) -> Self {
        self.elements.retain(|(t, ..)| *t != tag);
        self.elements.push((tag, *vr, value));
        self
    }

    pub fn without(mut self, tag: Tag) -> Self {
        self.elements.retain(|(t, ..)| *t != tag);
        self
    }

    pub fn text(self, tag: Tag, text: &str) -> Self {
        let vr = match tag {
            tags::SERIES_INSTANCE_UID | tags::SOP_INSTANCE_UID => b"UI",
            tags::MODALITY | tags::PHOTOMETRIC_INTERPRETATION | tags::IMAGE_TYPE => b"CS",
            tags::PATIENT_NAME => b"PN",
            tags::SERIES_NUMBER | tags::NUMBER_OF_FRAMES | tags::INSTANCE_NUMBER => b"IS",
            _ => b"DS",
        };
        self.set(tag, vr, text.into())
    }

    pub fn short(self, tag: Tag, value: u16) -> Self {
        self.set(tag, b"US", value.to_le_bytes().to_vec())
    }

    /// The data set alone, in explicit little endian.
    pub fn data_set(&self) -> Vec<u8> {
        let mut sorted: Vec<_> = self.elements.iter().collect();
        sorted.sort_by_key(|(tag, ..)| *tag);
        sorted.iter().flat_map(|(tag, vr, value)| element(*tag, vr, value)).collect()
    }

    pub fn bytes(&self) -> Vec<u8> {
        [meta(&self.transfer_syntax), self.data_set()].concat()
    }
}

/// Frames as encapsulated pixel data, one fragment each, as the end of a file.
pub fn encapsulated(frames: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = element(tags::PIXEL_DATA, b"OB", b"");
    bytes[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    bytes.extend(item(b""));
    for frame in frames {
        let mut padded = frame.clone();
        padded.resize(frame.len().next_multiple_of(2), 0);
        bytes.extend(item(&padded));
    }
    bytes.extend([0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]);
    bytes
}
