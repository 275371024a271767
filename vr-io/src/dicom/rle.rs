//! RLE Lossless: a run of PackBits for each byte of the numbers, the highest first (DICOM PS3.5 2024, annex G).

use std::io;

use crate::encoding::invalid;

/// Bytes of the header: the number of segments, and the offsets of up to 15.
const HEADER: usize = 64;

/// Decodes a frame of `pixels` pixels of `samples` numbers of `bytes` bytes: little endian, the numbers of a pixel together.
pub(super) fn decode(coded: &[u8], pixels: usize, samples: usize, bytes: usize) -> io::Result<Vec<u8>> {
    let planes = samples * bytes;
    let word = |i: usize| coded.get(4 * i..).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b) as usize);
    let count = word(0).filter(|_| coded.len() >= HEADER).ok_or_else(|| invalid("no header of 64 bytes".into()))?;
    if count != planes {
        return Err(invalid(format!("{count} segments, not {planes} (samples times bytes)")));
    }
    let mut decoded = Vec::new();
    for plane in 0..planes {
        let start = word(plane + 1).unwrap_or(0);
        let end = if plane + 1 < planes { word(plane + 2).unwrap_or(0) } else { coded.len() };
        let segment = coded.get(start..end).filter(|_| start >= HEADER);
        let segment = segment.ok_or_else(|| invalid(format!("segment {plane} lies outside the frame")))?;
        decoded.push(unpack(segment, pixels)?);
    }
    // Only now, when all bytes came out, there is room for as many.
    let mut out = vec![0; pixels * planes];
    for (plane, values) in decoded.iter().enumerate() {
        let (sample, from_top) = (plane / bytes, plane % bytes);
        let at = sample * bytes + bytes - 1 - from_top;
        out.iter_mut().skip(at).step_by(planes).zip(values).for_each(|(to, &from)| *to = from);
    }
    Ok(out)
}

/// Unpacks `count` bytes: n literal bytes after n − 1, a byte n times after 257 − n.
fn unpack(mut packed: &[u8], count: usize) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    while out.len() < count {
        let Some((&control, rest)) = packed.split_first() else {
            return Err(invalid(format!("{} of {count} bytes in a segment", out.len())));
        };
        let used = match control {
            0..128 => {
                let n = usize::from(control) + 1;
                out.extend_from_slice(rest.get(..n).ok_or_else(|| invalid("a segment ends within a run".into()))?);
                n
            }
            // Nothing, by the standard.
            128 => 0,
            129.. => {
                let &value = rest.first().ok_or_else(|| invalid("a segment ends within a run".into()))?;
                out.resize(out.len() + 257 - usize::from(control), value);
                1
            }
        };
        packed = &rest[used..];
    }
    // Rows need not end with runs.
    out.truncate(count);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(segments: &[&[u8]]) -> Vec<u8> {
        let mut header = vec![0u8; HEADER];
        header[..4].copy_from_slice(&(segments.len() as u32).to_le_bytes());
        let mut offset = HEADER;
        for (i, segment) in segments.iter().enumerate() {
            header[4 * i + 4..4 * i + 8].copy_from_slice(&(offset as u32).to_le_bytes());
            offset += segment.len();
        }
        [header, segments.concat()].concat()
    }

    #[test]
    fn the_highest_byte_comes_first() {
        let coded = frame(&[&[0xfe, 1], &[1, 2, 3, 128, 0, 4]]);
        assert_eq!(decode(&coded, 3, 1, 2).unwrap(), [2, 1, 3, 1, 4, 1]);
        let colours = frame(&[&[1, 1, 2], &[1, 3, 4], &[1, 5, 6]]);
        assert_eq!(decode(&colours, 2, 3, 1).unwrap(), [1, 3, 5, 2, 4, 6]);
    }

    #[test]
    fn damage_is_noticed() {
        let good = frame(&[&[0xfe, 1]]);
        assert_eq!(decode(&good, 3, 1, 1).unwrap(), [1, 1, 1]);
        for cut in 0..good.len() {
            assert!(decode(&good[..cut], 3, 1, 1).is_err(), "{cut}");
        }
        assert!(decode(&good, 4, 1, 1).is_err());
        assert!(decode(&good, 3, 1, 2).is_err());
        assert!(decode(&frame(&[&[5, 1]]), 6, 1, 1).is_err());
        let mut outside = good;
        outside[4] = 63;
        assert!(decode(&outside, 3, 1, 1).is_err());
    }
}
