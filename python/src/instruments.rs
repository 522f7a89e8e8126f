//! Caricatures, symmetry classes, and files.

use std::path::PathBuf;
use std::sync::Arc;

use chladni_caricature::{
    DEFAULT_HARMONICS, Layer, LayerState, Model, Project, ShapeSource, Stack, Template,
};
use chladni_mesh::{Loaded, TriMesh, save_mesh};
use chladni_music::{Class, Symmetry, SymmetryMethod};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{self, give, give_matrix, give_rows};
use crate::basis::{Basis, rows_of};
use crate::failure::{Failure, InputError};
use crate::{matching, work};

/// A template from Python's words: a name, a number of harmonics, or a mesh (V, F).
fn template(object: &Bound<'_, PyAny>) -> PyResult<(Template, Option<TriMesh>)> {
    if let Ok(name) = object.extract::<String>() {
        return match name.as_str() {
            "ellipsoid" => Ok((Template::Ellipsoid, None)),
            "sphere" => Ok((Template::Sphere, None)),
            other => Err(InputError::new_err(format!(
                "template is {other:?}: it can be 'ellipsoid', 'sphere', an int (of harmonics that its own smooth \
                 shape has), or a mesh (V, F)"
            ))),
        };
    }
    if let Ok((vertices, faces)) = object.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>() {
        let mesh = arrays::mesh(&vertices, &faces, ["the template's V", "the template's F"])?;
        // Only a label: the mesh itself is handed over.
        return Ok((Template::File(PathBuf::from("template")), Some(mesh)));
    }
    Ok((Template::LowPass(arrays::count(object, "template", 1)?), None))
}

/// See `chladni.caricature`.
#[pyfunction]
pub fn caricature<'py>(
    py: Python<'py>,
    basis: &Bound<'py, Basis>,
    against: &Bound<'py, PyAny>,
    mu: &Bound<'py, PyAny>,
    model: &Bound<'py, PyAny>,
    landmarks: Option<&Bound<'py, PyAny>>,
    method: &Bound<'py, PyAny>,
    seed: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (mesh, body) = (basis.get().mesh(), Arc::new(basis.get().body(py)?));
    let (template, template_mesh) = template(against)?;
    let model = match arrays::word(model, "model")?.as_str() {
        "coordinate" => Model::Coordinate,
        "normal" => Model::Normal,
        "distance" => Model::Distance,
        other => {
            return Err(InputError::new_err(format!(
                "model is {other:?}: it can be 'coordinate', 'normal' or 'distance'"
            )));
        }
    };
    let sizes = [mesh.positions.len(), template_mesh.as_ref().map_or(0, |mesh| mesh.positions.len())];
    let mut project = Project::new(ShapeSource::File("shape".into()), DEFAULT_HARMONICS);
    let mu = arrays::number(mu, "mu")?;
    let matching = matching::settings(method, landmarks, sizes, seed, false)?;
    let curve = project.usual_curve(&template, matching.method, mu);
    let layer = Layer { mu, model, matching, curve, ..Layer::new("caricature", template) };
    let moved = work::run(py, progress, |task| {
        project.push(layer)?;
        let mut stack = Stack::new(body.clone())?;
        let mut warnings = Vec::new();
        for request in stack.missing(&project) {
            let matched = request.run(mesh, &body, template_mesh.as_ref(), task)?;
            warnings.extend(matched.report.iter().flat_map(|report| report.warnings.clone()));
            stack.install(request, Ok(matched));
        }
        let evaluation = stack.evaluate(&project);
        for layer in &evaluation.layers {
            let why = match &layer.state {
                LayerState::Acts => continue,
                LayerState::Failed(why) => why.clone(),
                state => format!("{state:?}"),
            };
            return Err(Failure::Input(format!("the caricature cannot be made: {why}")));
        }
        Ok((evaluation.file_positions(&body, &mesh.positions), warnings))
    })?;
    arrays::warn(py, &moved.1, 2)?;
    give_rows(py, moved.0)
}

/// See `chladni.symmetry`.
#[pyfunction]
pub fn symmetry<'py>(
    py: Python<'py>,
    basis: &Bound<'py, Basis>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let body = basis.get().body(py)?;
    let (found, rotated) = work::run(py, progress, |task| {
        let found = Symmetry::of(&body, task)?;
        let rotated = rows_of(&found.rotated(&body));
        Ok((found, rotated))
    })?;
    let out = PyDict::new(py);
    out.set_item("classes", give(py, found.classes.iter().map(|class: &Class| class.sign()).collect()))?;
    out.set_item("scores", give(py, found.scores))?;
    let shape = [body.operator_vertex.len(), rotated.eigenvalues.len()];
    out.set_item("eigenvectors", give_matrix(py, rotated.vectors.into_vec(), shape)?)?;
    let (mut normal, mut offset) = (None, None);
    if let SymmetryMethod::Mirror(plane) = found.method {
        // A point of the plane in the working frame is one of the plane in the file.
        let point = body.frame.to_file(plane.normal.map(|x| x * plane.offset));
        normal = Some(give(py, plane.normal.to_vec()));
        offset = Some((0..3).map(|i| plane.normal[i] * point[i]).sum::<f64>());
    }
    out.set_item("normal", normal)?;
    out.set_item("offset", offset)?;
    Ok(out)
}

/// V and F.
type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>);

/// See `chladni.read_mesh`.
#[pyfunction]
pub fn read_mesh<'py>(py: Python<'py>, path: &Bound<'py, PyAny>) -> PyResult<Arrays<'py>> {
    let path = arrays::path(path, "path")?;
    let source = ShapeSource::named(&path);
    let Loaded { mesh, mended, .. } = work::run(py, None, |_| Ok(source.load(None)?))?;
    let mended: Vec<String> = mended.iter().map(|mended| format!("{}: {mended}", path.display())).collect();
    arrays::warn(py, &mended, 2)?;
    let triangles = mesh.triangles.iter().map(|t| t.map(i64::from)).collect();
    Ok((give_rows(py, mesh.positions)?, give_rows(py, triangles)?))
}

/// See `chladni.write_mesh`.
#[pyfunction]
#[expect(non_snake_case, reason = "as the field writes them")]
pub fn write_mesh(
    py: Python<'_>,
    path: &Bound<'_, PyAny>,
    V: &Bound<'_, PyAny>,
    F: &Bound<'_, PyAny>,
) -> PyResult<()> {
    let path = arrays::path(path, "path")?;
    let mesh = arrays::mesh(V, F, ["V", "F"])?;
    work::run(py, None, |_| Ok(save_mesh(&mesh, &path)?))
}
