//! The name and the cover of the song that is heard, on stage for a while after it has begun.

use egui::{Align2, Color32, FontId, Rect, TextureHandle, Ui, pos2, vec2};

use super::listening::Listening;
use crate::work::{COVER, GAP, TITLE, title_opacity};

/// The song that is heard, and since when.
#[derive(Default)]
pub struct SongTitle {
    text: String,
    cover: Option<TextureHandle>,
    since_secs: f64,
}

impl SongTitle {
    /// Takes in the song at this time of the window.
    pub fn follow(&mut self, listening: &Listening, now_secs: f64) {
        let text = listening.source_name();
        if self.text != text {
            (self.text, self.since_secs) = (text, now_secs);
        }
        self.cover = listening.source_cover().cloned();
    }

    /// Draws it over the stage, which fills `screen` and is as `light` as this, in [0, 1].
    pub fn show(&self, ui: &Ui, screen: Rect, now_secs: f64, light: f32) {
        let opacity = title_opacity(now_secs - self.since_secs) * light;
        if opacity <= 0.0 {
            return;
        }
        let [size, left, bottom] = TITLE;
        let mut at = screen.left_bottom() + vec2(left, -bottom);
        if let Some(cover) = &self.cover {
            let pixels = cover.size_vec2();
            let shown = pixels * (COVER * size / pixels.max_elem().max(1.0));
            let place = Rect::from_min_max(at - vec2(0.0, shown.y), at + vec2(shown.x, 0.0));
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(cover.id(), place, whole, Color32::from_white_alpha((255.0 * opacity) as u8));
            at.x += shown.x + GAP * size;
        }
        let color = Color32::from_white_alpha((220.0 * opacity) as u8);
        ui.painter().text(at, Align2::LEFT_BOTTOM, &self.text, FontId::proportional(size), color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_not_seen_where_the_stage_is_black() {
        let title = SongTitle { text: "A song".into(), ..SongTitle::default() };
        let letters = |light: f32| {
            let ctx = egui::Context::default();
            let output =
                ctx.run_ui(egui::RawInput::default(), |ui| title.show(ui, ui.max_rect(), 2.0, light));
            let is_text = |shape: &&egui::epaint::ClippedShape| matches!(shape.shape, egui::Shape::Text(_));
            output.shapes.iter().filter(is_text).count()
        };
        assert_eq!((letters(0.0), letters(1.0)), (0, 1));
    }
}
