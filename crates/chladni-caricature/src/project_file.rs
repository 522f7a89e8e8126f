//! Project files: text that a person can read and edit, written completely or not at all.
//!
//! docs/caricature.md describes the format.

use std::path::{Path, PathBuf};

use chladni_harmonics::Laplacian;
use chladni_match::MatchSettings;
use chladni_mesh::{MeshError, Orientation};
use chladni_task::{asks_another_machine, folder_of, newer, read_file};
use serde::{Deserialize, Serialize};

use self::paths::{relative_text, resolved, whole};
use crate::layer::DEFAULT_MU;
use crate::migration::{FORMAT_VERSION, USUAL_VERSION, migrate};
use crate::project::DEFAULT_HARMONICS;
use crate::{
    CaricatureError, Layer, LayerId, Model, Painted, Project, ProxyKey, Region, Resolution, ScaleCurve,
    ShapeSource, Smoothing, Sphere, Template, runs,
};

mod paths;

/// The most bytes that are read of one file.
pub(crate) const MOST_BYTES: u64 = 1 << 30;

/// The whole file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format_version: i64,
    /// In recovery files: where the project was saved before, if it was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    recovered_from: Option<PathBuf>,
    shape: ShapeTable,
    #[serde(default, rename = "layer")]
    layers: Vec<LayerTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeTable {
    source: String,
    #[serde(default = "default_harmonics")]
    harmonics: usize,
    /// Only where the resolution is not the usual one, 0 vertices where all are taken; format 5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    proxy: Option<ProxyKey>,
    /// Only if the orientation was set by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stands: Option<Orientation>,
    /// Only where it is the papers'.
    #[serde(default, skip_serializing_if = "is_usual")]
    laplacian: Laplacian,
    /// Only where they are kept.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    keep_triangles: bool,
}

