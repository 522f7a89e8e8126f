//! A person taps to clicks, then to flashes, and learns how much later the picture is seen than the sound is heard.

use chladni_music::{
    CALIBRATION_PERIOD_SECS, CALIBRATION_TAPS, Calibration, Latency, MusicError, Signal, calibration_flash,
};
use chladni_sound::{Player, PlayerSettings, PlayerState, Repeat, WavSample, clicks, write_wav};
use egui::{Align, Color32, Event, Id, Key, Layout, Order, Rect, RichText, Sense, Ui, vec2};

use super::MusicRoom;
use super::listening::Listening;
use super::preferences::Preferences;
use crate::studio::author_id::AuthorId;
use crate::studio::keys::calibrating::{LEAVE, TAP_BY_ENTER, TAP_BY_LETTER, TAP_BY_SPACE};
use crate::studio::room::Shared;
use crate::studio::shortcut::is_asked;
use crate::studio::theme;
use crate::work::Error;

/// Sample rate and number of the clicks, which are repeated.
const CLICKS_HZ: u32 = 48_000;
const CLICKS: usize = 16;
/// After a change from clicks to flashes, taps still follow the clicks.
const REST_SECS: f64 = 1.5;
/// Keys that tap.
const KEYS: [Key; 3] =
    [TAP_BY_SPACE.keys.logical_key, TAP_BY_ENTER.keys.logical_key, TAP_BY_LETTER.keys.logical_key];
/// Points of the area for words at the lower edge.
const WORDS: f32 = 150.0;

/// The clicks and flashes, and the taps so far.
pub struct Calibrating {
    /// Plays the clicks, on the device of the songs.
    player: Player,
    /// How loud these are, as the songs: in [0, 1].
    volume: f32,
    /// The songs played before and resume afterwards.
    resumes: bool,
    taps: Calibration,
    signal: Signal,
    /// Taps count from then on.
    from_secs: f64,
    leaves: bool,
    _folder: tempfile::TempDir,
}

/// A button that was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
    Leave,
    Again,
    Use,
}

impl Calibrating {
    /// Pauses the song and begins to click.
    fn begin(listening: &mut Listening, preferences: &Preferences) -> Result<Self, Error> {
        let folder = tempfile::tempdir().map_err(|why| Error::other(format!("no room for clicks: {why}")))?;
        let path = folder.path().join("clicks.wav");
        write_wav(&path, &clicks(CLICKS_HZ, CALIBRATION_PERIOD_SECS, CLICKS), WavSample::Int16)?;
        let (device, volume) = (preferences.output_device.clone(), listening.volume());
        let player = Player::start(PlayerSettings { device, volume, audible: true })?;
        let resumes = listening.plays_songs();
        listening.player().pause();
        player.repeat(Repeat::List);
        player.play_list(vec![path]);
        Ok(Self {
            player,
            volume,
            resumes,
            taps: Calibration::default(),
            signal: Signal::Click,
            from_secs: 0.0,
            leaves: false,
            _folder: folder,
        })
    }

    /// Whether the song goes on afterwards: it played before, and no live input has taken its place.
    fn song_goes_on(&self, listening: &Listening) -> bool {
        let is_there = listening.player().status().state != PlayerState::Stopped;
        self.resumes && listening.live().is_none() && is_there
    }

    /// Takes Escape and the keys that tap, so that they do nothing else meanwhile. Once all taps are made, the buttons need
    /// these keys; so does a question.
    pub fn take_keys(&mut self, ctx: &egui::Context) {
        if is_asked(ctx) {
            return;
        }
        let now_secs = ctx.input(|input| input.time);
        self.leaves |= LEAVE.pressed(ctx);
        if !self.is_done() {
            (0..ctx.input_mut(taken)).for_each(|_| self.tap(now_secs));
        }
    }

    /// A tap at `now_secs` of the window.
    pub fn tap(&mut self, now_secs: f64) {
        if now_secs < self.from_secs || self.is_done() {
            return;
        }
        let after_secs = match self.signal {
            // A click lies in the middle of its period.
            Signal::Click => self.player.status().position_secs - 0.5 * CALIBRATION_PERIOD_SECS,
            Signal::Flash => now_secs,
        };
        self.taps.tap(self.signal, after_secs);
        if self.signal == Signal::Click && self.taps.count(Signal::Click) >= CALIBRATION_TAPS {
            self.player.pause();
            (self.signal, self.from_secs) = (Signal::Flash, now_secs + REST_SECS);
        }
    }

