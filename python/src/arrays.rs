//! From whatever numpy makes an array of to the engines' vectors, with a message where that is impossible, and back.

use std::fmt::Display;
use std::path::PathBuf;

use chladni_mesh::TriMesh;
use numpy::ndarray::{Array2, ShapeBuilder};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;

use crate::failure::{Failure, InputError};

type Any<'a, 'py> = &'a Bound<'py, PyAny>;

/// Refuses an array some of whose values are masked: those beneath the mask are not meant.
fn refuse_masked(object: Any, name: &str) -> PyResult<()> {
    let masked = object.py().import("numpy")?.getattr("ma")?.call_method1("is_masked", (object,))?;
    if masked.is_truthy()? {
        return Err(InputError::new_err(format!("{name} has masked values")));
    }
    Ok(())
}

/// `object` as a contiguous array of `dtype`, if its own type is one of `kinds` (numpy's letters).
fn as_array<'py>(
    object: Any<'_, 'py>,
    name: &str,
    dtype: &str,
    order: &str,
    kinds: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let numpy = object.py().import("numpy")?;
    let mut array = numpy
        .call_method1("asarray", (object,))
        .map_err(|error| InputError::new_err(format!("{name} is no array: {}", error.value(object.py()))))?;
    let mut own = array.getattr("dtype")?;
    let mut kind: String = own.getattr("kind")?.extract()?;
    // Python's own numbers, such as fractions, are objects.
    if kind == "O" && kinds.contains('f') {
        array = object.py().import("chladni._arguments")?.call_method1("floats", (&array, name))?;
        own = array.getattr("dtype")?;
        kind = own.getattr("kind")?.extract()?;
    }
    // An empty list is an array of floats.
    if !kinds.contains(&kind) && array.getattr("size")?.extract::<usize>()? > 0 {
        let wanted = if kinds.contains('f') { "real numbers" } else { "whole numbers" };
        return Err(InputError::new_err(format!("{name} holds {own}, where {wanted} are needed")));
    }
    let options = [("order", order)].into_py_dict(object.py())?;
    array.call_method("astype", (dtype,), Some(&options))
}

/// Any number of dimensions of f64, in C or F order.
fn floats<'py>(object: Any<'_, 'py>, name: &str, order: &str) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    refuse_masked(object, name)?;
    as_array(object, name, "float64", order, "fiub")?.extract()
}

/// How an argument looks, in at most one short line.
fn shown(object: Any) -> String {
    let Ok(text) = object.repr().map(|text| text.to_string()) else { return "unprintable".into() };
    if text.len() <= 60 && !text.contains('\n') {
        return text;
    }
    let kind = object.get_type().name().map_or_else(|_| "object".into(), |name| name.to_string());
    format!("a long {kind}")
}

/// One of a few words.
pub fn word(object: Any, name: &str) -> PyResult<String> {
    object
        .extract()
        .map_err(|_| InputError::new_err(format!("{name} is {}, where a word is needed", shown(object))))
}

/// True or False.
pub fn flag(object: Any, name: &str) -> PyResult<bool> {
    object.extract().map_err(|_| {
        InputError::new_err(format!("{name} is {}, where True or False is needed", shown(object)))
    })
}

/// A path as a string or an `os.PathLike`.
pub fn path(object: Any, name: &str) -> PyResult<PathBuf> {
    object
        .extract()
        .map_err(|_| InputError::new_err(format!("{name} is {}, where a path is needed", shown(object))))
}

fn shape_error(name: &str, found: &[usize], wanted: &str) -> PyErr {
    let shape = found.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    InputError::new_err(format!("{name} has the shape ({shape}), where {wanted} is needed"))
}

fn check_finite(values: &[f64], name: &str, width: usize) -> PyResult<()> {
    match values.iter().position(|x| !x.is_finite()) {
        Some(at) => {
            let row = at / width.max(1);
            Err(InputError::new_err(format!("{name} has {} in row {row}", values[at])))
        }
        None => Ok(()),
    }
}

/// n finite values.
pub fn vector(object: Any, name: &str) -> PyResult<Vec<f64>> {
    let array = floats(object, name, "C")?;
    if array.ndim() != 1 {
        return Err(shape_error(name, array.shape(), "(n,)"));
    }
    let values = array.as_slice()?.to_vec();
    check_finite(&values, name, 1)?;
    Ok(values)
}

/// n × K finite values, column-major, with their shape.
pub fn matrix(object: Any, name: &str) -> PyResult<(Vec<f64>, [usize; 2])> {
    let array = floats(object, name, "F")?;
    let &[n, k] = array.shape() else { return Err(shape_error(name, array.shape(), "(n, k)")) };
    // Of an array in F order the memory is that of its transpose in C order.
    let values = array.as_array().t().as_slice().map(<[f64]>::to_vec).unwrap_or_default();
    if values.len() != n * k {
        return Err(Failure::Internal(format!("{name} is not contiguous")).into());
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(at) => Err(InputError::new_err(format!("{name} has {} in row {}", values[at], at % n))),
        None => Ok((values, [n, k])),
    }
}

