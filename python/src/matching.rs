//! Which point of one surface belongs to each vertex of another.

use chladni_match::{Landmark, MatchSettings, Method, Scaling, match_shapes};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{self, give, give_rows};
use crate::failure::{Failure, InputError};
use crate::work;

/// How to match, from Python's words.
pub fn settings(
    method: &Bound<'_, PyAny>,
    landmarks: Option<&Bound<'_, PyAny>>,
    sizes: [usize; 2],
    seed: &Bound<'_, PyAny>,
    rigid: bool,
) -> PyResult<MatchSettings> {
    let method = match arrays::word(method, "method")?.as_str() {
        "same" => Method::Same,
        "icp" => Method::Icp,
        "fit" => Method::Fit,
        "map" => Method::Map,
        other => {
            return Err(InputError::new_err(format!(
                "method is {other:?}: it can be 'same', 'icp', 'fit' or 'map'"
            )));
        }
    };
    let landmarks = landmarks.map(|landmarks| pairs(landmarks, sizes)).transpose()?.unwrap_or_default();
    let seed = arrays::count(seed, "seed", 0)? as u64;
    let scaling = if rigid { Scaling::Rigid } else { Scaling::Free };
    Ok(MatchSettings { method, landmarks, seed, scaling })
}

/// (m, 2) vertices, of the first shape and of the second.
fn pairs(landmarks: &Bound<'_, PyAny>, sizes: [usize; 2]) -> PyResult<Vec<Landmark>> {
    // An empty list has one dimension as an array.
    if landmarks.len().is_ok_and(|m| m == 0) {
        return Ok(Vec::new());
    }
    let (values, [_, width]) = arrays::matrix(landmarks, "landmarks")?;
    let n = values.len() / width.max(1);
    if width != 2 {
        return Err(InputError::new_err(format!("landmarks have {width} columns, where 2 are needed")));
    }
    let vertex = |i: usize, side: usize| {
        let value = values[side * n + i];
        let is_vertex = value >= 0.0 && value.fract() == 0.0 && value < sizes[side] as f64;
        let reason = || {
            let shape = side + 1;
            let (landmark, n) = (i + 1, sizes[side]);
            format!("landmark {landmark} names vertex {value} of shape {shape}, which has {n} vertices")
        };
        if is_vertex { Ok(value as u32) } else { Err(InputError::new_err(reason())) }
    };
    (0..n).map(|i| Ok(Landmark { shape: vertex(i, 0)?, template: vertex(i, 1)? })).collect()
}

/// See `chladni.match`.
#[pyfunction]
#[expect(non_snake_case, reason = "as the field writes them")]
pub fn match_meshes<'py>(
    py: Python<'py>,
    V1: &Bound<'py, PyAny>,
    F1: &Bound<'py, PyAny>,
    V2: &Bound<'py, PyAny>,
    F2: &Bound<'py, PyAny>,
    landmarks: Option<&Bound<'py, PyAny>>,
    method: &Bound<'py, PyAny>,
    seed: &Bound<'py, PyAny>,
    rigid: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let shape = arrays::mesh(V1, F1, ["V1", "F1"])?;
    let template = arrays::mesh(V2, F2, ["V2", "F2"])?;
    let sizes = [shape.positions.len(), template.positions.len()];
    let settings = settings(method, landmarks, sizes, seed, arrays::flag(rigid, "rigid")?)?;
    let found = work::run(py, progress, |task| Ok(match_shapes(&shape, &template, &settings, task)?))?;
    let (correspondence, report) = (found.correspondence, found.report);
    let Some(on) = correspondence.on_template else {
        return Err(Failure::Internal("a match with a mesh is not on the mesh".into()).into());
    };
    let nearest = |at: &chladni_mesh::surface::SurfacePoint| {
        let corners = template.triangles[at.triangle as usize];
        let most = (0..3).max_by(|a, b| at.weights[*a].total_cmp(&at.weights[*b])).unwrap_or(0);
        i64::from(corners[most])
    };
    let out = PyDict::new(py);
    out.set_item("p2p", give(py, on.iter().map(nearest).collect()))?;
    out.set_item("triangles", give(py, on.iter().map(|at| i64::from(at.triangle)).collect()))?;
    out.set_item("weights", give_rows(py, on.iter().map(|at| at.weights).collect())?)?;
    out.set_item("points", give_rows(py, correspondence.point)?)?;
    out.set_item("targets", give_rows(py, correspondence.target)?)?;
    out.set_item("confidence", give(py, correspondence.confidence))?;
    out.set_item("transform", give_rows(py, correspondence.similarity.to_matrix().to_vec())?)?;
    out.set_item("coverage", report.coverage)?;
    out.set_item("residual_median", report.residual_median)?;
    out.set_item("residual_p95", report.residual_p95)?;
    out.set_item("flipped_triangles", report.flipped_triangles)?;
    out.set_item("strongly_stretched", report.strongly_stretched)?;
    out.set_item("near_tie", report.near_tie)?;
    arrays::warn(py, &report.warnings, 2)?;
    Ok(out)
}
