//! `chladni basis`: the harmonics of a mesh as numbers.

use std::io;
use std::path::{Path, PathBuf};

use chladni_harmonics::npz::{write_basis, write_basis_folder, write_operator};
use chladni_harmonics::{
    BasisSettings, Body, BuildReport, CoverReport, HarmonicsError, InnerSolver, Laplacian, MOST_THREADS,
    Operator, Ranks, RanksReport,
};
use chladni_mesh::weld;
use chladni_task::{Task, counted};
use serde::Serialize;

use super::Terminal;
use crate::work::body::{basis_cache, laplacian};
use crate::work::outputs::{check_arrays, check_distinct, check_folder};
use crate::work::{Error, Warning, Watcher, source};

/// Solve for the harmonics of a mesh and write them for NumPy.
#[derive(clap::Args)]
pub struct Args {
    /// A mesh file or sample:NAME.
    mesh: PathBuf,
    /// K, the number of harmonics [default: 256, or all where there are fewer].
    #[arg(short = 'k', long, value_name = "K")]
    harmonics: Option<usize>,
    /// Write `eigenvalues` (K), `eigenvectors` (N×K), `mass` (N) and `operator_vertex` (n:
    /// file vertex → row, −1 where no triangle uses it), in the file's own units.
    /// A name that ends in / is a folder: then each is a .npy file of its own, which NumPy can read in parts
    /// (`mmap_mode="r"`).
    #[arg(short, long, value_name = "B.npz|DIR/")]
    output: Option<PathBuf>,
    /// Write the stiffness matrix as solved here (N×N, for scipy.sparse.load_npz).
    #[arg(long, value_name = "S.npz")]
    operator: Option<PathBuf>,
    /// Print what was solved, how long it took and the certificate as JSON.
    #[arg(long)]
    json: bool,
    /// Worker threads, at most 1024 [default: 0, all of the machine's]. The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Memory in GB that the solve may take [default: what is free]. What does not fit is kept in --scratch.
    #[arg(long, value_name = "GB", allow_negative_numbers = true, value_parser = gigabytes)]
    memory: Option<f64>,
    /// The folder for harmonics that do not fit in memory, and for what passes between the ranks of --engine slepc,
    /// which all hosts must share [default: the folder that TMPDIR names, else /var/tmp].
    #[arg(long, value_name = "DIR")]
    scratch: Option<PathBuf>,
    /// Neither read nor write the cache of solved bases.
    #[arg(long)]
    no_cache: bool,
    /// The papers' plain cotangent Laplacian, which not every mesh can have.
    #[arg(long)]
    paper: bool,
    /// Where K would cut a group of equal eigenvalues, go on to its end.
    #[arg(long)]
    whole_clusters: bool,
    /// Who solves: chladni, on this machine, or slepc, on the ranks of MPI, for meshes that outgrow it (needs Open MPI
    /// and slepc4py, docs/scale.md). The certificate is Chladni's own.
    #[arg(long, value_name = "ENGINE", default_value = "chladni")]
    engine: Engine,
    #[command(flatten)]
    on: RankOptions,
}

/// Who solves.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Engine {
    Chladni,
    Slepc,
}

/// Where SLEPc solves.
#[derive(clap::Args)]
struct RankOptions {
    /// MPI processes for --engine slepc [default: one for each core].
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// Split the ranks into this many groups, each with a factor and a part of the spectrum of its own: quicker, with as
    /// many times the memory.
    #[arg(long, value_name = "G")]
    groups: Option<usize>,
    /// Solve without factors, for meshes whose factors do not fit on all ranks together. Nothing then counts the
    /// eigenvalues; a second search for what may be missing takes its place.
    #[arg(long, conflicts_with = "groups")]
    iterative: bool,
    /// A host file of MPI, to solve on more than this machine.
    #[arg(long, value_name = "FILE")]
    hosts: Option<PathBuf>,
}

