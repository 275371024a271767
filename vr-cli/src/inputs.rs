//! Files that a command reads, none of which may be written.

use std::fs;
use std::path::{Path, PathBuf};

use crate::args::ReplaceArgs;
use crate::failure::Failure;
use crate::output_file::check_replaced;

/// Files that a command reads, by their identity: a link, a hard link or another spelling of the name is the same file.
#[derive(Debug)]
pub struct Inputs {
    /// Name of the files in messages: `a file that is read`.
    what: &'static str,
    files: Vec<(FileId, PathBuf)>,
}

impl Inputs {
    /// Identifies all files of a list that exist. `what` names them in messages: `a file that is read`.
    pub fn new(what: &'static str, paths: impl IntoIterator<Item = PathBuf>) -> Self {
        let files = paths.into_iter().filter_map(|path| Some((FileId::of(&path)?, path)));
        Self { what, files: files.collect() }
    }

    /// Refuses to write where an input is. Called before anything is computed or written.
    ///
    /// # Errors
    /// [`Failure::Usage`] naming the flag, its file, and the input that would be destroyed.
    pub fn protect(&self, flag: &str, place: &Path) -> Result<(), Failure> {
        let Some(id) = FileId::of(place) else { return Ok(()) };
        match self.files.iter().find(|(input, _)| *input == id) {
            Some((_, input)) => Err(Failure::usage(format!(
                "{flag}: {} is {}{}: writing would destroy it; name another file",
                place.display(),
                self.what,
                if input == place { String::new() } else { format!(" ({})", input.display()) },
            ))),
            None => Ok(()),
        }
    }

    /// Refuses to write where an input is, and over a file that is not to be replaced.
    ///
    /// # Errors
    /// Errors of [`Self::protect`] and [`check_replaced`].
    pub fn permit(&self, flag: &str, place: &Path, replace: ReplaceArgs) -> Result<(), Failure> {
        self.protect(flag, place)?;
        check_replaced(place, replace)
    }
}

/// Refuses to write two things at one place.
///
/// # Errors
/// [`Failure::Usage`] naming the flag, its place, and what else goes there.
pub fn apart((flag, place): (&str, &Path), (what, other): (&str, &Path)) -> Result<(), Failure> {
    let same = match (FileId::of(place), FileId::of(other)) {
        (Some(a), Some(b)) => a == b,
        // What does not exist yet has only its name.
        (None, None) => future_name(place) == future_name(other),
        _ => false,
    };
    if same {
        let message = format!("{flag}: {} is where {what} goes, too; name another file", place.display());
        return Err(Failure::usage(message));
    }
    Ok(())
}

/// Returns the full name of a file that does not exist yet.
fn future_name(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.into());
    path.file_name().map_or(folder.clone(), |name| folder.join(name))
}

/// Identity of a file that exists.
#[derive(Debug, PartialEq, Eq)]
enum FileId {
    /// Device and inode: all hard links share them.
    #[cfg(unix)]
    Inode(u64, u64),
    /// Name without links, where a system tells no more: hard links are not seen.
    #[cfg(not(unix))]
    Name(PathBuf),
}

impl FileId {
    /// Returns the identity of the file that a path leads to, through any links; `None` where there is none, or none that can be looked at.
    fn of(path: &Path) -> Option<Self> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let place = fs::metadata(path).ok()?;
            // Nothing is lost by writing to a device: /dev/null may be read and written.
            place.is_file().then(|| Self::Inode(place.dev(), place.ino()))
        }
        #[cfg(not(unix))]
        {
            fs::canonicalize(path).ok().map(Self::Name)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_by_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["scan", "copy"] {
            fs::write(at(name), "the same bytes").unwrap();
        }
        let inputs = Inputs::new("a file that is read", [at("scan"), at("missing")]);
        let mut same = vec![at("scan"), at("./scan")];
        #[cfg(unix)]
        {
            fs::hard_link(at("scan"), at("hard")).unwrap();
            std::os::unix::fs::symlink("scan", at("link")).unwrap();
            std::os::unix::fs::symlink("link", at("further")).unwrap();
            std::os::unix::fs::symlink(".", at("here")).unwrap();
            same.extend([at("hard"), at("link"), at("further"), at("here/scan")]);
        }
        for place in same {
            let refused = inputs.protect("-o", &place).unwrap_err().to_string();
            assert!(refused.contains("would destroy it") && refused.contains("scan"), "{refused}");
        }
        for place in ["copy", "missing", "new"] {
            inputs.protect("-o", &at(place)).unwrap();
        }
    }

    #[test]
    fn places_that_do_not_exist_yet_are_compared_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("old"), "").unwrap();
        assert!(apart(("a", &at("x")), ("b", &at("./x"))).is_err());
        assert!(apart(("a", &at("old")), ("b", &at("./old"))).is_err());
        apart(("a", &at("x")), ("b", &at("y"))).unwrap();
        apart(("a", &at("x")), ("b", &at("old"))).unwrap();
    }
}
