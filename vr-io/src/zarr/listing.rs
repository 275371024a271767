//! Files that are there, from lists of their folders.

use std::collections::{HashMap, HashSet};
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Names in the folders of an array, each of which is listed once: of a million chunks that are not stored, the file system is asked for none.
pub(super) struct Listing<'a> {
    root: &'a Path,
    /// `None` for a folder that cannot be listed.
    folders: HashMap<PathBuf, Option<HashSet<OsString>>>,
}

impl<'a> Listing<'a> {
    pub(super) fn new(root: &'a Path) -> Self {
        Self { root, folders: HashMap::new() }
    }

    /// False for files below the root that are not there for certain.
    pub(super) fn may_have(&mut self, file: &Path) -> bool {
        let Ok(below) = file.strip_prefix(self.root) else { return true };
        let mut folder = self.root.to_owned();
        for name in below {
            if !self.names(&folder).is_none_or(|names| names.contains(name)) {
                return false;
            }
            folder.push(name);
        }
        true
    }

    fn names(&mut self, folder: &Path) -> Option<&HashSet<OsString>> {
        if !self.folders.contains_key(folder) {
            let names = match folder.read_dir() {
                Ok(entries) => entries.map(|entry| entry.map(|entry| entry.file_name())).collect::<Result<_, _>>().ok(),
                Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Some(HashSet::new()),
                Err(_) => None,
            };
            self.folders.insert(folder.to_owned(), names);
        }
        self.folders[folder].as_ref()
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn files_are_there_or_not() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir_all(root.join("c/0/1")).unwrap();
        for name in ["c/0/1/2", "0.1.2"] {
            fs::write(root.join(name), "").unwrap();
        }
        let mut listing = Listing::new(root);
        for (name, there) in [
            ("c/0/1/2", true),
            ("0.1.2", true),
            ("c/0/1/3", false),
            ("c/0/2/2", false),
            ("c/1/1/2", false),
            ("d", false),
            // Below a file.
            ("0.1.2/0", false),
        ] {
            assert_eq!(listing.may_have(&root.join(name)), there, "{name}");
        }
        // Folders that are not there have no list.
        assert_eq!(listing.folders.len(), 5);
        // Of files elsewhere nothing is known.
        assert!(listing.may_have(Path::new("elsewhere/0")));
    }
}
