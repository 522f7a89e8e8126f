//! How a command fails: one line for a person and an exit code for a script.

use std::fmt::Display;

use chladni_task::Cancelled;

/// Why a command did not do what it was asked.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// A file or an argument is wrong; the line names it and the reason. Exit code 2.
    #[error("{0}")]
    BadInput(String),
    /// Anything else, such as a full disk. Exit code 1.
    #[error("{0}")]
    Other(String),
    /// The user pressed Ctrl-C. Exit code 1.
    #[error("cancelled; no unfinished file is left")]
    Cancelled,
}

impl Failure {
    /// Bad input, described by an error that already names file and reason.
    pub fn input(error: impl Display) -> Self {
        Self::BadInput(error.to_string())
    }

    /// A failure of the machine rather than of the input.
    pub fn other(error: impl Display) -> Self {
        Self::Other(error.to_string())
    }

    /// Writing `path` failed.
    pub fn writing(path: &std::path::Path, error: impl Display) -> Self {
        Self::Other(format!("{}: cannot be written: {error}", path.display()))
    }

    /// 2 for bad input or arguments, 1 for anything else.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::BadInput(_) => 2,
            Self::Other(_) | Self::Cancelled => 1,
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
