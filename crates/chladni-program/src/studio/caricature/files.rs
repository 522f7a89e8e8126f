//! Opening and saving project files without losing work.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use chladni_caricature::{
    Action, CaricatureError, Layer, Project, Recovered, Resolution, ShapeSource, Template,
};
use chladni_mesh::surface::vec3::single;
use chladni_task::{alone, write_atomic};
use chladni_view::{Camera, View};
use egui::Context;

use super::CaricatureRoom;
use super::autosave::Autosave;
use super::edits::Edit;
use super::evaluating::in_turn;
use super::loading::{self, Candidate};
use super::matches::renew;
use super::moved;
use super::preview::Preview;
use super::session::Session;
use super::shot::{Pose, Shot};
use crate::studio::choose::{FileKind, ask_where_to_save};
use crate::studio::job::Job;
use crate::studio::pictures;
use crate::studio::room::{Room, Shared};
use crate::studio::unsaved::{Answer, Question};
use crate::work::formats::{MESHES, PROJECT, is_project, opened_together};
use crate::work::{Error, file_hash, layer_against, shown_name, source};

/// The use of files that come together.
pub(super) struct Arranged {
    /// The project or mesh that takes the place of what is open.
    pub opened: Option<PathBuf>,
    /// Meshes that become layers.
    pub templates: Vec<PathBuf>,
    /// How many projects there are, of which one is opened.
    projects: usize,
}

impl CaricatureRoom {
    /// Asks for meshes or a project and opens them.
    pub(super) fn choose_file(&mut self, shared: &mut Shared<'_>) {
        let paths = shared.chooser.open_several(&[("Meshes and projects", &self.extensions())]);
        self.open_together(&paths, true, shared);
    }

    /// Opens the project among `paths`, or else the first mesh as the shape, where it is to be opened `anew`; the other
    /// meshes become layers.
    pub(super) fn open_together(&mut self, paths: &[PathBuf], anew: bool, shared: &mut Shared<'_>) {
        let shapes = self.shapes_among(paths, shared);
        let Arranged { opened, templates, projects } = self.arranged(shapes, anew);
        let Some(path) = opened else { return self.take_templates(templates, shared) };
        if projects > 1 {
            let name = path.display();
            shared.notices.warn(format!("One project is open at a time: of these, {name} is opened."));
        }
        self.load(&path, templates, shared);
    }

    /// Which of `shapes`, meshes and projects, is opened, and which become layers.
    pub(super) fn arranged(&self, shapes: Vec<PathBuf>, anew: bool) -> Arranged {
        // A single mesh is compared with the shape that is open, or will be.
        let is_open = self.session.is_some() || self.loading.is_some() || self.candidate.is_some();
        let has_shape = is_open && !self.is_untouched_sample();
        let new_shape = anew || !has_shape || shapes.len() > 1;
        let (projects, mut templates): (Vec<PathBuf>, Vec<PathBuf>) =
            shapes.into_iter().partition(|path| is_project(path));
        let count = projects.len();
        let first_mesh = || (new_shape && !templates.is_empty()).then(|| templates.remove(0));
        let opened = projects.into_iter().next().or_else(first_mesh);
        Arranged { opened, templates, projects: count }
    }

    /// Whether the shape is the sample that stands here in the beginning, as it was.
    fn is_untouched_sample(&self) -> bool {
        let is_untouched = |session: &Session| {
            self.loading.is_none() && session.path.is_none() && !session.history.is_modified()
        };
        self.unasked && self.session.as_ref().is_none_or(is_untouched)
    }

    /// The meshes and projects among `paths`; of other files, it says where they are opened.
    fn shapes_among(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) -> Vec<PathBuf> {
        let (shapes, left_out) = opened_together(paths);
        for why in left_out {
            if shapes.is_empty() {
                self.refuse(Error::Input(why), shared);
            } else {
                shared.notices.warn(why);
            }
        }
        shapes
    }

    /// Opens a mesh as a new shape, or a project, and makes a layer against each of `templates`.
    fn load(&mut self, path: &Path, mut templates: Vec<PathBuf>, shared: &mut Shared<'_>) {
        let candidate = if is_project(path) {
            let on_disk = file_hash(path);
            let known = |file: &Path| shared.settings.knows(path, file);
            match moved::open(path, &mut templates, known) {
                Ok((project, found)) => {
                    for moved::Found { missing, mesh, .. } in found.iter().filter(|found| found.is_in_doubt) {
                        let (missing, mesh) = (missing.display(), mesh.display());
                        shared.notices.warn(format!(
                            "{missing} is not there. {mesh} was taken in its place, but by their names it may be \
                             another."
                        ));
                    }
                    if let Some(warning) = source::outside(path, &project, known) {
                        shared.notices.warn(warning);
                    }
                    let found_moved = !found.is_empty();
                    Candidate { path: Some(path.to_owned()), on_disk, found_moved, ..Candidate::new(project) }
                }
                Err(why) => return self.refuse(why, shared),
            }
        } else if let Some(name) = ShapeSource::sample_name(path) {
            return self.start(Candidate { templates, ..sample(name, shared) }, shared);
        } else {
            let shape = ShapeSource::File(path.to_owned());
            Candidate::new(Project::new(shape, shared.settings.harmonics))
        };
        self.start(Candidate { templates, ..candidate }, shared);
    }