fn is_usual(laplacian: &Laplacian) -> bool {
    *laplacian == Laplacian::default()
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerTable {
    name: String,
    template: String,
    #[serde(default = "default_model")]
    model: Model,
    #[serde(default = "default_mu")]
    mu: f64,
    #[serde(default = "one")]
    strength: f64,
    #[serde(default = "yes")]
    enabled: bool,
    #[serde(default)]
    solo: bool,
    /// May hold only what differs from the defaults of the program that wrote it.
    #[serde(default, rename = "match", skip_serializing_if = "toml::Table::is_empty")]
    matching: toml::Table,
    #[serde(default = "one")]
    infill: f64,
    #[serde(default)]
    region: RegionTable,
    #[serde(default)]
    scale: ScaleCurve,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct RegionTable {
    /// `x,y,z,radius` in the shape's file units, each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    spheres: Vec<String>,
    /// Run-length text over the operator vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    painted: Option<String>,
    wavelength: f64,
    roll_off: crate::RollOff,
    clamp: bool,
}

impl Default for RegionTable {
    fn default() -> Self {
        let Smoothing { wavelength, roll_off, clamp } = Smoothing::default();
        Self { spheres: Vec::new(), painted: None, wavelength, roll_off, clamp }
    }
}

const TOO_MUCH_PAINTED: &str = "the layers have more painted values than are read";

fn default_harmonics() -> usize {
    DEFAULT_HARMONICS
}
fn default_model() -> Model {
    Model::Coordinate
}
fn default_mu() -> f64 {
    DEFAULT_MU
}
fn one() -> f64 {
    1.0
}
fn yes() -> bool {
    true
}

impl Project {
    /// Reads the project file at `path`, as [`read`](Self::read) does, where it is [near](Self::check_near).
    ///
    /// # Errors
    /// As of both.
    pub fn load(path: &Path) -> Result<Self, CaricatureError> {
        let project = Self::read(path)?;
        project.check_near(path, |_| false)?;
        Ok(project)
    }

    /// Reads the project file at `path`, whichever files it names. Paths in it are taken from its folder; where `path` is a
    /// link, from that of the file that it leads to.
    ///
    /// Files of older formats are brought up to date in memory.
    ///
    /// # Errors
    /// A file that cannot be read, that is not a valid project (with line and column where known), or that a newer
    /// program wrote.
    pub fn read(path: &Path) -> Result<Self, CaricatureError> {
        let bytes = read_file(path, MOST_BYTES)
            .map_err(|source| CaricatureError::Io { path: path.into(), source })?;
        let no_text = || CaricatureError::ProjectFile {
            path: path.into(),
            why: "is no text, so it is not a Chladni project".into(),
        };
        let text = String::from_utf8(bytes).map_err(|_| no_text())?;
        Ok(Self::from_text(&text, path)?.0)
    }

    /// The files of [another machine](asks_another_machine) that a project at `path` names.
    pub fn far_files(&self, path: &Path) -> Vec<&Path> {
        let place = whole(path);
        let mut files = self.files();
        files.retain(|file| asks_another_machine(file, folder_of(&place)));
        files
    }

    /// Checks, before any of them is looked for, that a project at `path` names no [far files](Self::far_files) but those
    /// that are `known` to the user.
    ///
    /// # Errors
    /// [`CaricatureError::ProjectFile`] with the file that it names.
    pub fn check_near(&self, path: &Path, known: impl Fn(&Path) -> bool) -> Result<(), CaricatureError> {
        let far = self.far_files(path).into_iter().find(|file| !known(file));
        far.map_or(Ok(()), |file| {
            let why = format!(
                "names {}, which is on another machine and was not looked for: open the project together with that mesh, or \
                 keep both on one share",
                file.display()
            );
            Err(CaricatureError::ProjectFile { path: path.into(), why })
        })
    }

    /// Writes the project to `path`: readers see the old file or the whole new one, whatever
    /// happens to this process meanwhile.
    ///
    /// # Errors
    /// As [`to_text`](Self::to_text), or an error of the system.
    pub fn save(&self, path: &Path) -> Result<(), CaricatureError> {
        let text = self.to_text(path, None)?;
        chladni_task::write_atomic(path, text.as_bytes())
            .map_err(|source| CaricatureError::Io { path: path.into(), source })
    }

    /// The oldest format that holds it, which it is written in.
    pub fn format_version(&self) -> i64 {
        if self.resolution == Resolution::Usual { USUAL_VERSION } else { FORMAT_VERSION }
    }

    /// The text of a project file at `path`; with `recovered_from`, of a recovery file.
    ///
    /// # Errors
    /// Names that are not Unicode, and more painted values than are read.
    pub fn to_text(&self, path: &Path, recovered_from: Option<PathBuf>) -> Result<String, CaricatureError> {
        let invalid =
            |why: CaricatureError| CaricatureError::ProjectFile { path: path.into(), why: why.to_string() };
        // A file that does not open again would lose the work.
        if self.stored_values() > runs::MOST_VALUES {
            return Err(CaricatureError::ProjectFile { path: path.into(), why: TOO_MUCH_PAINTED.into() });
        }
        let source = match &self.shape {
            ShapeSource::File(file) => relative_text(file, path).map_err(invalid)?,
            sample @ ShapeSource::Sample(_) => sample.to_string(),
        };
        let layers = self.layers().iter().map(|(_, l)| LayerTable::of(l, self, path));
        let proxy = match &self.resolution {
            Resolution::Usual => None,
            Resolution::Whole => Some(ProxyKey { vertices: 0, fingerprint: None }),
            Resolution::Proxy(proxy) => Some(proxy.clone()),
        };
        let document = Document {
            format_version: self.format_version(),
            recovered_from,
            shape: ShapeTable {
                source,
                harmonics: self.harmonics,
                proxy,
                stands: self.stands,
                laplacian: self.laplacian,
                keep_triangles: self.keep_triangles,
            },
            layers: layers.collect::<Result<_, _>>().map_err(invalid)?,
        };
        toml::to_string(&document).map_err(|e| invalid(e.into()))
    }

    /// The project in the `text` of a file at `path` and, from a recovery file, where it was saved before.
    ///
    /// # Errors
    /// As [`read`](Self::read), but those of the file system.
    pub fn from_text(text: &str, path: &Path) -> Result<(Self, Option<PathBuf>), CaricatureError> {
        let invalid = |why: String| CaricatureError::ProjectFile { path: path.into(), why };
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| invalid(one_line(&e, text)))?;
        let migrated = migrate(table, path)?;
        // A current text is parsed directly, so that errors have line and column.
        let (document, older_format): (Document, _) = match migrated {
            None => (toml::from_str(text).map_err(|e| invalid(one_line(&e, text)))?, None),
            Some((table, format)) => {
                let document = table.try_into();
                (document.map_err(|e: toml::de::Error| invalid(e.message().to_owned()))?, Some(format))
            }
        };
        let shape = document.shape.source.parse().map_err(|e: MeshError| invalid(e.to_string()))?;
        let shape = match shape {
            ShapeSource::File(file) => ShapeSource::File(resolved(&file, path)),
            sample @ ShapeSource::Sample(_) => sample,
        };
        if document.shape.harmonics == 0 {
            return Err(invalid("the number of harmonics is 0".to_owned()));
        }
        let mut project = Self::new(shape, document.shape.harmonics);
        project.older_format = older_format;
        project.resolution = match document.shape.proxy {
            None => Resolution::Usual,
            Some(proxy) if proxy.vertices == 0 => Resolution::Whole,
            Some(proxy) if proxy.vertices < ProxyKey::FEWEST => {
                return Err(invalid(format!("a proxy has {} vertices or more", ProxyKey::FEWEST)));
            }
            Some(proxy) => Resolution::Proxy(proxy),
        };
        project.stands = document.shape.stands;
        project.laplacian = document.shape.laplacian;
        project.keep_triangles = document.shape.keep_triangles;
        // A few bytes of text stand for as many painted values as a mesh may have.
        let mut painted = 0;
        for (i, table) in document.layers.into_iter().enumerate() {
            let place = format!("layer {} ({})", i + 1, table.name);
            let layer = table.into_layer(path).map_err(|e| invalid(format!("{place}: {e}")))?;
            painted += layer.region.painted.stored_values();
            if painted > runs::MOST_VALUES {
                return Err(invalid(format!("{place}: {TOO_MUCH_PAINTED}")));
            }
            project.push(layer).map_err(|e| invalid(format!("{place}: {e}")))?;
        }
        Ok((project, document.recovered_from))
    }
}

impl LayerTable {
    fn of(layer: &Layer, project: &Project, path: &Path) -> Result<Self, CaricatureError> {
        let template = match &layer.template {
            Template::File(file) => relative_text(file, path)?,
            // Ids are not written: layers get them anew, in order, when the file is read.
            Template::Layer(id) => {
                let number = project.number(*id).ok_or(CaricatureError::NoLayer(id.0))?;
                Template::Layer(LayerId(number as u64)).to_string()
            }
            other => other.to_string(),
        };
        let Smoothing { wavelength, roll_off, clamp } = layer.region.smoothing;
        let (spheres, painted) = match &layer.region.painted {
            Painted::Everywhere => (Vec::new(), None),
            Painted::Spheres(spheres) => (spheres.iter().map(Sphere::to_string).collect(), None),
            Painted::Vertices(values) => (Vec::new(), Some(runs::to_text(values))),
        };
        let mut matching = toml::Table::try_from(&layer.matching)?;
        let default = toml::Table::try_from(MatchSettings::default())?;
        matching.retain(|key, value| default.get(key) != Some(value));
        Ok(Self {
            name: layer.name.clone(),
            template,
            model: layer.model,
            mu: layer.mu,
            strength: layer.strength,
            enabled: layer.enabled,
            solo: layer.solo,
            matching,
            infill: layer.infill,
            region: RegionTable { spheres, painted, wavelength, roll_off, clamp },
            scale: layer.curve.clone(),
        })
    }

    fn into_layer(self, path: &Path) -> Result<Layer, CaricatureError> {
        let template = match self.template.parse()? {
            Template::File(file) => Template::File(resolved(&file, path)),
            other => other,
        };
        let bad_match = |why: String| CaricatureError::Syntax { what: "match", text: String::new(), why };
        let mut matching = toml::Table::try_from(MatchSettings::default())?;
        if let Some(unknown) = self.matching.keys().find(|k| !matching.contains_key(*k)) {
            return Err(bad_match(format!("there is no setting `{unknown}`")));
        }
        matching.extend(self.matching);
        let matching = matching.try_into().map_err(|e: toml::de::Error| bad_match(e.message().to_owned()))?;
        let RegionTable { spheres, painted, wavelength, roll_off, clamp } = self.region;
        let painted = match painted {
            Some(text) if spheres.is_empty() => Painted::Vertices(runs::from_text(&text)?),
            Some(_) => {
                return Err(CaricatureError::syntax(
                    "region",
                    "painted",
                    "spheres and painted exclude each other",
                ));
            }
            None if spheres.is_empty() => Painted::Everywhere,
            None => Painted::Spheres(spheres.iter().map(|s| s.parse()).collect::<Result<_, _>>()?),
        };
        Ok(Layer {
            name: self.name,
            template,
            matching,
            infill: self.infill,
            model: self.model,
            mu: self.mu,
            strength: self.strength,
            region: Region { painted, smoothing: Smoothing { wavelength, roll_off, clamp } },
            curve: self.scale,
            enabled: self.enabled,
            solo: self.solo,
        })
    }
}

/// "line 3, column 7: what is wrong", without the quoted source.
fn one_line(error: &toml::de::Error, text: &str) -> String {
    let what = newer(error.message().lines().next().unwrap_or("not valid TOML"));
    match error.span().and_then(|span| text.get(..span.start)) {
        Some(before) => {
            let line = before.matches('\n').count() + 1;
            let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
            format!("line {line}, column {column}: {what}")
        }
        None => what,
    }
}
