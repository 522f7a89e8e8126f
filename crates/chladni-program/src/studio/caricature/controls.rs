//! The controls of one layer: model, μ, region, scale curve.

use chladni_caricature::{
    Action, Layer, LayerId, Model, PaintEdit, Painted, Property, RollOff, ScaleCurve, Smoothing,
};
use chladni_mesh::MirrorPlane;
use egui::{RichText, Slider, Ui};

use super::brush::BrushTool;
use super::crossings;
use super::curve::{self, Pen};
use super::edits::Edits;
use super::footer::grouped;
use super::mask_menu::{MaskMenu, MaskWish};
use super::named_parts::NamedParts;
use super::session::Held;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::caricature::{FURTHEST, INVERT, NEXT_MODEL, STRONGER, WEAKER};
use crate::studio::theme;
use crate::work::scale_plot::Spectrum;
use crate::work::{MAY_FOLD, Quantity};

/// Measurements that the panel shows beside the layer's own numbers.
pub struct Measured<'a> {
    /// The spectrum that the model exaggerates; empty until the match is there.
    pub spectrum: &'a Spectrum,
    /// The shape's own mirror plane, once it was looked for.
    pub mirror: Option<Option<MirrorPlane>>,
    /// Triangles folded by this layer; `None` where it could not be matched and does nothing.
    pub folds: Option<usize>,
    /// The layer does nothing yet: its match is still to come.
    pub waits: bool,
    /// Triangles of the whole result that pass through others; `None` until they are counted.
    pub crossings: Option<crossings::Count>,
    /// How far the layer is held back, where the project keeps triangles.
    pub kept: Option<Held>,
    /// The names of the mesh's own numbers, which a region can be.
    pub channels: &'a [String],
}

/// Requests of the panel besides edits of the layer.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish {
    /// Move μ to the last value with no more folds than it may have.
    AsFarAsItGoes,
    /// Show on the shape, or stop showing.
    SeeWhere(Quantity),
    /// A region from elsewhere, or to elsewhere.
    Mask(MaskWish),
}

/// State of the panel itself.
pub struct Controls {
    pen: Pen,
    /// How many triangles may fold where μ goes as far as it goes, in percent.
    may_fold_percent: f64,
    masks: MaskMenu,
    /// The parts of a head.
    pub named: NamedParts,
}

impl Default for Controls {
    fn default() -> Self {
        Self {
            pen: Pen::default(),
            may_fold_percent: 100.0 * MAY_FOLD,
            masks: MaskMenu::default(),
            named: NamedParts::default(),
        }
    }
}

impl Controls {
    /// The share of the triangles that may fold where μ goes as far as it goes.
    pub fn may_fold(&self) -> f64 {
        self.may_fold_percent / 100.0
    }

