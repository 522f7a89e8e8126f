//! The name and the cover of the song that is heard, on stage for a while after it has begun.

use std::sync::Arc;

use chladni_view::Picture;
use egui::{Align2, Color32, Rect, TextureHandle, Ui, vec2};

use super::legible::{self, Anchored};
use super::listening::Listening;
use super::projection::Projection;
use crate::work::{COVER, Caption, GAP, TITLE, title_opacity};

/// The song that is heard, and since when.
#[derive(Default)]
pub struct SongTitle {
    caption: Caption,
    cover: Option<TextureHandle>,
    /// As the show numbers it: another song may have the same title.
    song: Option<usize>,
    since_secs: f64,
    /// How many songs were named before.
    number: u64,
    is_hidden: bool,
}

/// A title as it is seen in one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenTitle {
    number: u64,
    opacity: f32,
}

impl SongTitle {
    /// Takes in the song at this time of the window, and whether it is to be named.
    pub fn follow(&mut self, listening: &Listening, now_secs: f64, is_shown: bool) {
        self.is_hidden = !is_shown;
        // A live input is no song.
        let text = if listening.live().is_some() { String::new() } else { listening.source_name() };
        let song = listening.song_number();
        if self.caption.text != text || self.song != song {
            self.song = song;
            (self.since_secs, self.number) = (now_secs, self.number + 1);
            (self.caption, self.cover) = (Caption::new(text, None), None);
        }
        let cover = listening.source_cover();
        let picture = cover.map(|cover| &cover.picture);
        if self.caption.cover.as_ref().map(Arc::as_ptr) != picture.map(Arc::as_ptr) {
            self.caption = Caption::new(std::mem::take(&mut self.caption.text), picture.cloned());
            self.cover = cover.map(|cover| cover.texture.clone());
        }
    }

    /// The cover is shown by another window from now on.
    pub fn change_device(&mut self) {
        (self.caption, self.cover) = (Caption::new(std::mem::take(&mut self.caption.text), None), None);
    }

    /// How opaque it is on a stage in full light, in [0, 1].
    pub fn opacity(&self, now_secs: f64) -> f32 {
        if self.is_hidden { 0.0 } else { title_opacity(now_secs - self.since_secs) }
    }

    /// It, as opaque as this, for a picture that is finished later.
    pub fn seen(&self, opacity: f32) -> SeenTitle {
        SeenTitle { number: self.number, opacity }
    }

    /// Draws it over a picture in which it was seen so; another song has another title.
    pub fn lay(&mut self, picture: &mut Picture, seen: SeenTitle) {
        if seen.number == self.number && !self.caption.text.is_empty() {
            self.caption.lay(picture, seen.opacity);
        }
    }

    /// Draws it over the stage, which fills `screen`, as the projector needs it, as opaque as this.
    pub fn show(&self, ui: &Ui, screen: Rect, projection: Projection, opacity: f32) {
        if opacity <= 0.0 || self.caption.text.is_empty() {
            return;
        }
        let [size, left, bottom] = TITLE;
        let mut at = screen.left_bottom() + vec2(left, -bottom);
        if let Some(cover) = &self.cover {
            let pixels = cover.size_vec2();
            let shown = pixels * (COVER * size / pixels.max_elem().max(1.0));
            let place = Rect::from_min_max(at - vec2(0.0, shown.y), at + vec2(shown.x, 0.0));
            let tint = Color32::from_white_alpha((255.0 * opacity) as u8);
            projection.paint_part(ui, (screen, place), cover.id(), tint);
            at.x += shown.x + GAP * size;
        }
        let place = Anchored { at, anchor: Align2::LEFT_BOTTOM, width: screen.right() - left - at.x };
        let (corner, text) = legible::laid_out(ui, place, &self.caption.text, size);
        let text = projection.bent(screen, corner, text);
        legible::halo(ui, corner, &text, size, opacity);
        let white = Color32::from_white_alpha((220.0 * opacity) as u8);
        ui.painter().galley(corner, text, projection.trimmed(white));
    }
}

#[cfg(test)]
mod tests {
    use super::super::listening::ShowSong;
    use super::*;
    use chladni_music::{BeatReading, ClockTrack, Moment, Stretch};

    fn titled() -> SongTitle {
        SongTitle { caption: Caption::new("A song".into(), None), ..SongTitle::default() }
    }

