//! The handle that the rest of the program holds: commands go in, status and samples come out.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Instant;

use super::engine::{Command, Engine, PlayerEvent};
use super::queue::Repeat;
use super::settings::PlayerSettings;
use super::shared::Shared;
use crate::{LONGEST_CROSSFADE_SECS, SoundError};

/// What is shown lies this far ahead of what is heard at most, or behind it.
pub const MOST_AHEAD_SECS: f64 = 0.5;

/// Whether time passes in a song.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlayerState {
    /// There is no song, or its end was reached.
    #[default]
    Stopped,
    /// Time passes.
    Playing,
    /// Time stands still.
    Paused,
}

/// The state of the player at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlayerStatus {
    /// Stopped, playing or paused.
    pub state: PlayerState,
    /// Whether it stopped because the last song was heard to its end.
    pub is_over: bool,
    /// The index in the playlist of the song that is heard.
    pub song: usize,
    /// Whether that is the playlist given last. Not for a moment after another one was given, nor while a song sounds on
    /// that is not in it.
    pub is_listed: bool,
    /// The time in that song of the sample that is heard now; the latency of the device is accounted for. Where a picture
    /// is shown ahead ([`Player::show_ahead`]), both are those of the moment that it shows.
    pub position_secs: f64,
    /// The length of that song, if its header states it; no less than where it has come to.
    pub duration_secs: Option<f64>,
    /// The length of the crossfade with which that song began, half of it before it became the song that is
    /// heard; 0 where it began at once.
    pub crossfade_secs: f64,
    /// The device; `None` if there is none and time passes in silence.
    pub device: Option<String>,
    /// Rate of the samples of [`Player::heard_window`], in Hz.
    pub rate_hz: u32,
    /// How often the device got silence because samples came too late.
    pub underruns: u64,
}

/// How far [`Player::take_heard`] has taken what was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeardTo {
    /// Which output counts the frames.
    output: u64,
    frame: u64,
}

/// A player with a thread of its own. Dropping it ends the sound.
///
/// ```
/// use chladni_sound::{Player, PlayerSettings, PlayerState};
///
/// let player = Player::start(PlayerSettings { audible: false, ..PlayerSettings::default() })?;
/// assert_eq!(player.status().state, PlayerState::Stopped);
/// # Ok::<(), chladni_sound::SoundError>(())
/// ```
pub struct Player {
    shared: Arc<Shared>,
    /// How many playlists were given.
    lists: AtomicU64,
    commands: Sender<Command>,
    events: Receiver<PlayerEvent>,
    /// Whether it was reported that the engine is gone.
    is_gone: AtomicBool,
    thread: Option<JoinHandle<()>>,
}

impl Player {
    /// Starts the thread. A missing device is not an error: an event reports it.
    ///
    /// # Errors
    /// The system cannot create the thread.
    pub fn start(settings: PlayerSettings) -> Result<Self, SoundError> {
        let shared = Arc::new(Shared::new(settings.volume));
        let (commands, received) = channel();
        let (report, events) = channel();
        let engine_shared = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("sound".into())
            .spawn(move || Engine::new(engine_shared, received, report, settings).run())
            .map_err(|error| SoundError::Device { what: format!("no thread for it: {error}") })?;
        let (lists, is_gone) = (AtomicU64::new(0), AtomicBool::new(false));
        Ok(Self { shared, lists, commands, events, is_gone, thread: Some(thread) })
    }

    /// Replaces the playlist and plays its first song.
    pub fn play_list(&self, songs: Vec<PathBuf>) {
        self.lists.fetch_add(1, Ordering::Relaxed);
        self.send(Command::PlayList(songs));
    }

    /// Changes the playlist around the song that plays. If that song is no longer in it, the song in its
    /// place plays. Of one that is there more than once, the first place is taken for the first, and so on.
    pub fn set_songs(&self, songs: Vec<PathBuf>) {
        self.send_songs(songs, None);
    }

