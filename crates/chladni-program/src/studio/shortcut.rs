//! Keys and what they do: one list feeds the handlers, the tooltips and the cheat sheet.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::theme;

/// A key and its action, in the words of the window.
#[derive(Clone, Copy, Debug)]
pub struct Shortcut {
    /// The key with its modifiers.
    pub keys: KeyboardShortcut,
    /// What it does.
    pub action: &'static str,
}

impl Shortcut {
    /// A key without modifiers.
    pub const fn key(key: Key, action: &'static str) -> Self {
        Self { keys: KeyboardShortcut::new(Modifiers::NONE, key), action }
    }

    /// A key with Ctrl, or ⌘ on a Mac.
    pub const fn command(key: Key, action: &'static str) -> Self {
        Self { keys: KeyboardShortcut::new(Modifiers::COMMAND, key), action }
    }

    /// A key with Ctrl (⌘) and Shift.
    pub const fn command_shift(key: Key, action: &'static str) -> Self {
        let modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };
        Self { keys: KeyboardShortcut::new(modifiers, key), action }
    }

    /// Whether it was pressed in this frame, and not for the control that has the focus; consumes the key.
    pub fn pressed(&self, ctx: &egui::Context) -> bool {
        let plain = self.keys.modifiers == Modifiers::NONE;
        let taken = plain && is_taken(ctx, self.keys.logical_key);
        !taken && ctx.input_mut(|input| input.consume_shortcut(&self.keys))
    }

    /// "Ctrl+S", or "[".
    pub fn text(&self, ctx: &egui::Context) -> String {
        if self.keys.modifiers != Modifiers::NONE {
            return ctx.format_shortcut(&self.keys);
        }
        let key = self.keys.logical_key;
        match key {
            // The font of the cheat sheet has no symbols for these.
            Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown => key.name().to_owned(),
            _ => key.symbol_or_name().to_owned(),
        }
    }

    /// "action (Ctrl+S)", for a tooltip.
    pub fn tooltip(&self, ctx: &egui::Context) -> String {
        self.with_key(ctx, self.action)
    }

    /// "words (Ctrl+S)", for the tooltip of a control that does more than the key.
    pub fn with_key(&self, ctx: &egui::Context, words: &str) -> String {
        format!("{words} ({})", self.text(ctx))
    }
}

/// Whether what has the focus wants `key` for itself: a text field all of them, another control those
/// that click it, change it or lead to the next one.
pub fn is_taken(ctx: &egui::Context, key: Key) -> bool {
    let controls = matches!(
        key,
        Key::Space | Key::Enter | Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown
    );
    ctx.text_edit_focused() || controls && ctx.egui_wants_keyboard_input()
}

/// What the mouse does in every 3D view.
const MOUSE: [(&str, &str); 5] = [
    ("Left drag", "Turn, or use the tool"),
    ("Middle or right drag", "Turn"),
    ("Alt and left drag", "Turn, while a tool is in use"),
    ("Shift with these", "Shift"),
    ("Wheel", "Zoom"),
];

/// Lines of a column of the cheat sheet.
const COLUMN: usize = 17;

/// Draws the cheat sheet: groups of shortcuts in columns.
pub fn show_cheat_sheet(ctx: &egui::Context, open: &mut bool, groups: &[(&str, &[Shortcut])]) {
    let mut columns: Vec<(&str, Vec<(String, &str)>)> = Vec::new();
    for (name, shortcuts) in groups {
        let lines: Vec<_> = shortcuts.iter().map(|key| (key.text(ctx), key.action)).collect();
        // A long group goes on in the next column, without another heading.
        let parts = lines.chunks(COLUMN).enumerate();
        columns.extend(parts.map(|(part, lines)| (if part == 0 { *name } else { "" }, lines.to_vec())));
    }
    if let Some((_, first)) = columns.first_mut() {
        first.push((String::new(), ""));
        first.extend(MOUSE.map(|(keys, action)| (keys.to_owned(), action)));
    }
    let size = ctx.content_rect().size() - egui::vec2(40.0, 60.0);
    egui::Window::new("Keyboard and mouse")
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

fn show_column(ui: &mut egui::Ui, index: usize, lines: &[(String, &str)]) {
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
    use super::*;

    #[test]
    fn keys_are_written_in_letters_that_the_font_has() {
        let ctx = egui::Context::default();
        theme::install(&ctx);
        let _ = ctx.run_ui(egui::RawInput::default(), |_| {});
        for key in [
            Key::ArrowLeft,
            Key::ArrowRight,
            Key::ArrowUp,
            Key::ArrowDown,
            Key::OpenBracket,
            Key::Comma,
            Key::PageUp,
        ] {
            let text = Shortcut::key(key, "").text(&ctx);
            let font = egui::FontId::monospace(13.0);
            assert!(ctx.fonts_mut(|fonts| fonts.has_glyphs(&font, &text)), "{text}");
        }
    }
}
