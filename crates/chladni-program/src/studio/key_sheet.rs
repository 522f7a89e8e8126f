//! The sheet of all keys that F1 shows, from the table that their handlers ask.

use egui::{Color32, Id, Key, Modifiers, TextStyle, Ui, Vec2, vec2};

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

/// How far an arrow key scrolls, in points.
const STEP: f32 = 40.0;

/// A key or a mouse gesture, and its effect.
type Line = (String, &'static str);

/// The sheet, and what had the keyboard focus before it.
#[derive(Debug, Default)]
pub struct KeySheet {
    /// Whether it is to be shown.
    pub open: bool,
    /// It was open in the last frame.
    was_open: bool,
    /// The control that gets the focus back.
    beneath: Option<Id>,
}

impl KeySheet {
    /// Draws the sheet: keys that work everywhere, then the `keys` of the room called `room`. While it is open, the focus
    /// and the keys that scroll are its own; a click beside it closes it. Then the focus goes back to where it was.
    pub fn show(&mut self, ctx: &egui::Context, room: &'static str, keys: &'static [Shortcut]) {
        let columns = columns(ctx, room, keys);
        let size = ctx.content_rect().size() - vec2(40.0, 100.0);
        let shown = egui::Window::new("Keyboard and mouse")
            .order(egui::Order::Foreground)
            .open(&mut self.open)
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ctx, |ui| show_columns(ui, &columns, size));
        if let Some(shown) = shown.filter(|_| self.open) {
            let (sheet, response) = (shown.response.layer_id, shown.response);
            let was_in_front = ctx.memory(|memory| memory.top_modal_layer()) == Some(sheet);
            if was_in_front && response.clicked_elsewhere() {
                self.open = false;
            } else {
                ctx.memory_mut(|memory| memory.set_modal_layer(sheet));
            }
        }
        self.pass_the_focus(ctx);
    }

    /// What lies beneath the sheet loses the focus in the frame after it opens.
    fn pass_the_focus(&mut self, ctx: &egui::Context) {
        match (std::mem::replace(&mut self.was_open, self.open), self.open) {
            (false, true) => self.beneath = ctx.memory(|memory| memory.focused()),
            (true, false) => {
                if let Some(control) = self.beneath.take() {
                    ctx.memory_mut(|memory| memory.request_focus(control));
                }
            }
            _ => {}
        }
    }
}

/// The lists of keys, with their headings.
fn columns(
    ctx: &egui::Context,
    room: &'static str,
    keys: &'static [Shortcut],
) -> Vec<(&'static str, Vec<Line>)> {
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
    columns
}

/// Shows the lists in a sheet of at most this `size`.
fn show_columns(ui: &mut Ui, columns: &[(&str, Vec<Line>)], size: Vec2) {
    ui.spacing_mut().interact_size.y = 18.0;
    let room = egui::ScrollArea::both().max_width(size.x).max_height(size.y);
    // Scrolls only where the window is smaller than the sheet.
    let room = room.min_scrolled_width(size.x).min_scrolled_height(size.y);
    let (beside, width) = fitting(ui, columns, size.x);
    room.show(ui, |ui| {
        scroll_by_keys(ui, size.y);
        for (row, columns) in columns.chunks(beside).enumerate() {
            ui.horizontal_top(|ui| {
                for (index, (name, lines)) in columns.iter().enumerate() {
                    ui.vertical(|ui| {
                        ui.add_space(theme::GAP_SMALL);
                        ui.label(egui::RichText::new(*name).size(14.5).strong());
                        ui.add_space(theme::GAP_SMALL);
                        show_column(ui, (row, index), lines, width);
                    });
                    ui.add_space(theme::GAP_LARGE);
                }
            });
        }
    });
}

/// How many columns stand beside each other in this `room`, and how wide effects are before they wrap: all in a row, or two in
/// a smaller window.
fn fitting(ui: &Ui, columns: &[(&str, Vec<Line>)], room: f32) -> (usize, f32) {
    let (gap, scroll_bar) = (theme::GAP_LARGE + theme::GAP, ui.spacing().scroll.allocated_width());
    let room = room - scroll_bar;
    let widths = columns.iter().map(|(_, lines)| {
        let keys = widest(ui, &TextStyle::Monospace, lines.iter().map(|(keys, _)| keys.as_str()));
        (keys, widest(ui, &TextStyle::Body, lines.iter().map(|(_, action)| *action)))
    });
    let widths: Vec<(f32, f32)> = widths.collect();
    let all: f32 = widths.iter().map(|(keys, action)| keys + theme::GAP_LARGE + action + gap).sum();
    if all <= room {
        return (columns.len().max(1), f32::INFINITY);
    }
    let keys = widths.iter().map(|(keys, _)| *keys).fold(0.0, f32::max);
    (2, (0.5 * room - gap - theme::GAP_LARGE - keys).max(keys))
}

