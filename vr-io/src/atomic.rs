//! Files that appear whole or not at all: written beside their place under another name, then renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use crate::error::WriteError;
use crate::polled::Polled;
use crate::unfinished;

/// A seekable place to write to.
pub(crate) trait Output: Write + Seek {}
impl<T: Write + Seek> Output for T {}

/// Writes a file of any bytes: all of it, or nothing at all.
///
/// # Errors
/// A [`WriteError`] naming the file; what was there before is as it was.
pub fn write_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), WriteError> {
    let path = path.as_ref();
    write_whole(path, |out| out.write_all(bytes).map_err(|source| WriteError::Io { path: path.into(), source }))
}

/// Writes a file by way of a temporary one in the same folder. When anything fails, nothing is left behind, and a file that
/// was there before is as it was.
pub(crate) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Output) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    let failed = |source| WriteError::Io { path: path.into(), source };
    match fs::metadata(path) {
        Ok(place) if place.is_dir() => return Err(failed(io::ErrorKind::IsADirectory.into())),
        // Something like /dev/null takes what it is given; it must not be replaced by a file.
        Ok(place) if !place.is_file() => {
            let mut out = BufWriter::new(Polled::new(File::options().write(true).open(path).map_err(failed)?));
            write(&mut out)?;
            return out.flush().map_err(failed);
        }
        _ => {}
    }
    // Through a link, the file that it points to is replaced, not the link.
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let folder = place.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (mut temporary, _under_way) = unfinished::file_in(folder).map_err(failed)?;
    let mut out = BufWriter::new(Polled::new(&mut temporary));
    write(&mut out)?;
    out.flush().map_err(failed)?;
    drop(out);
    temporary.persist(&place).map_err(|e| failed(e.error))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failure_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.bin");
        write_whole(&path, |out| {
            out.write_all(b"old").unwrap();
            Ok(())
        })
        .unwrap();
        let failed = write_whole(&path, |out| {
            out.write_all(b"half of the new").unwrap();
            Err(WriteError::Encode { path: path.clone(), message: "no".into() })
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }

    #[test]
    fn places_that_cannot_be_written() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_whole(folder.path(), |_| Ok(())).unwrap_err();
        assert!(error.to_string().contains("cannot be written"), "{error}");
        assert!(write_whole(&folder.path().join("no/such/folder/x.png"), |_| Ok(())).is_err());
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    }
}
