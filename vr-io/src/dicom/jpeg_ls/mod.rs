//! JPEG-LS, without loss and near to it, of 2 to 16 bits (DICOM PS3.5 2024, annex A.4.3; ITU-T T.87; Weinberger, Seroussi and Sapiro 2000,
//! "The LOCO-I lossless image compression algorithm").

mod bits;
mod contexts;
mod header;
mod lines;
#[cfg(test)]
mod tests;

use std::io;

use super::coded_frame::pack;
use super::image::Shape;
use crate::encoding::invalid;

use bits::Bits;
use contexts::Contexts;
use header::{Interleave, Markers, Scan};
use lines::{LinePair, decode_line};

/// Decodes a frame: little endian, the numbers of a pixel together.
pub(super) fn decode(coded: &[u8], shape: &Shape) -> io::Result<Vec<u8>> {
    let mut markers = Markers::new(coded)?;
    let mut header = markers.frame()?;
    let frame = header.frame;
    frame.check(shape)?;
    // Every line has a bit at least, so that memory stays in proportion to lines that are there.
    if frame.rows > coded.len().saturating_mul(8) {
        return Err(invalid(format!("{} bytes for {} lines", coded.len(), frame.rows)));
    }
    let mut planes = vec![Vec::new(); frame.samples];
    while planes.iter().any(Vec::is_empty) {
        let scan = markers.scan(&mut header)?.ok_or_else(|| invalid("no scan of a component".into()))?;
        if scan.components.iter().any(|&c| !planes[c].is_empty()) {
            return Err(invalid("two scans of a component".into()));
        }
        let mut bits = Bits::new(markers.rest);
        let decode = match (scan.interleave, scan.components.len()) {
            (Interleave::Line, _) => by_lines,
            (Interleave::Pixel, 2) => by_pixels::<2>,
            (Interleave::Pixel, 3) => by_pixels::<3>,
            (Interleave::Pixel, _) => by_pixels::<4>,
        };
        decode(&scan, frame.columns, frame.rows, &mut bits, &mut planes)
            .ok_or_else(|| invalid("a scan ends early, or is damaged".into()))?;
        markers.skip_bits();
    }
    let planes: Vec<&[u16]> = planes.iter().map(Vec::as_slice).collect();
    Ok(pack(&planes, i32::from, frame.bits, shape.numbers.scalar))
}

fn append(plane: &mut Vec<u16>, line: &LinePair) {
    // Numbers lie between 0 and a maximum of 16 bits.
    plane.extend(line.numbers().iter().map(|&x| x as u16));
}

/// A component, or several that share the model and have runs of their own.
fn by_lines(scan: &Scan, width: usize, rows: usize, bits: &mut Bits<'_>, planes: &mut [Vec<u16>]) -> Option<()> {
    let mut contexts = Contexts::new(scan.parameters);
    let mut lines: Vec<_> = scan.components.iter().map(|&c| (c, [LinePair::new(width)], 0)).collect();
    for _ in 0..rows {
        for (component, line, run_index) in &mut lines {
            decode_line(line, &mut contexts, bits, run_index)?;
            append(&mut planes[*component], &line[0]);
        }
    }
    Some(())
}

/// Components with the numbers of a pixel together, which are in a run together.
fn by_pixels<const N: usize>(
    scan: &Scan,
    width: usize,
    rows: usize,
    bits: &mut Bits<'_>,
    planes: &mut [Vec<u16>],
) -> Option<()> {
    let mut contexts = Contexts::new(scan.parameters);
    let mut lines: [LinePair; N] = std::array::from_fn(|_| LinePair::new(width));
    let mut run_index = 0;
    for _ in 0..rows {
        decode_line(&mut lines, &mut contexts, bits, &mut run_index)?;
        for (&component, line) in scan.components.iter().zip(&lines) {
            append(&mut planes[component], line);
        }
    }
    Some(())
}
