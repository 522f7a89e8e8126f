//! One layer of a project: what is exaggerated, how, and where.

use std::path::PathBuf;

use chladni_match::Settings as MatchSettings;
use serde::{Deserialize, Serialize};

use crate::{Error, Model, Region, ScaleCurve};

/// Names a layer for as long as its project is open, across moves and undo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LayerId(pub u64);

/// One exaggeration. Its result is the shape of the layer above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// What the user calls it; the name of its morph target.
    pub name: String,
    /// What the shape is compared with.
    pub template: Template,
    /// How the template's points are found; used by templates that are meshes.
    pub matching: MatchSettings,
    /// The representation of the difference.
    pub model: Model,
    /// μ: 0 is the shape, 1 the template (coordinate model), below 0 exaggerates.
    pub mu: f64,
    /// A factor on μ from 0 to 1, for fading a layer in without losing its μ.
    pub strength: f64,
    /// Where it acts.
    pub region: Region,
    /// Which scales it exaggerates.
    pub curve: ScaleCurve,
    /// Whether it acts at all.
    pub enabled: bool,
    /// While any layer is soloed, only soloed layers act.
    pub solo: bool,
}

/// What the shape of a layer is compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Template {
    /// A mesh file. Project files hold its path relative to their own folder.
    File(PathBuf),
    /// A sample shape of this program, by name.
    Sample(String),
    /// The ellipsoid fitted to the original shape.
    Ellipsoid,
    /// The sphere fitted to the original shape.
    Sphere,
    /// The layer's own shape, scaled about the centroid of the original.
    Scaled(f64),
    /// The layer's own shape without its harmonics from k0 on: exaggerates its own detail.
    LowPass(usize),
    /// The original shape under all layers: exaggerates what the layers below did.
    Original,
}

impl Template {
    /// Whether it is a mesh that has to be matched with the shape.
    pub fn is_mesh(&self) -> bool {
        matches!(self, Self::File(_) | Self::Sample(_))
    }
}

/// `ellipsoid`, `sphere`, `self:scale=0.9`, `self:lowpass=20`, `self:original`, `sample:NAME`, or a
/// path.
impl std::str::FromStr for Template {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let bad = |why: &str| Error::syntax("template", text, why);
        if let Some(name) = text.strip_prefix("sample:") {
            return Ok(Self::Sample(name.to_owned()));
        }
        let Some(own) = text.strip_prefix("self:") else {
            return match text {
                "" => Err(bad("is empty")),
                "ellipsoid" => Ok(Self::Ellipsoid),
                "sphere" => Ok(Self::Sphere),
                _ => Ok(Self::File(PathBuf::from(text))),
            };
        };
        match own.split_once('=') {
            None if own == "original" => Ok(Self::Original),
            Some(("scale", factor)) => match factor.parse::<f64>() {
                Ok(factor) if factor.is_finite() && factor >= 0.0 => Ok(Self::Scaled(factor)),
                _ => Err(bad("the scale must be a number, 0 or more")),
            },
            Some(("lowpass", k0)) => match k0.parse::<usize>() {
                Ok(k0) if k0 > 0 => Ok(Self::LowPass(k0)),
                _ => Err(bad("the number of harmonics must be a whole number above 0")),
            },
            _ => Err(bad("write self:scale=0.9, self:lowpass=20 or self:original")),
        }
    }
}

impl std::fmt::Display for Template {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Sample(name) => write!(f, "sample:{name}"),
            Self::Ellipsoid => f.write_str("ellipsoid"),
            Self::Sphere => f.write_str("sphere"),
            Self::Scaled(factor) => write!(f, "self:scale={factor}"),
            Self::LowPass(k0) => write!(f, "self:lowpass={k0}"),
            Self::Original => f.write_str("self:original"),
        }
    }
}

impl TryFrom<String> for Template {
    type Error = Error;

    fn try_from(text: String) -> Result<Self, Error> {
        text.parse()
    }
}

impl From<Template> for String {
    fn from(template: Template) -> Self {
        template.to_string()
    }
}

/// The largest |μ| that is accepted; the paper goes to 8.
pub const MAX_MU: f64 = 100.0;

impl Layer {
    /// A layer as a user expects a new one: coordinate-wise, μ = −0.5, everywhere, every scale.
    pub fn new(name: impl Into<String>, template: Template) -> Self {
        Self {
            name: name.into(),
            template,
            matching: MatchSettings::default(),
            model: Model::Coordinate,
            mu: -0.5,
            strength: 1.0,
            region: Region::default(),
            curve: ScaleCurve::default(),
            enabled: true,
            solo: false,
        }
    }

    /// Checks every number against its range.
    pub fn validate(&self) -> Result<(), Error> {
        if self.mu.is_nan() || self.mu.abs() > MAX_MU {
            return Err(Error::Range { what: "μ", value: self.mu, range: "-100 to 100" });
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(Error::Range { what: "the strength", value: self.strength, range: "0 to 1" });
        }
        if self.region.smoothing.cutoff == 0 {
            return Err(Error::Range { what: "the cut-off", value: 0.0, range: "1 or more" });
        }
        self.curve.validate()
    }

    /// μ times strength.
    pub fn effective_mu(&self) -> f64 {
        self.mu * self.strength
    }
}
