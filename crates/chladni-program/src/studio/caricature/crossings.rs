//! Where the result passes through itself, counted in the background whenever the user pauses.

use std::sync::Arc;

use chladni_caricature::{Base, Crossings, Evaluation, Stack, Surface};
use chladni_task::{Cancelled, Task};

use crate::studio::job::Job;
use crate::work::Error;

/// The known crossings of the result, and the running search.
#[derive(Default)]
pub struct CrossingMeter {
    searcher: Option<Searcher>,
    /// The shape that was searched last, or is being searched.
    searched: Option<Arc<Base>>,
    running: Option<Job<Found>>,
    found: Option<Vec<u32>>,
}

/// The result of a search, with the searcher for reuse.
type Found = (Searcher, Vec<u32>);

/// The search structure, which is reused.
#[derive(Clone)]
struct Searcher {
    tree: Arc<Crossings>,
    /// Triangles that cross in the original shape.
    from_the_start: usize,
}

/// The counts that the panel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// Triangles of the result that pass through others.
    pub now: usize,
    /// Triangles of the original that do.
    pub from_the_start: usize,
    /// Whether the result has changed since.
    pub outdated: bool,
}

impl CrossingMeter {
    /// Takes finished results and, while `resting`, starts a search of a new result; true if something may
    /// look different.
    pub fn pump(
        &mut self,
        ctx: &egui::Context,
        stack: &Stack,
        evaluation: &Evaluation,
        resting: bool,
    ) -> Result<bool, Error> {
        let mut changed = false;
        match self.running.as_ref().map(Job::ended) {
            None => {}
            Some(None) if resting && self.is_searched(&evaluation.result) => return Ok(false),
            // The user continues and needs all threads: dropping the search stops it.
            Some(None | Some(Err(Error::Cancelled))) => (self.running, self.searched) = (None, None),
            Some(Some(Ok((searcher, found)))) => {
                (self.searcher, self.found) = (Some(searcher), Some(found));
                (self.running, changed) = (None, true);
            }
            Some(Some(Err(why))) => {
                self.running = None;
                return Err(why);
            }
        }
        if resting && !self.is_searched(&evaluation.result) {
            let result = Arc::clone(&evaluation.result);
            self.searched = Some(Arc::clone(&result));
            let (searcher, surface) = (self.searcher.clone(), Arc::clone(stack.surface()));
            self.running = Some(Job::start("Counting crossings", ctx, move |task| {
                let searcher = match searcher {
                    Some(searcher) => searcher,
                    None => Searcher::of(surface, task)?,
                };
                let found = searcher.tree.triangles(&result.positions, task)?;
                Ok((searcher, found))
            }));
        }
        Ok(changed)
    }

    fn is_searched(&self, result: &Arc<Base>) -> bool {
        self.searched.as_ref().is_some_and(|searched| Arc::ptr_eq(searched, result))
    }

    /// The triangles that were found last, ascending.
    pub fn triangles(&self) -> &[u32] {
        self.found.as_deref().unwrap_or_default()
    }

    /// The last count for `evaluation` or an earlier one; `None` before the first count.
    pub fn count(&self, evaluation: &Evaluation) -> Option<Count> {
        let (found, searcher) = (self.found.as_ref()?, self.searcher.as_ref()?);
        let outdated = self.running.is_some() || !self.is_searched(&evaluation.result);
        Some(Count { now: found.len(), from_the_start: searcher.from_the_start, outdated })
    }
}

impl Searcher {
    fn of(surface: Arc<Surface>, task: &Task) -> Result<Self, Cancelled> {
        let tree = Arc::new(Crossings::of(Arc::clone(&surface)));
        let from_the_start = tree.triangles(&surface.positions, task)?.len();
        Ok(Self { tree, from_the_start })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_caricature::{Project, ShapeSource};
    use chladni_harmonics::{BasisSettings, Body};

    #[test]
    fn a_search_makes_way_for_the_hand_and_begins_again_when_it_rests() {
        let mesh = chladni_mesh::samples::icosphere(4);
        let body = Body::build(&mesh, &BasisSettings::new(4), &Task::new()).unwrap();
        let mut stack = Stack::new(Arc::new(body)).unwrap();
        let evaluation = stack.evaluate(&Project::new(ShapeSource::Sample("icosphere".into()), 4));
        let (ctx, mut meter) = (egui::Context::default(), CrossingMeter::default());
        meter.pump(&ctx, &stack, &evaluation, true).unwrap();
        assert!(meter.running.is_some());
        meter.pump(&ctx, &stack, &evaluation, false).unwrap();
        assert!(meter.running.is_none());
        let mut counted = || {
            meter.pump(&ctx, &stack, &evaluation, true).unwrap();
            meter.count(&evaluation).filter(|count| !count.outdated)
        };
        let start = std::time::Instant::now();
        let count = loop {
            assert!(start.elapsed() < chladni_testdata::HANGS, "the search never began again");
            if let Some(count) = counted() {
                break count;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        };
        assert_eq!((count.now, count.from_the_start), (0, 0));
    }
}
