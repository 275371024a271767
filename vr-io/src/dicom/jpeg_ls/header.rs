//! Marker segments before the scans (ITU-T T.87, annex C).

use std::io;

use super::super::coded_frame::CodedFrame;
use super::contexts::Parameters;
use crate::encoding::invalid;

/// Statements that hold for the scans which follow.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub frame: CodedFrame,
    /// Names of the components, in their order.
    names: Vec<u8>,
    /// Largest number, thresholds and halving of statistics, 0 for their defaults.
    preset: [u16; 5],
}

/// A scan: which components, and how.
#[derive(Clone, Debug)]
pub(super) struct Scan {
    /// Indices of its components.
    pub components: Vec<usize>,
    pub interleave: Interleave,
    pub parameters: Parameters,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Interleave {
    /// One component, or a line of each in turn.
    Line,
    /// The numbers of a pixel together.
    Pixel,
}

const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;
const RESTART_INTERVAL: u8 = 0xdd;
const APPLICATION_8: u8 = 0xe8;
const START_OF_FRAME: u8 = 0xf7;
const PRESET: u8 = 0xf8;

/// Markers in the bytes of a frame.
pub(super) struct Markers<'a> {
    /// From the next marker on.
    pub rest: &'a [u8],
}

impl<'a> Markers<'a> {
    pub fn new(coded: &'a [u8]) -> io::Result<Self> {
        match coded {
            [0xff, START_OF_IMAGE, rest @ ..] => Ok(Self { rest }),
            _ => Err(invalid("no JPEG-LS picture: the marker SOI must come first".into())),
        }
    }

    /// The next marker and its segment; none follows the end of the image.
    fn next(&mut self) -> io::Result<(u8, &'a [u8])> {
        let cut_off = || invalid("the markers end early".into());
        // Any number of 0xFF may stand before a marker.
        let fill = self.rest.iter().take_while(|&&b| b == 0xff).count();
        let (&marker, rest) = self.rest[fill..].split_first().filter(|_| fill > 0).ok_or_else(cut_off)?;
        if marker == END_OF_IMAGE {
            return Ok((marker, &[]));
        }
        let length = rest.first_chunk().map(|b| usize::from(u16::from_be_bytes(*b))).ok_or_else(cut_off)?;
        let segment = rest.get(2..length).ok_or_else(cut_off)?;
        self.rest = &rest[length..];
        Ok((marker, segment))
    }

    /// Reads up to the frame's header, which comes before all scans.
    pub fn frame(&mut self) -> io::Result<Header> {
        let mut preset = [0; 5];
        loop {
            let (marker, segment) = self.next()?;
            match marker {
                START_OF_FRAME => {
                    let (frame, names) = start_of_frame(segment)?;
                    return Ok(Header { frame, names, preset });
                }
                START_OF_SCAN | END_OF_IMAGE => return Err(invalid("no header of a JPEG-LS frame (SOF55)".into())),
                0xc0..=0xcf => return Err(invalid("JPEG of another kind, not JPEG-LS".into())),
                _ => other(marker, segment, &mut preset)?,
            }
        }
    }

    /// Reads up to the next scan, of which the bits follow; `None` at the end of the image.
    pub fn scan(&mut self, header: &mut Header) -> io::Result<Option<Scan>> {
        loop {
            let (marker, segment) = self.next()?;
            match marker {
                END_OF_IMAGE => return Ok(None),
                START_OF_SCAN => return start_of_scan(segment, header).map(Some),
                _ => other(marker, segment, &mut header.preset)?,
            }
        }
    }

    /// Goes on behind the bits of a scan: at the next marker, which no bits look like.
    pub fn skip_bits(&mut self) {
        let marker = self.rest.windows(2).position(|pair| pair[0] == 0xff && pair[1] >= 0x80);
        self.rest = &self.rest[marker.unwrap_or(self.rest.len())..];
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|b| u16::from_be_bytes(*b))
}

