//! One layer of a project: the difference that it exaggerates, how, and where.

use std::path::{Path, PathBuf};

use chladni_match::{Ellipsoid, MatchError, MatchSettings, Method};
use chladni_mesh::samples::portrait_sliders;
use chladni_mesh::{Known, ShapeSource};
use serde::{Deserialize, Serialize};

use crate::difference::check_kept;
use crate::{CaricatureError, Model, Painted, Region, RollOff, ScaleCurve, Smoothing, usual_wavelength};
use chladni_mesh::surface::vec3::Vec3;

/// Names a layer for as long as its project is open, across moves and undo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LayerId(pub u64);

/// One exaggeration. Its result is the shape of the layer above.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// The user's name for it, which its morph target gets, too.
    pub name: String,
    /// The shape to compare with.
    pub template: Template,
    /// How the template's points are found; used by templates that are meshes.
    pub matching: MatchSettings,
    /// How far the difference is filled in from its surroundings where the match is not trusted: from 0, as
    /// found, to 1.
    pub infill: f64,
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

/// The template of a layer: the shape that the mesh is compared with.
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
    /// A given ellipsoid or sphere.
    Given(GivenEllipsoid),
    /// The layer's own shape, scaled about the centroid of the original.
    Scaled(f64),
    /// The layer's own shape without its harmonics from k0 on: exaggerates its own detail.
    LowPass(usize),
    /// The original shape below all layers: exaggerates the effect of the layers below.
    Original,
    /// The shape as it is after a layer further down: exaggerates the effect of the layers between.
    Layer(LayerId),
}

/// An ellipsoid or sphere given by numbers, in the coordinates of the shape's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenEllipsoid {
    /// Its center.
    pub center: Vec3,
    /// Half the length of each axis; positive. All equal the radius for a sphere.
    pub semi_axes: Vec3,
    /// How far it is turned, in degrees, about x, then y, then z.
    pub turn_deg: Vec3,
}

impl GivenEllipsoid {
    /// The same as matching takes it.
    ///
    /// # Errors
    /// Semi-axes that are not positive and finite, other numbers that are not finite.
    pub fn ellipsoid(&self) -> Result<Ellipsoid, MatchError> {
        Ellipsoid::given(self.center, self.semi_axes, self.turn_deg)
    }
}

impl From<Ellipsoid> for GivenEllipsoid {
    fn from(found: Ellipsoid) -> Self {
        Self { center: found.center, semi_axes: found.semi_axes, turn_deg: found.turn_deg() }
    }
}

/// `sphere:x,y,z,radius`, or `ellipsoid:x,y,z,a,b,c` and, where it is turned, three angles more.
impl std::str::FromStr for GivenEllipsoid {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        let bad = |why: &str| CaricatureError::syntax("template", text, why);
        let (kind, list) = text.split_once(':').unwrap_or_default();
        let numbers: Option<Vec<f64>> = list.split(',').map(|t| t.trim().parse().ok()).collect();
        let given = match (kind, &numbers.unwrap_or_default()[..]) {
            ("sphere", &[x, y, z, r]) => Self { center: [x, y, z], semi_axes: [r; 3], turn_deg: [0.0; 3] },
            ("ellipsoid", &[x, y, z, a, b, c]) => {
                Self { center: [x, y, z], semi_axes: [a, b, c], turn_deg: [0.0; 3] }
            }
            ("ellipsoid", &[x, y, z, a, b, c, d, e, f]) => {
                Self { center: [x, y, z], semi_axes: [a, b, c], turn_deg: [d, e, f] }
            }
            _ => {
                return Err(bad(
                    "write sphere:x,y,z,radius or ellipsoid:x,y,z,a,b,c and, turned, three angles in degrees",
                ));
            }
        };
        given.ellipsoid().map_err(|error| bad(&error.to_string()))?;
        Ok(given)
    }
}

