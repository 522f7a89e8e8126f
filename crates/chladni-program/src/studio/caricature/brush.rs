//! The brush that paints a layer's region.

use chladni_caricature::{Action, Dab, LayerId, Limbs, PaintEdit};
use chladni_mesh::MirrorPlane;
use egui::{RichText, Ui};

use super::edits::Edits;
use super::lasso::LassoTool;
use super::limb_tool::LimbTool;
use super::stage::{BrushInHand, Press};
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::caricature::{BRUSH, ERASE};
use crate::studio::theme;

/// How the brush paints.
#[derive(Debug)]
pub struct BrushTool {
    /// Whether dragging on the shape paints.
    pub active: bool,
    /// Radius along the surface, working frame.
    pub radius: f32,
    /// The share of the radius that is painted in full, in [0, 1]; beyond it the brush fades out.
    pub hardness: f32,
    /// In [0, 1].
    pub intensity: f32,
    /// Paint away instead of on.
    pub erase: bool,
    /// Paint the mirrored place too.
    pub mirror: bool,
    /// A click fills everything connected.
    pub fill: bool,
    /// While painting, show the region as it acts instead of as painted.
    pub smoothed: bool,
    /// Takes whole parts in place of dabs.
    pub limbs: LimbTool,
    /// Takes the part inside a drawn line in place of dabs.
    pub lasso: LassoTool,
}

impl Default for BrushTool {
    fn default() -> Self {
        Self {
            active: false,
            radius: 0.15,
            hardness: 1.0,
            intensity: 1.0,
            erase: false,
            mirror: false,
            fill: false,
            smoothed: false,
            limbs: LimbTool::default(),
            lasso: LassoTool::default(),
        }
    }
}

impl BrushTool {
    /// Makes the brush `factor` times as wide.
    pub fn resize(&mut self, factor: f32) {
        self.radius = (self.radius * factor).clamp(0.005, 1.5);
    }

    /// Whether what it paints is a whole, on which size and hardness have no effect: a piece, a part, or what is drawn around.
    pub fn takes_wholes(&self) -> bool {
        self.fill || self.limbs.active || self.lasso.active
    }

    /// Draws the brush's controls. `plane` is the shape's own mirror, once it was looked for.
    pub fn show(&mut self, ui: &mut Ui, plane: Option<Option<MirrorPlane>>) {
        ui.horizontal(|ui| {
            let name = if self.active { "Painting" } else { "Paint" };
            ui.toggle_value(&mut self.active, icon::label(Icon::Brush, name))
                .on_hover_text(BRUSH.tooltip(ui.ctx()));
            if self.active {
                ui.toggle_value(&mut self.erase, icon::label(Icon::Eraser, "Erase"))
                    .on_hover_text(ERASE.tooltip(ui.ctx()));
                ui.toggle_value(&mut self.smoothed, "Smoothed")
                    .on_hover_text("Show the region as it acts, after smoothing, instead of as painted");
            } else {
                theme::weak(ui, "on the shape to confine the layer");
            }
        });
        if !self.active {
            return;
        }
        ui.add_enabled_ui(!self.takes_wholes(), |ui| {
            theme::row(
                ui,
                "Size",
                "Radius along the surface as it is seen, as a share of the shape; [ and ] change it",
                |ui| {
                    ui.add(theme::slider(&mut self.radius, 0.005..=1.5).logarithmic(true).fixed_decimals(3));
                },
            );
            let tip = "How much of the size is painted in full, beyond which it fades out: 1 has a hard edge";
            theme::row(ui, "Hardness", tip, |ui| {
                ui.add(theme::slider(&mut self.hardness, 0.0..=1.0).fixed_decimals(2));
            });
        });
        theme::row(ui, "Intensity", "How much of the layer acts where you paint", |ui| {
            ui.add(theme::slider(&mut self.intensity, 0.0..=1.0).fixed_decimals(2));
        });
        let before = [self.fill, self.limbs.active, self.lasso.active];
        ui.horizontal(|ui| {
            theme::checkbox(ui, &mut self.mirror, "Mirror")
                .author_id("mirror")
                .on_hover_text("Paint both sides of the shape at once");
            theme::checkbox(ui, &mut self.fill, "Fill")
                .author_id("fill")
                .on_hover_text("A click fills everything that is connected");
            self.limbs.show_switch(ui);
            self.lasso.show_switch(ui);
        });
        let now = [self.fill, self.limbs.active, self.lasso.active];
        [self.fill, self.limbs.active, self.lasso.active] = one_way(before, now);
        self.limbs.show_level(ui);
        if self.mirror {
            show_mirror(ui, plane);
        }
    }

