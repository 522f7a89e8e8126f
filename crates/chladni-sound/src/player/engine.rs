//! The thread that decodes songs and fills the ring.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use self::device::FIRST_RETRY;
use super::decoding::Decoding;
use super::output::Output;
use super::queue::{Playlist, Repeat, Stretch};
use super::settings::PlayerSettings;
use super::shared::Shared;
use super::tail::Tail;
use crate::StereoResampler;
use crate::history::Frame;

mod device;

/// How far ahead of the device the ring is filled: as far as a picture is shown ahead, and half a window more.
const AHEAD_SECS: f64 = 0.6;
/// How often the engine refills the ring.
const STEP: Duration = Duration::from_millis(5);
/// The largest number of songs that begin before the engine checks its commands again: repeating a song of
/// a few samples would otherwise take all its time.
const MOST_STARTS: usize = 8;
/// Frames that are decoded before the next ones are: others wait meanwhile for the timeline.
const BATCH_FRAMES: usize = 1024;
/// An event of a player.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PlayerEvent {
    /// Decoding of this song of the playlist begins.
    SongStarted(usize),
    /// This song could not be played and was skipped.
    SongFailed {
        /// Its index in the playlist.
        song: usize,
        /// The reason.
        reason: String,
    },
    /// This song was played, but part of it was missing.
    SongDamaged {
        /// Its index in the playlist.
        song: usize,
        /// The missing part.
        what: String,
    },
    /// The last song has ended.
    Finished,
    /// Sound is now played by this device.
    DeviceOpened(String),
    /// The device was lost, or there was none, for this reason: time passes in silence until one is found.
    DeviceLost(String),
    /// The player's thread has ended by a bug: nothing plays any more.
    BrokeOff,
}

pub(super) enum Command {
    PlayList(Vec<PathBuf>),
    /// Another list, and for each song of the present one its place in that, where it is known.
    Songs(Vec<PathBuf>, Option<Vec<Option<usize>>>),
    Play,
    Pause,
    Seek(f64),
    /// Without `plays`, a paused player stays paused.
    Next {
        plays: bool,
    },
    /// Likewise.
    Previous {
        plays: bool,
    },
    Select(usize),
    Repeat(Repeat),
    Crossfade(f64),
    Device(Option<String>),
    Quit,
}

pub(super) struct Engine {
    shared: Arc<Shared>,
    commands: Receiver<Command>,
    /// A command that was received, and is to be obeyed next.
    waiting: Option<Command>,
    events: Sender<PlayerEvent>,
    audible: bool,
    device: Option<String>,
    output: Output,
    list: Playlist,
    song: Option<Decoding>,
    /// The rest of the song before it.
    tail: Tail,
    crossfade_secs: f64,
    /// Frames on their way to the ring.
    batch: Vec<Frame>,
    /// The number of frames written to the current ring.
    written: u64,
    playing: bool,
    retry_at: Option<Instant>,
    retry_after: Duration,
}

impl Engine {
    pub fn new(
        shared: Arc<Shared>,
        commands: Receiver<Command>,
        events: Sender<PlayerEvent>,
        settings: PlayerSettings,
    ) -> Self {
        let mut engine = Self {
            shared,
            commands,
            waiting: None,
            events,
            audible: settings.audible,
            device: settings.device,
            output: Output::silence(),
            list: Playlist::default(),
            song: None,
            tail: Tail::default(),
            crossfade_secs: 0.0,
            batch: Vec::with_capacity(BATCH_FRAMES),
            written: 0,
            playing: false,
            retry_at: None,
            retry_after: FIRST_RETRY,
        };
        engine.open_output();
        engine
    }

    /// Runs until the handle is dropped.
    pub fn run(mut self) {
        loop {
            match self.next_command() {
                Ok(Command::Quit) | Err(RecvTimeoutError::Disconnected) => return self.hush(),
                Ok(command) => self.obey(command),
                Err(RecvTimeoutError::Timeout) => {}
            }
            self.look_after_output();
            self.fill();
        }
    }