impl std::fmt::Display for GivenEllipsoid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.center;
        let [a, b, c] = self.semi_axes;
        match self.turn_deg {
            [0.0, 0.0, 0.0] if a == b && b == c => write!(f, "sphere:{x},{y},{z},{a}"),
            [0.0, 0.0, 0.0] => write!(f, "ellipsoid:{x},{y},{z},{a},{b},{c}"),
            [d, e, g] => write!(f, "ellipsoid:{x},{y},{z},{a},{b},{c},{d},{e},{g}"),
        }
    }
}

impl Template {
    /// Whether one may replace the other while that is being matched.
    pub(crate) fn alike(&self, other: &Self) -> bool {
        let portrait = |template: &Self| match template {
            Self::Sample(name) => portrait_sliders(name).is_some(),
            _ => false,
        };
        let given = matches!((self, other), (Self::Given(_), Self::Given(_)));
        self == other || given || (portrait(self) && portrait(other))
    }

    /// Whether landmarks that were set on this template go where the `next` one replaces it: a mesh takes them along, unless
    /// the next one is the same file, moved. What is no mesh would not remember which one they belong to. Portraits with
    /// other sliders are meshes of their own.
    pub fn loses_landmarks_to(&self, next: &Self) -> bool {
        let has_same_vertices = match (self, next) {
            (Self::File(one), Self::File(two)) => one.file_name() == two.file_name(),
            _ => self == next,
        };
        self.is_mesh() && !has_same_vertices
    }

    /// Checks that a low-pass keeps no more than the `harmonics` that there are.
    ///
    /// # Errors
    /// [`CaricatureError::Range`] where it does.
    pub fn check_low_pass(&self, harmonics: usize) -> Result<(), CaricatureError> {
        match self {
            Self::LowPass(k0) => check_kept(*k0, harmonics),
            _ => Ok(()),
        }
    }

    /// Its file; `None` where it has none.
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            _ => None,
        }
    }

    /// Whether it is a mesh that has to be matched with the shape.
    pub fn is_mesh(&self) -> bool {
        matches!(self, Self::File(_) | Self::Sample(_))
    }

    /// Where its mesh comes from; `None` where it is none.
    pub fn mesh(&self) -> Option<ShapeSource> {
        match self {
            Self::File(path) => Some(ShapeSource::File(path.clone())),
            Self::Sample(name) => Some(ShapeSource::Sample(name.clone())),
            _ => None,
        }
    }

    /// What is known of how its mesh stands; nothing where it is none.
    pub fn known(&self) -> Known {
        self.mesh().map_or_else(Known::default, |source| source.known())
    }
}

impl From<ShapeSource> for Template {
    fn from(source: ShapeSource) -> Self {
        match source {
            ShapeSource::File(path) => Self::File(path),
            ShapeSource::Sample(name) => Self::Sample(name),
        }
    }
}

/// `ellipsoid`, `sphere`, a given one of either ([`GivenEllipsoid`]), `self:scale=0.9`, `self:lowpass=20`, `self:original`,
/// `self:layer=2`, `sample:NAME`, or a path. Layers are numbered from the lowest, 1, as are the ids of a project that was
/// just read.
impl std::str::FromStr for Template {
    type Err = CaricatureError;

    fn from_str(text: &str) -> Result<Self, CaricatureError> {
        let bad = |why: &str| CaricatureError::syntax("template", text, why);
        if text.starts_with("sphere:") || text.starts_with("ellipsoid:") {
            return text.parse().map(Self::Given);
        }
        let Some(own) = text.strip_prefix("self:") else {
            return match text {
                "" => Err(bad("is empty")),
                "ellipsoid" => Ok(Self::Ellipsoid),
                "sphere" => Ok(Self::Sphere),
                _ => Ok(ShapeSource::named(text).into()),
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
            Some(("layer", number)) => match number.parse::<u64>() {
                Ok(number) if number > 0 => Ok(Self::Layer(LayerId(number))),
                _ => Err(bad("layers are numbered from the lowest, 1")),
            },
            _ => Err(bad("write self:scale=0.9, self:lowpass=20, self:original or self:layer=1")),
        }
    }
}

impl std::fmt::Display for Template {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(_) | Self::Sample(_) => self.mesh().map_or(Ok(()), |source| source.fmt(f)),
            Self::Ellipsoid => f.write_str("ellipsoid"),
            Self::Sphere => f.write_str("sphere"),
            Self::Given(given) => given.fmt(f),
            Self::Scaled(factor) => write!(f, "self:scale={factor}"),
            Self::LowPass(k0) => write!(f, "self:lowpass={k0}"),
            Self::Original => f.write_str("self:original"),
            Self::Layer(layer) => write!(f, "self:layer={}", layer.0),
        }
    }
}

