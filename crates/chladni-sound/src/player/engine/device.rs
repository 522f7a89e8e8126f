//! Losing the device, and finding it again: the song goes on where it was heard.

use std::time::{Duration, Instant};

use super::{Engine, PlayerEvent};
use crate::history::History;
use crate::player::output::Output;
use crate::player::queue::Stretch;
use crate::player::tail::Tail;

/// Pauses between attempts to find a device again; they double up to the longest one.
pub(super) const FIRST_RETRY: Duration = Duration::from_secs(1);
const LONGEST_RETRY: Duration = Duration::from_secs(16);
/// How long a device may take to become quiet before it is closed: its buffers are heard out. Time between two looks at it.
const LONGEST_HUSH: Duration = Duration::from_millis(250);
const LOOK: Duration = Duration::from_millis(2);

impl Engine {
    pub(super) fn look_after_output(&mut self) {
        let now = Instant::now();
        self.output.advance(&self.shared.clock, now);
        if let Some(reason) = self.output.trouble(&self.shared.clock, now) {
            self.tell(PlayerEvent::DeviceLost(reason));
            self.retry_after = FIRST_RETRY;
            self.fall_silent();
        } else if self.retry_at.is_some_and(|at| now >= at) {
            self.reopen(false);
        }
    }

    /// Tries the device again and continues at the position of the song; in silence where there is none, which is reported
    /// unless it `is_news` no longer.
    pub(super) fn reopen(&mut self, is_news: bool) {
        let was_silent = self.output.device.is_none();
        self.hush();
        // The old stream is closed first: some devices allow only one.
        let place = if was_silent { None } else { self.change_output(Output::silence(), None) };
        match Output::device(self.device.as_deref(), &self.shared.clock) {
            Ok(output) => {
                let place = self.change_output(output, place);
                self.retry_at = None;
                self.retry_after = FIRST_RETRY;
                if let Some(name) = self.output.device.clone() {
                    self.tell(PlayerEvent::DeviceOpened(name));
                }
                self.go_on_at(place);
            }
            Err(error) => {
                if is_news {
                    self.tell(PlayerEvent::DeviceLost(error.to_string()));
                }
                // If the output was silent before, it continues without interruption.
                if !was_silent {
                    self.go_on_at(place);
                }
                self.retry_at = Some(Instant::now() + self.retry_after);
                self.retry_after = (2 * self.retry_after).min(LONGEST_RETRY);
            }
        }
        self.shared.clock.set_paused(!self.playing);
    }

    /// Fades a device out that is about to be closed, as it would end with a click.
    pub(super) fn hush(&self) {
        if self.output.device.is_none() {
            return;
        }
        self.shared.clock.set_paused(true);
        let end = Instant::now() + LONGEST_HUSH;
        while !self.shared.clock.is_quiet(Instant::now()) && Instant::now() < end {
            std::thread::sleep(LOOK);
        }
    }

    pub(super) fn open_output(&mut self) {
        self.change_output(Output::silence(), None);
        if self.audible {
            self.reopen(true);
        }
    }

    fn fall_silent(&mut self) {
        let place = self.change_output(Output::silence(), None);
        self.go_on_at(place);
        self.retry_at = Some(Instant::now() + self.retry_after);
    }

    /// Starts an empty ring. Time stands still at the last sample heard, or at `place`. Returns that
    /// position.
    fn change_output(&mut self, output: Output, place: Option<Stretch>) -> Option<Stretch> {
        // This drops the old output, and with it the other writer of the clock.
        self.output = output;
        let place = self.place().or(place);
        self.written = 0;
        (self.song, self.tail) = (None, Tail::default());
        let mut timeline = self.shared.timeline();
        self.shared.clock.restart();
        timeline.outputs += 1;
        timeline.rate_hz = self.output.rate_hz;
        timeline.device = self.output.device.clone();
        timeline.history = History::new(self.output.rate_hz);
        timeline.stretches.clear();
        timeline.dropped.clear();
        timeline.over = false;
        if let Some(place) = place {
            timeline.stretches.begin(Stretch { ring_frame: 0, ..place });
        }
        place
    }

