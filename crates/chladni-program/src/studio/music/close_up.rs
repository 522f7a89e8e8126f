//! One item large: its name, its knobs, and t and a to be drawn by hand.

use chladni_music::{Action, FormControl, GalleryItem, Instrument, Mapping, direct_transfer};
use egui::{Rect, RichText, TextEdit, Ui, UiBuilder, pos2, vec2};

use super::curve::{self, Plot};
use super::lineage;
use super::view::View;
use super::wish::Wish;
use crate::studio::author_id::AuthorId;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::music::{FAVORITE, STAGE};
use crate::studio::theme;
use crate::work::drawn_curve::smooth;

/// Height of the plots with their head.
const BENCH: f32 = 230.0;
const HEAD: f32 = 38.0;
/// A narrower bench shows icons without names.
const WIDE: f32 = 1040.0;

/// Divides the room's middle into the picture and the bench below it.
pub fn split(rect: Rect) -> (Rect, Rect) {
    let edge = (rect.bottom() - BENCH).max(rect.center().y);
    let picture = Rect::from_min_max(rect.min, pos2(rect.right(), edge));
    (picture, Rect::from_min_max(pos2(rect.left(), edge), rect.max))
}

/// An unfinished stroke: t or a of one item, until the pointer is released.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The mapping with the curve as it is now.
    pub mapping: Mapping,
    action: Stroke,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stroke {
    Transfer,
    Amplification,
}

/// The current sound, for the plots' backgrounds.
pub struct HeardBands<'a> {
    /// f_s of the sound bands.
    pub mid: &'a [f32],
    /// Where the bands lie.
    pub bands_hz: &'a [f32],
    /// λ_k of the body.
    pub eigenvalues: &'a [f64],
}

/// Draws the bench of the item at `index`.
pub fn show(
    ui: &mut Ui,
    rect: Rect,
    instrument: &Instrument,
    index: usize,
    draft: &mut Option<Draft>,
    heard: &HeardBands<'_>,
    wishes: &mut Vec<Wish>,
) {
    let Some(item) = instrument.gallery().items().get(index) else { return };
    ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
    let inside = rect.shrink2(vec2(12.0, 8.0));
    let head = Rect::from_min_size(inside.min, vec2(inside.width(), HEAD));
    let mut row = ui.new_child(UiBuilder::new().max_rect(head).layout(*ui.layout()));
    theme::group(&mut row, "This dance", |ui| {
        ui.horizontal_centered(|ui| header(ui, instrument, item, index, heard, wishes));
    });
    let plots = Rect::from_min_max(pos2(inside.left(), head.bottom() + 4.0), inside.max);
    let width = (plots.width() - theme::GAP) / 2.0;
    let left = Rect::from_min_size(plots.min, vec2(width, plots.height()));
    let right = left.translate(vec2(width + theme::GAP, 0.0));
    let mut mapping = draft.as_ref().map_or_else(|| item.genome.clone(), |draft| draft.mapping.clone());
    let transfer = Plot {
        id: "curve/t",
        name: "t: which harmonic each sound band drives",
        range: (0.0, 1.0),
        color: curve::transfer_color(ui),
        behind: heard.mid,
    };
    let response = curve::edit(ui, left, &transfer, &mut mapping.transfer);
    stroke(&response, Stroke::Transfer, &mapping, draft, index, wishes);
    if let Some(text) = response.hover_pos().and_then(|at| tell_transfer(left, at.x, &mapping, heard)) {
        response.on_hover_text_at_pointer(text);
    }
    let answered = answered(&mapping, heard);
    let amplification = Plot {
        id: "curve/a",
        name: "a: how strongly each harmonic answers, relative to the others",
        range: (-1.0, 1.0),
        color: theme::palette(ui).accent,
        behind: &answered,
    };
    let response = curve::edit(ui, right, &amplification, &mut mapping.amplification);
    stroke(&response, Stroke::Amplification, &mapping, draft, index, wishes);
    response.on_hover_text_at_pointer(
        "Only proportions count: the largest value that a sound reaches acts as 1 or −1. Gain is the strength.\n\
         Draw to bend; with Shift the line stays level",
    );
}

