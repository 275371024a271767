//! Headers of text, taken word by word.

use std::io;
use std::path::Path;
use std::str::FromStr;

use crate::error::{FieldError, FileError};
use crate::regular_file;

/// Longest header: far beyond one of a million blocks.
const MAX_BYTES: u64 = 1 << 30;

/// Reads a file of text; what is no UTF-8 in it becomes marks.
pub(super) fn read_text(path: &Path) -> Result<String, FileError> {
    let in_file = |e: io::Error| FileError::new(path, e);
    let bytes = regular_file::read(path, MAX_BYTES).map_err(in_file)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// All whole numbers of a text, whatever stands between them; `None` where one is too large.
pub(super) fn integers(text: &str) -> Option<Vec<i64>> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || c == '-')).filter(|word| !word.is_empty());
    words.map(|word| word.parse().ok()).collect()
}

/// The rest of a text.
pub(super) struct Words<'t> {
    rest: &'t str,
}

impl<'t> Words<'t> {
    pub fn new(text: &'t str) -> Self {
        Self { rest: text }
    }

    /// The rest of the line, without blanks around it.
    pub fn line(&mut self, what: &str) -> Result<&'t str, FieldError> {
        if self.rest.is_empty() {
            return Err(FieldError::new(what, "the end of the file", "must follow"));
        }
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        Ok(line.trim())
    }

    /// The next word.
    pub fn word(&mut self, what: &str) -> Result<&'t str, FieldError> {
        let rest = self.rest.trim_start();
        let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return Err(FieldError::new(what, "the end of the file", "must follow"));
        }
        Ok(word)
    }

    /// The next word, as a number.
    pub fn number<T: FromStr>(&mut self, what: &str, allowed: &str) -> Result<T, FieldError> {
        let word = self.word(what)?;
        word.parse().map_err(|_| FieldError::new(what, word, allowed))
    }

    /// The next three numbers.
    pub fn triple(&mut self, what: &str) -> Result<[f64; 3], FieldError> {
        let mut numbers = [0.0; 3];
        for number in &mut numbers {
            *number = self.number(what, "must be three numbers")?;
        }
        Ok(numbers)
    }

    /// The text that has not been taken.
    pub fn rest(&self) -> &'t str {
        self.rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_lines() {
        let mut words = Words::new("a b\nc d \n\n7 x 1 2 3");
        assert_eq!((words.word("w").unwrap(), words.line("l").unwrap()), ("a", "b"));
        assert_eq!((words.line("l").unwrap(), words.number("n", "whole")), ("c d", Ok(7u32)));
        assert_eq!(words.number::<u32>("n", "must be whole").unwrap_err().to_string(), "n: found x; must be whole");
        assert_eq!(words.triple("t"), Ok([1.0, 2.0, 3.0]));
        assert!(words.word("more").unwrap_err().to_string().contains("more: found the end of the file"));
        assert_eq!(integers("((0,-1,2) (3"), Some(vec![0, -1, 2, 3]));
        assert_eq!(integers("99999999999999999999"), None);
    }
}
