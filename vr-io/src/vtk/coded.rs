//! Runs of bytes in a file, as they are or in base64, and the blocks that they may be packed in.
//!
//! Bytes begin with their number; compressed ones with the number of blocks, the size of a block, that of the last one if it is smaller, and the
//! compressed size of each (`vtkXMLWriter`). In base64, these sizes are a run of their own where there are blocks, and one run with the bytes
//! where there are none.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::read::ZlibDecoder;
use lzma_rust2::XzReader;

use crate::polled::Polled;
use crate::regular_file::{self, RegularFile};
use crate::scalar::Endian;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
    /// LZMA2 in the container of `.xz` files.
    Lzma,
}

/// Largest memory that a block of LZMA may ask for, in KiB: its dictionary at the highest preset is 64 MiB.
const MAX_LZMA_KIB: u32 = 80 << 10;

/// Layout of the numbers before the bytes of an array.
#[derive(Clone, Copy, Debug)]
pub(super) struct SizeWords {
    pub endian: Endian,
    /// Bytes of each.
    pub bytes: usize,
}

impl SizeWords {
    fn word(self, bytes: &[u8]) -> u64 {
        let ordered = |bytes: &mut dyn Iterator<Item = &u8>| bytes.fold(0, |sum, &b| sum << 8 | u64::from(b));
        match self.endian {
            Endian::Little => ordered(&mut bytes.iter().rev()),
            Endian::Big => ordered(&mut bytes.iter()),
        }
    }
}

/// The fault of coded bytes: what was found, and what would be right.
pub(super) enum CodedError {
    Io(io::Error),
    Wrong(String, String),
}

impl From<io::Error> for CodedError {
    fn from(e: io::Error) -> Self {
        Self::Io(e)
    }
}

impl CodedError {
    fn cut(what: &str) -> Self {
        Self::Wrong("the end of the data".to_owned(), format!("its {what} must be whole"))
    }
}

/// A part of a file that holds bytes, or their base64.
pub(super) struct Coded {
    file: RegularFile,
    at: Range<u64>,
    base64: bool,
}

impl Coded {
    pub fn open(path: &Path, at: Range<u64>, base64: bool) -> io::Result<Self> {
        let file = regular_file::open(path)?;
        // The file may have become shorter since its header was read.
        let end = at.end.min(file.length()?);
        Ok(Self { file, at: at.start..end, base64 })
    }

    /// Place of uncompressed bytes behind their number, which must be `length`.
    pub fn place_of_plain(&mut self, length: u64, sizes: SizeWords) -> Result<u64, CodedError> {
        let start = self.at.start;
        let claimed = sizes.word(&self.run(start, sizes.bytes as u64)?.ok_or_else(|| CodedError::cut("bytes"))?);
        if claimed != length {
            return Err(CodedError::Wrong(
                format!("{claimed} bytes"),
                format!("the sizes of its piece and its type need {length}"),
            ));
        }
        Ok(start + sizes.bytes as u64)
    }

    /// Bytes that are not compressed.
    pub fn plain(&mut self, length: u64, sizes: SizeWords) -> Result<Vec<u8>, CodedError> {
        self.place_of_plain(length, sizes)?;
        let (start, header) = (self.at.start, sizes.bytes);
        let whole = length.checked_add(header as u64);
        let whole = whole.map(|n| self.run(start, n)).transpose()?.flatten();
        let mut whole = whole.ok_or_else(|| CodedError::cut("bytes"))?;
        whole.drain(..header);
        Ok(whole)
    }

    /// Bytes in blocks.
    pub fn unpacked(&mut self, length: u64, sizes: SizeWords, compressor: Compressor) -> Result<Vec<u8>, CodedError> {
        let cut = || CodedError::cut("blocks");
        let (start, word) = (self.at.start, sizes.bytes as u64);
        let head = self.run(start, 3 * word)?.ok_or_else(cut)?;
        let [blocks, size, last] = [0, 1, 2].map(|i| sizes.word(&head[i * sizes.bytes..(i + 1) * sizes.bytes]));
        let whole_blocks = if last == 0 { blocks } else { blocks.saturating_sub(1) };
        let claimed = u128::from(whole_blocks) * u128::from(size) + u128::from(last);
        if claimed != u128::from(length) {
            return Err(CodedError::Wrong(
                format!("blocks of {claimed} bytes"),
                format!("the sizes of its piece and its type need {length}"),
            ));
        }
        let head_length = blocks.checked_add(3).and_then(|n| n.checked_mul(word)).ok_or_else(cut)?;
        let head = self.run(start, head_length)?.ok_or_else(cut)?;
        let packed_sizes: Vec<u64> = head.chunks_exact(sizes.bytes).skip(3).map(|w| sizes.word(w)).collect();
        let packed = packed_sizes.iter().try_fold(0u64, |sum, &size| sum.checked_add(size)).ok_or_else(cut)?;
        let data = start.checked_add(self.coded_length(head_length).ok_or_else(cut)?).ok_or_else(cut)?;
        let packed = self.run(data, packed)?.ok_or_else(cut)?;
        let mut rest = &packed[..];
        let mut out = Vec::new();
        for (i, &packed_size) in packed_sizes.iter().enumerate() {
            let (block, after) = rest.split_at(packed_size as usize);
            rest = after;
            let unpacked = if last > 0 && i + 1 == packed_sizes.len() { last } else { size };
            let before = out.len();
            compressor
                .unpack(block, unpacked, &mut out)
                .map_err(|e| CodedError::Wrong(e, "block must be sound".to_owned()))?;
            if (out.len() - before) as u64 != unpacked {
                let found = format!("a block of {} bytes", out.len() - before);
                return Err(CodedError::Wrong(found, format!("its header claims {unpacked}")));
            }
        }
        Ok(out)
    }

