//! The basis of a mesh, with a row for each vertex that was given.

use std::path::PathBuf;
use std::sync::Arc;

use chladni_harmonics::{
    self as harmonics, BasisSettings, Body, BuildReport, InnerSolver, Laplacian, Operator, Ranks,
};
use chladni_mesh::{Frame, TriMesh};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::arrays::{self, give, give_matrix, give_rows};
use crate::failure::{Failure, InputError};
use crate::work;

/// How far eigenpairs can be trusted.
#[pyclass(frozen, eq, module = "chladni")]
#[derive(Clone, PartialEq)]
pub struct Certificate(pub harmonics::Certificate);

#[pymethods]
impl Certificate {
    /// True where counts of the eigenvalues show that no pair is missing or doubled, False where they show that one is, and
    /// None where no count does.
    #[getter]
    fn inertia_counts_match(&self) -> Option<bool> {
        self.0.inertia_counts_match
    }

    #[getter]
    fn max_relative_residual(&self) -> f64 {
        self.0.max_relative_residual
    }

    #[getter]
    fn max_orthogonality_error(&self) -> f64 {
        self.0.max_orthogonality_error
    }

    #[getter]
    fn is_precise(&self) -> bool {
        self.0.is_precise()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, CertificateParts)> {
        Ok((py.import("chladni.shapes")?.getattr("_certificate")?, self.parts()))
    }

    /// Python takes the hash away from what has an equality of its own.
    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.parts().into_pyobject(py)?.hash()
    }

    fn __repr__(&self) -> String {
        let counts = match self.0.inertia_counts_match {
            Some(true) => "True",
            Some(false) => "False",
            None => "None",
        };
        format!(
            "Certificate(inertia_counts_match={counts}, max_relative_residual={:.1e}, \
             max_orthogonality_error={:.1e})",
            self.0.max_relative_residual, self.0.max_orthogonality_error
        )
    }
}

impl Certificate {
    fn parts(&self) -> CertificateParts {
        let is_delaunay = self.0.laplacian == Laplacian::Delaunay;
        let (residual, orthogonality) = (self.0.max_relative_residual, self.0.max_orthogonality_error);
        (is_delaunay, self.0.inertia_counts_match, residual, orthogonality)
    }
}

/// Whether the Laplacian is the intrinsic Delaunay one, whether counts match, and the two errors.
type CertificateParts = (bool, Option<bool>, f64, f64);

/// A certificate from what `__reduce__` made of it.
#[pyfunction]
pub fn restored_certificate(parts: CertificateParts) -> Certificate {
    Certificate(harmonics::Certificate {
        laplacian: if parts.0 { Laplacian::Delaunay } else { Laplacian::Cotangent },
        inertia_counts_match: parts.1,
        max_relative_residual: parts.2,
        max_orthogonality_error: parts.3,
    })
}

/// Warns where a solve is not quite as asked for; `level` as in [`arrays::warn`].
pub fn warn_of(
    py: Python<'_>,
    report: &BuildReport,
    certificate: &harmonics::Certificate,
    level: usize,
) -> PyResult<()> {
    let mut warnings: Vec<String> = report.warnings(certificate).iter().map(ToString::to_string).collect();
    if report.fell_back_to_dense {
        warnings.push("could not be certified in slices and was solved as a dense matrix".into());
    }
    arrays::warn(py, &warnings, level)
}

/// See `chladni.Basis`.
#[pyclass(frozen, subclass, module = "chladni")]
pub struct Basis {
    mesh: TriMesh,
    frame: Frame,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    operator_vertex: Vec<Option<u32>>,
    eigenvalues: Py<PyArray1<f64>>,
    eigenvectors: Py<PyArray2<f64>>,
    mass: Py<PyArray1<f64>>,
    certificate: harmonics::Certificate,
    /// Whether its borders are.
    held: bool,
}

