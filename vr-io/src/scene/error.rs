//! Errors of scene files.

use std::path::{Path, PathBuf};

use vr_core::ParameterError;
use vr_core::memory::MemoryError;

use crate::error::{FileError, shown, shown_path, shown_with_quotes};
use crate::picture_read::PictureError;

use super::wrong_value::explained;

/// The reason why a scene file gives no scene. Every message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneFileError {
    /// The file itself, or one that it names: a volume, points, a mesh, a colour map.
    #[error(transparent)]
    File(#[from] FileError),
    /// Too little memory for what the scene asks for.
    #[error("{}{source}", place(path, None))]
    Memory {
        /// The file; empty where the scene is from none.
        path: PathBuf,
        /// The name of what does not fit, its size, and the memory that is left.
        source: MemoryError,
    },
    /// The picture of an environment map.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A key that means nothing.
    #[error("{}unknown key '{key}'; {}", place(path, *line), hint(nearest.as_deref(), known))]
    UnknownKey {
        /// The file.
        path: PathBuf,
        /// The line, from 1, where it is known.
        line: Option<usize>,
        /// The key found.
        key: String,
        /// The known key most like it.
        nearest: Option<String>,
        /// All keys that would be right there.
        known: Vec<String>,
    },
    /// Not TOML, a value of the wrong type, or keys of `[volume]` that do not go together.
    #[error("{}{message}", place(path, *line))]
    Syntax {
        /// The file.
        path: PathBuf,
        /// The line, from 1, where it is known.
        line: Option<usize>,
        /// The parser's message.
        message: String,
    },
    /// A value that makes no sense.
    #[error("{}{source}", place(path, None))]
    Parameter {
        /// The file; empty where the scene is from none.
        path: PathBuf,
        /// The field, what was found and what is allowed.
        source: ParameterError,
    },
    /// A scene that cannot be put into text.
    #[error("the scene cannot be written as TOML: {message}")]
    Text {
        /// The reason.
        message: String,
    },
}

impl SceneFileError {
    pub(crate) fn of_toml(error: &toml::de::Error, text: &str, path: &Path) -> Self {
        let line =
            error.span().map(|span| text.as_bytes()[..span.start.min(text.len())].split(|&c| c == b'\n').count());
        let path = path.to_owned();
        // serde lists what it knows in backquotes, after the key that it does not.
        let mut quoted = error.message().split('`').skip(1).step_by(2).map(str::to_owned);
        match quoted.next() {
            Some(key) if error.message().starts_with("unknown field") => {
                let known: Vec<String> = quoted.collect();
                let nearest = nearest(&key, &known).map(str::to_owned);
                Self::UnknownKey { path, line, key: shown(&key), nearest, known }
            }
            _ => {
                let at = error.span().map_or(0, |span| span.start);
                Self::Syntax { path, line, message: explained(error.message(), text, at) }
            }
        }
    }
}

/// The word most like this one, unless none is.
fn nearest<'a>(word: &str, known: &'a [impl AsRef<str>]) -> Option<&'a str> {
    known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(k.as_ref(), word), k.as_ref()))
        .min()
        .filter(|&(distance, k)| distance <= 2.max(k.len() / 2))
        .map(|(_, k)| k)
}

/// Makes the complaint about a name that is not known, with the known one most like it.
pub(super) fn unknown_name(field: &str, name: &str, known: &[&str], allowed: &'static str) -> ParameterError {
    let near = nearest(name, known).map_or_else(String::new, |n| format!(" (did you mean '{n}'?)"));
    ParameterError { field: field.into(), found: format!("'{}'{near}", shown_with_quotes(name)), allowed }
}

/// `file: line 3: `, as far as it is known.
fn place(path: &Path, line: Option<usize>) -> String {
    let mut place = String::new();
    if !path.as_os_str().is_empty() {
        place = format!("{}: ", shown_path(path));
    }
    if let Some(line) = line {
        place += &format!("line {line}: ");
    }
    place
}

fn hint(nearest: Option<&str>, known: &[String]) -> String {
    match nearest {
        Some(n) => format!("did you mean '{n}'?"),
        None => format!("must be one of {}", known.join(", ")),
    }
}
