//! An open project in the window: document, body, evaluation, and the jobs that feed them.

mod files;
mod following;
mod jobs;
mod names;
mod selection;

pub use jobs::{Found, Solved};
pub use selection::Held;

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use chladni_caricature::{
    Action, EvaluatedLayer, History, KeepRequest, Kept, LayerId, LayerState, MatchRequest, Project, Stack,
    Surface,
};
use chladni_harmonics::Laplacian;
use chladni_mesh::{Estimate, MirrorPlane, MirrorSearch, Orientation};
use chladni_task::{Cancelled, Task};

use files::MatchedFiles;

use super::crossings::CrossingMeter;
use super::edits::Edit;
use super::evaluating::{Evaluated, Figures, Shown, Sight};
use super::loading::Loaded;
use crate::studio::job::Job;
use crate::studio::newest::Newest;
use crate::studio::standing::Standing;
use crate::work::{Error, Sculpture, Subject};

/// A project with everything it needs to be drawn and changed.
pub struct Session {
    /// The document with its past and future.
    pub history: History,
    /// Where it was saved, if it was.
    pub path: Option<PathBuf>,
    /// The hash of the file there, as it was read or written last.
    pub on_disk: Option<String>,
    /// The shape.
    pub subject: Subject,
    /// Knows matches and limits, and what was evaluated; its clones evaluate the document.
    pub stack: Stack,
    /// The newest evaluation that has arrived. While the document changes it may be a step behind.
    pub shown: Arc<Shown>,
    /// Its figures, until the stage takes them.
    figures: Option<Figures>,
    evaluating: Newest<Evaluated>,
    /// What of the project is seen.
    sight: Sight,
    /// The layer that the panels edit.
    pub selected: Option<LayerId>,
    /// Where the result passes through itself.
    pub crossings: CrossingMeter,
    matching: Option<(MatchRequest, Job<Found>)>,
    files: MatchedFiles,
    /// Limits a layer that would fold the surface.
    keeping: Option<(KeepRequest, Job<Kept>)>,
    mirror: Arc<OnceLock<Option<MirrorPlane>>>,
    /// Prepares the brush, from the moment when it is chosen.
    brush: Option<Job<()>>,
    /// The harmonics that were asked for last.
    asked: (usize, Laplacian),
    /// The same of those that are there.
    solved: (usize, Laplacian),
    solving: Option<Job<Solved>>,
    /// The orientation estimated from the surface; a matched template may know better.
    stands: Estimate,
}

impl Session {
    /// A session on a loaded project.
    pub fn new(loaded: Loaded) -> Self {
        let asked = (loaded.project.harmonics, loaded.project.laplacian);
        let (selected, Evaluated { stack, shown, figures }) = (loaded.sight.selected, loaded.evaluated);
        Self {
            history: if loaded.new {
                History::recovered(loaded.project)
            } else {
                History::new(loaded.project)
            },
            path: loaded.path,
            on_disk: loaded.on_disk,
            subject: loaded.subject,
            stack,
            shown: Arc::new(shown),
            figures: Some(figures),
            evaluating: Newest::default(),
            sight: loaded.sight,
            selected,
            crossings: CrossingMeter::default(),
            matching: None,
            files: MatchedFiles::default(),
            keeping: None,
            mirror: Arc::default(),
            brush: None,
            asked,
            solved: asked,
            solving: None,
            stands: loaded.stands,
        }
    }

    /// Prepares, in the background, the data that the first stroke of a brush needs.
    pub fn prepare_brush(&mut self, ctx: &egui::Context) {
        if self.brush.is_some() {
            return;
        }
        let soften = self.stack.brush_preparation();
        let (mirror, surface) = (Arc::clone(&self.mirror), Arc::clone(self.stack.surface()));
        self.brush = Some(Job::start("Preparing the brush", ctx, move |task| {
            soften();
            if mirror.get().is_none() {
                // If another job set it first, its result stands.
                let _ = mirror.set(own_mirror(&surface, task)?);
            }
            Ok(())
        }));
    }

    /// The plane in which the shape comes closest to its mirror image; waits if the search is still running.
    pub fn mirror(&self) -> Option<MirrorPlane> {
        // Nobody cancels it.
        *self.mirror.get_or_init(|| own_mirror(self.stack.surface(), &Task::new()).unwrap_or_default())
    }

    /// The same, once it was found or not found.
    pub fn known_mirror(&self) -> Option<Option<MirrorPlane>> {
        self.mirror.get().copied()
    }

