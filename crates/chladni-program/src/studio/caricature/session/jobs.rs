//! Matching and solving in the background.

use std::sync::Arc;

use chladni_caricature::{Action, CaricatureError, MatchRequest, Matched, Stack};
use chladni_harmonics::Body;
use chladni_mesh::Estimate;
use chladni_task::Task;

use super::super::crossings::CrossingMeter;
use super::super::edits::Edit;
use super::Session;
use crate::studio::job::Job;
use crate::work::{Aside, Error, Warning, body, matched, template_name};

/// A shape with its harmonics and the warnings about them.
pub type Solved = (Body, Vec<Warning>);

/// The result of a match; a failure is shown with its layer.
pub type Found = Result<Matched, CaricatureError>;

impl Session {
    /// Starts the next match that a layer waits for, and takes a finished one. Returns why a match failed,
    /// and whether to redraw.
    pub fn pump_matches(&mut self, ctx: &egui::Context) -> (Option<Warning>, bool) {
        let mut warning = None;
        let mut changed = false;
        if let Some((request, job)) = &self.matching
            && let Some(outcome) = job.ended()
        {
            let request = request.clone();
            let result = outcome.unwrap_or_else(|why| Err(CaricatureError::Elsewhere(why.to_string())));
            // No message if the user stopped it.
            let failed = result.as_ref().err().filter(|why| !matches!(why, CaricatureError::Cancelled(_)));
            warning = failed.map(|why| Warning::Plain(why.to_string()));
            if let Ok(Matched { stands: Some(stands), .. }) = &result
                && self.stands.in_doubt
            {
                self.stands = Estimate { orientation: *stands, in_doubt: false, ..self.stands };
            }
            self.stack.install(request, result);
            self.matching = None;
            self.refresh();
            changed = true;
        }
        let missing = self.stack.missing(self.history.project());
        if self.matching.as_ref().is_some_and(|(running, _)| !missing.contains(running)) {
            // Landmarks have changed, or the layer is gone: the match is no longer needed.
            self.matching = None;
        }
        if self.matching.is_none()
            && let Some(request) = missing.into_iter().next()
        {
            self.files.note(&request.template);
            self.matching = Some((request.clone(), self.start_match(request, ctx)));
        }
        (warning, changed)
    }

    /// Takes over matches that were found elsewhere for the same shape: layers that waited for them act now.
    pub fn learn(&mut self, other: &Stack) {
        self.stack.learn(other);
        for (_, layer) in self.history.project().layers() {
            self.files.note(&layer.template);
        }
        self.refresh();
    }

    /// The number of harmonics that was solved for last.
    pub fn solved_harmonics(&self) -> usize {
        self.solved.0
    }

    /// Limits, while the hand rests, the layers that would fold the surface, the lowest first; true where one was
    /// settled.
    pub fn pump_keeping(&mut self, ctx: &egui::Context, resting: bool) -> bool {
        if self.is_behind() {
            // The next evaluation shows whether a running search is still needed.
            return false;
        }
        let wanted = self.unsettled();
        if self
            .keeping
            .as_ref()
            .is_some_and(|(running, _)| !wanted.as_ref().is_some_and(|w| w.is_same(running)))
        {
            // Something has changed: the result is no longer needed.
            self.keeping = None;
        }
        if let Some((request, job)) = &self.keeping
            && let Some(outcome) = job.ended()
        {
            let request = request.clone();
            self.keeping = None;
            self.stack.settle(request, outcome.map_err(|why| CaricatureError::Elsewhere(why.to_string())));
            self.refresh();
            return true;
        }
        if self.keeping.is_none()
            && resting
            && let Some(request) = wanted
        {
            let asked = request.clone();
            self.keeping =
                Some((request, Job::start("Keeping triangles", ctx, move |task| Ok(asked.run(task)?))));
        }
        false
    }

