//! The sheet of all keys that F1 shows, from the table that their handlers ask.

use super::shortcut::Shortcut;
use super::{keys, theme};

/// Keys of what Tab has reached.
const FOCUSED: [(&str, &str); 4] = [
    ("Arrows", "Turn the view that has the focus"),
    ("+ and −", "Nearer, farther, in that view"),
    ("Arrows on a curve", "Go along it, raise and lower it"),
    ("Menu, Shift+F10", "Open the menu of what has the focus"),
];

/// Mouse gestures in every 3D view, and while a region is painted.
const MOUSE: [(&str, &str); 7] = [
    ("Left drag", "Turn, or use the tool"),
    ("Middle or right drag", "Turn"),
    ("Alt and left drag", "Turn, while a tool is in use"),
    ("Shift with these", "Shift"),
    ("Wheel", "Zoom"),
    ("Ctrl while painting", "Erase, or paint where Erase is on"),
    ("Shift with a part", "Take it besides what is painted"),
];

/// Lines of a column of a room: the longest list fills two columns, and three fit a new window.
const COLUMN: usize = 20;

/// A key or a mouse gesture, and its effect.
type Line = (String, &'static str);

/// Draws the sheet: keys that work everywhere, then the `keys` of the room called `room`.
pub fn show(ctx: &egui::Context, open: &mut bool, room: &'static str, keys: &'static [Shortcut]) {
    let lines = |keys: &'static [Shortcut]| keys.iter().map(|key| (key.text(ctx), key.action));
    let gap = || std::iter::once((String::new(), ""));
    let by_hand = |(how, action): (&str, &'static str)| (how.to_owned(), action);
    let everywhere = lines(keys::window::ALL).chain(gap()).chain(lines(keys::view::ALL));
    let everywhere = everywhere.chain(FOCUSED.map(by_hand)).chain(gap()).chain(MOUSE.map(by_hand));
    let mut columns: Vec<(&str, Vec<Line>)> = vec![("Window", everywhere.collect())];
    // A long group goes on in the next column, without another heading.
    let room_lines: Vec<Line> = lines(keys).collect();
    let parts = room_lines.chunks(COLUMN).enumerate();
    columns.extend(parts.map(|(part, lines)| (if part == 0 { room } else { "" }, lines.to_vec())));
    let size = ctx.content_rect().size() - egui::vec2(40.0, 60.0);
    egui::Window::new("Keyboard and mouse")
        .order(egui::Order::Foreground)
        .open(open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ctx, |ui| {
            ui.spacing_mut().interact_size.y = 18.0;
            let room = egui::ScrollArea::both().max_width(size.x).max_height(size.y - 40.0);
            // Scrolls only where the window is smaller than the sheet.
            let room = room.min_scrolled_width(size.x).min_scrolled_height(size.y - 40.0);
            room.show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    for (index, (name, lines)) in columns.iter().enumerate() {
                        ui.vertical(|ui| {
                            ui.add_space(theme::GAP_SMALL);
                            ui.label(egui::RichText::new(*name).size(14.5).strong());
                            ui.add_space(theme::GAP_SMALL);
                            show_column(ui, index, lines);
                        });
                        ui.add_space(theme::GAP_LARGE);
                    }
                });
            });
        });
}

fn show_column(ui: &mut egui::Ui, index: usize, lines: &[Line]) {
    egui::Grid::new(("keys", index)).num_columns(2).spacing([theme::GAP_LARGE, 3.0]).show(ui, |ui| {
        for (keys, action) in lines {
            ui.monospace(keys);
            ui.label(*action);
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;
    use crate::studio::opening::WINDOW;

    #[test]
    fn the_sheet_of_every_room_fits_a_new_window() {
        for room in [keys::start::ALL, keys::caricature::ALL, keys::breeding::ALL, keys::music::ALL] {
            let sheet = move |ui: &mut egui::Ui| show(ui.ctx(), &mut true, "Room", room);
            let mut window = Harness::builder().with_size(WINDOW).build_ui(sheet);
            theme::install(&window.ctx);
            window.run_steps(6);
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, WINDOW.into());
            let actions = room.iter().chain(keys::view::ALL).map(|key| key.action);
            for action in actions.chain(MOUSE.map(|(_, action)| action)) {
                for line in window.get_all_by_label(action) {
                    let rect = line.rect();
                    assert!(screen.contains_rect(rect), "“{action}” at {rect}");
                }
            }
        }
    }
}
