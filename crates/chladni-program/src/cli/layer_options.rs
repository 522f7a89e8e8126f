//! The options that describe a caricature layer, shared by `caricature` and `project`.

use std::path::{Path, PathBuf};

use chladni_caricature::{
    Layer, Model, Painted, Project, Region, RollOff, ScaleCurve, Smoothing, Template, parse_wavelength,
    usual_wavelength,
};
use chladni_harmonics::Laplacian;
use chladni_match::{MatchSettings, Method, Scaling, load_landmarks};
use chladni_mesh::weld;

use super::Terminal;
use super::number::number;
use crate::work::{Error, Subject, Watcher};

/// How a layer exaggerates.
#[derive(clap::Args, Clone, Debug)]
pub struct LayerOptions {
    /// How the difference is represented: coordinate, normal or distance.
    #[arg(long, default_value_t = Model::Coordinate)]
    model: Model,
    /// 0 is the shape, 1 the template; below 0 exaggerates [default: -0.5; in paper mode -0.8, of the
    /// distance model -8]. Typical: -0.5 to -2.4, for the distance model to -8.
    #[arg(long, allow_hyphen_values = true, value_parser = mu)]
    mu: Option<f64>,
    /// A factor on μ from 0 to 1.
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    strength: f64,
    /// How soft the region's edge is: a wavelength as percent of the shape's size (32%), or about how many
    /// harmonics have longer waves (96, for the wavelength π/√96), the paper's nχ [default: 32%; 96 in paper mode].
    #[arg(long, value_name = "P%|N", allow_negative_numbers = true, value_parser = cutoff)]
    cutoff: Option<f64>,
    /// How the region's edge is softened: by heat, which never rings, or sharp as in the paper [default:
    /// heat; sharp in paper mode].
    #[arg(long, value_parser = roll_off)]
    roll_off: Option<RollOff>,
    /// Let a sharp region ring below 0 and above 1, as it does in paper mode.
    #[arg(long)]
    no_clamp: bool,
    /// Which scales: flat, smooth, broad, mid, fine, or points wavelength:gain,… in percent of the shape's
    /// size and d:gain for all that is finer than the harmonics (90%:1,40%:2,15%:0,d:0). Where none is
    /// given: flat; but smooth, without the finest, for exaggerating (μ < 0) a matched mesh, whose match is
    /// never exact there. In paper mode flat.
    #[arg(long, value_name = "CURVE")]
    scale_curve: Option<ScaleCurve>,
    /// How a template mesh is matched: same (connectivity), icp, fit, or map (by landmarks).
    #[arg(long = "match", value_name = "METHOD", value_parser = method)]
    matching: Option<Method>,
    /// Pairs of vertices that belong together, `shape_vertex template_vertex` a line.
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
    /// Keep the template mesh's own size, as the paper does, instead of fitting it to the shape's: sizes are
    /// then exaggerated, too.
    #[arg(long)]
    rigid: bool,
    /// Seed of all that matching samples [default: 0].
    #[arg(long, value_parser = seed)]
    seed: Option<u64>,
    /// How far the difference is filled in from its surroundings where a match is not to be trusted, such as
    /// hair, holes and the cut of a neck: 0, as it was found, to 1 [default: 1; 0 in paper mode].
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    infill: Option<f64>,
}

/// The scaling that `--rigid` asks for.
pub fn scaling(rigid: bool) -> Scaling {
    if rigid { Scaling::Rigid } else { Scaling::Free }
}

/// Reads a seed. Project files are TOML, whose whole numbers end at 2⁶³ − 1.
pub(super) fn seed(text: &str) -> Result<u64, Error> {
    let fits = |seed: &u64| i64::try_from(*seed).is_ok();
    number(text, fits, format_args!("a whole number from 0 to {}", i64::MAX))
}

fn mu(text: &str) -> Result<f64, Error> {
    number(text, |_| true, "a number, such as -1.2")
}

fn cutoff(text: &str) -> Result<f64, Error> {
    let harmonics = || text.parse::<u32>().ok().filter(|n| *n > 0);
    let wavelength = parse_wavelength(text).or_else(|| harmonics().map(|n| usual_wavelength(n.into())));
    wavelength
        .ok_or_else(|| Error::input("the cut-off must be a wavelength such as 32%, or a number of harmonics"))
}

fn roll_off(text: &str) -> Result<RollOff, Error> {
    match text {
        // Names from older command lines.
        "heat" | "gaussian" => Ok(RollOff::Heat),
        "sharp" => Ok(RollOff::Sharp),
        _ => Err(Error::input("must be heat or sharp")),
    }
}

/// The method that `--match` names.
pub fn method(text: &str) -> Result<Method, Error> {
    serde_json::from_value(serde_json::Value::String(text.to_owned()))
        .map_err(|error| Error::input(error.to_string().replace("variant", "method")))
}

/// Checks that landmarks are not given to the method that takes vertices as they are.
///
/// # Errors
/// [`Error::Input`] where they are.
pub fn check_landmarks(method: Method, landmarks: Option<&Path>) -> Result<(), Error> {
    match landmarks {
        Some(_) if method == Method::Same => {
            Err(Error::input("--landmarks lead a match, and none is looked for between the same vertices"))
        }
        _ => Ok(()),
    }
}

