//! Upload: files that a page sends in pieces, in a folder of their own until they are read: on a disk, or in memory.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use vr_core::clock::Instant;
use vr_core::memory::{self, MemoryError, bytes_text};

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
}

/// Folder for the files of an upload.
pub trait UploadFolder: Sized {
    /// Makes an empty one.
    ///
    /// # Errors
    /// Those of the system.
    fn empty() -> io::Result<Self>;

    /// Appends bytes to a file, which `is_new` has be made: one that is there already is an error then.
    ///
    /// # Errors
    /// Those of the system.
    fn append(&mut self, name: &str, is_new: bool, bytes: &[u8]) -> io::Result<()>;
}

/// Files on their way.
struct Upload<F> {
    id: String,
    folder: F,
    /// Bytes of each file so far.
    files: BTreeMap<String, u64>,
    announced: u64,
    last: Instant,
}

/// Place for one upload at a time.
pub struct Uploads<F> {
    /// Most bytes of the files of an upload.
    pub max_bytes: u64,
    current: Option<Upload<F>>,
}

impl<F: UploadFolder> Uploads<F> {
    /// A place for uploads of at most so many bytes.
    pub fn new(max_bytes: u64) -> Self {
        Self { max_bytes, current: None }
    }

    /// Begins an upload of so many bytes under a number that no other has. One that has been idle for long is given up for it.
    ///
    /// # Errors
    /// Too many bytes, too little memory, or an upload by another page.
    pub fn begin(&mut self, id: String, bytes: u64, now: Instant) -> Result<(), UploadError> {
        if self.current.as_ref().is_some_and(|upload| now.saturating_duration_since(upload.last) < IDLE) {
            return Err(UploadError::Busy);
        }
        if bytes > self.max_bytes {
            return Err(UploadError::Size { found: bytes, allowed: self.max_bytes });
        }
        memory::check("the file", bytes)?;
        let folder = F::empty()?;
        self.current = Some(Upload { id, folder, files: BTreeMap::new(), announced: bytes, last: now });
        Ok(())
    }

    /// Takes the next piece of a file.
    ///
    /// # Errors
    /// The reason why it is not taken; the upload goes on.
    pub fn piece(&mut self, id: &str, name: &str, offset: u64, bytes: &[u8], now: Instant) -> Result<(), UploadError> {
        let upload = self.current.as_mut().filter(|upload| upload.id == id).ok_or(UploadError::Unknown)?;
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
        upload.folder.append(name, !upload.files.contains_key(name), bytes)?;
        upload.files.insert(name.to_owned(), expected + bytes.len() as u64);
        upload.last = now;
        Ok(())
    }

    /// Ends an upload; returns the folder of its files.
    ///
    /// # Errors
    /// An upload that is over, or files that have not arrived as they were announced.
    pub fn end(&mut self, id: &str) -> Result<F, UploadError> {
        let upload = self.current.take_if(|upload| upload.id == id).ok_or(UploadError::Unknown)?;
        Ok(upload.folder)
    }
}

/// Files that can be opened.
#[derive(Serialize)]
pub struct Listing {
    /// True if other files can be opened at all.
    pub opens: bool,
    /// True if a folder was named.
    pub has_folder: bool,
    /// Paths below the folder, in order.
    pub files: Vec<String>,
    /// Most bytes of files that the page may send.
    pub max_upload: u64,
}

/// Size of the files to come.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeginQuery {
    /// Bytes of all of them.
    pub bytes: u64,
}

/// Number of an upload.
#[derive(Serialize)]
pub struct Begun {
    /// The number, to be given with each piece.
    pub id: String,
}

/// Name of a file, and where in it a piece begins.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PieceQuery {
    /// Name of the file.
    pub name: String,
    /// Byte of the file that the piece begins at.
    pub offset: u64,
}

/// Name of the file of an upload that is to be opened; empty for all of them, as the folder of a series.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NameQuery {
    /// Name of the file.
    pub name: String,
}

/// A text without the path of a folder.
pub fn without_folder(folder: &Path, text: &str) -> String {
    let folder = folder.display().to_string();
    text.replace(&format!("{folder}/"), "").replace(&format!("{folder}\\"), "").replace(&folder, "the files")
}

/// Checks that a name is that of a file in a folder, on every system.
///
/// # Errors
/// A name that is a path.
pub fn check_name(name: &str) -> Result<(), UploadError> {
    let is_part = !name.contains(['/', '\\', ':', '\0']) && !name.chars().any(char::is_control);
    let is_name = (1..=MAX_NAME).contains(&name.len()) && !matches!(name, "." | "..");
    if is_part && is_name { Ok(()) } else { Err(UploadError::Name(name.chars().take(MAX_NAME).collect())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files in memory.
    struct Shelf(BTreeMap<String, Vec<u8>>);

    impl UploadFolder for Shelf {
        fn empty() -> io::Result<Self> {
            Ok(Self(BTreeMap::new()))
        }

        fn append(&mut self, name: &str, is_new: bool, bytes: &[u8]) -> io::Result<()> {
            assert_eq!(is_new, !self.0.contains_key(name));
            self.0.entry(name.to_owned()).or_default().extend(bytes);
            Ok(())
        }
    }

    #[test]
    fn pieces_make_files_and_nothing_else() {
        let (now, id) = (Instant::now(), "7");
        let mut uploads = Uploads::<Shelf>::new(100);
        uploads.begin(id.to_owned(), 10, now).unwrap();
        uploads.piece(id, "a.raw", 0, b"12345", now).unwrap();
        uploads.piece(id, "a.raw", 5, b"67", now).unwrap();
        uploads.piece(id, "b", 0, b"8", now).unwrap();
        assert!(matches!(uploads.piece(id, "a.raw", 5, b"x", now), Err(UploadError::Offset { expected: 7, .. })));
        assert!(matches!(uploads.piece(id, "c", 1, b"x", now), Err(UploadError::Offset { expected: 0, .. })));
        assert!(matches!(uploads.piece(id, "b", 1, b"xyz", now), Err(UploadError::More(10))));
        assert!(matches!(uploads.piece("0123", "b", 1, b"x", now), Err(UploadError::Unknown)));
        for name in ["", ".", "..", "../b", "/b", "a/b", "a\\b", "c:b", "a\0b", "a\nb", &"x".repeat(201)] {
            assert!(matches!(uploads.piece(id, name, 0, b"x", now), Err(UploadError::Name(_))), "{name:?}");
        }
        let Shelf(files) = uploads.end(id).unwrap();
        assert!(matches!(uploads.end(id), Err(UploadError::Unknown)));
        assert_eq!((files.len(), &files["a.raw"][..]), (2, &b"1234567"[..]));
    }

    #[test]
    fn one_at_a_time_and_none_that_is_too_large() {
        let now = Instant::now();
        let mut uploads = Uploads::<Shelf>::new(100);
        let too_large = uploads.begin("1".to_owned(), 101, now);
        assert!(matches!(too_large, Err(UploadError::Size { found: 101, allowed: 100 })));
        uploads.begin("1".to_owned(), 100, now).unwrap();
        assert!(matches!(uploads.begin("2".to_owned(), 1, now + IDLE / 2), Err(UploadError::Busy)));
        uploads.begin("2".to_owned(), 1, now + IDLE).unwrap();
        assert!(matches!(uploads.piece("1", "a", 0, b"x", now), Err(UploadError::Unknown)));
        uploads.piece("2", "a", 0, b"x", now).unwrap();
    }
}
