//! Suggested children, judged by the recent sound.

use std::sync::Arc;

use chladni_music::{Action, Describer, Gallery, suggest};

use super::Concert;
use crate::studio::job::Job;
use crate::work::Error;

/// Candidates that are judged beside the frames.
#[derive(Default)]
pub struct Judging {
    wanted: bool,
    /// The gallery that is judged, and the job.
    running: Option<(Arc<Gallery>, Job<Vec<u16>>)>,
}

impl Judging {
    /// Children are wanted, as soon as they are judged.
    pub fn want(&mut self) {
        self.wanted = true;
    }
}

impl Concert {
    /// Whether children were asked for that are still being judged.
    pub fn is_judging(&self) -> bool {
        self.judging.wanted
    }

    /// Has candidates judged where children are wanted; breeds the best once that is done. A choice made meanwhile
    /// counts: then it begins again. Where nothing is chosen any more, or another generation was gone to, there are none.
    pub(super) fn judge(&mut self, ctx: &egui::Context) -> Result<(), Error> {
        if !self.judging.wanted {
            return Ok(());
        }
        let of_now = |(gallery, _): &(Arc<Gallery>, Job<Vec<u16>>)| **gallery == *self.instrument.gallery();
        if !self.judging.running.as_ref().is_some_and(of_now) {
            let now = self.instrument.gallery();
            let is_over = |(judged, _): &(Arc<Gallery>, Job<Vec<u16>>)| {
                // One that was made meanwhile keeps what is chosen.
                let is_left = judged.current() != now.current()
                    && judged.generations().len() == now.generations().len();
                is_left || !now.items().iter().any(|item| item.chosen)
            };
            if self.judging.running.as_ref().is_some_and(is_over) {
                self.judging = Judging::default();
                return Ok(());
            }
            let gallery = Arc::new(now.clone());
            let judged = gallery.clone();
            let playing = self.instrument.parameters().playing();
            let moments = self.recent.moments(self.instrument.shape().bands);
            let dancer = self.ensemble.dancer().clone();
            let job = Job::start("Suggesting", ctx, move |_| {
                let describer = Describer::new(dancer, playing, moments)?;
                Ok(suggest(&judged, &describer)?)
            });
            self.judging.running = Some((gallery, job));
        }
        let Some(judged) = self.judging.running.as_ref().and_then(|(_, job)| job.ended()) else {
            return Ok(());
        };
        self.judging = Judging::default();
        self.act(Action::BreedFrom { candidates: judged? })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;
    use chladni_music::Switch;

    /// A ball whose second generation is asked for children.
    fn breeding() -> Concert {
        let mut concert = Concert::of_ball(32).unwrap();
        let choose = |item| Action::Choose { item, on: true };
        let suggest = Action::Switch { switch: Switch::Suggest, on: true };
        for action in [choose(1), choose(2), Action::Breed, suggest, choose(2), choose(3), Action::Breed] {
            concert.act(action).unwrap();
        }
        assert!(concert.is_judging() && concert.instrument().gallery().current() == 1);
        concert
    }

    #[test]
    fn children_that_are_still_judged_are_not_bred_from_another_generation() {
        let mut concert = breeding();
        // They are judged until the end of the test.
        let (_end, held) = channel::<()>();
        let ctx = egui::Context::default();
        let job = Job::start("Suggesting", &ctx, move |_| {
            let _ = held.recv();
            Ok(Vec::new())
        });
        concert.judging.running = Some((Arc::new(concert.instrument().gallery().clone()), job));
        concert.act(Action::GoTo { generation: 0 }).unwrap();
        concert.judge(&ctx).unwrap();
        assert!(!concert.is_judging());
        assert_eq!(concert.instrument().gallery().generations().len(), 2);
    }

    #[test]
    fn children_that_are_still_judged_go_on_to_another_shape() {
        let before = breeding();
        let mut concert = Concert::of_ball(48).unwrap();
        concert.go_on_from(&before).unwrap();
        concert.go_on_as(before);
        assert!(concert.is_judging());
    }
}
