//! Small whole files of every kind. They are those of the tests of `vr-io`, which makes them.

pub mod amr;
pub mod grids;
pub mod meshes;
pub mod pictures;
pub mod points;
pub mod texts;
pub mod vtk;

use std::path::{Path, PathBuf};

/// No other files.
pub fn nothing_beside(_: &Path) {}

/// A file of the tests of `vr-io`.
fn kept(name: &str) -> Vec<u8> {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "../vr-io/tests/all", name].iter().collect();
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A file that `vr-io` writes.
fn written<E: std::fmt::Display>(name: &str, write: impl FnOnce(&Path) -> Result<(), E>) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder for a seed");
    let path = folder.path().join(name);
    write(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{name}: {e}"))
}
