//! Live input instead of a song, and how it is found again after it was lost.

use std::sync::mpsc::{Receiver, TryRecvError, channel};

use chladni_sound::{Capture, CaptureSource};

use super::Listening;
use crate::work::Ear;

/// The pause between two attempts to find a lost source.
const AGAIN_SECS: f64 = 1.0;

/// A live input that is listened to instead of a song.
pub struct Live {
    pub(super) capture: Capture,
    pub(super) name: String,
    /// Where it can be opened again; `None` of a capture that the program itself feeds.
    source: Option<CaptureSource>,
    lost: Option<Lost>,
    /// How long no sound has come.
    quiet_secs: f64,
}

/// A source that is looked for, and opened again, on a thread of its own: sound systems answer slowly.
#[derive(Default)]
struct Lost {
    answer: Option<Receiver<Option<Capture>>>,
    next_secs: f64,
}

/// The state of a source since it was last checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    /// It is heard, or still looked for.
    Unchanged,
    /// It was lost, and is looked for from now on.
    Lost,
    /// It was lost for good.
    Gone,
    /// It was found again.
    Back,
}

impl Live {
    fn new(capture: Capture, name: String, source: Option<CaptureSource>) -> Self {
        Self { capture, name, source, lost: None, quiet_secs: 0.0 }
    }

    /// Notices where the source was lost, and opens it again as soon as it is back. To be called in every frame.
    fn keep(&mut self, now_secs: f64) -> Fate {
        if !self.capture.is_lost() {
            return Fate::Unchanged;
        }
        let Some(source) = &self.source else { return Fate::Gone };
        let Some(lost) = &mut self.lost else {
            self.lost = Some(Lost::default());
            return Fate::Lost;
        };
        if let Some(capture) = lost.opened_again(source, now_secs) {
            (self.capture, self.lost, self.quiet_secs) = (capture, None, 0.0);
            return Fate::Back;
        }
        Fate::Unchanged
    }

    /// Whether it comes from `source`, which may have another name than when it was opened.
    pub(super) fn is_from(&self, source: &CaptureSource) -> bool {
        self.source.as_ref().map_or_else(|| source.is_called(&self.name), |own| own.is_same(source))
    }

    /// Takes the sound of the last `dt_secs`.
    pub(super) fn take(&mut self, dt_secs: f64, left: &mut Vec<f32>, right: &mut Vec<f32>) {
        let frames = self.capture.take(left, right);
        self.quiet_secs = if frames == 0 { self.quiet_secs + dt_secs } else { 0.0 };
    }

    /// Copies the newest sound that was taken; silence where none comes any more.
    pub(super) fn window(&self, left: &mut [f32], right: &mut [f32]) {
        if self.capture.is_lost() || self.quiet_secs > Ear::QUIET_SECS {
            left.fill(0.0);
            right.fill(0.0);
        } else {
            self.capture.window(left, right);
        }
    }
}

impl Listening {
    /// Listens to a source that was opened; the song pauses.
    pub(super) fn listen_to_opened(&mut self, source: CaptureSource, capture: Capture) {
        self.go_live(Live::new(capture, source.name.clone(), Some(source)));
    }

    /// Listens to a capture that is called `name`; the song pauses.
    pub fn listen_on(&mut self, capture: Capture, name: String) {
        self.go_live(Live::new(capture, name, None));
    }

    fn go_live(&mut self, live: Live) {
        if self.live.is_none() {
            // Nobody has asked for the tune that plays where no song was chosen.
            self.resumes = self.plays_songs() && !self.has_only_the_tune();
        }
        self.player.pause();
        (self.live, self.wanted) = (Some(live), None);
        self.forget_beat();
    }

    /// Back to the songs; an input that is still looked for is not wanted any more.
    pub fn stop_listening(&mut self) {
        self.wanted = None;
        self.leave_live();
    }