    /// Reports why nothing was opened.
    pub(super) fn refuse(&mut self, why: Error, shared: &mut Shared<'_>) {
        self.refused = true;
        shared.notices.failed(why);
    }

    /// Reports why what was opening is not shown, and what is in its place: something else may have begun to open before it.
    pub(super) fn fall_back(&mut self, why: Error, shared: &mut Shared<'_>) {
        let before = self.session.as_ref().filter(|_| !why.is_cancelled());
        let why = match before.map(Session::name) {
            Some(name) => Error::Input(format!("{why}; “{name}” is shown as before")),
            None => why,
        };
        self.refuse(why, shared);
    }

    /// Asks for another shape and carries the layers over to it, as a new project with a history of its own.
    pub(super) fn change_shape(&mut self, shared: &mut Shared<'_>) {
        let Some(session) = &self.session else { return };
        let Some(path) = shared.chooser.open(&[("Meshes", &MESHES)]) else { return };
        let mut project = session.project().clone();
        (project.shape, project.resolution) = (ShapeSource::File(path), Resolution::Usual);
        let made_on = Some(Arc::clone(&session.subject.mesh));
        self.start(Candidate { made_on, ..Candidate::new(project) }, shared);
    }

    /// Opens a sample.
    pub(super) fn open_sample(&mut self, name: &str, shared: &mut Shared<'_>) {
        self.start(sample(name, shared), shared);
    }

    /// Puts `candidate` in the place of the open project, which is asked about where it has
    /// unsaved changes.
    pub(super) fn start(&mut self, candidate: Candidate, shared: &Shared<'_>) {
        if self.has_unsaved_work() {
            self.candidate = Some(candidate);
        } else {
            self.begin(candidate, &shared.ctx);
        }
    }

    fn begin(&mut self, mut candidate: Candidate, ctx: &Context) {
        // It stays until the new shape is there.
        self.unasked &= self.session.is_some();
        self.templates = std::mem::take(&mut candidate.templates);
        let label = match &candidate.project.shape {
            ShapeSource::File(path) => shown_name(path).into_owned(),
            sample @ ShapeSource::Sample(_) => sample.to_string(),
        };
        let label = format!("Opening {label}");
        let (read, meshes) = channel();
        self.preview = Some(Preview::of(meshes));
        self.loading = Some(Job::start(label, ctx, move |task| loading::load(candidate, &read, task)));
    }

    /// Asks for meshes to compare with, and makes a layer against each.
    pub(super) fn choose_template(&mut self, shared: &mut Shared<'_>) {
        let meshes = shared.chooser.open_several(&[("Meshes", &MESHES)]);
        self.take_templates(meshes, shared);
    }

    /// Makes a layer against each of `meshes`, in the project being loaded if there is one.
    fn take_templates(&mut self, meshes: Vec<PathBuf>, shared: &mut Shared<'_>) {
        if let Some(candidate) = &mut self.candidate {
            candidate.templates.extend(meshes);
        } else if self.loading.is_some() {
            self.templates.extend(meshes);
        } else {
            meshes.into_iter().for_each(|path| self.add_template(path, shared));
        }
    }

    /// Lays a mesh beside the shape: a new layer against it.
    pub(super) fn add_template(&mut self, path: PathBuf, shared: &mut Shared<'_>) {
        let Some(session) = &mut self.session else { return };
        let index = session.project().layers().len();
        let layer = Box::new(layer_against(session.project(), path));
        renew(session, &layer.template, shared);
        match session.apply(vec![Edit::Once(Action::Add { index, layer })]) {
            Ok(changed) => self.stale |= changed,
            Err(why) => shared.notices.failed(why),
        }
    }

