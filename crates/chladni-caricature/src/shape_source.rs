//! Where a project's shape comes from.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::Error;

/// The shape of a project: a file, or one of the program's samples.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum ShapeSource {
    /// A mesh file. Project files hold its path relative to their own folder.
    File(PathBuf),
    /// A sample shape, by name.
    Sample(String),
}

/// `sample:NAME` or a path.
impl std::str::FromStr for ShapeSource {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        match text.strip_prefix("sample:") {
            Some(name) => Ok(Self::Sample(name.to_owned())),
            None if text.is_empty() => Err(Error::syntax("shape", text, "is empty")),
            None => Ok(Self::File(PathBuf::from(text))),
        }
    }
}

impl std::fmt::Display for ShapeSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Sample(name) => write!(f, "sample:{name}"),
        }
    }
}

impl TryFrom<String> for ShapeSource {
    type Error = Error;

    fn try_from(text: String) -> Result<Self, Error> {
        text.parse()
    }
}

impl From<ShapeSource> for String {
    fn from(source: ShapeSource) -> Self {
        source.to_string()
    }
}
