//! The stage in a window of its own, while the gallery goes on in the first.

use std::sync::Arc;

use chladni_music::{Bands, Beat, Dancer, Ensemble, Framing, Instrument, Target, calibration_flash};
use chladni_synth::Item;
use egui::{Color32, ViewportBuilder, ViewportCommand, ViewportId};

use super::super::calibrating::taken;
use super::super::place::{Change, Place};
use super::super::preferences::Screen;
use super::super::wish::Wish;
use super::Concert;
use super::frame::Frame;
use super::pane::Pane;
use super::stillness;
use crate::studio::focus;
use crate::studio::keys::music::{BLACKOUT, FREEZE, GO, LEAVE, MARK_LEFT, MARK_RIGHT};
use crate::studio::room::Shared;
use crate::studio::viewport;
use crate::work::{Error, Lag, Staging};

/// The parts of the second window that the first does not have.
pub struct Apart {
    /// Its picture.
    pub pane: Pane,
    /// Plays the dance on stage; the first window's plays the gallery.
    ensemble: Ensemble,
    items: Vec<Item>,
    /// How many of them are seen; as many more may be their lags.
    count: usize,
    lag: Lag,
    place: Place,
}

/// Its name, in its frame and for screen readers.
const TITLE: &str = "Chladni: picture";

/// The second window.
fn window() -> ViewportId {
    ViewportId::from_hash_of("picture")
}

impl Apart {
    pub fn new(pane: &Pane, ensemble: &Ensemble) -> Self {
        let pane = Pane::new(pane.viewport.screen());
        Self {
            pane,
            ensemble: ensemble.clone(),
            items: Vec::new(),
            count: 0,
            lag: Lag::default(),
            place: Place::default(),
        }
    }

    /// The dance on stage is that of `dancer` from now on: of the same body, which stands otherwise.
    pub fn give_to(&mut self, dancer: Arc<Dancer>) {
        self.ensemble.give_to(dancer);
    }

    /// Uses no more than this many harmonics from now on; `None` for all.
    pub fn use_at_most(&mut self, harmonics: Option<u32>) {
        self.ensemble.use_at_most(harmonics);
    }

    /// How many harmonics the dance on stage uses if none are left out.
    pub fn harmonics_wanted(&self) -> u32 {
        self.ensemble.harmonics_wanted()
    }

    /// Computes the items on stage now.
    pub fn play(&mut self, instrument: &Instrument, bands: &Bands<'_>, beat: Beat) -> Result<(), Error> {
        self.items = self.ensemble.play(instrument, bands, beat)?.to_vec();
        self.count = self.items.len();
        Ok(())
    }

    /// Adds the lag of the items on stage, where it is wanted.
    pub fn lag(&mut self, at_secs: f64, wanted: bool) {
        self.lag.follow(&mut self.items, at_secs, wanted);
    }

    /// The items that were on stage last.
    pub fn items(&self) -> &[Item] {
        &self.items[..self.count]
    }

    /// The window is closed; another stage gets another one.
    pub fn leave(&mut self) {
        self.place = Place::default();
        self.pane.forget();
    }
}