    /// Draws the controls of `layer`.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        id: LayerId,
        layer: &Layer,
        measured: &Measured<'_>,
        brush: &mut BrushTool,
        edits: &mut Edits,
    ) -> Option<Wish> {
        ui.add_space(theme::GAP);
        theme::heading(ui, "Model");
        theme::group(ui, "Model", |ui| model_buttons(ui, id, layer, edits));
        let wish = theme::section(ui, "Amount", |ui| {
            amount(ui, id, layer, measured, &mut self.may_fold_percent, edits)
        });
        let mask = theme::section(ui, "Region", |ui| {
            region(ui, id, layer, edits);
            let mask = ui
                .horizontal(|ui| {
                    let mask = self.masks.show(ui, measured.channels);
                    self.named.show_switch(ui);
                    mask
                })
                .inner;
            self.named.show(ui, id, layer, brush.active && brush.erase, edits);
            brush.show(ui, measured.mirror);
            mask
        });
        theme::section(ui, "Scale", |ui| self.scale(ui, id, layer, measured.spectrum, edits));
        mask.map(Wish::Mask).or(wish)
    }

    fn scale(&mut self, ui: &mut Ui, id: LayerId, layer: &Layer, spectrum: &Spectrum, edits: &mut Edits) {
        ui.horizontal(|ui| {
            // All in one row, also beside a scroll bar.
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.spacing_mut().button_padding.x = 6.0;
            let presets = [
                ("all", "Every scale alike", ScaleCurve::flat(1.0)),
                (
                    "smooth",
                    "All but the finest, below a quarter of its size, where a match of two meshes is rough",
                    ScaleCurve::smooth(),
                ),
                ("broad", "Large forms only: waves of more than half of its size", ScaleCurve::broad()),
                ("mid", "Features of the size of a nose: waves of half of its size", ScaleCurve::mid()),
                ("fine", "Wrinkles and edges: waves below a quarter of its size", ScaleCurve::fine()),
            ];
            for (name, tip, preset) in presets {
                let chosen = layer.curve == preset;
                let button = ui.selectable_label(chosen, theme::capitalized(name)).on_hover_text(tip);
                if button.author_id(format!("curve/{name}")).clicked() {
                    edits.set(id, Property::Curve(preset));
                }
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                for (pen, mark, tip) in
                    [(Pen::Free, Icon::Pencil, "Draw freely"), (Pen::Points, Icon::Spline, "Drag points")]
                {
                    if ui.selectable_label(self.pen == pen, icon::text(mark)).on_hover_text(tip).clicked() {
                        self.pen = pen;
                    }
                }
            });
        });
        let mut edited = layer.curve.clone();
        let response = curve::edit(ui, &mut edited, self.pen, spectrum);
        edits.drag(id, &response, || Property::Curve(edited.clone()));
        let tip = "Φ_d: the gain of everything finer than the last harmonic";
        theme::row(ui, "Finest", tip, |ui| {
            let mut residual = layer.curve.residual;
            let slider = ui.add(theme::slider(&mut residual, 0.0..=ScaleCurve::MAX_GAIN).fixed_decimals(2));
            edits.drag(id, &slider, || Property::Curve(ScaleCurve { residual, ..layer.curve.clone() }));
        });
    }
}

fn model_buttons(ui: &mut Ui, id: LayerId, layer: &Layer, edits: &mut Edits) {
    ui.horizontal(|ui| {
        for (model, name, tip) in [
            (
                Model::Coordinate,
                "Coordinate",
                "Moves every point along its difference: sharp features, can fold",
            ),
            (
                Model::Normal,
                "Normal",
                "Inflates and deflates along the surface: smooth parts, chins and noses",
            ),
            (Model::Distance, "Distance", "One filter for all directions: subtle, keeps forms even at −8"),
        ] {
            let tip = NEXT_MODEL.with_key(ui.ctx(), tip);
            let button = ui.selectable_label(layer.model == model, name).on_hover_text(tip);
            if button.author_id(format!("model/{model}")).clicked() {
                edits.set(id, Property::Model(model));
            }
        }
    });
}

fn amount(
    ui: &mut Ui,
    id: LayerId,
    layer: &Layer,
    measured: &Measured<'_>,
    may_fold_percent: &mut f64,
    edits: &mut Edits,
) -> Option<Wish> {
    let mut wish = None;
    let [more, less] = [STRONGER, WEAKER].map(|key| key.text(ui.ctx()));
    let tip = format!("Below 0 exaggerates, 0 is the shape, 1 is the template; {more} and {less} change it");
    theme::row(ui, "μ", &tip, |ui| {
        // Room for the button at the end.
        ui.spacing_mut().slider_width -= 40.0;
        let mut mu = layer.mu;
        let low = if layer.model == Model::Distance { -8.0 } else { -3.0 };
        let slider = Slider::new(&mut mu, low..=1.0).clamping(egui::SliderClamping::Never);
        let slider = ui.add(slider.show_value(false));
        let value = ui.add(theme::number(&mut mu).range(-100.0..=100.0).speed(0.01).fixed_decimals(2));
        for response in [slider, value] {
            edits.drag(id, &response, || Property::Mu(mu));
        }
        let far = ui.button(icon::text(Icon::ChevronsLeft));
        if far.on_hover_text(FURTHEST.tooltip(ui.ctx())).clicked() {
            wish = Some(Wish::AsFarAsItGoes);
        }
    });
    theme::row(ui, "Strength", "Fades the layer in and out without losing its μ", |ui| {
        let mut strength = layer.strength;
        let slider = ui.add(theme::slider(&mut strength, 0.0..=1.0).fixed_decimals(2));
        edits.drag(id, &slider, || Property::Strength(strength));
    });
    let tip =
        "How many triangles may fold where μ goes as far as it goes: of a scan one sliver should not end it";
    theme::row(ui, "May fold", tip, |ui| {
        let slider = theme::slider(may_fold_percent, 0.0..=2.0).logarithmic(true).smallest_positive(0.01);
        ui.add(theme::in_units(slider, 1.0, 2, " %"));
    });
    let mut keep = measured.kept.is_some();
    let tip = "Holds all layers back where they would fold the surface or pass it through itself, and lets detail turn \
               with what it sits on. Found whenever the hand rests. Without it, the paper exactly";
    let kept = theme::checkbox(ui, &mut keep, "Keep triangles").author_id("keep-triangles");
    if kept.on_hover_text(tip).clicked() {
        edits.once(Action::KeepTriangles(keep));
    }
    ui.scope(|ui| verdicts(ui, measured)).inner.or(wish)
}