#[pymethods]
impl Basis {
    #[new]
    #[expect(
        non_snake_case,
        clippy::too_many_arguments,
        reason = "as the field writes them; each has a name in Python"
    )]
    fn new(
        py: Python<'_>,
        V: &Bound<'_, PyAny>,
        F: &Bound<'_, PyAny>,
        k: &Bound<'_, PyAny>,
        whole_clusters: &Bound<'_, PyAny>,
        threads: Option<&Bound<'_, PyAny>>,
        progress: Option<&Bound<'_, PyAny>>,
        engine: &Bound<'_, PyAny>,
        ranks: Option<&Bound<'_, PyAny>>,
        groups: Option<&Bound<'_, PyAny>>,
        iterative: &Bound<'_, PyAny>,
        hosts: Option<&Bound<'_, PyAny>>,
        scratch: Option<&Bound<'_, PyAny>>,
        boundary: &Bound<'_, PyAny>,
        solved: Option<SolvedArrays>,
        may_cut: bool,
    ) -> PyResult<Self> {
        let mesh = arrays::mesh(V, F, ["V", "F"])?;
        if let Some(solved) = solved {
            return Self::restored(mesh, solved);
        }
        let whole_clusters = arrays::flag(whole_clusters, "whole_clusters")?;
        let hosts = hosts.map(|hosts| arrays::path(hosts, "hosts")).transpose()?;
        let scratch = scratch.map(|scratch| arrays::path(scratch, "scratch")).transpose()?;
        let (engine, iterative) = (arrays::word(engine, "engine")?, arrays::flag(iterative, "iterative")?);
        let ranks = ranks_of(&engine, ranks, groups, iterative, hosts, scratch)?;
        let held = is_held(&arrays::word(boundary, "boundary")?, ranks.is_some())?;
        let harmonics = arrays::count(k, "k", 1)?;
        if harmonics > mesh.positions.len() {
            let n = mesh.positions.len();
            return Err(InputError::new_err(format!(
                "k is {harmonics}, but {n} vertices have only {n} harmonics"
            )));
        }
        let threads = threads.map(|threads| arrays::count(threads, "threads", 1)).transpose()?;
        if threads.is_some() && ranks.is_some() {
            return Err(InputError::new_err("threads belongs to engine=\"chladni\"; SLEPc has ranks"));
        }
        let settings = BasisSettings { threads, whole_clusters, ..BasisSettings::new(harmonics) };
        let (body, report) = work::run(py, progress, |task| {
            Ok(match &ranks {
                None if held => Body::with_held_border(&mesh, &settings, task)?,
                None => Body::load_or_build(&mesh, &settings, None, task)?,
                Some(ranks) => {
                    let operator = Operator::of(&mesh)?;
                    let (body, report, _) = Body::solve_on_ranks(&mesh, &operator, &settings, ranks, task)?;
                    (body, report)
                }
            })
        })?;
        // Only `chladni.shapes._basis` may cut a group, and the user's line is one call above it.
        let level = if may_cut { 3 } else { 2 };
        warn_of(py, &report, &body.basis.certificate, level)?;
        if report.cuts_cluster && !whole_clusters && !may_cut {
            let last = body.basis.harmonics().saturating_sub(1);
            let warning = format!(
                "harmonic {last} belongs to a group of equal eigenvalues that goes on; \
                 Basis(…, whole_clusters=True) takes all of it"
            );
            arrays::warn(py, &[warning], level)?;
        }
        let (frame, positions, triangles) = (body.frame, body.positions.clone(), body.triangles.clone());
        let operator_vertex = body.operator_vertex.clone();
        let rows = into_rows(body);
        let shape = [operator_vertex.len(), rows.eigenvalues.len()];
        Ok(Self {
            mesh,
            frame,
            positions,
            triangles,
            operator_vertex,
            eigenvalues: give(py, rows.eigenvalues).unbind(),
            eigenvectors: give_matrix(py, rows.vectors.into_vec(), shape)?.unbind(),
            mass: give(py, rows.mass).unbind(),
            certificate: rows.certificate,
            held,
        })
    }

    #[getter]
    fn eigenvalues<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.eigenvalues.bind(py).clone()
    }

    #[getter]
    fn eigenvectors<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.eigenvectors.bind(py).clone()
    }

    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.mass.bind(py).clone()
    }

    #[getter]
    fn certificate(&self) -> Certificate {
        Certificate(self.certificate)
    }

    /// V, F, and the solution, from which `chladni.Basis` restores itself.
    #[expect(clippy::type_complexity, reason = "what Python is given")]
    fn parts<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>, SolvedArrays)> {
        let corners: Vec<[i64; 3]> = self.mesh.triangles.iter().map(|t| t.map(i64::from)).collect();
        let arrays = (
            self.eigenvalues.clone_ref(py),
            self.eigenvectors.clone_ref(py),
            self.mass.clone_ref(py),
            Py::new(py, Certificate(self.certificate))?,
            self.held,
        );
        Ok((give_rows(py, self.mesh.positions.clone())?, give_rows(py, corners)?, arrays))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let k = self.eigenvalues.bind(py).readonly().as_slice()?.len();
        Ok(format!("Basis({} vertices, {k} harmonics)", self.operator_vertex.len()))
    }
}

/// Eigenvalues, eigenvectors, mass, their certificate, and whether the borders are held.
type SolvedArrays = (Py<PyArray1<f64>>, Py<PyArray2<f64>>, Py<PyArray1<f64>>, Py<Certificate>, bool);

impl Basis {
    /// The basis of `mesh` from an earlier solution.
    fn restored(mesh: TriMesh, solved: SolvedArrays) -> PyResult<Self> {
        let Body { frame, positions, triangles, operator_vertex, .. } =
            Body::unsolved(&mesh).map_err(Failure::from)?;
        let (eigenvalues, eigenvectors, mass, certificate, held) = solved;
        let certificate = certificate.get().0;
        Ok(Self {
            mesh,
            frame,
            positions,
            triangles,
            operator_vertex,
            eigenvalues,
            eigenvectors,
            mass,
            certificate,
            held,
        })
    }

