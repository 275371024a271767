//! Places for texts in picture files: iTXt chunks of PNG, attributes of EXR.

use std::io::{BufReader, Read, Seek};
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::LayerAttributes;
use png::text_metadata::ITXtChunk;
use png::{Decoder, DecodingError, Info, Limits};

use super::Texts;
use crate::picture_read::PictureError;
use crate::regular_file::{self, RegularFile};

/// Name of the chunk or attribute that holds the record.
const KEY: &str = "vr";

/// Largest record that is read: a scene file with 64³ voxels has some 5 MB.
const MAX_TEXT: usize = 1 << 26;

/// Chunks of a PNG that hold texts.
pub(super) fn png_chunks(texts: &Texts) -> [ITXtChunk; 2] {
    let mut record = ITXtChunk::new(KEY, &texts.record);
    record.compressed = true;
    [ITXtChunk::new("Description", &texts.description), record]
}

/// Attributes of an EXR layer that hold texts.
pub(super) fn exr_attributes(texts: &Texts) -> LayerAttributes {
    // UTF-8, as other programs read it.
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let mut attributes = LayerAttributes { comments: Some(text(&texts.description)), ..LayerAttributes::default() };
    attributes.other.insert(text(KEY), AttributeValue::Text(text(&texts.record)));
    attributes
}

/// Reads the text of the record in a picture; `None` where there is none.
pub(super) fn read_text(path: &Path) -> Result<Option<String>, PictureError> {
    let io = |source| PictureError::Io { path: path.into(), source };
    let mut file = regular_file::open(path).map_err(io)?;
    let mut head = Vec::new();
    (&mut file).take(4).read_to_end(&mut head).map_err(io)?;
    file.rewind().map_err(io)?;
    if head == exr::meta::magic_number::BYTES {
        exr_text(path, BufReader::new(file))
    } else if head == *b"\x89PNG" {
        png_text(BufReader::new(file)).map_err(|error| match error {
            DecodingError::IoError(e) if e.kind() != std::io::ErrorKind::UnexpectedEof => io(e),
            other => PictureError::damaged(path, "PNG", other),
        })
    } else {
        Err(PictureError::unsupported(path, "this file", "only PNG and EXR pictures hold a record"))
    }
}

fn exr_text(path: &Path, file: BufReader<RegularFile>) -> Result<Option<String>, PictureError> {
    let damaged = |message: &dyn std::fmt::Display| PictureError::damaged(path, "EXR", message);
    let meta = MetaData::read_from_buffered(file, false).map_err(|e| damaged(&e))?;
    let attributes = meta.headers.iter().flat_map(|h| h.own_attributes.other.iter().chain(&h.shared_attributes.other));
    let mut found = attributes.filter(|(key, _)| key.as_slice() == KEY.as_bytes());
    match found.next() {
        Some((_, AttributeValue::Text(text))) => match std::str::from_utf8(text.as_slice()) {
            Ok(text) => Ok(Some(text.to_owned())),
            Err(e) => Err(damaged(&e)),
        },
        _ => Ok(None),
    }
}

fn png_text(file: BufReader<RegularFile>) -> Result<Option<String>, DecodingError> {
    let mut reader = Decoder::new_with_limits(file, Limits { bytes: MAX_TEXT }).read_info()?;
    if let Some(text) = record_of(reader.info())? {
        return Ok(Some(text));
    }
    // A program that packs files anew may put the text behind the pixels.
    reader.finish()?;
    record_of(reader.info())
}

/// Returns the record among a PNG's texts, of whichever kind a program has made it.
fn record_of(info: &Info<'_>) -> Result<Option<String>, DecodingError> {
    if let Some(chunk) = info.utf8_text.iter().find(|chunk| chunk.keyword == KEY) {
        let mut chunk = chunk.clone();
        chunk.decompress_text_with_limit(MAX_TEXT)?;
        return chunk.get_text().map(Some);
    }
    if let Some(chunk) = info.compressed_latin1_text.iter().find(|chunk| chunk.keyword == KEY) {
        let mut chunk = chunk.clone();
        chunk.decompress_text_with_limit(MAX_TEXT)?;
        return chunk.get_text().map(Some);
    }
    Ok(info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == KEY).map(|chunk| chunk.text.clone()))
}
