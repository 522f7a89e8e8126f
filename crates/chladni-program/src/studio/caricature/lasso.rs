//! A line drawn around a part of the visible surface.

use chladni_caricature::{Action, Dab, LayerId, PaintEdit};
use egui::{Pos2, Stroke, Ui};

use super::edits::Edits;
use crate::studio::author_id::AuthorId;
use crate::studio::theme;

/// The line that is being drawn.
#[derive(Debug, Default)]
pub struct LassoTool {
    /// Whether a drag draws a line around the part to take.
    pub active: bool,
    line: Vec<Pos2>,
}

/// The least distance between two points of the line, in points of the screen.
const STEP: f32 = 3.0;

impl LassoTool {
    /// Draws what turns it on.
    pub fn show_switch(&mut self, ui: &mut Ui) {
        theme::checkbox(ui, &mut self.active, "Lasso").author_id("lasso").on_hover_text(
            "Draw around a part of what you see: it is painted, or, with Erase or Ctrl, taken away; what is hidden stays",
        );
    }

    /// Forgets a line that is not finished: the next drag begins another.
    pub fn let_go(&mut self) {
        self.line.clear();
    }

    /// Follows a drag on the shape and draws its line; returns the line once the button is released.
    pub fn follow(&mut self, ui: &Ui, response: &egui::Response) -> Option<Vec<Pos2>> {
        let primary = egui::PointerButton::Primary;
        let drawing = response.dragged_by(primary) || response.drag_stopped_by(primary);
        // Alt and drag turns the view; the release may come while Alt is down.
        if !drawing || ui.input(|input| input.modifiers.alt) {
            self.let_go();
            return None;
        }
        if response.drag_started_by(primary) {
            self.line.clear();
            self.line.extend(ui.input(|input| input.pointer.press_origin()));
        }
        if response.dragged_by(primary)
            && let Some(at) = response.interact_pointer_pos()
            && self.line.last().is_some_and(|last| last.distance(at) >= STEP)
        {
            self.line.push(at);
        }
        if response.drag_stopped_by(primary) {
            return Some(std::mem::take(&mut self.line)).filter(|line| line.len() > 2);
        }
        let stroke = Stroke::new(1.5, theme::palette(ui).warning);
        ui.painter().add(egui::Shape::closed_line(self.line.clone(), stroke));
        None
    }

    /// Paints the `vertices` that were encircled, or takes them away.
    pub fn take(vertices: Vec<u32>, intensity: f32, erase: bool, layer: LayerId, edits: &mut Edits) {
        if !vertices.is_empty() {
            let edit = PaintEdit::Dab(Dab::even(vertices, intensity, erase));
            edits.once(Action::Paint { layer, edit });
        }
    }
}

/// Whether `line`, closed, goes around a point an odd number of times.
pub fn encloses(line: &[Pos2], point: Pos2) -> bool {
    let ends = line.iter().skip(1).chain(line.first());
    let crosses = |(a, b): (&Pos2, &Pos2)| {
        (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    line.iter().zip(ends).filter(|sides| crosses(*sides)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn a_line_whose_release_alt_takes_is_gone() {
        let (ctx, mut lasso) = (egui::Context::default(), LassoTool::default());
        let mut step = |mut events: Vec<egui::Event>, modifiers: egui::Modifiers| {
            let (mut line, mut left) = (None, 0);
            events.insert(0, egui::Event::ModifiersChanged(modifiers));
            let input = egui::RawInput { events, ..egui::RawInput::default() };
            let _ = ctx.run_ui(input, |ui| {
                let size = egui::vec2(300.0, 300.0);
                let response = ui.allocate_response(size, egui::Sense::click_and_drag());
                line = lasso.follow(ui, &response);
                left = lasso.line.len();
            });
            (line, left)
        };
        let (none, alt) = (egui::Modifiers::NONE, egui::Modifiers::ALT);
        let moved = |x: f32, y: f32| vec![egui::Event::PointerMoved(pos2(x, y))];
        let button = |pressed: bool, modifiers: egui::Modifiers| {
            let (pos, button) = (pos2(150.0, 150.0), egui::PointerButton::Primary);
            vec![egui::Event::PointerButton { pos, button, pressed, modifiers }]
        };
        for with_alt in [false, true] {
            step(moved(150.0, 150.0), none);
            step(button(true, none), none);
            for (x, y) in [(170.0, 150.0), (190.0, 180.0), (150.0, 190.0)] {
                step(moved(x, y), none);
            }
            let drawn = step(moved(140.0, 170.0), none).1;
            assert!(drawn > 3, "{drawn} points");
            let release = if with_alt { alt } else { none };
            let (line, left) = step(button(false, release), release);
            assert_eq!((line.is_some(), left), (!with_alt, 0));
            assert_eq!(step(moved(150.0, 150.0), none), (None, 0));
        }
    }

    #[test]
    fn a_line_encloses_its_inside_and_not_its_bays() {
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)].map(|(x, y)| pos2(x, y));
        for (x, y, inside) in
            [(1.0, 1.0, true), (3.5, 2.0, true), (2.0, 2.0, false), (5.0, 1.0, false), (-1.0, 0.5, false)]
        {
            assert_eq!(encloses(&line, pos2(x, y)), inside, "{x}, {y}");
        }
        assert!(!encloses(&line[..1], pos2(0.0, 0.0)) && !encloses(&[], pos2(0.0, 0.0)));
    }
}
