//! Small text files with a format version: read, written, and refused if newer or too large.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::MusicError;

/// The format version of preset and show files that this program writes.
pub const FORMAT_VERSION: u32 = 4;

#[derive(Deserialize)]
struct Version {
    format_version: u32,
}

/// The version of a text, which is read first: a newer file may have unknown fields.
pub(crate) fn version(kind: &'static str, text: &str) -> Result<u32, MusicError> {
    let version: Version = parse(kind, text)?;
    if version.format_version > FORMAT_VERSION {
        return Err(MusicError::Version { kind, found: version.format_version, known: FORMAT_VERSION });
    }
    Ok(version.format_version)
}

pub(crate) fn parse<T: DeserializeOwned>(kind: &'static str, text: &str) -> Result<T, MusicError> {
    toml::from_str(text).map_err(|error: toml::de::Error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        let line = 1 + before.matches('\n').count();
        let why = chladni_task::newer(&error.message().trim().replace('\n', " "));
        MusicError::Parse { kind, why: format!("line {line}: {why}") }
    })
}

pub(crate) fn print<T: Serialize>(kind: &'static str, value: &T) -> Result<String, MusicError> {
    toml::to_string(value).map_err(|error| MusicError::Parse { kind, why: error.to_string() })
}

/// `text`, unless a file of it would be too large to be [read] again: the work in it would be lost.
pub(crate) fn readable(kind: &'static str, text: String, most_mib: u64) -> Result<String, MusicError> {
    if text.len() as u64 > most_mib << 20 {
        let why = format!("larger than the {most_mib} MiB that are read of such a file");
        return Err(MusicError::Parse { kind, why });
    }
    Ok(text)
}

pub(crate) fn read(path: &Path, most_mib: u64) -> Result<String, MusicError> {
    chladni_task::read_text_file(path, most_mib << 20)
        .map_err(|why| MusicError::File { path: path.to_owned(), why })
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), MusicError> {
    chladni_task::write_atomic(path, text.as_bytes())
        .map_err(|why| MusicError::File { path: path.to_owned(), why })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_would_not_be_read_again_is_refused() {
        let of = |bytes: usize| readable("show", "-".repeat(bytes), 1);
        assert_eq!(of(1 << 20).unwrap().len(), 1 << 20);
        assert!(of((1 << 20) + 1).unwrap_err().to_string().contains("larger than the 1 MiB"));
    }
}