    /// Solves for other harmonics where the project asks for them, and takes them in. Returns the warnings
    /// when they have arrived; an error says why they did not.
    pub fn pump_harmonics(&mut self, ctx: &egui::Context) -> Result<Option<Vec<Warning>>, Error> {
        let (harmonics, laplacian) = (self.project().harmonics, self.project().laplacian);
        if self.asked != (harmonics, laplacian) {
            self.asked = (harmonics, laplacian);
            self.solving = None;
        }
        if self.asked != self.solved && self.solving.is_none() {
            let (mesh, name) = (Arc::clone(&self.subject.mesh), self.project().shape.to_string());
            let work = move |task: &Task| {
                let aside = Aside::new(task);
                let (body, _) = body::build(&name, &mesh, harmonics, laplacian, &aside)?;
                Ok((body, aside.warnings()))
            };
            self.solving = Some(Job::start(format!("Solving for {harmonics} harmonics"), ctx, work));
        }
        let Some(outcome) = self.solving.as_ref().and_then(Job::ended) else { return Ok(None) };
        self.solving = None;
        if outcome.is_err() {
            self.restore_solved()?;
        }
        let (body, warnings) = outcome?;
        self.solved = self.asked;
        // Matches do not depend on harmonics: finished ones are kept, and a running one continues.
        self.stack = self.stack.with_harmonics_of(Arc::new(body))?;
        self.evaluate_anew();
        self.brush = None;
        self.crossings = CrossingMeter::default();
        self.refresh();
        Ok(Some(warnings))
    }

    /// Restores the last values that solved. A project saved with values that its shape cannot have would not open again,
    /// and one saved with a cancelled solve would open with that solve.
    fn restore_solved(&mut self) -> Result<(), Error> {
        self.asked = self.solved;
        let (harmonics, laplacian) = self.solved;
        // By the way that led here, so that no step back leads here again: forth where it was a step back.
        if self.history.step_to(|project| (project.harmonics, project.laplacian) == (harmonics, laplacian)) {
            self.refresh();
            return Ok(());
        }
        // Something else was done meanwhile.
        let mut edits = Vec::new();
        if self.project().harmonics != harmonics {
            edits.push(Edit::Once(Action::SetHarmonics(harmonics)));
        }
        if self.project().laplacian != laplacian {
            edits.push(Edit::Once(Action::SetLaplacian(laplacian)));
        }
        self.apply(edits)?;
        Ok(())
    }

    /// Counts where the result passes through itself, while the hand rests. True where the count
    /// is new; an error says why there is none.
    pub fn pump_crossings(&mut self, ctx: &egui::Context, resting: bool) -> Result<bool, Error> {
        let resting = resting && !self.is_behind();
        self.crossings.pump(ctx, &self.stack, &self.shown.evaluation, resting)
    }

    /// The harmonics that are being solved for.
    pub fn solving(&self) -> Option<&Job<Solved>> {
        self.solving.as_ref()
    }

    fn start_match(&self, request: MatchRequest, ctx: &egui::Context) -> Job<Found> {
        let (shape, body) = (Arc::clone(&self.subject.mesh), Arc::clone(self.stack.body()));
        let name = template_name(&request.template, self.project());
        // Warnings of a match are shown beside its quality.
        let work = move |task: &Task| Ok(matched(&request, &shape, &body, &Aside::new(task)));
        Job::start(format!("Matching {name}"), ctx, work)
    }

    /// The match that runs now.
    pub fn running_match(&self) -> Option<&Job<Found>> {
        self.matching.as_ref().map(|(_, job)| job)
    }

    /// Tries again what has failed of the selected layer: its match, or keeping its triangles.
    pub fn retry_match(&mut self) {
        if let Some(request) = self.selected_request() {
            // Where no match with another file is left, this one is the file that landmarks belong to.
            if !self.stack.is_matched_with(&request.template) {
                self.files.forget(&request.template);
            }
            self.stack.forget(&request);
        }
        if let Some(layer) = self.selected {
            self.stack.forget_limit(layer);
            self.refresh();
        }
    }
}
