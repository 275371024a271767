//! Names of files in scene files.

use std::ffi::OsStr;
use std::fmt;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize, Serializer};

/// Path of a file that a scene names, relative to the scene file.
///
/// A path is bytes, and a scene file is text: where a name is not UTF-8, the text has marks (U+FFFD) in place of what is not, and does not
/// lead to the file. The value itself does.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(from = "PathBuf")]
pub struct FileName(PathBuf);

impl Serialize for FileName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0.to_string_lossy())
    }
}

impl Deref for FileName {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<Path> for FileName {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

impl fmt::Display for FileName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.display().fmt(f)
    }
}

impl<T: AsRef<OsStr>> From<T> for FileName {
    fn from(path: T) -> Self {
        Self(path.as_ref().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_through_text_and_the_rest_is_marked() {
        #[derive(Serialize, Deserialize, PartialEq, Debug)]
        struct Section {
            path: FileName,
        }
        let section = Section { path: "sub/µ \"1\".nrrd".into() };
        let text = toml::to_string(&section).unwrap();
        assert_eq!(toml::from_str::<Section>(&text).unwrap(), section);
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStrExt;
            let section = Section { path: OsStr::from_bytes(b"caf\xe9.nrrd").into() };
            assert_eq!(toml::to_string(&section).unwrap(), "path = \"caf\u{fffd}.nrrd\"\n");
            assert_eq!(section.path.as_os_str().as_bytes(), b"caf\xe9.nrrd");
        }
    }
}
