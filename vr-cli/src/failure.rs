//! Failures of the program, and their exit codes.

use std::fmt;
use std::process::ExitCode;

use crate::interrupt;

/// Failure of a command. Its text is one line.
#[derive(Debug)]
pub enum Failure {
    /// Wrong command line: exit code 2.
    Usage(String),
    /// Failure of anything else (a file, the scene in it, the disk): exit code 1.
    Failed(String),
    /// Error bound that is not proven for every pixel, after everything was done and written: exit code 3.
    Unproven(String),
    /// Work that Ctrl-C has ended: exit code 130.
    Cancelled(String),
}

impl Failure {
    /// Returns a failure of the command line.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self::Usage(one_line(&message.to_string()))
    }

    /// Returns a failure of anything but the command line.
    pub fn failed(message: impl fmt::Display) -> Self {
        Self::Failed(one_line(&message.to_string()))
    }

    /// Returns the exit code for the shell.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Failed(_) => ExitCode::from(1),
            Self::Unproven(_) => ExitCode::from(3),
            Self::Cancelled(_) => ExitCode::from(interrupt::EXIT_CODE),
        }
    }

    /// Returns the same as the failure of a command that was cancelled.
    pub fn cancelled(self) -> Self {
        Self::Cancelled(self.to_string())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) | Self::Failed(message) | Self::Unproven(message) | Self::Cancelled(message) => {
                f.write_str(message)
            }
        }
    }
}

/// Joins the lines of a message, of which those of libraries (TOML and clap among them) may have several: people grep, and scripts read, one.
fn one_line(message: &str) -> String {
    message.split('\n').map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_one_line() {
        assert_eq!(Failure::usage("a\n  b\n\nc").to_string(), "a; b; c");
    }
}
