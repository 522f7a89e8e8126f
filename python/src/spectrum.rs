//! Operators and eigenpairs of matrices.

use chladni_harmonics::{BasisSettings, ConsistentPencil, Eigenpairs, Pencil, SymmetricSparse};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{self, give, give_matrix};
use crate::basis::{Certificate, warn_of};
use crate::failure::Failure;
use crate::work;

type Column<'py, T> = Bound<'py, PyArray1<T>>;
/// S in compressed columns (starts, rows, values) and the diagonal of M.
type Laplacian<'py> = (Column<'py, i64>, Column<'py, i64>, Column<'py, f64>, Column<'py, f64>);

/// See `chladni.mesh_laplacian`.
#[pyfunction]
pub fn mesh_laplacian<'py>(
    py: Python<'py>,
    verts: &Bound<'py, PyAny>,
    faces: &Bound<'py, PyAny>,
    mollify_factor: &Bound<'py, PyAny>,
) -> PyResult<Laplacian<'py>> {
    let mesh = arrays::mesh(verts, faces, ["verts", "faces"])?;
    let mollify = arrays::number(mollify_factor, "mollify_factor")?;
    let laplacian = work::run(py, None, |_| Ok(chladni_harmonics::mesh_laplacian(&mesh, mollify)?))?;
    Ok(given(py, laplacian))
}

/// See `chladni.point_cloud_laplacian`.
#[pyfunction]
pub fn point_cloud_laplacian<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    mollify_factor: &Bound<'py, PyAny>,
    n_neighbors: &Bound<'py, PyAny>,
) -> PyResult<Laplacian<'py>> {
    let points = arrays::points(points, "points")?;
    let mollify = arrays::number(mollify_factor, "mollify_factor")?;
    let neighbors = arrays::count(n_neighbors, "n_neighbors", 2)?;
    let laplacian = work::run(py, None, move |_| {
        Ok(chladni_harmonics::point_cloud_laplacian(&points, neighbors, mollify)?)
    })?;
    Ok(given(py, laplacian))
}

fn given(py: Python<'_>, (stiffness, mass): (SymmetricSparse, Vec<f64>)) -> Laplacian<'_> {
    let SymmetricSparse { column_starts, rows, values } = stiffness;
    let starts = column_starts.into_iter().map(|start| start as i64).collect();
    let rows = rows.into_iter().map(i64::from).collect();
    (give(py, starts), give(py, rows), give(py, values), give(py, mass))
}

/// A matrix in compressed columns, as `chladni.eigsh` makes them: (n, starts, rows, values).
fn matrix(parts: &Bound<'_, PyAny>, name: &str) -> PyResult<(Vec<usize>, Vec<usize>, Vec<f64>)> {
    let part = |i: usize| parts.get_item(i);
    let n = arrays::count(&part(0)?, name, 0)?;
    let starts = arrays::index_list(&part(1)?, name, usize::MAX, "entries")?;
    let rows = arrays::index_list(&part(2)?, name, n, "rows")?;
    Ok((starts, rows, arrays::vector(&part(3)?, name)?))
}

/// λ, H (n × k, F order) and their certificate.
type Pairs<'py> = (Column<'py, f64>, Bound<'py, PyArray2<f64>>, Certificate);

/// See `chladni.eigsh`; S and M as (n, starts, rows, values), M or None for the identity.
#[pyfunction]
pub fn eigsh<'py>(
    py: Python<'py>,
    stiffness: &Bound<'py, PyAny>,
    mass: Option<&Bound<'py, PyAny>>,
    k: &Bound<'py, PyAny>,
    threads: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Pairs<'py>> {
    let s = matrix(stiffness, "A")?;
    let m = mass.map(|mass| matrix(mass, "M")).transpose()?;
    let harmonics = arrays::count(k, "k", 1)?;
    let threads = threads.map(|threads| arrays::count(threads, "threads", 1)).transpose()?;
    let settings = BasisSettings { threads, ..BasisSettings::new(harmonics) };
    let n = s.0.len().saturating_sub(1);
    if harmonics > n {
        let reason = format!("k is {harmonics}, but a matrix of {n} rows has only {n} eigenvalues");
        return Err(Failure::Input(reason).into());
    }
    let (pairs, report) = work::run(py, progress, move |task| {
        let stiffness = SymmetricSparse::from_columns("A", &s.0, &s.1, &s.2)?;
        let mass = m.map(|m| SymmetricSparse::from_columns("M", &m.0, &m.1, &m.2)).transpose()?;
        let lumped = match &mass {
            None => Some(vec![1.0; n]),
            Some(mass) if mass.rows.len() == mass.size() => Some(mass.diagonal()),
            Some(_) => None,
        };
        Ok(match (lumped, mass) {
            (None, Some(mass)) => ConsistentPencil::new(&stiffness, &mass)?.solve(&settings, task)?,
            (lumped, _) => {
                let (basis, report) =
                    Pencil::new(&stiffness, &lumped.unwrap_or_default())?.solve(&settings, task)?;
                let (eigenvalues, vectors) = (basis.eigenvalues, basis.vectors.into_vec());
                (Eigenpairs { eigenvalues, vectors, certificate: basis.certificate }, report)
            }
        })
    })?;
    warn_of(py, &report, &pairs.certificate, 2)?;
    let shape = [n, pairs.eigenvalues.len()];
    let vectors = give_matrix(py, pairs.vectors, shape)?;
    Ok((give(py, pairs.eigenvalues), vectors, Certificate(pairs.certificate)))
}
