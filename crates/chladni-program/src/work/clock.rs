//! The time of a show, which never goes back, whatever songs, pauses and jumps there are.

use chladni_music::Stretch;

/// If a song's position is ahead of the clock by more than this, the user has sought.
const SEEK_SECS: f64 = 0.3;
/// A position that has not moved for this long stands still.
const STILL_SECS: f64 = 0.1;
/// A song that stands still this near its end has ended: its silence continues.
const END_SECS: f64 = 0.05;
/// A device's clock goes back by less than this where it stumbles.
const BACK_SECS: f64 = 0.1;
/// After this long without a look, what plays begins a stretch of its own: an ear would take long to hear all of it.
const AWAY_SECS: f64 = 10.0;

/// The player's position at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playing {
    /// Which of the show's songs; `None` is live input.
    pub song: Option<usize>,
    /// Where in it.
    pub position_secs: f64,
    /// How long it is, where that is known.
    pub duration_secs: Option<f64>,
    /// The length of the crossfade in which this song began; it became the current song at the middle of it.
    pub crossfade_secs: f64,
    /// It was heard to its end, and no other follows.
    pub is_over: bool,
}

/// Seconds since the show began. While a song plays it keeps the song's time, to the last bit.
#[derive(Clone, Debug, Default)]
pub struct ShowClock {
    at_secs: f64,
    now_secs: Option<f64>,
    seen: Option<Playing>,
    still_secs: f64,
    stretch: Option<Stretch>,
}

impl ShowClock {
    /// A clock that continues from `at_secs`.
    pub fn from(at_secs: f64) -> Self {
        Self { at_secs, ..Self::default() }
    }

    /// The time of the show.
    pub fn at_secs(&self) -> f64 {
        self.at_secs
    }

    /// What is heard now; `None` before anything was.
    pub fn stretch(&self) -> Option<Stretch> {
        self.stretch
    }

    /// Whether a song's position came to `position_secs` by a stumble of the device's clock: a little back, and not to the
    /// song's beginning, as where it repeats.
    pub fn stumbles(step_secs: f64, position_secs: f64) -> bool {
        (-BACK_SECS..0.0).contains(&step_secs) && position_secs > BACK_SECS
    }

