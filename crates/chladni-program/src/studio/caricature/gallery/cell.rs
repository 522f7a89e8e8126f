//! One of the twelve: its marks, and its buttons and keys.

use std::sync::Arc;

use egui::text::LayoutJob;
use egui::{Align2, Color32, Galley, Rect, Sense, Stroke, TextStyle, Ui, vec2};

use crate::studio::author_id::AuthorId;
use crate::studio::context_menu;
use crate::studio::icon::{self, Icon};
use crate::studio::keys::breeding::{CHOOSE, FAVORITE, LOCK, MUTATE, TAKE};
use crate::studio::shortcut::Shortcut;
use crate::studio::theme;
use crate::work::{Error, Exhibition};

const ACCENT: Color32 = Color32::from_rgb(226, 166, 70);

/// A wish about a caricature that its gallery alone cannot fulfill.
pub enum Wanted {
    /// It is to become layers.
    Taken,
    /// It is to be changed a little.
    Changed,
}

/// Shows the marks of a caricature at `place` and does the action that was clicked or pressed; keys are for the
/// `marked` one. Marks are set only on a gallery that is `idle`: one that is bred on comes back with those that it had.
pub fn show(
    ui: &mut Ui,
    place: Rect,
    index: usize,
    marked: &mut usize,
    shown: &mut Exhibition,
    idle: bool,
) -> Result<Option<Wanted>, Error> {
    let response = ui.interact(place, ui.scope_id().with(("caricature", index)), Sense::click());
    if response.contains_pointer() && ui.input(|input| input.pointer.is_moving()) || response.gained_focus() {
        *marked = index;
    }
    let is_marked = index == *marked;
    let pressed = |key: Shortcut| is_marked && key.pressed(ui.ctx());
    let (gallery, sitter) = (&mut shown.gallery, &shown.sitter);
    let Some(item) = gallery.generations().items().get(index).cloned() else { return Ok(None) };
    let favorite = gallery.is_favorite(item.id);
    let title = format!("Caricature {}", index + 1);
    let doing = sitter.title(&item.genome);
    response.widget_info(|| egui::WidgetInfo {
        current_text_value: Some(in_words(favorite, item.locked, &doing)),
        ..egui::WidgetInfo::selected(egui::Role::CheckBox, true, item.chosen, &title)
    });
    let response = response.author_id(format!("caricature/{}", index + 1));
    let words = is_marked.then(|| laid_out(ui, place, &doing));
    let response = if words.as_ref().is_some_and(|words| words.elided) {
        response.on_hover_text(&doing)
    } else {
        response
    };
    frame(ui, place, index, (item.chosen, favorite, item.locked), words);
    let (mut takes, mut favors, mut locks, mut changes) =
        (pressed(TAKE) || response.double_clicked(), pressed(FAVORITE), pressed(LOCK), pressed(MUTATE));
    context_menu::show(&response, |ui| {
        takes |= wish(ui, Icon::Check, "Take it: it becomes layers");
        favors |= wish(ui, Icon::Star, if favorite { "No favorite any more" } else { "Favorite" });
        locks |= wish(ui, Icon::Lock, if item.locked { "Unlock" } else { "Lock in its place" });
        changes |= wish(ui, Icon::Dices, "Change a little");
    });
    if !idle {
        return Ok(takes.then_some(Wanted::Taken));
    }
    // The second click of a double click takes back the choice of the first.
    if response.clicked() || pressed(CHOOSE) {
        gallery.choose(index, !item.chosen)?;
    }
    if favors {
        gallery.favor(index, !favorite)?;
    }
    if locks {
        gallery.lock_place(index, !item.locked)?;
    }
    Ok(if takes { Some(Wanted::Taken) } else { changes.then_some(Wanted::Changed) })
}

/// The marks of a caricature and its effect, for screen readers.
fn in_words(favorite: bool, locked: bool, doing: &str) -> String {
    let marks = [(favorite, "favorite"), (locked, "locked"), (true, doing)];
    marks.iter().filter(|mark| mark.0).map(|mark| mark.1).collect::<Vec<_>>().join(", ")
}

/// A line of the menu; true where it was clicked.
fn wish(ui: &mut Ui, mark: Icon, name: &str) -> bool {
    context_menu::entry(ui, true, icon::label(mark, name)).clicked()
}

/// The effect of the marked one, of which a small cell shows only the beginning: most of it is left to the picture.
fn laid_out(ui: &Ui, cell: Rect, doing: &str) -> Arc<Galley> {
    let (font, weak) = (TextStyle::Small.resolve(ui.style()), theme::palette(ui).weak);
    let mut job = LayoutJob::simple(doing.to_owned(), font, weak, cell.width() - 18.0);
    job.wrap.max_rows = ((cell.height() / 3.0 / ui.text_style_height(&TextStyle::Small)) as usize).max(1);
    ui.painter().layout_job(job)
}

/// The edge of a cell with its marks; for the marked one also its effect in words.
fn frame(
    ui: &Ui,
    cell: Rect,
    index: usize,
    (chosen, favorite, locked): (bool, bool, bool),
    words: Option<Arc<Galley>>,
) {
    let palette = theme::palette(ui);
    let border = match (chosen, words.is_some()) {
        (true, _) => Stroke::new(3.0, ACCENT),
        (false, true) => Stroke::new(1.5, palette.weak),
        (false, false) => Stroke::new(1.0, palette.weak.gamma_multiply(0.2)),
    };
    let painter = ui.painter().with_clip_rect(cell);
    painter.rect_stroke(cell, 6.0, border, egui::StrokeKind::Inside);
    let font = TextStyle::Small.resolve(ui.style());
    let number = (index + 1).to_string();
    painter.text(cell.right_top() + vec2(-9.0, 8.0), Align2::RIGHT_TOP, number, font, palette.weak);
    let marks = [(chosen, Icon::CircleCheck), (favorite, Icon::Star), (locked, Icon::Lock)];
    let marks: Vec<String> = marks.iter().filter(|mark| mark.0).map(|mark| icon::text(mark.1)).collect();
    let large = egui::FontId::proportional(15.0);
    painter.text(cell.left_top() + vec2(9.0, 8.0), Align2::LEFT_TOP, marks.join(" "), large, ACCENT);
    if let Some(text) = words {
        let at = cell.left_bottom() + vec2(9.0, -8.0 - text.size().y);
        // It lies on the picture, which may be dark where the theme is light.
        let ground = Rect::from_min_size(at, text.size()).expand(4.0);
        painter.rect_filled(ground, 4.0, palette.stage.gamma_multiply(0.85));
        painter.galley(at, text, palette.weak);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_leave_most_of_a_small_cell_to_the_picture() {
        let doing = "Exaggerates broad forms along the surface, and what is fine by its distance";
        let _ = egui::Context::default().run_ui(egui::RawInput::default(), |ui| {
            let [small, large] = [80.0, 320.0].map(|side| {
                let cell = Rect::from_min_size(egui::Pos2::ZERO, egui::Vec2::splat(side));
                let words = laid_out(ui, cell, doing);
                assert!(words.size().y < 0.4 * side, "{:?}", words.size());
                words
            });
            assert!(small.elided && !large.elided);
        });
    }
}
