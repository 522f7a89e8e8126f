//! `chladni basis`: the harmonics of a mesh as numbers.

use std::path::PathBuf;

use chladni_harmonics::npz::{write_basis, write_operator};
use chladni_harmonics::{BasisSettings, Body, BuildReport, HarmonicsError, Laplacian, Operator};
use chladni_mesh::{ShapeSource, weld};
use serde::Serialize;

use super::Terminal;
use crate::work::body::{basis_cache, laplacian};
use crate::work::outputs::check_file;
use crate::work::{Error, Warning, Watcher};

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
        let loaded = ShapeSource::named(&self.mesh).load(None)?;
        let named = |error: HarmonicsError| Error::from(error).of(self.mesh.display());
        let settings = BasisSettings {
            laplacian: laplacian(self.paper),
            threads: self.threads,
            whole_clusters: self.whole_clusters,
            ..BasisSettings::new(self.harmonics)
        };
        let cache = if self.no_cache { None } else { basis_cache() };
        let (harmonics, vertices) = (self.harmonics, weld(&loaded.mesh).positions.len());
        if harmonics > vertices && vertices > 0 {
            return Err(named(HarmonicsError::BadHarmonicCount { harmonics, vertices }));
        }
        let wanted = self.operator.is_some().then(|| Operator::with(&loaded.mesh, settings.laplacian));
        let operator = wanted.transpose().map_err(named)?;
        let (body, report) = terminal
            .watch("harmonics", |task| match &operator {
                Some(operator) => Body::of_operator(&loaded.mesh, operator, &settings, cache.as_ref(), task),
                None => Body::load_or_build(&loaded.mesh, &settings, cache.as_ref(), task),
            })
            .map_err(named)?;
        for warning in report.warnings(&body.basis.certificate) {
            terminal.warn(Warning::Told(warning.to_string()));
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
        if let (Some(path), Some(operator)) = (&self.operator, &operator) {
            write_operator(path, operator).map_err(|e| Error::unwritten(path, e))?;
        }
        if let Some(path) = &self.output {
            write_basis(path, &body).map_err(|e| Error::unwritten(path, e))?;
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
