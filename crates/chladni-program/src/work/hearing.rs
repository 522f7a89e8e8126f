//! Sound bands and beat at any time of a show: a function of the show alone.

use std::collections::BTreeMap;
use std::sync::Arc;

use chladni_music::{
    Bands, Beat, ClockTrack, Director, Harmony, Parameters, Resonators, Ringing, Stretch, smooth,
};
use chladni_sound::{Beats, Hop, Song, SongSpectrum, SoundError, Spectrum, SpectrumSettings};

use self::clocked::Clocked;
use self::songs::Seam;
use super::tuning::Tuning;

mod clocked;
mod songs;
#[cfg(test)]
mod tests;

/// A jump within a song, or to another one, is faded over this time.
pub(super) const FADE_SECS: f64 = 0.3;
/// A song that goes on this near to where it was expected has not jumped: times are rounded.
const ROUNDED_SECS: f64 = 1e-6;
/// Jumps that happened this long before the earliest time asked for are ignored.
const FORGOTTEN_SECS: f64 = 10.0;

/// A song of the show that is known as a whole.
#[derive(Clone, Debug)]
pub struct KnownSong {
    /// Its samples.
    pub song: Arc<Song>,
    /// Its beats, once they are tracked.
    pub beats: Option<Beats>,
    /// [`Song::loud_level`]; 0 for silence.
    loud: f32,
}

impl KnownSong {
    /// A song known by its samples, which are read once to find how loud they get.
    ///
    /// # Errors
    /// [`SoundError::Setting`] where their rate is out of range.
    pub fn new(song: Arc<Song>) -> Result<Self, SoundError> {
        let loud = song.loud_level()?;
        Ok(Self::of_loudness(song, loud))
    }

    /// The same where it is known how loud they get: their [`Song::loud_level`].
    pub fn of_loudness(song: Arc<Song>, loud: f32) -> Self {
        Self { song, beats: None, loud }
    }
}

/// The sound and the beat at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    /// Since the show began.
    pub at_secs: f64,
    /// It comes of a song that is known as a whole.
    pub is_known: bool,
    /// The sound.
    pub bands: Bands<'a>,
    /// Which chords it is of.
    pub harmony: Harmony,
    /// The beat.
    pub beat: Beat,
    /// While a jump is fading: the beat before it, and how far the fade is, in [0, 1].
    pub fading: Option<(Beat, f32)>,
}

/// Follows a show stretch by stretch. The same stretches and knobs at the same times give the same result,
/// bit for bit, however often it is called.
#[derive(Default)]
pub struct Hearing {
    songs: BTreeMap<usize, KnownSong>,
    /// Each with how the count of beats goes on with it.
    stretches: Vec<(Stretch, Seam)>,
    /// The director of each song.
    directors: BTreeMap<usize, SongDirector>,
    /// An outer clock that was followed in place of the songs' beats.
    clocked: Clocked,
    tuning: Option<Tuning>,
    resonators: Option<Resonators>,
    /// Where in its song the ear began to listen.
    from_song_secs: f64,
    ear: Option<SongSpectrum>,
    fade: Option<Fade>,
    now: Spectrum,
    /// The state of the resonators, where there are any.
    ringing: Ringing,
    /// Which chords it is of.
    harmony: Harmony,
    /// Nothing before it will be asked for.
    begins_secs: f64,
}

/// Who films a song in one stretch.
struct SongDirector {
    /// When the stretch began.
    since_secs: f64,
    /// The last seed.
    seed: u64,
    director: Director,
}

struct Fade {
    from: Spectrum,
    ringing: Ringing,
    harmony: Harmony,
    beat: Beat,
    since_secs: f64,
}

/// A spectrum as the instrument takes it, without what rings.
pub fn bands_of(spectrum: &Spectrum) -> Bands<'_> {
    Bands {
        ringing: None,
        left: &spectrum.left,
        right: &spectrum.right,
        mid: &spectrum.mid,
        side: &spectrum.side,
        side_gain: spectrum.side_gain,
    }
}

impl Hearing {
    /// A hearing that will be asked for nothing before `begins_secs`.
    pub fn from(begins_secs: f64) -> Self {
        Self { begins_secs, ..Self::default() }
    }

