//! What a person, or a script, gets to read: results on stdout, everything else on stderr.

use std::io::{self, ErrorKind, Write};

use serde::Serialize;

use crate::failure::Failure;

/// Where results and remarks go.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// Nothing but errors.
    pub quiet: bool,
    /// Results for machines.
    pub json: bool,
}

impl Console {
    /// One line about what was assumed or chosen.
    pub fn note(self, note: &str) {
        if !self.quiet {
            // Nobody is left to tell when stderr is closed.
            let _ = writeln!(io::stderr(), "note: {note}");
        }
    }

    /// The result: text for people, or one JSON object.
    ///
    /// # Errors
    /// A full disk, say. A reader that went away (`vr info | head -1`) is no failure.
    pub fn result(self, text: &str, json: &impl Serialize) -> Result<(), Failure> {
        let text = match (self.json, self.quiet) {
            (true, _) => serde_json::to_string_pretty(json).map_err(Failure::failed)?,
            (false, true) => return Ok(()),
            (false, false) => text.trim_end().to_owned(),
        };
        let mut out = io::stdout().lock();
        match writeln!(out, "{text}").and_then(|()| out.flush()) {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(Failure::failed(format!("stdout: {e}"))),
            _ => Ok(()),
        }
    }

    /// Why nothing came of it, in one line.
    pub fn error(failure: &Failure) {
        let _ = writeln!(io::stderr(), "error: {failure}");
    }
}
