//! What is drawn over the dancing shapes: choice, marks, and each item's t and a.

use chladni_music::{Action, Instrument, Mapping};
use egui::{Color32, Pos2, Rect, Response, Stroke, Ui, pos2};

use crate::studio::icon::{self, Icon};
use crate::studio::theme;

/// What a click on an item asks for.
pub enum Click {
    /// An action of the instrument.
    Do(Action),
    /// Its mapping as a preset file.
    SavePreset(usize),
}

/// Draws the overlay of every cell and handles clicks: one chooses, two put on stage, the other
/// button opens a menu.
pub fn overlay(
    ui: &mut Ui,
    response: &Response,
    cells: &[Rect],
    instrument: &Instrument,
    hovered: &mut Option<usize>,
) -> Vec<Click> {
    let mut clicks = Vec::new();
    let pointer = response.hover_pos();
    *hovered = pointer.and_then(|at| cells.iter().position(|cell| cell.contains(at)));
    let items = instrument.gallery().items();
    for (index, (cell, item)) in cells.iter().zip(items).enumerate() {
        let favourite = instrument.favourites().iter().any(|known| known.id == item.id);
        let palette = theme::palette(ui);
        let border = match (item.chosen, *hovered == Some(index)) {
            (true, _) => Stroke::new(2.5, palette.accent),
            (false, true) => Stroke::new(1.0, Color32::from_white_alpha(70)),
            (false, false) => Stroke::new(1.0, Color32::from_white_alpha(18)),
        };
        ui.painter().rect_stroke(*cell, 6.0, border, egui::StrokeKind::Inside);
        curves(ui, *cell, &item.mapping);
        let mut at = cell.left_top() + egui::vec2(9.0, 8.0);
        for (shown, mark) in
            [(item.chosen, Icon::CircleCheck), (favourite, Icon::Star), (item.locked, Icon::Lock)]
        {
            if shown {
                let font = egui::FontId::proportional(15.0);
                ui.painter().text(at, egui::Align2::LEFT_TOP, icon::text(mark), font, palette.accent);
                at.x += 20.0;
            }
        }
        let name = if item.name.is_empty() { format!("{}", index + 1) } else { item.name.clone() };
        let font = egui::TextStyle::Small.resolve(ui.style());
        let corner = cell.right_top() + egui::vec2(-9.0, 8.0);
        ui.painter().text(corner, egui::Align2::RIGHT_TOP, name, font, Color32::from_white_alpha(150));
    }
    let Some(index) = *hovered else { return clicks };
    let Some(item) = items.get(index) else { return clicks };
    if response.double_clicked() {
        clicks.push(Click::Do(Action::Perform { item: index }));
    } else if response.clicked() {
        clicks.push(Click::Do(Action::Choose { item: index, on: !item.chosen }));
    }
    menu(response, instrument, index, &mut clicks);
    clicks
}

fn menu(response: &Response, instrument: &Instrument, index: usize, clicks: &mut Vec<Click>) {
    // The menu stays with the item it was opened on, wherever the pointer goes.
    let id = response.id.with("menu item");
    if response.secondary_clicked() {
        response.ctx.data_mut(|data| data.insert_temp(id, index));
    }
    let item = response.ctx.data(|data| data.get_temp::<usize>(id)).unwrap_or(index);
    let Some(shown) = instrument.gallery().items().get(item) else { return };
    let favourite = instrument.favourites().iter().any(|known| known.id == shown.id);
    response.context_menu(|ui| {
        let mut entry = |ui: &mut Ui, mark: Icon, name: &str, click: Click| {
            if ui.button(icon::label(mark, name)).clicked() {
                clicks.push(click);
                ui.close();
            }
        };
        entry(ui, Icon::Presentation, "Put on stage", Click::Do(Action::Perform { item }));
        let name = if favourite { "No favourite any more" } else { "Favourite" };
        entry(ui, Icon::Star, name, Click::Do(Action::Favourite { item, on: !favourite }));
        let name = if shown.locked { "Unlock" } else { "Lock in its place" };
        entry(ui, Icon::Lock, name, Click::Do(Action::Lock { item, on: !shown.locked }));
        entry(ui, Icon::Dices, "Change a little", Click::Do(Action::Mutate { item, amount: 0.2 }));
        entry(ui, Icon::Save, "Save as preset …", Click::SavePreset(item));
    });
}

/// t above a, as small curves at the bottom of the cell.
fn curves(ui: &Ui, cell: Rect, mapping: &Mapping) {
    let width = (cell.width() * 0.34).min(120.0);
    let height = (cell.height() * 0.13).min(30.0);
    let palette = theme::palette(ui);
    let left =
        Rect::from_min_size(pos2(cell.left() + 9.0, cell.bottom() - height - 8.0), egui::vec2(width, height));
    let right = left.translate(egui::vec2(cell.width() - width - 18.0, 0.0));
    line(ui, left, &mapping.transfer, 0.0, 1.0, Color32::from_rgb(120, 190, 220));
    let peak = mapping.amplification.iter().fold(0.0_f32, |peak, a| peak.max(a.abs())).max(1e-6);
    line(ui, right, &mapping.amplification, -peak, peak, palette.accent);
}

fn line(ui: &Ui, rect: Rect, values: &[f32], low: f32, high: f32, color: Color32) {
    if values.len() < 2 {
        return;
    }
    let last = (values.len() - 1) as f32;
    let points: Vec<Pos2> = values
        .iter()
        .enumerate()
        .map(|(i, value)| {
            let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
            pos2(rect.left() + rect.width() * i as f32 / last, rect.bottom() - rect.height() * share)
        })
        .collect();
    ui.painter().line(points, Stroke::new(1.3, color.gamma_multiply(0.85)));
}
