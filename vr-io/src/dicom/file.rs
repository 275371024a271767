//! One file: preamble, meta information, and the data set up to the voxels (DICOM PS3.10 2024, section 7).

use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::read::DeflateDecoder;

use super::element_header::Headers;
use super::elements::{DataSetReader, Elements, Forward, PixelElement};
use super::tags;
use super::transfer_syntax::TransferSyntax;
use crate::error::{FileError, FileErrorKind};
use crate::regular_file::{self, RegularFile};

/// Bytes before the prefix, of any content.
const PREAMBLE: usize = 128;
const PREFIX: &[u8] = b"DICM";
/// Bytes that a deflated data set may inflate to before its voxels: a thousand times what such headers hold.
const MAX_INFLATED_HEADER: u64 = 1 << 26;

/// A file of which all but the voxels was read.
#[derive(Debug)]
pub(super) struct DicomFile {
    pub path: PathBuf,
    pub syntax: TransferSyntax,
    /// Offset of the data set in the file.
    pub start: u64,
    /// Bytes of the file.
    pub length: u64,
    pub elements: Elements,
    pub pixels: Option<PixelElement>,
}

impl DicomFile {
    /// Opens a file that is asked for.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        Self::open_if_dicom(path)?.ok_or_else(|| {
            let allowed = "must be DICM after 128 bytes, or a data set from the first byte on";
            FileError::new(path, FileErrorKind::field("prefix", "neither DICM nor a data set", allowed))
        })
    }

    /// Opens a file of a folder: `None` where it is none of DICOM's.
    pub fn open_if_dicom(path: &Path) -> Result<Option<Self>, FileError> {
        let in_file = |e: FileErrorKind| FileError::new(path, e);
        let io = |e: io::Error| FileError::new(path, e);
        let file = regular_file::open(path).map_err(io)?;
        let length = file.length().map_err(io)?;
        let mut source = BufReader::new(file);
        let mut head = Vec::new();
        source.by_ref().take((PREAMBLE + PREFIX.len()) as u64).read_to_end(&mut head).map_err(io)?;
        if head.get(PREAMBLE..) == Some(PREFIX) {
            let (syntax, start) = read_meta(&mut source, length).map_err(in_file)?;
            return Self::read(path, source, syntax, start, length).map(Some).map_err(in_file);
        }
        // Without meta information: of old, and from senders that leave it away. Anything may begin like that, so that what turns out not to
        // be a data set is none.
        let Some(headers) = headers_of_bare_data_set(&head) else { return Ok(None) };
        source.seek(SeekFrom::Start(0)).map_err(io)?;
        let read = Self::read(path, source, TransferSyntax::native(headers), 0, length);
        Ok(read.ok().filter(|file| file.pixels.is_some()))
    }

    fn read(
        path: &Path,
        mut source: BufReader<RegularFile>,
        syntax: TransferSyntax,
        start: u64,
        length: u64,
    ) -> Result<Self, FileErrorKind> {
        source.seek(SeekFrom::Start(start))?;
        let (elements, pixels) = if syntax.deflated {
            let inflated = Forward(DeflateDecoder::new(source));
            DataSetReader::new(inflated, 0).read(syntax.headers, MAX_INFLATED_HEADER)?
        } else {
            DataSetReader::new(source, start).read(syntax.headers, length)?
        };
        Ok(Self { path: path.into(), syntax, start, length, elements, pixels })
    }
}

/// Reads group 0002, which is explicit little endian in every file; gives the transfer syntax and the offset of what follows.
fn read_meta(source: &mut BufReader<RegularFile>, length: u64) -> Result<(TransferSyntax, u64), FileErrorKind> {
    let mut start = (PREAMBLE + PREFIX.len()) as u64;
    let mut uid = None;
    loop {
        let mut group = [0; 2];
        match source.read_exact(&mut group) {
            Ok(()) => source.seek_relative(-2)?,
            Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => break,
            Err(e) => return Err(e.into()),
        }
        if u16::from_le_bytes(group) != 2 {
            break;
        }
        // One element at a time: the end of the group is told by the next one, since writers get the group's length wrong.
        let (end, found) = read_meta_element(source, start, length)?;
        start = end;
        uid = found.or(uid);
    }
    let allowed = "the field is required: it tells how the data set is coded";
    let uid = uid.ok_or_else(|| FileErrorKind::field(tags::TRANSFER_SYNTAX_UID.name(), "nothing", allowed))?;
    Ok((TransferSyntax::from_uid(&uid), start))
}

fn read_meta_element(
    source: &mut BufReader<RegularFile>,
    start: u64,
    length: u64,
) -> Result<(u64, Option<String>), FileErrorKind> {
    let mut reader = DataSetReader::new(source, start);
    let elements = reader.read_one(Headers::Explicit, length)?;
    Ok((reader.position(), elements.text(tags::TRANSFER_SYNTAX_UID).map(|uid| uid.into_owned())))
}

/// Coding of a data set that begins a file, if it looks like one: its first element belongs to group 0008 then.
fn headers_of_bare_data_set(head: &[u8]) -> Option<Headers> {
    let [8, 0, _, 0, a, b, c, d, ..] = *head else { return None };
    if a.is_ascii_uppercase() && b.is_ascii_uppercase() {
        return Some(Headers::Explicit);
    }
    (u32::from_le_bytes([a, b, c, d]) < 1024).then_some(Headers::Implicit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tells_bare_data_sets_by_their_first_element() {
        assert_eq!(headers_of_bare_data_set(b"\x08\0\x05\0CS\x0a\0"), Some(Headers::Explicit));
        assert_eq!(headers_of_bare_data_set(b"\x08\0\0\0\x04\0\0\0"), Some(Headers::Implicit));
        assert_eq!(headers_of_bare_data_set(b"\x08\0\0\0\0\0\0\x40"), None);
        assert_eq!(headers_of_bare_data_set(b"\x20\x08\0\x05\0CS\x0a"), None);
        assert_eq!(headers_of_bare_data_set(b"\x08\0"), None);
    }
}
