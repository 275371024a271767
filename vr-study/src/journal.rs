//! Journal: the finished parts of a long study, on disk, so that it can be resumed.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// File of the finished parts of a study, one JSON line each, below a line that names the study.
///
/// A line that was cut short (the machine went down) and all that follow count as not done.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    done: BTreeMap<String, Value>,
    file: File,
}

impl Journal {
    /// Resumes the journal of a study, or begins one: another study's is overwritten.
    ///
    /// # Errors
    /// A file that cannot be written, or that another run writes to meanwhile ([`io::ErrorKind::ResourceBusy`]).
    pub fn open(path: &Path, study: &str) -> io::Result<Self> {
        // Hold the file that is there until there is another one in its place: two runs would undo each other's work.
        let before = File::options().create(true).append(true).open(path)?;
        hold(&before)?;
        if !is_at(&before, path) {
            return Err(busy());
        }
        let mut done = BTreeMap::new();
        if let Ok(text) = fs::read_to_string(path) {
            let mut lines = text.lines().map_while(|line| serde_json::from_str::<(String, Value)>(line).ok());
            if lines.next().is_some_and(|(word, name)| word == STUDY && name == study) {
                done.extend(lines);
            }
        }
        let mut kept = Vec::new();
        write_line(&mut kept, STUDY, &Value::from(study))?;
        for (part, value) in &done {
            write_line(&mut kept, part, value)?;
        }
        // Whole or not at all: what was done before is not lost if this fails.
        vr_io::write_bytes(path, &kept).map_err(io::Error::other)?;
        let file = File::options().append(true).open(path)?;
        hold(&file)?;
        Ok(Self { path: path.into(), done, file })
    }

    /// Returns the result of a part: the noted one, or one that is made now and noted.
    ///
    /// # Errors
    /// Any error of `make`, and a file that cannot be written.
    pub fn part<T, E>(&mut self, name: &str, make: impl FnOnce() -> Result<T, E>) -> Result<T, E>
    where
        T: Serialize + DeserializeOwned,
        E: From<io::Error>,
    {
        if let Some(value) = self.noted(name) {
            return Ok(value);
        }
        let made = make()?;
        self.note(name, &made)?;
        Ok(made)
    }

    /// Returns the noted result of a part; `None` where there is none, or an older program noted it in another form.
    pub fn noted<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        serde_json::from_value(self.done.get(name)?.clone()).ok()
    }

    /// Notes the result of a part, in place of one that was noted before.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn note(&mut self, name: &str, result: &impl Serialize) -> io::Result<()> {
        let value = serde_json::to_value(result)?;
        write_line(&mut self.file, name, &value)?;
        self.done.insert(name.to_owned(), value);
        Ok(())
    }

    /// Returns the names of all parts that are noted, sorted.
    pub fn parts(&self) -> impl Iterator<Item = &str> {
        self.done.keys().map(String::as_str)
    }

    /// Removes the file: the study is done, and nothing is left to resume.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn finish(self) -> io::Result<()> {
        drop(self.file);
        fs::remove_file(&self.path)
    }
}

const STUDY: &str = "study";

/// Locks a file for as long as it is open. Where a file system has no locks, runs are not told apart.
fn hold(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(busy()),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

fn busy() -> io::Error {
    let message = "another run writes there; wait for its end, or name another folder";
    io::Error::new(io::ErrorKind::ResourceBusy, message)
}

/// True if a file is still the one at its path: another run may have put one in its place before the lock was had.
fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let identity = |place: io::Result<fs::Metadata>| place.map(|place| (place.dev(), place.ino())).ok();
        identity(file.metadata()) == identity(fs::metadata(path))
    }
    #[cfg(not(unix))]
    {
        // Files that are open are not replaced there.
        let _ = (file, path);
        true
    }
}

fn write_line(file: &mut impl Write, part: &str, value: &Value) -> io::Result<()> {
    let mut line = serde_json::to_string(&(part, value))?;
    line.push('\n');
    file.write_all(line.as_bytes())?;
    file.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(path: &Path, study: &str, parts: &[&str]) -> Vec<String> {
        let mut journal = Journal::open(path, study).unwrap();
        let mut made = Vec::new();
        for part in parts {
            let value: io::Result<Vec<f64>> = journal.part(part, || {
                made.push((*part).to_owned());
                Ok(vec![0.1 + 0.2, 1e-300])
            });
            assert_eq!(value.unwrap(), [0.1 + 0.2, 1e-300], "bit for bit, kept or not");
        }
        made
    }

    #[test]
    fn one_run_at_a_time_has_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let mut first = Journal::open(&path, "one").unwrap();
        first.note("a", &1).unwrap();
        let refused = Journal::open(&path, "one").unwrap_err();
        assert_eq!(refused.kind(), io::ErrorKind::ResourceBusy, "{refused}");
        first.note("b", &2).unwrap();
        drop(first);
        let second = Journal::open(&path, "one").unwrap();
        assert_eq!(second.parts().collect::<Vec<_>>(), ["a", "b"], "nothing is lost");
    }

    #[test]
    fn a_study_is_taken_up_where_it_stopped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        assert_eq!(run(&path, "one", &["a", "b"]), ["a", "b"]);
        assert_eq!(run(&path, "one", &["a", "b", "c"]), ["c"]);
        // Cut in the middle of the last line.
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, &text[..text.len() - 4]).unwrap();
        assert_eq!(run(&path, "one", &["a", "b", "c"]), ["c"]);
        assert_eq!(run(&path, "other", &["a"]), ["a"]);
        let mut journal = Journal::open(&path, "other").unwrap();
        journal.note("a", &7).unwrap();
        journal.note("b", &8).unwrap();
        drop(journal);
        let journal = Journal::open(&path, "other").unwrap();
        assert_eq!((journal.noted("a"), journal.noted::<String>("b"), journal.noted::<u8>("c")), (Some(7), None, None));
        assert_eq!(journal.parts().collect::<Vec<_>>(), ["a", "b"]);
        journal.finish().unwrap();
        assert!(!path.exists());
    }
}
