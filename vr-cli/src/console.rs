//! Output for people and scripts: results on stdout, everything else on stderr.

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
            let _ = writeln!(io::stderr(), "note: {note}");
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
        match writeln!(out, "{}", text.trim_end()).and_then(|()| out.flush()) {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::failed(format!("stdout: {e}"))),
            _ => Ok(()),
        }
    }

    /// Prints the reason of a failure in one line.
    pub fn error(failure: &Failure) {
        let _ = writeln!(io::stderr(), "error: {failure}");
    }
}
