//! A folder in which a reader meets files.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::targets::Target;

/// Bytes of memory that readers are told is left. Seeds have a few kilobytes: what takes more has believed a header.
pub const MEMORY_LEFT: u64 = 64 << 20;

/// Bytes of memory that a reader may take at one time: what it asked for, the page or piece that it unpacks beside that, and tables of its
/// decoders.
pub const MAX_MEMORY: usize = 2 * MEMORY_LEFT as usize + (16 << 20);

/// A folder in which a reader meets one file after the other, with those beside it that it needs.
pub struct Ground {
    target: &'static Target,
    folder: TempDir,
}

impl Ground {
    /// Makes the folder of a target, in memory where the system has such a place.
    ///
    /// # Panics
    /// If there can be no such folder.
    pub fn new(target: &'static Target) -> Self {
        let memory = PathBuf::from("/dev/shm");
        let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        let folder = folder.expect("a folder for files");
        if let Some(parent) = folder.path().join(target.file).parent() {
            fs::create_dir_all(parent).expect("a folder for files");
        }
        (target.beside)(folder.path());
        Self { target, folder }
    }

    /// Reads a file of these bytes.
    ///
    /// # Errors
    /// A fault of the reader: a message of two lines, a volume that is not finite.
    ///
    /// # Panics
    /// If the reader does, or the file cannot be written.
    pub fn run(&self, bytes: &[u8]) -> Result<(), String> {
        let path = self.folder.path().join(self.target.file);
        // A new file each time: one that a reader has mapped keeps its bytes.
        let _ = fs::remove_file(&path);
        let packed = self.target.pack.map(|pack| pack(bytes));
        fs::write(&path, packed.as_deref().unwrap_or(bytes)).expect("a file to read");
        (self.target.reader)(&self.folder.path().join(self.target.entry))
    }
}
