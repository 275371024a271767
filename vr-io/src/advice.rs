//! Advice on what to name instead of a file or folder that is no volume by itself: the header beside it, or the volumes in it.

use std::path::Path;

use crate::detect::detect;
use crate::error::{FieldError, FileError, shown};
use crate::read::file_head;

/// Files that are opened in search of advice: a folder may hold many.
const MAX_OPENED: usize = 256;
/// Names in a message.
const MAX_NAMES: usize = 5;

/// The refusal of a file without a header of its own, where one beside it names it.
pub(crate) fn header_beside(path: &Path) -> Option<FileError> {
    let name = path.file_name()?.to_str()?;
    let names_it = |head: &[u8]| head.windows(name.len()).any(|bytes| bytes == name.as_bytes());
    let is_header = |path: &Path| {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        matches!(extension.as_str(), "nhdr" | "mhd" | "vvd" | "dat" | "general" | "nrrd")
    };
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut headers: Vec<_> = folder.read_dir().ok()?.flatten().map(|e| e.path()).filter(|p| is_header(p)).collect();
    headers.sort();
    let found = headers.iter().take(MAX_OPENED).find(|header| file_head(header).is_ok_and(|head| names_it(&head)))?;
    let allowed = format!("{} beside it describes it: name that", shown(&found.file_name()?.to_string_lossy()));
    Some(FieldError::new("header", "none in the file itself", allowed).in_file(path))
}

/// The refusal of a folder that is no volume, with the names of files in it that may be.
pub(crate) fn folder_of_files(path: &Path) -> FileError {
    let mut names: Vec<String> = Vec::new();
    let mut files: Vec<_> = path.read_dir().into_iter().flatten().flatten().map(|e| e.path()).collect();
    files.sort();
    for file in files.iter().filter(|p| p.is_file()).take(MAX_OPENED) {
        let is_volume = file_head(file).is_ok_and(|head| detect(file, &head).is_ok());
        if is_volume && names.len() <= MAX_NAMES {
            names.push(shown(&file.file_name().unwrap_or_default().to_string_lossy()));
        }
    }
    if names.len() > MAX_NAMES {
        names[MAX_NAMES] = "…".to_owned();
    }
    let allowed = if names.is_empty() {
        "a folder that is read holds DICOM, pictures as slices, or Zarr".to_owned()
    } else {
        format!("name one of its files: {}", names.join(", "))
    };
    FieldError::new("folder", "files that are no slices of one volume", allowed).in_file(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_of_a_raw_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let raw = folder.path().join("tooth.raw");
        std::fs::write(&raw, [0; 8]).unwrap();
        assert!(header_beside(&raw).is_none());
        std::fs::write(folder.path().join("tooth.nhdr"), "NRRD0004\ntype: uchar\ndata file: tooth.raw\n").unwrap();
        let message = header_beside(&raw).unwrap().to_string();
        assert!(
            message.ends_with("header: found none in the file itself; tooth.nhdr beside it describes it: name that"),
            "{message}"
        );
        let message = folder_of_files(folder.path()).to_string();
        assert!(message.contains("name one of its files: tooth.nhdr"), "{message}");
    }
}
