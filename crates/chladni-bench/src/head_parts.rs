//! `chladni-bench head-parts`: how well the named parts of heads are found whose parts are known.

use chladni_caricature::HeadParts;
use chladni_mesh::samples::{HEAD_PARTS, head_parts, sample};
use chladni_mesh::surface::vertex_areas;

use super::limbs::{overlap, shared_areas};
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Watcher};

/// Measure how well the named parts of heads are found whose parts are known.
#[derive(clap::Args)]
pub struct BenchHeadParts {
    /// The heads: `head`, or `portrait` with sliders.
    #[arg(default_values = [
        "head", "portrait", "portrait?age=-1.00", "portrait?age=1.00",
        "portrait?width=0.90,cheeks=0.50,jaw=0.80,neck=0.80", "portrait?width=-0.90,length=0.60,jaw=-0.60",
        "portrait?brow=-0.60,eyes=0.50,nose=-0.50,lips=0.60,jaw=-0.70,neck=-0.60",
        "portrait?brow=0.90,nose=0.60,bridge=0.80,jaw=0.90,chin=0.70",
    ])]
    heads: Vec<String>,
}

impl BenchHeadParts {
    /// Prints a row of a Markdown table for each head: for each part, intersection over union by area.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        for name in &self.heads {
            let missing = || Error::input(format!("sample:{name} has no known parts"));
            let mesh = sample(name).ok_or_else(missing)?;
            let known = head_parts(name, &mesh).ok_or_else(missing)?;
            let found = terminal
                .watch("parts", |task| HeadParts::of(&mesh, task))
                .map_err(|why| Error::other(why.to_string()))?;
            let areas = vertex_areas(&mesh.positions, &mesh.triangles);
            let [found, known]: [Vec<u32>; 2] =
                [&found.part, &known].map(|parts| parts.iter().copied().map(u32::from).collect());
            let count = HEAD_PARTS.len();
            let shared = shared_areas(&found, count, &known, count, &areas);
            let overlaps: Vec<f64> = (0..count).map(|part| overlap(&shared, part, part)).collect();
            let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
            let cells: Vec<String> = overlaps.iter().map(|overlap| format!("{overlap:.2}")).collect();
            terminal.result(format_args!("| `{name}` | {} | {mean:.2} |", cells.join(" | ")))?;
        }
        Ok(())
    }
}
