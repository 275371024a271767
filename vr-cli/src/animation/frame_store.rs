//! Frames on disk, with a journal of what made them, so that an interrupted animation goes on where it stopped.

use std::fs;
use std::io;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use vr_core::Counts;
use vr_study::journal::Journal;

use crate::console::Console;
use crate::failure::Failure;

use super::places::FramePlace;

/// Files of the frames, and the journal beside them.
pub struct FrameStore {
    /// Files of all frames.
    pub files: Vec<PathBuf>,
    names: Vec<String>,
    place: FramePlace,
    journal: Journal,
}

/// Entry of the journal about a frame.
#[derive(Debug, Serialize, Deserialize)]
struct Note {
    /// Hash of everything that the frame depends on.
    made_of: String,
    /// Hash of the file.
    file: String,
    rays: u64,
    samples: u64,
    unbounded: u64,
    /// Largest bound of those; absent where one has none.
    max_unbounded: Option<f64>,
}

/// First line of every journal of frames.
const STUDY: &str = "frames of vr, 1";

impl FrameStore {
    /// Opens the place of some frames. Frames of an earlier run that has more of them are removed.
    ///
    /// # Errors
    /// A place that cannot be written; a file in the place of a frame that is none, unless `force` gives it up.
    pub fn open(place: FramePlace, count: usize, force: bool, console: Console) -> Result<Self, Failure> {
        let failed = |e: io::Error| Failure::failed(format!("{}: cannot be written: {e}", place.folder.display()));
        if place.is_own_folder && !place.folder.is_dir() {
            fs::create_dir(&place.folder).map_err(failed)?;
        }
        let names =
            vr_io::numbered_names(&place.pattern, count).map_err(|e| Failure::usage(format!("--output: {e}")))?;
        let before = place.pattern.split('%').next().unwrap_or_default();
        let journal = Journal::open(&place.folder.join(format!("{before}journal.jsonl")), STUDY).map_err(failed)?;
        let files: Vec<PathBuf> = names.iter().map(|name| place.folder.join(name)).collect();
        let strange = |(name, file): &(&String, &PathBuf)| file.exists() && journal.noted::<Note>(name).is_none();
        if let Some((_, file)) = names.iter().zip(&files).find(strange).filter(|_| !force) {
            return Err(Failure::failed(format!(
                "{}: is there, and no frame of an earlier run; name another place, or replace it by --force",
                file.display()
            )));
        }
        let store = Self { files, names, place, journal };
        store.remove_others(console);
        Ok(store)
    }

    /// Removes frames of an earlier and longer run, which would be taken for some of this one.
    fn remove_others(&self, console: Console) {
        let others: Vec<&str> = self.journal.parts().filter(|name| !self.names.iter().any(|own| own == name)).collect();
        let file = |name: &str| self.place.folder.join(name);
        let unchanged = |name: &&&str| {
            let noted = self.journal.noted::<Note>(name);
            noted.zip(fs::read(file(name)).ok()).is_some_and(|(note, bytes)| note.file == hash(&bytes))
        };
        let removed = others.iter().filter(unchanged).filter(|name| fs::remove_file(file(name)).is_ok()).count();
        if removed > 0 {
            console.note(&format!("{removed} frames of an earlier, longer run are removed"));
        }
    }

    /// Returns the work of a frame that is there, whole, and made of the same.
    pub fn kept(&self, frame: usize, made_of: Option<&str>) -> Option<Counts> {
        let note: Note =
            self.journal.noted(&self.names[frame]).filter(|note: &Note| made_of == Some(note.made_of.as_str()))?;
        let bytes = fs::read(&self.files[frame]).ok()?;
        let Note { file, rays, samples, unbounded, max_unbounded, .. } = note;
        let max_unbounded = max_unbounded.unwrap_or(f64::INFINITY);
        (file == hash(&bytes)).then_some(Counts { rays, samples, unbounded, max_unbounded, ..Counts::default() })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// A file that cannot be written; it is then as it was.
    pub fn put(&mut self, frame: usize, made_of: Option<&str>, bytes: &[u8], counts: &Counts) -> Result<(), Failure> {
        let &Counts { rays, samples, unbounded, max_unbounded, .. } = counts;
        let note = Note {
            made_of: made_of.unwrap_or_default().to_owned(),
            file: hash(bytes),
            rays,
            samples,
            unbounded,
            max_unbounded: max_unbounded.is_finite().then_some(max_unbounded),
        };
        // A file that is not what the note says is drawn again: whatever fails between the two loses a frame at most.
        self.journal.note(&self.names[frame], &note).map_err(Failure::failed)?;
        vr_io::write_bytes(&self.files[frame], bytes).map_err(Failure::failed)
    }

    /// True if the frames are removed when the animation is written.
    pub fn is_temporary(&self) -> bool {
        self.place.is_temporary
    }

    /// Returns the folder and the pattern of the names.
    pub fn place(&self) -> &FramePlace {
        &self.place
    }

    /// Removes frames that were not asked for themselves, when the animation is written.
    pub fn finish(self, console: Console) {
        if !self.place.is_temporary {
            return;
        }
        for file in &self.files {
            // What is gone is removed.
            let _ = fs::remove_file(file);
        }
        let removed = self.journal.finish().and_then(|()| fs::remove_dir(&self.place.folder));
        if let Err(e) = removed {
            console.note(&format!("{}: cannot be removed: {e}", self.place.folder.display()));
        }
    }
}

fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(folder: &std::path::Path, count: usize, force: bool) -> Result<FrameStore, Failure> {
        let pattern = "f-%02d.png".to_owned();
        let place = FramePlace { folder: folder.into(), pattern, is_temporary: true, is_own_folder: true };
        FrameStore::open(place, count, force, Console { quiet: true, json: false })
    }

    #[test]
    fn frames_are_kept_if_they_are_whole_and_made_of_the_same() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("frames");
        let counts = Counts { rays: 7, unbounded: 1, max_unbounded: f64::INFINITY, ..Counts::default() };
        let mut store = open(&folder, 3, false).unwrap();
        for frame in 0..3 {
            store.put(frame, Some("key"), &[frame as u8; 9], &counts).unwrap();
        }
        drop(store);
        let store = open(&folder, 3, false).unwrap();
        assert_eq!(store.kept(1, Some("key")), Some(counts));
        assert_eq!((store.kept(1, Some("other")), store.kept(1, None)), (None, None));
        fs::write(folder.join("f-01.png"), [1; 8]).unwrap();
        fs::remove_file(folder.join("f-00.png")).unwrap();
        assert_eq!((store.kept(0, Some("key")), store.kept(1, Some("key"))), (None, None), "cut, and gone");
        assert!(store.kept(2, Some("key")).is_some());
        drop(store);
        // A shorter run leaves nothing behind that it could be taken for.
        let store = open(&folder, 2, false).unwrap();
        assert!(!folder.join("f-02.png").exists());
        store.finish(Console { quiet: true, json: false });
        assert!(!folder.exists());
    }

    #[test]
    fn other_files_are_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("f-01.png"), "mine").unwrap();
        let refused = open(folder.path(), 2, false).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains("f-01.png") && refused.contains("--force"), "{refused}");
        assert!(open(folder.path(), 2, true).is_ok());
    }
}
