//! Presets and sessions as small text files.

use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::gallery::{GalleryItem, GalleryShape};
use crate::{Error, Instrument, LoggedAction, Mapping, Origin};

/// The format version of preset and session files that this program writes.
pub const FORMAT_VERSION: u32 = 1;

/// A mapping with a name: plays on any shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// 1.
    pub format_version: u32,
    /// What it is called.
    pub name: String,
    /// Words to find it by.
    #[serde(default)]
    pub tags: Vec<String>,
    /// The seed of the session it comes from.
    pub seed: u64,
    /// How the item came to be, then how its ancestors did, each named by id; newest first.
    #[serde(default)]
    pub lineage: Vec<Ancestor>,
    /// What it plays.
    pub mapping: Mapping,
}

/// One line of a lineage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ancestor {
    /// Its id in the session.
    pub id: u32,
    /// Its name there; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Whether it was edited by hand.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub edited: bool,
    /// How it came to be.
    #[serde(flatten)]
    pub origin: Origin,
}

/// The longest lineage that is written.
const MAX_LINEAGE: usize = 256;

/// How `item` came to be, then how its ancestors did, newest first; at most 256 of them.
pub fn lineage(instrument: &Instrument, item: &GalleryItem) -> Vec<Ancestor> {
    let mut lineage: Vec<Ancestor> = Vec::new();
    let mut queue = std::collections::VecDeque::from([item.id]);
    while let Some(id) = queue.pop_front() {
        if lineage.len() == MAX_LINEAGE || lineage.iter().any(|a| a.id == id) {
            continue;
        }
        let found = if id == item.id { Some(item) } else { instrument.item(id) };
        let Some(found) = found else { continue };
        match found.origin {
            Origin::Bred { parents } => queue.extend(parents),
            Origin::Mutated { parent } => queue.push_back(parent),
            Origin::Initial { .. } | Origin::Loaded { .. } => {}
        }
        let (name, origin) = (found.name.clone(), found.origin.clone());
        lineage.push(Ancestor { id, name, edited: found.edited, origin });
    }
    lineage
}

impl Preset {
    /// An item of an instrument as a preset, with its lineage.
    pub fn of(instrument: &Instrument, item: &GalleryItem, tags: Vec<String>) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            name: if item.name.is_empty() { format!("item {}", item.id) } else { item.name.clone() },
            tags,
            seed: instrument.seed(),
            lineage: lineage(instrument, item),
            mapping: item.mapping.clone(),
        }
    }

    /// Reads the text of a preset file. Errors name the line, or a newer format version.
    pub fn from_text(text: &str) -> Result<Self, Error> {
        let preset: Self = parse("preset", text)?;
        preset.mapping.validate()?;
        Ok(preset)
    }

    /// The text of a preset file.
    pub fn to_text(&self) -> Result<String, Error> {
        print("preset", self)
    }

    /// Reads a preset file of at most 16 MiB.
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::from_text(&read(path, 16)?)
    }

    /// Writes a preset file whole or not at all.
    pub fn save(&self, path: &Path) -> Result<(), Error> {
        write(path, &self.to_text()?)
    }
}

/// A session: what was played and all that was done, so that it can be rendered again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Session {
    /// 1.
    pub format_version: u32,
    /// The song's file, as the user named it; may be empty.
    #[serde(default)]
    pub song: String,
    /// The seed of the gallery.
    pub seed: u64,
    /// S.
    pub size: usize,
    /// All that was done, oldest first.
    #[serde(default)]
    pub actions: Vec<LoggedAction>,
}

impl Session {
    /// The session of an instrument that listened to `song`.
    pub fn of(instrument: &Instrument, song: &str) -> Self {
        Self {
            format_version: FORMAT_VERSION,
            song: song.to_owned(),
            seed: instrument.seed(),
            size: instrument.size(),
            actions: instrument.log().to_vec(),
        }
    }

    /// The instrument at its beginning, for a body; apply `actions` as time goes by.
    pub fn begin(&self, shape: GalleryShape) -> Result<Instrument, Error> {
        Instrument::new(self.seed, self.size, shape)
    }

    /// The instrument after all actions.
    pub fn replay(&self, shape: GalleryShape) -> Result<Instrument, Error> {
        let mut instrument = self.begin(shape)?;
        for line in &self.actions {
            instrument.apply(line.moment, line.action.clone())?;
        }
        Ok(instrument)
    }

    /// Reads the text of a session file.
    pub fn from_text(text: &str) -> Result<Self, Error> {
        parse("session", text)
    }

    /// The text of a session file.
    pub fn to_text(&self) -> Result<String, Error> {
        print("session", self)
    }

    /// Reads a session file of at most 64 MiB: hours of knobs that are turned all the time.
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::from_text(&read(path, 64)?)
    }

    /// Writes a session file whole or not at all.
    pub fn save(&self, path: &Path) -> Result<(), Error> {
        write(path, &self.to_text()?)
    }
}

#[derive(Deserialize)]
struct Version {
    format_version: u32,
}

fn parse<T: DeserializeOwned>(kind: &'static str, text: &str) -> Result<T, Error> {
    let bad = |error: toml::de::Error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        let line = 1 + before.matches('\n').count();
        Error::Parse { kind, why: format!("line {line}: {}", error.message().trim().replace('\n', " ")) }
    };
    // The version first: a newer file has fields of which nothing is known.
    let version: Version = toml::from_str(text).map_err(bad)?;
    if version.format_version > FORMAT_VERSION {
        return Err(Error::Version { kind, found: version.format_version, known: FORMAT_VERSION });
    }
    toml::from_str(text).map_err(bad)
}

fn print<T: Serialize>(kind: &'static str, value: &T) -> Result<String, Error> {
    toml::to_string(value).map_err(|error| Error::Parse { kind, why: error.to_string() })
}

fn read(path: &Path, most_mib: u64) -> Result<String, Error> {
    let file = |why| Error::File { path: path.to_owned(), why };
    let most = most_mib << 20;
    let mut text = String::new();
    // Not by what the system says of its size: a device or a pipe has none.
    let source = std::fs::File::open(path).map_err(file)?;
    source.take(most + 1).read_to_string(&mut text).map_err(file)?;
    if text.len() as u64 > most {
        let why = format!("larger than {most_mib} MiB");
        return Err(file(std::io::Error::new(std::io::ErrorKind::InvalidData, why)));
    }
    Ok(text)
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    chladni_task::write_atomic(path, text.as_bytes())
        .map_err(|why| Error::File { path: path.to_owned(), why })
}