impl RankOptions {
    /// The ranks that `engine` needs.
    fn of(&self, engine: Engine, scratch: &Path) -> Result<Option<Ranks>, Error> {
        let Self { ranks, groups, iterative, hosts } = self;
        if engine == Engine::Chladni {
            let given = ranks.is_some() || groups.is_some() || *iterative || hosts.is_some();
            let refused = "--ranks, --groups, --iterative and --hosts belong to --engine slepc";
            return if given { Err(Error::input(refused)) } else { Ok(None) };
        }
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let ranks = Ranks {
            count: ranks.unwrap_or_else(cores),
            inner: if *iterative {
                InnerSolver::Iterated
            } else {
                InnerSolver::Factors { groups: groups.unwrap_or(1) }
            },
            hosts: hosts.clone(),
            scratch: Some(scratch.to_owned()),
        };
        ranks.check()?;
        Ok(Some(ranks))
    }
}

/// The output of `--json`.
#[derive(Serialize)]
struct Summary {
    laplacian: Laplacian,
    /// `null` for the papers' Laplacian, and for a basis from the cache.
    cover: Option<CoverReport>,
    vertices: usize,
    harmonics: usize,
    seconds: chladni_harmonics::BuildSeconds,
    max_relative_residual: f64,
    max_orthogonality_error: f64,
    /// `null` where no count shows it.
    inertia_counts_match: Option<bool>,
    cached: bool,
    cuts_cluster: bool,
    profile: chladni_harmonics::SolveProfile,
    #[serde(skip_serializing_if = "Option::is_none")]
    ranks: Option<RanksReport>,
}

/// The solver on ranks, in words.
fn by_ranks(of: &RanksReport) -> String {
    let how = match of.counted_by {
        Some(program) => format!("counted by {program}"),
        None => format!("in {} searches, the last of which found none that was missing", of.searches),
    };
    format!(" by SLEPc on {}, {how}", counted(of.ranks, "rank", "ranks"))
}

/// Whether `path` is the name of a folder, which ends with a separator.
fn is_folder(path: &Path) -> bool {
    path.as_os_str().as_encoded_bytes().last().is_some_and(|end| std::path::is_separator(char::from(*end)))
}

fn gigabytes(text: &str) -> Result<f64, Error> {
    let value: f64 = text.parse().map_err(|_| Error::input("not a number"))?;
    if value > 0.0 && value < 1e9 { Ok(value) } else { Err(Error::input("a size in GB, above 0")) }
}

/// Writes the file or folder `path`; Ctrl-C stops that, too.
fn written(
    terminal: &Terminal,
    path: &Path,
    write: impl FnOnce(&Task) -> io::Result<()>,
) -> Result<(), Error> {
    terminal.watch("writing", write).map_err(|error| match terminal.task().check() {
        Err(cancelled) => cancelled.into(),
        Ok(()) => Error::unwritten(path, error),
    })
}