    /// How the shape stands: as the project says, else as is most probable.
    pub fn standing(&self) -> Standing {
        let Estimate { orientation, in_doubt, .. } = self.stands;
        Standing { found: orientation, in_doubt, given: self.project().stands }
    }

    /// Its orientation.
    pub fn stands(&self) -> Orientation {
        self.standing().now()
    }

    /// The document as it is now.
    pub fn project(&self) -> &Project {
        self.history.project()
    }

    /// Does the edits of the panels, up to the first error; true if something may look different.
    pub fn apply(&mut self, edits: Vec<Edit>) -> Result<bool, Error> {
        let mut changed = false;
        let outcome = edits.into_iter().try_for_each(|edit| {
            changed |= self.take_up(&edit)?;
            Ok(())
        });
        // Edits before an error are done.
        if changed {
            self.refresh();
        }
        outcome.map(|()| changed)
    }

    /// Does one thing; true where the document has changed.
    fn take_up(&mut self, edit: &Edit) -> Result<bool, Error> {
        let (next, surface) = (self.project().next_id(), Arc::clone(self.stack.surface()));
        let place = self.project().layers().iter().position(|(id, _)| Some(*id) == self.selected);
        match edit {
            Edit::Once(action) => self.history.apply(action, Some(&surface)),
            Edit::Live(action) => self.history.apply_live(action, Some(&surface)),
            Edit::Together(actions) => self.history.apply_together(actions, Some(&surface)),
            Edit::Finish => {
                self.history.finish();
                return Ok(false);
            }
        }?;
        match edit {
            Edit::Once(Action::Add { .. } | Action::Duplicate(_)) => self.selected = Some(next),
            Edit::Once(Action::Remove(id)) if self.selected == Some(*id) => {
                // The one that was above, or the topmost.
                let layers = self.project().layers();
                let next = place.and_then(|place| layers.get(place)).or(layers.last());
                self.selected = next.map(|(id, _)| *id);
            }
            Edit::Together(actions) if actions.iter().any(|a| matches!(a, Action::Add { .. })) => {
                // The topmost of those that were added.
                self.selected = self.project().layers().last().map(|(id, _)| *id);
            }
            _ => {}
        }
        Ok(true)
    }

    /// Takes a step back or forth; its label, where there was one.
    pub fn travel(&mut self, back: bool) -> Option<&'static str> {
        let label = if back { self.history.undo() } else { self.history.redo() };
        if label.is_some() {
            self.refresh();
        }
        label
    }

    /// The document has changed, or what its layers were waiting for has arrived: it is to be evaluated again.
    pub(super) fn refresh(&mut self) {
        if self.selected.is_none_or(|id| self.project().layer(id).is_none()) {
            self.selected = self.project().layers().last().map(|(id, _)| *id);
        }
        self.evaluating.outdate();
    }

    /// Layers whose template could not be read or matched: they do nothing.
    pub fn failed_layers(&self) -> Vec<LayerId> {
        let failed = |layer: &&EvaluatedLayer| matches!(layer.state, LayerState::Failed(_));
        self.shown.evaluation.layers.iter().filter(failed).map(|layer| layer.id).collect()
    }

    /// Whether `layer` does nothing yet, because its template is still to be matched.
    pub fn is_waiting(&self, layer: LayerId) -> bool {
        let layers = &self.shown.evaluation.layers;
        layers.iter().any(|evaluated| evaluated.id == layer && evaluated.state == LayerState::Waiting)
    }

    /// Triangles folded by `layer`; `None` until it is evaluated.
    pub fn folds_of(&self, layer: LayerId) -> Option<usize> {
        let index = self.shown.evaluation.layers.iter().position(|evaluated| evaluated.id == layer)?;
        Some(self.shown.folds.get(index)?.len())
    }

    /// Whether it is still being found how far layers must be held back: until then the last known limit is shown.
    pub fn is_settling(&self) -> bool {
        self.keeping.is_some() || self.unsettled().is_some()
    }

    /// Whether layers still wait for a match, or other harmonics are being solved for: the result is to change by itself.
    pub fn is_working(&self) -> bool {
        self.solving.is_some() || !self.stack.missing(self.project()).is_empty()
    }

    /// The result that is shown; later edits do not change it.
    pub fn sculpture(&self) -> Sculpture {
        let (source, subject) = (self.project().shape.clone(), self.subject.clone());
        Sculpture {
            source,
            subject,
            body: Arc::clone(self.stack.body()),
            evaluation: self.shown.evaluation.clone(),
        }
    }
}

