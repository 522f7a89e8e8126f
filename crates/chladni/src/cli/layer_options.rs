//! The options that describe a caricature layer, shared by `caricature` and `project`.

use std::path::PathBuf;

use chladni_caricature::{Layer, Model, Painted, Region, RollOff, ScaleCurve, Smoothing, Sphere, Template};
use chladni_match::{Method, Settings, load_landmarks};

use super::Failure;

/// How a layer exaggerates.
#[derive(clap::Args, Clone, Debug)]
pub struct LayerOptions {
    /// How the difference is represented: coordinate, normal or distance.
    #[arg(long, default_value_t = Model::Coordinate)]
    model: Model,
    /// 0 is the shape, 1 the template; below 0 exaggerates. Typical: -0.5 to -2.4, for the distance
    /// model to -8.
    #[arg(long, default_value_t = -0.5, allow_hyphen_values = true)]
    mu: f64,
    /// A factor on μ from 0 to 1.
    #[arg(long, default_value_t = 1.0)]
    strength: f64,
    /// Act only within this ball, x,y,z,radius in the shape's own units; may be repeated.
    #[arg(long, value_name = "X,Y,Z,RADIUS", allow_hyphen_values = true)]
    region: Vec<Sphere>,
    /// nχ: how many harmonics the region's soft edge has; fewer is softer.
    #[arg(long, default_value_t = Smoothing::default().cutoff, value_name = "N")]
    cutoff: usize,
    /// How the region's low-pass ends: gaussian, or sharp as in the paper.
    #[arg(long, default_value = "gaussian", value_parser = roll_off)]
    roll_off: RollOff,
    /// Let the smoothed region ring below 0 and above 1.
    #[arg(long)]
    no_clamp: bool,
    /// Which scales: flat, smooth, broad, mid, fine, or points frequency:gain,… and d:gain for all
    /// above the harmonics (0:1,0.4:2,1:0,d:0). Where none is given: flat; but smooth, without the
    /// finest, for exaggerating (μ < 0) a matched mesh, whose match is never exact there.
    #[arg(long, value_name = "CURVE")]
    scale_curve: Option<ScaleCurve>,
    /// How a template mesh is matched: same (connectivity), icp, fit, or map (by landmarks).
    #[arg(long = "match", value_name = "METHOD", value_parser = method)]
    matching: Option<Method>,
    /// Pairs of vertices that belong together, `shape_vertex template_vertex` a line.
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
}

fn roll_off(text: &str) -> Result<RollOff, String> {
    match text {
        "gaussian" => Ok(RollOff::Gaussian),
        "sharp" => Ok(RollOff::Sharp),
        _ => Err("must be gaussian or sharp".into()),
    }
}

fn method(text: &str) -> Result<Method, String> {
    serde_json::from_value(serde_json::Value::String(text.to_owned()))
        .map_err(|error| error.to_string().replace("variant", "method"))
}

impl LayerOptions {
    /// The layer called `name` with these options.
    pub fn layer(&self, name: &str, template: Template) -> Result<Layer, Failure> {
        let painted =
            if self.region.is_empty() { Painted::Everywhere } else { Painted::Spheres(self.region.clone()) };
        let smoothing = Smoothing { cutoff: self.cutoff, roll_off: self.roll_off, clamp: !self.no_clamp };
        let mut matching = Settings::default();
        matching.method = self.matching.unwrap_or(matching.method);
        if let Some(path) = &self.landmarks {
            matching.landmarks = load_landmarks(path).map_err(Failure::input)?;
        }
        let rough = template.is_mesh() && matching.method != Method::Same && self.mu < 0.0;
        let usual = || if rough { ScaleCurve::smooth() } else { ScaleCurve::flat(1.0) };
        let layer = Layer {
            name: name.to_owned(),
            template,
            matching,
            model: self.model,
            mu: self.mu,
            strength: self.strength,
            region: Region { painted, smoothing },
            curve: self.scale_curve.clone().unwrap_or_else(usual),
            enabled: true,
            solo: false,
        };
        layer.validate().map_err(Failure::input)?;
        Ok(layer)
    }
}
