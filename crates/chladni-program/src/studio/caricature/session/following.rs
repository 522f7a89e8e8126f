//! What is shown follows the document, evaluated on other threads.

use std::sync::Arc;
use std::time::Duration;

use chladni_caricature::KeepRequest;
use egui::Context;

use super::super::evaluating::{Evaluated, Figures, Sight, in_turn};
use super::Session;
use crate::work::Error;

impl Session {
    /// Takes in finished evaluations of what `sight` shows, and waits no longer than `patience` for the newest; true where
    /// something may look different.
    pub fn follow(&mut self, ctx: &Context, sight: Sight, patience: Duration) -> Result<bool, Error> {
        let mut new = false;
        loop {
            self.hand_over(ctx, sight);
            self.wait(patience);
            if !self.take_in()? {
                return Ok(new);
            }
            new = true;
        }
    }

    /// Waits until the document as it is now is shown, for what must be exact.
    pub fn catch_up(&mut self, ctx: &Context) -> Result<(), Error> {
        let sight = Sight { selected: self.selected, ..self.sight };
        self.follow(ctx, sight, Duration::MAX).map(|_| ())
    }

    /// Has the document evaluated as it is now; while an earlier evaluation runs, it has its turn after that.
    pub fn hand_over(&mut self, ctx: &Context, sight: Sight) {
        if sight != self.sight {
            self.sight = sight;
            self.evaluating.outdate();
        }
        if !self.evaluating.is_due() {
            return;
        }
        let project = self.project().clone();
        self.stack.forget_unused(&project);
        let (stack, before) = (self.stack.clone(), Arc::clone(&self.shown));
        self.evaluating.begin(ctx, move || in_turn(|| Evaluated::of(stack, &project, sight, Some(&before))));
    }

    /// Waits for the running evaluation; see [`Newest::wait`](crate::studio::newest::Newest::wait).
    pub fn wait(&mut self, patience: Duration) {
        self.evaluating.wait(patience);
    }

    /// Takes in an evaluation that has ended; true where there was one.
    pub fn take_in(&mut self) -> Result<bool, Error> {
        let Some(evaluated) = self.evaluating.ended() else { return Ok(false) };
        let Evaluated { stack, shown, figures } = evaluated?;
        self.stack.remember(stack);
        (self.shown, self.figures) = (Arc::new(shown), Some(figures));
        Ok(true)
    }

    /// Figures that have arrived since this was last asked.
    pub fn take_figures(&mut self) -> Option<Figures> {
        self.figures.take()
    }

    /// Whether what is shown is older than the document.
    pub fn is_behind(&self) -> bool {
        self.evaluating.is_behind()
    }

    /// How long until what is shown has been behind for long; `None` where it is not behind.
    pub fn slow_in(&self) -> Option<Duration> {
        self.evaluating.slow_in()
    }

    /// Drops a running evaluation, and begins anew.
    pub fn evaluate_anew(&mut self) {
        self.evaluating.give_up();
    }

