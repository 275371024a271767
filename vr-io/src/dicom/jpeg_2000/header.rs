//! Claims of a code stream on memory, checked before it is decoded (ITU-T T.800, annex A).

use std::io;

use super::super::coded_frame::CodedFrame;
use crate::encoding::invalid;

const START_OF_CODE: u16 = 0xff4f;
const SIZE: u16 = 0xff51;
const CODING_STYLE: u16 = 0xff52;
const COMPONENT_CODING_STYLE: u16 = 0xff53;
const START_OF_TILE_PART: u16 = 0xff90;
const START_OF_DATA: u16 = 0xff93;
const END_OF_CODE: u16 = 0xffd9;

/// Numbers of a picture whose room is granted for any code: 2048² of one component. Flat pictures of them need hardly a byte.
const FREE: u64 = 1 << 22;
/// Numbers that each byte of code grants beyond.
const MAX_EXPANSION: u64 = 2048;
/// Least bytes of a tile: the markers of its part.
const TILE_BYTES: u64 = 14;

/// Kind of the picture in a code stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Header {
    pub frame: CodedFrame,
    pub signed: bool,
}

/// Finds the code stream, which DICOM has bare, and some writers in a JP2 file.
pub(super) fn code_stream(coded: &[u8]) -> io::Result<&[u8]> {
    let missing = || invalid("no code stream of JPEG 2000".into());
    let mut rest = coded;
    while word(rest, 0) != Some(START_OF_CODE) {
        // A box: its length, its type, and a longer length where the first is 1.
        let length = long(rest, 0).ok_or_else(missing)?;
        let (length, head) = match length {
            0 => (rest.len() as u64, 8),
            1 => (
                u64::from(long(rest, 8).ok_or_else(missing)?) << 32 | u64::from(long(rest, 12).ok_or_else(missing)?),
                16,
            ),
            _ => (length.into(), 8),
        };
        let end = usize::try_from(length).ok().filter(|&end| end >= head && end <= rest.len()).ok_or_else(missing)?;
        rest = if rest.get(4..8) == Some(b"jp2c") { &rest[head..end] } else { &rest[end..] };
    }
    Ok(rest)
}

impl Header {
    /// Reads the size of the frame and holds all that takes memory against it and against the bytes that are there.
    pub fn read(code: &[u8]) -> io::Result<Self> {
        let mut segments = Segments { code, at: 2 };
        let (header, tiles) = match segments.next()? {
            (SIZE, segment) => size(segment).ok_or_else(|| invalid("sizes (SIZ) that do not hold together".into()))?,
            _ => return Err(invalid("no sizes (SIZ) at the start of the code".into())),
        };
        let CodedFrame { columns, rows, samples, bits } = header.frame;
        // Sizes have 32 bits.
        let numbers = (columns as u64).saturating_mul(rows as u64).saturating_mul(samples as u64);
        let bytes = code.len() as u64;
        if numbers > FREE.max(bytes.saturating_mul(MAX_EXPANSION)) || tiles.saturating_mul(TILE_BYTES) > bytes {
            return Err(invalid(format!(
                "{bytes} bytes for {columns}x{rows} pixels of {samples} samples in {tiles} tiles"
            )));
        }
        if !(1..=16).contains(&bits) {
            return Err(invalid(format!("{bits} bits a number, not 1 to 16")));
        }

        // Blocks may be as small as a number, and each has a record for every layer. Bytes of both in the decoder, roughly:
        const BLOCK: u64 = 256;
        const LAYER: u64 = 24;
        let mut layers = 1;
        let mut blocks = 0;
        for (marker, segment) in segments.styles()? {
            let style = match marker {
                CODING_STYLE => {
                    layers = layers.max(word(segment, 2).unwrap_or(0).into());
                    segment.get(5..)
                }
                _ => segment.get(2..),
            };
            let style =
                style.and_then(|style| count_blocks(style, segment_has_precincts(marker, segment), header.frame));
            let wrong = || invalid("coding styles (COD, COC) that do not hold together".into());
            blocks = blocks.max(style.ok_or_else(wrong)?);
        }
        if blocks.saturating_mul(BLOCK + LAYER * layers) > 16 * (FREE + 4 * numbers) {
            return Err(invalid(format!("{blocks} blocks in {layers} layers for {columns}x{rows} pixels")));
        }
        Ok(header)
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|b| u16::from_be_bytes(*b))
}

fn long(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|b| u32::from_be_bytes(*b))
}