    #[test]
    fn a_live_input_has_no_title() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let mut title = SongTitle::default();
        title.follow(&listening, 1.0, true);
        assert!(!title.caption.text.is_empty());
        let (capture, _feed) = chladni_sound::Capture::fed(48_000).unwrap();
        listening.listen_on(capture, "Built-in microphone".into());
        title.follow(&listening, 2.0, true);
        assert_eq!(title.caption.text, "");
        let mut picture = Picture::filled(320, 180, [0, 0, 0, 255]);
        title.lay(&mut picture, title.seen(1.0));
        assert!(picture.rgba.chunks(4).all(|p| p[0] == 0));
    }

    #[test]
    fn the_second_of_two_songs_of_one_title_is_named_too() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let songs = ["a/01.wav", "b/01.wav"].map(|path| ShowSong::new(path.into(), BeatReading::default()));
        let mut title = SongTitle::default();
        let mut named = |song: usize, now_secs: f64| {
            let song = Some(song);
            let heard = Stretch { at_secs: 0.0, song, song_secs: 0.0, playing: true, crossfade_secs: 0.0 };
            listening.go_on(songs.to_vec(), &[heard], ClockTrack::default(), Moment::default());
            title.follow(&listening, now_secs, true);
            (title.caption.text.clone(), title.since_secs)
        };
        let since = |at_secs: f64| ("01".to_owned(), at_secs);
        assert_eq!([named(0, 1.0), named(0, 50.0), named(1, 90.0)], [since(1.0), since(1.0), since(90.0)]);
    }

    #[test]
    fn it_is_not_seen_where_the_stage_is_black() {
        let title = titled();
        let letters = |opacity: f32| {
            let ctx = egui::Context::default();
            let output = ctx.run_ui(egui::RawInput::default(), |ui| {
                title.show(ui, ui.max_rect(), Projection::default(), opacity);
            });
            let is_text = |shape: &&epaint::ClippedShape| matches!(shape.shape, egui::Shape::Text(_));
            output.shapes.iter().filter(is_text).count()
        };
        // Eight times for the halo, and once in white.
        assert_eq!((letters(0.0), letters(1.0)), (0, 9));
    }

    #[test]
    fn it_lies_on_the_wall_in_its_colors() {
        let title = titled();
        let corners = [[0.3, 0.2], [0.7, 0.2], [0.7, 0.6], [0.3, 0.6]];
        let projection = Projection { corners, trim: [1.0, 0.0, 0.5] };
        let mut wall = Rect::NOTHING;
        let output = egui::Context::default().run_ui(egui::RawInput::default(), |ui| {
            let screen = ui.max_rect();
            let at = |x: f32, y: f32| screen.min + vec2(x, y) * screen.size();
            // The halo stands out by some points.
            wall = Rect::from_min_max(at(0.3, 0.2), at(0.7, 0.6)).expand(4.0);
            title.show(ui, screen, projection, 1.0);
        });
        let texts: Vec<&epaint::TextShape> = output
            .shapes
            .iter()
            .filter_map(|shape| if let egui::Shape::Text(text) = &shape.shape { Some(text) } else { None })
            .collect();
        assert_eq!(texts.len(), 9);
        for text in &texts {
            let bounds = text.visual_bounding_rect();
            assert!(bounds.is_positive() && wall.contains_rect(bounds), "{bounds:?} {wall:?}");
        }
        let [r, g, b, a] = texts[8].fallback_color.to_array();
        assert!((r, g, a) == (220, 0, 220) && (109..112).contains(&b), "{b}");
    }

    #[test]
    fn other_programs_see_it_in_pictures_of_its_song_only() {
        let mut title = titled();
        let light = |title: &mut SongTitle, seen: SeenTitle| {
            let mut picture = Picture::filled(320, 180, [0, 0, 0, 255]);
            title.lay(&mut picture, seen);
            picture.rgba.chunks(4).map(|p| u32::from(p[0])).sum::<u32>()
        };
        let (dim, bright) = (title.seen(0.3), title.seen(title.opacity(2.0)));
        assert!(light(&mut title, dim) > 1000 && light(&mut title, bright) > light(&mut title, dim));
        title.number += 1;
        assert_eq!(light(&mut title, bright), 0);
        title.is_hidden = true;
        assert_eq!(title.opacity(2.0), 0.0);
    }
}