    /// Saves the project, asking for a name if it has none or another is wanted; true if it was saved.
    pub(super) fn save(&mut self, ask: bool, shared: &mut Shared<'_>) -> bool {
        self.end_renaming(shared);
        let Some(session) = &mut self.session else { return true };
        let mut saved = None;
        if let Some(path) = session.path.clone().filter(|_| !ask) {
            saved = save_unchanged(session, &path).map(|done| (path.clone(), done));
            if saved.is_none() {
                // The dialog asks before it replaces a file.
                let why = "another program has changed it. To replace that, choose it again.";
                shared.notices.warn(format!("{}: {why}", path.display()));
            }
        }
        let kinds: &[FileKind<'_>] = &[("Chladni project", &[PROJECT])];
        let saved = saved.or_else(|| {
            let suggested = session.beside(PROJECT);
            let path = ask_where_to_save(shared.chooser, kinds, &[PROJECT], &suggested)?;
            let done = alone(&path, || save_to(session, &path));
            Some((path, done))
        });
        let Some((path, done)) = saved else { return false };
        let far = source::far(&path, session.project());
        match done {
            Ok(()) => {
                shared.settings.remember(&path);
                shared.notices.done(format!("Saved {}", path.display()));
                far.into_iter().for_each(|far| shared.notices.warn(far));
                self.keep_picture(&path, shared);
                true
            }
            Err(why) => {
                shared.notices.failed(why);
                false
            }
        }
    }

    /// Keeps a picture of a shape that has no project yet; a project's picture is made when it is saved.
    pub(super) fn picture_new_shape(&self, shared: &mut Shared<'_>) {
        let Some(session) = self.session.as_ref().filter(|session| session.path.is_none()) else { return };
        if let Some(path) = session.project().shape.file() {
            self.keep_picture(path, shared);
        }
    }

    /// Keeps a picture of the result for the start screen.
    pub(super) fn keep_picture(&self, path: &Path, shared: &mut Shared<'_>) {
        let (Some(session), Some(stage)) = (&self.session, &self.stage) else { return };
        let (mut stack, project) = (session.stack.clone(), session.project().clone());
        let [width, height] = pictures::SIZE;
        let mut camera = Camera::on(session.stands(), View::ThreeQuarter);
        let empty = stage.shot_of(Pose::default(), stage.own_coat());
        shared.pictures.keep(&shared.ctx, path, move || {
            let result = in_turn(|| stack.evaluate(&project)).ok()?.result;
            let pose = (single(&result.positions), single(result.normals()));
            let aspect = width as f32 / height as f32;
            camera.fit(pose.0.iter().copied(), aspect, 0.9);
            Shot { camera, aspect, poses: vec![pose], ..empty }.picture(width, height).ok()
        });
    }

    pub(super) fn has_unsaved_work(&self) -> bool {
        // A project that was saved had layers worth keeping, also where all of them were removed since.
        let worth = |session: &Session| session.path.is_some() || !session.project().layers().is_empty();
        self.session.as_ref().is_some_and(|session| session.history.is_modified() && worth(session))
    }

    /// Asks what to do with unsaved work when another project is opened.
    pub(super) fn ask_to_replace(&mut self, shared: &mut Shared<'_>) {
        if self.candidate.is_none() {
            return;
        }
        // It may be saved by now, or another project may have taken its place.
        let answer = if self.has_unsaved_work() {
            let name = self.session.as_ref().map(Session::name).unwrap_or_default();
            let line = format!("“{name}” has changes that are not saved.");
            Question::OPENING.ask(&shared.ctx, &[line])
        } else {
            Some(Answer::Discard)
        };
        match answer {
            None => {}
            Some(Answer::Save) if !self.save(false, shared) => {}
            Some(Answer::Save | Answer::Discard) => {
                if let Some(candidate) = self.candidate.take() {
                    self.begin(candidate, &shared.ctx);
                }
            }
            Some(Answer::Stay) => self.candidate = None,
        }
    }

    /// Offers to recover work after a crash; true if the user accepts.
    pub(super) fn offer_recovery(&mut self, shared: &mut Shared<'_>) -> bool {
        let Some(recovered) = self.offer.show(shared) else { return false };
        let project = recovered.project.clone();
        let candidate = Candidate {
            path: recovered.original.clone(),
            on_disk: known_original(&recovered),
            recovered: Some(recovered),
            ..Candidate::new(project)
        };
        self.start(candidate, shared);
        true
    }

    /// Keeps a recovery copy of unsaved work.
    pub(super) fn keep_copy(&mut self, shared: &mut Shared<'_>) {
        let (Some(session), Some(folder)) = (&self.session, &shared.folders.recovery) else { return };
        if self.autosave.is_none() {
            match Autosave::start(folder) {
                Ok(autosave) => self.autosave = Some(Ok(autosave)),
                Err(why) => {
                    shared.notices.warn(format!("No recovery copy can be kept: {why}"));
                    self.autosave = Some(Err(()));
                }
            }
        }
        let Some(Ok(autosave)) = &mut self.autosave else { return };
        let now_secs = shared.ctx.input(|input| input.time);
        let error = match self.adopting.take() {
            Some(recovered) => autosave.adopt(recovered, &session.history, now_secs),
            None => autosave.tick(&session.history, session.path.as_deref(), now_secs),
        };
        if let Some(why) = error {
            shared.notices.warn(why);
        }
        if let Some(secs) = autosave.due_secs(&session.history, now_secs) {
            shared.ctx.request_repaint_after(Duration::from_secs_f64(secs + 0.05));
        }
    }
}

/// A sample; the head comes with a first layer, so that there is something to see.
fn sample(name: &str, shared: &mut Shared<'_>) -> Candidate {
    let mut project = Project::new(ShapeSource::Sample(name.into()), shared.settings.harmonics);
    if name == "head" {
        let template = Template::Sample("template".into());
        let first = Layer { mu: -0.8, ..project.new_layer("Character", template) };
        if let Err(error) = project.push(first) {
            shared.notices.failed(error);
        }
    }
    Candidate::new(project)
}

/// Whether the file at `path` is not the one of the hash `known`, which was read or written here last. Where it is gone
/// there is nothing to lose; one that cannot be read may be anything.
fn is_changed_elsewhere(path: &Path, known: Option<&str>) -> bool {
    let is_gone = path.metadata().is_err_and(|why| why.kind() == ErrorKind::NotFound);
    let now = file_hash(path);
    !is_gone && (now.is_none() || now.as_deref() != known)
}

/// The hash of the file of a recovered project; none where that was written after the copy, as by another program, or may have
/// been, as the copy is dated by a clock that was ahead.
fn known_original(recovered: &Recovered) -> Option<String> {
    let original = recovered.original.as_deref()?;
    let written = original.metadata().ok()?.modified().ok()?;
    let copied = recovered.modified?;
    if written <= copied && copied.elapsed().is_ok() { file_hash(original) } else { None }
}

/// Writes the project to `path`, where its own file is; `None` where another program has changed that.
fn save_unchanged(session: &mut Session, path: &Path) -> Option<Result<(), Error>> {
    alone(path, || {
        if is_changed_elsewhere(path, session.on_disk.as_deref()) {
            return None;
        }
        Some(save_to(session, path))
    })
}

/// Writes the project to `path`, whole or not at all.
fn save_to(session: &mut Session, path: &Path) -> Result<(), Error> {
    let text = session.project().to_text(path, None).map_err(Error::unsaved)?;
    let failed = |source| Error::unsaved(CaricatureError::Io { path: path.to_owned(), source });
    write_atomic(path, text.as_bytes()).map_err(failed)?;
    // The file's own hash could be that of what another program has written since.
    let written = blake3::hash(text.as_bytes()).to_hex().to_string();
    (session.path, session.on_disk) = (Some(PathBuf::from(path)), Some(written));
    session.history.mark_saved();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_cannot_be_read_counts_as_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.chladni");
        assert!(!is_changed_elsewhere(&path, Some("0")) && !is_changed_elsewhere(&path, None), "gone");
        std::fs::write(&path, "a project").unwrap();
        let known = file_hash(&path);
        assert_eq!(known, Some(blake3::hash(b"a project").to_hex().to_string()));
        assert!(!is_changed_elsewhere(&path, known.as_deref()) && is_changed_elsewhere(&path, Some("0")));
        // No content of a folder is read, whoever asks.
        for known in [None, Some("0")] {
            assert!(is_changed_elsewhere(folder.path(), known));
        }
    }

    #[test]
    fn a_file_that_was_written_after_the_recovery_copy_is_not_known() {
        let folder = tempfile::tempdir().unwrap();
        let original = folder.path().join("p.chladni");
        std::fs::write(&original, "by another program").unwrap();
        let written = original.metadata().unwrap().modified().unwrap() - Duration::from_secs(60);
        std::fs::File::options().write(true).open(&original).unwrap().set_modified(written).unwrap();
        let known = |copied| {
            known_original(&Recovered {
                copy: folder.path().join("copy.chladni"),
                original: Some(original.clone()),
                modified: Some(copied),
                project: Project::new(ShapeSource::Sample("head".into()), 8),
            })
        };
        assert_eq!(known(written + Duration::from_secs(1)), file_hash(&original));
        assert_eq!(known(written - Duration::from_secs(1)), None);
        assert_eq!(known(written + Duration::from_secs(1 << 25)), None, "the clock was ahead");
    }
}
