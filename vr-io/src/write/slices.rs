//! Volumes as PNG slices: a folder of them, or the files of a pattern.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf, is_separator};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use vr_core::parallel;

use crate::error::WriteError;
use crate::file_pattern;
use crate::scalar::ScalarType;

use super::numbers::Numbers;
use super::{Job, folder, refused, shape};

/// Places of the slices.
#[derive(Clone, Debug)]
pub(super) struct SliceFiles {
    folder: PathBuf,
    names: Vec<String>,
    /// True if the folder is made for them.
    whole_folder: bool,
}

impl SliceFiles {
    /// The files that a folder or a pattern stands for; `None` for a name of another kind.
    pub fn of(path: &Path, count: usize) -> Result<Option<Self>, WriteError> {
        let text = path.to_string_lossy();
        if path.is_dir() || text.ends_with(is_separator) {
            let digits = (count - 1).to_string().len();
            let names = (0..count).map(|i| format!("slice_{i:0digits$}.png")).collect();
            return Ok(Some(Self { folder: path.into(), names, whole_folder: true }));
        }
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            return Ok(None);
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !name.contains('%') {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let message =
                format!("a PNG holds one slice: name a folder ({stem}/), or a pattern such as {stem}_%03d.png");
            return Err(refused(path, message));
        }
        let pattern = |e: crate::FieldError| refused(path, e.to_string());
        let names = file_pattern::expand("pattern", &format!("{name} 0 {}", count - 1), count).map_err(pattern)?;
        let parent = path.parent().unwrap_or(Path::new(""));
        let there: Vec<String> = match folder::or_here(parent).read_dir() {
            Ok(entries) => entries.flatten().filter_map(|e| e.file_name().into_string().ok()).collect(),
            Err(_) => Vec::new(),
        };
        let same = file_pattern::matching("pattern", &name, &there).map_err(pattern)?;
        if let Some(other) = same.iter().find(|name| !names.contains(name)) {
            let message =
                format!("{other} is there, and would be read as one of the slices; remove it, or name another pattern");
            return Err(refused(path, message));
        }
        Ok(Some(Self { folder: parent.into(), names, whole_folder: false }))
    }

    pub fn files(&self) -> Vec<PathBuf> {
        self.names.iter().map(|name| self.folder.join(name)).collect()
    }

    /// Writes the slices into a folder beside their place, and moves them there when all are done.
    pub fn write(&self, job: &mut Job<'_>) -> Result<ScalarType, WriteError> {
        let numbers = job.values("a PNG");
        let scalar = depth(job, &numbers)?;
        let numbers = numbers.with_scalar(scalar);
        let failed = |source: io::Error| WriteError::Io { path: job.path.into(), source };
        if self.whole_folder {
            folder::check_vacant(job.path, "name a new one, or a pattern such as slice_%03d.png in it")?;
        }
        let temporary = if self.whole_folder { folder::beside(&self.folder) } else { folder::within(&self.folder) };
        let (temporary, _under_way) = temporary.map_err(failed)?;
        let [nx, ny, _] = job.grid.dims();
        parallel::try_collect(self.names.len(), |z| {
            let name = &self.names[z];
            let slice = nx * ny * z..nx * ny * (z + 1);
            write_slice(&temporary.path().join(name), &numbers, slice, [nx, ny])
                .map_err(|source| WriteError::Io { path: self.folder.join(name), source })
        })?;
        if self.whole_folder {
            folder::rename(temporary, &self.folder).map_err(failed)?;
        } else {
            for name in &self.names {
                fs::rename(temporary.path().join(name), self.folder.join(name)).map_err(failed)?;
            }
        }
        let spacing = shape::vector(job.grid.placement().spacing());
        job.notes.push(format!("PNG slices hold no placement: spacing ({spacing}), position and orientation are lost"));
        Ok(scalar)
    }
}

/// Unsigned integers of 8 or 16 bits that hold the numbers.
fn depth(job: &Job<'_>, numbers: &Numbers<'_>) -> Result<ScalarType, WriteError> {
    let range = job.grid.value_range();
    match (numbers.scalar(), range) {
        (scalar @ (ScalarType::U8 | ScalarType::U16), _) => Ok(scalar),
        (ScalarType::I8, Some((low, _))) if low >= 0.0 => Ok(ScalarType::U8),
        (ScalarType::I16, Some((low, _))) if low >= 0.0 => Ok(ScalarType::U16),
        (scalar, range) => {
            let (low, high) = range.unwrap_or((0.0, 1.0));
            let message = format!(
                "voxels of {scalar} from {low} to {high}: a PNG holds whole numbers from 0 to 255 or 65535; convert them first \
                 (vr convert --to u16 --rescale {low},{high})"
            );
            Err(refused(job.path, message))
        }
    }
}

fn write_slice(
    path: &Path,
    numbers: &Numbers<'_>,
    voxels: std::ops::Range<usize>,
    [width, height]: [usize; 2],
) -> io::Result<()> {
    let mut bytes = Vec::new();
    numbers.write_part(voxels, &mut bytes)?;
    let mut color = ExtendedColorType::L8;
    if numbers.scalar().bytes() == 2 {
        color = ExtendedColorType::L16;
        // `image` takes 16-bit channels in the machine's byte order.
        if cfg!(target_endian = "big") {
            bytes.as_chunks_mut::<2>().0.iter_mut().for_each(|pair| pair.reverse());
        }
    }
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let mut out = BufWriter::new(File::create(path)?);
    let png: &mut dyn Write = &mut out;
    PngEncoder::new(png).write_image(&bytes, side(width)?, side(height)?, color).map_err(io::Error::other)?;
    out.flush()
}