impl TryFrom<String> for Template {
    type Error = CaricatureError;

    fn try_from(text: String) -> Result<Self, CaricatureError> {
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

/// μ of a new layer, and of one in a file that says none.
pub(crate) const DEFAULT_MU: f64 = -0.5;

impl Layer {
    /// A new layer with the defaults: coordinate model, μ = −0.5, everywhere, every scale.
    pub fn new(name: impl Into<String>, template: Template) -> Self {
        Self {
            name: name.into(),
            template,
            matching: MatchSettings::default(),
            infill: 1.0,
            model: Model::Coordinate,
            mu: DEFAULT_MU,
            strength: 1.0,
            region: Region::default(),
            curve: ScaleCurve::default(),
            enabled: true,
            solo: false,
        }
    }

    /// A layer with the settings that the paper prints: a sharp cut at about nχ = 96 ([`usual_wavelength`]) that may
    /// ring, every scale and every match as it is, and μ = −0.8, where its figures begin.
    pub fn paper(name: impl Into<String>, template: Template) -> Self {
        let smoothing =
            Smoothing { wavelength: usual_wavelength(96.0), roll_off: RollOff::Sharp, clamp: false };
        Self {
            mu: Model::Coordinate.paper_mu(),
            region: Region { smoothing, ..Region::default() },
            curve: ScaleCurve::flat(1.0),
            infill: 0.0,
            ..Self::new(name, template)
        }
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first number that is out of its range.
    pub fn validate(&self) -> Result<(), CaricatureError> {
        if self.mu.is_nan() || self.mu.abs() > MAX_MU {
            return Err(CaricatureError::Range { what: "μ", value: self.mu, range: "-100 to 100" });
        }
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(CaricatureError::Range {
                what: "the strength",
                value: self.strength,
                range: "0 to 1",
            });
        }
        if !(0.0..=1.0).contains(&self.infill) {
            return Err(CaricatureError::Range { what: "the infill", value: self.infill, range: "0 to 1" });
        }
        let wavelength = self.region.smoothing.wavelength;
        if !(0.01..=10.0).contains(&wavelength) {
            let (what, range) = ("the wavelength of the region's cut-off", "0.01 to 10 of the size");
            return Err(CaricatureError::Range { what, value: wavelength, range });
        }
        self.curve.validate()
    }

    /// Whether it is matched with a template mesh vertex by vertex, for which all vertices of the shape are needed.
    pub fn matches_vertices(&self) -> bool {
        self.matching.method == Method::Same && self.template.is_mesh()
    }

    /// Whether it names vertices of the shape by number: in a painted region or by landmarks.
    pub fn names_vertices(&self) -> bool {
        matches!(self.region.painted, Painted::Vertices(_)) || !self.matching.landmarks.is_empty()
    }

    /// Whether it names vertices or places of the shape: in a region, by landmarks, or as a given ellipsoid or sphere. These
    /// are [`carried`](crate::Project::carried) to another shape.
    pub(crate) fn names_places(&self) -> bool {
        self.names_vertices()
            || self.region.painted != Painted::Everywhere
            || matches!(self.template, Template::Given(_))
    }

    /// μ times strength.
    pub fn effective_mu(&self) -> f64 {
        self.mu * self.strength
    }
}
