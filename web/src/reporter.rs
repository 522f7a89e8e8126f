//! What the worker tells the page while it works, and the shapes that it is given.

use chladni_mesh::{ShapeSource, TriMesh};
use chladni_program::work::{Error, Warning, Watcher, source};
use chladni_task::Task;
use js_sys::Function;
use wasm_bindgen::prelude::*;

/// The shape called `name`, which is `sample:NAME` or a file whose content is `bytes`.
pub fn shape(name: &str, bytes: Option<&[u8]>, watcher: &impl Watcher) -> Result<TriMesh, Error> {
    match bytes {
        Some(bytes) => source::shape_in(name, bytes, watcher),
        None => source::shape(&ShapeSource::named(name), watcher),
    }
}

/// Reports to the page what is done, as `report("step", "solving …")`, and warnings as `report("warning", …)`.
pub struct Reporter<'a> {
    task: Task,
    report: &'a Function,
}

impl<'a> Reporter<'a> {
    pub fn new(report: &'a Function) -> Self {
        Self { task: Task::new(), report }
    }

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
