//! Reports of the worker to the page, and the shapes that it reads.

use chladni_mesh::{ShapeSource, TriMesh};
use chladni_program::work::{Error, Warning, Watcher, source};
use std::cell::RefCell;

use chladni_task::{Progress, Task};
use js_sys::Function;
use wasm_bindgen::prelude::*;

/// The shape called `name`, which is `sample:NAME` or a file whose content is `bytes`.
pub fn shape(name: &str, bytes: Option<&[u8]>, watcher: &impl Watcher) -> Result<TriMesh, Error> {
    match bytes {
        Some(bytes) => source::shape_in(name, bytes, watcher),
        None => source::shape(&ShapeSource::named(name), watcher),
    }
}

/// Reports the work to the page, as `report("step", "solving …")`, warnings as `report("warning", …)`, and how far
/// a step is as `report("progress", "solving, 40 %")`.
pub struct Reporter<'a> {
    task: Task,
    report: &'a Function,
}

/// The last report to the page. A worker does one thing at a time.
#[derive(Default)]
struct Told {
    report: Option<Function>,
    line: String,
}

thread_local! {
    static TOLD: RefCell<Told> = RefCell::default();
}

impl<'a> Reporter<'a> {
    pub fn new(report: &'a Function) -> Self {
        let task = Task::new();
        TOLD.with_borrow_mut(|told| *told = Told { report: Some(report.clone()), ..Told::default() });
        task.heard_by(progress);
        Self { task, report }
    }

    fn tell(&self, kind: &str, text: &str) {
        tell(self.report, kind, text);
    }
}

fn tell(report: &Function, kind: &str, text: &str) {
    // Nobody need listen.
    let _ = report.call2(&JsValue::NULL, &kind.into(), &text.into());
}

/// Tells the page how far a stage is, once for each percent.
fn progress(now: &Progress) {
    let Some(share) = now.fraction() else { return };
    TOLD.with_borrow_mut(|told| {
        let line = format!("{}, {:.0} %", now.stage, 100.0 * share);
        if line != told.line
            && let Some(report) = &told.report
        {
            tell(report, "progress", &line);
            told.line = line;
        }
    });
}

impl Watcher for Reporter<'_> {
    fn task(&self) -> &Task {
        &self.task
    }

    fn warn(&self, warning: Warning) {
        let text = match warning {
            // The page has no options.
            Warning::InDoubt { name, stands } => {
                let way_out = "set it with Up, among the parts of the look";
                format!("{name}: shown with {stands}, which is in doubt; {way_out}.")
            }
            warning => warning.to_string(),
        };
        self.tell("warning", &text);
    }

    fn watch<T>(&self, label: &str, part: impl FnOnce(&Task) -> T) -> T {
        // The page forgets how far the step before was.
        TOLD.with_borrow_mut(|told| told.line.clear());
        self.tell("step", label);
        part(&self.task)
    }
}
