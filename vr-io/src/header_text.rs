//! The text at the begin of a file, before anything of it is understood.

use std::io::{BufRead, BufReader, Read, Take};
use std::path::Path;

use crate::error::FileError;
use crate::regular_file::{self, RegularFile};

/// Reads a header line by line, as far as the parser of the format asks, and keeps the bytes read.
pub(crate) struct HeaderText<'p> {
    path: &'p Path,
    file: Take<BufReader<RegularFile>>,
    text: Vec<u8>,
}

impl<'p> HeaderText<'p> {
    /// Length at which a header ends, as if the file did: far beyond any sensible one, a list of a million files included.
    const LONGEST: u64 = 1 << 26;

    pub fn open(path: &'p Path) -> Result<Self, FileError> {
        let file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
        Ok(Self { path, file: BufReader::new(file).take(Self::LONGEST), text: Vec::new() })
    }

    /// The next line, with what ends it; empty at the end of the file.
    pub fn next_line(&mut self) -> Result<&[u8], FileError> {
        let from = self.text.len();
        self.file.read_until(b'\n', &mut self.text).map_err(|e| FileError::new(self.path, e))?;
        Ok(&self.text[from..])
    }

    /// Reads all the lines that are left.
    pub fn read_rest(&mut self) -> Result<(), FileError> {
        self.file.read_to_end(&mut self.text).map_err(|e| FileError::new(self.path, e))?;
        Ok(())
    }

    /// Returns all that was read, byte for byte.
    pub fn into_bytes(self) -> Vec<u8> {
        self.text
    }
}
