//! What is drawn over the dancing shapes: choice, marks, and each item's t and a.

use chladni_music::{Action, GalleryItem, Instrument, Mapping};
use egui::{Color32, Rect, Response, Stroke, Ui, pos2};

use super::concert::View;
use super::curve;
use super::wish::Wish;
use crate::studio::icon::{self, Icon};

/// Draws the overlay of every cell and handles clicks: one chooses, two put on stage, the other
/// button opens a menu. Returns the item under the pointer.
pub fn overlay(
    ui: &mut Ui,
    cells: &[Rect],
    instrument: &Instrument,
    wishes: &mut Vec<Wish>,
) -> Option<usize> {
    let mut hovered = None;
    let items = instrument.gallery().items();
    for (index, (cell, item)) in cells.iter().zip(items).enumerate() {
        let response = ui.interact(*cell, ui.scope_id().with(("dance", index)), egui::Sense::click());
        let title = title(item, index);
        response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, item.chosen, &title));
        if response.contains_pointer() {
            hovered = Some(index);
        }
        paint(ui, *cell, instrument, item, &title, response.hovered());
        if response.double_clicked() {
            wishes.push(Wish::Do(Action::Perform { item: index }));
        } else if response.clicked() {
            wishes.push(Wish::Do(Action::Choose { item: index, on: !item.chosen }));
        }
        menu(&response, instrument, index, wishes);
    }
    hovered
}

fn title(item: &GalleryItem, index: usize) -> String {
    if item.name.is_empty() { format!("Dance {}", index + 1) } else { item.name.clone() }
}

fn paint(ui: &Ui, cell: Rect, instrument: &Instrument, item: &GalleryItem, title: &str, hovered: bool) {
    let favourite = instrument.favourites().iter().any(|known| known.id == item.id);
    // The cells are dark in both themes.
    let (accent, text) = (Color32::from_rgb(226, 166, 70), Color32::from_white_alpha(150));
    let border = match (item.chosen, hovered) {
        (true, _) => Stroke::new(2.5, accent),
        (false, true) => Stroke::new(1.0, Color32::from_white_alpha(70)),
        (false, false) => Stroke::new(1.0, Color32::from_white_alpha(18)),
    };
    ui.painter().rect_stroke(cell, 6.0, border, egui::StrokeKind::Inside);
    curves(ui, cell, &item.mapping);
    let mut at = cell.left_top() + egui::vec2(9.0, 8.0);
    for (shown, mark) in
        [(item.chosen, Icon::CircleCheck), (favourite, Icon::Star), (item.locked, Icon::Lock)]
    {
        if shown {
            let font = egui::FontId::proportional(15.0);
            ui.painter().text(at, egui::Align2::LEFT_TOP, icon::text(mark), font, accent);
            at.x += 20.0;
        }
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    let corner = cell.right_top() + egui::vec2(-9.0, 8.0);
    let title = title.strip_prefix("Dance ").filter(|_| item.name.is_empty()).unwrap_or(title);
    ui.painter().text(corner, egui::Align2::RIGHT_TOP, title, font, text);
}

fn menu(response: &Response, instrument: &Instrument, item: usize, wishes: &mut Vec<Wish>) {
    let Some(shown) = instrument.gallery().items().get(item) else { return };
    let favourite = instrument.favourites().iter().any(|known| known.id == shown.id);
    response.context_menu(|ui| {
        let mut entry = |ui: &mut Ui, mark: Icon, name: &str, wish: Wish| {
            if ui.button(icon::label(mark, name)).clicked() {
                wishes.push(wish);
                ui.close();
            }
        };
        entry(ui, Icon::Presentation, "Put on stage", Wish::Do(Action::Perform { item }));
        entry(ui, Icon::Spline, "Name and draw …", Wish::Show(View::CloseUp(item)));
        let name = if favourite { "No favourite any more" } else { "Favourite" };
        entry(ui, Icon::Star, name, Wish::Do(Action::Favourite { item, on: !favourite }));
        let name = if shown.locked { "Unlock" } else { "Lock in its place" };
        entry(ui, Icon::Lock, name, Wish::Do(Action::Lock { item, on: !shown.locked }));
        entry(ui, Icon::Dices, "Change a little", Wish::Do(Action::Mutate { item, amount: 0.2 }));
        ui.separator();
        entry(ui, Icon::BookmarkPlus, "Keep on the shelf …", Wish::Keep(shown.id));
        entry(ui, Icon::Save, "Save as a file …", Wish::SavePreset(shown.id));
    });
}

/// t above a, as small curves at the bottom of the cell.
fn curves(ui: &Ui, cell: Rect, mapping: &Mapping) {
    let width = (cell.width() * 0.34).min(120.0);
    let height = (cell.height() * 0.13).min(30.0);
    let left =
        Rect::from_min_size(pos2(cell.left() + 9.0, cell.bottom() - height - 8.0), egui::vec2(width, height));
    let right = left.translate(egui::vec2(cell.width() - width - 18.0, 0.0));
    let stroke = |color: Color32| Stroke::new(1.3, color.gamma_multiply(0.85));
    curve::line(ui.painter(), left, &mapping.transfer, (0.0, 1.0), stroke(curve::TRANSFER));
    let peak = mapping.amplification.iter().fold(0.0_f32, |peak, a| peak.max(a.abs())).max(1e-6);
    let accent = Color32::from_rgb(226, 166, 70);
    curve::line(ui.painter(), right, &mapping.amplification, (-peak, peak), stroke(accent));
}