    fn is_done(&self) -> bool {
        self.signal == Signal::Flash && self.taps.count(Signal::Flash) >= CALIBRATION_TAPS
    }

    fn again(&mut self) {
        (self.taps, self.signal, self.from_secs) = (Calibration::default(), Signal::Click, 0.0);
        self.player.play();
    }

    /// Flashes are shown now.
    fn flashes(&self) -> bool {
        self.signal == Signal::Flash && !self.is_done()
    }

    /// How bright the field is.
    fn light(&self, now_secs: f64) -> f32 {
        if self.flashes() { calibration_flash(now_secs) } else { 0.0 }
    }

    /// Draws over the whole window; returns the choice that was made, if any.
    fn show(&mut self, ui: &mut Ui, whole: Rect) -> Option<Choice> {
        let now_secs = ui.input(|input| input.time);
        let light = (255.0 * self.light(now_secs)).round() as u8;
        let field = ui.allocate_rect(whole, Sense::click());
        ui.painter().rect_filled(whole, 0.0, Color32::from_gray(light));
        field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Tap here"));
        let field = field.author_id("calibrate/tap");
        let (pressed, released) =
            ui.input(|input| (input.pointer.primary_pressed(), input.pointer.any_released()));
        // When it is pressed counts; what clicks without a pointer has no other moment.
        let taps = if pressed { field.contains_pointer() } else { field.clicked() && !released };
        if taps {
            self.tap(now_secs);
        }
        let words = Rect::from_min_max(whole.left_bottom() - vec2(0.0, WORDS), whole.right_bottom());
        let mut chosen = None;
        ui.scope_builder(
            egui::UiBuilder::new().max_rect(words).layout(Layout::top_down(Align::Center)),
            |ui| {
                ui.painter().rect_filled(words, 0.0, ui.visuals().panel_fill);
                ui.add_space(theme::GAP);
                chosen = self.words(ui);
            },
        );
        chosen
    }

    fn words(&self, ui: &mut Ui) -> Option<Choice> {
        let line = |ui: &mut Ui, text: String| ui.label(RichText::new(text).size(16.0));
        if self.is_done() {
            let latency = self.taps.latency();
            line(ui, outcome(&latency));
            return buttons(ui, latency.is_ok());
        }
        line(ui, asked(self.signal).to_owned());
        line(ui, format!("{} of {CALIBRATION_TAPS}", self.taps.count(self.signal)));
        if let Some(why) = why_unheard(self.player.status().device.is_some(), self.volume) {
            line(ui, format!("{why}: no click is heard."));
        }
        buttons(ui, false)
    }
}

fn asked(signal: Signal) -> &'static str {
    match signal {
        Signal::Click => "Tap the space bar, or anywhere here, with each click. There is nothing to see yet.",
        Signal::Flash => "Now tap with each flash. There is nothing to hear.",
    }
}

/// Why clicks cannot be heard; `None` where they can.
fn why_unheard(has_device: bool, volume: f32) -> Option<&'static str> {
    match (has_device, volume > 0.0) {
        (false, _) => Some("There is no sound device"),
        (true, false) => Some("The volume is 0"),
        (true, true) => None,
    }
}

fn outcome(latency: &Result<Latency, MusicError>) -> String {
    match latency {
        Ok(Latency { secs, spread_secs }) => {
            let (late_ms, spread_ms) = (1e3 * secs, 1e3 * spread_secs);
            let which = if late_ms < 0.0 { "earlier" } else { "later" };
            format!(
                "The picture is seen {:.0} ms {which} than the sound is heard (± {spread_ms:.0} ms).",
                late_ms.abs()
            )
        }
        Err(why) => format!("These taps cannot be used: {why}."),
    }
}

