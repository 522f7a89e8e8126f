//! Live input: finding it by name, its gain, and its level.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use chladni_sound::{Capture, CaptureSource, Level, capture_sources};
use egui::Context;

use super::Listening;

/// The largest gain of live input, and the largest attenuation.
pub const MOST_GAIN_DB: f32 = 24.0;

/// Gain and level of live input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Factor on the amplitude.
    gain: f32,
    level: Level,
}

impl Default for Input {
    fn default() -> Self {
        Self { gain: 1.0, level: Level::Auto }
    }
}

impl Input {
    /// A gain in decibels; with a fixed level, soft input stays soft.
    pub fn new(gain_db: f32, is_fixed: bool) -> Self {
        let gain_db = if gain_db.is_finite() { gain_db.clamp(-MOST_GAIN_DB, MOST_GAIN_DB) } else { 0.0 };
        let level = if is_fixed { Level::Fixed(1.0) } else { Level::Auto };
        Self { gain: 10f32.powf(0.05 * gain_db), level }
    }

    /// The level that the ear follows.
    pub(super) fn level(&self) -> Level {
        self.level
    }

    pub(super) fn amplify(&self, samples: &mut [f32]) {
        if self.gain != 1.0 {
            samples.iter_mut().for_each(|sample| *sample *= self.gain);
        }
    }
}

/// An input that is looked for and opened, on a thread of its own: sound systems answer slowly.
pub(super) struct Wanted {
    name: String,
    /// The open input, none where there is none of this name, or why it cannot be opened.
    answer: Receiver<Result<Option<Opened>, String>>,
}

type Opened = (CaptureSource, Capture);

fn opened(source: CaptureSource) -> Result<Opened, String> {
    let capture = Capture::start(&source).map_err(|why| why.to_string())?;
    Ok((source, capture))
}

impl Listening {
    /// Sets gain and level from now on.
    pub fn set_input(&mut self, input: Input) {
        self.input = input;
    }

    /// Switches to the live input of this name, or back to the songs if live input is on or looked for; the song that it
    /// paused plays on.
    pub fn toggle_live(&mut self, name: Option<&str>, ctx: &Context) {
        if self.live.is_some() || self.wanted.is_some() {
            let resumes = self.live.is_some() && self.resumes;
            self.stop_listening();
            if resumes {
                self.player.play();
            }
            return;
        }
        match name {
            Some(name) => self.listen_to_named(name, ctx),
            None => {
                self.warnings.push("No live input was chosen yet: choose one in the drawer Songs.".into())
            }
        }
    }

    /// Whether this live input is listened to, or will be once it is open.
    pub fn listens_to(&self, source: &CaptureSource) -> bool {
        match &self.wanted {
            Some(wanted) => source.is_called(&wanted.name),
            None => self.live.as_ref().is_some_and(|live| live.is_from(source)),
        }
    }

    /// Looks for a live input, and listens to it once it is found.
    pub fn listen_to_named(&mut self, name: &str, ctx: &Context) {
        let wanted = name.to_owned();
        self.want(name, ctx, move || {
            let all = capture_sources().map_err(|why| format!("{wanted}: {why}"))?;
            Ok(all.into_iter().find(|source| source.is_called(&wanted)))
        });
    }

    /// Listens to a microphone or to the machine's own sound as soon as it is open; the song pauses then.
    pub fn listen_to(&mut self, source: &CaptureSource, ctx: &Context) {
        let found = source.clone();
        self.want(&source.name, ctx, move || Ok(Some(found)));
    }

    fn want(
        &mut self,
        name: &str,
        ctx: &Context,
        find: impl FnOnce() -> Result<Option<CaptureSource>, String> + Send + 'static,
    ) {
        let (send, answer) = channel();
        let ctx = ctx.clone();
        let open = move || {
            let found = find().and_then(|found| found.map(opened).transpose());
            // Another one may be wanted meanwhile.
            let _ = send.send(found);
            ctx.request_repaint();
        };
        match std::thread::Builder::new().name("live input".into()).spawn(open) {
            Ok(_) => self.wanted = Some(Wanted { name: name.to_owned(), answer }),
            Err(why) => self.warnings.push(format!("{name} cannot be opened: {why}")),
        }
    }

    /// Listens to the source that was opened, or says why not.
    pub(super) fn keep_wanted(&mut self) {
        let Some(wanted) = &self.wanted else { return };
        let found = match wanted.answer.try_recv() {
            Err(TryRecvError::Empty) => return,
            Err(TryRecvError::Disconnected) => Ok(None),
            Ok(found) => found,
        };
        let name = self.wanted.take().map(|wanted| wanted.name).unwrap_or_default();
        match found {
            Ok(Some((source, capture))) => self.listen_to_opened(source, capture),
            Ok(None) => self.warnings.push(format!("{name} is not there: choose another live input.")),
            Err(why) => self.warnings.push(why),
        }
    }
}

#[cfg(test)]
mod tests {
    use chladni_music::{ClockTrack, Moment, Parameters};

    use super::super::Message;
    use super::*;