    /// The next command, if one comes soon. Of seeks that wait in a row, as those of a slider that is dragged, the last one.
    fn next_command(&mut self) -> Result<Command, RecvTimeoutError> {
        let mut command = match self.waiting.take() {
            Some(command) => command,
            None => self.commands.recv_timeout(STEP)?,
        };
        while matches!(command, Command::Seek(_)) {
            match self.commands.try_recv() {
                Ok(next @ Command::Seek(_)) => command = next,
                next => {
                    self.waiting = next.ok();
                    break;
                }
            }
        }
        Ok(command)
    }

    fn obey(&mut self, command: Command) {
        match command {
            Command::PlayList(songs) => {
                (self.list.songs, self.list.current) = (songs, 0);
                self.list.number += 1;
                self.start(Some(0), 0.0, true);
            }
            Command::Songs(songs, places) => self.set_songs(songs, places),
            Command::Play if self.place().is_some() => self.set_playing(true),
            Command::Play => self.start(Some(self.list.current), 0.0, true),
            Command::Pause => self.set_playing(false),
            Command::Seek(secs) => {
                let secs = if secs.is_finite() { secs.max(0.0) } else { 0.0 };
                self.back_to_heard();
                self.start(Some(self.list.current), secs, self.playing);
            }
            Command::Next { plays } => {
                self.back_to_heard();
                self.start(self.list.after(true), 0.0, plays || self.playing);
            }
            Command::Previous { plays } => {
                self.back_to_heard();
                self.start(self.list.before(), 0.0, plays || self.playing);
            }
            Command::Select(song) if song < self.list.songs.len() => self.start(Some(song), 0.0, true),
            Command::Select(_) => {}
            Command::Repeat(repeat) => self.list.repeat = repeat,
            Command::Crossfade(secs) => self.crossfade_secs = secs,
            Command::Device(device) => {
                self.device = device;
                self.retry_after = FIRST_RETRY;
                self.reopen(true);
            }
            Command::Quit => {}
        }
    }

    /// Replaces the list around the song that plays. If that song is no longer in it, the one in its place
    /// plays. If only the one that is decoded ahead is not, or no longer comes next, the song that is heard goes on to its
    /// end, and then the list.
    fn set_songs(&mut self, songs: Vec<PathBuf>, places: Option<Vec<Option<usize>>>) {
        let places = places.unwrap_or_else(|| self.list.places_in(&songs));
        let heard = self.place().filter(|heard| heard.list == self.list.number);
        let heard = heard.and_then(|heard| Some(((*places.get(heard.song)?)?, heard)));
        self.shared.timeline().stretches.renumber(&places, self.list.number);
        self.list.number += 1;
        let current = self.list.current;
        let last = songs.len().checked_sub(1);
        self.list.songs = songs;
        if let Some((at, _)) = heard {
            self.list.current = at;
        }
        let (repeats, after) = (self.list.repeat == Repeat::Song, self.list.after(false));
        let is_next = |place: usize, at: usize, heard: Stretch| {
            // The same song, or one behind others that cannot be read; none where the list has begun anew.
            let ahead = current.checked_sub(heard.song);
            repeats || after == Some(place) || ahead.is_some_and(|songs| place == at + songs)
        };
        match (places.get(current).copied().flatten(), heard) {
            (Some(place), None) => self.list.current = place,
            (Some(place), Some((at, heard))) if is_next(place, at, heard) => self.list.current = place,
            (_, Some((at, heard))) => self.start(Some(at), heard.song_secs, self.playing),
            (None, None) => self.start(last.map(|last| current.min(last)), 0.0, self.playing),
        }
    }

    /// The stretch that is heard now; `None` before the first song.
    fn heard(&self) -> Option<Stretch> {
        let mut timeline = self.shared.timeline();
        let rate_hz = timeline.rate_hz.max(1);
        let frame = self.shared.clock.heard_frame(Instant::now(), rate_hz);
        let (stretch, song_secs) = timeline.stretches.at(frame, rate_hz)?;
        Some(Stretch { song_secs, ..stretch })
    }

    /// The stretch that is heard now, if part of the songs is still to be heard.
    fn place(&self) -> Option<Stretch> {
        let taken = self.shared.clock.consumed().max(self.shared.clock.flushed_before());
        if self.is_ending() && taken >= self.written { None } else { self.heard() }
    }