    /// Advances to the player's position at `now_secs` of any steadily running clock; returns the stretch that begins
    /// there, if one does.
    pub fn follow(&mut self, now_secs: f64, playing: Playing) -> Option<Stretch> {
        let dt_secs = (now_secs - self.now_secs.unwrap_or(now_secs)).max(0.0);
        self.now_secs = Some(now_secs);
        let seen = self.seen.replace(playing);
        let step_secs = seen.map_or(0.0, |seen| playing.position_secs - seen.position_secs);
        let moved = playing.song.is_none() || step_secs != 0.0;
        // A position that has stood still for a moment, as between two blocks of a device, catches up.
        let longest_step_secs = dt_secs + self.still_secs.min(SEEK_SECS) + SEEK_SECS;
        self.still_secs = if moved { 0.0 } else { self.still_secs + dt_secs };
        let position = playing.position_secs;
        // By the clock, which stands where it stumbles: many small steps back are a seek.
        let behind_secs =
            self.stretch.map_or(step_secs, |stretch| position - stretch.song_secs_at(self.at_secs));
        let stumbles = step_secs < 0.0 && Self::stumbles(behind_secs.min(step_secs), position);
        let follows = (0.0..=longest_step_secs).contains(&step_secs) || stumbles;
        // The length may be unknown or too long, and a picture ahead of the sound stands still before that is over.
        let ended = playing.is_over || playing.duration_secs.is_some_and(|end| position >= end - END_SECS);
        let plays = self.stretch.filter(|stretch| stretch.playing && stretch.song.is_some());
        if let Some(stretch) = plays.filter(|_| dt_secs > AWAY_SECS && (moved || ended)) {
            let goes_on = stretch.song == playing.song && follows;
            let by_song_secs = stretch.at_secs + (position - stretch.song_secs);
            let by_time_secs = self.at_secs + dt_secs;
            self.at_secs = if goes_on && moved { self.at_secs.max(by_song_secs) } else { by_time_secs };
            let song_secs = stretch.song_secs_at(self.at_secs);
            let anew = Stretch { at_secs: self.at_secs, song_secs, crossfade_secs: 0.0, ..stretch };
            // Where something else plays by now, that begins at the next look.
            self.stretch = goes_on.then_some(anew);
            return Some(anew);
        }
        let begin = |clock: &mut Self, song_secs, playing_on, crossfade_secs| {
            let (at_secs, song) = (clock.at_secs, playing.song);
            clock.stretch = Some(Stretch { at_secs, song, song_secs, playing: playing_on, crossfade_secs });
            clock.stretch
        };
        // A song that already played, as behind live input, has no crossfade.
        let crossfade_secs = if position <= playing.crossfade_secs { playing.crossfade_secs } else { 0.0 };
        let leap = |clock: &mut Self| {
            // Actions of the last moment were done before the leap, even if no time has passed since.
            let is_first = clock.stretch.is_none() && clock.at_secs == 0.0;
            let after_secs = if is_first { 0.0 } else { clock.at_secs.next_up() };
            clock.at_secs = (clock.at_secs + dt_secs).max(after_secs);
            begin(clock, position, true, crossfade_secs)
        };
        let Some(stretch) = self.stretch.filter(|stretch| stretch.song == playing.song) else {
            return leap(self);
        };
        if playing.song.is_none() {
            self.at_secs += dt_secs;
            return None;
        }
        if moved && !follows {
            return leap(self);
        }
        if moved {
            let began = if stretch.playing { None } else { begin(self, stretch.song_secs, true, 0.0) };
            if let Some(stretch) = self.stretch {
                self.at_secs = self.at_secs.max(stretch.at_secs + (position - stretch.song_secs));
            }
            return began;
        }
        if self.still_secs <= STILL_SECS {
            return None;
        }
        let changes = if stretch.playing { !ended } else { playing.is_over };
        // A pause begins when the song stopped, so that it is no leap.
        let begun = changes.then(|| begin(self, position, !stretch.playing, 0.0)).flatten();
        self.at_secs += dt_secs;
        begun
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn song(song: usize, position_secs: f64) -> Playing {
        let (duration_secs, crossfade_secs) = (Some(100.0), 0.0);
        Playing { song: Some(song), position_secs, duration_secs, crossfade_secs, is_over: false }
    }

    #[test]
    fn playing_pausing_seeking_and_another_song_each_begin_a_stretch() {
        let mut clock = ShowClock::default();
        let mut begun = Vec::new();
        let mut now = 50.0;
        let mut follow = |clock: &mut ShowClock, playing: Playing| {
            now += 1.0 / 16.0;
            let at = clock.at_secs();
            begun.extend(clock.follow(now, playing));
            assert!(clock.at_secs() >= at);
        };
        (0..16).for_each(|i| follow(&mut clock, song(0, f64::from(i) / 16.0)));
        assert_eq!(clock.at_secs(), 15.0 / 16.0);
        (0..16).for_each(|_| follow(&mut clock, song(0, 15.0 / 16.0)));
        (0..16).for_each(|i| follow(&mut clock, song(0, f64::from(15 + i) / 16.0)));
        (0..16).for_each(|i| follow(&mut clock, song(0, 40.0 + f64::from(i) / 16.0)));
        (0..16).for_each(|i| follow(&mut clock, song(1, f64::from(i) / 16.0)));
        (0..4).for_each(|_| follow(&mut clock, Playing { song: None, ..song(0, 0.0) }));
        let kinds: Vec<_> = begun.iter().map(|s| (s.song, s.song_secs, s.playing)).collect();
        let paused = (Some(0), 15.0 / 16.0, false);
        let on = |song, secs| (song, secs, true);
        assert_eq!(
            kinds,
            [
                on(Some(0), 0.0),
                paused,
                on(Some(0), 15.0 / 16.0),
                on(Some(0), 40.0),
                on(Some(1), 0.0),
                on(None, 0.0)
            ]
        );
        assert!(begun.windows(2).all(|pair| pair[0].at_secs < pair[1].at_secs));
        assert_eq!(begun[1].at_secs, 15.0 / 16.0);
    }

    #[test]
    fn a_leap_without_any_time_begins_after_what_was_done_before() {
        for next in [song(0, 0.5), song(1, 0.5), Playing { song: None, ..song(0, 0.0) }] {
            let mut clock = ShowClock::default();
            assert_eq!(clock.follow(1.0, song(0, 3.0)).map(|stretch| stretch.at_secs), Some(0.0));
            clock.follow(1.5, song(0, 3.5));
            let done_secs = clock.at_secs();
            let begun = clock.follow(1.5, next);
            assert!(begun.is_some_and(|stretch| stretch.at_secs > done_secs), "{begun:?}");
        }
    }

    #[test]
    fn a_clock_that_stumbles_is_no_leap() {
        let mut clock = ShowClock::default();
        assert!(clock.follow(0.0, song(0, 3.0)).is_some());
        let looks = [(0.5, 3.5, 0.5), (0.5625, 3.4375, 0.5), (0.75, 3.625, 0.625)];
        for (now_secs, position_secs, at_secs) in looks {
            assert_eq!(clock.follow(now_secs, song(0, position_secs)), None);
            assert_eq!(clock.at_secs(), at_secs);
        }
        // A seek goes farther back, and a short song that repeats goes to its beginning.
        assert!(clock.follow(0.8125, song(0, 3.125)).is_some());
        assert!(clock.follow(0.875, song(1, 0.0625)).is_some());
        assert!(clock.follow(0.9375, song(1, 0.0)).is_some());
        // So do many small steps.
        let mut clock = ShowClock::default();
        let begun = [5.0, 4.9375, 4.875, 4.8125].into_iter().enumerate();
        let begun = begun.filter_map(|(i, at)| clock.follow(i as f64 / 16.0, song(0, at)));
        assert_eq!(begun.map(|stretch| stretch.song_secs).collect::<Vec<_>>(), [5.0, 4.875]);
    }

    #[test]
    fn after_a_long_absence_what_plays_begins_a_stretch_of_its_own() {
        let mut clock = ShowClock::default();
        clock.follow(0.0, song(0, 3.0));
        assert_eq!(clock.follow(1.0, song(0, 4.0)), None);
        let place = |stretch: Stretch| (stretch.at_secs, stretch.song, stretch.song_secs, stretch.playing);
        assert_eq!(clock.follow(61.0, song(0, 64.0)).map(place), Some((61.0, Some(0), 64.0, true)));
        assert_eq!(clock.follow(61.5, song(0, 64.5)), None);
        // Something else is heard at the next look.
        let live = Playing { song: None, ..song(0, 0.0) };
        for next in [song(1, 2.0), song(0, 5.0), live] {
            let mut clock = clock.clone();
            assert_eq!(clock.follow(90.5, next).map(place), Some((90.5, Some(0), 93.5, true)));
            let begun = clock.follow(90.625, next).map(place);
            assert_eq!(begun, Some((90.625, next.song, next.position_secs, true)));
        }
        // So does the silence behind a song.
        let over = Playing { is_over: true, ..song(0, 64.5) };
        assert_eq!(clock.follow(90.5, over).map(place), Some((90.5, Some(0), 93.5, true)));
        assert_eq!(clock.follow(90.625, over), None);
        assert_eq!(clock.at_secs(), 90.625);
    }

    #[test]
    fn a_crossfade_belongs_to_the_song_that_begins_with_it() {
        let fading = |number, position_secs| Playing { crossfade_secs: 4.0, ..song(number, position_secs) };
        let mut clock = ShowClock::default();
        let begun =
            [(0, 30.0), (0, 30.1), (1, 2.1), (1, 2.2), (1, 2.2), (1, 2.2), (1, 2.2), (1, 2.3), (1, 0.5)];
        let begun = begun.into_iter().enumerate();
        let begun = begun.filter_map(|(i, (number, at))| clock.follow(i as f64 / 10.0, fading(number, at)));
        let fades: Vec<_> = begun.map(|stretch| (stretch.song_secs, stretch.crossfade_secs)).collect();
        assert_eq!(fades, [(30.0, 0.0), (2.1, 4.0), (2.2, 0.0), (2.2, 0.0), (0.5, 4.0)]);
    }

    #[test]
    fn the_silence_behind_a_song_goes_on() {
        let over = Playing { is_over: true, ..song(0, 3.0) };
        let at_end = Playing { duration_secs: Some(3.0), is_over: false, ..over };
        for end in [at_end, over, Playing { duration_secs: None, ..over }] {
            let mut clock = ShowClock::default();
            let begun = (0..40).filter_map(|i| clock.follow(f64::from(i) / 20.0, end)).count();
            assert_eq!(begun, 1);
            assert!(clock.at_secs() > 1.5, "{}", clock.at_secs());
        }
        // The picture comes to the end before the sound.
        let mut clock = ShowClock::default();
        let ahead = |i: u32| if i < 10 { song(0, 3.0) } else { over };
        let begun = (0..40).filter_map(|i| clock.follow(f64::from(i) / 20.0, ahead(i)));
        assert_eq!(begun.map(|stretch| stretch.playing).collect::<Vec<_>>(), [true, false, true]);
    }
}
