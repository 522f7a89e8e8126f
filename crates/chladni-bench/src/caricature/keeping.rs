//! `chladni-bench keeping`: what is left of an exaggeration that neither folds nor crosses.

use std::sync::Arc;
use std::time::Instant;

use chladni_caricature::{
    Action, Crossings, DEFAULT_HARMONICS, Layer, Model, Project, Property, ScaleCurve, ShapeSource, Template,
    flipped_triangles,
};
use chladni_harmonics::Laplacian;
use chladni_mesh::surface::vec3::add;

use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Watcher, body, make, settled, source};

/// Measure what keeping triangles leaves of an exaggeration, in all three models.
#[derive(clap::Args)]
pub struct BenchKeeping {
    /// The shape: a mesh file or sample:NAME.
    shape: String,
    /// The template, as `chladni caricature` takes it.
    template: Template,
    /// μ.
    #[arg(long, allow_hyphen_values = true, default_value_t = -1.5)]
    mu: f64,
    /// The template has the triangles of the shape.
    #[arg(long)]
    same: bool,
    /// K, the number of harmonics.
    #[arg(short = 'k', long, value_name = "K", default_value_t = DEFAULT_HARMONICS)]
    harmonics: usize,
}

impl BenchKeeping {
    /// Prints a row of a Markdown table for each model.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let mesh = source::mesh(&self.shape, terminal)?;
        let (body, _) = body::build(&self.shape, &mesh, self.harmonics, Laplacian::Delaunay, terminal)?;
        let mut project = Project::new(ShapeSource::Sample("bench".into()), self.harmonics);
        let mut layer = Layer { mu: self.mu, ..project.new_layer("bench", self.template.clone()) };
        if self.same {
            layer.matching.method = chladni_match::Method::Same;
            layer.curve = ScaleCurve::flat(1.0);
        }
        let id = project.push(layer)?;
        let mut stack = make(mesh, Arc::new(body), &project, false, terminal)?.stack;
        let surface = Arc::clone(stack.surface());
        let crossings = Crossings::of(Arc::clone(&surface));
        let crossing =
            |positions: &[[f64; 3]]| terminal.watch("crossings", |task| crossings.triangles(positions, task));
        let before = crossing(&surface.positions)?;
        let percent = |count: usize| 100.0 * count as f64 / surface.triangles.len() as f64;
        for model in Model::ALL {
            project.keep_triangles = false;
            project.apply(&Action::Set { layer: id, to: Property::Model(model) }, None)?;
            project.apply(&Action::Set { layer: id, to: Property::Mu(self.mu) }, None)?;
            let plain = stack.evaluate(&project);
            project.keep_triangles = true;
            let start = Instant::now();
            let kept = settled(&mut stack, &project, terminal)?;
            let seconds = start.elapsed().as_secs_f64();
            let Some(share) = kept.layers.first().and_then(|l| Some(l.kept.as_ref()?.share)) else {
                return Err(Error::input("the layer does not act"));
            };
            let counts = |displacement: &[[f64; 3]]| -> Result<(f64, f64), Error> {
                let at: Vec<_> =
                    surface.positions.iter().zip(displacement).map(|(x, d)| add(*x, *d)).collect();
                let mut new = crossing(&at)?;
                new.retain(|t| before.binary_search(t).is_err());
                Ok((percent(flipped_triangles(&surface, &surface.positions, &at).len()), percent(new.len())))
            };
            let ((folds, crosses), (left, still)) =
                (counts(&plain.displacement())?, counts(&kept.displacement())?);
            let template = self.template.to_string();
            let (shape, template, mu) = (name(&self.shape), name(&template), self.mu);
            let share = 100.0 * share;
            terminal.result(format_args!(
                "| {shape} | {template} | {mu} | {model} | {folds:.2} | {crosses:.2} | {left:.3} | {still:.3} | {share:.0} | {seconds:.1} |"
            ))?;
        }
        Ok(())
    }
}

/// The last part of a path.
fn name(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}
