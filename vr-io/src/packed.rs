//! Files that may be compressed as a whole: their first bytes, and all of them.

use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::encoding::Encoding;
use crate::error::{FileError, FileErrorKind};
use crate::read::file_head;
use crate::regular_file;

/// A file, and the compression that its first bytes show.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    pub path: PathBuf,
    pub encoding: Encoding,
}

impl Packed {
    pub fn new(path: &Path) -> Result<Self, FileError> {
        let head = file_head(path).map_err(|e| FileError::new(path, e))?;
        Ok(Self { path: path.into(), encoding: Encoding::of_file(&head) })
    }

    /// The unpacked bytes, from the first one on.
    pub fn reader(&self) -> Result<Box<dyn Read>, FileError> {
        let io = |e| FileError::new(&self.path, e);
        let file = regular_file::open(&self.path).map_err(io)?;
        Ok(self.encoding.reader(BufReader::with_capacity(1 << 16, file)))
    }

    /// The unpacked bytes, after the first `skip`; fewer bytes than that are an error.
    pub fn reader_after(&self, skip: u64) -> Result<Box<dyn Read>, FileError> {
        let mut reader = self.reader()?;
        let skipped = io::copy(&mut reader.by_ref().take(skip), &mut io::sink()).map_err(|e| self.damaged(e))?;
        if skipped < skip {
            return Err(self.damaged(io::ErrorKind::UnexpectedEof.into()));
        }
        Ok(reader)
    }

    /// The first unpacked bytes; fewer where the file is shorter, or cut off.
    pub fn head(&self, length: u64) -> Result<Vec<u8>, FileError> {
        let mut head = Vec::new();
        match self.reader()?.take(length).read_to_end(&mut head) {
            Err(e) if self.encoding == Encoding::Raw => Err(FileError::new(&self.path, e)),
            // The parser of the format tells what is missing.
            Err(e) if e.kind() != io::ErrorKind::UnexpectedEof => Err(self.damaged(e)),
            _ => Ok(head),
        }
    }

    pub fn damaged(&self, source: io::Error) -> FileError {
        FileError::new(&self.path, FileErrorKind::Damaged { encoding: self.encoding.name(), source })
    }
}
