//! The overlay of the dancing shapes: choice, marks, and each item's t and a.

use chladni_music::{Action, GalleryItem, Instrument, ItemId, Mapping};
use egui::{Align2, Color32, Rect, Response, RichText, Sense, Stroke, Ui, UiBuilder, Vec2, pos2, vec2};

use super::curve;
use super::legible::{self, Anchored};
use super::lineage;
use super::view::View;
use super::wish::{A_LITTLE, Then, Wish};
use crate::studio::author_id::AuthorId;
use crate::studio::context_menu;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::music::{DRAW, FAVORITE, LOCK, MUTATE, STAGE};
use crate::studio::shortcut::Shortcut;
use crate::studio::theme;

// The cells are dark in both themes, or as bright as the background that was chosen for them.
const ACCENT: Color32 = Color32::from_rgb(226, 166, 70);
/// Beneath lines and icons, which are then seen on any background.
const RIM: Color32 = Color32::from_black_alpha(190);
/// How far marks and curves stay away from a cell's edge.
const EDGE: f32 = 9.0;
/// The part of a cell's width that marks and edges take.
const MARKS: f32 = 80.0;
/// The part that the buttons of the marked cell take.
const BUTTONS: f32 = 166.0;
/// What a number in the corner takes with the edge.
const NUMBER: f32 = 24.0;

/// Draws the overlay of every cell and handles clicks: a click chooses, a double click puts on stage, and the
/// other button opens a menu. `marked` is the item that keys act on. Returns the item under the pointer, and
/// the one that has just got the focus. The item `on_stage`, and the next one, say so.
pub fn overlay(
    ui: &mut Ui,
    cells: &[Rect],
    instrument: &Instrument,
    marked: Option<usize>,
    on_stage: Option<ItemId>,
    wishes: &mut Vec<Wish>,
) -> (Option<usize>, Option<usize>) {
    let (mut hovered, mut focused) = (None, None);
    let items = instrument.gallery().items();
    for (index, (cell, item)) in cells.iter().zip(items).enumerate() {
        let response = ui.interact(*cell, ui.scope_id().with(("dance", index)), Sense::click());
        let title = lineage::called(instrument, item);
        let next = instrument.next_on_stage().map(|(id, _)| id);
        let standing = [(on_stage, "on stage"), (next, "next")];
        let standing = standing.into_iter().find(|(id, _)| *id == Some(item.id)).map(|(_, text)| text);
        let name = standing.map_or_else(|| title.clone(), |standing| format!("{title}, {standing}"));
        let marked_as = in_words(instrument.is_favorite(item.id), item.locked);
        response.widget_info(|| egui::WidgetInfo {
            current_text_value: marked_as.map(str::to_owned),
            ..egui::WidgetInfo::selected(egui::Role::CheckBox, true, item.chosen, &name)
        });
        let response = response.author_id(format!("dance/{}", index + 1));
        if response.contains_pointer() {
            hovered = Some(index);
        }
        if response.gained_focus() {
            focused = Some(index);
        }
        let is_marked = marked == Some(index);
        frame(ui, *cell, item, &title, is_marked);
        if let Some(standing) = standing {
            in_corner(ui, *cell, (30.0, MARKS), standing, ACCENT);
        }
        // The second click of a double click takes back the choice of the first.
        if response.clicked() {
            wishes.push(Wish::Do(Action::Choose { item: index, on: !item.chosen }));
        }
        if response.double_clicked() {
            wishes.push(Wish::Do(Action::PerformGallery { first: index }));
        }
        menu(&response, instrument, (index, item), wishes);
        marks(ui, *cell, instrument, (index, item), is_marked, wishes);
    }
    (hovered, focused)
}

/// The marks of an item, for screen readers.
fn in_words(favorite: bool, locked: bool) -> Option<&'static str> {
    match (favorite, locked) {
        (true, true) => Some("favorite, locked"),
        (true, false) => Some("favorite"),
        (false, true) => Some("locked"),
        (false, false) => None,
    }
}

