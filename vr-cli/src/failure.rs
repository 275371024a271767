//! Failures of the program, and their exit codes.

use std::fmt;
use std::process::ExitCode;

/// The end of a command that did not succeed. Its text is one line.
#[derive(Debug)]
pub enum Failure {
    /// The command line asks for something impossible: exit code 2.
    Usage(String),
    /// The command line is fine, and something else is not (a file, the scene in it, the disk): exit code 1.
    Failed(String),
    /// Everything is done and written, and an error bound is not proven for every pixel: exit code 3.
    Unproven(String),
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

    /// Exit code for the shell.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Failed(_) => ExitCode::from(1),
            Self::Unproven(_) => ExitCode::from(3),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) | Self::Failed(message) | Self::Unproven(message) => f.write_str(message),
        }
    }
}

/// Messages of libraries (TOML and clap among them) may run over several lines: a person greps, and a script reads, one.
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