impl Args {
    /// Solves, writes the files asked for, and reports.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let folder = self.output.as_deref().filter(|path| is_folder(path));
        let files = [self.output.as_ref().filter(|_| folder.is_none()), self.operator.as_ref()];
        let files: Vec<&Path> = files.into_iter().flatten().map(PathBuf::as_path).collect();
        files.iter().try_for_each(|path| check_arrays(path))?;
        check_distinct(&files)?;
        folder.map_or(Ok(()), check_folder)?;
        if let Some(scratch) = self.scratch.as_deref().filter(|path| !path.is_dir()) {
            return Err(Error::Input(format!("--scratch {}: there is no such folder", scratch.display())));
        }
        let scratch = self.scratch.clone().unwrap_or_else(BasisSettings::default_scratch);
        let ranks = self.on.of(self.engine, &scratch)?;
        if ranks.is_some() && self.threads.is_some() {
            return Err(Error::input("--threads is for Chladni's own solver; SLEPc has --ranks"));
        }
        // A basis from the cache would never ask for them.
        if let Some(threads) = self.threads.filter(|threads| *threads > MOST_THREADS) {
            let too_many = HarmonicsError::TooManyThreads { threads, most: MOST_THREADS };
            return Err(Error::from(too_many).of("--threads"));
        }
        let mesh = source::mesh(&self.mesh, terminal)?;
        let named = |error: HarmonicsError| Error::from(error).of(self.mesh.display());
        let settings = BasisSettings {
            harmonics: self.harmonics.unwrap_or(BasisSettings::default().harmonics),
            laplacian: laplacian(self.paper),
            threads: self.threads,
            whole_clusters: self.whole_clusters,
            memory_bytes: self.memory.map(|gigabytes| (1e9 * gigabytes) as u64),
            scratch: Some(scratch),
        };
        let cache = if self.no_cache { None } else { basis_cache() };
        if let Some(harmonics) = self.harmonics {
            let vertices = weld(&mesh).positions.len();
            if harmonics > vertices && vertices > 0 {
                return Err(named(HarmonicsError::BadHarmonicCount { harmonics, vertices }));
            }
        }
        let wanted =
            (self.operator.is_some() || ranks.is_some()).then(|| Operator::with(&mesh, settings.laplacian));
        let operator = wanted.transpose().map_err(named)?;
        let (body, report, of_ranks) = terminal
            .watch("harmonics", |task| match (&operator, &ranks) {
                (Some(operator), Some(ranks)) => {
                    Body::solve_on_ranks(&mesh, operator, &settings, ranks, task)
                        .map(|(body, report, of_ranks)| (body, report, Some(of_ranks)))
                }
                (Some(operator), None) => Body::of_operator(&mesh, operator, &settings, cache.as_ref(), task)
                    .map(|(body, report)| (body, report, None)),
                (None, _) => Body::load_or_build(&mesh, &settings, cache.as_ref(), task)
                    .map(|(body, report)| (body, report, None)),
            })
            .map_err(named)?;
        for warning in report.warnings(&body.basis.certificate) {
            terminal.warn(Warning::of(self.mesh.display(), warning));
        }
        if report.fell_back_to_dense {
            terminal.warn(Warning::Plain(
                "the eigenvalues could not be counted in slices; solved as a dense matrix instead".into(),
            ));
        }
        if report.cuts_cluster {
            terminal.warn(Warning::Plain(format!(
                "harmonic {} belongs to a group of equal eigenvalues that goes on; --whole-clusters takes all of it",
                settings.harmonics - 1
            )));
        }
        if let (Some(path), Some(operator)) = (&self.operator, &operator) {
            written(terminal, path, |task| write_operator(path, operator, task))?;
        }
        if let Some(path) = &self.output {
            let write = if folder.is_some() { write_basis_folder } else { write_basis };
            written(terminal, path, |task| write(path, &body, task))?;
        }
        self.report(terminal, &body, &report, of_ranks)
    }

    fn report(
        &self,
        terminal: &Terminal,
        body: &Body,
        report: &BuildReport,
        of_ranks: Option<RanksReport>,
    ) -> Result<(), Error> {
        let (basis, certificate) = (&body.basis, &body.basis.certificate);
        if self.json {
            return terminal.json(&Summary {
                laplacian: certificate.laplacian,
                cover: report.cover,
                vertices: basis.vertices(),
                harmonics: basis.harmonics(),
                seconds: report.seconds,
                max_relative_residual: certificate.max_relative_residual,
                max_orthogonality_error: certificate.max_orthogonality_error,
                inertia_counts_match: certificate.inertia_counts_match,
                cached: report.cached,
                cuts_cluster: report.cuts_cluster,
                profile: report.profile,
                ranks: of_ranks,
            });
        }
        terminal.result(format_args!(
            "{} of {} vertices ({} Laplacian{}) in {:.2} s{}{}; residual {:.1e}, orthogonality {:.1e}, {}",
            counted(basis.harmonics(), "harmonic", "harmonics"),
            basis.vertices(),
            certificate.laplacian,
            report.cover.map_or_else(String::new, |cover| format!(": {cover}")),
            report.seconds.total,
            if report.cached { " (cached)" } else { "" },
            of_ranks.map_or_else(String::new, |of| by_ranks(&of)),
            certificate.max_relative_residual,
            certificate.max_orthogonality_error,
            match certificate.inertia_counts_match {
                Some(true) => "counts match",
                Some(false) => "counts do not match",
                None => "not counted",
            },
        ))?;
        [&self.output, &self.operator].into_iter().flatten().try_for_each(|path| terminal.wrote(path))
    }
}
