//! Twelve caricatures of one shape, to be chosen from and bred, as the window and the page show them.

use std::sync::Arc;

use chladni_caricature::{
    Action, Layer, Portrait, Project, Property, Sitter, Stack, Template, VariantGallery,
};
use chladni_match::MatchSettings;
use chladni_mesh::TriMesh;

use super::{Error, Watcher, sitter};

/// The seed of the first gallery; each further one has the next.
pub const FIRST_SEED: u64 = 1;

/// The gallery of a sitter, and what its variants look like.
#[derive(Clone)]
pub struct Exhibition {
    /// The shape with its parts and templates.
    pub sitter: Arc<Sitter>,
    /// Its generations.
    pub gallery: VariantGallery,
    /// Those that are shown.
    pub portraits: Vec<Portrait>,
}

/// A step that changes a gallery.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// Children of those that are chosen.
    Breed,
    /// The parents of those that are shown.
    Back,
    /// Twelve others, of this seed.
    Restart(u64),
    /// One is changed a little.
    Change(usize),
}

impl Exhibition {
    /// The template of the topmost layer that is compared with a mesh.
    pub fn template_of(project: &Project) -> Option<(Template, MatchSettings)> {
        let mut layers = project.layers().iter().rev();
        let (_, layer) = layers.find(|(_, layer)| layer.template.is_mesh())?;
        Some((layer.template.clone(), layer.matching.clone()))
    }

    /// The gallery of a shape, as [`sitter()`] prepares it: with the generations and favorites of the one `before`, where
    /// that has the same parts and templates on other harmonics, otherwise with its first twelve.
    ///
    /// # Errors
    /// As [`sitter()`].
    pub fn open(
        before: Option<&Self>,
        mesh: &TriMesh,
        stack: &mut Stack,
        given: Option<(Template, MatchSettings)>,
        watcher: &impl Watcher,
    ) -> Result<Self, Error> {
        let sitter = Arc::new(sitter(mesh, stack, given, watcher)?);
        let gallery = match before {
            Some(before) if sitter.understands(&before.sitter) => before.gallery.clone(),
            _ => VariantGallery::new(FIRST_SEED, &sitter)?,
        };
        let portraits = sitter.portray(&gallery.variants())?;
        Ok(Self { sitter, gallery, portraits })
    }

    /// The same after a step.
    ///
    /// # Errors
    /// Errors of the gallery.
    pub fn after(mut self, step: Step) -> Result<Self, Error> {
        match step {
            Step::Breed => self.gallery.breed(&self.sitter)?,
            Step::Back => {
                self.gallery.back();
            }
            Step::Restart(seed) => self.gallery.restart(seed, &self.sitter)?,
            Step::Change(index) => self.gallery.mutate(index, &self.sitter)?,
        }
        self.portraits = self.sitter.portray(&self.gallery.variants())?;
        Ok(self)
    }

    /// How many of those that are shown are chosen, and whether they have no parents.
    pub fn chosen(&self) -> (usize, bool) {
        let generations = self.gallery.generations();
        let chosen = generations.items().iter().filter(|item| item.chosen).count();
        (chosen, generations.generations()[generations.current()].from.is_none())
    }
}

/// Actions that put `layers` on top of a project and hide those that are there: the gallery shows its variants
/// without them.
pub fn hung(project: &Project, layers: Vec<Layer>) -> Vec<Action> {
    let seen = || project.layers().iter().filter(|(_, layer)| layer.enabled);
    let hide = seen().map(|(id, _)| Action::Set { layer: *id, to: Property::Enabled(false) });
    let alone = project.layers().iter().filter(|(_, layer)| layer.solo);
    let alone = alone.map(|(id, _)| Action::Set { layer: *id, to: Property::Solo(false) });
    let top = project.layers().len();
    let add = |(i, layer)| Action::Add { index: top + i, layer: Box::new(layer) };
    hide.chain(alone).chain(layers.into_iter().enumerate().map(add)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::Aside;
    use chladni_caricature::GALLERY_SIZE;
    use chladni_harmonics::{BasisSettings, Body};
    use chladni_match::Landmark;
    use chladni_task::Task;

    #[test]
    fn what_is_taken_is_seen_alone_and_what_was_there_is_hidden() {
        use chladni_caricature::History;

        let mut project = Project::new(chladni_mesh::ShapeSource::Sample("head".into()), 20);
        project.push(Layer { solo: true, ..Layer::new("below", Template::Sphere) }).unwrap();
        let mut history = History::new(project);
        for action in hung(history.project(), vec![Layer::new("taken", Template::Ellipsoid)]) {
            history.apply(&action, None).unwrap();
        }
        let project = history.project();
        let acts: Vec<_> = project.layers().iter().map(|(_, l)| (l.name.as_str(), project.acts(l))).collect();
        assert_eq!(acts, [("below", false), ("taken", true)]);
    }

    #[test]
    fn those_that_are_chosen_have_children_and_the_parents_come_back() {
        let (mesh, task) = (chladni_mesh::samples::icosphere(3), Task::new());
        let body = Body::build(&mesh, &BasisSettings::new(20), &task).unwrap();
        let mut stack = Stack::new(Arc::new(body)).unwrap();
        let mut first = Exhibition::open(None, &mesh, &mut stack, None, &Aside::new(&task)).unwrap();
        assert_eq!((first.portraits.len(), first.chosen()), (GALLERY_SIZE, (0, true)));
        assert!(first.clone().after(Step::Breed).is_err());
        first.gallery.choose(2, true).unwrap();
        let children = first.clone().after(Step::Breed).unwrap();
        assert!(!children.chosen().1);
        assert_ne!(children.portraits[0].positions, first.portraits[0].positions);
        let back = children.after(Step::Back).unwrap();
        assert_eq!(back.portraits[0].positions, first.portraits[0].positions);
    }

    #[test]
    fn generations_and_favorites_outlive_other_harmonics_but_not_another_template() {
        let (mesh, task) = (chladni_mesh::samples::icosphere(3), Task::new());
        let body = |k: usize| Arc::new(Body::build(&mesh, &BasisSettings::new(k), &task).unwrap());
        let mut stack = Stack::new(body(40)).unwrap();
        let mut first = Exhibition::open(None, &mesh, &mut stack, None, &Aside::new(&task)).unwrap();
        first.gallery.choose(2, true).unwrap();
        first.gallery.favor(3, true).unwrap();
        let bred = first.after(Step::Breed).unwrap();
        let mut finer = stack.with_harmonics_of(body(60)).unwrap();
        let again = Exhibition::open(Some(&bred), &mesh, &mut finer, None, &Aside::new(&task)).unwrap();
        assert_eq!(again.gallery, bred.gallery);
        assert_eq!(again.sitter.body().basis.harmonics(), 60);
        let other = Some((Template::Sphere, MatchSettings::default()));
        let other = Exhibition::open(Some(&bred), &mesh, &mut finer, other, &Aside::new(&task)).unwrap();
        assert!(other.chosen().1 && other.gallery.favorites().is_empty());
        let compares = |shown: &Exhibition, matching: &MatchSettings| {
            shown.sitter.compares_with(&Template::Sphere, matching)
        };
        let matching = MatchSettings::default();
        assert!(compares(&other, &matching) && !compares(&bred, &matching));
        let landmarks = vec![Landmark { shape: 0, template: 0 }];
        assert!(!compares(&other, &MatchSettings { landmarks, ..matching }));
    }
}