fn buttons(ui: &mut Ui, usable: bool) -> Option<Choice> {
    let mut chosen = None;
    ui.horizontal(|ui| {
        ui.add_space(0.5 * (ui.available_width() - 260.0).max(0.0));
        let choices = [
            (Choice::Use, "use", "Use it"),
            (Choice::Again, "again", "Again"),
            (Choice::Leave, "cancel", "Cancel"),
        ];
        for (choice, id, name) in choices {
            let button = ui.add_enabled(usable || choice != Choice::Use, egui::Button::new(name));
            if button.author_id(format!("calibrate/{id}")).clicked() {
                chosen = Some(choice);
            }
        }
    });
    chosen
}

impl MusicRoom {
    /// Lets a person tap, or no longer.
    pub(super) fn calibrate(&mut self, shared: &mut Shared<'_>) {
        if self.calibrating.is_some() {
            return self.end_calibrating();
        }
        let Some(listening) = &mut self.listening else { return };
        match Calibrating::begin(listening, &shared.settings.music) {
            Ok(calibrating) => self.calibrating = Some(calibrating),
            Err(why) => shared.notices.failed(why),
        }
    }

    /// Draws clicks and flashes while a person taps to them, and keeps what comes of it.
    pub(super) fn follow_taps(&mut self, shared: &mut Shared<'_>) {
        let (Some(calibrating), Some(listening)) = (&mut self.calibrating, &mut self.listening) else {
            return;
        };
        let ctx = &shared.ctx;
        ctx.request_repaint();
        if let Some(concert) = &mut self.concert {
            (concert.calibrates, concert.flashes) = (true, calibrating.flashes());
        }
        let whole = ctx.content_rect();
        let area = egui::Area::new(Id::unique("calibrating")).order(Order::Foreground).fixed_pos(whole.min);
        let chosen = area.show(ctx, |ui| calibrating.show(ui, whole)).inner;
        match chosen.or(calibrating.leaves.then_some(Choice::Leave)) {
            None => return,
            Some(Choice::Again) => return calibrating.again(),
            Some(Choice::Leave) => {}
            Some(Choice::Use) => {
                if let Ok(latency) = calibrating.taps.latency() {
                    shared.settings.music.set_late_ms((1e3 * latency.secs).round() as i32);
                    listening.show_ahead(shared.settings.music.late_secs());
                }
            }
        }
        self.end_calibrating();
    }

    /// Ends clicks and flashes, if there are any; the songs go on.
    pub(super) fn end_calibrating(&mut self) {
        let Some(calibrating) = self.calibrating.take() else { return };
        if let Some(listening) = &self.listening
            && calibrating.song_goes_on(listening)
        {
            listening.player().play();
        }
        if let Some(concert) = &mut self.concert {
            (concert.calibrates, concert.flashes) = (false, false);
        }
    }
}

/// How many keys that tap were pressed; they are taken out.
pub fn taken(input: &mut egui::InputState) -> usize {
    let mut taps = 0;
    input.events.retain(|event| {
        let Event::Key { key, pressed: true, repeat, .. } = event else { return true };
        taps += usize::from(KEYS.contains(key) && !repeat);
        !KEYS.contains(key)
    });
    taps
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn no_song_goes_on_under_live_input() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let end = Instant::now() + chladni_testdata::HANGS;
        while !listening.plays_songs() {
            assert!(Instant::now() < end, "the tune does not play");
            std::thread::sleep(Duration::from_millis(5));
        }
        let calibrating = Calibrating::begin(&mut listening, &Preferences::default()).unwrap();
        assert!(calibrating.song_goes_on(&listening));
        let (capture, _feed) = chladni_sound::Capture::fed(48_000).unwrap();
        listening.listen_on(capture, "feed".into());
        assert!(!calibrating.song_goes_on(&listening));
    }

    #[test]
    fn clicks_that_nobody_hears_are_explained() {
        assert_eq!(why_unheard(true, 0.5), None);
        assert_eq!(why_unheard(true, 0.0), Some("The volume is 0"));
        assert_eq!(why_unheard(false, 0.0), Some("There is no sound device"));
    }

    #[test]
    fn the_outcome_says_which_of_the_two_is_late() {
        let of = |secs| outcome(&Ok(Latency { secs, spread_secs: 0.006 }));
        assert_eq!(of(0.083), "The picture is seen 83 ms later than the sound is heard (± 6 ms).");
        assert!(of(-0.12).contains("120 ms earlier"));
        assert!(outcome(&Calibration::default().latency()).contains("at least 8 taps"));
    }
}
