//! Checks of the places that files are written to.

use std::path::{Path, PathBuf};

use serde::Serializer;

use crate::args::ReplaceArgs;
use crate::failure::Failure;

/// Checks that a file which is there may be replaced: a picture of this program's own, any file if that is asked for. What is no file, such as
/// a pipe, takes what it is given.
///
/// # Errors
/// [`Failure::Failed`] naming the file.
pub fn check_replaced(path: &Path, replace: ReplaceArgs) -> Result<(), Failure> {
    if replace.force || !path.is_file() || vr_io::is_own_picture(path) {
        return Ok(());
    }
    let shown = path.display();
    Err(Failure::failed(format!(
        "{shown}: is there, and is no picture of vr's; name another file, or replace it by --force"
    )))
}

/// Checks, before the work begins, that a file can be written to a place: a name that tells the format, in a folder that exists.
///
/// # Errors
/// [`Failure::Usage`] for another extension, [`Failure::Failed`] for a place that cannot be.
pub fn check(path: &Path, extensions: &[&str]) -> Result<(), Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    if !extension.as_deref().is_some_and(|e| extensions.contains(&e)) {
        let found = extension.unwrap_or_else(|| "nothing".to_owned());
        let allowed = extensions.join(" or ");
        return Err(Failure::usage(format!("{}: extension: found {found}; must be {allowed}", path.display())));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.is_dir() || !folder.is_dir() {
        let what = if path.is_dir() { "is a folder" } else { "its folder does not exist" };
        return Err(Failure::failed(format!("{}: cannot be written: {what}", path.display())));
    }
    Ok(())
}

/// True if a name is that of a PNG.
pub fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

/// Writes the paths of files into JSON as messages show them: a path is bytes, and JSON is text.
///
/// # Errors
/// Errors of the serializer.
pub fn as_texts<S: Serializer>(paths: &impl AsRef<[PathBuf]>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.as_ref().iter().map(|path| path.to_string_lossy()))
}
