//! Stacks of pictures in one TIFF file: TIFF 6.0 (Aldus, 1992) and BigTIFF (2007).
//!
//! A page is a slice. What else a stack means is said in the ImageDescription of its first page: by ImageJ as lines of `key=value`, by
//! OME-TIFF (Goldberg et al., Genome Biology 6, 2005) as XML. Both name channels (components), slices and times (frames), and the distance
//! between slices, of which TIFF itself knows nothing.

mod arrangement;
mod decode;
pub(crate) mod first_directory;
mod page;
mod pixels;
#[cfg(test)]
mod tests;

use std::io::{self, BufReader};
use std::path::Path;

use tiff::decoder::{Decoder, Limits};
use tiff::tags::{ByteOrder, Tag};
use tiff::{TiffError, TiffResult};
use vr_core::Placement;

use crate::claim::check_claim;
use crate::error::{FieldError, FileError, FileErrorKind};
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
use crate::payload::Payload;
use crate::read::{Description, ReadOptions};
use crate::regular_file::{self, RegularFile};
use crate::scalar::Endian;
use crate::source::{Decoded, Source};
use crate::world::Space;

use arrangement::Arrangement;
pub(crate) use arrangement::{Spacing, spacing_notes};
pub(crate) use decode::decode_page;
pub(crate) use page::{Page, first_page};

/// Most pages of a file; one that has more is wrong.
const MAX_PAGES: usize = 1 << 20;

pub(crate) type TiffFile = Decoder<BufReader<RegularFile>>;

/// Opens a file at its first page; `page_bytes` are those of a page to decode, or 0 where headers alone are read.
pub(crate) fn open(path: &Path, page_bytes: usize) -> Result<TiffFile, FileError> {
    let mut file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
    first_directory::check(path, &mut file)?;
    let length = file.length().map_err(|e| FileError::new(path, e))?;
    let decoder = Decoder::new(BufReader::new(file)).map_err(|e| refuse(path, e))?;
    let mut limits = Limits::default();
    // Descriptions in XML and tables of strips may be long, but not longer than the file.
    limits.ifd_value_size = usize::try_from(length).unwrap_or(usize::MAX);
    limits.intermediate_buffer_size = limits.ifd_value_size.max(1 << 20);
    // The decoder holds a value of a table in 32 bytes, of which the file has two at least.
    limits.decoding_buffer_size = limits.ifd_value_size.saturating_mul(16).max(1 << 20).max(page_bytes);
    Ok(decoder.with_limits(limits))
}

/// An error of the decoder, as one of ours.
pub(crate) fn refuse(path: &Path, error: TiffError) -> FileError {
    match error {
        TiffError::IoError(e) if e.kind() != io::ErrorKind::UnexpectedEof => FileError::new(path, e),
        TiffError::UnsupportedError(e) => {
            let allowed =
                "must be what is read here: uncompressed, PackBits, LZW, Deflate, JPEG or fax, of 8 to 64 bits";
            FieldError::new("TIFF", e, allowed).in_file(path)
        }
        e => FileError::new(path, FileErrorKind::Damaged { encoding: "TIFF", source: io::Error::other(e) }),
    }
}