    /// Whether all that was to be played is in the ring.
    fn is_ending(&self) -> bool {
        self.song.is_none() && self.tail.is_over()
    }

    /// Goes back to the song that is heard, to which "next", "previous" and seeking refer: the ring may already
    /// hold the next one. A song that was removed from the list keeps its number until it ends, which may lie beyond the
    /// list.
    fn back_to_heard(&mut self) {
        let heard = self.heard().map(|heard| heard.song);
        self.list.current = heard.filter(|&song| song < self.list.songs.len()).unwrap_or(self.list.current);
    }

    fn set_playing(&mut self, playing: bool) {
        self.playing = playing;
        let stopped = self.place().is_none();
        let mut timeline = self.shared.timeline();
        timeline.playing = playing;
        timeline.stopped = stopped;
        timeline.over &= stopped;
        self.shared.clock.set_paused(!playing);
    }

    /// Starts a song at a time, at once: the ring is flushed.
    fn start(&mut self, song: Option<usize>, secs: f64, playing: bool) {
        self.flush();
        (self.song, self.tail) = (None, Tail::default());
        self.shared.clock.set_drained(true);
        if let Some(song) = song {
            self.open_song(song, secs, None);
        }
        self.set_playing(playing && self.song.is_some());
    }

    /// Drops what was not yet handed out.
    fn flush(&self) {
        // What was handed out is still heard, and the picture shows it so much earlier.
        let mut timeline = self.shared.timeline();
        let ahead = (self.shared.clock.shown_ahead_secs() * f64::from(timeline.rate_hz)) as i64;
        let first = self.shared.clock.consumed().saturating_add_signed(ahead).min(self.written);
        timeline.dropped.add(first..self.written.saturating_add_signed(ahead.max(0)));
        self.shared.clock.flush_before(self.written);
    }

    /// Opens a song, or the next one that can be opened, and records its place in the ring, behind what the song before has
    /// left. Returns that where no song can be opened.
    fn open_song(
        &mut self,
        first: usize,
        secs: f64,
        mut before: Option<StereoResampler>,
    ) -> Option<StereoResampler> {
        if first >= self.list.songs.len() {
            return before;
        }
        let mut secs = secs;
        self.list.current = first;
        for _ in 0..self.list.songs.len() {
            let song = self.list.current;
            let Some(path) = self.list.songs.get(song) else { return before };
            let opened = Decoding::open(path, secs, self.output.rate_hz).and_then(|mut decoding| {
                let led = before.take().map_or(Ok(0), |before| decoding.follow(before))?;
                Ok((decoding, led))
            });
            match opened {
                Ok((decoding, led)) => {
                    let rate_hz = f64::from(decoding.reader.rate_hz());
                    let total_frames = decoding.reader.total_frames();
                    // At most half of a short song: a crossfade that goes on at its end would leave too little power. What
                    // was written as a stream may state 0.
                    if let Some(frames) = total_frames.filter(|frames| *frames > 0) {
                        let half = 0.5 * frames as f64 * f64::from(self.output.rate_hz) / rate_hz;
                        self.tail.shorten(half as usize);
                    }
                    let begins = self.written + led + self.tail.alone() as u64;
                    // From the middle of a crossfade on, this song is the louder one.
                    let middle = self.tail.len() / 2;
                    let secs_of = |frames: usize| frames as f64 / f64::from(self.output.rate_hz);
                    self.shared.timeline().stretches.begin(Stretch {
                        ring_frame: begins + middle as u64,
                        list: self.list.number,
                        song,
                        song_secs: secs + secs_of(middle),
                        duration_secs: total_frames.map(|frames| frames as f64 / rate_hz),
                        crossfade_secs: secs_of(self.tail.len()),
                    });
                    self.song = Some(decoding);
                    self.tell(PlayerEvent::SongStarted(song));
                    return None;
                }
                Err(error) => self.tell(PlayerEvent::SongFailed { song, reason: error.to_string() }),
            }
            secs = 0.0;
            match self.list.after(true) {
                Some(next) => self.list.current = next,
                None => return before,
            }
        }
        before
    }

