//! Functional maps and point maps.

use chladni_harmonics::{Eigenvectors, FunctionalMap};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arrays::{self, give, give_matrix};
use crate::failure::InputError;
use crate::work;

/// Values of K eigenvectors on n vertices.
struct Columns {
    values: Vec<f64>,
    vertices: usize,
}

impl Columns {
    fn of(object: &Bound<'_, PyAny>, name: &str) -> PyResult<Self> {
        let (values, [vertices, _]) = arrays::matrix(object, name)?;
        if vertices == 0 {
            return Err(InputError::new_err(format!("{name} has no rows")));
        }
        Ok(Self { values, vertices })
    }

    fn view(&self) -> Eigenvectors<'_> {
        Eigenvectors { vertices: self.vertices, values: &self.values }
    }
}

fn map_of(object: &Bound<'_, PyAny>) -> PyResult<FunctionalMap> {
    let (values, [rows, columns]) = arrays::matrix(object, "FM_12")?;
    Ok(FunctionalMap { rows, columns, values })
}

fn dual_of(object: Option<&Bound<'_, PyAny>>, target: &Columns) -> PyResult<Option<Vec<f64>>> {
    let Some(object) = object else { return Ok(None) };
    let dual = Columns::of(object, "A2.T @ evects2")?;
    if dual.vertices != target.vertices || dual.values.len() != target.values.len() {
        return Err(InputError::new_err("A2 does not have a row for each of the rows of evects2"));
    }
    Ok(Some(dual.values))
}

/// See `chladni.FM_to_p2p`.
#[pyfunction]
pub fn fm_to_p2p<'py>(
    py: Python<'py>,
    map: &Bound<'py, PyAny>,
    source: &Bound<'py, PyAny>,
    target: &Bound<'py, PyAny>,
    adjoint: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let (map, adjoint) = (map_of(map)?, arrays::flag(adjoint, "use_adj")?);
    let (source, target) = (Columns::of(source, "evects1")?, Columns::of(target, "evects2")?);
    let points =
        work::run(py, None, |task| Ok(map.to_point_map(source.view(), target.view(), adjoint, task)?))?;
    Ok(give(py, points.into_iter().map(i64::from).collect()))
}

/// See `chladni.p2p_to_FM`; `dual` is A2ᵀ evects2.
#[pyfunction]
pub fn p2p_to_fm<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    source: &Bound<'py, PyAny>,
    target: &Bound<'py, PyAny>,
    dual: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (source, target) = (Columns::of(source, "evects1")?, Columns::of(target, "evects2")?);
    let dual = dual_of(dual, &target)?;
    let points = arrays::index_list(points, "p2p_21", source.vertices, "rows of evects1")?;
    let points: Vec<u32> = points.into_iter().map(|v| v as u32).collect();
    let map = work::run(py, None, |_| {
        Ok(FunctionalMap::of_point_map(&points, source.view(), target.view(), dual.as_deref())?)
    })?;
    give_matrix(py, map.values, [map.rows, map.columns])
}

/// See `chladni.zoomout_refine`; `dual` is A2ᵀ evects2, `step` (of the source, of the target).
#[pyfunction]
pub fn zoomout<'py>(
    py: Python<'py>,
    map: &Bound<'py, PyAny>,
    source: &Bound<'py, PyAny>,
    target: &Bound<'py, PyAny>,
    dual: Option<&Bound<'py, PyAny>>,
    rounds: &Bound<'py, PyAny>,
    step: (Bound<'py, PyAny>, Bound<'py, PyAny>),
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let map = map_of(map)?;
    let (source, target) = (Columns::of(source, "evects1")?, Columns::of(target, "evects2")?);
    let dual = dual_of(dual, &target)?;
    let rounds = arrays::count(rounds, "nit", 0)?;
    let step = [arrays::count(&step.1, "step", 0)?, arrays::count(&step.0, "step", 0)?];
    let map = work::run(py, progress, |task| {
        Ok(map.zoomed_out(source.view(), target.view(), dual.as_deref(), rounds, step, task)?)
    })?;
    give_matrix(py, map.values, [map.rows, map.columns])
}