impl Concert {
    /// Shows the stage in a window of its own, on the screen that the preferences name.
    pub(super) fn show_apart(
        &mut self,
        ctx: &egui::Context,
        shared: &mut Shared<'_>,
        apart: &mut Apart,
        frame: &Frame,
        framing: Option<Framing>,
        wishes: &mut Vec<Wish>,
    ) -> Result<(), Error> {
        let screen = shared.settings.music.screen.clone();
        let builder = ViewportBuilder::default()
            .with_title(TITLE)
            .with_inner_size([1280.0, 720.0])
            .with_fullscreen(screen == Screen::Full);
        if let Some(change) = apart.place.follow(&screen, &shared.screen.monitors()) {
            let command = match change {
                Change::Fill(index) => ViewportCommand::SetMonitor(index),
                Change::Leave | Change::Missing { .. } => ViewportCommand::Fullscreen(false),
            };
            ctx.send_viewport_cmd_to(window(), command);
            if matches!(change, Change::Missing { filled: true, .. }) {
                // The system puts it on another screen, and so before the controls.
                ctx.send_viewport_cmd_to(ViewportId::ROOT, ViewportCommand::Focus);
            }
            change.warning().into_iter().for_each(|why| shared.notices.warn(why));
        }
        let settings = self.instrument.parameters().frame_settings();
        let pose = stillness::pose(&apart.items, settings.normal_blending) ^ self.sand.version();
        std::mem::swap(&mut self.pane, &mut apart.pane);
        let shown = ctx.show_viewport_immediate(window(), builder, |ui, _| -> Result<(), Error> {
            // Where a system has no second window, it is drawn in the first.
            if ui.ctx().viewport_id() != ViewportId::ROOT {
                focus::name_window(ui.ctx(), TITLE);
            }
            let rect = viewport::whole_pixels(ui);
            ui.painter().rect_filled(rect, 0.0, Color32::BLACK);
            if self.calibrates {
                taps(ui.ctx(), wishes);
            }
            keys(ui.ctx(), wishes);
            let projection = shared.settings.music.projection;
            if self.house.frozen && self.pane.shown.is_some() {
                self.repaint(ui, projection, rect)?;
            } else {
                self.synthesize(&apart.items, &settings)?;
                let area = viewport::area(ui, rect);
                let (cells, _) = Staging::cells(area, apart.count);
                self.draw(ui, shared, (rect, area), &cells, (frame, framing), pose)?;
            }
            let opacity = self.title_opacity(ui.input(|input| input.time));
            self.song_title.show(ui, rect, projection, opacity);
            if self.flashes {
                let light = calibration_flash(ui.input(|input| input.time));
                ui.painter().rect_filled(rect, 0.0, Color32::from_gray((255.0 * light).round() as u8));
            }
            if self.adjusts {
                shared.settings.music.projection.adjust(ui, rect);
            }
            Ok(())
        });
        std::mem::swap(&mut self.pane, &mut apart.pane);
        shown
    }
}

/// Passes on taps to clicks and flashes, and Escape, which leaves them.
fn taps(ctx: &egui::Context, wishes: &mut Vec<Wish>) {
    // Drawn inside the first window, this would see that window's pointer, whose presses on the tap field are counted
    // there.
    let is_own = ctx.viewport_id() != ViewportId::ROOT;
    let pressed = is_own && ctx.input(|input| input.pointer.primary_pressed());
    let taps = ctx.input_mut(taken) + usize::from(pressed);
    wishes.extend((0..taps).map(|_| Wish::Press(Target::Tap)));
    if LEAVE.pressed(ctx) {
        wishes.push(Wish::Calibrate);
    }
}

/// Handles keys in the second window; closing it leaves the stage.
fn keys(ctx: &egui::Context, wishes: &mut Vec<Wish>) {
    use chladni_music::Action;
    if LEAVE.pressed(ctx) || ctx.input(|input| input.viewport().close_requested()) {
        wishes.push(Wish::Do(Action::LeaveStage));
    }
    for (key, wish) in [
        (GO, Wish::Do(Action::Go)),
        (BLACKOUT, Wish::Press(Target::Blackout)),
        (FREEZE, Wish::Press(Target::Freeze)),
        (MARK_LEFT, Wish::StepInTurn(false)),
        (MARK_RIGHT, Wish::StepInTurn(true)),
    ] {
        if key.pressed(ctx) {
            wishes.push(wish);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Event, Key, Modifiers};

    #[test]
    fn taps_in_the_second_window_are_passed_on_and_escape_leaves_them() {
        let key = |key, repeat| {
            let modifiers = Modifiers::NONE;
            Event::Key { key, physical_key: None, pressed: true, repeat, modifiers }
        };
        let input = |events| egui::RawInput { events, ..egui::RawInput::default() };
        let (ctx, mut wishes) = (egui::Context::default(), Vec::new());
        let events = vec![key(Key::Space, false), key(Key::T, false), key(Key::Escape, false)];
        let _ = ctx.run_ui(input(events), |ui| {
            taps(ui.ctx(), &mut wishes);
            keys(ui.ctx(), &mut wishes);
        });
        let [Wish::Press(Target::Tap), Wish::Press(Target::Tap), Wish::Calibrate] = &wishes[..] else {
            panic!("{wishes:?}")
        };
        // Held down.
        wishes.clear();
        let _ = ctx.run_ui(input(vec![key(Key::Space, true)]), |ui| taps(ui.ctx(), &mut wishes));
        assert!(wishes.is_empty(), "{wishes:?}");
    }
}