/// Size and number of tiles; all components must be alike.
fn size(segment: &[u8]) -> Option<(Header, u64)> {
    let axis = |i: usize| {
        let [end, start, tile, first] = [2, 10, 18, 26].map(|at| long(segment, at + 4 * i));
        let length = end?.checked_sub(start?).filter(|&length| length > 0)?;
        let tiles = end?.checked_sub(first?)?.div_ceil(tile.filter(|&tile| tile > 0)?);
        Some((length as usize, u64::from(tiles)))
    };
    let ((columns, across), (rows, down)) = (axis(0)?, axis(1)?);
    let samples = usize::from(word(segment, 34)?);
    let components = segment.get(36..)?.as_chunks::<3>().0.get(..samples)?;
    let first = components.first()?;
    let alike = components.iter().all(|c| c == first && c[1..] == [1, 1]);
    let bits = u32::from(first[0] & 0x7f) + 1;
    let frame = CodedFrame { columns, rows, samples, bits };
    alike.then_some((Header { frame, signed: first[0] >= 0x80 }, across * down))
}

/// True if the sizes of precincts follow.
fn segment_has_precincts(marker: u16, segment: &[u8]) -> bool {
    let flags = segment.get(if marker == CODING_STYLE { 0 } else { 1 });
    flags.is_some_and(|flags| flags & 1 == 1)
}

/// Blocks of all components, at most: resolution by resolution, the smaller of the block and the part of the precinct in a band (B.7).
fn count_blocks(style: &[u8], has_precincts: bool, frame: CodedFrame) -> Option<u64> {
    let &[levels, width, height, _, _, ref precincts @ ..] = style else { return None };
    if levels > 32 || width > 8 || height > 8 {
        return None;
    }
    let mut blocks = 0;
    for resolution in 0..=levels {
        let precinct = if has_precincts { *precincts.get(usize::from(resolution))? } else { 0xff };
        let band = u8::from(resolution > 0);
        // A precinct of one number has no room for three bands.
        let across = (width + 2).min((precinct & 15).checked_sub(band)?);
        let down = (height + 2).min((precinct >> 4).checked_sub(band)?);
        let shrunk = |length: usize| length as u64 >> (levels - resolution);
        // Bands of all but the first have half the length; blocks at both ends may be cut.
        let along = |length: usize, block: u8| (shrunk(length) >> block >> band) + 2;
        let bands = if resolution == 0 { 1 } else { 3 };
        blocks += bands * along(frame.columns, across) * along(frame.rows, down);
    }
    Some(blocks * frame.samples as u64)
}

/// Marker segments of the main header and of the tile-parts.
struct Segments<'a> {
    code: &'a [u8],
    at: usize,
}

impl<'a> Segments<'a> {
    /// The next marker and its segment.
    fn next(&mut self) -> io::Result<(u16, &'a [u8])> {
        let damaged = || invalid(format!("no marker segment at byte {} of the code", self.at));
        let marker = word(self.code, self.at).filter(|&marker| marker >= 0xff01).ok_or_else(damaged)?;
        if matches!(marker, 0xff30..=0xff3f | START_OF_DATA | END_OF_CODE) {
            self.at += 2;
            return Ok((marker, &[]));
        }
        let length = word(self.code, self.at + 2).ok_or_else(damaged)?;
        let end = self.at + 2 + usize::from(length);
        let segment = self.code.get(self.at + 4..end).ok_or_else(damaged)?;
        self.at = end;
        Ok((marker, segment))
    }

    /// All that say how blocks are coded.
    fn styles(mut self) -> io::Result<Vec<(u16, &'a [u8])>> {
        let mut styles = Vec::new();
        let mut part_end = None;
        while self.at < self.code.len() {
            let start = self.at;
            let (marker, segment) = self.next()?;
            match marker {
                CODING_STYLE | COMPONENT_CODING_STYLE => styles.push((marker, segment)),
                START_OF_TILE_PART => {
                    let length =
                        long(segment, 2).ok_or_else(|| invalid("a tile-part (SOT) without a length".into()))?;
                    part_end = Some(if length == 0 { self.code.len() } else { start.saturating_add(length as usize) });
                }
                START_OF_DATA => match part_end.take().filter(|&end| end >= self.at) {
                    Some(end) => self.at = end,
                    None => return Err(invalid("data (SOD) outside a tile-part".into())),
                },
                END_OF_CODE => break,
                _ => {}
            }
        }
        Ok(styles)
    }
}
