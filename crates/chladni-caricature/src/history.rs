//! Undo and redo of every action.

use crate::{Action, CaricatureError, LayerId, Project, Surface};

/// A project with its past and its future.
///
/// Each step keeps the whole project before it; layers are shared between steps, so a step costs only what it
/// changed. This works for every action.
#[derive(Clone, Debug)]
pub struct History {
    project: Project,
    past: Vec<Step>,
    future: Vec<Step>,
    gesture: Option<(&'static str, Option<LayerId>)>,
    /// The saved state; `None` if it was never saved.
    saved: Option<Project>,
}

#[derive(Clone, Debug)]
struct Step {
    label: &'static str,
    /// The project on the other side of the step.
    project: Project,
}

/// Steps that are kept; a painted region of 50,000 vertices costs 200 kB a step.
const MAX_STEPS: usize = 500;

impl History {
    /// A project just opened or made: nothing to undo, nothing to save.
    pub fn new(project: Project) -> Self {
        Self { saved: Some(project.clone()), project, past: Vec::new(), future: Vec::new(), gesture: None }
    }

    /// A project that differs from any file, such as a recovered one: it counts as modified.
    pub fn recovered(project: Project) -> Self {
        Self { saved: None, ..Self::new(project) }
    }

    /// The project as it is now.
    pub fn project(&self) -> &Project {
        &self.project
    }

    /// Does `action` as a step of its own. One that changes nothing is none, and what was undone can still be redone.
    ///
    /// # Errors
    /// As [`Project::apply`].
    pub fn apply(&mut self, action: &Action, surface: Option<&Surface>) -> Result<(), CaricatureError> {
        self.gesture = None;
        self.step(action, surface, true).map(drop)
    }

    /// Does `actions`, one after the other, as one step, which is called like the last; all of them or none.
    ///
    /// # Errors
    /// As [`Project::apply`].
    pub fn apply_together(
        &mut self,
        actions: &[Action],
        surface: Option<&Surface>,
    ) -> Result<(), CaricatureError> {
        let Some(last) = actions.last() else { return Ok(()) };
        let mut after = self.project.clone();
        actions.iter().try_for_each(|action| after.apply(action, surface))?;
        self.gesture = None;
        if self.project == after {
            return Ok(());
        }
        let before = std::mem::replace(&mut self.project, after);
        self.future.clear();
        self.remember(last.label(), before);
        Ok(())
    }

    /// Does `action` as part of a drag or a brush stroke: actions of one kind on one layer become
    /// one step until [`finish`](Self::finish).
    ///
    /// # Errors
    /// As [`Project::apply`].
    pub fn apply_live(&mut self, action: &Action, surface: Option<&Surface>) -> Result<(), CaricatureError> {
        let kind = (action.label(), action.layer());
        if self.step(action, surface, self.gesture != Some(kind))? {
            self.gesture = Some(kind);
        }
        Ok(())
    }

    /// Ends a drag or a brush stroke: the pointer was released.
    pub fn finish(&mut self) {
        self.gesture = None;
    }

    /// Does `action`; whether that changed anything.
    fn step(
        &mut self,
        action: &Action,
        surface: Option<&Surface>,
        new_step: bool,
    ) -> Result<bool, CaricatureError> {
        let before = self.project.clone();
        self.project.apply(action, surface)?;
        if self.project == before {
            return Ok(false);
        }
        self.future.clear();
        if new_step {
            self.remember(action.label(), before);
        }
        Ok(true)
    }

    fn remember(&mut self, label: &'static str, before: Project) {
        if self.past.len() == MAX_STEPS {
            self.past.remove(0);
        }
        self.past.push(Step { label, project: before });
    }

    /// Takes the last step back; returns its label, `None` where there is none.
    pub fn undo(&mut self) -> Option<&'static str> {
        self.gesture = None;
        let step = self.past.pop()?;
        let after = std::mem::replace(&mut self.project, step.project);
        self.future.push(Step { label: step.label, project: after });
        Some(step.label)
    }

    /// Does the step again that was last undone; returns its label.
    pub fn redo(&mut self) -> Option<&'static str> {
        self.gesture = None;
        let step = self.future.pop()?;
        let before = std::mem::replace(&mut self.project, step.project);
        self.past.push(Step { label: step.label, project: before });
        Some(step.label)
    }

    /// Takes one step forth or back where that leads to a project that is wanted; whether there was such a step.
    pub fn step_to(&mut self, is_wanted: impl Fn(&Project) -> bool) -> bool {
        let leads_there = |steps: &[Step]| steps.last().is_some_and(|step| is_wanted(&step.project));
        if leads_there(&self.future) {
            self.redo().is_some()
        } else {
            leads_there(&self.past) && self.undo().is_some()
        }
    }

    /// The number of steps that can be undone.
    pub fn steps(&self) -> usize {
        self.past.len()
    }

    /// Label of the step that undo would take back.
    pub fn undo_label(&self) -> Option<&'static str> {
        self.past.last().map(|s| s.label)
    }

    /// Label of the step that redo would repeat.
    pub fn redo_label(&self) -> Option<&'static str> {
        self.future.last().map(|s| s.label)
    }

    /// Marks the present state as saved.
    pub fn mark_saved(&mut self) {
        self.saved = Some(self.project.clone());
    }

    /// Whether there is something to save: undoing back to the saved state counts as saved.
    pub fn is_modified(&self) -> bool {
        self.saved.as_ref() != Some(&self.project)
    }
}
