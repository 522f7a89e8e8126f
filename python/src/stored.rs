//! A basis in a folder, of which only a piece is in memory at a time.

use std::io;
use std::path::{Path, PathBuf};

use chladni_harmonics::{HarmonicsError, npz};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::arrays::{self, give, give_matrix};
use crate::failure::{Failure, InputError, MissingFileError};
use crate::work;

/// A basis in a folder that ``chladni basis -o DIR/`` wrote, of which a few MiB are in memory at a time.
///
/// ``StoredBasis(folder)`` reads eigenvalues and areas; harmonics are read whenever a signal is analyzed or
/// synthesized. Rows are the vertices of the mesh's file, in its units. A pickle or a copy holds the folder's path
/// alone.
#[pyclass(frozen, module = "chladni")]
pub struct StoredBasis {
    folder: PathBuf,
    stored: npz::StoredBasis,
    eigenvalues: Py<PyArray1<f64>>,
    mass: Py<PyArray1<f64>>,
}

#[pymethods]
impl StoredBasis {
    #[new]
    fn new(py: Python<'_>, folder: &Bound<'_, PyAny>) -> PyResult<Self> {
        // Pieces are read later, when the program may be at work in another folder.
        let folder = std::path::absolute(arrays::path(folder, "folder")?)
            .map_err(|error| InputError::new_err(format!("folder: {error}")))?;
        let stored = npz::StoredBasis::open(&folder).map_err(|error| match &error {
            HarmonicsError::Stored { path, .. } if is_missing(path) => {
                MissingFileError::new_err(error.to_string())
            }
            _ => Failure::from(error).into(),
        })?;
        let eigenvalues = give(py, stored.eigenvalues().to_vec()).unbind();
        let mut welded = vec![0.0; stored.mass().len()];
        stored.operator_vertex().iter().flatten().for_each(|v| welded[*v as usize] += 1.0);
        let own = |v: &Option<u32>| v.map_or(0.0, |v| stored.mass()[v as usize] / welded[v as usize]);
        let mass = give(py, stored.operator_vertex().iter().map(own).collect()).unbind();
        Ok(Self { folder, stored, eigenvalues, mass })
    }

    #[getter]
    fn eigenvalues<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.eigenvalues.bind(py).clone()
    }

    #[getter]
    fn mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.mass.bind(py).clone()
    }

    /// ``eigenvectors.T @ (mass * signal)``: k coefficients of a signal (n,), or (k, c) of c signals (n, c).
    #[pyo3(signature = (signal, *, progress=None))]
    fn analyze<'py>(
        &self,
        py: Python<'py>,
        signal: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let columns = Columns::of(signal, "signal")?;
        let result = work::run(py, progress, |task| Ok(self.stored.analyze(&columns.slices(), task)?))?;
        columns.given(py, result, self.stored.eigenvalues().len())
    }

    /// ``eigenvectors @ coefficients``: a signal (n,) of up to k coefficients, or c signals (n, c) of as many columns.
    /// Harmonics whose coefficients are 0 are not read.
    #[pyo3(signature = (coefficients, *, progress=None))]
    fn synthesize<'py>(
        &self,
        py: Python<'py>,
        coefficients: &Bound<'py, PyAny>,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let columns = Columns::of(coefficients, "coefficients")?;
        let result = work::run(py, progress, |task| Ok(self.stored.synthesize(&columns.slices(), task)?))?;
        columns.given(py, result, self.stored.operator_vertex().len())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyType>, (PathBuf,)) {
        (slf.get_type(), (slf.get().folder.clone(),))
    }

    fn __repr__(&self) -> String {
        let (vertices, k) = (self.stored.operator_vertex().len(), self.stored.eigenvalues().len());
        format!("StoredBasis({vertices} vertices, {k} harmonics)")
    }
}

/// Whether no file has this name; one in a folder that may not be entered may be there.
fn is_missing(path: &Path) -> bool {
    match path.try_exists() {
        Ok(there) => !there,
        Err(error) => error.kind() == io::ErrorKind::NotADirectory,
    }
}

/// One signal, or several as the columns of a matrix.
struct Columns {
    values: Vec<f64>,
    shape: [usize; 2],
    is_vector: bool,
}

impl Columns {
    fn of(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        let (values, shape, is_vector) = arrays::vector_or_matrix(object, name)?;
        Ok(Self { values, shape, is_vector })
    }

    fn slices(&self) -> Vec<&[f64]> {
        let [rows, columns] = self.shape;
        (0..columns).map(|c| &self.values[c * rows..(c + 1) * rows]).collect()
    }

    /// `columns` of `rows` values each, in as many dimensions as these have.
    fn given<'py>(
        &self,
        py: Python<'py>,
        columns: Vec<Vec<f64>>,
        rows: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let (values, shape) = (columns.concat(), [rows, columns.len()]);
        Ok(if self.is_vector {
            give(py, values).into_any()
        } else {
            give_matrix(py, values, shape)?.into_any()
        })
    }
}
