//! Distances along a surface.

use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::{self, give};
use crate::work;

/// See `chladni.MeshHeatMethodDistanceSolver`.
#[pyclass(frozen, module = "chladni")]
pub struct HeatGeodesics(chladni_harmonics::HeatGeodesics);

#[pymethods]
impl HeatGeodesics {
    #[new]
    #[expect(non_snake_case, reason = "as the field writes them")]
    fn new(
        py: Python<'_>,
        V: &Bound<'_, PyAny>,
        F: &Bound<'_, PyAny>,
        t_coef: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let mesh = arrays::mesh(V, F, ["V", "F"])?;
        let time = arrays::number(t_coef, "t_coef")?;
        Ok(Self(work::run(py, None, |_| Ok(chladni_harmonics::HeatGeodesics::of(&mesh, time)?))?))
    }

    fn distances<'py>(
        &self,
        py: Python<'py>,
        sources: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let sources = arrays::index_list(sources, "the source", self.0.vertices(), "vertices")?;
        Ok(give(py, work::run(py, None, |_| Ok(self.0.distances(&sources)?))?))
    }
}