    /// Back to the songs until an input is found that is looked for.
    pub(super) fn leave_live(&mut self) {
        if self.live.take().is_some() {
            self.forget_beat();
        }
    }

    /// Reports when the source is lost, and when it is back.
    pub(super) fn keep_live(&mut self, now_secs: f64) {
        let Some(live) = &mut self.live else { return };
        match live.keep(now_secs) {
            Fate::Unchanged => {}
            Fate::Lost => {
                self.warnings
                    .push(format!("{} is silent now; it is heard as soon as it is back.", live.name));
            }
            Fate::Back => self.warnings.push(format!("{} is heard again.", live.name)),
            Fate::Gone => {
                self.warnings.push(format!("{} is gone; choose it again when it is back.", live.name));
                self.leave_live();
            }
        }
    }

    /// The live input's name.
    pub fn live(&self) -> Option<&str> {
        self.live.as_ref().map(|live| live.name.as_str())
    }
}

impl Lost {
    fn opened_again(&mut self, source: &CaptureSource, now_secs: f64) -> Option<Capture> {
        match self.answer.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return None,
            Some(Ok(Some(capture))) => {
                self.answer = None;
                return Some(capture);
            }
            Some(Ok(None) | Err(TryRecvError::Disconnected)) => {
                (self.answer, self.next_secs) = (None, now_secs + AGAIN_SECS);
            }
            None => {}
        }
        if now_secs >= self.next_secs {
            let (send, answer) = channel();
            let source = source.clone();
            let look = move || {
                // It may be lost again between finding and opening it.
                let capture = source.is_there().then(|| Capture::start(&source).ok());
                let _ = send.send(capture.flatten());
            };
            // Where no thread begins, the next look tries again.
            let begun = std::thread::Builder::new().name("lost source".into()).spawn(look);
            self.answer = begun.is_ok().then_some(answer);
            self.next_secs = now_secs + AGAIN_SECS;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::process::{Child, Command};
    use std::time::{Duration, Instant};

    use chladni_music::Parameters;
    use chladni_sound::{PlayerState, Song, WavSample, capture_sources, write_wav};

    use super::*;
    use crate::work::BeatCount;

    fn until(what: &str, mut done: impl FnMut(f64) -> bool) {
        let began = Instant::now();
        while !done(began.elapsed().as_secs_f64()) {
            assert!(began.elapsed() < chladni_testdata::HANGS, "waited for {what}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    #[test]
    fn a_feed_that_ends_is_gone() {
        let (capture, feed) = Capture::fed(48_000).unwrap();
        let mut live = Live::new(capture, "feed".into(), None);
        assert_eq!(live.keep(0.0), Fate::Unchanged);
        drop(feed);
        assert_eq!(live.keep(0.1), Fate::Gone);
    }

    #[test]
    fn the_count_of_beats_goes_on_after_it() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let (capture, _feed) = Capture::fed(48_000).unwrap();
        listening.listen_on(capture, "feed".into());
        listening.ear.beats = BeatCount::from(500.0);
        let hear = |listening: &mut Listening, now_secs| {
            listening.hear(now_secs, &Parameters::default(), |_, _| Ok(())).unwrap().beat.count
        };
        assert!(hear(&mut listening, 1.0) >= 500.0);
        listening.stop_listening();
        until("the song", |secs| {
            hear(&mut listening, 2.0 + secs);
            listening.hearing.stretch().is_some_and(|stretch| stretch.song.is_some())
        });
        let beat = listening.hearing.beat_at(listening.at_secs());
        assert!(beat.count >= 500.0, "{beat:?}");
    }

    #[test]
    fn it_is_heard_on_where_a_stopped_player_goes_to_another_song() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        for go in [Listening::next_song, Listening::previous_song] {
            let (capture, _feed) = Capture::fed(48_000).unwrap();
            listening.listen_on(capture, "feed".into());
            go(&mut listening, false);
            assert_eq!(listening.live(), Some("feed"));
            go(&mut listening, true);
            assert!(listening.live().is_none());
        }
    }

    #[test]
    fn the_song_that_it_paused_plays_on_after_it() {
        let ctx = egui::Context::default();
        let mut listening = Listening::start(&ctx, 1.0, None).unwrap();
        let mut feeds = Vec::new();
        let mut listen = |listening: &mut Listening| {
            let (capture, feed) = Capture::fed(48_000).unwrap();
            feeds.push(feed);
            listening.listen_on(capture, "feed".into());
        };
        let is_paused = |listening: &Listening| listening.player.status().state == PlayerState::Paused;
        until("the tune", |_| listening.plays_songs());
        listen(&mut listening);
        assert!(!listening.resumes, "the tune, which nobody has chosen");
        until("its pause", |_| is_paused(&listening));
        listening.toggle_live(None, &ctx);
        listening.append(vec![crate::work::formats::TUNE.into()]);
        listening.player.play();
        until("a song", |_| listening.plays_songs());
        // From one live input to another.
        listen(&mut listening);
        listen(&mut listening);
        until("the song's pause", |_| is_paused(&listening));
        listening.toggle_live(None, &ctx);
        until("the song again", |_| listening.plays_songs());
        listening.player.pause();
        until("a pause", |_| !listening.plays_songs());
        listen(&mut listening);
        assert!(!listening.resumes, "a song that was paused before");
    }

    #[test]
    fn an_input_that_gives_no_more_sound_is_silent() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        let (capture, mut feed) = Capture::fed(48_000).unwrap();
        listening.listen_on(capture, "feed".into());
        let mut now_secs = 1.0;
        let mut rms = || {
            now_secs += 0.05;
            listening.hear(now_secs, &Parameters::default(), |_, _| Ok(())).unwrap();
            listening.levels()[0].rms
        };
        assert_eq!(rms(), 0.0);
        feed.push(&[0.5; 9600], &[0.5; 9600]);
        assert!(rms() > 0.4 && rms() > 0.4, "it sounds on between two blocks");
        let later: Vec<f32> = (0..5).map(|_| rms()).collect();
        assert_eq!(later.last(), Some(&0.0), "{later:?}");
        feed.push(&[0.5; 9600], &[0.5; 9600]);
        assert!(rms() > 0.4);
    }

    /// The center of the band that is loudest after a second of a tone of 1 kHz at this rate, which comes in one block for
    /// so many frames of the window; and the least that was heard of it, once it had begun.
    fn heard_of_a_tone(listening: &mut Listening, from_secs: f64, rate_hz: u32, frames: usize) -> (f32, f32) {
        let (capture, mut feed) = Capture::fed(rate_hz).unwrap();
        listening.listen_on(capture, "feed".into());
        let block = frames * rate_hz as usize / 40;
        let mut least = f32::INFINITY;
        for frame in 1..=40 {
            if frame % frames == 0 {
                let at = |n: usize| std::f32::consts::TAU * 1000.0 * n as f32 / rate_hz as f32;
                let first = frame / frames * block;
                let tone: Vec<f32> = (first..first + block).map(|n| 0.5 * at(n).sin()).collect();
                feed.push(&tone, &tone);
            }
            let now_secs = from_secs + frame as f64 / 40.0;
            listening.hear(now_secs, &Parameters::default(), |_, _| Ok(())).unwrap();
            if frame > 20 {
                least = least.min(listening.levels()[0].rms);
            }
        }
        let (spectrum, bands_hz) = listening.spectrum();
        let loudest = spectrum.mid.iter().zip(bands_hz).max_by(|a, b| a.0.total_cmp(b.0)).unwrap();
        (*loudest.1, least)
    }

    #[test]
    fn a_tone_is_in_its_band_at_any_rate_and_in_blocks_of_any_size() {
        let mut listening = Listening::start(&egui::Context::default(), 1.0, None).unwrap();
        // An input that comes back at another rate, and one whose sound comes in bursts of a tenth of a second.
        for (from_secs, rate_hz, frames) in [(1.0, 48_000, 1), (2.0, 44_100, 1), (3.0, 48_000, 4)] {
            let (loudest_hz, least) = heard_of_a_tone(&mut listening, from_secs, rate_hz, frames);
            // At a wrong rate it would be 9 % off.
            assert!((loudest_hz / 1000.0 - 1.0).abs() < 0.04, "{loudest_hz} Hz at {rate_hz} in {frames}");
            assert!(least > 0.3, "{least} at {rate_hz} in {frames}");
        }
    }

    #[test]
    fn a_source_that_was_lost_is_heard_when_it_is_back() {
        let Some(server) = chladni_testdata::SoundServer::start() else { return };
        // The environment names the sound server, and belongs to a whole process.
        let inside = concat!(module_path!(), "::in_a_process_with_its_own_sound_server");
        let inside = inside.split_once("::").unwrap().1;
        let test = std::env::current_exe().unwrap();
        let outcome = server.command(test).args(["--exact", inside, "--ignored"]).output().unwrap();
        let said = String::from_utf8_lossy(&outcome.stdout);
        assert!(outcome.status.success() && said.contains("1 passed"), "{said}");
    }

    #[test]
    #[ignore = "run by the test above"]
    fn in_a_process_with_its_own_sound_server() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("tone.wav");
        let left: Vec<f32> = (0..9_600_000).map(|n| 0.5 * (n as f32 * 0.06).sin()).collect();
        let song = Song { rate_hz: 8_000, right: left.clone(), left };
        write_wav(&path, &song, WavSample::Int16).unwrap();
        let play = || Command::new("paplay").arg("--client-name=piper").arg(&path).spawn().unwrap();
        let stop = |mut player: Child| player.kill().and_then(|()| player.wait()).unwrap();
        let player = play();
        let mut source = None;
        until("the program", |_| {
            source = capture_sources().unwrap().into_iter().find(|source| source.name == "piper");
            source.is_some()
        });
        let source = source.unwrap();
        let mut renamed = source.clone();
        renamed.name = "piper (2)".into();
        let mut live = Live::new(Capture::start(&source).unwrap(), source.name.clone(), Some(source));
        assert!(live.is_from(&renamed));
        let heard = |live: &mut Live, now_secs: f64| {
            let fate = live.keep(now_secs);
            live.capture.take(&mut Vec::new(), &mut Vec::new());
            (fate, live.capture.level().peak > 0.4)
        };
        until("its sound", |now_secs| heard(&mut live, now_secs) == (Fate::Unchanged, true));
        stop(player);
        until("that it is lost", |now_secs| heard(&mut live, now_secs).0 == Fate::Lost);
        let player = play();
        until("that it is back", |now_secs| heard(&mut live, now_secs).0 == Fate::Back);
        until("its sound again", |now_secs| heard(&mut live, now_secs).1);
        stop(player);
        // A sink takes its monitor along; the server would go on with that of another one.
        let pactl = |arguments: &[&str]| {
            let output = Command::new("pactl").args(arguments).output().unwrap();
            String::from_utf8(output.stdout).unwrap().trim().to_owned()
        };
        let sink = ["load-module", "module-null-sink", "sink_name=other"];
        let module = pactl(&sink);
        let found = capture_sources().unwrap().into_iter().find(|source| source.name == "other.monitor");
        let source = found.unwrap();
        let mut live = Live::new(Capture::start(&source).unwrap(), source.name.clone(), Some(source));
        until("its frames", |_| live.capture.take(&mut Vec::new(), &mut Vec::new()) > 0);
        pactl(&["unload-module", &module]);
        until("that it is lost, too", |now_secs| heard(&mut live, now_secs).0 == Fate::Lost);
        pactl(&sink);
        until("that it is back, too", |now_secs| heard(&mut live, now_secs).0 == Fate::Back);
    }
}
