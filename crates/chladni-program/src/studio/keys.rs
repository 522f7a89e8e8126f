//! Every key of the window: the one table used by handlers, tooltips and the F1 page.

use egui::Key;

use super::shortcut::Shortcut;

/// A group of keys, in the order in which F1 shows them.
macro_rules! keys {
    ($(#[$about:meta])* $group:ident: $($name:ident = $kind:ident $key:ident, $action:literal;)+) => {
        $(#[$about])*
        pub mod $group {
            use super::{Key, Shortcut};

            $(
                #[doc = $action]
                pub const $name: Shortcut = Shortcut::$kind(Key::$key, $action);
            )+

            /// All of them.
            pub const ALL: &[Shortcut] = &[$($name),+];
        }
    };
}

keys! {
    /// Everywhere.
    window:
    HELP = key F1, "Show all keys";
    SWITCH_ROOM = control Tab, "The other room";
    ZOOM_IN = command Plus, "Larger text and controls";
    ZOOM_OUT = command Minus, "Smaller text and controls";
    ZOOM_RESET = command Num0, "Text and controls of the usual size";
    FULL_SCREEN = key F11, "Full screen";
}

keys! {
    /// On the start screen.
    start:
    OPEN = command O, "Open meshes, a song or a project";
}

keys! {
    /// In every 3D view, as in Blender.
    view:
    FRONT = key Num1, "Look from the front";
    RIGHT = key Num3, "Look from the right";
    ABOVE = key Num7, "Look from above";
    THREE_QUARTER = key Num5, "Three-quarter view";
    FIT = key Home, "Show all of it";
}

keys! {
    /// In the caricature room.
    caricature:
    OPEN = command O, "Open a mesh or project";
    SAVE = command S, "Save the project";
    SAVE_AS = command_shift S, "Save under another name";
    EXPORT = command E, "Export";
    UNDO = command Z, "Undo";
    REDO = command_shift Z, "Redo";
    REDO_BY_Y = command Y, "Redo";
    ADD_MESH = command T, "Compare with a mesh: a new layer";
    DUPLICATE = command D, "Duplicate the layer";
    DELETE = key Delete, "Delete the layer";
    RENAME = key F2, "Rename the layer";
    ABOVE = key PageUp, "Select the layer above";
    BELOW = key PageDown, "Select the layer below";
    RAISE = command PageUp, "Move the layer up";
    LOWER = command PageDown, "Move the layer down";
    HIDE = key H, "Hide or show the layer";
    SOLO = key S, "Only this layer, or all again";
    NEXT_MODEL = key M, "Next model";
    STRONGER = key Comma, "Exaggerate more: μ a step down";
    WEAKER = key Period, "Exaggerate less: μ a step up";
    FURTHEST = key E, "As far as it goes with hardly a fold";
    BRUSH = key B, "Paint the region";
    ERASE = key X, "Paint or erase";
    INVERT = key I, "Invert the region";
    SMALLER = key OpenBracket, "Smaller brush";
    LARGER = key CloseBracket, "Larger brush";
    LANDMARKS = key L, "Pick landmarks on both shapes";
    LEAVE = key Escape, "Leave picking or painting";
    COMPARE = key C, "Hold to see the original";
    NEXT_SHOW = key V, "Result, three models, before and after, beside the template";
    WIRE = key W, "Edges of triangles";
    INK = key P, "A drawing in ink on paper";
    GALLERY = key G, "A gallery of caricatures to choose from";
    FIT = key F, "Show all of it";
}

keys! {
    /// In the gallery of caricatures, as in that of dances.
    breeding:
    BREED = key Enter, "Breed the chosen ones";
    BACK = command Z, "Back to the generation of the parents";
    MARK_LEFT = key ArrowLeft, "Mark the caricature to the left";
    MARK_RIGHT = key ArrowRight, "Mark the caricature to the right";
    MARK_ABOVE = key ArrowUp, "Mark the caricature above";
    MARK_BELOW = key ArrowDown, "Mark the caricature below";
    CHOOSE = key C, "Choose the marked caricature as a parent, or no longer";
    FAVORITE = key F, "Favorite";
    LOCK = key L, "Lock in its place";
    MUTATE = key M, "Change it a little";
    TAKE = key S, "Take it: it becomes layers";
    SURPRISE = key R, "Surprise me";
    LEAVE = key Escape, "Leave the gallery";
}

keys! {
    /// In the music room.
    music:
    OPEN = command O, "Open a shape, songs, a preset or a show";
    SAVE = command S, "Save the show";
    FILM = command E, "Film what dances";
    RECORD = command R, "Record the set, or end that";
    PLAY = key Space, "Play or pause";
    NEXT_SONG = key PageDown, "The next song";
    PREVIOUS_SONG = key PageUp, "The song before";
    SHUFFLE = key J, "The songs in another order";
    REPEAT = key P, "Repeat nothing, the song or the list";
    LIVE = key I, "Live input, or the songs again";
    FOLLOW_CLOCK = key O, "Follow MIDI clock and OSC, or the music again";
    TAP = key T, "Tap the beat";
    HALVE = key OpenBracket, "The beat half as fast";
    DOUBLE = key CloseBracket, "The beat twice as fast";
    LOCK_BEAT = key K, "Hold the tempo, or listen again";
    NUDGE_BACK = key Comma, "The beat a little later";
    NUDGE_ON = key Period, "The beat a little sooner";
    BREED = key Enter, "Breed the chosen ones";
    BACK = command Z, "Back to the generation of the parents";
    FORTH = command_shift Z, "On to the generation after";
    FORTH_BY_Y = command Y, "On to the generation after";
    MARK_LEFT = key ArrowLeft, "Mark the dance to the left (on stage: the one before)";
    MARK_RIGHT = key ArrowRight, "Mark the dance to the right (on stage: the one after)";
    MARK_ABOVE = key ArrowUp, "Mark the dance above";
    MARK_BELOW = key ArrowDown, "Mark the dance below";
    CHOOSE = key C, "Choose the marked dance as a parent, or no longer";
    FAVORITE = key F, "Favorite";
    LOCK = key L, "Lock in its place";
    MUTATE = key M, "Change it a little";
    DRAW = key E, "Name it and draw its curves";
    STAGE = key S, "Put it on stage";
    SHOW = key G, "Put the favorites on stage";
    AUTOPILOT = key A, "Lean back: the autopilot, on or off";
    HOLD = key H, "The autopilot stays with this dance, or goes on";
    NEXT_UP = key N, "Next on stage: the marked dance";
    GO = key R, "On stage: bring the next dance";
    BLACKOUT = key B, "On stage: black, or back";
    FREEZE = key X, "On stage: the picture stands still, or goes on";
    LEAVE = key Escape, "Leave the stage, or back to the gallery";
}

keys! {
    /// While taps measure how late the picture is.
    calibrating:
    TAP_BY_SPACE = key Space, "Tap with each click, then with each flash";
    TAP_BY_ENTER = key Enter, "Tap with each click, then with each flash";
    TAP_BY_LETTER = key T, "Tap with each click, then with each flash";
    LEAVE = key Escape, "Leave it as it was";
}

keys! {
    /// In the form of a film.
    filming:
    LEAVE = key Escape, "Close the form without a film";
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    const ROOMS: [&[Shortcut]; 6] =
        [start::ALL, caricature::ALL, breeding::ALL, music::ALL, calibrating::ALL, filming::ALL];

    #[test]
    fn no_key_does_two_things_in_one_place() {
        for room in ROOMS {
            let all = [window::ALL, view::ALL, room].concat();
            let mut seen = HashSet::new();
            for shortcut in all {
                let keys = (shortcut.keys.modifiers, shortcut.keys.logical_key);
                assert!(seen.insert(keys), "{keys:?} also does: {}", shortcut.action);
            }
        }
    }

    #[test]
    fn keys_are_written_in_letters_that_the_font_has() {
        let ctx = egui::Context::default();
        crate::studio::theme::install(&ctx);
        let _ = ctx.run_ui(egui::RawInput::default(), |_| {});
        for shortcut in [window::ALL, view::ALL].into_iter().chain(ROOMS).flatten() {
            let (text, font) = (shortcut.text(&ctx), egui::FontId::monospace(13.0));
            assert!(ctx.fonts_mut(|fonts| fonts.has_glyphs(&font, &text)), "{text}");
        }
    }
}
