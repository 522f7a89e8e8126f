//! The observer of work: a terminal, a window, or a collector of warnings.

use std::cell::RefCell;
use std::path::Path;

use chladni_task::Task;

use super::Warning;

/// Observes work, and may stop it.
pub trait Watcher {
    /// The task that long work reports to; cancelling it stops the work.
    fn task(&self) -> &Task;

    /// Work continues, but not quite as asked.
    fn warn(&self, warning: Warning);

    /// The same of each of `warnings`.
    fn warn_each(&self, warnings: impl IntoIterator<Item = Warning>) {
        warnings.into_iter().for_each(|warning| self.warn(warning));
    }

    /// Whether the user knows already that the document at `document` names `file`, or works where that lies.
    fn knows(&self, _document: &Path, _file: &Path) -> bool {
        false
    }

    /// Does a `part` of the work that may take long and is called `label`.
    fn watch<T>(&self, _label: &str, part: impl FnOnce(&Task) -> T) -> T {
        part(self.task())
    }
}

/// Says of a document and a file whether the user [knows](Watcher::knows) of it.
type Knows<'a> = Box<dyn Fn(&Path, &Path) -> bool + 'a>;

/// Collects the warnings of background work until they can be shown.
pub struct Aside<'a> {
    task: &'a Task,
    warnings: RefCell<Vec<Warning>>,
    knows: Knows<'a>,
}

impl<'a> Aside<'a> {
    /// Work that reports to `task`.
    pub fn new(task: &'a Task) -> Self {
        Self { task, warnings: RefCell::default(), knows: Box::new(|_, _| false) }
    }

    /// The same for a user who [knows](Watcher::knows) what `knows` says of a document and a file.
    pub fn knowing(self, knows: impl Fn(&Path, &Path) -> bool + 'a) -> Self {
        Self { knows: Box::new(knows), ..self }
    }

    /// The collected warnings.
    pub fn warnings(self) -> Vec<Warning> {
        self.warnings.into_inner()
    }
}

impl Watcher for Aside<'_> {
    fn task(&self) -> &Task {
        self.task
    }

    fn warn(&self, warning: Warning) {
        self.warnings.borrow_mut().push(warning);
    }

    fn knows(&self, document: &Path, file: &Path) -> bool {
        (self.knows)(document, file)
    }
}