    /// Decodes until the ring is filled as far as intended.
    fn fill(&mut self) {
        let target = (AHEAD_SECS * f64::from(self.output.rate_hz)) as u64;
        // Frames that a pending flush will drop do not count.
        let clock = Arc::clone(&self.shared.clock);
        let taken = || clock.consumed().max(clock.flushed_before());
        let mut starts = 0;
        while self.written < taken() + target && starts < MOST_STARTS {
            let room = self.output.producer.slots().min(BATCH_FRAMES);
            if room == 0 {
                return;
            }
            if self.write(room) {
                continue;
            }
            let Some(decoding) = self.song.take() else { break };
            self.end_song(decoding);
            starts += 1;
        }
        // Once the ring is first filled, silence is an underrun until all is played.
        clock.set_drained(self.is_ending());
        if self.is_ending() && self.playing && clock.consumed() >= self.written {
            self.set_playing(false);
            let mut timeline = self.shared.timeline();
            (timeline.stopped, timeline.over) = (true, true);
            drop(timeline);
            self.tell(PlayerEvent::Finished);
        }
    }

    /// Decodes a batch into the ring, which has `room` for it, and into the history. Returns false if there
    /// is nothing more of this song.
    fn write(&mut self, room: usize) -> bool {
        let kept = self.list.after(false).map_or(0.0, |_| self.crossfade_secs);
        let kept = (kept * f64::from(self.output.rate_hz)) as usize;
        self.batch.clear();
        while self.batch.len() < room {
            let frame = match &mut self.song {
                Some(song) if self.tail.alone() == 0 => song.next(kept).map(|frame| self.tail.mix(frame)),
                _ => self.tail.next(),
            };
            let Some(frame) = frame else { break };
            self.batch.push(frame);
        }
        let mut timeline = self.shared.timeline();
        for &frame in &self.batch {
            if self.output.producer.push(frame).is_ok() {
                timeline.history.push(frame);
                self.written += 1;
            }
        }
        !self.batch.is_empty()
    }

    /// Goes on with the next song; the rest of this one is heard beneath it.
    fn end_song(&mut self, decoding: Decoding) {
        let song = self.list.current;
        let damage = decoding.reader.damage().map(|what| format!("{}: {what}", decoding.reader.name()));
        let (rest, resampler, decoded) = decoding.rest();
        match (decoded, damage) {
            (Err(error), _) => self.tell(PlayerEvent::SongFailed { song, reason: error.to_string() }),
            (Ok(()), Some(what)) => self.tell(PlayerEvent::SongDamaged { song, what }),
            (Ok(()), None) => {}
        }
        self.tail = rest.over(std::mem::take(&mut self.tail));
        let left = match self.list.after(false) {
            Some(next) => self.open_song(next, 0.0, Some(resampler)),
            None => Some(resampler),
        };
        // Its last frames are played where no song follows.
        let mut last = Vec::new();
        let finished = left.is_some_and(|mut resampler| resampler.finish(&mut last).is_ok());
        if finished && !last.is_empty() {
            let last = Tail::of(last.as_chunks().0.iter().copied());
            self.tail = last.over(std::mem::take(&mut self.tail));
        }
    }

    fn tell(&self, event: PlayerEvent) {
        // There may be no receiver.
        let _ = self.events.send(event);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn of_seeks_that_wait_the_last_one_is_obeyed() {
        let ((commands, received), (report, _events)) = (channel(), channel());
        let settings = PlayerSettings { audible: false, ..PlayerSettings::default() };
        let mut engine = Engine::new(Arc::new(Shared::new(1.0)), received, report, settings);
        let seek = |secs: f64| commands.send(Command::Seek(secs)).unwrap();
        [1.0, 2.0].into_iter().for_each(seek);
        commands.send(Command::Play).unwrap();
        [3.0, 4.0, 5.0].into_iter().for_each(seek);
        let obeyed: Vec<Option<f64>> = (0..3)
            .map(|_| match engine.next_command() {
                Ok(Command::Seek(secs)) => Some(secs),
                _ => None,
            })
            .collect();
        assert_eq!(obeyed, [Some(2.0), None, Some(5.0)]);
    }
}