/// Everything that the pages' headers say.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let mut file = open(path, 0)?;
    let mut notes = Notes::default();
    let (pages, text) = read_pages(path, &mut file, &mut notes)?;
    let first = &pages[0];
    let resolution = first.resolution.clone();
    let length = crate::memory_folder::length(path).map_err(|e| FileError::new(path, e))?;

    let mut arrangement = Arrangement::read(path, text.as_deref(), first, &mut notes)?;
    let contiguous = first.start.filter(|&start| {
        pages
            .iter()
            .zip(0..)
            .all(|(page, i)| page.start == first.page_bytes().checked_mul(i).and_then(|n| start.checked_add(n)))
    });
    let wanted = arrangement.pages();
    // ImageJ writes one directory where the file is long, and all pages one after another behind it.
    let behind_one = arrangement.is_imagej && pages.len() == 1 && contiguous.is_some();
    if wanted != Some(pages.len()) && !behind_one {
        if let Some(wanted) = wanted {
            let n = pages.len();
            notes.push(format!(
                "{} names {wanted} pages and the file has {n}: they are taken as slices",
                arrangement.by
            ));
        }
        arrangement.axes = vec![(pages.len(), Role::Space)];
    }
    arrangement.mend(&mut notes);

    let axes = page_axes(first, &arrangement.axes);
    let layout = Layout::new(path, &axes, options)?;
    first.note(&mut notes);
    let endian = match file.byte_order() {
        ByteOrder::LittleEndian => Endian::Little,
        ByteOrder::BigEndian => Endian::Big,
    };
    let (source, layout): (Source, Layout) = match contiguous {
        Some(start) => {
            let payload = Payload::part(path, start, first.scalar, endian);
            (payload.into(), layout)
        }
        None => {
            let bytes = (layout.count() as u64).saturating_mul(first.scalar.bytes() as u64);
            check_claim(path, "size of the pages", bytes.max(first.page_bytes()), length)?;
            let job = decode::Stack::new(path, &pages, &layout);
            let decoded = Decoded {
                decode: Box::new(move |_| job.decode()),
                scalar: first.scalar,
                endian: Endian::NATIVE,
                encoding: first.compression,
                files: vec![path.into()],
            };
            (decoded.into(), layout.dense())
        }
    };
    let spacing = arrangement.spacing.or(resolution);
    let (spacing, units, placed_by) = spacing_notes(spacing, "TIFF", &mut notes);
    let placement = Placement::from_spacing(spacing).map_err(|e| FileError::new(path, e))?;
    Ok(Description {
        format: if arrangement.is_ome { "OME-TIFF" } else { "TIFF" },
        header: path.into(),
        source,
        layout,
        placement,
        placed_by,
        calibration: arrangement.calibration.unwrap_or_default(),
        space: Space::Own,
        units,
        scan: None,
        notes,
    })
}

/// Axes of the numbers, fastest first.
fn page_axes(page: &Page, stack: &[(usize, Role)]) -> Vec<Axis> {
    let samples = Axis { size: page.samples, role: if page.is_color { Role::Color } else { Role::Component } };
    let plane = page.size.map(|size| Axis { size, role: Role::Space });
    let mut axes = if page.planar { vec![plane[0], plane[1], samples] } else { vec![samples, plane[0], plane[1]] };
    axes.extend(stack.iter().map(|&(size, role)| Axis { size, role }));
    axes
}

/// The pages of a file that are like the first one, and the text that describes them; the others are left out with a note.
fn read_pages(
    path: &Path,
    file: &mut TiffFile,
    notes: &mut Vec<String>,
) -> Result<(Vec<Page>, Option<String>), FileError> {
    let text = page::description(file).map_err(|e| refuse(path, e))?;
    let mut pages: Vec<Page> = Vec::new();
    let (mut others, mut first_other) = (0, String::new());
    for index in 0..MAX_PAGES {
        if index > 0 {
            file.next_image().map_err(|e| refuse(path, e))?;
        }
        // A page that is no slice may be of a kind that is not read.
        let reduced = !pages.is_empty() && is_reduced(file).unwrap_or(false);
        match Page::read(path, file, index) {
            Ok(page) if !reduced && pages.first().is_none_or(|first| first.is_like(&page)) => pages.push(page),
            Err(e) if pages.is_empty() => return Err(e),
            page => {
                if others == 0 {
                    first_other = match page {
                        Ok(page) => format!("page {}, {page}", index + 1),
                        Err(_) => format!("page {}", index + 1),
                    };
                }
                others += 1;
            }
        }
        if !file.more_images() {
            if others > 0 {
                let what = "thumbnails, or of another size or type";
                notes.push(format!("pages left out, being {what} than the first page: {others} ({first_other})"));
            }
            return Ok((pages, text));
        }
    }
    Err(FieldError::new("pages", "more", format!("must be at most {MAX_PAGES}")).in_file(path))
}

/// True if the page says that it is a smaller copy of another one, or a mask.
fn is_reduced(file: &mut TiffFile) -> TiffResult<bool> {
    Ok(file.find_tag_unsigned::<u32>(Tag::NewSubfileType)?.unwrap_or(0) & 5 != 0)
}
