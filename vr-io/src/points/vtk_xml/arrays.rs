//! The numbers of VTK's arrays: as text, in base64, or appended at the end of the file; as they are, or in compressed blocks.
//!
//! The layout is that of `vtkXMLDataElement` and `vtkXMLWriter` (VTK User's Guide, "VTK file formats"): bytes begin with their number; compressed
//! ones with the number of blocks, the size of a block, that of the last one if it is smaller, and the compressed size of each.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use roxmltree::Node;

use crate::error::{FileErrorKind, shown};
use crate::points::numbers;
use crate::scalar::{Endian, ScalarType};

/// Attributes of the root that hold for all arrays.
pub(super) struct Coding {
    pub endian: Endian,
    /// Bytes of a number in the headers of arrays.
    header: usize,
    compressor: Option<Compressor>,
}

#[derive(Clone, Copy, PartialEq)]
enum Compressor {
    Zlib,
    Lz4,
}

impl Coding {
    pub fn of(root: Node<'_, '_>) -> Result<Self, FileErrorKind> {
        let wrong =
            |place: &str, found: &str, allowed| Err(FileErrorKind::field(format!("VTKFile {place}"), found, allowed));
        let endian = match root.attribute("byte_order") {
            None | Some("LittleEndian") => Endian::Little,
            Some("BigEndian") => Endian::Big,
            Some(other) => return wrong("byte_order", other, "must be LittleEndian or BigEndian"),
        };
        let header = match root.attribute("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return wrong("header_type", other, "must be UInt32 or UInt64"),
        };
        let compressor = match root.attribute("compressor") {
            None | Some("") => None,
            Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
            Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
            Some(other) => {
                return wrong("compressor", other, "vtkZLibDataCompressor and vtkLZ4DataCompressor are read");
            }
        };
        Ok(Self { endian, header, compressor })
    }

    fn word(&self, bytes: &[u8]) -> u64 {
        let ordered = |bytes: &mut dyn Iterator<Item = &u8>| bytes.fold(0, |sum, &b| sum << 8 | u64::from(b));
        match self.endian {
            Endian::Little => ordered(&mut bytes.iter().rev()),
            Endian::Big => ordered(&mut bytes.iter()),
        }
    }
}

/// The data that follow the arrays' descriptions.
pub(super) struct Appended<'a> {
    bytes: &'a [u8],
    base64: bool,
}

impl<'a> Appended<'a> {
    /// Parts the XML from appended data, which need not be XML.
    pub fn split(bytes: &'a [u8]) -> Result<(Cow<'a, str>, Self), FileErrorKind> {
        const TAG: &[u8] = b"<AppendedData";
        let text = |bytes: &'a [u8]| {
            str::from_utf8(bytes).map_err(|_| FileErrorKind::field("XML", "bytes that are no text", "must be UTF-8"))
        };
        let Some(tag) = bytes.windows(TAG.len()).position(|w| w == TAG) else {
            return Ok((text(bytes)?.into(), Self { bytes: &[], base64: false }));
        };
        let missing = || FileErrorKind::field("AppendedData", "no '_'", "its bytes begin behind '_'");
        let end = tag + bytes[tag..].iter().position(|&c| c == b'>').ok_or_else(missing)? + 1;
        let begin = end + bytes[end..].iter().position(|&c| c == b'_').ok_or_else(missing)? + 1;
        let base64 = !text(&bytes[tag..end])?.contains("\"raw\"");
        let xml = format!("{}<AppendedData></AppendedData></VTKFile>", text(&bytes[..tag])?);
        Ok((xml.into(), Self { bytes: &bytes[begin..], base64 }))
    }
}

/// An array, not looked at yet.
pub(super) struct DataArray<'d, 't> {
    node: Node<'d, 't>,
    name: String,
    pub scalar: ScalarType,
}

impl<'d, 't> DataArray<'d, 't> {
    pub fn new(node: Node<'d, 't>) -> Result<Self, FileErrorKind> {
        let name = format!("array {}", shown(node.attribute("Name").unwrap_or("Points")));
        let scalar = node.attribute("type").unwrap_or_default();
        // Float32, UInt8, …
        let known = ScalarType::from_name(&scalar.to_ascii_lowercase())
            .filter(|_| scalar.ends_with(|c: char| c.is_ascii_digit()));
        let wrong =
            || FileErrorKind::field(format!("{name}, type"), scalar, "must be Int8 to UInt64, Float32 or Float64");
        let scalar = known.ok_or_else(wrong)?;
        Ok(Self { node, name, scalar })
    }

