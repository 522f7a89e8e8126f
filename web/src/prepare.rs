//! From a shape to a body that can dance: the slow part, for a worker.

use chladni_harmonics::Laplacian;
use chladni_program::work::{OwnLook, Stance, Watcher, body, dancer};
use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::parcel::Parcel;
use crate::reporter::{Reporter, shape};

/// The bytes of a body with a number of harmonics: of the shape called `name`, which is `sample:NAME` or a file whose
/// content is `bytes`. `report` gets two strings, `"step"` or `"warning"` and what it is.
///
/// # Errors
/// Files that cannot be read, or shapes that cannot be solved for.
#[wasm_bindgen]
pub fn prepare(
    name: &str,
    bytes: Option<Vec<u8>>,
    harmonics: usize,
    report: &Function,
) -> Result<Vec<u8>, JsError> {
    let watcher = Reporter::new(report);
    let mesh = shape(name, bytes.as_deref(), &watcher)?;
    let stands = Stance::default().of(name, &mesh, None, None, &watcher)?;
    let (body, _) = body::build(name, &mesh, harmonics, Laplacian::Delaunay, &watcher)?;
    let symmetry = watcher.watch("looking for symmetry", |task| dancer::classes(&body, false, task))?;
    let body = symmetry.rotated(&body);
    let own = OwnLook::of(name, &mesh, &body, &watcher);
    let parcel = Parcel { name: name.to_owned(), body, classes: symmetry.classes, stands, own };
    Ok(parcel.to_bytes()?)
}
