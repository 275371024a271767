//! Real files, which lie beside the checkout or nowhere.

use std::path::{Path, PathBuf};

/// A file or folder of the shared data, or `None` after a word where there are none.
pub fn data(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("VR_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    if root.is_dir() {
        return Some(root.join(name));
    }
    println!("skipped: no shared data at {}", root.display());
    None
}
