//! Files of templates: one that was written again is read again where it is chosen again.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use chladni_caricature::{Action, LayerId, Property, Template};
use chladni_match::MatchSettings;

use super::super::edits::Edit;
use super::Session;
use crate::work::{Error, template_name};

/// The length of a file, and when it was written.
type Stamp = (u64, SystemTime);

/// Files of templates as they were when they were first matched; `None` where they were not there.
#[derive(Default)]
pub struct MatchedFiles {
    stamps: HashMap<PathBuf, Option<Stamp>>,
    /// How many times one of them was found to be another.
    renewals: usize,
}

/// What has become of a file since it was matched.
enum Fate {
    /// Nothing, or it was not matched.
    Same,
    /// It was not there, and is now.
    Come,
    /// It is another.
    Other,
}

impl MatchedFiles {
    /// A match with this template begins.
    pub fn note(&mut self, template: &Template) {
        if let Some(path) = template.file() {
            let noted = self.stamps.entry(path.to_owned()).or_default();
            *noted = noted.or_else(|| stamp(path));
        }
    }

    /// The next match with this template is the first one.
    pub fn forget(&mut self, template: &Template) {
        if let Some(path) = template.file() {
            self.stamps.remove(path);
        }
    }

    /// Notes the file of a template that was matched as it is now.
    fn renew(&mut self, template: &Template) -> Fate {
        let Some(path) = template.file() else { return Fate::Same };
        let (Some(now), Some(noted)) = (stamp(path), self.stamps.get_mut(path)) else { return Fate::Same };
        let fate = match noted.replace(now) {
            None => Fate::Come,
            Some(before) if before != now => Fate::Other,
            Some(_) => return Fate::Same,
        };
        self.renewals += 1;
        fate
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let about = path.metadata().ok()?;
    Some((about.len(), about.modified().ok()?))
}

impl Session {
    /// Takes in that a template is chosen. Where its file is another than the one that was matched, matches with that one are
    /// forgotten, and the landmarks, which are vertices of it, go where one had succeeded. Returns what the user should know
    /// of this.
    pub fn renew(&mut self, template: &Template) -> Result<Option<String>, Error> {
        let fate = self.files.renew(template);
        if matches!(fate, Fate::Same) {
            return Ok(None);
        }
        // Landmarks are vertices of a file that was matched.
        let was_matched = self.stack.is_matched_with(template);
        self.stack.forget_template(template);
        self.matching.take_if(|(request, _)| request.template == *template);
        self.refresh();
        let layers = self.project().layers().iter();
        let compared = layers.filter(|(_, layer)| layer.template == *template);
        let compared: Vec<(LayerId, MatchSettings)> =
            compared.map(|(id, layer)| (*id, layer.matching.clone())).collect();
        if matches!(fate, Fate::Come) || !was_matched || compared.is_empty() {
            return Ok(None);
        }
        let marked = compared.into_iter().filter(|(_, matching)| !matching.landmarks.is_empty());
        let bare = |(layer, matching): (LayerId, MatchSettings)| {
            let matching = MatchSettings { landmarks: Vec::new(), ..matching };
            Action::Set { layer, to: Property::Matching(matching) }
        };
        let actions: Vec<Action> = marked.map(bare).collect();
        let without = if actions.is_empty() { "" } else { ", without their landmarks" };
        self.apply(vec![Edit::Together(actions)])?;
        let name = template_name(template, self.project());
        Ok(Some(format!(
            "{name} is another file now: the layers that are compared with it are matched anew{without}."
        )))
    }