    /// The lowest layer that is still to be limited, as far as is known.
    pub(super) fn unsettled(&self) -> Option<KeepRequest> {
        let keeps = self.project().keep_triangles && !self.is_behind();
        if keeps { self.stack.unsettled_in(&self.shown.evaluation) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::edits::Edit;
    use super::super::super::loading::{Candidate, load};
    use super::*;
    use chladni_caricature::{
        Action, Evaluation, Layer, LayerId, Project, Property, ShapeSource, Stack, Template,
    };
    use chladni_mesh::surface::vec3::single;
    use chladni_task::Task;
    use std::sync::mpsc::channel;

    /// A session on the head with two layers that need no match.
    fn session() -> (Session, [LayerId; 2]) {
        let mut project = Project::new(ShapeSource::Sample("head".into()), 16);
        let layer = |template| Layer { mu: -0.5, ..Layer::new("layer", template) };
        let [low, high] = [Template::LowPass(4), Template::Original].map(|t| project.push(layer(t)).unwrap());
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        (Session::new(loaded), [low, high])
    }

    fn set(session: &mut Session, layer: LayerId, mu: f64) {
        session.apply(vec![Edit::Live(Action::Set { layer, to: Property::Mu(mu) })]).unwrap();
    }

    fn bits(evaluation: &Evaluation) -> Vec<[u64; 3]> {
        evaluation.result.positions.iter().map(|p| p.map(f64::to_bits)).collect()
    }

    #[test]
    fn what_is_shown_in_the_end_is_the_newest_document_bit_for_bit() {
        let (mut session, [low, high]) = session();
        let (ctx, sight) = (Context::default(), session.sight);
        for step in 0..40 {
            set(&mut session, if step % 3 == 0 { low } else { high }, -0.01 * f64::from(step));
            session.follow(&ctx, sight, Duration::ZERO).unwrap();
        }
        let layer = Box::new(Layer { mu: 0.4, ..Layer::new("top", Template::Scaled(0.5)) });
        session
            .apply(vec![Edit::Once(Action::Remove(low)), Edit::Once(Action::Add { index: 1, layer })])
            .unwrap();
        // What is not evaluated yet has no folds to show.
        let top = session.selected.unwrap();
        assert!(
            session.is_behind() && session.folds_of(top).is_none() && session.selected_evaluation().is_none()
        );
        session.catch_up(&ctx).unwrap();
        assert!(!session.is_behind() && session.folds_of(top).is_some());
        let mut at_once = Stack::new(Arc::clone(session.stack.body())).unwrap();
        let expected = at_once.evaluate(session.project());
        assert_eq!(bits(&session.shown.evaluation), bits(&expected));
        let figures = session.take_figures().unwrap();
        assert_eq!(figures.result.0, single(&expected.result.positions));
        let folds: Vec<_> = expected.layers.iter().map(|l| l.folded_triangles(at_once.surface())).collect();
        assert_eq!(session.shown.folds.iter().map(|f| f.to_vec()).collect::<Vec<_>>(), folds);
    }

    #[test]
    fn an_evaluation_on_harmonics_that_were_left_is_not_taken_in() {
        let (mut session, [low, _]) = session();
        let (ctx, sight) = (Context::default(), session.sight);
        session.apply(vec![Edit::Once(Action::SetHarmonics(24))]).unwrap();
        loop {
            // One is always on its way.
            set(&mut session, low, -0.3);
            session.hand_over(&ctx, sight);
            if session.pump_harmonics(&ctx).unwrap().is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        assert!(session.is_behind() && !session.take_in().unwrap());
        session.catch_up(&ctx).unwrap();
        let difference = session.shown.evaluation.layers[0].difference.as_ref().unwrap();
        assert_eq!(difference.base.basis().harmonics(), 24);
    }

    #[test]
    fn the_three_models_and_the_template_come_where_they_are_seen() {
        let (mut session, _) = session();
        let ctx = Context::default();
        let figures = session.take_figures().unwrap();
        assert!(figures.models.is_none() && figures.template.is_none());
        let sight = Sight { models: true, template: true, ..session.sight };
        assert!(session.follow(&ctx, sight, Duration::MAX).unwrap());
        let figures = session.take_figures().unwrap();
        let [coordinate, normal, _] = figures.models.unwrap();
        assert!(coordinate == figures.result && normal != coordinate && figures.template.is_some());
        // A layer that does not act looks the same in all of them.
        let sight = Sight { selected: None, ..sight };
        assert!(session.follow(&ctx, sight, Duration::MAX).unwrap());
        let figures = session.take_figures().unwrap();
        assert!(figures.models.unwrap().iter().all(|model| *model == figures.result));
        assert!(!session.follow(&ctx, sight, Duration::MAX).unwrap(), "nothing has changed");
    }
}
