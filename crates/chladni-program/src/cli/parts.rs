//! `chladni parts MESH`: the named parts of a head, or, at a level, the limbs of any shape.

use std::path::{Path, PathBuf};

use chladni_caricature::{HEAD_PARTS, HeadParts};
use chladni_harmonics::npz::write_npz;
use chladni_mesh::{ShapeSource, TriMesh};
use serde::Serialize;

use super::number::number;
use super::part_output::{COLORS, Divided, PartOutput};
use super::resolution::ResolutionOptions;
use super::{Terminal, limbs};
use crate::work::outputs::check_no_texture;
use crate::work::{Error, Subject, Warning, Watcher};

/// Find the parts of a head (nose, brow, eyes, mouth, chin, jaw, cheeks, ears, crown and neck), or of any shape.
#[derive(clap::Args)]
pub struct Parts {
    /// The shape: a mesh file or sample:NAME.
    mesh: PathBuf,
    /// Find what stands out of any shape in place of the named parts of a head, from 0 (whole limbs) to 1 (small
    /// features).
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = level)]
    level: Option<f64>,
    #[command(flatten)]
    resolution: ResolutionOptions,
    #[command(flatten)]
    output: PartOutput,
}

/// A level of [`Limbs`](chladni_caricature::Limbs).
pub fn level(text: &str) -> Result<f64, Error> {
    number(text, |x| (0.0..=1.0).contains(x), "a number from 0 to 1")
}

/// A part as it is printed.
#[derive(Serialize)]
struct Printed {
    name: &'static str,
    vertices: usize,
    /// The mean of its vertices' confidence; `None` of a part that was not found.
    confidence: Option<f64>,
}

impl Parts {
    /// Finds, writes and prints them.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let PartOutput { output, json, render, .. } = &self.output;
        self.output.check()?;
        let shape = ShapeSource::named(&self.mesh);
        let subject = Subject::open_at(self.resolution.wanted(), &shape, terminal)?;
        render.as_deref().map_or(Ok(()), |path| check_no_texture(path, &self.mesh, subject.whole()))?;
        let name = self.mesh.display().to_string();
        if let Some(level) = self.level {
            return limbs::run(&self.output, level, (&name, &subject), terminal);
        }
        let mesh = &*subject.mesh;
        let found = found(&name, mesh, terminal)?;
        if let Some(path) = output {
            let n = subject.whole().positions.len() as u64;
            let written = write_npz(path, |npz| {
                npz.array("part", &[n], subject.at_whole(&found.part, 0))?;
                npz.array("confidence", &[n], subject.at_whole(&found.confidence, 0.0))
            });
            written.map_err(|error| Error::unwritten(path, error))?;
        }
        if let Some(path) = render {
            let part = found.part.iter().map(|part| Some(usize::from(*part))).collect();
            let marks = HEAD_PARTS.iter().map(ToString::to_string).zip(COLORS).collect();
            self.output.draw(path, &Divided { name: &name, mesh, part, marks }, terminal)?;
        }
        let parts: Vec<Printed> =
            HEAD_PARTS.iter().enumerate().map(|(i, name)| Printed::of(name, i, &found)).collect();
        if *json {
            return terminal.json(&parts);
        }
        for Printed { name, vertices, confidence } in &parts {
            let trust = confidence.map_or_else(String::new, |c| format!(", confidence {c:.2}"));
            terminal.result(format_args!("{name:<8} {vertices} vertices{trust}"))?;
        }
        self.output.print_files(terminal)
    }
}

impl Printed {
    fn of(name: &'static str, part: usize, found: &HeadParts) -> Self {
        let (vertices, confidence) = found.extent(part);
        Self { name, vertices, confidence }
    }
}

/// The parts of the head `mesh`, which is called `name`: those of a sample are known; warns where another hardly matches
/// one.
pub fn found(name: &str, mesh: &TriMesh, terminal: &Terminal) -> Result<HeadParts, Error> {
    let sample = ShapeSource::sample_name(Path::new(name));
    if let Some(known) = sample.and_then(|sample| HeadParts::known(sample, mesh)) {
        return Ok(known);
    }
    let found = terminal.watch("finding the parts of the head", |task| HeadParts::of(mesh, task));
    let found = found.map_err(|error| Error::from(error).of(name))?;
    for warning in &found.report.warnings {
        terminal.warn(Warning::of(format_args!("{name}, matched with a head"), warning));
    }
    Ok(found)
}