    /// Another number where a template's file was found to be another: what was made with that is outdated.
    pub fn renewals(&self) -> usize {
        self.files.renewals
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::loading::{Candidate, load};
    use super::*;
    use crate::work::{Aside, matched};
    use chladni_caricature::{CaricatureError, Layer, MatchRequest, Matched, Project, ShapeSource};
    use chladni_match::Landmark;
    use chladni_mesh::{samples::icosphere, save_mesh};
    use chladni_task::Task;
    use std::sync::mpsc::channel;

    /// An open project whose layer has a landmark on `template.ply`.
    fn marked(folder: &Path) -> (Session, MatchRequest, PathBuf) {
        let [shape, file] = ["shape.ply", "template.ply"].map(|name| folder.join(name));
        for path in [&shape, &file] {
            save_mesh(&icosphere(1), path).unwrap();
        }
        let mut layer = Layer { mu: 0.5, ..Layer::new("layer", Template::File(file.clone())) };
        layer.matching.landmarks = vec![Landmark { shape: 1, template: 1 }];
        let request = MatchRequest::of(&layer).unwrap();
        let mut project = Project::new(ShapeSource::File(shape), 4);
        project.push(layer).unwrap();
        let loaded = load(Candidate::new(project), &channel().0, &Task::new()).unwrap();
        (Session::new(loaded), request, file)
    }

    /// Any match of the shape.
    fn found(session: &Session) -> Matched {
        let request = MatchRequest::of(&Layer::new("sphere", Template::Sphere)).unwrap();
        matched(&request, &session.subject.mesh, session.stack.body(), &Aside::new(&Task::new())).unwrap()
    }

    /// As [`marked`], with a match that failed and a file that was written again since.
    fn broken_and_mended(folder: &Path) -> (Session, MatchRequest) {
        let (mut session, request, file) = marked(folder);
        session.files.note(&request.template);
        session.stack.install(request.clone(), Err(CaricatureError::Elsewhere("broken".into())));
        save_mesh(&icosphere(2), &file).unwrap();
        (session, request)
    }

    #[test]
    fn a_file_that_is_mended_and_chosen_again_keeps_its_landmarks() {
        let folder = tempfile::tempdir().unwrap();
        let (mut session, request) = broken_and_mended(folder.path());
        assert_eq!((session.renew(&request.template).unwrap(), session.renewals()), (None, 1));
        assert_eq!(session.stack.missing(session.project()), [request]);
    }

    #[test]
    fn a_file_that_is_mended_and_tried_again_keeps_its_landmarks() {
        let folder = tempfile::tempdir().unwrap();
        let (mut session, request) = broken_and_mended(folder.path());
        session.retry_match();
        assert_eq!(session.stack.missing(session.project()), std::slice::from_ref(&request));
        session.files.note(&request.template);
        assert_eq!((session.renew(&request.template).unwrap(), session.renewals()), (None, 0));
        assert_eq!(session.stack.missing(session.project()), [request]);
    }

    #[test]
    fn a_template_that_was_written_again_is_matched_anew_without_landmarks_where_it_is_chosen_again() {
        let folder = tempfile::tempdir().unwrap();
        let (mut session, request, file) = marked(folder.path());
        let template = request.template.clone();
        assert_eq!(session.renew(&template).unwrap(), None, "never matched");
        session.files.note(&template);
        let as_it_was = found(&session);
        session.stack.install(request.clone(), Ok(as_it_was));
        assert_eq!(session.renew(&template).unwrap(), None);
        assert!(session.stack.missing(session.project()).is_empty());

        save_mesh(&icosphere(2), &file).unwrap();
        // Another match with it, by itself, is no reason to keep the one before.
        session.files.note(&template);
        let said = session.renew(&template).unwrap().unwrap();
        assert!(said.contains("template.ply") && said.contains("without their landmarks"), "{said}");
        assert!(session.stack.missing(session.project())[0].matching.landmarks.is_empty());
        assert!(session.travel(true).is_some());
        assert_eq!(session.stack.missing(session.project()), [request]);
        assert_eq!((session.renew(&template).unwrap(), session.renewals()), (None, 1));

        // One that was not there when it was to be matched has the landmarks that it had.
        let moved = folder.path().join("moved.ply");
        let template = Template::File(moved.clone());
        session.files.note(&template);
        std::fs::rename(&file, &moved).unwrap();
        assert_eq!((session.renew(&template).unwrap(), session.renewals()), (None, 2));
    }
}
