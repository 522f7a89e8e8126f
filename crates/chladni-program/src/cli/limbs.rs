//! `chladni parts MESH --level X`: the limbs of any shape.

use chladni_caricature::{Limbs, Painted};
use chladni_harmonics::Laplacian;
use chladni_harmonics::npz::write_npz;
use chladni_mesh::TriMesh;
use chladni_task::counted;
use serde::Serialize;

use super::Terminal;
use super::part_output::{COLORS, Divided, PartOutput};
use crate::work::{Error, Subject, body, twins_of};

/// A trunk in the picture, linear light.
const TRUNK: [f32; 4] = [0.62, 0.66, 0.70, 1.0];

/// A part as it is printed.
#[derive(Serialize)]
struct Printed {
    part: usize,
    share: f64,
    persistence: f64,
    twin: Option<usize>,
}

/// Finds, writes, draws and prints the parts of `subject`, which is called `name`, at `level`.
pub fn run(
    wanted: &PartOutput,
    level: f64,
    (name, subject): (&str, &Subject),
    terminal: &Terminal,
) -> Result<(), Error> {
    let mesh = &*subject.mesh;
    let (body, _) = body::build(name, mesh, Limbs::HARMONICS, Laplacian::Delaunay, terminal)?;
    let found = Limbs::of(&body, level);
    let twins = twins_of(&found, &body, terminal)?;
    let part_of = |vertex: &Option<u32>| vertex.and_then(|v| found.part.get(v as usize)).copied();
    if let Some(path) = &wanted.output {
        // −1 where no triangle uses the vertex.
        let parts: Vec<i64> = body.operator_vertex.iter().map(|v| part_of(v).map_or(-1, i64::from)).collect();
        let parts = subject.at_whole(&parts, -1);
        let written = write_npz(path, |npz| npz.array("part", &[parts.len() as u64], parts));
        written.map_err(|error| Error::unwritten(path, error))?;
    }
    if let Some(path) = &wanted.render {
        let part = body.operator_vertex.iter().map(|v| part_of(v).map(|part| part as usize)).collect();
        let colors = colors(&found, &twins).into_iter().enumerate();
        let marks = colors.map(|(part, color)| (part.to_string(), color)).collect();
        wanted.draw(path, &Divided { name, mesh, part, marks }, terminal)?;
    }
    let parts = found.parts.iter().zip(twins).enumerate();
    let parts: Vec<Printed> = parts
        .map(|(part, (limb, twin))| Printed { part, share: limb.share, persistence: limb.persistence, twin })
        .collect();
    if wanted.json {
        return terminal.json(&parts);
    }
    for (Printed { part, share, persistence, twin }, limb) in parts.iter().zip(&found.parts) {
        let twin = twin.map_or_else(String::new, |twin| format!(", mirror image of {twin}"));
        let kind =
            if limb.is_trunk() { "trunk".to_owned() } else { format!("stands out by {persistence:.2}") };
        terminal.result(format_args!("{part:<3} {:.1} % of the surface, {kind}{twin}", 100.0 * share))?;
    }
    wanted.print_files(terminal)
}

/// χ01 of some parts of the shape of that name, by their numbers at `level`.
pub fn region(
    (name, mesh): (&str, &TriMesh),
    level: f64,
    wanted: &[usize],
    terminal: &Terminal,
) -> Result<Painted, Error> {
    let (body, _) = body::build(name, mesh, Limbs::HARMONICS, Laplacian::Delaunay, terminal)?;
    let found = Limbs::of(&body, level);
    let count = found.parts.len();
    match wanted.iter().find(|part| **part >= count) {
        Some(part) => {
            let parts = counted(count, "part", "parts");
            Err(Error::Input(format!("{name} has {parts} at level {level}, from 0 on: there is no {part}")))
        }
        None => Ok(found.painted(wanted)),
    }
}

/// A color for each part: gray for trunks, the same for mirror images.
fn colors(found: &Limbs, twins: &[Option<usize>]) -> Vec<[f32; 4]> {
    let mut next = COLORS.iter().filter(|color| **color != TRUNK).cycle();
    let mut colors: Vec<Option<[f32; 4]>> = vec![None; found.parts.len()];
    for (i, part) in found.parts.iter().enumerate() {
        let of_twin = twins[i].and_then(|twin| colors[twin]);
        colors[i] = if part.is_trunk() { Some(TRUNK) } else { of_twin.or_else(|| next.next().copied()) };
    }
    colors.into_iter().map(Option::unwrap_or_default).collect()
}
