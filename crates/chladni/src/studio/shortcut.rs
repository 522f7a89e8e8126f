//! Keys and what they do: one list feeds the handlers, the tooltips and the cheat sheet.

use egui::{Key, KeyboardShortcut, Modifiers};

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

    /// Whether it was pressed in this frame, outside text fields; consumes the key.
    pub fn pressed(&self, ctx: &egui::Context) -> bool {
        let typing = ctx.egui_wants_keyboard_input() && self.keys.modifiers == Modifiers::NONE;
        !typing && ctx.input_mut(|input| input.consume_shortcut(&self.keys))
    }

    /// "action (Ctrl+S)", for a tooltip.
    pub fn tooltip(&self, ctx: &egui::Context) -> String {
        format!("{} ({})", self.action, ctx.format_shortcut(&self.keys))
    }
}

/// Draws the cheat sheet: groups of shortcuts in columns.
pub fn show_cheat_sheet(ctx: &egui::Context, open: &mut bool, groups: &[(&str, &[Shortcut])]) {
    egui::Window::new("Keyboard")
        .open(open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ctx, |ui| {
            ui.horizontal_top(|ui| {
                for (name, shortcuts) in groups {
                    ui.vertical(|ui| {
                        ui.set_min_width(230.0);
                        ui.strong(*name);
                        egui::Grid::new(*name).num_columns(2).show(ui, |ui| {
                            for shortcut in *shortcuts {
                                ui.monospace(ctx.format_shortcut(&shortcut.keys));
                                ui.label(shortcut.action);
                                ui.end_row();
                            }
                        });
                    });
                }
            });
        });
}