/// What the layer does to the triangles; a click on a line shows where.
fn verdicts(ui: &mut Ui, measured: &Measured<'_>) -> Option<Wish> {
    ui.spacing_mut().interact_size.y = theme::TARGET;
    ui.spacing_mut().button_padding.y = 0.0;
    ui.spacing_mut().item_spacing.y = 0.0;
    if measured.waits {
        // Counts of the shape without the layer would look like its own.
        still_to_come(ui, "Folds and crossings: after the match");
        return None;
    }
    let where_it_folds = measured.folds.and_then(|count| folds(ui, count));
    let where_it_crosses = crossings(ui, measured.crossings);
    let where_it_is_held = measured.kept.and_then(|held| held_back(ui, held));
    where_it_folds.or(where_it_crosses).or(where_it_is_held)
}

/// A line as high as the [`meter`] that takes its place: what is below it stays where it is.
fn still_to_come(ui: &mut Ui, text: &str) {
    ui.horizontal(|ui| theme::weak(ui, text));
}

/// How much of the movement is kept; a click on it shows where it is held back.
fn held_back(ui: &mut Ui, held: Held) -> Option<Wish> {
    let Held::Back { kept } = held else {
        still_to_come(ui, "Holding back…");
        return None;
    };
    let text = format!("{:.0} % of the movement kept", 100.0 * kept.min(1.0));
    let tip = "Mean length of the layer's displacement beside the unlimited one. Click to see where it is held back.";
    meter(ui, kept >= 0.7, &text, tip)
        .author_id("held-back")
        .clicked()
        .then_some(Wish::SeeWhere(Quantity::HeldBack))
}

/// The fold meter; a click on it shows where.
fn folds(ui: &mut Ui, folds: usize) -> Option<Wish> {
    let text = match folds {
        0 => "No folds".into(),
        1 => "1 folded triangle".into(),
        more => format!("{} folded triangles", grouped(more)),
    };
    let tip = "Triangles whose front this layer turned to the back. Click to see where.";
    meter(ui, folds == 0, &text, tip).author_id("folds").clicked().then_some(Wish::SeeWhere(Quantity::Folds))
}

/// The same for parts that pass through each other.
fn crossings(ui: &mut Ui, count: Option<crossings::Count>) -> Option<Wish> {
    let Some(crossings::Count { now, from_the_start, outdated }) = count else {
        still_to_come(ui, "Counting crossings…");
        return None;
    };
    let text = match now {
        0 => "Nothing passes through itself".into(),
        more => format!("{} crossing triangles", grouped(more)),
    };
    let text = if outdated { format!("{text} …") } else { text };
    let mut tip = "Triangles of the whole result that pass through others, such as an ear through a cheek; \
                   counted whenever the hand rests. Click to see where."
        .to_owned();
    if from_the_start > 0 {
        tip += &format!(" The shape came with {}.", grouped(from_the_start));
    }
    meter(ui, now <= from_the_start, &text, &tip)
        .author_id("crossings")
        .clicked()
        .then_some(Wish::SeeWhere(Quantity::Crossings))
}

/// A line of green or red status, to be clicked.
fn meter(ui: &mut Ui, good: bool, text: &str, tip: &str) -> egui::Response {
    let palette = theme::palette(ui);
    let (mark, color) =
        if good { (Icon::CircleCheck, palette.good) } else { (Icon::TriangleAlert, palette.warning) };
    let text = RichText::new(icon::label(mark, text)).color(color).small();
    ui.add(egui::Button::new(text).frame(false)).on_hover_text(tip)
}