    /// A song of the show, by its number, is known from now on.
    pub fn know(&mut self, number: usize, song: KnownSong) {
        self.songs.insert(number, song);
        self.directors.remove(&number);
        if self.stretch().is_some_and(|stretch| stretch.song == Some(number)) {
            self.ear = None;
        }
        self.count_again();
    }

    /// Its beats are.
    pub fn know_beats(&mut self, number: usize, beats: Beats) {
        if let Some(song) = self.songs.get_mut(&number) {
            song.beats = Some(beats);
        }
        self.directors.remove(&number);
        self.count_again();
    }

    /// A song, if it is known.
    pub fn song(&self, number: usize) -> Option<&KnownSong> {
        self.songs.get(&number)
    }

    /// Lets go of the samples of all songs but one; their beats are kept.
    pub fn forget_samples_but(&mut self, number: usize) {
        for (_, song) in self.songs.iter_mut().filter(|(known, _)| **known != number) {
            song.song = Arc::default();
        }
    }

    /// The stretch that was begun last.
    pub fn stretch(&self) -> Option<Stretch> {
        self.stretches.last().map(|(stretch, _)| *stretch)
    }

    /// All stretches so far.
    pub fn stretches(&self) -> impl Iterator<Item = Stretch> {
        self.stretches.iter().map(|(stretch, _)| *stretch)
    }

    /// A hearing of a show that goes on at `at_secs`, with the stretches heard before, in order, and the clock that
    /// was followed. A clock that is followed now counts as another one.
    pub fn continued(stretches: &[Stretch], clock: ClockTrack, at_secs: f64) -> Self {
        let mut hearing = Self::default();
        hearing.go_on(stretches, clock);
        hearing.leave_clock(at_secs);
        hearing
    }

    /// Continues a show: the stretches heard before, in order, and the clock that was followed.
    fn go_on(&mut self, stretches: &[Stretch], clock: ClockTrack) {
        self.know_clock(clock);
        self.stretches = stretches.iter().map(|stretch| (*stretch, Seam::default())).collect();
        (self.ear, self.fade) = (None, None);
        self.from_song_secs = self.stretch().map_or(0.0, |stretch| stretch.song_secs);
        self.count_again();
    }

    /// Whether what plays goes on in this stretch without a jump, as after a long absence: only the ear begins anew.
    pub fn goes_on_with(&self, stretch: Stretch) -> bool {
        self.stretch().is_some_and(|last| last.playing && stretch.playing && !leaps(last, stretch))
    }

    /// From `stretch.at_secs` on, this is heard.
    ///
    /// # Errors
    /// As [`hear`](Self::hear).
    pub fn begin(&mut self, stretch: Stretch) -> Result<(), SoundError> {
        let leaps = self.stretch().is_some_and(|last| leaps(last, stretch));
        if leaps && stretch.at_secs + FORGOTTEN_SECS > self.begins_secs {
            let beat = self.beat_at(stretch.at_secs);
            if self.listen(stretch.at_secs)? {
                self.fade_from(stretch.at_secs, self.heard(), beat);
            }
        }
        if leaps || self.goes_on_with(stretch) || self.stretches.is_empty() {
            self.ear = None;
            self.from_song_secs = stretch.song_secs;
        }
        let seam = self.seam(&self.stretches, stretch);
        self.stretches.push((stretch, seam));
        Ok(())
    }

    /// From `at_secs` on the ear is tuned as `parameters` say.
    pub fn tune(&mut self, at_secs: f64, parameters: &Parameters) {
        let tuning = Tuning::of(parameters);
        Resonators::follow(&mut self.resonators, tuning.timbre.as_ref(), tuning.bands);
        if self.tuning.replace(tuning).is_some_and(|before| before != tuning) {
            self.ear = None;
            self.from_song_secs = self.stretch().map_or(0.0, |stretch| stretch.song_secs_at(at_secs));
        }
    }

    /// Fades out sound that was heard in another way, from `at_secs` on, so that the shape does not jump.
    pub fn fade_from(
        &mut self,
        at_secs: f64,
        (from, ringing, harmony): (Spectrum, Ringing, Harmony),
        beat: Beat,
    ) {
        self.fade = Some(Fade { from, ringing, harmony, beat, since_secs: at_secs });
    }

    /// The last result, for an ear that goes on from it.
    pub fn heard(&self) -> (Spectrum, Ringing, Harmony) {
        (self.now.clone(), self.ringing.clone(), self.harmony)
    }

