//! `chladni info MESH`: the health report.

use std::path::PathBuf;

use chladni_harmonics::CoverReport;
use chladni_mesh::{Estimate, HealthReport, Known, ShapeSource};
use serde::Serialize;

use super::Terminal;
use crate::work::{Error, Warning, Watcher, health_rows, laplacian_row, source};

/// Report what a mesh file holds and how sound it is.
#[derive(clap::Args)]
pub struct Info {
    /// A mesh file (OBJ, PLY, OFF, STL, glTF, GLB or Medit) or sample:NAME.
    mesh: PathBuf,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
}

/// The output of `--json`: the report, what had to be mended, and what is done for the Laplacian.
#[derive(Serialize)]
struct Printed {
    #[serde(flatten)]
    report: HealthReport,
    stands: Stands,
    mended: Vec<String>,
    /// `null` where the mesh has no harmonics.
    cover: Option<CoverReport>,
}

/// How the shape most probably stands, in the file's axes.
#[derive(Serialize)]
struct Stands {
    up: [f64; 3],
    front: [f64; 3],
    in_doubt: bool,
    because: &'static str,
}

impl Info {
    /// Prints the report.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let (report, mended, found, cover) = terminal.watch("reading the mesh", |task| {
            let source = ShapeSource::named(&self.mesh);
            let loaded = source.load(None).map_err(|error| source::explained(&source, error))?;
            let mended: Vec<String> = loaded.mended.iter().map(ToString::to_string).collect();
            // Samples are estimated, too: that shows how well it goes.
            let known = if source.stands().is_some() { Known::default() } else { source.known() };
            let found = Estimate::of(&loaded.mesh, known, task)?;
            Ok::<_, Error>((loaded.health(), mended, found, CoverReport::of(&loaded.mesh)))
        })?;
        for line in &mended {
            terminal.warn(Warning::of(self.mesh.display(), line));
        }
        if self.json {
            let stands = Stands {
                up: found.orientation.up(),
                front: found.orientation.front(),
                in_doubt: found.in_doubt,
                because: found.evidence.words(),
            };
            return terminal.json(&Printed { report, stands, mended, cover: cover.ok() });
        }
        for (name, value) in health_rows(&report).into_iter().chain([laplacian_row(cover.as_ref())]) {
            terminal.result(format_args!("{name:<22} {value}"))?;
        }
        let why = match found.in_doubt {
            true => "in doubt".to_owned(),
            false => format!("because {}", found.evidence.words()),
        };
        terminal.result(format_args!("{:<22} {} ({why})", "stands", found.orientation))
    }
}