    /// The mesh that it is of.
    pub fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// The body as the engines take it, from the arrays as they are now.
    pub fn body(&self, py: Python<'_>) -> PyResult<Body> {
        if self.held {
            let reason = "the borders of this basis are held: shapes are deformed with boundary='neumann'";
            return Err(InputError::new_err(reason));
        }
        let scale = self.frame.scale;
        // A vertex of the file for each operator vertex, and how many share it.
        let mut row = vec![0; self.positions.len()];
        let mut sharing = vec![0.0; self.positions.len()];
        for (file, v) in self.operator_vertex.iter().enumerate() {
            if let Some(v) = v {
                row[*v as usize] = file;
                sharing[*v as usize] += 1.0;
            }
        }
        let values = self.eigenvalues.bind(py).readonly();
        let vectors = self.eigenvectors.bind(py).readonly();
        let mass = self.mass.bind(py).readonly();
        let (vectors, mass) = (vectors.as_array(), mass.as_slice()?);
        let fits = vectors.shape() == [self.operator_vertex.len(), values.as_slice()?.len()]
            && mass.len() == self.operator_vertex.len();
        if !fits {
            return Err(Failure::Input("the arrays of the basis have changed their shape".into()).into());
        }
        let columns = vectors.columns().into_iter();
        let basis = harmonics::Basis {
            eigenvalues: values.as_slice()?.iter().map(|l| l / (scale * scale)).collect(),
            vectors: columns.flat_map(|h| row.iter().map(move |v| h[*v] / scale)).collect(),
            mass: row.iter().zip(&sharing).map(|(v, n)| mass[*v] * n * scale * scale).collect(),
            certificate: self.certificate,
        };
        Ok(Body {
            frame: self.frame,
            positions: self.positions.clone(),
            triangles: self.triangles.clone(),
            operator_vertex: self.operator_vertex.clone(),
            basis: Arc::new(basis),
        })
    }
}

/// Whether borders are held instead of free.
fn is_held(boundary: &str, on_ranks: bool) -> PyResult<bool> {
    match boundary {
        "neumann" => Ok(false),
        "dirichlet" if on_ranks => {
            Err(InputError::new_err("boundary='dirichlet' is solved with engine='chladni' only"))
        }
        "dirichlet" => Ok(true),
        _ => Err(InputError::new_err(format!(
            "boundary is {boundary:?}, where 'neumann' or 'dirichlet' is needed"
        ))),
    }
}

/// The ranks that SLEPc is to solve on, where it is asked for.
fn ranks_of(
    engine: &str,
    ranks: Option<&Bound<'_, PyAny>>,
    groups: Option<&Bound<'_, PyAny>>,
    iterative: bool,
    hosts: Option<PathBuf>,
    scratch: Option<PathBuf>,
) -> PyResult<Option<Ranks>> {
    let given = ranks.is_some() || groups.is_some() || iterative || hosts.is_some() || scratch.is_some();
    match engine {
        "chladni" if !given => Ok(None),
        "chladni" => {
            Err(InputError::new_err("ranks, groups, iterative, hosts and scratch belong to engine=\"slepc\""))
        }
        "slepc" => {
            let number = |given: Option<&Bound<'_, PyAny>>, name: &str, usual: usize| {
                given.map_or(Ok(usual), |given| arrays::count(given, name, 1))
            };
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            if iterative && groups.is_some() {
                return Err(InputError::new_err("groups are of factors, which iterative=True does without"));
            }
            let inner = if iterative {
                InnerSolver::Iterated
            } else {
                InnerSolver::Factors { groups: number(groups, "groups", 1)? }
            };
            let ranks = Ranks { count: number(ranks, "ranks", cores)?, inner, hosts, scratch };
            ranks.check().map_err(Failure::from)?;
            Ok(Some(ranks))
        }
        _ => Err(InputError::new_err(format!("engine is {engine:?}, where 'chladni' or 'slepc' is needed"))),
    }
}

/// The basis of a body in the file's units, with a row for each of the file's vertices. Those that were welded have the
/// same row and share their area; those that no triangle uses have zeros.
pub fn rows_of(body: &Body) -> harmonics::Basis {
    if has_own_rows(body) { body.basis_in_file() } else { spread(body) }
}

/// The same without a copy where the file has a vertex for each of the body's.
fn into_rows(body: Body) -> harmonics::Basis {
    if has_own_rows(&body) { body.into_basis_in_file() } else { spread(&body) }
}

fn has_own_rows(body: &Body) -> bool {
    body.operator_vertex.len() == body.basis.vertices()
        && body.operator_vertex.iter().enumerate().all(|(i, v)| *v == Some(i as u32))
}

fn spread(body: &Body) -> harmonics::Basis {
    let own = body.basis_in_file();
    let n = own.vertices();
    let mut sharing = vec![0.0; n];
    body.operator_vertex.iter().flatten().for_each(|v| sharing[*v as usize] += 1.0);
    let row = |values: &[f64]| -> Vec<f64> {
        body.operator_vertex.iter().map(|v| v.map_or(0.0, |v| values[v as usize])).collect()
    };
    let shared: Vec<f64> = own.mass.iter().zip(&sharing).map(|(a, n)| a / n).collect();
    harmonics::Basis {
        vectors: own.vectors.chunks_exact(n.max(1)).flat_map(row).collect(),
        mass: row(&shared),
        eigenvalues: own.eigenvalues,
        certificate: own.certificate,
    }
}
