//! `chladni mean A B C -o OUT`: the mean of several shapes, as a template.

use std::path::{Path, PathBuf};

use chladni_match::{MatchSettings, MeanShape, Method};
use chladni_mesh::{ShapeSource, TriMesh, save_mesh};

use super::Terminal;
use super::layer_options::{check_seed, method, scaling};
use crate::work::left_out::left_by;
use crate::work::outputs::check_mesh;
use crate::work::{Error, Warning, Watcher, source};

/// Average several shapes, such as scans of many heads, into one: a template of what is usual among them.
///
/// Each is matched with the first and brought to its pose and size; the result has the first one's triangles.
#[derive(clap::Args)]
pub struct Mean {
    /// Mesh files or sample:NAME, two or more.
    #[arg(required = true, num_args = 2..)]
    shapes: Vec<PathBuf>,
    /// Where the result goes: .obj, .ply, .stl or .glb.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// How each is matched with the first: same (connectivity), icp or fit.
    #[arg(long = "match", value_name = "METHOD", value_parser = without_landmarks, default_value = "fit")]
    matching: Method,
    /// Keep sizes: all shapes are in one unit.
    #[arg(long)]
    rigid: bool,
    /// Seed of all sampling [default: 0].
    #[arg(long)]
    seed: Option<u64>,
}

/// A method that needs no landmarks: they would be other pairs for each shape.
fn without_landmarks(text: &str) -> Result<Method, Error> {
    match method(text)? {
        Method::Map => Err(Error::input("map needs landmarks: the mean takes same, icp or fit")),
        method => Ok(method),
    }
}

impl Mean {
    /// Averages them and writes the result. One shape is held at a time beside the first.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let read: Vec<&Path> = self.shapes.iter().map(PathBuf::as_path).collect();
        check_mesh(&self.output, &read)?;
        check_seed(self.matching, self.seed)?;
        let Some((first, others)) = self.shapes.split_first() else {
            return Err(Error::input("the mean needs two shapes or more"));
        };
        let shape = source::mesh(first, terminal)?;
        // Each match takes long: a wrong name would lose all before it.
        others.iter().try_for_each(|path| source::check_there(&ShapeSource::named(path), terminal))?;
        let (method, scaling) = (self.matching, scaling(self.rigid));
        let usual = MatchSettings::default();
        let settings = MatchSettings { method, scaling, seed: self.seed.unwrap_or(usual.seed), ..usual };
        let mut mean = MeanShape::of(&shape);
        for path in others {
            let other = source::mesh(path, terminal)?;
            let names = format!("{}, matched with {}", first.display(), path.display());
            let report = terminal.watch("matching", |task| mean.add(&other, &settings, task));
            let report = report.map_err(|error| Error::from(error).of(&names))?;
            for warning in &report.warnings {
                terminal.warn(Warning::of(&names, warning));
            }
            let (misses, trust) = (100.0 * report.median_distance, 100.0 * report.mean_confidence);
            terminal.result(format_args!(
                "{}: median distance {misses:.2} % of the diagonal, mean confidence {trust:.0} %",
                path.display()
            ))?;
        }
        let result = TriMesh { positions: mean.positions(), ..shape };
        save_mesh(&result, &self.output).map_err(Error::unsaved)?;
        terminal.warn_each(left_by(&ShapeSource::named(first), &result, &self.output));
        terminal.wrote(&self.output)
    }
}
