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
