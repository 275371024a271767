//! A folder in which a reader meets files.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use vr_io::MemoryFolder;

use crate::targets::Target;

/// Bytes of memory that readers are told is left. Seeds have a few kilobytes: what takes more has believed a header.
pub const MEMORY_LEFT: u64 = 64 << 20;

/// Bytes of memory that a reader may take at one time: what it asked for, the page or piece that it unpacks beside that, and tables of its
/// decoders.
pub const MAX_MEMORY: usize = 2 * MEMORY_LEFT as usize + (16 << 20);

/// A folder in which a reader meets one file after the other, with those beside it that it needs.
pub struct Ground {
    target: &'static Target,
    place: Place,
}

enum Place {
    /// A folder of the system.
    Disk(TempDir),
    /// Files beside the one that is read, by name: of a [`MemoryFolder`] for each that is.
    Memory(Vec<(String, Vec<u8>)>),
}

impl Ground {
    /// Makes the folder of a target, in memory where the system has such a place.
    ///
    /// # Panics
    /// If there can be no such folder.
    pub fn new(target: &'static Target) -> Self {
        Self { target, place: Place::Disk(folder_of(target)) }
    }

    /// Makes a folder that is none of the system's, whose calls take several times as long as a reader; for a target that needs folders in its folder, one of
    /// the system.
    ///
    /// # Panics
    /// If there can be no folder for the files beside the one that is read.
    pub fn in_memory(target: &'static Target) -> Self {
        let folder = folder_of(target);
        let is_flat = Path::new(target.entry).components().count() == 1;
        let place = match files_of(folder.path()).filter(|_| is_flat) {
            Some(files) => Place::Memory(files),
            None => Place::Disk(folder),
        };
        Self { target, place }
    }

    /// Reads a file of these bytes.
    ///
    /// # Errors
    /// A fault of the reader: a message of two lines, a volume that is not finite.
    ///
    /// # Panics
    /// If the reader does, or the file cannot be written.
    pub fn run(&self, bytes: &[u8]) -> Result<(), String> {
        let packed = self.target.pack.map(|pack| pack(bytes));
        let bytes = packed.as_deref().unwrap_or(bytes);
        match &self.place {
            Place::Disk(folder) => {
                let path = folder.path().join(self.target.file);
                // A new file each time: one that a reader has mapped keeps its bytes.
                let _ = fs::remove_file(&path);
                fs::write(&path, bytes).expect("a file to read");
                (self.target.reader)(&folder.path().join(self.target.entry))
            }
            Place::Memory(beside) => {
                let file = (self.target.file.to_owned(), bytes.to_vec());
                // The last file of a name is the one that holds.
                let folder = MemoryFolder::new(beside.iter().cloned().chain([file]));
                (self.target.reader)(&folder.path().join(self.target.entry))
            }
        }
    }
}

/// A folder of the system, with the files that a target needs beside the one that is read.
fn folder_of(target: &Target) -> TempDir {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    let folder = folder.expect("a folder for files");
    if let Some(parent) = folder.path().join(target.file).parent() {
        fs::create_dir_all(parent).expect("a folder for files");
    }
    (target.beside)(folder.path());
    folder
}

/// Files of a folder, by name; `None` if there are folders in it.
fn files_of(folder: &Path) -> Option<Vec<(String, Vec<u8>)>> {
    let entries = folder.read_dir().expect("a folder for files").map(|entry| entry.expect("a file"));
    let file = |entry: fs::DirEntry| Some((entry.file_name().into_string().ok()?, fs::read(entry.path()).ok()?));
    entries.map(file).collect()
}
