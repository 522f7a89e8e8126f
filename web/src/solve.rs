//! The slow parts of a caricature, for a worker: harmonics, matches, the parts of a head.

use chladni_caricature::MatchRequest;
use chladni_harmonics::{Basis, Body, Certificate, Laplacian};
use chladni_program::work::{Error, HEADLIKE, body, head_parts, matched_with, template_mesh};
use js_sys::Function;
use serde::{Deserialize, Serialize};
use wasm_bindgen::prelude::*;

use crate::numbers::{Damaged, head, headed, numbers};
use crate::reporter::{Reporter, shape};

/// The text before the numbers.
#[derive(Serialize, Deserialize)]
struct Head {
    vertices: usize,
    eigenvalues: Vec<f64>,
    certificate: Certificate,
}

/// The harmonics of a shape (`sample:NAME`, or a file called `name` whose content is `bytes`) in all their digits, for
/// [`Sitting::take_harmonics`](crate::Sitting::take_harmonics). `laplacian` is that of the project.
///
/// # Errors
/// Files that cannot be read, or shapes that cannot be solved for.
#[wasm_bindgen]
pub fn solve(
    name: &str,
    bytes: Option<Vec<u8>>,
    harmonics: usize,
    laplacian: &str,
    report: &Function,
) -> Result<Vec<u8>, JsError> {
    let watcher = Reporter::new(report);
    let mesh = shape(name, bytes.as_deref(), &watcher)?;
    let laplacian: Laplacian = serde_json::from_value(laplacian.into())?;
    let (body, _) = body::build(name, &mesh, harmonics, laplacian, &watcher)?;
    Ok(to_bytes(&body.basis)?)
}

/// The match of a shape with its template that a layer waits for, as the JSON `request` asks; `template` is the
/// template's content where it is a file. For [`Sitting::install`](crate::Sitting::install).
///
/// # Errors
/// Files that cannot be read, and shapes that do not match.
#[wasm_bindgen]
pub fn match_template(
    name: &str,
    bytes: Option<Vec<u8>>,
    request: &str,
    template: Option<Vec<u8>>,
    report: &Function,
) -> Result<String, JsError> {
    let watcher = Reporter::new(report);
    let request: MatchRequest = serde_json::from_str(request)?;
    let mesh = shape(name, bytes.as_deref(), &watcher)?;
    let template = match template {
        Some(bytes) => Some(shape(&request.template.to_string(), Some(&bytes), &watcher)?),
        None => template_mesh(&request.template, &watcher)?,
    };
    let body = Body::unsolved(&mesh).map_err(|error| Error::from(error).of(name))?;
    let found = matched_with(&request, &mesh, &body, template.as_ref(), &watcher).map_err(Error::from)?;
    Ok(serde_json::to_string(&found)?)
}

/// For each vertex of the shape's file, the part of a head on which it lies, by the part's number among the names;
/// none where the shape is not a head.
///
/// # Errors
/// Files that cannot be read or matched.
#[wasm_bindgen]
pub fn parts_of_head(
    name: &str,
    bytes: Option<Vec<u8>>,
    report: &Function,
) -> Result<Option<Vec<u8>>, JsError> {
    let watcher = Reporter::new(report);
    let mesh = shape(name, bytes.as_deref(), &watcher)?;
    Ok(head_parts(&mesh, HEADLIKE, &watcher)?.map(|(parts, _, _)| parts.part))
}

/// The length of the head in four bytes, the head as JSON, then areas and harmonics, all little-endian.
fn to_bytes(basis: &Basis) -> Result<Vec<u8>, Damaged> {
    let mut bytes = headed(&Head {
        vertices: basis.mass.len(),
        eigenvalues: basis.eigenvalues.clone(),
        certificate: basis.certificate,
    })?;
    bytes.reserve(8 * (basis.mass.len() + basis.vectors.len()));
    bytes.extend(basis.mass.iter().chain(&basis.vectors).flat_map(|x| x.to_le_bytes()));
    Ok(bytes)
}

/// Reads the output of [`to_bytes`].
pub fn from_bytes(bytes: &[u8]) -> Result<Basis, Damaged> {
    let mut rest = bytes;
    let Head { vertices, eigenvalues, certificate } = head(&mut rest)?;
    let mass = numbers(&mut rest, vertices, 1, f64::from_le_bytes)?;
    let vectors = numbers(&mut rest, vertices, eigenvalues.len(), f64::from_le_bytes)?;
    Ok(Basis { eigenvalues, vectors: vectors.into(), mass, certificate })
}
