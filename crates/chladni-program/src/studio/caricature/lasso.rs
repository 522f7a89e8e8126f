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

    /// Follows a drag on the shape and draws its line; returns the line once the button is released.
    pub fn follow(&mut self, ui: &Ui, response: &egui::Response) -> Option<Vec<Pos2>> {
        let primary = egui::PointerButton::Primary;
        if ui.input(|input| input.modifiers.alt) {
            return None; // Alt and drag turns the view.
        }
        if response.drag_started_by(primary) {
            self.line.clear();
            self.line.extend(ui.input(|input| input.pointer.press_origin()));
        }
        if response.dragged_by(primary)
            && let Some(at) = response.interact_pointer_pos()
            && self.line.last().is_none_or(|last| last.distance(at) >= STEP)
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
