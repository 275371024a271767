//! Temporary files and folders of writes that are under way: removed where a run ends in the middle, swept up where one was killed.

use std::collections::{BTreeSet, HashSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex};
use std::time::Duration;

use tempfile::{Builder, NamedTempFile, TempDir};
use vr_core::parallel::locked;

const PREFIX: &str = ".vr-";
const SUFFIX: &str = ".part";

/// Age at which a temporary file is taken for the leftover of a killed run.
const OLD: Duration = Duration::from_secs(24 * 60 * 60);

/// Places of all writes that are under way in this process.
static UNDER_WAY: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Folders in which this process has swept up.
static SWEPT: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);

/// Removes the temporary files of all writes that are under way. For a program that is about to end in the middle of its work, when a
/// signal tells it to: the files that were to be written are as they were before.
///
/// A write that goes on afterwards fails.
pub fn remove_unfinished() {
    for place in std::mem::take(&mut *locked(&UNDER_WAY)) {
        remove(&place);
    }
}

/// A write that is under way, as long as this lives.
pub(crate) struct UnderWay(PathBuf);

impl UnderWay {
    fn begin(place: &Path) -> Self {
        locked(&UNDER_WAY).insert(place.into());
        Self(place.into())
    }
}

impl Drop for UnderWay {
    fn drop(&mut self) {
        locked(&UNDER_WAY).remove(&self.0);
    }
}

/// Makes a temporary file in a folder.
pub(crate) fn file_in(folder: &Path) -> io::Result<(NamedTempFile, UnderWay)> {
    sweep(folder);
    // As any new file has them, less the user's mask; temporary files are private otherwise.
    let file = builder(0o666).tempfile_in(folder)?;
    let under_way = UnderWay::begin(file.path());
    Ok((file, under_way))
}

/// Makes a temporary folder in a folder.
pub(crate) fn folder_in(folder: &Path) -> io::Result<(TempDir, UnderWay)> {
    sweep(folder);
    let folder = builder(0o777).tempdir_in(folder)?;
    let under_way = UnderWay::begin(folder.path());
    Ok((folder, under_way))
}

#[cfg_attr(not(unix), expect(unused_variables, reason = "permissions are Unix's"))]
fn builder(mode: u32) -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
    builder
}

/// Removes from a folder what killed runs have left there, once a process. Nothing fails by it: another may sweep at the same time.
fn sweep(folder: &Path) {
    if !locked(&SWEPT).insert(folder.into()) {
        return;
    }
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_ours = name.to_str().and_then(|name| name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)).is_some();
        let age = || entry.metadata().and_then(|entry| entry.modified()).ok()?.elapsed().ok();
        if is_ours && age().is_some_and(|age| age > OLD) {
            remove(&entry.path());
        }
    }
}

/// Removes a file or a folder, not what a link leads to; where it cannot be, it stays.
fn remove(place: &Path) {
    let _ = if fs::symlink_metadata(place).is_ok_and(|entry| entry.is_dir()) {
        fs::remove_dir_all(place)
    } else {
        fs::remove_file(place)
    };
}

#[cfg(test)]
mod tests {
    use std::fs::File;
    use std::time::SystemTime;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn leftovers_are_swept_when_they_are_old() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at(".vr-folder.part")).unwrap();
        fs::write(at(".vr-folder.part/0"), "x").unwrap();
        for name in [".vr-old.part", ".vr-new.part", "old.part", ".vr-old"] {
            fs::write(at(name), "x").unwrap();
        }
        let long_ago = SystemTime::now() - 2 * OLD;
        for name in [".vr-folder.part", ".vr-old.part", "old.part", ".vr-old"] {
            File::open(at(name)).unwrap().set_modified(long_ago).unwrap();
        }
        drop(file_in(folder.path()).unwrap());
        assert_eq!(names(folder.path()), [".vr-new.part", ".vr-old", "old.part"]);
    }

    #[test]
    fn a_write_is_under_way_as_long_as_its_file_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let under_way = |place: &Path| locked(&UNDER_WAY).contains(place);
        let (file, entry) = file_in(folder.path()).unwrap();
        let place = file.path().to_path_buf();
        assert!(under_way(&place));
        drop((file, entry));
        assert!(!under_way(&place) && names(folder.path()).is_empty());
        // Other tests write at this moment: only what is removed by name is looked at.
        let (made, _entry) = folder_in(folder.path()).unwrap();
        fs::write(made.path().join("0"), "x").unwrap();
        remove(made.path());
        assert!(names(folder.path()).is_empty());
    }
}
