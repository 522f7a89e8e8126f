//! `chladni basis`: the harmonics of a mesh as numbers.

use std::io;
use std::path::PathBuf;

use chladni_harmonics::{BasisSettings, Body, BuildReport, HarmonicsError, Laplacian, Operator};
use serde::Serialize;

use super::Terminal;
use crate::work::body::{basis_cache, laplacian};
use crate::work::npz::{Npz, write_npz};
use crate::work::outputs::check_file;
use crate::work::{Error, Warning, Watcher, source};

/// Solve for the harmonics of a mesh and write them for NumPy.
#[derive(clap::Args)]
pub struct Args {
    /// A mesh file or sample:NAME.
    mesh: PathBuf,
    /// K, the number of harmonics.
    #[arg(short = 'k', long, value_name = "K", default_value_t = 256)]
    harmonics: usize,
    /// Write `eigenvalues` (K), `eigenvectors` (N×K), `mass` (N) and `operator_vertex` (n:
    /// file vertex → row, −1 where no triangle uses it), in the file's own units.
    #[arg(short, long, value_name = "B.npz")]
    output: Option<PathBuf>,
    /// Write the stiffness matrix as solved here (N×N, for scipy.sparse.load_npz).
    #[arg(long, value_name = "S.npz")]
    operator: Option<PathBuf>,
    /// Print what was solved, how long it took and the certificate as JSON.
    #[arg(long)]
    json: bool,
    /// Worker threads (all of the machine's by default). The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Neither read nor write the cache of solved bases.
    #[arg(long)]
    no_cache: bool,
    /// The papers' plain cotangent Laplacian, which not every mesh can have.
    #[arg(long)]
    paper: bool,
    /// Where K would cut a group of equal eigenvalues, go on to its end.
    #[arg(long)]
    whole_clusters: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Summary {
    laplacian: Laplacian,
    vertices: usize,
    harmonics: usize,
    seconds: chladni_harmonics::BuildSeconds,
    max_relative_residual: f64,
    max_orthogonality_error: f64,
    inertia_counts_match: bool,
    cached: bool,
    cuts_cluster: bool,
    profile: chladni_harmonics::SolveProfile,
}

impl Args {
    /// Solves, writes what was asked for, and reports.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        [&self.output, &self.operator].into_iter().flatten().try_for_each(|path| check_file(path))?;
        let loaded = source::loaded(&source::shape_source(&self.mesh))?;
        let named = |error: HarmonicsError| Error::from(error).of(self.mesh.display());
        let settings = BasisSettings {
            laplacian: laplacian(self.paper),
            threads: self.threads,
            whole_clusters: self.whole_clusters,
            ..BasisSettings::new(self.harmonics)
        };
        let cache = if self.no_cache { None } else { basis_cache() };
        let (body, report) = terminal
            .watch("harmonics", |task| Body::load_or_build(&loaded.mesh, &settings, cache.as_ref(), task))
            .map_err(named)?;
        for warning in report.warnings(&body.basis.certificate) {
            terminal.warn(Warning::Told(warning));
        }
        if report.fell_back_to_dense {
            terminal.warn(Warning::Told(
                "the eigenvalues could not be counted in slices; solved as a dense matrix instead".into(),
            ));
        }
        if report.cuts_cluster {
            terminal.warn(Warning::Told(format!(
                "harmonic {} belongs to a group of equal eigenvalues that goes on; --whole-clusters takes all of it",
                self.harmonics - 1
            )));
        }
        if let Some(path) = &self.operator {
            let operator = Operator::with(&loaded.mesh, settings.laplacian).map_err(named)?;
            write_npz(path, |npz| write_operator(npz, &operator)).map_err(|e| Error::unwritten(path, e))?;
        }
        if let Some(path) = &self.output {
            write_npz(path, |npz| write_basis(npz, &body)).map_err(|e| Error::unwritten(path, e))?;
        }
        self.report(terminal, &body, &report)
    }

    fn report(&self, terminal: &Terminal, body: &Body, report: &BuildReport) -> Result<(), Error> {
        let (basis, certificate) = (&body.basis, &body.basis.certificate);
        if self.json {
            return terminal.json(&Summary {
                laplacian: certificate.laplacian,
                vertices: basis.vertices(),
                harmonics: basis.harmonics(),
                seconds: report.seconds,
                max_relative_residual: certificate.max_relative_residual,
                max_orthogonality_error: certificate.max_orthogonality_error,
                inertia_counts_match: certificate.inertia_counts_match,
                cached: report.cached,
                cuts_cluster: report.cuts_cluster,
                profile: report.profile,
            });
        }
        terminal.result(format_args!(
            "{} harmonics of {} vertices ({} Laplacian) in {:.2} s{}; residual {:.1e}, orthogonality {:.1e}, counts {}",
            basis.harmonics(),
            basis.vertices(),
            certificate.laplacian,
            report.seconds.total,
            if report.cached { " (cached)" } else { "" },
            certificate.max_relative_residual,
            certificate.max_orthogonality_error,
            if certificate.inertia_counts_match { "match" } else { "do not match" },
        ))?;
        [&self.output, &self.operator].into_iter().flatten().try_for_each(|path| terminal.wrote(path))
    }
}

/// Working units back to the file's: lengths by 1/s, so areas by 1/s², eigenvalues by s² and
/// harmonics, which are orthonormal under the areas, by s.
fn write_basis(npz: &mut Npz<'_, '_>, body: &Body) -> io::Result<()> {
    let basis = &body.basis;
    let (n, k) = (basis.vertices() as u64, basis.harmonics() as u64);
    let s = body.frame.scale;
    npz.array("eigenvalues", &[k], basis.eigenvalues.iter().map(|l| l * s * s))?;
    npz.array("mass", &[n], basis.mass.iter().map(|a| a / (s * s)))?;
    let rows = body.operator_vertex.iter().map(|v| v.map_or(-1, i64::from));
    npz.array("operator_vertex", &[body.operator_vertex.len() as u64], rows)?;
    npz.columns("eigenvectors", [n, k], basis.vectors.iter().map(|h| h * s))
}

fn write_operator(npz: &mut Npz<'_, '_>, operator: &Operator) -> io::Result<()> {
    let stiffness = &operator.stiffness;
    let (n, entries) = (stiffness.size() as u64, stiffness.values.len() as u64);
    npz.array("indices", &[entries], stiffness.rows.iter().map(|&r| i64::from(r)))?;
    npz.array("indptr", &[n + 1], stiffness.column_starts.iter().map(|&c| c as i64))?;
    npz.word("format", "csc")?;
    npz.array("shape", &[2], [n as i64, n as i64])?;
    npz.array("data", &[entries], stiffness.values.iter().copied())
}
