//! The keyboard focus: a ring around the focused control, which is scrolled into view.

use egui::accesskit::{Action, ActionRequest, TreeId};
use egui::{Event, Id, Key, Stroke, StrokeKind, ViewportId};

use super::theme;

/// Shows the focus from when a key or a screen reader moves it until the pointer is used.
#[derive(Debug, Default)]
struct Ring {
    by_keys: bool,
    last: Option<Id>,
    hidden: Option<Id>,
}

impl egui::Plugin for Ring {
    fn debug_name(&self) -> &'static str {
        "focus ring"
    }

    fn input_hook(&mut self, _: &egui::Context, input: &mut egui::RawInput) {
        for event in &input.events {
            match event {
                Event::Key { key, pressed: true, .. } => self.by_keys |= moves_the_focus(*key),
                Event::AccessKitActionRequest(request) => self.by_keys |= request.action == Action::Focus,
                Event::PointerButton { .. } => self.by_keys = false,
                _ => {}
            }
        }
        if let Some(id) = self.hidden.take() {
            input.events.push(Event::AccessKitActionRequest(ActionRequest {
                action: Action::ScrollIntoView,
                target_tree: TreeId::ROOT,
                target_node: id.accesskit_id(),
                data: None,
            }));
        }
    }

    fn on_end_pass(&mut self, ui: &mut egui::Ui) {
        // On Escape egui drops the focus at the start of the next frame, before a shortcut can see that a text field had it.
        let (is_in_text, kept) = (ui.ctx().text_edit_focused(), in_text(ui.ctx().viewport_id()));
        ui.ctx().data_mut(|data| data.insert_temp(kept, is_in_text));
        let focused = ui.memory(|memory| memory.focused()).filter(|_| self.by_keys);
        let moved = std::mem::replace(&mut self.last, focused) != focused;
        let Some(control) = focused.and_then(|id| ui.ctx().read_response(id)) else { return };
        let seen = control.interact_rect;
        if moved && seen != control.rect {
            self.hidden = Some(control.id);
            ui.ctx().request_repaint();
        }
        if !seen.is_positive() {
            return;
        }
        let painter = ui.ctx().layer_painter(control.layer_id).with_clip_rect(seen.expand(4.0));
        // Of a control that fills the window it lies inside.
        let around = control.rect.expand(1.0).intersect(ui.ctx().content_rect().shrink(2.0));
        // A rim below it, so that it is seen on any ground.
        for (width, color) in [(4.0, ui.visuals().panel_fill), (2.0, theme::palette(ui).accent)] {
            painter.rect_stroke(around, 6.0, Stroke::new(width, color), StrokeKind::Middle);
        }
    }
}

/// Sets fonts, themes and the ring once, when a window opens.
pub fn install(ctx: &egui::Context) {
    theme::install(ctx);
    ctx.add_plugin(Ring::default());
    // Sizes are the preferences'; egui's own keys for them would take turns with ours.
    ctx.options_mut(|options| options.zoom_with_keyboard = false);
}

/// Calls the window `name` for screen readers: egui leaves the root of their tree without one.
pub fn name_window(ctx: &egui::Context, name: &str) {
    ctx.accesskit_node_builder(egui::accesskit_root_id(), |root| root.set_label(name));
}

/// Whether a text field, or a number that is being typed, had the focus at the end of the frame before.
pub fn was_in_text(ctx: &egui::Context) -> bool {
    let kept = in_text(ctx.viewport_id());
    ctx.data(|data| data.get_temp(kept)).unwrap_or_default()
}

/// Where that is kept, for each window.
fn in_text(window: ViewportId) -> Id {
    Id::unique(("focus in text", window))
}

fn moves_the_focus(key: Key) -> bool {
    matches!(key, Key::Tab | Key::ArrowLeft | Key::ArrowRight | Key::ArrowUp | Key::ArrowDown)
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;

    use super::*;

    #[test]
    fn the_ring_of_what_fills_the_window_lies_inside() {
        let fill = |ui: &mut egui::Ui| {
            let screen = ui.ctx().content_rect();
            let _ = ui.interact(screen, Id::unique("stage"), egui::Sense::click());
        };
        let mut window = Harness::builder().with_size(egui::vec2(300.0, 200.0)).build_ui(fill);
        install(&window.ctx);
        window.run_steps(2);
        window.key_press(Key::Tab);
        window.run_steps(3);
        let screen = window.ctx.content_rect().expand(0.01);
        let strokes = window.output().shapes.iter().filter_map(|clipped| match &clipped.shape {
            egui::Shape::Rect(rect) if rect.stroke.width >= 2.0 => Some(rect),
            _ => None,
        });
        let rings: Vec<egui::Rect> = strokes.map(|ring| ring.visual_bounding_rect()).collect();
        assert_eq!(rings.len(), 2, "{rings:?}");
        assert!(rings.iter().all(|ring| screen.contains_rect(*ring)), "{rings:?}");
    }
}
