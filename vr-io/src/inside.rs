//! Paths that a file names, held within its folder.

use std::path::{Component, Path, PathBuf};

use crate::error::FieldError;

/// The path of a file that another one names, which must lie within the folder.
///
/// # Errors
/// Absolute paths, and those that lead out of the folder.
pub(crate) fn inside(folder: &Path, field: &str, name: &str) -> Result<PathBuf, FieldError> {
    let inner = Path::new(name);
    if name.is_empty() || !inner.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
        return Err(FieldError::new(field, name, "must be a path inside of the folder"));
    }
    Ok(folder.join(inner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_within_the_folder() {
        let of = |name| inside(Path::new("a"), "file", name).map_err(|e| e.to_string());
        assert_eq!(of("b/./c.vti").unwrap(), Path::new("a/b/./c.vti"));
        for wrong in ["../b", "b/../../c", "/etc/passwd", ""] {
            assert!(of(wrong).unwrap_err().contains("inside of the folder"), "{wrong}");
        }
    }
}