/// The width of the widest of these texts.
fn widest<'a>(ui: &Ui, style: &TextStyle, texts: impl Iterator<Item = &'a str>) -> f32 {
    let font = style.resolve(ui.style());
    let width = |text: &str| ui.painter().layout_no_wrap(text.to_owned(), font.clone(), Color32::PLACEHOLDER);
    texts.map(|text| width(text).size().x).fold(0.0, f32::max)
}

/// Scrolls by a step, or by nearly a `page`, unless a question or a menu in front of the sheet has the keys.
fn scroll_by_keys(ui: &Ui, page: f32) {
    let is_in_front = ui.memory(|memory| memory.is_above_modal_layer(ui.layer_id()));
    if !is_in_front || egui::Popup::is_any_open(ui.ctx()) {
        return;
    }
    let page = page - STEP;
    for (key, down) in
        [(Key::ArrowDown, STEP), (Key::ArrowUp, -STEP), (Key::PageDown, page), (Key::PageUp, -page)]
    {
        let presses = ui.input_mut(|input| input.count_and_consume_key(Modifiers::NONE, key));
        if presses > 0 {
            ui.scroll_with_delta(vec2(0.0, -down * presses as f32));
        }
    }
}

fn show_column(ui: &mut Ui, place: (usize, usize), lines: &[Line], width: f32) {
    let grid = egui::Grid::new(("keys", place)).num_columns(2).spacing([theme::GAP_LARGE, 3.0]);
    grid.max_col_width(width).show(ui, |ui| {
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
    use egui_kittest::kittest::{NodeT, Queryable};

    use super::*;
    use crate::studio::opening::{SMALLEST, WINDOW};

    /// A window with the sheet in front of a button.
    fn opened(size: [f32; 2], room: &'static [Shortcut]) -> Harness<'static> {
        let mut sheet = KeySheet { open: true, ..KeySheet::default() };
        let content = move |ui: &mut Ui| {
            let _ = ui.button("Behind");
            if keys::window::HELP.pressed_anywhere(ui.ctx()) {
                sheet.open = !sheet.open;
            }
            sheet.show(ui.ctx(), "Room", room);
        };
        let mut window = Harness::builder().with_size(size).build_ui(content);
        theme::install(&window.ctx);
        window.run_steps(6);
        window
    }

    #[test]
    fn the_sheet_of_every_room_fits_a_new_window_and_the_width_of_the_smallest() {
        for room in [keys::start::ALL, keys::caricature::ALL, keys::breeding::ALL, keys::music::ALL] {
            for (size, height) in [(WINDOW, WINDOW[1]), (SMALLEST, f32::INFINITY)] {
                let window = opened(size, room);
                let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, vec2(size[0], height));
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

    #[test]
    fn keys_scroll_the_sheet_and_the_focus_stays_in_it() {
        let mut window = opened(SMALLEST, keys::caricature::ALL);
        let below = |window: &Harness<'_>| {
            let last = window.get_by_label(keys::caricature::GALLERY.action).rect();
            last.bottom() - SMALLEST[1]
        };
        let before = below(&window);
        assert!(before > 0.0, "there is room for all");
        window.key_press(Key::ArrowDown);
        window.run_steps(8);
        assert!(below(&window) < before - 0.5 * STEP);
        for _ in 0..6 {
            window.key_press(Key::PageDown);
            window.run_steps(8);
        }
        assert!(below(&window) < 0.0);
        for _ in 0..3 {
            window.key_press(Key::Tab);
            window.run_steps(2);
            assert!(!window.get_by_label("Behind").accesskit_node().is_focused());
        }
    }

    #[test]
    fn the_focus_is_where_it_was_once_the_sheet_is_closed() {
        let mut window = opened(WINDOW, keys::start::ALL);
        for (key, is_behind) in [(Key::F1, false), (Key::Tab, true), (Key::F1, false), (Key::F1, true)] {
            window.key_press(key);
            window.run_steps(6);
            let behind = window.get_by_label("Behind").accesskit_node().is_focused();
            assert_eq!(behind, is_behind, "{key:?}");
        }
    }
}
