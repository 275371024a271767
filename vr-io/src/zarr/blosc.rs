//! Chunks of Blosc 1 (<https://github.com/Blosc/c-blosc>, README_CHUNK_FORMAT.rst): blocks of which the bytes, or the bits, of the numbers
//! were sorted by significance before another coding packed them.
//!
//! LZ4, zlib and Zstandard are read; BloscLZ and Snappy are refused.

use std::io;

use crate::encoding::{Encoding, invalid};

use super::codec::{cut_off, lz4_block, read, zstd};

const HEADER: usize = 16;
/// Bits of the third byte.
const BYTES_SORTED: u8 = 0x1;
const STORED: u8 = 0x2;
const BITS_SORTED: u8 = 0x4;
const NOT_SPLIT: u8 = 0x10;

/// The bytes of a chunk; more than `max_bytes` is an error.
pub(crate) fn decode(chunk: &[u8], max_bytes: usize) -> io::Result<Vec<u8>> {
    let (header, data) = chunk.split_first_chunk::<HEADER>().ok_or_else(cut_off)?;
    let flags = header[2];
    let number = usize::from(header[3]).max(1);
    let (total, block) = (size_at(chunk, 4)?, size_at(chunk, 8)?);
    if total > max_bytes {
        return Err(invalid(format!("Blosc's header says {total} bytes, more than the {max_bytes} of a chunk")));
    }
    if flags & STORED != 0 {
        return data.get(..total).map(<[u8]>::to_vec).ok_or_else(cut_off);
    }
    if total == 0 {
        return Ok(Vec::new());
    }
    if block == 0 {
        return Err(invalid("Blosc's header says blocks of 0 bytes".into()));
    }
    let mut out = Vec::new();
    for i in 0..total.div_ceil(block) {
        let length = block.min(total - i * block);
        let start = size_at(chunk, HEADER + 4 * i)?;
        let sorted = unpack_block(chunk.get(start..).ok_or_else(cut_off)?, flags, length, length == block, number)?;
        if flags & BYTES_SORTED != 0 && number > 1 {
            unsort_bytes(&sorted, number, &mut out);
        } else if flags & BITS_SORTED != 0 && length >= number && (length / number).is_multiple_of(8) {
            unsort_bits(&sorted, number, &mut out);
        } else {
            out.extend(sorted);
        }
    }
    Ok(out)
}

/// A block of `length` bytes: whole, or one part for each byte of a number.
fn unpack_block(mut packed: &[u8], flags: u8, length: usize, is_full: bool, number: usize) -> io::Result<Vec<u8>> {
    let parts = if flags & NOT_SPLIT == 0 && is_full && length.is_multiple_of(number) { number } else { 1 };
    let part_length = length / parts;
    let mut out = Vec::new();
    for _ in 0..parts {
        let size = size_at(packed, 0)?;
        let part = packed.get(4..).and_then(|p| p.get(..size)).ok_or_else(cut_off)?;
        packed = &packed[4 + size..];
        if size == part_length {
            out.extend_from_slice(part);
            continue;
        }
        let unpacked = match flags >> 5 {
            1 => lz4_block(part, part_length, part_length)?,
            3 => read(Encoding::Zlib.reader(part), part_length)?,
            4 => zstd(part, part_length)?,
            other => {
                let name = ["BloscLZ", "", "Snappy"].get(usize::from(other)).unwrap_or(&"an unknown coding");
                return Err(invalid(format!("Blosc with {name} is not read; LZ4, zlib and Zstandard are")));
            }
        };
        if unpacked.len() != part_length {
            return Err(cut_off());
        }
        out.extend(unpacked);
    }
    Ok(out)
}

fn size_at(bytes: &[u8], at: usize) -> io::Result<usize> {
    let four = bytes.get(at..).and_then(<[u8]>::first_chunk).ok_or_else(cut_off)?;
    let size = i32::from_le_bytes(*four);
    usize::try_from(size).map_err(|_| invalid(format!("Blosc's header says a length of {size}")))
}

/// First all first bytes of the numbers, then all second ones; what makes no number is behind.
fn unsort_bytes(sorted: &[u8], number: usize, out: &mut Vec<u8>) {
    let count = sorted.len() / number;
    let start = out.len();
    out.resize(start + count * number, 0);
    if count > 0 {
        for (byte, run) in sorted[..count * number].chunks_exact(count).enumerate() {
            for (i, &value) in run.iter().enumerate() {
                out[start + i * number + byte] = value;
            }
        }
    }
    out.extend_from_slice(&sorted[count * number..]);
}

/// First the lowest bits of the first bytes of all numbers, eight numbers to a byte; what makes no number is behind.
fn unsort_bits(sorted: &[u8], number: usize, out: &mut Vec<u8>) {
    let count = sorted.len() / number;
    let start = out.len();
    out.resize(start + count * number, 0);
    if count > 0 {
        for (plane, run) in sorted[..count * number].chunks_exact(count / 8).enumerate() {
            let (byte, bit) = (plane / 8, plane % 8);
            for (i, &eight) in run.iter().enumerate() {
                for k in 0..8 {
                    out[start + (8 * i + k) * number + byte] |= (eight >> k & 1) << bit;
                }
            }
        }
    }
    out.extend_from_slice(&sorted[count * number..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chunk of one block.
    fn chunk(flags: u8, number: u8, total: usize, packed: &[u8]) -> Vec<u8> {
        let mut out = vec![2, 1, flags, number];
        for size in [total, total, HEADER + 4 + packed.len(), HEADER + 4] {
            out.extend((size as i32).to_le_bytes());
        }
        out.extend(packed);
        out
    }

    fn part(bytes: &[u8]) -> Vec<u8> {
        [&(bytes.len() as i32).to_le_bytes(), bytes].concat()
    }

    #[test]
    fn bytes_are_put_back_beside_each_other() {
        // Of 1, 258, 3 in 16 bits, in two parts; none of them was worth packing.
        let packed = [part(&[1, 2, 3]), part(&[0, 1, 0])].concat();
        assert_eq!(decode(&chunk(0x20 | BYTES_SORTED, 2, 6, &packed), 6).unwrap(), [1, 0, 2, 1, 3, 0]);
    }

    #[test]
    fn bits_are_put_back_beside_each_other() {
        // Eight numbers of one byte; bit 0 is set in the first, bit 7 in the last.
        let planes = [1, 0, 0, 0, 0, 0, 0, 0x80];
        let block = chunk(0x20 | BITS_SORTED | NOT_SPLIT, 1, 8, &part(&planes));
        assert_eq!(decode(&block, 8).unwrap(), [1, 0, 0, 0, 0, 0, 0, 0x80]);
    }

    #[test]
    fn a_block_of_lz4() {
        let bytes: Vec<u8> = (0..200).map(|i| i / 50).collect();
        let packed = part(&lz4_flex::block::compress(&bytes));
        let good = chunk(0x20 | NOT_SPLIT, 1, 200, &packed);
        assert_eq!(decode(&good, 200).unwrap(), bytes);
        for length in 0..good.len() {
            assert!(decode(&good[..length], 200).is_err(), "{length}");
        }
        assert!(decode(&good, 199).unwrap_err().to_string().contains("200 bytes, more than the 199"));
        let blosclz = chunk(NOT_SPLIT, 1, 200, &packed);
        assert!(decode(&blosclz, 200).unwrap_err().to_string().contains("BloscLZ is not read"));
        let mut negative = good;
        negative[8..12].copy_from_slice(&(-1i32).to_le_bytes());
        assert!(decode(&negative, 200).is_err());
    }
}
