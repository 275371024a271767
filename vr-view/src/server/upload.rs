//! Upload: files that a page sends in pieces, in a folder of their own until they are read.

use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use vr_core::memory::{self, MemoryError, bytes_text};

use super::token::Token;

/// Most bytes of a piece.
pub const MAX_PIECE: usize = 4 << 20;
/// Most files that belong together: the slices of a series are some hundreds.
pub const MAX_FILES: usize = 4096;
/// Most bytes of a name.
const MAX_NAME: usize = 200;
/// Time without a piece after which an upload is given up, so that another page may send its own.
const IDLE: Duration = Duration::from_secs(30);

/// Reason why files, or a piece of one, are not taken.
#[derive(Debug, thiserror::Error)]
pub enum UploadError {
    /// Another page sends files.
    #[error("another page is sending a file: try again when it is done")]
    Busy,
    /// An upload that is over, or never was.
    #[error("this upload is over: send the file again")]
    Unknown,
    /// A name that is a path, or no name at all.
    #[error("name: found {0:?}; must be the name of a file alone, of 1 to 200 bytes, without folders")]
    Name(String),
    /// Files larger than what is allowed.
    #[error("size: found {}; must be {} at most", bytes_text(*.found), bytes_text(*.allowed))]
    Size {
        /// Bytes that were announced.
        found: u64,
        /// Bytes that are allowed.
        allowed: u64,
    },
    /// More bytes than were announced.
    #[error("size: found more bytes than the {} that were announced", bytes_text(*.0))]
    More(u64),
    /// A piece that does not begin where the one before has ended.
    #[error("offset: found {found}; must be {expected}, where the piece before has ended")]
    Offset {
        /// Place of the piece.
        found: u64,
        /// Place where it would have to begin.
        expected: u64,
    },
    /// Too many files.
    #[error("files: found more than {MAX_FILES}")]
    Files,
    /// Too little memory.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// A failure of the system.
    #[error("temporary folder: {}", .0.kind())]
    System(#[from] io::Error),
    /// No random number.
    #[error("the system gives no random numbers")]
    Random,
}

/// Files on their way.
struct Upload {
    id: Token,
    folder: TempDir,
    /// Bytes of each file so far.
    files: BTreeMap<String, u64>,
    announced: u64,
    last: Instant,
}

/// Place for one upload at a time.
pub struct Uploads {
    /// Most bytes of the files of an upload.
    pub max_bytes: u64,
    current: Option<Upload>,
}

/// Files that have arrived; gone when this is dropped.
pub struct Arrived {
    folder: TempDir,
}

impl Arrived {
    /// Path of a file, or of the folder of all of them where no name is given.
    ///
    /// # Errors
    /// A name that is a path.
    pub fn path(&self, name: &str) -> Result<PathBuf, UploadError> {
        if name.is_empty() {
            return Ok(self.folder.path().to_owned());
        }
        check_name(name)?;
        Ok(self.folder.path().join(name))
    }

    /// The folder, which is to stand in no message.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }
}

impl Uploads {
    /// A place for uploads of at most so many bytes.
    pub fn new(max_bytes: u64) -> Self {
        Self { max_bytes, current: None }
    }

    /// Begins an upload of so many bytes; returns its number. One that has been idle for long is given up for it.
    ///
    /// # Errors
    /// Too many bytes, too little memory, or an upload by another page.
    pub fn begin(&mut self, bytes: u64, now: Instant) -> Result<String, UploadError> {
        if self.current.as_ref().is_some_and(|upload| now.saturating_duration_since(upload.last) < IDLE) {
            return Err(UploadError::Busy);
        }
        if bytes > self.max_bytes {
            return Err(UploadError::Size { found: bytes, allowed: self.max_bytes });
        }
        memory::check("the file", bytes)?;
        let id = Token::random().map_err(|_| UploadError::Random)?;
        let folder = tempfile::Builder::new().prefix("vr-view-").tempdir()?;
        let text = id.text().to_owned();
        self.current = Some(Upload { id, folder, files: BTreeMap::new(), announced: bytes, last: now });
        Ok(text)
    }

