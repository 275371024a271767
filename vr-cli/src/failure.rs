//! Why the program ends without what was asked for, and the exit code that says so.

use std::fmt;
use std::process::ExitCode;

/// The end of a command that did not succeed. Its text is one line.
#[derive(Debug)]
pub enum Failure {
    /// The command line asks for what cannot be: exit code 2.
    Usage(String),
    /// The command line is fine, and something else is not (a file, the scene in it, the disk): exit code 1.
    Failed(String),
    /// Everything is done and written, and a promised error is not proven for every pixel: exit code 3.
    Promise(String),
}

impl Failure {
    /// The command line is wrong.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self::Usage(one_line(&message.to_string()))
    }

    /// Something other than the command line is wrong.
    pub fn failed(message: impl fmt::Display) -> Self {
        Self::Failed(one_line(&message.to_string()))
    }

    /// What the shell is told.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Failed(_) => ExitCode::from(1),
            Self::Promise(_) => ExitCode::from(3),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) | Self::Failed(message) | Self::Promise(message) => f.write_str(message),
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
