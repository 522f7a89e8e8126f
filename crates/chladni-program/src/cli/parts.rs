//! `chladni parts MESH`: the named parts of a head, or, at a level, the limbs of any shape.

use std::path::PathBuf;

use chladni_caricature::{HEAD_PARTS, HeadParts};
use chladni_harmonics::npz::write_npz;
use chladni_mesh::TriMesh;
use serde::Serialize;

use super::part_output::{COLORS, Colored, PartOutput, draw};
use super::{Terminal, limbs};
use crate::work::outputs::check_no_texture;
use crate::work::{Error, Warning, Watcher, source};

/// Find the parts of a head (nose, brow, eyes, mouth, chin, jaw, cheeks, ears, crown and neck), or of any shape.
#[derive(clap::Args)]
pub struct Parts {
    /// The shape: a mesh file or sample:NAME.
    mesh: PathBuf,
    /// Find what stands out of any shape in place of the named parts of a head, from 0 (whole limbs) to 1 (small
    /// features).
    #[arg(long, value_name = "X", value_parser = level)]
    level: Option<f64>,
    #[command(flatten)]
    output: PartOutput,
}

/// A level of [`Limbs`](chladni_caricature::Limbs).
pub fn level(text: &str) -> Result<f64, Error> {
    let parsed = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
    parsed.ok_or_else(|| Error::input("must be a number from 0 to 1"))
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
        let PartOutput { output, json, render } = &self.output;
        self.output.check()?;
        let mesh = source::mesh(&self.mesh, terminal)?;
        render.as_deref().map_or(Ok(()), |path| check_no_texture(path, &self.mesh, &mesh))?;
        let name = self.mesh.display().to_string();
        if let Some(level) = self.level {
            return limbs::run(&self.output, level, (&name, &mesh), terminal);
        }
        let found = found(&name, &mesh, terminal)?;
        if let Some(path) = output {
            let n = found.part.len() as u64;
            let written = write_npz(path, |npz| {
                npz.array("part", &[n], found.part.iter().copied())?;
                npz.array("confidence", &[n], found.confidence.iter().copied())
            });
            written.map_err(|error| Error::unwritten(path, error))?;
        }
        if let Some(path) = render {
            let color = |part: &u8| COLORS.get(usize::from(*part)).copied().unwrap_or([1.0; 4]);
            let colors = found.part.iter().map(color).collect();
            draw(path, Colored { name: &name, mesh: &mesh, colors }, terminal)?;
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

/// The parts of the head `mesh`, which is called `name`; warns where it hardly matches one.
pub fn found(name: &str, mesh: &TriMesh, terminal: &Terminal) -> Result<HeadParts, Error> {
    let found = terminal.watch("finding the parts of the head", |task| HeadParts::of(mesh, task));
    let found = found.map_err(|error| Error::from(error).of(name))?;
    for warning in &found.report.warnings {
        terminal.warn(Warning::of(format_args!("{name}, matched with a head"), warning));
    }
    Ok(found)
}