    /// Takes the next piece of a file.
    ///
    /// # Errors
    /// The reason why it is not taken; the upload goes on.
    pub fn piece(&mut self, id: &str, name: &str, offset: u64, bytes: &[u8], now: Instant) -> Result<(), UploadError> {
        let upload = self.current.as_mut().filter(|upload| upload.id.is(id)).ok_or(UploadError::Unknown)?;
        check_name(name)?;
        let so_far: u64 = upload.files.values().sum();
        if so_far + bytes.len() as u64 > upload.announced {
            return Err(UploadError::More(upload.announced));
        }
        if upload.files.len() == MAX_FILES && !upload.files.contains_key(name) {
            return Err(UploadError::Files);
        }
        let expected = upload.files.get(name).copied().unwrap_or(0);
        if offset != expected {
            return Err(UploadError::Offset { found: offset, expected });
        }
        let path = upload.folder.path().join(name);
        // A name is new where nothing of it is here yet: names that differ in case may be one file.
        let mut options = OpenOptions::new();
        let options =
            if upload.files.contains_key(name) { options.append(true) } else { options.write(true).create_new(true) };
        options.open(path)?.write_all(bytes)?;
        upload.files.insert(name.to_owned(), expected + bytes.len() as u64);
        upload.last = now;
        Ok(())
    }

    /// Ends an upload; its files are those that have arrived.
    ///
    /// # Errors
    /// An upload that is over, or files that have not arrived as they were announced.
    pub fn end(&mut self, id: &str) -> Result<Arrived, UploadError> {
        let upload = self.current.take_if(|upload| upload.id.is(id)).ok_or(UploadError::Unknown)?;
        Ok(Arrived { folder: upload.folder })
    }
}

/// Checks that a name is that of a file in a folder, on every system.
fn check_name(name: &str) -> Result<(), UploadError> {
    let is_part = !name.contains(['/', '\\', ':', '\0']) && !name.chars().any(char::is_control);
    let is_name = (1..=MAX_NAME).contains(&name.len()) && !matches!(name, "." | "..");
    if is_part && is_name { Ok(()) } else { Err(UploadError::Name(name.chars().take(MAX_NAME).collect())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_make_files_and_nothing_else() {
        let now = Instant::now();
        let mut uploads = Uploads::new(100);
        let id = uploads.begin(10, now).unwrap();
        uploads.piece(&id, "a.raw", 0, b"12345", now).unwrap();
        uploads.piece(&id, "a.raw", 5, b"67", now).unwrap();
        uploads.piece(&id, "b", 0, b"8", now).unwrap();
        assert!(matches!(uploads.piece(&id, "a.raw", 5, b"x", now), Err(UploadError::Offset { expected: 7, .. })));
        assert!(matches!(uploads.piece(&id, "c", 1, b"x", now), Err(UploadError::Offset { expected: 0, .. })));
        assert!(matches!(uploads.piece(&id, "b", 1, b"xyz", now), Err(UploadError::More(10))));
        assert!(matches!(uploads.piece("0123", "b", 1, b"x", now), Err(UploadError::Unknown)));
        for name in ["", ".", "..", "../b", "/b", "a/b", "a\\b", "c:b", "a\0b", "a\nb", &"x".repeat(201)] {
            assert!(matches!(uploads.piece(&id, name, 0, b"x", now), Err(UploadError::Name(_))), "{name:?}");
        }
        let arrived = uploads.end(&id).unwrap();
        assert!(matches!(uploads.end(&id), Err(UploadError::Unknown)));
        assert_eq!(std::fs::read(arrived.path("a.raw").unwrap()).unwrap(), b"1234567");
        assert!(arrived.path("../a.raw").is_err());
        let folder = arrived.folder().to_owned();
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
        drop(arrived);
        assert!(!folder.exists());
    }

    #[test]
    fn one_at_a_time_and_none_that_is_too_large() {
        let now = Instant::now();
        let mut uploads = Uploads::new(100);
        assert!(matches!(uploads.begin(101, now), Err(UploadError::Size { found: 101, allowed: 100 })));
        let first = uploads.begin(100, now).unwrap();
        assert!(matches!(uploads.begin(1, now + IDLE / 2), Err(UploadError::Busy)));
        let second = uploads.begin(1, now + IDLE).unwrap();
        assert!(matches!(uploads.piece(&first, "a", 0, b"x", now), Err(UploadError::Unknown)));
        uploads.piece(&second, "a", 0, b"x", now).unwrap();
    }
}
