//! The series of a folder, and the choice of one of them.
//!
//! Messages name a series by SeriesNumber, Modality, size, SeriesDescription and SeriesInstanceUID: no attribute of the patient.

use std::path::{Path, PathBuf};

use vr_core::parallel;

use super::elements::Elements;
use super::file::DicomFile;
use super::tags;
use crate::error::{FieldError, FileError, shown};
use crate::memory_folder;

/// Series that a message lists.
const MAX_LISTED: usize = 20;

/// Files of one series.
struct Series {
    uid: String,
    files: Vec<DicomFile>,
}

/// The files of a folder that hold images; notes on those that do not.
pub(super) fn images_of_folder(folder: &Path, notes: &mut Vec<String>) -> Result<Vec<DicomFile>, FileError> {
    let in_folder = |e| FileError::new(folder, e);
    let mut paths: Vec<PathBuf> = Vec::new();
    for path in memory_folder::entries(folder).map_err(in_folder)? {
        paths.push(path.map_err(in_folder)?);
    }
    // Nothing depends on names, but that the same folder gives the same errors.
    paths.sort();
    paths.retain(|path| memory_folder::is_file(path));
    let opened = parallel::try_collect(paths.len(), |i| DicomFile::open_if_dicom(&paths[i]))?;
    let count = opened.len();
    let mut files: Vec<DicomFile> = opened.into_iter().flatten().collect();
    if files.len() < count {
        notes.push(format!("{} of {count} files of the folder are not DICOM and are left out", count - files.len()));
    }
    let dicom = files.len();
    files.retain(|f| f.pixels.is_some());
    if files.len() < dicom {
        notes.push(format!("{} DICOM files without an image are left out", dicom - files.len()));
    }
    Ok(files)
}

/// SeriesInstanceUID; empty where a file has none.
pub(super) fn uid(elements: &Elements) -> String {
    elements.text(tags::SERIES_INSTANCE_UID).unwrap_or_default().into_owned()
}

/// True for the pictures on which a scan is planned.
fn is_localizer(file: &DicomFile) -> bool {
    let kind = file.elements.text(tags::IMAGE_TYPE).unwrap_or_default();
    kind.split('\\').any(|word| word.trim() == "LOCALIZER")
}

/// The files of one series, chosen by UID or number where there are several.
pub(super) fn choose(
    folder: &Path,
    files: Vec<DicomFile>,
    choice: Option<&str>,
    notes: &mut Vec<String>,
) -> Result<Vec<DicomFile>, FileError> {
    let mut all: Vec<Series> = Vec::new();
    for file in files {
        let uid = uid(&file.elements);
        match all.iter_mut().find(|s| s.uid == uid) {
            Some(series) => series.files.push(file),
            None => all.push(Series { uid, files: vec![file] }),
        }
    }
    all.sort_by_key(|s| (s.number(), s.uid.clone()));
    if let Some(choice) = choice {
        let number: Option<i64> = choice.trim().parse().ok();
        let fits = |s: &Series| s.uid == choice.trim() || (number.is_some() && s.number() == number);
        let fitting = all.iter().filter(|s| fits(s)).count();
        if fitting != 1 {
            let allowed = format!("{fitting} of the series are that: {}", list(&all));
            return Err(FieldError::new("series", choice, allowed).in_file(folder));
        }
        all.retain(fits);
    } else if all.iter().any(|s| !s.files.iter().all(is_localizer)) {
        let count = all.len();
        all.retain(|s| !s.files.iter().all(is_localizer));
        if all.len() < count {
            notes.push(format!("{} series of localizers are left out", count - all.len()));
        }
    }
    if all.len() > 1 {
        let allowed = format!("choose a series by its UID or, where no other has it, its number: {}", list(&all));
        return Err(FieldError::new("series", format_args!("{} in the folder", all.len()), allowed).in_file(folder));
    }
    match all.pop() {
        Some(series) => Ok(series.files),
        None => Err(FieldError::new("series", "nothing", "must be a folder with DICOM images").in_file(folder)),
    }
}

/// A series without its localizers and second copies, unless there is nothing else.
pub(super) fn without_strays(mut files: Vec<DicomFile>, notes: &mut Vec<String>) -> Vec<DicomFile> {
    let localizers = files.iter().filter(|f| is_localizer(f)).count();
    if localizers > 0 && localizers < files.len() {
        files.retain(|f| !is_localizer(f));
        notes.push(format!("{localizers} localizer images of the series are left out"));
    }
    let mut seen = std::collections::HashSet::new();
    let count = files.len();
    files.retain(|f| match f.elements.text(tags::SOP_INSTANCE_UID) {
        Some(uid) => seen.insert(uid.into_owned()),
        None => true,
    });
    if files.len() < count {
        notes.push(format!(
            "{} files with the SOPInstanceUID of another one are copies and are left out",
            count - files.len()
        ));
    }
    files
}

impl Series {
    fn number(&self) -> Option<i64> {
        self.files[0].elements.integer(tags::SERIES_NUMBER).ok().flatten()
    }

    fn line(&self) -> String {
        let elements = &self.files[0].elements;
        let size = |tag| elements.u16(tag).ok().flatten().unwrap_or(0);
        let number = self.number().map_or_else(|| "no number".to_owned(), |n| n.to_string());
        let mut line = format!("{number} (");
        if let Some(modality) = modality(elements) {
            line += &format!("{modality}, ");
        }
        line += &format!("{}x{}", size(tags::COLUMNS), size(tags::ROWS));
        if let Ok(Some(frames @ 2..)) = elements.integer(tags::NUMBER_OF_FRAMES) {
            line += &format!(", {frames} frames");
        }
        line += &format!(", {} file{}", self.files.len(), if self.files.len() == 1 { "" } else { "s" });
        if let Some(description) = elements.text(tags::SERIES_DESCRIPTION) {
            line += &format!(", {}", shown(&description));
        }
        line + &format!(", UID {})", shown(&self.uid))
    }
}

/// `CT`, `MR`, `PT`, …
pub(super) fn modality(elements: &Elements) -> Option<String> {
    elements.text(tags::MODALITY).map(|m| shown(&m))
}

fn list(all: &[Series]) -> String {
    let mut lines: Vec<String> = all.iter().take(MAX_LISTED).map(Series::line).collect();
    if all.len() > MAX_LISTED {
        lines.push(format!("and {} more", all.len() - MAX_LISTED));
    }
    lines.join("; ")
}
