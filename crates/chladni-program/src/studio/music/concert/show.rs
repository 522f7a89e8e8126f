//! One frame of the music room: heard, danced, deformed, drawn, and its overlay.

use std::time::Instant;

use chladni_music::{Framing, Mapping, Moment, Settings};
use chladni_synth::{Coefficients, FrameSettings, Item};
use chladni_view::Rect;
use egui::{Response, Ui};

use super::super::close_up;
use super::super::gallery;
use super::super::listening::Listening;
use super::super::view::View;
use super::super::wish::Wish;
use super::Concert;
use super::apart::Apart;
use super::coarse;
use super::frame::Frame;
use super::pace::Change;
use super::stillness;
use super::viewpoint::{camera_at, navigate, touches};
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::studio::viewport;
use crate::studio::{PlayedFrame, Trace};
use crate::work::{Error, Staging, look_on_stage, reaction};

/// The matter of notices about how many harmonics are in use.
const HARMONICS: &str = "harmonics in use";

impl Concert {
    /// Hears, deforms and draws one frame, and handles clicks on it.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        shared: &mut Shared<'_>,
        listening: &mut Listening,
        trace: Option<&Trace>,
        wishes: &mut Vec<Wish>,
    ) -> Result<(), Error> {
        let began = (shared.now)();
        let whole = viewport::whole_pixels(ui);
        self.seconds = ui.input(|input| input.time);
        self.backcloth.follow(shared);
        self.moving = self.backcloth.moves();
        if listening.beats_changed() {
            self.count_beats(|moment| listening.beats_at(moment))?;
        }
        listening.set_seed(self.instrument.seed());
        self.follow_bars(&listening.new_bars())?;
        self.judge(ui.ctx())?;
        let (mut frame, mut items) = self.play(shared, listening, began)?;
        // Name and number are those of one song only once the frame has been heard.
        self.song_title.follow(listening, self.seconds, shared.settings.music.song_titles);
        if frame.is_apart {
            let framing = frame.framing(&self.instrument, listening);
            let before = (shared.now)();
            self.beside(|concert, apart| {
                concert.show_apart(ui.ctx(), shared, apart, &frame, framing, wishes)
            })?;
            // Fewer harmonics would not make that faster.
            frame.began += (shared.now)().saturating_duration_since(before);
        } else if let Some(apart) = &mut self.apart {
            apart.leave();
        }
        self.draws_stage = frame.shows_stage();
        if let View::Harmonics(first) = self.view
            && !self.draws_stage
        {
            return self.show_harmonics(ui, whole, first);
        }
        if self.draws_stage && self.house.frozen && self.pane.shown.is_some() {
            return self.repaint(ui, shared.settings.music.projection, whole);
        }
        if let (Some(trace), Some(item)) = (trace, items.first()) {
            trace.borrow_mut().push(played(&frame, item));
        }
        let count = items.len();
        let pose = self.deform(shared, &frame, &mut items)?;
        self.show_items(ui, shared, listening, (&frame, count, pose), whole, wishes)
    }

    /// Hears the current sound, and lets all visible items dance to it.
    fn play(
        &mut self,
        shared: &mut Shared<'_>,
        listening: &mut Listening,
        began: Instant,
    ) -> Result<(Frame, Vec<Item>), Error> {
        let tried_out = self.tried_out.take().or_else(|| self.close_up_mapping());
        // On stage sand lies on the dance there.
        let solo = tried_out.as_ref().filter(|_| !self.on_stage());
        let (sand, ensemble, instrument) = (&mut self.sand, &mut self.ensemble, &self.instrument);
        let before = |hearing: &mut _, at_secs| sand.follow(hearing, ensemble, instrument, solo, at_secs);
        let heard = listening.hear(self.seconds, instrument.parameters(), before)?;
        self.moment = Moment { at_secs: heard.at_secs, at_beat: heard.beat.count };
        self.recent.hear(heard.at_secs, &heard.bands);
        let look = look_on_stage(&self.instrument, shared.settings.music.look());
        let staged = self.on_stage();
        if !staged {
            self.house.open();
        }
        let is_apart = staged && shared.settings.music.own_window;
        let frame = Frame {
            began,
            at_secs: heard.at_secs,
            is_known: heard.is_known,
            beat: heard.beat,
            reaction: reaction(&self.instrument, heard.beat, heard.fading),
            look: look.answering(&heard.mood()),
            staged,
            is_apart,
            solo: tried_out.filter(|_| !staged || is_apart),
        };
        if is_apart {
            let apart = self.apart.get_or_insert_with(|| Apart::new(&self.pane, &self.ensemble));
            apart.use_at_most(self.pace.harmonics());
            apart.play(&self.instrument, &heard.bands, heard.beat)?;
            apart.lag(heard.at_secs, frame.look.feels_speed());
        }
        let items = match &frame.solo {
            Some((mapping, settings)) => {
                self.ensemble.audition(&self.instrument, (mapping, settings), &heard.bands, heard.beat)
            }
            None if is_apart => self.ensemble.play_gallery(&self.instrument, &heard.bands, heard.beat),
            None => self.ensemble.play(&self.instrument, &heard.bands, heard.beat),
        }?
        .to_vec();
        Ok((frame, items))
    }

    /// Does something with the second window, which the rest of the concert does not see meanwhile.
    fn beside(&mut self, run: impl FnOnce(&mut Self, &mut Apart) -> Result<(), Error>) -> Result<(), Error> {
        let Some(mut apart) = self.apart.take() else { return Ok(()) };
        self.draws_stage = true;
        let done = run(self, &mut apart);
        self.apart = Some(apart);
        done
    }

    fn show_harmonics(&mut self, ui: &mut Ui, whole: egui::Rect, first: usize) -> Result<(), Error> {
        let response = ui.allocate_rect(whole, egui::Sense::click_and_drag());
        self.hand.let_go(&mut self.viewpoint);
        navigate(ui, &response, &mut self.viewpoint, 1.0);
        let camera = camera_at(&self.viewpoint, self.staging.stands());
        if self.pane.shown.is_some() {
            self.harmonics.leave();
        }
        self.pane.forget();
        self.take_down()?;
        ui.painter().rect_filled(whole, 0.0, theme::palette(ui).stage);
        let (viewport, topology) = (&mut self.pane.viewport, &self.deformed.topology);
        self.moving |= self.harmonics.show(ui, viewport, topology, camera, whole, first)?;
        self.send(false)
    }

    /// Deforms the shapes as `items` say, and notes how fine their waves are.
    pub(super) fn synthesize(&mut self, items: &[Item], settings: &FrameSettings) -> Result<(), Error> {
        self.deformed.synthesize(items, settings)?;
        self.seen.clear();
        if !self.details.is_empty() {
            self.seen.extend(items.iter().map(coarse::harmonics_seen));
        }
        Ok(())
    }

    /// Deforms the shapes as `items` say, to which their lag is added where the look wants it, and strews their sand; the
    /// pose, which tells whether anything has moved.
    fn deform(
        &mut self,
        shared: &mut Shared<'_>,
        frame: &Frame,
        items: &mut Vec<Item>,
    ) -> Result<u64, Error> {
        // Sound that is not known in advance is heard only in the present.
        while self.sand.due(frame.at_secs).is_some() {
            let stepping = self.apart.as_ref().filter(|_| frame.is_apart).map_or(&items[..], Apart::items);
            self.sand.step(stepping, &self.instrument);
        }
        self.lag.follow(items, frame.at_secs, frame.look.feels_speed());
        let settings = self.instrument.parameters().frame_settings();
        let pose = stillness::pose(items, settings.normal_blending) ^ self.sand.version();
        // Where another window is drawn, too, its shapes have taken the place of these.
        if frame.is_apart || self.pane.shown.as_ref().is_none_or(|shown| shown.pose != pose) {
            self.synthesize(items, &settings)?;
            let took = (shared.now)().saturating_duration_since(frame.began);
            // The limit is that of both windows.
            let beside = self.apart.as_ref().filter(|_| frame.is_apart).map_or(0, Apart::harmonics_wanted);
            if let Some(change) = self.pace.frame(took, self.ensemble.harmonics_wanted().max(beside)) {
                self.ensemble.use_at_most(self.pace.harmonics());
                match change {
                    Change::Fewer(text) => shared.notices.update(HARMONICS, text),
                    Change::More(text) => shared.notices.settle(HARMONICS, text),
                }
            }
        }
        // Reported once; then the processor continues.
        if let Some(fallback) = self.deformed.take_fallback() {
            shared.notices.warn(fallback.to_string());
        }
        Ok(pose)
    }

    /// Draws `count` shapes in `whole`, seen from where the hand or the camera has chosen, with their overlay.
    fn show_items(
        &mut self,
        ui: &mut Ui,
        shared: &Shared<'_>,
        listening: &mut Listening,
        (frame, count, pose): (&Frame, usize, u64),
        whole: egui::Rect,
        wishes: &mut Vec<Wish>,
    ) -> Result<(), Error> {
        let close_up = match self.view {
            View::CloseUp(item) if !frame.shows_stage() => Some(item),
            _ => None,
        };
        let (rect, bench) = if close_up.is_some() { close_up::split(whole) } else { (whole, whole) };
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        let area = viewport::area(ui, rect);
        let (cells, columns) = Staging::cells(area, count);
        self.columns = columns;
        let framing = self.navigate(ui, &response, listening, frame, (area, &cells));
        self.draw(ui, shared, (rect, area), &cells, (frame, framing), pose)?;
        if let Some(item) = close_up {
            let (spectrum, bands_hz) = listening.spectrum();
            let heard = close_up::HeardBands {
                mid: &spectrum.mid,
                bands_hz,
                eigenvalues: &self.ensemble.dancer().eigenvalues,
            };
            close_up::show(ui, bench, &self.instrument, item, &mut self.draft, &heard, wishes);
        } else if matches!(self.view, View::Gallery) && !frame.shows_stage() && frame.solo.is_none() {
            let places: Vec<egui::Rect> =
                cells.iter().map(|cell| viewport::to_points(ui, rect, *cell)).collect();
            self.show_marks(ui, &places, wishes);
        }
        Ok(())
    }

    /// Moves the viewer by hand; the shot to be shown, where the camera chooses them.
    fn navigate(
        &mut self,
        ui: &Ui,
        response: &Response,
        listening: &mut Listening,
        frame: &Frame,
        (area, cells): (Rect, &[Rect]),
    ) -> Option<Framing> {
        let cells_high = cells.first().map_or(1.0, |cell| area.height as f32 / cell.height.max(1) as f32);
        let chosen = frame.shows_stage().then(|| frame.framing(&self.instrument, listening)).flatten();
        match chosen {
            None if frame.shows_stage() => self.hand.keep(),
            None => self.hand.let_go(&mut self.viewpoint),
            Some(_) => {}
        }
        let before = self.viewpoint;
        navigate(ui, response, &mut self.viewpoint, cells_high);
        let chosen = chosen?;
        Some(self.hand.over(self.seconds, (before, touches(ui)), &mut self.viewpoint, chosen))
    }

    /// Draws the overlay of the gallery and finds which shape is marked.
    fn show_marks(&mut self, ui: &mut Ui, places: &[egui::Rect], wishes: &mut Vec<Wish>) {
        let (hovered, focused) =
            gallery::overlay(ui, places, &self.instrument, self.marked, self.on_stage_now(), wishes);
        let moved =
            ui.input(|input| input.pointer.delta() != egui::Vec2::ZERO || input.pointer.any_pressed());
        // A pointer that rests does not take the mark from the arrow keys.
        if focused.is_some() {
            self.marked = focused;
        } else if moved || self.marked.is_none() {
            self.marked = hovered;
        }
    }

    /// The mapping that the close-up plays: with the stroke that is being drawn, or the item as it is.
    fn close_up_mapping(&self) -> Option<(Mapping, Settings)> {
        let View::CloseUp(item) = self.view else { return None };
        let item = self.instrument.gallery().items().get(item)?;
        let mapping = self.draft.as_ref().map_or(&item.genome, |draft| &draft.mapping);
        Some((mapping.clone(), Settings::default()))
    }
}

/// A frame as tests compare it with films.
fn played(frame: &Frame, item: &Item) -> PlayedFrame {
    let coefficients = match item.terms.first().map(|term| &term.coefficients) {
        Some(Coefficients::Vector(c)) => c.as_flattened().to_vec(),
        Some(Coefficients::Normal(c)) => c.clone(),
        None => Vec::new(),
    };
    let on_stage = frame.shows_stage();
    PlayedFrame { at_secs: frame.at_secs, is_known: frame.is_known, on_stage, coefficients }
}