    /// Turns a drag on the shape with the brush in `hand` into dabs of the vertices that the ring enclosed, or, where there
    /// are `limbs`, a click into a part.
    pub fn paint(
        &mut self,
        ui: &Ui,
        response: &egui::Response,
        (presses, hand): (&[Press], BrushInHand<'_>),
        layer: LayerId,
        limbs: Option<&Limbs>,
        edits: &mut Edits,
    ) {
        let modifiers = ui.input(|input| input.modifiers);
        if modifiers.alt {
            return; // Alt and drag turns the view.
        }
        let primary = egui::PointerButton::Primary;
        if self.limbs.active {
            if let Some(limbs) = limbs.filter(|_| response.clicked_by(primary)) {
                let erase = self.erase ^ modifiers.ctrl;
                let taken = self.limbs.taken(limbs, erase, self.intensity, modifiers);
                taken.into_iter().for_each(|edit| edits.once(Action::Paint { layer, edit }));
            }
            return;
        }
        let pressed = response.dragged_by(primary) || response.clicked_by(primary);
        for press in presses.iter().filter(|_| pressed) {
            let erase = self.erase ^ modifiers.ctrl;
            let mut paint = |edit| edits.live(Action::Paint { layer, edit });
            if self.fill {
                let intensity = if erase { 0.0 } else { self.intensity };
                let at = press.touch.on_surface();
                PaintEdit::fills(&hand.brush, at, hand.surface, intensity).for_each(paint);
            } else {
                paint(PaintEdit::Dab(Dab::of(&press.reach, self.intensity, erase)));
            }
        }
        if response.drag_stopped() || response.clicked_by(primary) {
            edits.finish();
        }
    }
}

/// Of ways to work that exclude each other, the one that was switched on last.
pub fn one_way(before: [bool; 3], now: [bool; 3]) -> [bool; 3] {
    match (0..3).find(|way| now[*way] && !before[*way]) {
        Some(on) => std::array::from_fn(|way| way == on),
        None => now,
    }
}

/// How well the shape's mirror plane fits.
fn show_mirror(ui: &mut Ui, plane: Option<Option<MirrorPlane>>) {
    let palette = theme::palette(ui);
    let (text, color) = match plane {
        None => ("Looking for the mirror plane…".to_owned(), palette.weak),
        Some(None) => ("The shape has no extent to mirror".to_owned(), palette.warning),
        Some(Some(plane)) => {
            let share = 100.0 * plane.misfit;
            let good = plane.fits();
            let text = if good {
                format!("Its mirror image misses the shape by {share:.1} %")
            } else {
                format!("Not symmetric: its mirror image misses by {share:.1} %")
            };
            (text, if good { palette.weak } else { palette.warning })
        }
    };
    let tip = "The plane in which the shape comes closest to its own mirror image, and how far mirrored \
               vertices then miss the surface: root mean square of the best nine tenths, as a share of the \
               bounding box's diagonal";
    ui.label(RichText::new(text).color(color).small()).on_hover_text(tip);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fill_parts_and_lasso_exclude_each_other() {
        let [fill, parts, lasso] = [[true, false, false], [false, true, false], [false, false, true]];
        assert_eq!(one_way(parts, [false, true, true]), lasso);
        assert_eq!(one_way(lasso, [true, false, true]), fill);
        assert_eq!(one_way(fill, [true, true, false]), parts);
        assert_eq!(one_way(fill, [false; 3]), [false; 3]);
        assert_eq!(one_way(lasso, lasso), lasso);
    }
}
