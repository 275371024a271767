//! Folders that appear whole or not at all: written beside their place under another name, then renamed.

use std::fs;
use std::io;
use std::path::Path;

use tempfile::TempDir;

use crate::error::WriteError;
use crate::unfinished::{self, UnderWay};

use super::refused;

/// Refuses a place where a folder with something in it is.
pub(super) fn check_vacant(path: &Path, advice: &str) -> Result<(), WriteError> {
    if path.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(refused(path, format!("the folder holds files; {advice}")));
    }
    Ok(())
}

/// A new folder beside a place, gone again unless it is renamed to it.
pub(super) fn beside(path: &Path) -> io::Result<(TempDir, UnderWay)> {
    unfinished::folder_in(or_here(path.parent().unwrap_or(Path::new(""))))
}

/// A new folder within a folder, gone again when it is dropped.
pub(super) fn within(folder: &Path) -> io::Result<(TempDir, UnderWay)> {
    unfinished::folder_in(or_here(folder))
}

/// Gives a new folder its place.
pub(super) fn rename(temporary: TempDir, path: &Path) -> io::Result<()> {
    // An empty folder makes room.
    if path.is_dir() {
        fs::remove_dir(path)?;
    }
    fs::rename(temporary.path(), path)?;
    // It has another name now: there is nothing to remove.
    let _ = temporary.keep();
    Ok(())
}

/// The folder, or the current one where it has no name.
pub(super) fn or_here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}
