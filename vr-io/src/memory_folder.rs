//! Files in memory in place of the disk: for a program that has been sent them, and for a browser, which gives a module no disk.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex};

use vr_core::parallel::locked;

/// Bytes of a file.
pub(crate) type MemoryFile = Arc<Vec<u8>>;

/// Files of a folder by their names.
type Files = BTreeMap<String, MemoryFile>;

/// Folders that are there, by their paths.
static FOLDERS: LazyLock<Mutex<BTreeMap<PathBuf, Arc<Files>>>> = LazyLock::new(Mutex::default);

/// Folder of files in memory, without folders in it: every reader of this crate takes its paths, as long as it lives. What was read from it stays.
///
/// # Examples
/// ```
/// use vr_io::{MemoryFolder, ReadOptions, Loaded};
///
/// let header = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n";
/// let folder = MemoryFolder::new([("a.nrrd".to_owned(), [&header[..], &[1, 2, 3, 4, 5, 6, 7, 8]].concat())]);
/// let Loaded { volume, .. } = vr_io::read(&folder.path().join("a.nrrd"), &ReadOptions::default())?;
/// assert_eq!(volume.value_range(), Some((1.0, 8.0)));
/// # Ok::<(), vr_io::FileError>(())
/// ```
#[derive(Debug)]
pub struct MemoryFolder(PathBuf);

impl MemoryFolder {
    /// A folder of files, each with its name.
    pub fn new(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let files = files.into_iter().map(|(name, bytes)| (name, Arc::new(bytes))).collect();
        // No folder of a disk has such a name by chance; messages print it as it is, so that it can be taken out of them.
        let path = PathBuf::from(format!("vr-memory:{}", NEXT.fetch_add(1, Ordering::Relaxed)));
        locked(&FOLDERS).insert(path.clone(), Arc::new(files));
        Self(path)
    }

    /// Path of the folder, which is none of the disk.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for MemoryFolder {
    fn drop(&mut self) {
        locked(&FOLDERS).remove(&self.0);
    }
}

/// The files of a folder in memory; `None` for any other path.
fn folder(path: &Path) -> Option<Arc<Files>> {
    locked(&FOLDERS).get(path).cloned()
}

/// A file in memory; `None` where the path is of the disk.
///
/// # Errors
/// [`io::ErrorKind::NotFound`] for a file that the folder does not have, [`io::ErrorKind::InvalidInput`] for the folder.
pub(crate) fn find(path: &Path) -> Option<io::Result<MemoryFile>> {
    if is_memory_folder(path) {
        let message = "is a folder; must be a regular file";
        return Some(Err(io::Error::new(io::ErrorKind::InvalidInput, message)));
    }
    let files = folder(path.parent()?)?;
    let found = path.file_name().and_then(|name| files.get(name.to_str()?)).cloned();
    Some(found.ok_or_else(|| io::ErrorKind::NotFound.into()))
}

fn is_memory_folder(path: &Path) -> bool {
    locked(&FOLDERS).contains_key(path)
}

/// True if a path is that of a file.
pub(crate) fn is_file(path: &Path) -> bool {
    find(path).map_or_else(|| path.is_file(), |found| found.is_ok())
}

/// True if a path is that of a folder.
pub(crate) fn is_folder(path: &Path) -> bool {
    is_memory_folder(path) || path.is_dir()
}

/// True if there is anything at a path.
pub(crate) fn exists(path: &Path) -> bool {
    is_memory_folder(path) || find(path).map_or_else(|| path.exists(), |found| found.is_ok())
}

/// Length of a file in bytes.
///
/// # Errors
/// Those of the system.
pub(crate) fn length(path: &Path) -> io::Result<u64> {
    match find(path) {
        Some(found) => Ok(found?.len() as u64),
        None => Ok(fs::metadata(path)?.len()),
    }
}

/// Paths in a folder, one by one, in no order.
///
/// # Errors
/// Those of the system.
pub(crate) fn entries(path: &Path) -> io::Result<Box<dyn Iterator<Item = io::Result<PathBuf>>>> {
    if let Some(files) = folder(path) {
        let names: Vec<PathBuf> = files.keys().map(|name| path.join(name)).collect();
        return Ok(Box::new(names.into_iter().map(Ok)));
    }
    Ok(Box::new(path.read_dir()?.map(|entry| Ok(entry?.path()))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Loaded, ReadOptions, read};

    #[test]
    fn readers_take_what_a_disk_would_give() {
        // A header and its voxels, and a series of pictures: as files on a disk, and in memory.
        let header =
            b"ObjectType = Image\nNDims = 3\nDimSize = 3 2 2\nElementType = MET_USHORT\nElementDataFile = b.raw\n";
        let voxels: Vec<u8> = (0..12u16).flat_map(|i| (i * i).to_le_bytes()).collect();
        let slice = |k: u8| [&b"P5 3 2 255\n"[..], &[k, 1, 2, 3 * k, 4, 5]].concat();
        let pair = [("a.mhd", header.to_vec()), ("b.raw", voxels)];
        let series = [("s1.pgm", slice(1)), ("s2.pgm", slice(2)), ("s3.pgm", slice(3))];
        let named = |files: &[(&str, Vec<u8>)]| {
            files.iter().map(|(name, bytes)| (name.to_string(), bytes.clone())).collect::<Vec<_>>()
        };
        for (files, name) in [(named(&pair), "a.mhd"), (named(&series), "")] {
            let disk = tempfile::tempdir().unwrap();
            files.iter().for_each(|(name, bytes)| fs::write(disk.path().join(name), bytes).unwrap());
            let memory = MemoryFolder::new(files);
            let of = |folder: &Path| {
                let path = if name.is_empty() { folder.to_owned() } else { folder.join(name) };
                let Loaded { volume, info, .. } = read(&path, &ReadOptions::default()).unwrap();
                (crate::volume_hash(&volume), volume.value_range(), info.files.len())
            };
            assert_eq!(of(memory.path()), of(disk.path()), "{name:?}");
        }
        // What is not there is not found; a folder is no file; and with the folder, all of it goes.
        let memory = MemoryFolder::new(named(&pair));
        let kind = |path: &Path| crate::regular_file::open(path).unwrap_err().kind();
        assert_eq!(kind(&memory.path().join("c")), io::ErrorKind::NotFound);
        assert_eq!(kind(memory.path()), io::ErrorKind::InvalidInput);
        let gone = memory.path().join("a.mhd");
        assert!(is_file(&gone) && length(&gone).unwrap() > 0 && is_folder(memory.path()));
        drop(memory);
        assert!(!is_file(&gone) && !exists(&gone));
    }
}