fn frame(ui: &Ui, cell: Rect, item: &GalleryItem, title: &str, marked: bool) {
    let (width, color) = match (item.chosen, marked) {
        (true, true) => (3.0, ACCENT),
        (true, false) => (2.5, ACCENT),
        (false, true) => (1.5, Color32::from_white_alpha(170)),
        (false, false) => (1.0, Color32::from_white_alpha(18)),
    };
    let line = |inward: f32, stroke: Stroke| {
        ui.painter().rect_stroke(cell.shrink(inward), 6.0 - inward, stroke, egui::StrokeKind::Inside);
    };
    if item.chosen || marked {
        line(0.0, Stroke::new(width + 2.0, RIM));
    }
    line(1.0, Stroke::new(width, color));
    curves(ui, cell, &item.genome);
    let title = title.strip_prefix("Dance ").filter(|_| item.name.is_empty()).unwrap_or(title);
    let taken = if marked { BUTTONS } else { MARKS };
    in_corner(ui, cell, (8.0, taken), title, Color32::from_white_alpha(230));
}

/// Text in the upper right corner of a cell, so far below its edge, beside what is `taken` at the left.
fn in_corner(ui: &Ui, cell: Rect, (below, taken): (f32, f32), text: &str, color: Color32) {
    let size = egui::TextStyle::Small.resolve(ui.style()).size;
    let width = (cell.width() - taken).max(NUMBER - EDGE);
    let place = Anchored { at: cell.right_top() + vec2(-EDGE, below), anchor: Align2::RIGHT_TOP, width };
    legible::show(ui, place, text, size, color);
}

/// Chosen, favorite and locked; on the marked item buttons for all that can be done with it, as many as have room: the menu
/// and keys have them, too.
fn marks(
    ui: &mut Ui,
    cell: Rect,
    instrument: &Instrument,
    (index, item): (usize, &GalleryItem),
    marked: bool,
    wishes: &mut Vec<Wish>,
) {
    let favorite = instrument.is_favorite(item.id);
    let corner = cell.left_top() + vec2(EDGE - 3.0, 5.0);
    let row = Rect::from_min_max(corner, pos2(cell.right() - NUMBER, corner.y + theme::TARGET));
    if !marked {
        let mut at = row.left_top() + vec2(3.0, 3.0);
        for (shown, mark) in
            [(item.chosen, Icon::CircleCheck), (favorite, Icon::Star), (item.locked, Icon::Lock)]
        {
            if shown {
                let place = Anchored { at, anchor: Align2::LEFT_TOP, width: f32::INFINITY };
                legible::show(ui, place, &icon::text(mark), 15.0, ACCENT);
                at.x += 20.0;
            }
        }
        return;
    }
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let mut ui = ui.new_child(UiBuilder::new().id_salt(("marks", index)).max_rect(row).layout(layout));
    ui.spacing_mut().item_spacing.x = 2.0;
    ui.spacing_mut().button_padding = vec2(3.0, 2.0);
    if item.chosen {
        let (place, _) = ui.allocate_exact_size(vec2(15.0, theme::TARGET), Sense::hover());
        let place = Anchored { at: place.center(), anchor: Align2::CENTER_CENTER, width: f32::INFINITY };
        legible::show(&ui, place, &icon::text(Icon::CircleCheck), 15.0, ACCENT);
    }
    let mut button = |mark: Icon, on: Option<bool>, key: Shortcut, wish: Wish| {
        if ui.available_width() < theme::TARGET {
            return;
        }
        let (color, fill) =
            if on == Some(true) { (theme::ON_ACCENT, ACCENT) } else { (Color32::from_white_alpha(230), RIM) };
        let text = RichText::new(icon::text(mark)).size(15.0).color(color);
        let button = egui::Button::new(text).fill(fill).stroke(Stroke::NONE).small();
        let button = ui.add(button.min_size(Vec2::splat(theme::TARGET)));
        if let Some(on) = on {
            let info = || egui::WidgetInfo::selected(egui::Role::CheckBox, true, on, key.action);
            button.widget_info(info);
        }
        if button.on_hover_text(key.tooltip(ui.ctx())).clicked() {
            wishes.push(wish);
        }
    };
    button(Icon::Star, Some(favorite), FAVORITE, Wish::Do(Action::Favorite { item: index, on: !favorite }));
    button(Icon::Lock, Some(item.locked), LOCK, Wish::Do(Action::Lock { item: index, on: !item.locked }));
    button(Icon::Dices, None, MUTATE, Wish::Do(Action::Mutate { item: index, amount: A_LITTLE }));
    button(Icon::Spline, None, DRAW, Wish::Show(View::CloseUp(index)));
    button(Icon::Presentation, None, STAGE, Wish::Do(Action::PerformGallery { first: index }));
}