    /// The same where it is known to which place each song of the present list has gone: `None` is nowhere.
    pub fn rearrange(&self, songs: Vec<PathBuf>, places: Vec<Option<usize>>) {
        self.send_songs(songs, Some(places));
    }

    fn send_songs(&self, songs: Vec<PathBuf>, places: Option<Vec<Option<usize>>>) {
        self.lists.fetch_add(1, Ordering::Relaxed);
        self.send(Command::Songs(songs, places));
    }

    /// Continues after a pause, or starts again after the end.
    pub fn play(&self) {
        self.send(Command::Play);
    }

    /// Pauses.
    pub fn pause(&self) {
        // The clock is paused at once, not when the engine next checks its commands.
        self.shared.clock.set_paused(true);
        self.send(Command::Pause);
    }

    /// Goes to a time in the current song.
    pub fn seek(&self, secs: f64) {
        self.send(Command::Seek(secs));
    }

    /// Goes to the next song. It plays where `plays`; otherwise a player that is paused or stopped does not begin to.
    pub fn next(&self, plays: bool) {
        self.send(Command::Next { plays });
    }

    /// Goes to the previous song, likewise.
    pub fn previous(&self, plays: bool) {
        self.send(Command::Previous { plays });
    }

    /// Plays the song with this index in the playlist; nothing changes where there is none.
    pub fn select(&self, song: usize) {
        self.send(Command::Select(song));
    }

    /// Sets what happens after the end of a song.
    pub fn repeat(&self, repeat: Repeat) {
        self.send(Command::Repeat(repeat));
    }

    /// Sets how long the end of a song is heard under the beginning of the next, in seconds up to
    /// [`LONGEST_CROSSFADE_SECS`]. With 0, the start, one follows the other without a gap. At most half of what
    /// was heard of a song fades out; a song started by hand begins at once.
    pub fn set_crossfade_secs(&self, secs: f64) {
        let secs = if secs.is_finite() { secs.clamp(0.0, LONGEST_CROSSFADE_SECS) } else { 0.0 };
        self.send(Command::Crossfade(secs));
    }

    /// Sets the amplitude, in [0, 1].
    pub fn set_volume(&self, volume: f32) {
        self.shared.clock.set_volume(volume);
    }

    /// Sets how far ahead of what is heard the moment lies that a picture is to show, in seconds up to
    /// [`MOST_AHEAD_SECS`]; behind it where negative. A picture that is seen late, as through a projector, is drawn so
    /// much ahead. Status, windows and what is taken are those of that moment; what sounds stays.
    pub fn show_ahead(&self, secs: f64) {
        let secs = if secs.is_finite() { secs.clamp(-MOST_AHEAD_SECS, MOST_AHEAD_SECS) } else { 0.0 };
        self.shared.clock.show_ahead(secs);
    }

    /// How far ahead that is.
    pub fn shown_ahead_secs(&self) -> f64 {
        self.shared.clock.shown_ahead_secs()
    }

    /// Changes to the device with this id, `None` for the system's default; the song continues.
    pub fn set_device(&self, device: Option<String>) {
        self.send(Command::Device(device));
    }

    /// The events since the last call.
    pub fn events(&self) -> impl Iterator<Item = PlayerEvent> {
        std::iter::from_fn(move || match self.events.try_recv() {
            Ok(event) => Some(event),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => self.broke_off(),
        })
    }

    /// Stops without the engine, and reports once that it is gone.
    fn broke_off(&self) -> Option<PlayerEvent> {
        if self.is_gone.swap(true, Ordering::Relaxed) {
            return None;
        }
        self.shared.clock.set_paused(true);
        let mut timeline = self.shared.timeline();
        (timeline.playing, timeline.stopped) = (false, true);
        Some(PlayerEvent::BrokeOff)
    }