    /// The encoding in a word: `ascii`, `base64`, `raw`, `zlib` or `lz4`.
    pub fn encoding(&self, coding: &Coding, appended: &Appended<'_>) -> &'static str {
        match (self.node.attribute("format"), coding.compressor) {
            (Some("ascii"), _) => "ascii",
            (_, Some(Compressor::Zlib)) => "zlib",
            (_, Some(Compressor::Lz4)) => "lz4",
            (Some("appended"), None) if !appended.base64 => "raw",
            _ => "base64",
        }
    }

    /// All its numbers, of which there must be `count`.
    pub fn numbers(&self, count: usize, coding: &Coding, appended: &Appended<'_>) -> Result<Vec<f64>, FileErrorKind> {
        let text: String = match self.node.attribute("format") {
            Some("appended") => String::new(),
            _ => self.node.children().filter_map(|n| n.is_text().then(|| n.text()).flatten()).collect(),
        };
        let source = match self.node.attribute("format") {
            None | Some("ascii") => return self.ascii(&text, count),
            Some("binary") => Source { bytes: text.trim().as_bytes(), base64: true },
            Some("appended") => {
                let offset = self.node.attribute("offset").unwrap_or_default();
                let from = offset.trim().parse().ok().and_then(|from: usize| appended.bytes.get(from..));
                let allowed = format!("must be within the {} bytes of AppendedData", appended.bytes.len());
                let bytes =
                    from.ok_or_else(|| FileErrorKind::field(format!("{}, offset", self.name), offset, allowed))?;
                Source { bytes, base64: appended.base64 }
            }
            Some(other) => return Err(self.wrong(other, "format must be ascii, binary or appended")),
        };
        let length = count as u64 * self.scalar.bytes() as u64;
        let bytes = match coding.compressor {
            None => self.plain(source, length, coding)?,
            Some(compressor) => self.unpacked(source, length, coding, compressor)?,
        };
        Ok(numbers::numbers(&bytes, self.scalar, coding.endian))
    }

    fn wrong(&self, found: impl std::fmt::Display, allowed: impl Into<String>) -> FileErrorKind {
        FileErrorKind::field(self.name.clone(), found, allowed)
    }

    fn ascii(&self, text: &str, count: usize) -> Result<Vec<f64>, FileErrorKind> {
        let number = |word: &str| word.parse().map_err(|_| self.wrong(word, "must be a number"));
        let all: Vec<f64> = text.split_ascii_whitespace().map(number).collect::<Result<_, _>>()?;
        if all.len() != count {
            return Err(self.wrong(format!("{} numbers", all.len()), format!("NumberOfPoints needs {count}")));
        }
        Ok(all)
    }

    fn plain<'b>(&self, source: Source<'b>, length: u64, coding: &Coding) -> Result<Cow<'b, [u8]>, FileErrorKind> {
        let cut = || self.wrong("the end of the data", "its bytes must be whole");
        // The number of bytes and the bytes are one run of base64.
        let claimed = coding.word(&source.run(0, coding.header).ok_or_else(cut)?);
        if claimed != length {
            return Err(self.wrong(format!("{claimed} bytes"), format!("NumberOfPoints and type need {length}")));
        }
        let whole = usize::try_from(length).ok().and_then(|n| n.checked_add(coding.header));
        let whole = whole.and_then(|n| source.run(0, n)).ok_or_else(cut)?;
        Ok(match whole {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[coding.header..]),
            Cow::Owned(bytes) => Cow::Owned(bytes[coding.header..].to_vec()),
        })
    }

    fn unpacked<'b>(
        &self,
        source: Source<'b>,
        length: u64,
        coding: &Coding,
        compressor: Compressor,
    ) -> Result<Cow<'b, [u8]>, FileErrorKind> {
        let cut = || self.wrong("the end of the data", "its blocks must be whole");
        let start = source.run(0, 3 * coding.header).ok_or_else(cut)?;
        let [blocks, size, last] = [0, 1, 2].map(|i| coding.word(&start[i * coding.header..(i + 1) * coding.header]));
        let whole_blocks = if last == 0 { blocks } else { blocks.saturating_sub(1) };
        let claimed = u128::from(whole_blocks) * u128::from(size) + u128::from(last);
        if claimed != u128::from(length) {
            return Err(
                self.wrong(format!("blocks of {claimed} bytes"), format!("NumberOfPoints and type need {length}"))
            );
        }
        let header = usize::try_from(blocks).ok().and_then(|n| n.checked_add(3)?.checked_mul(coding.header));
        let header_length = header.ok_or_else(cut)?;
        let header = source.run(0, header_length).ok_or_else(cut)?;
        let mut data = source.after(header_length).ok_or_else(cut)?;
        // In base64, the blocks are one run, apart from the header.
        let sizes: Vec<u64> = header.chunks_exact(coding.header).skip(3).map(|word| coding.word(word)).collect();
        let packed = sizes.iter().try_fold(0u64, |sum, &size| sum.checked_add(size));
        let packed = packed.and_then(|n| usize::try_from(n).ok()).ok_or_else(cut)?;
        let packed = data.take(packed).ok_or_else(cut)?;
        let mut rest = &packed[..];
        let mut out = Vec::new();
        for (i, &packed_size) in sizes.iter().enumerate() {
            let (block, after) = rest.split_at(packed_size as usize);
            rest = after;
            let unpacked = if last > 0 && i + 1 == sizes.len() { last } else { size };
            let before = out.len();
            compressor.unpack(block, unpacked, &mut out).map_err(|e| self.wrong(e, "block must be sound"))?;
            if (out.len() - before) as u64 != unpacked {
                let found = format!("a block of {} bytes", out.len() - before);
                return Err(self.wrong(found, format!("its header claims {unpacked}")));
            }
        }
        Ok(Cow::Owned(out))
    }
}

