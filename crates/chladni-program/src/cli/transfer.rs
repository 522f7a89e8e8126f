//! `chladni transfer NEUTRAL EXPRESSION TARGET -o OUT`: the same expression, or caricature, on another shape.

use std::path::PathBuf;

use chladni_match::{MatchSettings, Method, load_landmarks, transfer};
use chladni_mesh::surface::Bounds;
use chladni_mesh::surface::vec3::{length, sub};
use chladni_mesh::{ShapeSource, TriMesh, save_mesh};

use super::Terminal;
use super::layer_options::{check_landmarks, method, scaling};
use crate::work::left_out::{is_gltf, left_by};
use crate::work::outputs::check_mesh;
use crate::work::{Error, Warning, Watcher, source};

/// Move the difference between two shapes, such as an expression or a caricature, onto a third.
///
/// The result has the target's own triangles: `chladni caricature TARGET OUT --match same --rigid` takes it as a template,
/// for regions, scales and layers.
#[derive(clap::Args)]
pub struct TransferCommand {
    /// The shape without the expression.
    neutral: PathBuf,
    /// The same with it. Where the triangles are the same, vertex by vertex; else matched, less pose and size.
    expression: PathBuf,
    /// The shape that is to have it.
    target: PathBuf,
    /// Where the result goes: .obj, .ply, .stl or .glb.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// How much of the difference: 1 all of it, 2 twice as much, -1 the opposite.
    #[arg(long, allow_hyphen_values = true, default_value_t = 1.0)]
    amount: f64,
    /// How the target is matched with the neutral shape: same (connectivity), icp, fit, or map (by landmarks).
    #[arg(long = "match", value_name = "METHOD", value_parser = method, default_value = "fit")]
    matching: Method,
    /// Pairs of vertices that belong together, `target_vertex neutral_vertex` a line.
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
    /// Keep sizes: the neutral shape and the target are in one unit.
    #[arg(long)]
    rigid: bool,
}

impl TransferCommand {
    /// Moves it and writes the result.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        check_mesh(&self.output, &[&self.neutral, &self.expression, &self.target])?;
        check_landmarks(self.matching, self.landmarks.as_deref())?;
        if !self.amount.is_finite() {
            return Err(Error::input("the amount must be a finite number"));
        }
        let [neutral, expression, target] =
            [&self.neutral, &self.expression, &self.target].map(|path| source::mesh(path, terminal));
        let (neutral, expression, target) = (neutral?, expression?, target?);
        if is_one_shape(&neutral, &expression) {
            let hint = if is_gltf(&self.neutral) || is_gltf(&self.expression) {
                "; a GLB of Chladni holds the original with sliders: save PLY or OBJ"
            } else {
                ""
            };
            terminal.warn(Warning::Plain(format!(
                "{} and {} are one shape, so that nothing moves{hint}",
                self.neutral.display(),
                self.expression.display()
            )));
        }
        let landmarks = self.landmarks.as_deref().map_or(Ok(Vec::new()), load_landmarks)?;
        let (method, scaling) = (self.matching, scaling(self.rigid));
        let settings = MatchSettings { method, landmarks, scaling, ..MatchSettings::default() };
        let name = self.target.display();
        let found = terminal
            .watch("moving the difference", |task| transfer(&neutral, &expression, &target, &settings, task))
            .map_err(|error| Error::from(error).of(&name))?;
        for warning in &found.report.warnings {
            terminal
                .warn(Warning::of(format_args!("{name}, matched with {}", self.neutral.display()), warning));
        }
        let moved = target.positions.iter().zip(&found.positions);
        let moved = moved.map(|(x, r)| std::array::from_fn(|i| x[i] + self.amount * (r[i] - x[i])));
        let result = TriMesh { positions: moved.collect(), ..target };
        save_mesh(&result, &self.output).map_err(Error::unsaved)?;
        terminal.warn_each(left_by(&ShapeSource::named(&self.target), &result, &self.output));
        let trusted = 100.0 * found.confidence.iter().sum::<f64>() / (found.confidence.len().max(1) as f64);
        terminal.result(format_args!("mean confidence {trusted:.0} %"))?;
        terminal.wrote(&self.output)
    }
}

/// Whether the vertices of both are the same, but for rounding.
fn is_one_shape(a: &TriMesh, b: &TriMesh) -> bool {
    let near = 1e-6 * Bounds::of(a.positions.iter().copied()).diagonal();
    let mut pairs = a.positions.iter().zip(&b.positions);
    a.positions.len() == b.positions.len() && pairs.all(|(a, b)| length(sub(*a, *b)) <= near)
}