/// n finite values as a matrix of one column, or n × K column-major ones; their shape, and whether it is the former.
pub fn vector_or_matrix(object: Any, name: &str) -> PyResult<(Vec<f64>, [usize; 2], bool)> {
    if floats(object, name, "F")?.ndim() == 1 {
        let values = vector(object, name)?;
        let rows = values.len();
        return Ok((values, [rows, 1], true));
    }
    matrix(object, name).map(|(values, shape)| (values, shape, false))
}

/// n × 3 finite coordinates.
pub fn points(object: Any, name: &str) -> PyResult<Vec<[f64; 3]>> {
    let array = floats(object, name, "C")?;
    if !matches!(array.shape(), [_, 3]) {
        return Err(shape_error(name, array.shape(), "(n, 3)"));
    }
    let values = array.as_slice()?;
    check_finite(values, name, 3)?;
    Ok(values.as_chunks::<3>().0.to_vec())
}

/// Whole numbers ≥ 0 with their shape.
fn indices(object: Any, name: &str, below: usize, of: &str) -> PyResult<(Vec<usize>, Vec<usize>)> {
    refuse_masked(object, name)?;
    // Numbers of 64 bits without a sign may be larger than any with one.
    if let Ok(array) = object.extract::<PyReadonlyArrayDyn<'_, u64>>() {
        let values: Vec<u64> = array.as_array().iter().copied().collect();
        return below_all(&values, array.shape(), name, below, of);
    }
    let array: PyReadonlyArrayDyn<'_, i64> = as_array(object, name, "int64", "C", "iu")?.extract()?;
    below_all(array.as_slice()?, array.shape(), name, below, of)
}

/// `values` as numbers from 0 to below `below`, with their shape.
fn below_all<T: Copy + Display>(
    values: &[T],
    shape: &[usize],
    name: &str,
    below: usize,
    of: &str,
) -> PyResult<(Vec<usize>, Vec<usize>)>
where
    usize: TryFrom<T>,
{
    let number = |value: &T| {
        let number = usize::try_from(*value).ok().filter(|number| *number < below);
        number.ok_or_else(|| {
            InputError::new_err(format!("{name} has {value}, but there are {below} {of}, from 0"))
        })
    };
    Ok((values.iter().map(number).collect::<PyResult<_>>()?, shape.to_vec()))
}

/// n whole numbers ≥ 0 and < `below`, which counts `of`; a single one is a list of one.
pub fn index_list(object: Any, name: &str, below: usize, of: &str) -> PyResult<Vec<usize>> {
    let (values, shape) = indices(object, name, below, of)?;
    if shape.len() > 1 {
        return Err(shape_error(name, &shape, "(n,)"));
    }
    Ok(values)
}

/// Vertices V, (n, 3), and triangles F, (m, 3).
pub fn mesh(vertices: Any, faces: Any, names: [&str; 2]) -> PyResult<TriMesh> {
    let positions = points(vertices, names[0])?;
    let below = positions.len().min(u32::MAX as usize);
    let (corners, shape) = indices(faces, names[1], below, "vertices")?;
    if !matches!(shape[..], [_, 3]) {
        return Err(shape_error(names[1], &shape, "(m, 3)"));
    }
    let triangles = corners.as_chunks::<3>().0.iter().map(|t| t.map(|v| v as u32)).collect();
    Ok(TriMesh { positions, triangles, ..TriMesh::default() })
}

/// A whole number ≥ `least` and < 2⁶³.
pub fn count(object: Any, name: &str, least: usize) -> PyResult<usize> {
    let number = object.extract::<i64>().ok().and_then(|number| usize::try_from(number).ok());
    match number.filter(|number| *number >= least) {
        Some(number) => Ok(number),
        None => {
            let given = shown(object);
            Err(InputError::new_err(format!(
                "{name} is {given}, where a whole number of at least {least} and below 2**63 is needed"
            )))
        }
    }
}

/// A finite number.
pub fn number(object: Any, name: &str) -> PyResult<f64> {
    match object.extract::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => {
            Err(InputError::new_err(format!("{name} is {}, where a finite number is needed", shown(object))))
        }
    }
}

/// A vector that becomes numpy's without a copy.
pub fn give<T: numpy::Element>(py: Python<'_>, values: Vec<T>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, values)
}

/// n × K column-major values as an array in F order, without a copy.
pub fn give_matrix(
    py: Python<'_>,
    values: Vec<f64>,
    [n, k]: [usize; 2],
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let array = Array2::from_shape_vec((n, k).f(), values)
        .map_err(|error| Failure::Internal(format!("a matrix of {n} × {k}: {error}")))?;
    Ok(PyArray2::from_owned_array(py, array))
}

/// n × C values, row by row.
pub fn give_rows<const C: usize, T: numpy::Element + Copy>(
    py: Python<'_>,
    rows: Vec<[T; C]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let n = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([n, C])
}

/// Warns in Python that a result is not quite as it was asked for, at the line of the user's call: `level` 2 where a
/// function of `chladni` that the user calls is the one that calls this, 3 where one more is between them.
pub fn warn(py: Python<'_>, warnings: &[String], level: usize) -> PyResult<()> {
    let category = py.import("chladni._errors")?.getattr("ChladniWarning")?;
    for text in warnings {
        py.import("warnings")?.call_method1("warn", (text, &category, level))?;
    }
    Ok(())
}