/// `None` if the shape has no extent.
fn own_mirror(surface: &Surface, task: &Task) -> Result<Option<MirrorPlane>, Cancelled> {
    let search = MirrorSearch::of(&surface.positions, &surface.triangles);
    search.map_or(Ok(None), |search| search.best(&[], task))
}

#[cfg(test)]
mod tests {
    use super::super::loading::{Candidate, load};
    use super::*;
    use crate::work::Warning;
    use chladni_caricature::{Layer, LayerState, ShapeSource, Template};
    use chladni_mesh::TriMesh;
    use std::sync::mpsc::channel;

    #[test]
    fn a_small_shape_of_many_seams_opens_with_as_many_harmonics_as_it_has() {
        // Every triangle has corners of its own: 240 vertices in the file, 42 places.
        let sphere = chladni_mesh::samples::icosphere(1);
        let corners = sphere.triangles.iter().flatten().map(|v| sphere.positions[*v as usize]);
        let soup = TriMesh {
            positions: corners.collect(),
            triangles: (0..80).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            ..TriMesh::default()
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("soup.ply");
        chladni_mesh::save_mesh(&soup, &path).unwrap();
        let project = Project::new(ShapeSource::File(path), 100);
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        let body = loaded.evaluated.stack.body();
        assert_eq!((body.positions.len(), body.basis.harmonics()), (42, 42));
    }

    /// Asks for the papers' operator and waits for the result.
    fn in_paper_mode(mesh: &TriMesh) -> (Session, Result<Option<Vec<Warning>>, Error>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("shape.ply");
        chladni_mesh::save_mesh(mesh, &path).unwrap();
        let project = Project::new(ShapeSource::File(path), 4);
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        let mut session = Session::new(loaded);
        session.apply(vec![Edit::Once(Action::SetLaplacian(Laplacian::Cotangent))]).unwrap();
        loop {
            match session.pump_harmonics(&egui::Context::default()) {
                Ok(None) => std::thread::sleep(std::time::Duration::from_millis(5)),
                outcome => return (session, outcome),
            }
        }
    }

    #[test]
    fn paper_mode_solves_again_and_is_taken_back_where_a_shape_cannot_have_it() {
        let of = |session: &Session| session.stack.body().basis.certificate.laplacian;
        let (session, outcome) = in_paper_mode(&chladni_mesh::samples::icosphere(1));
        assert!(outcome.is_ok());
        assert_eq!((of(&session), session.project().laplacian), (Laplacian::Cotangent, Laplacian::Cotangent));
        assert_eq!(
            session.project().new_layer("new", Template::Sphere),
            Layer::paper("new", Template::Sphere)
        );
        let fan = TriMesh {
            positions: vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.5, 0.8, 0.5], [-0.5, -0.8, 0.5]],
            triangles: vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]],
            ..TriMesh::default()
        };
        let (mut session, outcome) = in_paper_mode(&fan);
        assert!(outcome.unwrap_err().to_string().contains("3 triangles meet"));
        assert_eq!((of(&session), session.project().laplacian), (Laplacian::Delaunay, Laplacian::Delaunay));
        // Nothing is left to be solved, and no step back leads there again.
        assert_eq!(session.pump_harmonics(&egui::Context::default()).unwrap(), None);
        assert!(session.solving().is_none());
        assert_eq!((session.history.undo_label(), session.history.redo_label()), (None, Some("Laplacian")));
    }

    #[test]
    fn harmonics_that_are_there_are_not_solved_for_again() {
        let project = Project::new(ShapeSource::Sample("head".into()), 12);
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        let (mut session, ctx) = (Session::new(loaded), egui::Context::default());
        // So many that they are not there yet when it is undone.
        session.apply(vec![Edit::Once(Action::SetHarmonics(1024))]).unwrap();
        assert_eq!(session.pump_harmonics(&ctx).unwrap(), None);
        assert!(session.travel(true).is_some());
        assert_eq!(session.pump_harmonics(&ctx).unwrap(), None);
        assert!(session.solving().is_none());
        assert_eq!(session.stack.body().basis.harmonics(), 12);
    }

    #[test]
    fn another_number_of_harmonics_matches_nothing_anew() {
        let mut project = Project::new(ShapeSource::Sample("head".into()), 16);
        let layer = project.push(Layer { mu: -1.0, ..Layer::new("round", Template::Ellipsoid) }).unwrap();
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        let mut session = Session::new(loaded);
        let ctx = egui::Context::default();
        let deadline = std::time::Instant::now() + chladni_testdata::HANGS;
        let wait_for = |session: &mut Session, done: &dyn Fn(&Session) -> bool| {
            while !done(session) {
                assert!(std::time::Instant::now() < deadline);
                session.pump_harmonics(&ctx).unwrap();
                session.pump_matches(&ctx);
                session.catch_up(&ctx).unwrap();
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        };
        wait_for(&mut session, &|session| session.selected_match().is_some());
        let before = Arc::clone(session.selected_match().unwrap());
        // On the way: the more triangles may fold, the further it goes.
        let [no_fold, hardly, some] = [0.0, 0.001, 0.02].map(|share| session.furthest_mu(share).unwrap());
        assert!(no_fold < 0.0 && hardly < no_fold && some < hardly, "{no_fold}, {hardly}, {some}");
        session.apply(vec![Edit::Once(Action::SetHarmonics(24))]).unwrap();
        wait_for(&mut session, &|session| session.stack.body().basis.harmonics() == 24);
        assert!(session.running_match().is_none() && session.stack.missing(session.project()).is_empty());
        assert!(Arc::ptr_eq(&before, session.selected_match().unwrap()));
        let acting = &session.shown.evaluation.layers[0];
        assert_eq!((acting.id, acting.state.clone()), (layer, LayerState::Acts));
        assert_eq!(acting.difference.as_ref().unwrap().target.spectrum().len(), 24);
    }

    #[test]
    fn a_match_that_was_found_elsewhere_reaches_the_shape() {
        let mut project = Project::new(ShapeSource::Sample("head".into()), 16);
        let layer = Layer { mu: -1.0, ..Layer::new("round", Template::Ellipsoid) };
        project.push(layer.clone()).unwrap();
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        let (mut session, ctx) = (Session::new(loaded), egui::Context::default());
        session.catch_up(&ctx).unwrap();
        assert_eq!(session.shown.evaluation.layers[0].state, LayerState::Waiting);
        // As the gallery does.
        let mut other = session.stack.clone();
        let request = MatchRequest::of(&layer).unwrap();
        let found = request.run(&session.subject.mesh, session.stack.body(), None, &Task::new());
        other.install(request, found);
        session.learn(&other);
        session.catch_up(&ctx).unwrap();
        assert_eq!(session.shown.evaluation.layers[0].state, LayerState::Acts);
    }

    #[test]
    fn the_layer_above_is_selected_where_the_selected_one_goes_and_no_other_where_several_things_change() {
        let mut project = Project::new(ShapeSource::Sample("head".into()), 8);
        let ids: Vec<LayerId> =
            (1..4).map(|i| project.push(Layer::new(i.to_string(), Template::Scaled(0.5))).unwrap()).collect();
        let mut session = Session::new(load(Candidate::new(project), &channel().0, &Task::new()).unwrap());
        session.selected = Some(ids[0]);
        let to = chladni_caricature::Property::Mu(0.5);
        session.apply(vec![Edit::Together(vec![Action::Set { layer: ids[1], to }])]).unwrap();
        assert_eq!(session.selected, Some(ids[0]));
        for left in [&ids[1..], &ids[2..]] {
            session.apply(vec![Edit::Once(Action::Remove(session.selected.unwrap()))]).unwrap();
            assert_eq!(session.selected, Some(left[0]));
            assert!(session.project().layers().iter().map(|(id, _)| id).eq(left));
        }
    }

    #[test]
    fn what_came_before_an_error_is_done_and_seen() {
        let project = Project::new(ShapeSource::Sample("head".into()), 16);
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        let mut session = Session::new(loaded);
        let layer = || Box::new(Layer::new("Magnify all", Template::Scaled(0.5)));
        let add = || Edit::Once(Action::Add { index: 0, layer: layer() });
        let first = session.project().next_id();
        let remove = || Edit::Once(Action::Remove(first));
        // The second time it is not there any more.
        assert!(session.apply(vec![add(), add(), remove(), remove()]).is_err());
        session.catch_up(&egui::Context::default()).unwrap();
        assert_eq!((session.project().layers().len(), session.shown.evaluation.layers.len()), (1, 1));
        assert!(session.selected.is_some());
    }
}