    /// The state of the player now.
    pub fn status(&self) -> PlayerStatus {
        let mut timeline = self.shared.timeline();
        let heard = self.shared.clock.shown_frame(Instant::now(), timeline.rate_hz);
        let rate_hz = timeline.rate_hz.max(1);
        let place = timeline.stretches.at(heard, rate_hz);
        // A picture that is shown ahead ends with the song; headers may say less than there is.
        let written = timeline.history.written();
        let position_secs = place.map_or(0.0, |(stretch, secs)| {
            secs.min(stretch.duration_secs.unwrap_or(0.0).max(stretch.secs_at(written as f64, rate_hz)))
        });
        PlayerStatus {
            state: match (timeline.stopped, timeline.playing) {
                (true, _) => PlayerState::Stopped,
                (false, true) => PlayerState::Playing,
                (false, false) => PlayerState::Paused,
            },
            is_over: timeline.over,
            song: place.map_or(0, |(stretch, _)| stretch.song),
            is_listed: place.is_none_or(|(stretch, _)| stretch.list == self.lists.load(Ordering::Relaxed)),
            position_secs,
            duration_secs: place
                .and_then(|(stretch, _)| stretch.duration_secs)
                .map(|duration| duration.max(position_secs)),
            crossfade_secs: place.map_or(0.0, |(stretch, _)| stretch.crossfade_secs),
            device: timeline.device.clone(),
            rate_hz: timeline.rate_hz,
            underruns: self.shared.clock.underruns(),
        }
    }

    /// Copies the samples around the one that is heard now, before volume, at [`PlayerStatus::rate_hz`].
    /// `ahead` frames of the window lie after the current one (0: the window ends there; half its length:
    /// it is centered). Returns the matching position in the song, in seconds.
    pub fn heard_window(&self, ahead: usize, left: &mut [f32], right: &mut [f32]) -> f64 {
        let mut timeline = self.shared.timeline();
        let rate_hz = timeline.rate_hz.max(1);
        let heard = self.shared.clock.shown_frame(Instant::now(), rate_hz);
        timeline.history.window(heard.round() as i64 + ahead as i64, left, right);
        timeline.stretches.at(heard, rate_hz).map_or(0.0, |(_, secs)| secs)
    }

    /// Appends all frames that were heard since the last call, before volume, at [`PlayerStatus::rate_hz`], and sets `from`
    /// to the frame heard now; the first call appends nothing. After a change of device, the frames are those of the new
    /// one. What a jump dropped was not heard. Frames more than a few seconds old are silence.
    ///
    /// Returns where in `left` frames come, now or with the next call, that do not follow from those before: at first,
    /// behind a jump, and from another device. A [`Seam`](crate::Seam) joins them.
    pub fn take_heard(
        &self,
        from: &mut Option<HeardTo>,
        left: &mut Vec<f32>,
        right: &mut Vec<f32>,
    ) -> Vec<usize> {
        let timeline = self.shared.timeline();
        let rate_hz = timeline.rate_hz.max(1);
        let heard = self.shared.clock.shown_frame(Instant::now(), rate_hz).round().max(0.0) as u64;
        let output = timeline.outputs;
        let (first, mut next) = match *from {
            None => (heard, None),
            Some(known) if known.output == output => (known.frame, Some(known.frame)),
            // Another one counts from its beginning.
            Some(_) => (0, None),
        };
        // A clock that goes back a little stands still.
        let end = heard.max(first);
        *from = Some(HeardTo { output, frame: end });
        let mut breaks = Vec::new();
        let parts = timeline.dropped.heard_of(first..end);
        let all: u64 = parts.clone().map(|part| part.end - part.start).sum();
        let mut too_old = all.saturating_sub(4 * u64::from(rate_hz));
        for part in parts {
            let old = too_old.min(part.end - part.start);
            too_old -= old;
            let before = left.len();
            if next != Some(part.start + old) {
                breaks.push(before);
            }
            next = Some(part.end);
            let after = before + (part.end - part.start - old) as usize;
            left.resize(after, 0.0);
            right.resize(after, 0.0);
            let (Some(left), Some(right)) = (left.get_mut(before..), right.get_mut(before..)) else {
                continue;
            };
            timeline.history.window(part.end as i64, left, right);
        }
        if next != Some(end) {
            breaks.push(left.len());
        }
        breaks
    }

