//! Where a shape comes from.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::{Known, Loaded, MeshError, Orientation, load_mesh, samples};

/// A mesh file, or one of the [`samples`]: what a user writes as a path or as `sample:NAME`.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum ShapeSource {
    /// A mesh file. Project files hold its path relative to their own folder.
    File(PathBuf),
    /// A sample, by name.
    Sample(String),
}

const SAMPLE: &str = "sample:";

impl ShapeSource {
    /// The source called `name`: a sample if it begins with `sample:`, else a file.
    pub fn named(name: impl Into<PathBuf>) -> Self {
        let path = name.into();
        match Self::sample_name(&path) {
            Some(sample) => Self::Sample(sample.to_owned()),
            None => Self::File(path),
        }
    }

    /// The NAME of `sample:NAME`; `None` if `name` is a path. Sound samples use the same syntax.
    pub fn sample_name(name: &Path) -> Option<&str> {
        name.to_str()?.strip_prefix(SAMPLE)
    }

    /// Its file; `None` for a sample.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Sample(_) => None,
        }
    }

    /// How it stands where that is known without looking at it: samples stand as they were modeled.
    pub fn stands(&self) -> Option<Orientation> {
        match self {
            Self::Sample(_) => Some(Orientation::Y_UP),
            Self::File(_) => None,
        }
    }

    /// The part of the orientation that follows from the name alone: all of a sample's; of a glTF file, that y is up
    /// and z should be in front (glTF 2.0, section 3.4).
    pub fn known(&self) -> Known {
        let is_gltf = |path: &Path| {
            let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default();
            ["glb", "gltf"].into_iter().any(|known| end.eq_ignore_ascii_case(known))
        };
        match self {
            Self::Sample(_) => Orientation::Y_UP.into(),
            Self::File(path) if is_gltf(path) => Known {
                up: Some(Orientation::Y_UP.up()),
                usual_front: Some(Orientation::Y_UP.front()),
                ..Known::default()
            },
            Self::File(_) => Known::default(),
        }
    }

    /// Reads the file, whose relative path starts from `folder`, or makes the sample.
    ///
    /// # Errors
    /// A file that cannot be read as a mesh, or a name that no sample has.
    pub fn load(&self, folder: Option<&Path>) -> Result<Loaded, MeshError> {
        match self {
            Self::File(path) => match folder {
                Some(folder) => load_mesh(&folder.join(path)),
                None => load_mesh(path),
            },
            Self::Sample(name) => {
                samples::portrait_sliders(name).transpose()?;
                let mesh = samples::sample(name)
                    .ok_or_else(|| MeshError::NoSample { name: name.clone(), known: &samples::SAMPLES })?;
                Ok(Loaded { mesh, mended: Vec::new(), stored_positions: None })
            }
        }
    }
}

/// As [`ShapeSource::named`], but an empty text is refused.
impl FromStr for ShapeSource {
    type Err = MeshError;

    fn from_str(text: &str) -> Result<Self, MeshError> {
        if text.is_empty() { Err(MeshError::NoName) } else { Ok(Self::named(text)) }
    }
}

impl std::fmt::Display for ShapeSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Sample(name) => write!(f, "{SAMPLE}{name}"),
        }
    }
}

impl TryFrom<String> for ShapeSource {
    type Error = MeshError;

    fn try_from(text: String) -> Result<Self, MeshError> {
        text.parse()
    }
}

impl From<ShapeSource> for String {
    fn from(source: ShapeSource) -> Self {
        source.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gltf_files_have_y_up_and_a_usual_front() {
        for (name, up) in [("a/b.GLB", true), ("c.gltf", true), ("glb", false), ("d.obj", false)] {
            let known = ShapeSource::named(name).known();
            assert_eq!((known.up.is_some(), known.usual_front.is_some()), (up, up), "{name}");
            assert_eq!(known.front, None);
        }
        assert_eq!(ShapeSource::named("sample:cat").known(), Orientation::Y_UP.into());
    }

    #[test]
    fn what_is_written_is_read_back() {
        for (text, source) in [
            ("sample:head", ShapeSource::Sample("head".into())),
            ("sample:", ShapeSource::Sample(String::new())),
            ("a/sample:head.obj", ShapeSource::File("a/sample:head.obj".into())),
        ] {
            assert_eq!(text.parse::<ShapeSource>().unwrap(), source);
            assert_eq!(source.to_string(), text);
        }
        assert!(matches!("".parse::<ShapeSource>(), Err(MeshError::NoName)));
    }

    #[test]
    fn a_sample_is_made_and_a_file_is_found_from_its_folder() {
        assert_eq!(
            ShapeSource::named("sample:head").load(None).unwrap().mesh,
            samples::sample("head").unwrap()
        );
        let error = ShapeSource::named("sample:unicorn").load(None).unwrap_err().to_string();
        assert!(error.starts_with("sample:unicorn: there is no such sample; there are head, "), "{error}");
        assert!(error.ends_with(" and portrait"), "{error}");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("one.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let loaded = ShapeSource::named("one.obj").load(Some(folder.path())).unwrap();
        assert_eq!(loaded.mesh.triangles, [[0, 1, 2]]);
    }
}