    /// Reads `length` bytes from a place of the file on, where in base64 a run begins; `None` where there are fewer.
    fn run(&mut self, from: u64, length: u64) -> io::Result<Option<Vec<u8>>> {
        let left = self.at.end.saturating_sub(from);
        if !self.base64 {
            return if length > left { Ok(None) } else { self.read(from, length).map(Some) };
        }
        // A run that goes on has no padding where this part of it ends.
        let digits = self.coded_length(length).map_or(left, |digits| digits.min(left));
        // Longer than all digits that are left can be.
        if length / 3 > digits / 4 + 1 {
            return Ok(None);
        }
        let Ok(mut bytes) = STANDARD.decode(self.read(from, digits)?) else { return Ok(None) };
        let length = length as usize;
        bytes.truncate(length);
        Ok((bytes.len() == length).then_some(bytes))
    }

    /// Bytes of the file that a run of so many takes.
    fn coded_length(&self, length: u64) -> Option<u64> {
        if self.base64 { length.div_ceil(3).checked_mul(4) } else { Some(length) }
    }

    /// Reads bytes of the file, which are within it.
    fn read(&mut self, from: u64, length: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.file.seek(SeekFrom::Start(from))?;
        (&mut self.file).take(length).read_to_end(&mut bytes)?;
        if (bytes.len() as u64) < length { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(bytes) }
    }
}

/// Reads a part of a file.
pub(super) fn read_range(path: &Path, at: &Range<u64>) -> io::Result<Vec<u8>> {
    let mut file = regular_file::open(path)?;
    file.seek(SeekFrom::Start(at.start))?;
    let mut bytes = Vec::new();
    file.take(at.end - at.start).read_to_end(&mut bytes)?;
    if (bytes.len() as u64) < at.end - at.start { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(bytes) }
}

impl Compressor {
    /// Appends what a block unpacks to: `size` bytes, or some more or less where it is not what it claims to be.
    fn unpack(self, block: &[u8], size: u64, out: &mut Vec<u8>) -> Result<(), String> {
        let mut read = |unpacker: &mut dyn Read| {
            Polled::new(unpacker).take(size.saturating_add(1)).read_to_end(out).map(|_| ()).map_err(|e| e.to_string())
        };
        match self {
            Self::Zlib => read(&mut ZlibDecoder::new(block))?,
            Self::Lzma => read(&mut XzReader::new_mem_limit(block, false, MAX_LZMA_KIB))?,
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers 0 to 15, as `lzma_easy_buffer_encode` packs them for VTK: preset 5, CRC32.
    const PACKED: &str = "fd377a585a0000016922de360200210116000000742fe5a301000f000102030405060708090a0b0c0d0e0f0088e2cece00012410e944d9cc9042990d010000000001595a";

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
    }

    fn unpacked(block: &[u8], size: u64) -> Result<Vec<u8>, String> {
        let mut out = Vec::new();
        Compressor::Lzma.unpack(block, size, &mut out).map(|()| out)
    }

    #[test]
    fn blocks_of_lzma_unpack() {
        let packed = bytes(PACKED);
        assert_eq!(unpacked(&packed, 16).unwrap(), (0..16).collect::<Vec<u8>>());
        // No more than one byte beyond what is claimed, so that a small block does not fill the memory.
        assert_eq!(unpacked(&packed, 3).unwrap().len(), 4);
        // 64 KiB of zeros at the highest preset.
        let zeros = "fd377a585a0000016922de36020021011c00000010cf58cce0ffff004c5d00006ffdffffa3b7ff473e481572396151b89228e6a38607f9eee41e82d32fc53a3c014bb17ec98a8a4d2fa30dd97fa6e38c231153e05918c5758ae277f8b6947f0c6ac0de7449645c9e3ad10000eb8e97d70001648080040000e437860b3e300d8b020000000001595a";
        assert_eq!(unpacked(&bytes(zeros), 1 << 16).unwrap(), vec![0; 1 << 16]);
    }

    #[test]
    fn unpacking_ends_where_the_work_is_cancelled() {
        let control = vr_core::Control::default();
        control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        io::Write::write_all(&mut zlib, &[0; 16]).unwrap();
        for (compressor, block) in [(Compressor::Zlib, zlib.finish().unwrap()), (Compressor::Lzma, bytes(PACKED))] {
            let unpack = || compressor.unpack(&block, 16, &mut Vec::new());
            assert_eq!(control.cancellable(unpack), Ok(Err("cancelled".to_owned())));
            assert_eq!(unpack(), Ok(()));
        }
    }

    #[test]
    fn damaged_blocks_of_lzma_are_errors() {
        let packed = bytes(PACKED);
        for length in 0..packed.len() {
            let _ = unpacked(&packed[..length], 16);
        }
        // Within the data and the checks of the headers; the last bytes are the stream's end, which need not be read.
        for place in 0..48 {
            let mut damaged = packed.clone();
            damaged[place] ^= 0x55;
            // A chunk that is longer than the block is seen by its length.
            let length = unpacked(&damaged, 16).map(|out| out.len());
            assert_ne!(length, Ok(16), "byte {place}");
        }
        // A dictionary of 4 GiB, in a header that is sound.
        let greedy = "fd377a585a0000016922de360200210128000000e6a011b301000f000102030405060708090a0b0c0d0e0f0088e2cece00012410e944d9cc9042990d010000000001595a";
        assert!(unpacked(&bytes(greedy), 16).is_err());
    }
}
