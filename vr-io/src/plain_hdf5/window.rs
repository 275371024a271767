//! Parts of a file, none of which is read beyond its end.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use crate::error::FileErrorKind;
use crate::regular_file::{self, RegularFile};

use super::damaged;

/// A file that is read here and there.
pub(super) struct Window {
    file: RegularFile,
    length: u64,
}

impl Window {
    pub fn open(path: &Path) -> Result<Self, FileErrorKind> {
        let file = regular_file::open(path)?;
        let length = file.length()?;
        Ok(Self { file, length })
    }

    /// So many bytes from a place on.
    pub fn bytes(&mut self, at: u64, count: u64) -> Result<Vec<u8>, FileErrorKind> {
        let bytes = self.up_to(at, count)?;
        if bytes.len() as u64 == count { Ok(bytes) } else { Err(damaged(at, "the end of the file")) }
    }

    /// So many bytes from a place on, or fewer at the end of the file.
    pub fn up_to(&mut self, at: u64, count: u64) -> Result<Vec<u8>, FileErrorKind> {
        let mut bytes = Vec::new();
        if at < self.length {
            self.file.seek(SeekFrom::Start(at))?;
            (&mut self.file).take(count).read_to_end(&mut bytes)?;
        }
        Ok(bytes)
    }

    /// The number of 8 bytes at a place.
    pub fn word(&mut self, at: u64) -> Result<u64, FileErrorKind> {
        word(&self.bytes(at, 8)?, 0).ok_or_else(|| damaged(at, "the end of the file"))
    }
}

/// The number of 8 bytes in some bytes, if they are so many.
pub(super) fn word(bytes: &[u8], from: usize) -> Option<u64> {
    bytes.get(from..)?.first_chunk().map(|b| u64::from_le_bytes(*b))
}