/// Checks that no seed is given to the method that samples nothing.
///
/// # Errors
/// [`Error::Input`] where one is.
pub fn check_seed(method: Method, seed: Option<u64>) -> Result<(), Error> {
    match seed {
        Some(_) if method == Method::Same => Err(Error::input(
            "--seed is for a match that is looked for, and none is between the same vertices",
        )),
        _ => Ok(()),
    }
}

impl LayerOptions {
    /// The seed that is given.
    pub fn seed(&self) -> Option<u64> {
        self.seed
    }

    /// Whether a scale curve is given.
    pub fn names_curve(&self) -> bool {
        self.scale_curve.is_some()
    }

    /// Whether it is matched vertex by vertex, for which all are needed.
    pub fn needs_all_vertices(&self) -> bool {
        self.matching == Some(Method::Same)
    }

    /// Checks that no option for matching is given where `template` is no mesh, and so is not matched, nor one that the
    /// method does not use. The seed of what `is_bred` is that of a gallery, and of use in any case.
    ///
    /// # Errors
    /// [`Error::Input`] with the option's name.
    pub fn check_for(&self, template: Option<&Template>, is_bred: bool) -> Result<(), Error> {
        let seed = self.seed.filter(|_| !is_bred);
        let given = self.matching.map(|_| "--match").or(self.landmarks.as_ref().map(|_| "--landmarks"));
        let given = given.or(self.rigid.then_some("--rigid")).or(self.infill.map(|_| "--infill"));
        match given.or(seed.map(|_| "--seed")) {
            Some(option) if !template.is_some_and(Template::is_mesh) => {
                Err(Error::Input(format!("{option} is for a template that is a mesh")))
            }
            _ => {
                let method = self.matching.unwrap_or_default();
                check_landmarks(method, self.landmarks.as_deref())?;
                check_seed(method, seed)
            }
        }
    }

    /// Checks that no option for the edge of a region is given where there is none, nor one that its edge does not have;
    /// `paper` says whether that is sharp by default. A layer of a project may get its region later, in the window: there
    /// [`check_clamp`](Self::check_clamp) is enough.
    ///
    /// # Errors
    /// [`Error::Input`] with the option's name.
    pub fn check_edge(&self, has_region: bool, paper: bool) -> Result<(), Error> {
        let given = self.cutoff.map(|_| "--cutoff").or(self.roll_off.map(|_| "--roll-off"));
        match given.or(self.no_clamp.then_some("--no-clamp")) {
            Some(option) if !has_region => {
                Err(Error::Input(format!("{option} is for the edge of a region, and none is given")))
            }
            _ => self.check_clamp(paper),
        }
    }

    /// Checks that `--no-clamp` is given only for a sharp edge; `paper` says whether edges are sharp by default.
    ///
    /// # Errors
    /// [`Error::Input`] with the option's name.
    pub fn check_clamp(&self, paper: bool) -> Result<(), Error> {
        let is_sharp = self.roll_off.map_or(paper, |roll_off| roll_off == RollOff::Sharp);
        if self.no_clamp && !is_sharp {
            return Err(Error::input("--no-clamp is for a sharp edge: give --roll-off sharp, too"));
        }
        Ok(())
    }

    /// How a template mesh is matched with `subject`; warns of landmarks that come to one vertex.
    ///
    /// # Errors
    /// Landmarks that cannot be read, or are not there.
    pub fn matching(&self, subject: &Subject, terminal: &Terminal) -> Result<MatchSettings, Error> {
        let mut matching = MatchSettings { scaling: scaling(self.rigid), ..MatchSettings::default() };
        matching.seed = self.seed.unwrap_or(matching.seed);
        matching.method = self.matching.unwrap_or(matching.method);
        if let Some(path) = &self.landmarks {
            let (landmarks, warning) = subject.renumbered(load_landmarks(path)?)?;
            terminal.warn_each(warning);
            matching.landmarks = landmarks;
        }
        Ok(matching)
    }

    /// The layer called `name` with these options where χ01 is `painted`, for `project` on `subject`.
    ///
    /// # Errors
    /// Options out of their ranges, or a low-pass that keeps more harmonics than there are.
    pub fn layer(
        &self,
        name: &str,
        template: Template,
        painted: Painted,
        project: &Project,
        subject: &Subject,
        terminal: &Terminal,
    ) -> Result<Layer, Error> {
        if matches!(template, Template::LowPass(_)) {
            // A small shape has fewer than the project asks for.
            let most = weld(&subject.mesh).positions.len();
            template.check_low_pass(project.harmonics.min(most))?;
        }
        let paper = project.laplacian == Laplacian::Cotangent;
        let usual = if paper { Layer::paper(name, template) } else { Layer::new(name, template) };
        let smoothing = usual.region.smoothing;
        let smoothing = Smoothing {
            wavelength: self.cutoff.unwrap_or(smoothing.wavelength),
            roll_off: self.roll_off.unwrap_or(smoothing.roll_off),
            clamp: smoothing.clamp && !self.no_clamp,
        };
        let mu = self.mu.unwrap_or(if paper { self.model.paper_mu() } else { usual.mu });
        let matching = self.matching(subject, terminal)?;
        let curve = project.usual_curve(&usual.template, matching.method, mu);
        let layer = Layer {
            matching,
            infill: self.infill.unwrap_or(usual.infill),
            model: self.model,
            mu,
            strength: self.strength,
            region: Region { painted, smoothing },
            curve: self.scale_curve.clone().unwrap_or(curve),
            ..usual
        };
        layer.validate()?;
        Ok(layer)
    }
}
