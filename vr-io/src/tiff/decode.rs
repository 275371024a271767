//! Decoding of the chosen pages, several at a time.

use std::path::{Path, PathBuf};

use tiff::decoder::DecodingResult;
use vr_core::parallel;

use crate::error::{FieldError, FileError};
use crate::layout::Layout;

use super::{Page, TiffFile, open, pixels, refuse};

/// The numbers of the chosen slices: where they are in the file.
pub(super) struct Stack {
    path: PathBuf,
    /// Place of each slice's page in the file's chain of directories.
    pages: Vec<usize>,
    /// First of the chosen numbers in a page, and the step to the next.
    offset: usize,
    step: usize,
    /// Chosen numbers of a page.
    count: usize,
    /// Bytes of all numbers of a page.
    page_bytes: usize,
}

impl Stack {
    pub fn new(path: &Path, pages: &[Page], layout: &Layout) -> Self {
        let [nx, ny, nz] = layout.dims;
        let numbers = nx * ny * pages[0].samples;
        let place = |z: usize| (layout.offset + z * layout.strides[2]) / numbers;
        Self {
            path: path.into(),
            pages: (0..nz).filter_map(|z| pages.get(place(z)).map(|p| p.index)).collect(),
            offset: layout.offset % numbers,
            step: layout.strides[0],
            count: nx * ny,
            page_bytes: usize::try_from(pages[0].page_bytes()).unwrap_or(usize::MAX),
        }
    }

    /// Bytes of all chosen numbers, in the machine's order. Memory grows with what the pages really hold.
    pub fn decode(&self) -> Result<Vec<u8>, FileError> {
        // Each thread walks the chain of directories once, from front to back.
        let threads = rayon::current_num_threads().clamp(1, self.pages.len().max(1));
        const RUN: usize = 4;
        let mut files: Vec<TiffFile> =
            (0..threads).map(|_| open(&self.path, self.page_bytes)).collect::<Result<_, _>>()?;
        let mut out = Vec::new();
        for batch in self.pages.chunks(threads * RUN) {
            let mut parts: Vec<Result<Vec<u8>, FileError>> = batch.chunks(RUN).map(|_| Ok(Vec::new())).collect();
            let work = files.iter_mut().zip(batch.chunks(RUN)).zip(&mut parts);
            parallel::each_part(work, |_, ((file, run), part)| **part = self.decode_run(file, run));
            for part in parts {
                out.extend(part?);
            }
        }
        Ok(out)
    }

    /// The chosen numbers of some pages.
    fn decode_run(&self, file: &mut TiffFile, pages: &[usize]) -> Result<Vec<u8>, FileError> {
        let mut part = Vec::new();
        for &page in pages {
            file.seek_to_image(page).map_err(|e| refuse(&self.path, e))?;
            decode_page(&self.path, file, self.offset, self.step, self.count, &mut part)?;
        }
        Ok(part)
    }
}

/// Appends the chosen numbers of the page at which `file` stands.
pub(crate) fn decode_page(
    path: &Path,
    file: &mut TiffFile,
    offset: usize,
    step: usize,
    count: usize,
    out: &mut Vec<u8>,
) -> Result<(), FileError> {
    let mut decoded = DecodingResult::U8(Vec::new());
    file.read_image_to_buffer(&mut decoded).map_err(|e| refuse(path, e))?;
    if pixels::append(&decoded, offset, step, count, out) {
        return Ok(());
    }
    Err(FieldError::new("page", "fewer pixels", format!("its directory says {count}")).in_file(path))
}
