//! `chladni info MESH`: the health report.

use std::path::PathBuf;

use chladni_harmonics::{CoverReport, HarmonicsError};
use chladni_mesh::{Estimate, HealthReport, Known, ShapeSource, Topology};
use serde::Serialize;

use super::Terminal;
use crate::work::{Error, Warning, Watcher};

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
            let loaded = source.load(None)?;
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
        lines(&report).into_iter().try_for_each(|line| terminal.result(line))?;
        terminal.result(format_args!("{:<22} {}", "Laplacian", operated(&cover)))?;
        let why = match found.in_doubt {
            true => "in doubt".to_owned(),
            false => format!("because {}", found.evidence.words()),
        };
        terminal.result(format_args!("{:<22} {} ({why})", "stands", found.orientation))
    }
}

fn lines(report: &HealthReport) -> Vec<String> {
    let mut lines = Vec::new();
    let mut row = |name: &str, value: String| lines.push(format!("{name:<22} {value}"));
    row("vertices", report.vertices.to_string());
    row("triangles", report.triangles.to_string());
    if report.polygons != report.triangles {
        row("polygons", report.polygons.to_string());
    }
    row("as stored", described(&report.topology));
    let welded = &report.welded;
    if welded.vertices != report.vertices || welded.triangles != report.triangles {
        let counts = format!("{} vertices, {} triangles", welded.vertices, welded.triangles);
        row("welded", format!("{counts}; {}", described(&welded.topology)));
    }
    for (name, count) in [
        ("degenerate triangles", report.degenerate_triangles),
        ("duplicate triangles", report.duplicate_triangles),
        ("duplicate vertices", report.duplicate_vertices),
        ("unreferenced vertices", report.unreferenced_vertices),
    ] {
        row(name, count.to_string());
    }
    if report.inward_triangles > 0 {
        let of = format!("{} of {}", report.inward_triangles, welded.triangles);
        row("faces look inward", format!("{of}, or against their neighbors"));
    }
    let [low, high] = [report.bounds_min, report.bounds_max];
    let length = |value| digits(value, report.diagonal);
    for (i, axis) in ["x", "y", "z"].into_iter().enumerate() {
        row(axis, format!("{} to {}", length(low[i]), length(high[i])));
    }
    let extent: Vec<String> = (0..3).map(|i| length(high[i] - low[i])).collect();
    row("extent", format!("{} (diagonal {})", extent.join(" × "), length(report.diagonal)));
    row("area", digits(report.area, report.area));
    if let Some(volume) = report.volume {
        row("volume", digits(volume, volume));
    }
    lines
}

/// What is done to the shape for its Laplacian, or why it has none.
fn operated(cover: &Result<CoverReport, HarmonicsError>) -> String {
    cover.as_ref().map_or_else(|error| format!("none: {error}"), ToString::to_string)
}

/// `value` with six decimals or, where these would say little on a `scale` as small as this one, six digits.
fn digits(value: f64, scale: f64) -> String {
    if scale.abs() < 1e-3 && value != 0.0 { format!("{value:.5e}") } else { format!("{:.6}", value + 0.0) }
}

/// A topology in words, the good news short.
fn described(topology: &Topology) -> String {
    let count = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
    let mut words = vec![
        count(topology.components, "component", "components"),
        match topology.boundary_loops {
            0 => "closed".to_owned(),
            loops => count(loops, "boundary loop", "boundary loops"),
        },
    ];
    for (n, one, many) in [
        (topology.nonmanifold_edges, "non-manifold edge", "non-manifold edges"),
        (topology.nonmanifold_vertices, "non-manifold vertex", "non-manifold vertices"),
        (topology.misoriented_edges, "wrongly oriented edge", "wrongly oriented edges"),
    ] {
        if n > 0 {
            words.push(count(n, one, many));
        }
    }
    if let Some(genus) = topology.genus {
        words.push(format!("genus {genus}"));
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_done_for_the_laplacian_is_described_and_so_is_why_there_is_none() {
        let ball = chladni_mesh::samples::icosphere(1);
        assert_eq!(operated(&CoverReport::of(&ball)), "the mesh as it is, 0 edge flips");
        let line = chladni_mesh::TriMesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..chladni_mesh::TriMesh::default()
        };
        assert!(operated(&CoverReport::of(&line)).starts_with("none: "));
    }

    #[test]
    fn small_shapes_have_sizes_too() {
        assert_eq!(digits(1.25, 2.0), "1.250000");
        assert_eq!(digits(-0.0, 2.0), "0.000000");
        assert_eq!(digits(1e-5, 1.7e-5), "1.00000e-5");
        assert_eq!(digits(0.0, 1.7e-5), "0.000000");
    }
}