    fn go_on_at(&mut self, place: Option<Stretch>) {
        if let Some(place) = place {
            self.start(Some(place.song), place.song_secs, self.playing);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::mpsc::channel;

    use super::*;
    use crate::player::hand_out::HandOut;
    use crate::player::settings::PlayerSettings;
    use crate::player::shared::Shared;
    use crate::{SEAM_SECS, Song, WavSample, write_wav};

    const RATE_HZ: u32 = 8000;
    const LOUD: f32 = 0.9;

    /// The next 64 frames that a device is handed out, on the left.
    fn ask(hand_out: &mut HandOut) -> Vec<f32> {
        let (mut buffer, now) = ([0.0f32; 128], Instant::now());
        hand_out.fill(&mut buffer, now, now);
        buffer.iter().step_by(2).copied().collect()
    }

    /// What a device hears of a loud level until it is closed, as another one is to be opened that is not there, and what the
    /// next one hears at first.
    fn change_of_device(folder: &std::path::Path) -> [Vec<f32>; 2] {
        let path = folder.join("loud.wav");
        let left = vec![LOUD; 20 * RATE_HZ as usize];
        let song = Song { rate_hz: RATE_HZ, right: left.clone(), left };
        write_wav(&path, &song, WavSample::Float32).unwrap();
        let (shared, (_commands, received), (report, _events)) =
            (Arc::new(Shared::new(1.0)), channel(), channel());
        let settings = PlayerSettings { audible: false, ..PlayerSettings::default() };
        let mut engine = Engine::new(Arc::clone(&shared), received, report, settings);
        (engine.list.songs, engine.device) = (vec![path], Some("nowhere".into()));
        let (output, mut hand_out, open) = Output::by_hand(RATE_HZ, &shared.clock);
        engine.change_output(output, None);
        engine.start(Some(0), 0.0, true);
        engine.fill();
        let device = std::thread::spawn(move || {
            let mut heard = Vec::new();
            while !open.is_abandoned() {
                let frames = ask(&mut hand_out);
                if !open.is_abandoned() {
                    heard.extend(frames);
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            heard
        });
        let end = Instant::now() + chladni_testdata::HANGS;
        while shared.clock.consumed() < 1000 {
            assert!(Instant::now() < end, "the device asks for nothing");
            engine.fill();
            std::thread::sleep(LOOK);
        }
        engine.reopen(true);
        let before = device.join().unwrap();
        let (output, mut hand_out, _open) = Output::by_hand(RATE_HZ, &shared.clock);
        engine.change_output(output, None);
        engine.start(Some(0), 1.0, true);
        engine.fill();
        let after = (0..8).flat_map(|_| ask(&mut hand_out)).collect();
        [before, after]
    }

    #[test]
    fn a_device_that_is_changed_fades_out_and_the_next_one_fades_in() {
        let folder = tempfile::tempdir().unwrap();
        // The fade of a jump, and that of the gain.
        let most = 3.1 * LOUD / (SEAM_SECS * RATE_HZ as f32);
        let largest_step = |heard: &[f32]| {
            let steps = heard.windows(2).map(|pair| (pair[1] - pair[0]).abs());
            steps.fold(0.0, f32::max)
        };
        // A busy machine may not ask for the end of the fade while it is waited for.
        let fades_out = (0..4).any(|_| {
            let [before, after] = change_of_device(folder.path()).map(|heard| [vec![0.0], heard].concat());
            for heard in [&before, &after] {
                assert!(heard.iter().any(|sample| *sample > 0.99 * LOUD), "nothing is heard");
                let step = largest_step(heard);
                assert!(step <= most, "{step} of {most}");
            }
            before.last() == Some(&0.0)
        });
        assert!(fades_out, "it is closed while it sounds");
    }

    #[test]
    fn a_device_of_another_rate_goes_on_where_the_song_was_heard() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ramp.wav");
        // Each sample says when it is heard.
        let left: Vec<f32> = (0..10 * 8000).map(|n| n as f32 / 80_000.0).collect();
        write_wav(&path, &Song { rate_hz: 8000, right: left.clone(), left }, WavSample::Float32).unwrap();
        let (shared, (commands, received), (report, _events)) =
            (Arc::new(Shared::new(1.0)), channel(), channel());
        let settings = PlayerSettings { audible: false, ..PlayerSettings::default() };
        let mut engine = Engine::new(Arc::clone(&shared), received, report, settings);
        drop(commands);
        engine.list.songs = vec![path];
        engine.start(Some(0), 3.0, true);
        for rate_hz in [44_100, 96_000, 22_050, 48_000] {
            engine.fill();
            // Time passes, as the silent output has it.
            let later = Instant::now() + Duration::from_millis(100);
            engine.output.advance(&shared.clock, later);
            let before = engine.place().unwrap().song_secs;
            let place = engine.change_output(Output::silence_at(rate_hz), None);
            engine.go_on_at(place);
            engine.fill();
            let after = engine.place().unwrap();
            assert!((after.song_secs - before).abs() < 0.02, "{} after {before}", after.song_secs);
            let timeline = shared.timeline();
            assert_eq!((timeline.rate_hz, timeline.playing), (rate_hz, true));
            // What is in the ring is that part of the song, at the new rate.
            let (mut left, mut right) = (vec![0.0; 2], vec![0.0; 2]);
            let second = rate_hz as i64 / 10;
            timeline.history.window(second, &mut left, &mut right);
            let secs = f64::from(left[0]) * 10.0;
            assert!((secs - (after.song_secs + 0.1)).abs() < 0.02, "{secs}, {}", after.song_secs);
        }
    }
}