    /// The sound at `at_secs`, which lies in the stretch begun last; `None` where its song is not known.
    ///
    /// # Errors
    /// A song at a rate that the filter bank does not take.
    pub fn hear(&mut self, at_secs: f64) -> Result<Option<Heard<'_>>, SoundError> {
        if !self.listen(at_secs)? {
            return Ok(None);
        }
        let beat = self.beat_at(at_secs);
        let fading = self.fade.as_ref().map(|fade| (fade.beat, fade.done(at_secs)));
        // The beats of a clock do not leap where the song does.
        let is_clocked = self.clock().beat_at(at_secs).is_some();
        let fading = fading.filter(|(_, done)| *done < 1.0);
        let ringing = self.resonators.as_ref().map(|_| &self.ringing);
        let bands = Bands { ringing, ..bands_of(&self.now) };
        let mut harmony = self.harmony;
        if let (Some(fade), Some((_, done))) = (&self.fade, fading) {
            harmony.mix(fade.harmony, 1.0 - done);
        }
        let fading = fading.filter(|_| !is_clocked);
        Ok(Some(Heard { at_secs, is_known: true, bands, harmony, beat, fading }))
    }

    /// The spectrum that [`hear`](Self::hear) gave last, and where its bands lie.
    pub fn spectrum(&self) -> Option<(&Spectrum, &[f32])> {
        Some((&self.now, self.ear.as_ref()?.bands_hz()))
    }

    /// How it rings there.
    pub fn ringing(&self) -> &Ringing {
        &self.ringing
    }

    /// Which chords are heard there.
    pub fn harmony(&self) -> Harmony {
        self.harmony
    }

    /// Listens to `at_secs`; false where nothing is known of the sound there.
    fn listen(&mut self, at_secs: f64) -> Result<bool, SoundError> {
        let (Some(stretch), Some(tuning)) = (self.stretch(), self.tuning) else { return Ok(false) };
        let Some(number) = stretch.song else {
            let silence = vec![0.0; tuning.bands];
            let [mid, side, left, right] = std::array::from_fn(|_| silence.clone());
            self.now = Spectrum { mid, side, left, right, side_gain: tuning.side_gain };
            self.ringing.still(tuning.bands);
            return Ok(true);
        };
        let known = self.songs.get(&number).filter(|known| known.song.frames() > 0);
        let Some(known) = known else { return Ok(false) };
        let ear = match &mut self.ear {
            Some(ear) => ear,
            None => {
                let settings =
                    SpectrumSettings { loud: Some(known.loud), ..tuning.settings(known.song.rate_hz) };
                let song = Arc::clone(&known.song);
                self.ear.insert(SongSpectrum::new(song, settings, self.from_song_secs)?)
            }
        };
        let (bank, harmony) = (&mut self.resonators, &mut self.harmony);
        let after_secs = ear.at_after(stretch.song_secs_at(at_secs), |hop| match hop {
            Hop::Beginning => {
                *harmony = Harmony::default();
                bank.iter_mut().for_each(Resonators::still);
            }
            Hop::Heard(spectrum, bands_hz) => {
                harmony.hear(&spectrum.mid, bands_hz, SongSpectrum::HOP_SECS);
                bank.iter_mut().for_each(|bank| bank.hear(&bands_of(spectrum), SongSpectrum::HOP_SECS));
            }
        });
        self.now.clone_from(ear.spectrum());
        if let Some(bank) = bank {
            self.ringing.clone_from(bank.ring(after_secs));
        }
        if let Some(fade) = &self.fade {
            let done = fade.done(at_secs);
            if done < 1.0 {
                self.now.mix(&fade.from, 1.0 - done);
                self.ringing.mix(&fade.ringing, 1.0 - done);
            }
        }
        Ok(true)
    }
}

/// Whether a stretch begins elsewhere than the one before it has come to.
fn leaps(last: Stretch, next: Stretch) -> bool {
    let jump_secs = next.song_secs - last.song_secs_at(next.at_secs);
    last.song != next.song || jump_secs.abs() > ROUNDED_SECS
}

/// How far the fade after a jump is, `gone_secs` after it, in [0, 1].
pub(super) fn faded(gone_secs: f64) -> f32 {
    smooth((gone_secs / FADE_SECS).clamp(0.0, 1.0) as f32)
}

impl Fade {
    fn done(&self, at_secs: f64) -> f32 {
        faded(at_secs - self.since_secs)
    }
}