impl Compressor {
    /// Appends what a block unpacks to: `size` bytes, or some more or less where it is not what it claims to be.
    fn unpack(self, block: &[u8], size: u64, out: &mut Vec<u8>) -> Result<(), String> {
        match self {
            Self::Zlib => {
                ZlibDecoder::new(block).take(size.saturating_add(1)).read_to_end(out).map_err(|e| e.to_string())?;
            }
            Self::Lz4 => {
                // A byte stands for at most 255.
                let max_size = (block.len() as u64 + 1).saturating_mul(255);
                if size > max_size {
                    return Err(format!("{} bytes for {size}", block.len()));
                }
                out.extend(lz4_flex::block::decompress(block, size as usize).map_err(|e| e.to_string())?);
            }
        }
        Ok(())
    }
}

/// Bytes, or their base64.
#[derive(Clone, Copy)]
struct Source<'a> {
    bytes: &'a [u8],
    base64: bool,
}

impl<'a> Source<'a> {
    /// Reads `length` bytes from byte `from` on, which in base64 begins a run; `None` where there are fewer.
    fn run(&self, from: usize, length: usize) -> Option<Cow<'a, [u8]>> {
        let mut source = *self;
        source.bytes = source.bytes.get(from..)?;
        source.take(length)
    }

    fn take(&mut self, length: usize) -> Option<Cow<'a, [u8]>> {
        if !self.base64 {
            return self.bytes.get(..length).map(Cow::Borrowed);
        }
        let digits = self.bytes.get(..length.div_ceil(3).checked_mul(4)?);
        // A run that goes on has no padding where this part of it ends.
        let mut bytes = match digits {
            Some(digits) => STANDARD.decode(digits).ok()?,
            None => STANDARD.decode(self.bytes).ok()?,
        };
        bytes.truncate(length);
        (bytes.len() == length).then_some(Cow::Owned(bytes))
    }

    /// The data that follow a run of so many bytes.
    fn after(&self, length: usize) -> Option<Self> {
        let taken = if self.base64 { length.div_ceil(3).checked_mul(4)? } else { length };
        Some(Self { bytes: self.bytes.get(taken..)?, base64: self.base64 })
    }
}
