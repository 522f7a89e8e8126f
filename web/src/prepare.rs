//! From a shape to a body that can dance: the slow part, for a worker.

use chladni_harmonics::Laplacian;
use chladni_mesh::ShapeSource;
use chladni_program::work::{self, Stance, Warning, Watcher, body, dancer};
use chladni_task::Task;
use js_sys::Function;
use wasm_bindgen::prelude::*;

use crate::parcel::Parcel;

/// Reports to the page what is done, as `report("step", "solving …")`, and warnings as `report("warning", …)`.
struct Reporter<'a> {
    task: Task,
    report: &'a Function,
}

impl Reporter<'_> {
    fn tell(&self, kind: &str, text: &str) {
        // Nobody need listen.
        let _ = self.report.call2(&JsValue::NULL, &kind.into(), &text.into());
    }
}

impl Watcher for Reporter<'_> {
    fn task(&self) -> &Task {
        &self.task
    }

    fn warn(&self, warning: Warning) {
        self.tell("warning", &warning.to_string());
    }

    fn watch<T>(&self, label: &str, part: impl FnOnce(&Task) -> T) -> T {
        self.tell("step", label);
        part(&self.task)
    }
}

/// The bytes of a body of so many harmonics: of the shape called `name`, which is `sample:NAME` or a file whose
/// content is `bytes`. `report` gets two strings, `"step"` or `"warning"` and what it is.
///
/// # Errors
/// What cannot be read, or solved for.
#[wasm_bindgen]
pub fn prepare(
    name: &str,
    bytes: Option<Vec<u8>>,
    harmonics: usize,
    report: &Function,
) -> Result<Vec<u8>, JsError> {
    let watcher = Reporter { task: Task::new(), report };
    let mesh = match bytes {
        Some(bytes) => work::source::shape_in(name, &bytes, &watcher)?,
        None => work::source::shape(&ShapeSource::named(name), &watcher)?,
    };
    let stands = Stance::default().of(name, &mesh, None, None, &watcher)?;
    let (body, _) = body::build(name, &mesh, harmonics, Laplacian::Delaunay, &watcher)?;
    let symmetry = watcher.watch("looking for symmetry", |task| dancer::classes(&body, false, task))?;
    let body = symmetry.rotated(&body);
    let parcel = Parcel { name: name.to_owned(), body, classes: symmetry.classes, stands };
    Ok(parcel.to_bytes()?)
}