    fn send(&self, command: Command) {
        // The engine ends only together with this handle, or by a bug, which is an event.
        let _ = self.commands.send(command);
    }
}

impl Drop for Player {
    fn drop(&mut self) {
        self.send(Command::Quit);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::history::History;

    #[test]
    fn that_the_engine_is_gone_is_reported_once_and_nothing_plays() {
        let shared = Arc::new(Shared::new(1.0));
        let mut timeline = shared.timeline();
        (timeline.playing, timeline.stopped) = (true, false);
        drop(timeline);
        let ((commands, _), (report, events)) = (channel(), channel());
        report.send(PlayerEvent::SongStarted(0)).unwrap();
        drop(report);
        let (lists, is_gone) = (AtomicU64::new(0), AtomicBool::new(false));
        let player = Player { shared, lists, commands, events, is_gone, thread: None };
        assert_eq!(player.status().state, PlayerState::Playing);
        let events: Vec<PlayerEvent> = player.events().collect();
        assert_eq!(events, [PlayerEvent::SongStarted(0), PlayerEvent::BrokeOff]);
        assert_eq!(player.events().count(), 0);
        assert_eq!(player.status().state, PlayerState::Stopped);
    }

    #[test]
    fn what_was_heard_is_taken_once_over_jumps_and_from_the_first_frame_of_another_device() {
        let shared = Arc::new(Shared::new(1.0));
        let ((commands, _), (_, events)) = (channel(), channel());
        let (lists, is_gone) = (AtomicU64::new(0), AtomicBool::new(false));
        let player = Player { shared: Arc::clone(&shared), lists, commands, events, is_gone, thread: None };
        // Each sample is the number of its frame.
        let open_another = || {
            let mut timeline = shared.timeline();
            timeline.outputs += 1;
            (timeline.rate_hz, timeline.history) = (48_000, History::new(48_000));
            timeline.dropped.clear();
            (0..3_000).for_each(|n| timeline.history.push([n as f32; 2]));
        };
        let mut from = None;
        // The first and the last frame, how many there are, and where one does not follow.
        let mut take_to = |frame: u64| {
            shared.clock.anchor(frame, Instant::now(), frame, frame);
            let (mut left, mut right) = (Vec::new(), Vec::new());
            let breaks = player.take_heard(&mut from, &mut left, &mut right);
            assert_eq!(left, right);
            (left.first().copied().zip(left.last().copied()), left.len(), breaks)
        };
        open_another();
        assert_eq!(take_to(500), (None, 0, vec![0]), "what came before is unknown");
        assert_eq!(take_to(1_500), (Some((500.0, 1_499.0)), 1_000, vec![]));
        assert_eq!(take_to(1_400), (None, 0, vec![]), "a clock that goes back a little");
        assert_eq!(take_to(1_600), (Some((1_500.0, 1_599.0)), 100, vec![]));
        shared.timeline().dropped.add(1_700..2_000);
        assert_eq!(take_to(2_100), (Some((1_600.0, 2_099.0)), 200, vec![100]));
        shared.timeline().dropped.add(2_100..2_500);
        assert_eq!(take_to(2_500), (None, 0, vec![0]), "a jump that nothing was heard behind yet");
        assert_eq!(take_to(2_600), (Some((2_500.0, 2_599.0)), 100, vec![]));
        open_another();
        assert_eq!(take_to(700), (Some((0.0, 699.0)), 700, vec![0]));
    }
}