fn menu(
    response: &Response,
    instrument: &Instrument,
    (index, item): (usize, &GalleryItem),
    wishes: &mut Vec<Wish>,
) {
    let favorite = instrument.is_favorite(item.id);
    context_menu::show(response, |ui| {
        let mut entry = |ui: &mut Ui, mark: Icon, name: &str, wish: Wish| {
            if context_menu::entry(ui, true, icon::label(mark, name)).clicked() {
                wishes.push(wish);
            }
        };
        entry(ui, Icon::Presentation, "Put on stage", Wish::Do(Action::PerformGallery { first: index }));
        entry(ui, Icon::Spline, "Name and draw …", Wish::Show(View::CloseUp(index)));
        let name = if favorite { "No favorite any more" } else { "Favorite" };
        entry(ui, Icon::Star, name, Wish::Do(Action::Favorite { item: index, on: !favorite }));
        let name = if item.locked { "Unlock" } else { "Lock in its place" };
        entry(ui, Icon::Lock, name, Wish::Do(Action::Lock { item: index, on: !item.locked }));
        entry(ui, Icon::Dices, "Change a little", Wish::Do(Action::Mutate { item: index, amount: A_LITTLE }));
        ui.separator();
        entry(ui, Icon::BookmarkPlus, "Keep on the shelf …", Wish::Keep(item.id));
        entry(ui, Icon::Save, "Save as a file …", Wish::Choose(Then::SavePreset(item.id)));
        ui.separator();
        lineage::menu(ui, &icon::label(Icon::GitFork, "Lineage"), instrument, item, wishes);
    });
}

/// t at the left and a at the right, as small curves at the bottom of the cell.
fn curves(ui: &Ui, cell: Rect, mapping: &Mapping) {
    const NAME: f32 = 11.0;
    let width = (cell.width() * 0.36 - NAME).min(150.0);
    let height = (cell.height() * 0.14).min(36.0);
    let left = Rect::from_min_size(
        pos2(cell.left() + EDGE + NAME, cell.bottom() - height - EDGE),
        vec2(width, height),
    );
    let right = left.translate(vec2(cell.width() - width - 2.0 * EDGE - NAME, 0.0));
    let peak = mapping.amplification.iter().fold(0.0_f32, |peak, a| peak.max(a.abs())).max(1e-6);
    let faint = Stroke::new(1.0, Color32::from_white_alpha(26));
    ui.painter().hline(left.x_range(), left.bottom(), faint);
    ui.painter().hline(right.x_range(), right.center().y, faint);
    for (rect, name, values, range, color) in [
        (left, "t", &mapping.transfer, (0.0, 1.0), curve::TRANSFER),
        (right, "a", &mapping.amplification, (-peak, peak), ACCENT),
    ] {
        curve::line(ui.painter(), rect, values, range, Stroke::new(3.5, RIM));
        curve::line(ui.painter(), rect, values, range, Stroke::new(1.5, color));
        let at = pos2(rect.left() - 5.0, rect.center().y);
        let place = Anchored { at, anchor: Align2::RIGHT_CENTER, width: f32::INFINITY };
        legible::show(ui, place, name, 11.0, color);
    }
}