    #[test]
    fn live_input_is_as_loud_as_its_gain_says() {
        let mut samples = [0.1, -0.2];
        Input::new(20.0, false).amplify(&mut samples);
        assert!((samples[0] - 1.0).abs() < 1e-6 && (samples[1] + 2.0).abs() < 1e-6);
        assert_eq!(Input::new(f32::NAN, false), Input::default());
        assert_eq!(Input::new(99.0, true).gain, Input::new(MOST_GAIN_DB, true).gain);
        assert_eq!(Input::new(0.0, true).level(), Level::Fixed(1.0));
    }

    #[test]
    fn a_fixed_level_shows_what_is_soft_as_soft() {
        let ctx = Context::default();
        // The loudest band of a soft tone, as it is heard.
        let heard = |gain_db: f32, is_fixed: bool| {
            let mut listening = Listening::start(&ctx, 1.0, None).unwrap();
            let (capture, mut feed) = Capture::fed(48_000).unwrap();
            listening.listen_on(capture, "feed".into());
            listening.set_input(Input::new(gain_db, is_fixed));
            let tone: Vec<f32> = (0..24_000u16)
                .map(|n| 0.01 * (f32::from(n) * std::f32::consts::TAU * 440.0 / 48_000.0).sin())
                .collect();
            for (frame, block) in tone.chunks(800).enumerate() {
                feed.push(block, block);
                let now_secs = 1.0 + frame as f64 / 60.0;
                listening.hear(now_secs, &Parameters::default(), |_, _| Ok(())).unwrap();
            }
            let loudest = listening.spectrum().0.mid.iter().fold(0.0f32, |most, band| most.max(*band));
            (loudest, listening.levels()[0].peak)
        };
        let (auto, fixed, louder) = (heard(0.0, false), heard(0.0, true), heard(20.0, true));
        assert!(auto.0 > 0.3 && fixed.0 < 0.05, "{auto:?} {fixed:?}");
        assert!((louder.0 / fixed.0 - 10.0).abs() < 0.1, "{louder:?} {fixed:?}");
        assert!((fixed.1 - 0.01).abs() < 1e-3 && (louder.1 - 0.1).abs() < 1e-2);
    }

    /// Its warnings.
    fn said(listening: &mut Listening) -> String {
        let text = |message: Message| if let Message::Warning(text) = message { Some(text) } else { None };
        listening.messages().into_iter().filter_map(text).collect()
    }

    #[test]
    fn an_input_that_is_not_there_is_named() {
        let ctx = Context::default();
        let mut listening = Listening::start(&ctx, 1.0, None).unwrap();
        listening.toggle_live(None, &ctx);
        assert!(said(&mut listening).contains("drawer Songs"));
        listening.toggle_live(Some("no such input"), &ctx);
        while listening.wanted.is_some() {
            listening.keep_wanted();
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        assert!(listening.live().is_none());
        assert!(said(&mut listening).contains("no such input"));
    }

    #[test]
    fn an_input_that_is_looked_for_is_not_taken_once_something_else_is_wanted() {
        let ctx = Context::default();
        let mut listening = Listening::start(&ctx, 1.0, None).unwrap();
        let instead: [&dyn Fn(&mut Listening); 5] = [
            &|listening| listening.select(0),
            &Listening::toggle,
            &|listening| listening.next_song(true),
            &|listening| listening.toggle_live(Some("no such input"), &ctx),
            &|listening| listening.go_on(Vec::new(), &[], ClockTrack::default(), Moment::default()),
        ];
        for choose in instead {
            listening.listen_to_named("no such input", &ctx);
            assert!(listening.wanted.is_some());
            choose(&mut listening);
            assert!(listening.wanted.is_none());
        }
        // A window is opened with both.
        listening.listen_to_named("no such input", &ctx);
        listening.add(vec!["song.flac".into()]);
        assert!(listening.wanted.is_some());
        // Nor do media keys leave a live input for the songs.
        listening.next_song(false);
        listening.previous_song(false);
        assert!(listening.wanted.is_some());
    }

    #[test]
    fn the_beat_of_a_show_that_is_opened_goes_on_from_there() {
        let mut listening = Listening::start(&Context::default(), 1.0, None).unwrap();
        let ends = Moment { at_secs: 250.0, at_beat: 500.0 };
        listening.go_on(Vec::new(), &[], ClockTrack::default(), ends);
        assert_eq!(listening.last_beat.count, 500.0);
        listening.hear(1.0, &Parameters::default(), |_, _| Ok(())).unwrap();
        assert!(listening.last_beat.count >= 500.0);
        // An outer clock that was followed before counts on from there, too.
        listening.want_clock(true);
        for tick in 0..48 {
            listening.hear_clock(chladni_music::ClockMessage::Tick, 1.0 + f64::from(tick) / 48.0);
        }
        listening.hear(2.0, &Parameters::default(), |_, _| Ok(())).unwrap();
        assert!(listening.follows_clock() && listening.last_beat.count >= 500.0);
        listening.go_on(Vec::new(), &[], ClockTrack::default(), Moment { at_beat: 900.0, ..ends });
        listening.hear(2.1, &Parameters::default(), |_, _| Ok(())).unwrap();
        assert!(listening.follows_clock() && listening.last_beat.count >= 900.0);
    }
}
