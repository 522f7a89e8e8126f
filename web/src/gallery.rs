//! Twelve caricatures of a shape, computed in a worker and shown by the page.

use std::path::Path;
use std::sync::Arc;

use chladni_caricature::{Group, Layer, MatchRequest, Matched, Project, Stack, surprise};
use chladni_harmonics::Body;
use chladni_program::work::{Exhibition, FIRST_SEED, Step};
use js_sys::Function;
use serde::Serialize;
use wasm_bindgen::prelude::*;

use crate::reporter::{Reporter, shape};
use crate::{PROJECT, solve};

/// A gallery in the hands of a page.
#[wasm_bindgen]
pub struct Wall {
    shown: Exhibition,
    /// The seed of the gallery that was begun last.
    seed: u64,
}

/// One caricature of the twelve.
#[derive(Serialize)]
struct Item {
    name: String,
    chosen: bool,
    favorite: bool,
}

#[derive(Serialize)]
struct State {
    items: Vec<Item>,
    chosen: usize,
    /// They have no parents.
    first: bool,
    /// Groups of numbers, and whether children inherit each unchanged.
    groups: Vec<(&'static str, bool)>,
    /// The favorites' effects in words, in the order in which they were marked.
    favorites: Vec<String>,
}

#[wasm_bindgen]
impl Wall {
    /// The first twelve of a shape (`sample:NAME`, or a file called `name` whose content is `bytes`) with these harmonics,
    /// compared as the `project` compares it. `matches` are those that [`Sitting::matches`](crate::Sitting::matches) knows.
    ///
    /// # Errors
    /// Files that cannot be read or matched.
    #[wasm_bindgen(constructor)]
    pub fn new(
        name: &str,
        bytes: Option<Vec<u8>>,
        basis: &[u8],
        project: &str,
        matches: &str,
        report: &Function,
    ) -> Result<Self, JsError> {
        let watcher = Reporter::new(report);
        let mesh = shape(name, bytes.as_deref(), &watcher)?;
        let mut stack = Stack::new(Arc::new(Body::of_basis(&mesh, solve::from_bytes(basis)?)?))?;
        let matches: Vec<(MatchRequest, Matched)> = serde_json::from_str(matches)?;
        for (request, found) in matches {
            stack.install(request, Ok(found));
        }
        let (project, _) = Project::from_text(project, Path::new(PROJECT))?;
        // Only the page knows the content of a file: here there is only its match.
        let given = Exhibition::template_of(&project).filter(|(template, matching)| {
            let request = MatchRequest { template: template.clone(), matching: matching.clone() };
            stack.matched(&request).is_some()
        });
        let shown = Exhibition::open(None, &mesh, &mut stack, given, &watcher)?;
        Ok(Self { shown, seed: FIRST_SEED })
    }

    /// Does a step: `breed`, `back`, or `others`.
    ///
    /// # Errors
    /// Another name, and nothing to breed from.
    pub fn step(&mut self, name: &str) -> Result<(), JsError> {
        let step = match name {
            "breed" => Step::Breed,
            "back" => Step::Back,
            "others" => {
                self.seed += 1;
                Step::Restart(self.seed)
            }
            _ => return Err(JsError::new("there is no such step")),
        };
        self.shown = self.shown.clone().after(step)?;
        Ok(())
    }

    /// Chooses one as a parent, or no longer.
    ///
    /// # Errors
    /// A number beyond the last.
    pub fn choose(&mut self, item: usize, on: bool) -> Result<(), JsError> {
        Ok(self.shown.gallery.choose(item, on)?)
    }

    /// Marks one as a favorite, which stays at hand whatever is bred, or no longer.
    ///
    /// # Errors
    /// A number beyond the last.
    pub fn favor(&mut self, item: usize, on: bool) -> Result<(), JsError> {
        Ok(self.shown.gallery.favor(item, on)?)
    }

    /// From now on children have a group of numbers unchanged from one parent, or no longer.
    ///
    /// # Errors
    /// A name that no group has.
    pub fn lock(&mut self, group: &str, on: bool) -> Result<(), JsError> {
        let found = Group::ALL.into_iter().find(|known| known.name() == group);
        self.shown.gallery.lock(found.ok_or_else(|| JsError::new("there is no such group"))?, on);
        Ok(())
    }

    /// The layers of one, as JSON, for [`Sitting::hang`](crate::Sitting::hang).
    ///
    /// # Errors
    /// A number beyond the last.
    pub fn layers(&self, item: usize) -> Result<String, JsError> {
        let found = self.shown.portraits.get(item);
        written(&found.ok_or_else(|| JsError::new("there is no such caricature"))?.layers)
    }

    /// Those of a favorite, by its number among them.
    ///
    /// # Errors
    /// A number beyond the last.
    pub fn favorite(&self, number: usize) -> Result<String, JsError> {
        let Exhibition { sitter, gallery, .. } = &self.shown;
        let found = gallery.favorites().get(number);
        let variant = &found.ok_or_else(|| JsError::new("there is no such favorite"))?.genome;
        written(&sitter.portray_one(variant)?.layers)
    }

    /// Those of a random good one, another for each `number`: the page counts them, as it opens a gallery anew after each.
    ///
    /// # Errors
    /// Bugs only.
    pub fn surprise(&self, number: u32) -> Result<String, JsError> {
        // Far from the seeds of galleries.
        let (_, portrait) = surprise(self.seed ^ (u64::from(number) << 32), &self.shown.sitter)?;
        written(&portrait.layers)
    }

    /// All that the page shows beside the picture, as JSON.
    ///
    /// # Errors
    /// Bugs only.
    pub fn state(&self) -> Result<String, JsError> {
        let Exhibition { sitter, gallery, .. } = &self.shown;
        let items = gallery.generations().items().iter().map(|item| Item {
            name: sitter.title(&item.genome),
            chosen: item.chosen,
            favorite: gallery.is_favorite(item.id),
        });
        let (chosen, first) = self.shown.chosen();
        let groups = Group::ALL.map(|group| (group.name(), gallery.is_locked(group))).to_vec();
        let favorites = gallery.favorites().iter().map(|item| sitter.title(&item.genome)).collect();
        Ok(serde_json::to_string(&State { items: items.collect(), chosen, first, groups, favorites })?)
    }

    /// The coordinates of all vertices of all twelve, one after the other.
    pub fn positions(&self) -> Vec<f32> {
        self.shown.portraits.iter().flat_map(|portrait| portrait.positions.as_flattened()).copied().collect()
    }
}

fn written(layers: &[Layer]) -> Result<String, JsError> {
    Ok(serde_json::to_string(layers)?)
}