/// Keeps the stroke as a draft, and turns it into one action when the pointer is released.
fn stroke(
    response: &egui::Response,
    action: Stroke,
    mapping: &Mapping,
    draft: &mut Option<Draft>,
    item: usize,
    wishes: &mut Vec<Wish>,
) {
    if response.changed() {
        *draft = Some(Draft { mapping: mapping.clone(), action });
    }
    let released = response.drag_stopped() || response.clicked() || !response.is_pointer_button_down_on();
    if released && let Some(done) = draft.take_if(|draft| draft.action == action) {
        wishes.push(Wish::Do(match action {
            Stroke::Transfer => Action::SetTransfer { item, transfer: done.mapping.transfer },
            Stroke::Amplification => {
                Action::SetAmplification { item, amplification: done.mapping.amplification }
            }
        }));
    }
}

fn header(
    ui: &mut Ui,
    instrument: &Instrument,
    item: &GalleryItem,
    index: usize,
    heard: &HeardBands<'_>,
    wishes: &mut Vec<Wish>,
) {
    let back = ui.button(icon::label(Icon::ChevronLeft, "Gallery")).author_id("back-to-gallery");
    if back.on_hover_text("Back to all dances (Escape)").clicked() {
        wishes.push(Wish::Show(View::Gallery));
    }
    let mut name = item.name.clone();
    let hint = format!("Name of dance {}", index + 1);
    let edit = TextEdit::singleline(&mut name).hint_text(hint).desired_width(120.0);
    let edit = ui.add(edit).accessible_name("Name").author_id("name");
    if edit.changed() {
        wishes.push(Wish::Do(Action::Rename { item: index, name }));
    }
    let favorite = instrument.is_favorite(item.id);
    let star = egui::Button::selectable(favorite, text(ui, Icon::Star, "Favorite"));
    if button(ui, star, "favorite", "Favorite", FAVORITE.tooltip(ui.ctx())) {
        wishes.push(Wish::Do(Action::Favorite { item: index, on: !favorite }));
    }
    let keep = egui::Button::new(text(ui, Icon::BookmarkPlus, "Keep …"));
    if button(ui, keep, "keep", "Keep …", "Put it on the shelf".into()) {
        wishes.push(Wish::Keep(item.id));
    }
    let stage = egui::Button::new(text(ui, Icon::Presentation, "Stage"));
    if button(ui, stage, "perform", "Stage", STAGE.tooltip(ui.ctx())) {
        wishes.push(Wish::Do(Action::PerformGallery { first: index }));
    }
    let name = text(ui, Icon::GitFork, "Lineage");
    lineage::menu(ui, &name, instrument, item, wishes);
    ui.separator();
    let weak = theme::palette(ui).weak;
    ui.spacing_mut().slider_width = 70.0;
    stereo_mu(ui, instrument, item, index, wishes);
    let mut gain = item.genome.gain;
    let label = ui.label(RichText::new("Gain").color(weak)).id;
    let slider = theme::slider(&mut gain, 0.0..=4.0).fixed_decimals(2);
    if ui.add(slider).labelled_by(label).on_hover_text("This dance's own strength").changed() {
        wishes.push(Wish::Do(Action::SetItemGain { item: index, gain }));
    }
    shapes_menu(ui, item, index, heard, wishes);
}

/// The item's μ, where the form has a use for it.
fn stereo_mu(ui: &mut Ui, instrument: &Instrument, item: &GalleryItem, index: usize, wishes: &mut Vec<Wish>) {
    let weak = theme::palette(ui).weak;
    let label = RichText::new("μ").color(weak);
    if let Some(why) = instrument.parameters().form.ignores(FormControl::StereoMu) {
        ui.label(label).on_hover_text(why);
        ui.label(RichText::new("not in halves").small().color(weak)).on_hover_text(why);
        return;
    }
    let mut stereo_mu = item.genome.stereo_mu;
    let label = ui.label(label).id;
    let tip = "0: the middle of the sound moves symmetric harmonics, its sides antisymmetric ones; at 1 \
               symmetric ones hear the right channel alone and antisymmetric ones the left";
    let slider = theme::slider(&mut stereo_mu, 0.0..=1.0).fixed_decimals(2);
    if ui.add(slider).labelled_by(label).on_hover_text(tip).changed() {
        wishes.push(Wish::Do(Action::SetStereoMu { item: index, stereo_mu }));
    }
}