fn region(ui: &mut Ui, id: LayerId, layer: &Layer, edits: &mut Edits) {
    let everywhere = layer.region.painted == Painted::Everywhere;
    ui.horizontal_wrapped(|ui| {
        // All in one row, however narrow the panel.
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.spacing_mut().button_padding.x = 6.0;
        let mut paint = |edit: PaintEdit| edits.once(Action::Paint { layer: id, edit });
        let all = ui.selectable_label(everywhere, "Everywhere").author_id("everywhere");
        if all.on_hover_text("The whole shape").clicked() && !everywhere {
            paint(PaintEdit::Set(Painted::Everywhere));
        }
        if ui.button("Clear").on_hover_text("Nothing, to begin painting").clicked() {
            paint(PaintEdit::Clear);
        }
        if ui.button("Invert").on_hover_text(INVERT.tooltip(ui.ctx())).clicked() {
            paint(PaintEdit::Invert);
        }
        let tool = |ui: &mut Ui, mark, name, tip| {
            ui.button(icon::text(mark)).accessible_name(name).on_hover_text(tip).clicked()
        };
        if tool(ui, Icon::CirclePlus, "Grow", "Grow: one ring of vertices more") {
            paint(PaintEdit::Grow);
        }
        if tool(ui, Icon::CircleMinus, "Shrink", "Shrink: one ring of vertices less") {
            paint(PaintEdit::Shrink);
        }
        if tool(ui, Icon::Droplet, "Soften", "Soften: the edge fades over one ring of vertices more") {
            paint(PaintEdit::Smooth);
        }
    });
    if everywhere {
        return;
    }
    let smoothing = layer.region.smoothing;
    let tip = "The wavelength where the region's edge is half faded, as a share of the shape's size: longer is softer";
    theme::row(ui, "Softness", tip, |ui| {
        let mut percent = 100.0 * smoothing.wavelength;
        let slider = theme::slider(&mut percent, 4.0..=320.0).logarithmic(true);
        let slider = ui.add(theme::in_units(slider, 1.0, 0, " %"));
        let wavelength = percent / 100.0;
        edits.drag(id, &slider, || Property::Smoothing(Smoothing { wavelength, ..smoothing }));
    });
    ui.horizontal(|ui| {
        for (roll_off, name, tip) in [
            (RollOff::Heat, "Soft edge", "A step of heat flow: an average, which never rings"),
            (RollOff::Sharp, "Sharp cut", "The paper's cut: rings below 0 and above 1 around the edge"),
        ] {
            if ui.selectable_label(smoothing.roll_off == roll_off, name).on_hover_text(tip).clicked() {
                edits.set(id, Property::Smoothing(Smoothing { roll_off, ..smoothing }));
            }
        }
        if smoothing.roll_off == RollOff::Heat {
            return;
        }
        let mut clamp = smoothing.clamp;
        if theme::checkbox(ui, &mut clamp, "Clamp")
            .on_hover_text("Cuts ringing off below 0 and above 1")
            .changed()
        {
            edits.set(id, Property::Smoothing(Smoothing { clamp, ..smoothing }));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_are_as_high_before_they_are_known() {
        let (ctx, spectrum) = (egui::Context::default(), Spectrum::default());
        theme::install(&ctx);
        let height = |crossings: Option<crossings::Count>, kept: Option<Held>, waits: bool| {
            let folds = (!waits).then_some(0);
            let (spectrum, channels) = (&spectrum, &[]);
            let measured = Measured { spectrum, mirror: None, folds, waits, crossings, kept, channels };
            let mut height = 0.0;
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                height = ui.scope(|ui| verdicts(ui, &measured)).response.rect.height();
            });
            height
        };
        let count = crossings::Count { now: 3, from_the_start: 0, outdated: false };
        let lines = |count: u8| f32::from(count) * theme::TARGET;
        for (found, expected) in [
            (height(None, None, true), lines(1)),
            (height(None, Some(Held::Unknown), false), lines(3)),
            (height(Some(count), Some(Held::Unknown), false), lines(3)),
            (height(Some(count), Some(Held::Back { kept: 0.5 }), false), lines(3)),
        ] {
            assert!((found - expected).abs() < 0.1, "{found} of {expected}");
        }
    }
}
