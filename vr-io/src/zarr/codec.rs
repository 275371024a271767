//! Codings of a chunk's bytes.

use std::io::{self, Read};

use crate::encoding::{Encoding, invalid};
use crate::error::FieldError;
use crate::polled::Polled;

use super::blosc;
use super::crc32c::crc32c;

/// A coding of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    Gzip,
    Zlib,
    Bzip2,
    Zstd,
    /// A block, its length before it.
    Lz4,
    Blosc,
    /// A checksum at the end.
    Crc32c,
}

impl Codec {
    pub fn from_name(name: &str, field: &str) -> Result<Self, FieldError> {
        Ok(match name {
            "gzip" => Self::Gzip,
            "zlib" => Self::Zlib,
            "bz2" => Self::Bzip2,
            "zstd" => Self::Zstd,
            "lz4" => Self::Lz4,
            "blosc" => Self::Blosc,
            "crc32c" => Self::Crc32c,
            other => {
                let allowed = "must be gzip, zlib, bz2, zstd, lz4, blosc or crc32c";
                return Err(FieldError::new(field, other, allowed));
            }
        })
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Bzip2 => "bzip2",
            Self::Zstd => "zstd",
            Self::Lz4 => "lz4",
            Self::Blosc => "blosc",
            Self::Crc32c => "crc32c",
        }
    }

    /// Decodes `coded`; more than `max_bytes` of output is an error.
    pub fn decode(self, coded: &[u8], max_bytes: usize) -> io::Result<Vec<u8>> {
        match self {
            Self::Gzip => read(Encoding::Gzip.reader(coded), max_bytes),
            Self::Zlib => read(Encoding::Zlib.reader(coded), max_bytes),
            Self::Bzip2 => read(Encoding::Bzip2.reader(coded), max_bytes),
            Self::Zstd => zstd(coded, max_bytes),
            Self::Lz4 => {
                let (length, block) = coded.split_first_chunk().ok_or_else(cut_off)?;
                lz4_block(block, u32::from_le_bytes(*length) as usize, max_bytes)
            }
            Self::Blosc => blosc::decode(coded, max_bytes),
            Self::Crc32c => {
                let (bytes, stored) = coded.split_last_chunk().ok_or_else(cut_off)?;
                if crc32c(bytes) == u32::from_le_bytes(*stored) {
                    Ok(bytes.to_vec())
                } else {
                    Err(invalid("the CRC-32C does not fit the bytes".into()))
                }
            }
        }
    }
}

pub(super) fn cut_off() -> io::Error {
    invalid("the chunk is cut off".into())
}

fn too_long(max_bytes: usize) -> io::Error {
    invalid(format!("there are more than {max_bytes} bytes in it"))
}

/// A frame of Zstandard.
pub(super) fn zstd(coded: &[u8], max_bytes: usize) -> io::Result<Vec<u8>> {
    let frame = ruzstd::decoding::StreamingDecoder::new(coded).map_err(io::Error::other)?;
    read(frame, max_bytes)
}

/// A block of LZ4 that stands for `length` bytes at most.
pub(super) fn lz4_block(block: &[u8], length: usize, max_bytes: usize) -> io::Result<Vec<u8>> {
    if length > max_bytes {
        return Err(too_long(max_bytes));
    }
    // No byte of LZ4 stands for more than 255.
    if length / 255 > block.len() {
        return Err(cut_off());
    }
    lz4_flex::block::decompress(block, length).map_err(io::Error::other)
}

/// Everything that comes out of a decoder.
pub(super) fn read(decoder: impl Read, max_bytes: usize) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    Polled::new(decoder).take(max_bytes as u64 + 1).read_to_end(&mut out)?;
    if out.len() > max_bytes { Err(too_long(max_bytes)) } else { Ok(out) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decoding_ends_where_the_work_is_cancelled() {
        let control = vr_core::Control::default();
        control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        // A frame of Zstandard of one raw block: magic, descriptor, window, header of the last block, its bytes.
        let frame = [0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x58, 0x19, 0x00, 0x00, b'a', b'b', b'c'];
        assert_eq!(zstd(&frame, 3).unwrap(), b"abc");
        assert_eq!(control.cancellable(|| zstd(&frame, 3).unwrap_err().to_string()).unwrap(), "cancelled");
    }
}
