//! VTK's XML: the text, which ends where appended data begin, and what the root says about all arrays.

use std::io::{self, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};

use crate::error::FileErrorKind;
use crate::regular_file;
use crate::scalar::Endian;

use super::coded::{Compressor, SizeWords};

/// The text of a file, without its appended data.
pub(crate) struct XmlFile {
    path: PathBuf,
    text: String,
    appended: Appended,
}

/// The data that follow the arrays' descriptions.
#[derive(Clone, Debug)]
pub(super) struct Appended {
    /// Place in the file, from behind the `_` to the file's end.
    pub at: Range<u64>,
    pub base64: bool,
}

/// The file as a store of numbers: what is needed to read an array later on.
#[derive(Clone, Debug)]
pub(crate) struct Store {
    pub(super) path: PathBuf,
    pub endian: Endian,
    pub(super) sizes: SizeWords,
    pub(super) compressor: Option<Compressor>,
    pub(super) appended: Appended,
}

const TAG: &[u8] = b"<AppendedData";

impl XmlFile {
    /// Reads a file up to its appended data, which need not be XML.
    pub fn open(path: &Path) -> Result<Self, FileErrorKind> {
        let mut file = regular_file::open(path)?;
        let length = file.length()?;
        let mut bytes = Vec::new();
        let found = read_to_tag(&mut file, &mut bytes)?;
        let length = length.max(bytes.len() as u64);
        let mut appended = Appended { at: length..length, base64: false };
        if let Some(tag) = found {
            let missing = || FileErrorKind::field("AppendedData", "no '_'", "its bytes begin behind '_'");
            let end = tag + bytes[tag..].iter().position(|&c| c == b'>').ok_or_else(missing)? + 1;
            let begin = end + bytes[end..].iter().position(|&c| c == b'_').ok_or_else(missing)? + 1;
            let attributes = &bytes[tag..end];
            let raw = [b"\"raw\"", b"'raw'"].iter().any(|raw| attributes.windows(raw.len()).any(|w| w == *raw));
            appended = Appended { at: begin as u64..length, base64: !raw };
            bytes.truncate(tag);
            bytes.extend_from_slice(b"<AppendedData></AppendedData></VTKFile>");
        }
        let text = String::from_utf8(bytes)
            .map_err(|_| FileErrorKind::field("XML", "bytes that are no text", "must be UTF-8"))?;
        Ok(Self { path: path.into(), text, appended })
    }

    /// Its elements; their ranges are places in the file.
    pub fn document(&self) -> Result<Document<'_>, FileErrorKind> {
        Document::parse(&self.text)
            .map_err(|e| FileErrorKind::field("XML", e, "must be well-formed and whole, to the end of VTKFile"))
    }

    /// Reads how arrays are stored.
    pub fn store(&self, root: Node<'_, '_>) -> Result<Store, FileErrorKind> {
        let wrong =
            |place: &str, found: &str, allowed| Err(FileErrorKind::field(format!("VTKFile {place}"), found, allowed));
        let endian = match root.attribute("byte_order") {
            None | Some("LittleEndian") => Endian::Little,
            Some("BigEndian") => Endian::Big,
            Some(other) => return wrong("byte_order", other, "must be LittleEndian or BigEndian"),
        };
        let bytes = match root.attribute("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return wrong("header_type", other, "must be UInt32 or UInt64"),
        };
        let compressor = match root.attribute("compressor") {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some("vtkLZMADataCompressor") => Some(Compressor::Lzma),
            Some(other) => {
                let read = "vtkZLibDataCompressor, vtkLZ4DataCompressor and vtkLZMADataCompressor are read";
                return wrong("compressor", other, read);
            }
        };
        let sizes = SizeWords { endian, bytes };
        Ok(Store { path: self.path.clone(), endian, sizes, compressor, appended: self.appended.clone() })
    }
}

/// The root of a file that holds one of some kinds of data, and its kind.
pub(crate) fn root<'d, 't>(
    document: &'d Document<'t>,
    kinds: &[&'static str],
) -> Result<(Node<'d, 't>, &'static str), FileErrorKind> {
    let root = document.root_element();
    let found = root.attribute("type").unwrap_or_default();
    let kind = kinds.iter().copied().find(|&kind| kind == found && root.has_tag_name("VTKFile"));
    let wrong = || FileErrorKind::field("VTKFile type", found, format!("must be {}", kinds.join(" or ")));
    Ok((root, kind.ok_or_else(wrong)?))
}

/// Reads a file until the mark of appended data has come by, with all to the `_`; the place of the mark.
fn read_to_tag(file: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<Option<usize>> {
    const CHUNK: u64 = 1 << 16;
    let mut searched = 0;
    let mut tag = None;
    loop {
        if file.take(CHUNK).read_to_end(bytes)? == 0 {
            return Ok(tag);
        }
        tag = tag.or_else(|| find_tag(bytes, searched));
        searched = (bytes.len() + 1).saturating_sub(TAG.len());
        if let Some(tag) = tag
            && let Some(end) = bytes[tag..].iter().position(|&c| c == b'>')
            && bytes[tag + end..].contains(&b'_')
        {
            return Ok(Some(tag));
        }
    }
}

fn find_tag(bytes: &[u8], from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        at += bytes[at..].iter().position(|&c| c == b'<')?;
        if bytes[at..].starts_with(TAG) {
            return Some(at);
        }
        at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives a few bytes at a time.
    struct Slow<'a>(&'a [u8], usize);

    impl Read for Slow<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let n = self.1.min(self.0.len()).min(buffer.len());
            buffer[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    #[test]
    fn the_mark_is_found_across_chunks_and_no_more_is_read_than_needed() {
        for before in (1 << 16) - 20..(1 << 16) + 4 {
            let mut file = vec![b'<'; before];
            file.extend(b"<AppendedData encoding=\"raw\">\n _");
            file.resize(1 << 20, 0xff);
            let mut bytes = Vec::new();
            assert_eq!(read_to_tag(&mut &file[..], &mut bytes).unwrap(), Some(before));
            assert!(bytes.len() <= 2 << 16, "{}", bytes.len());
        }
        let mut bytes = Vec::new();
        assert_eq!(read_to_tag(&mut Slow(b"<VTKFile><a/></VTKFile>", 3), &mut bytes).unwrap(), None);
        assert_eq!(bytes.len(), 23);
        assert_eq!(read_to_tag(&mut Slow(b"<VTKFile><AppendedData>", 3), &mut Vec::new()).unwrap(), Some(9));
    }
}
