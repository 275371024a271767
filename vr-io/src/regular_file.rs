//! The one way to open a file that is read. Devices, pipes and sockets are refused before they are opened: they may never end, and opening
//! a pipe blocks until another process writes to it.

use std::fs::{self, File, FileType};
use std::io::{self, Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use vr_core::memory;

use crate::memory_folder::{self, MemoryFile};
use crate::polled::Polled;

/// Longest text that a person writes, and that is parsed as a whole: four times a scene file with a volume of 64³ voxels in it.
pub(crate) const MAX_TEXT: u64 = 1 << 24;

/// A file that is read, until the work that reads it is cancelled.
pub(crate) type RegularFile = Polled<Opened>;

impl RegularFile {
    /// Length in bytes.
    pub fn length(&self) -> io::Result<u64> {
        match self.get_ref() {
            Opened::Disk(file) => Ok(file.metadata()?.len()),
            Opened::Memory(bytes) => Ok(bytes.get_ref().as_ref().len() as u64),
        }
    }

    /// The file of the system; `None` for one in memory.
    pub fn on_disk(&self) -> Option<&File> {
        match self.get_ref() {
            Opened::Disk(file) => Some(file),
            Opened::Memory(_) => None,
        }
    }
}

/// An open file.
#[derive(Debug)]
pub(crate) enum Opened {
    /// One of the system.
    Disk(File),
    /// One of a [`MemoryFolder`](crate::MemoryFolder).
    Memory(Cursor<SharedBytes>),
}

/// Bytes of a file in memory, as a stream reads them.
#[derive(Debug)]
pub(crate) struct SharedBytes(MemoryFile);

impl AsRef<[u8]> for SharedBytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Read for Opened {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Disk(file) => file.read(out),
            Self::Memory(bytes) => bytes.read(out),
        }
    }
}

impl Seek for Opened {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        match self {
            Self::Disk(file) => file.seek(place),
            Self::Memory(bytes) => bytes.seek(place),
        }
    }
}

/// Opens a file.
///
/// # Errors
/// Those of the system, and [`ErrorKind::InvalidInput`] for anything but a regular file.
pub(crate) fn open(path: &Path) -> io::Result<RegularFile> {
    if let Some(found) = memory_folder::find(path) {
        return Ok(Polled::new(Opened::Memory(Cursor::new(SharedBytes(found?)))));
    }
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() {
        let message = format!("is {}; must be a regular file", name_of(kind));
        return Err(io::Error::new(ErrorKind::InvalidInput, message));
    }
    Ok(Polled::new(Opened::Disk(File::open(path)?)))
}

/// Reads a whole file of at most `limit` bytes.
///
/// # Errors
/// Those of [`open`], and [`ErrorKind::FileTooLarge`] for a longer file.
pub(crate) fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let too_large = |found: u64| {
        let message = format!("has {found} bytes or more; at most {limit} are read of such a file");
        io::Error::new(ErrorKind::FileTooLarge, message)
    };
    let length = file.length()?;
    if length > limit {
        return Err(too_large(length));
    }
    memory::check("the file", length).map_err(|e| io::Error::new(ErrorKind::OutOfMemory, e))?;
    // It may grow at this moment; room for the end of the file is what tells it from the middle.
    let mut bytes = Vec::with_capacity(length as usize + 1);
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(limit + 1));
    }
    Ok(bytes)
}

/// Reads a whole file of UTF-8, of at most `limit` bytes.
///
/// # Errors
/// Those of the system, [`ErrorKind::InvalidInput`] for anything but a regular file, [`ErrorKind::FileTooLarge`] for a longer one, and
/// [`ErrorKind::InvalidData`] for other bytes, naming the first of them.
pub fn read_text(path: impl AsRef<Path>, limit: u64) -> io::Result<String> {
    String::from_utf8(read(path.as_ref(), limit)?).map_err(|e| {
        let message = format!("is no text: byte {} is not UTF-8", e.utf8_error().valid_up_to());
        io::Error::new(ErrorKind::InvalidData, message)
    })
}

fn name_of(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    if kind.is_dir() { "a folder" } else { "something else than a file" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_a_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        fs::write(&path, "µ12").unwrap();
        assert_eq!(read_text(&path, 4).unwrap(), "µ12");
        let error = read_text(&path, 3).unwrap_err();
        assert_eq!(error.to_string(), "has 4 bytes or more; at most 3 are read of such a file");
        fs::write(&path, b"ab\xff").unwrap();
        assert_eq!(read_text(&path, 9).unwrap_err().to_string(), "is no text: byte 2 is not UTF-8");
        assert!(open(folder.path()).unwrap_err().to_string().starts_with("is a folder"));
    }

    #[cfg(unix)]
    #[test]
    fn what_may_never_end_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert!(open(&socket).unwrap_err().to_string().starts_with("is a socket"));
        for device in ["/dev/zero", "/dev/null"] {
            assert!(open(Path::new(device)).unwrap_err().to_string().starts_with("is a device"), "{device}");
        }
    }
}