fn start_of_frame(segment: &[u8]) -> io::Result<(CodedFrame, Vec<u8>)> {
    let cut_off = || invalid("the header of the frame (SOF55) is too short".into());
    let rows = word(segment, 1).ok_or_else(cut_off)?;
    let columns = word(segment, 3).ok_or_else(cut_off)?;
    let components = segment.get(6..).ok_or_else(cut_off)?.as_chunks::<3>().0;
    let (bits, count) = (segment[0], usize::from(segment[5]));
    let components = components.get(..count).filter(|c| !c.is_empty()).ok_or_else(cut_off)?;
    if !(2..=16).contains(&bits) {
        return Err(invalid(format!("{bits} bits a number, not 2 to 16")));
    }
    if components.iter().any(|[_, factors, _]| *factors != components[0][1]) {
        return Err(invalid("components of several sizes are not read".into()));
    }
    let frame = CodedFrame { columns: columns.into(), rows: rows.into(), samples: components.len(), bits: bits.into() };
    Ok((frame, components.iter().map(|[name, ..]| *name).collect()))
}

/// Takes presets, passes comments over, and refuses what would alter the numbers.
fn other(marker: u8, segment: &[u8], preset: &mut [u16; 5]) -> io::Result<()> {
    match (marker, segment) {
        (PRESET, [1, values @ ..]) => {
            let values = values.as_chunks().0.first_chunk::<5>();
            let values = values.ok_or_else(|| invalid("presets (LSE) that end early".into()))?;
            *preset = values.map(u16::from_be_bytes);
            Ok(())
        }
        (PRESET, _) => Err(invalid("mapping tables and sizes beyond 16 bits (LSE) are not read".into())),
        (RESTART_INTERVAL, segment) if segment.iter().any(|&b| b != 0) => {
            Err(invalid("restart intervals (DRI) are not read".into()))
        }
        // Not of the standard, and not DICOM's.
        (APPLICATION_8, [b'm', b'r', b'f', b'x', transform, ..]) if *transform != 0 => {
            Err(invalid("colours that were transformed (mrfx) are not read".into()))
        }
        _ => Ok(()),
    }
}

fn start_of_scan(segment: &[u8], header: &Header) -> io::Result<Scan> {
    let cut_off = || invalid("the header of a scan (SOS) is too short".into());
    let (&count, rest) = segment.split_first().ok_or_else(cut_off)?;
    let (selected, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or_else(cut_off)?;
    let &[near, interleave, shift, ..] = rest else { return Err(cut_off()) };
    let mut components = Vec::new();
    for [name, table] in selected.as_chunks().0 {
        let index = header.names.iter().position(|n| n == name);
        let index = index.filter(|i| *table == 0 && !components.contains(i));
        components.push(index.ok_or_else(|| invalid(format!("a scan of component {name}, which is not there")))?);
    }
    let interleave = match (components.len(), interleave) {
        (1, 0..=2) | (2.., 1) => Interleave::Line,
        (2..=4, 2) => Interleave::Pixel,
        (n, mode) => return Err(invalid(format!("a scan of {n} components with interleave mode {mode}"))),
    };
    if shift != 0 {
        return Err(invalid("numbers without their lower bits (a point transform) are not read".into()));
    }
    let parameters = parameters(header.preset, header.frame.bits, near.into())?;
    Ok(Scan { components, interleave, parameters })
}

/// Presets where there are, else defaults (C.2.4.1.1).
fn parameters([max, t1, t2, t3, reset]: [u16; 5], bits: u32, near: i32) -> io::Result<Parameters> {
    let or = |preset: u16, default: i32| if preset == 0 { default } else { preset.into() };
    let most = (1 << bits) - 1;
    let max = or(max, most);
    if max > most || near > 255.min(max / 2) {
        return Err(invalid(format!("numbers up to {max} with errors up to {near}, in {bits} bits")));
    }
    let defaults = Parameters::default_thresholds(max, near);
    let thresholds = [or(t1, defaults[0]), or(t2, defaults[1]), or(t3, defaults[2])];
    let reset = or(reset, 64).cast_unsigned();
    if ![near + 1, thresholds[0], thresholds[1], thresholds[2], max].is_sorted() || reset < 3 {
        return Err(invalid(format!("thresholds {thresholds:?} of numbers up to {max}, statistics halved at {reset}")));
    }
    Ok(Parameters { max, near, thresholds, reset })
}
