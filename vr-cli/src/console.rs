//! Output for people and scripts: results on stdout, everything else on stderr.

use std::borrow::Cow;
use std::io::{self, ErrorKind, Write};

use serde::Serialize;

use crate::failure::Failure;

/// Output of results and remarks.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// True if only errors are printed.
    pub quiet: bool,
    /// True if results are JSON.
    pub json: bool,
}

impl Console {
    /// Prints one line about something assumed or chosen.
    pub fn note(self, note: &str) {
        if !self.quiet {
            // A closed stderr is no failure: there is no place left to report it.
            let _ = writeln!(io::stderr(), "note: {}", harmless(note));
        }
    }

    /// Prints the result: text for people, or one JSON object.
    ///
    /// # Errors
    /// A full disk, say. A reader that went away (`vr info | head -1`) is no failure.
    pub fn result(self, text: &str, json: &impl Serialize) -> Result<(), Failure> {
        match (self.json, self.quiet) {
            (true, _) => Self::page(&serde_json::to_string_pretty(json).map_err(Failure::failed)?),
            (false, true) => Ok(()),
            (false, false) => Self::page(text),
        }
    }

    /// Prints a text that was asked for by itself.
    ///
    /// # Errors
    /// Errors of [`Self::result`].
    pub fn page(text: &str) -> Result<(), Failure> {
        let mut out = io::stdout().lock();
        match writeln!(out, "{}", harmless(text.trim_end())).and_then(|()| out.flush()) {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::failed(format!("stdout: {e}"))),
            _ => Ok(()),
        }
    }

    /// Prints the reason of a failure in one line.
    pub fn error(failure: &Failure) {
        let _ = writeln!(io::stderr(), "error: {}", harmless(&failure.to_string()));
    }
}

/// Returns a text with all that could move a terminal's cursor, change its colours or turn its text around written as `\u{1b}`: names of
/// files, fields and arrays are a stranger's words. Line feeds and tabs stay.
fn harmless(text: &str) -> Cow<'_, str> {
    let acts = |c: char| {
        let turns_around = matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        turns_around || c.is_control() && !matches!(c, '\n' | '\t')
    };
    if !text.contains(acts) {
        return text.into();
    }
    let written = |c: char| if acts(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(written).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_terminal_obeys_is_printed() {
        assert_eq!(harmless("µ: 1\t2\n3"), "µ: 1\t2\n3");
        assert_eq!(harmless("a\x1b[31mb\r\u{9b}2J\u{202e}c\x07"), r"a\u{1b}[31mb\r\u{9b}2J\u{202e}c\u{7}");
    }
}
