//! A key and its action.

use egui::{Event, InputState, Key, KeyboardShortcut, Modifiers};

use super::focus;

/// A key and its action, in the words of the window.
#[derive(Clone, Copy, Debug)]
pub struct Shortcut {
    /// The key with its modifiers.
    pub keys: KeyboardShortcut,
    /// Its action, in words.
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

    /// A key with Ctrl, also on a Mac.
    pub const fn control(key: Key, action: &'static str) -> Self {
        Self { keys: KeyboardShortcut::new(Modifiers::CTRL, key), action }
    }

    /// A key with Ctrl (⌘) and Shift.
    pub const fn command_shift(key: Key, action: &'static str) -> Self {
        let modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };
        Self { keys: KeyboardShortcut::new(modifiers, key), action }
    }

    /// Whether it was pressed in this frame, neither for the control that has the focus nor while the window
    /// [is asked](is_asked) something; consumes the key. Held down, it counts again only if it goes step by step.
    pub fn pressed(&self, ctx: &egui::Context) -> bool {
        !is_asked(ctx) && self.pressed_anywhere(ctx)
    }

    /// The same, also while the window [is asked](is_asked) something: for keys of the window itself.
    pub fn pressed_anywhere(&self, ctx: &egui::Context) -> bool {
        let key = self.keys.logical_key;
        let taken = match self.keys.modifiers {
            Modifiers::NONE => is_taken(ctx, key),
            // With Ctrl, a text field has undo, redo, the clipboard and the whole text.
            _ => ctx.text_edit_focused() && EDITING.contains(&key),
        };
        !taken && ctx.input_mut(|input| take(input, &self.keys))
    }

    /// Whether a key without modifiers is down, neither for the control that has the focus nor while the window
    /// [is asked](is_asked) something.
    pub fn held(&self, ctx: &egui::Context) -> bool {
        let key = self.keys.logical_key;
        ctx.input(|input| input.key_down(key)) && !is_taken(ctx, key) && !is_asked(ctx)
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

/// Keys that edit text together with Ctrl.
const EDITING: [Key; 6] = [Key::Z, Key::Y, Key::X, Key::C, Key::V, Key::A];

/// Keys that go on step by step while they are held down; every other key acts once.
const STEPPING: [Key; 13] = [
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::ArrowUp,
    Key::ArrowDown,
    Key::Comma,
    Key::Period,
    Key::OpenBracket,
    Key::CloseBracket,
    Key::Plus,
    Key::Equals,
    Key::Minus,
    // With Ctrl: back and forth.
    Key::Z,
    Key::Y,
];

/// By how many steps the control that has the focus goes on: presses of `more` without Ctrl, less those of `less`. Takes
/// them out of the input.
pub fn steps(ui: &egui::Ui, more: Key, less: Key) -> f32 {
    ui.input_mut(|input| {
        let mut presses = |key| input.count_and_consume_key(Modifiers::NONE, key) as f32;
        presses(more) - presses(less)
    })
}

/// Takes the presses of `keys` out of the input; whether there was one that counts.
fn take(input: &mut InputState, keys: &KeyboardShortcut) -> bool {
    let steps = STEPPING.contains(&keys.logical_key);
    let mut counts = false;
    input.events.retain(|event| {
        let Event::Key { key, pressed: true, repeat, modifiers, .. } = event else { return true };
        let is_it = *key == keys.logical_key && modifiers.matches_logically(keys.modifiers);
        counts |= is_it && (steps || !*repeat);
        !is_it
    });
    counts
}

/// Whether a question, a choice, a menu or the sheet of keys stands in front of everything else: it has the keys.
pub fn is_asked(ctx: &egui::Context) -> bool {
    let is_below = !ctx.memory(|memory| memory.is_above_modal_layer(egui::LayerId::background()));
    is_below || egui::Popup::is_any_open(ctx)
}

/// Whether the control with the focus wants `key` for itself: a text field all of them, another control those
/// that click it, change it or lead to the next one.
fn is_taken(ctx: &egui::Context, key: Key) -> bool {
    let controls = matches!(
        key,
        Key::Space | Key::Enter | Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown
    );
    // A field that Escape has just left had that key.
    let in_text = ctx.text_edit_focused() || key == Key::Escape && focus::was_in_text(ctx);
    in_text || controls && ctx.egui_wants_keyboard_input()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_held_down_acts_once_unless_it_goes_step_by_step() {
        for (key, steps) in [(Key::Space, false), (Key::ArrowRight, true), (Key::OpenBracket, true)] {
            let (ctx, shortcut) = (egui::Context::default(), Shortcut::key(key, "Act"));
            let pressed = |pressed: bool| {
                let modifiers = Modifiers::NONE;
                let event = Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
                let input = egui::RawInput { events: vec![event], ..egui::RawInput::default() };
                let mut acts = false;
                let _ = ctx.run_ui(input, |ui| acts = shortcut.pressed(ui.ctx()));
                acts
            };
            // The window tells by itself which presses are repeats.
            assert_eq!([true, true, false, true].map(pressed), [true, steps, false, true], "{key:?}");
        }
    }

    #[test]
    fn an_open_menu_has_the_keys() {
        let acts = |opens: bool| {
            let (ctx, shortcut) = (egui::Context::default(), Shortcut::key(Key::Escape, "Leave"));
            let (key, modifiers) = (Key::Escape, Modifiers::NONE);
            let event = Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
            let input = egui::RawInput { events: vec![event], ..egui::RawInput::default() };
            let mut acts = [false; 2];
            let _ = ctx.run_ui(input, |ui| {
                if opens {
                    egui::Popup::open_id(ui.ctx(), egui::Id::unique("menu"));
                }
                acts = [shortcut.held(ui.ctx()), shortcut.pressed(ui.ctx())];
            });
            acts
        };
        assert_eq!([true, false].map(acts), [[false; 2], [true; 2]]);
    }
}
