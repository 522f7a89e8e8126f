//! Whole parts of the shape as a region: the one under the pointer is shown, a click takes it.

use std::sync::Arc;

use chladni_caricature::{Action, LayerId, Limbs, PaintEdit};
use chladni_mesh::MirrorPlane;
use egui::{Modifiers, Slider, Ui};

use super::edits::Edits;
use super::stage::Press;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;

/// How parts are taken.
#[derive(Debug)]
pub struct LimbTool {
    /// Whether a click takes a part.
    pub active: bool,
    /// From 0 (whole limbs) to 1 (small features).
    pub level: f64,
    /// The parts under the pointer: one, or two that are mirror images.
    pointed: Vec<usize>,
}

impl Default for LimbTool {
    fn default() -> Self {
        Self { active: false, level: Limbs::USUAL_LEVEL, pointed: Vec::new() }
    }
}

impl LimbTool {
    /// Draws what turns it on.
    pub fn show_switch(&mut self, ui: &mut Ui) {
        theme::checkbox(ui, &mut self.active, "Parts").author_id("parts").on_hover_text(
            "A click takes the part under the pointer as the region; Shift adds it, Erase or Ctrl takes it away",
        );
    }

    /// Draws the level where it is on.
    pub fn show_level(&mut self, ui: &mut Ui) {
        if self.active {
            let tip = "From whole limbs (0) to small features (1)";
            theme::row(ui, "Level", tip, |ui| {
                ui.add(Slider::new(&mut self.level, 0.0..=1.0).fixed_decimals(2));
            });
        }
    }

    /// What is to be shown of `limbs`: 1 on the parts under the pointer.
    pub fn shown(&self, limbs: &Limbs) -> Vec<f32> {
        let value = |part: &u32| f32::from(u8::from(self.pointed.contains(&(*part as usize))));
        limbs.part.iter().map(value).collect()
    }

    /// Takes in what is under the pointer, with its mirror image in `plane`; true when that has changed.
    pub fn point(
        &mut self,
        press: Option<&Press>,
        triangles: &[[u32; 3]],
        limbs: &Limbs,
        plane: Option<MirrorPlane>,
    ) -> bool {
        let vertex = press.and_then(|press| {
            let corners = triangles.get(press.touch.triangle as usize)?;
            let nearest =
                (0..3).max_by(|a, b| press.touch.barycentric[*a].total_cmp(&press.touch.barycentric[*b]))?;
            Some(corners[nearest])
        });
        let part = vertex.and_then(|v| limbs.part.get(v as usize)).map(|part| *part as usize);
        let twin = part.zip(plane).and_then(|(part, plane)| limbs.twins(&plane).get(part).copied().flatten());
        let pointed: Vec<usize> = part.into_iter().chain(twin).collect();
        let changed = pointed != self.pointed;
        self.pointed = pointed;
        changed
    }

    /// Takes the part under the pointer: alone, or, with Shift, besides what is painted; `erase` takes it away.
    pub fn take(&self, limbs: &Limbs, layer: LayerId, erase: bool, modifiers: Modifiers, edits: &mut Edits) {
        if self.pointed.is_empty() {
            return;
        }
        let edit = PaintEdit::taking(&self.pointed, &limbs.part, modifiers.shift, erase);
        edits.once(Action::Paint { layer, edit });
    }
}

/// The parts that were found last.
#[derive(Debug, Default)]
pub struct KnownLimbs(Option<(f64, usize, Arc<Limbs>)>);

impl KnownLimbs {
    /// Those of `body` at `level`, searched again only where one of the two has changed.
    pub fn of(&mut self, body: &chladni_harmonics::Body, level: f64) -> Arc<Limbs> {
        let harmonics = body.basis.harmonics();
        if let Some((known, with, limbs)) = &self.0
            && (*known, *with) == (level, harmonics)
        {
            return Arc::clone(limbs);
        }
        let limbs = Arc::new(Limbs::of(body, level));
        self.0 = Some((level, harmonics, Arc::clone(&limbs)));
        limbs
    }
}

#[cfg(test)]
mod tests {
    use super::super::edits::Edit;
    use super::*;
    use chladni_caricature::{Dab, Layer, Limb, Painted, Project, ShapeSource, Template};

    #[test]
    fn a_click_takes_a_part_alone_shift_adds_it_and_erasing_takes_it_away() {
        let part = Limb { share: 0.5, persistence: 1.0, middle: [0.0; 3] };
        let limbs = Limbs { part: vec![0, 1, 1, 0], parts: vec![part; 2] };
        let mut project = Project::new(ShapeSource::Sample("head".into()), 4);
        let layer = project.push(Layer::new("a layer", Template::Ellipsoid)).unwrap();
        let taken = |pointed: &[usize], erase: bool, modifiers: Modifiers| {
            let tool = LimbTool { pointed: pointed.to_vec(), ..LimbTool::default() };
            let mut edits = Edits::default();
            tool.take(&limbs, layer, erase, modifiers, &mut edits);
            edits.take().pop().map(|edit| match edit {
                Edit::Once(Action::Paint { edit, .. }) => edit,
                other => panic!("{other:?}"),
            })
        };
        let alone = PaintEdit::Set(Painted::Vertices([0.0, 1.0, 1.0, 0.0].into()));
        assert_eq!(taken(&[1], false, Modifiers::NONE), Some(alone));
        let dab = |erase: bool| Some(PaintEdit::Dab(Dab::even(vec![1, 2], 1.0, erase)));
        assert_eq!(taken(&[1], false, Modifiers::SHIFT), dab(false));
        assert_eq!(taken(&[1], true, Modifiers::NONE), dab(true));
        assert_eq!(taken(&[], false, Modifiers::NONE), None);
        let tool = LimbTool { pointed: vec![0], ..LimbTool::default() };
        assert_eq!(tool.shown(&limbs), [1.0, 0.0, 0.0, 1.0]);
    }
}