/// An icon with its name, or alone where the bench is narrow.
pub fn text(ui: &Ui, mark: Icon, name: &str) -> String {
    if ui.max_rect().width() < WIDE { icon::text(mark) } else { icon::label(mark, name) }
}

fn button(ui: &mut Ui, button: egui::Button<'_>, id: &str, name: &str, tip: String) -> bool {
    ui.add(button).author_id(id).on_hover_text(tip).accessible_name(name).clicked()
}

/// Ready-made curves, to begin from.
fn shapes_menu(
    ui: &mut Ui,
    item: &GalleryItem,
    index: usize,
    heard: &HeardBands<'_>,
    wishes: &mut Vec<Wish>,
) {
    let mapping = &item.genome;
    let name = text(ui, Icon::Spline, "Curves");
    let button = ui.menu_button(name, |ui| {
        let mut entry = |ui: &mut Ui, name: &str, action: &dyn Fn() -> Action| {
            if ui.button(name).clicked() {
                wishes.push(Wish::Do(action()));
                ui.close();
            }
        };
        let transfer = |transfer: Vec<f32>| Action::SetTransfer { item: index, transfer };
        let amplification = |amplification: Vec<f32>| Action::SetAmplification { item: index, amplification };
        let bands = mapping.transfer.len();
        entry(ui, "t: low to low, high to high", &|| {
            transfer(direct_transfer(heard.eigenvalues, bands, 1.0, false))
        });
        entry(ui, "t: reversed", &|| transfer(mapping.transfer.iter().map(|t| 1.0 - t).collect()));
        entry(ui, "t: smooth", &|| {
            let mut values = mapping.transfer.clone();
            smooth(&mut values);
            transfer(values)
        });
        ui.separator();
        entry(ui, "a: at rest", &|| amplification(vec![0.0; mapping.amplification.len()]));
        entry(ui, "a: grow instead of shrink", &|| {
            amplification(mapping.amplification.iter().map(|a| -a).collect())
        });
        entry(ui, "a: smooth", &|| {
            let mut values = mapping.amplification.clone();
            smooth(&mut values);
            amplification(values)
        });
    });
    button
        .response
        .accessible_name("Curves")
        .author_id("curves")
        .on_hover_text("Ready-made curves, to begin from");
}

/// The sound that now arrives at each harmonic, coarsely: the background of a.
fn answered(mapping: &Mapping, heard: &HeardBands<'_>) -> Vec<f32> {
    const COLUMNS: usize = 96;
    let mut columns = vec![0.0f32; COLUMNS];
    let bands = heard.mid.len();
    for (b, loudness) in heard.mid.iter().enumerate() {
        let at = b * mapping.transfer.len() / bands.max(1);
        let Some(t) = mapping.transfer.get(at) else { continue };
        let column = ((t * COLUMNS as f32) as usize).min(COLUMNS - 1);
        columns[column] = columns[column].max(*loudness);
    }
    columns
}

fn tell_transfer(rect: Rect, x: f32, mapping: &Mapping, heard: &HeardBands<'_>) -> Option<String> {
    let u = ((x - rect.left()) / rect.width()).clamp(0.0, 0.999);
    let t = mapping.transfer.get((u * mapping.transfer.len() as f32) as usize)?;
    let hz = heard.bands_hz.get((u * heard.bands_hz.len() as f32) as usize)?;
    let top = heard.eigenvalues.len().saturating_sub(1) as f32;
    Some(format!("{hz:.0} Hz drives harmonic {:.0}\nDraw to bend; with Shift the line stays level", t * top))
}
