//! The sound and the beat that are heard now, and corrections of the beat by hand.

use chladni_music::{BeatReading, FileRef, SongRef};
use chladni_program::work::{Error, read_beats};
use chladni_sound::{Beats, Spectrum};
use wasm_bindgen::prelude::*;

use super::{Concert, is_called};

/// A song of the show.
#[derive(Default)]
pub(super) struct ShowSong {
    /// As a show file names it, which may be in folders that the page does not see.
    file: FileRef,
    /// As they were found; none before the song was decoded.
    pub beats: Option<Beats>,
    /// How they are read.
    pub reading: BeatReading,
}

impl ShowSong {
    /// It is the file of this name; if the show means that one, its path stays.
    pub fn call(&mut self, name: String) {
        if !is_called(&self.file.path, &name) {
            self.file = FileRef { path: name, blake3: None };
        }
    }

    /// As a show file names it.
    pub fn reference(&self) -> SongRef {
        SongRef { reading: self.reading, ..SongRef::of(self.file.clone()) }
    }
}

impl From<SongRef> for ShowSong {
    fn from(song: SongRef) -> Self {
        Self { file: song.file(), beats: None, reading: song.reading }
    }
}

#[wasm_bindgen]
impl Concert {
    /// Beats per minute of what is heard; 0 where no beat is known.
    pub fn tempo_bpm(&self) -> f64 {
        match &self.live {
            Some(live) => live.ear.follower.moment().tempo_bpm,
            None => self.known_beats().map_or(0.0, |beats| beats.tempo_bpm),
        }
    }

    /// The confidence of that beat, in [0, 1].
    pub fn beat_confidence(&self) -> f64 {
        match &self.live {
            Some(live) => live.ear.follower.moment().confidence,
            None => f64::from(self.hearing.beat_at(self.clock.at_secs()).confidence),
        }
    }

    /// The beat half as fast.
    ///
    /// # Errors
    /// No song is heard, and no microphone.
    pub fn halve_beat(&mut self) -> Result<(), JsError> {
        match &mut self.live {
            Some(live) => live.ear.follower.halve(),
            None => self.change_octave(-1)?,
        }
        Ok(())
    }

    /// The beat twice as fast.
    ///
    /// # Errors
    /// No song is heard, and no microphone.
    pub fn double_beat(&mut self) -> Result<(), JsError> {
        match &mut self.live {
            Some(live) => live.ear.follower.double(),
            None => self.change_octave(1)?,
        }
        Ok(())
    }

    /// A beat of the live sound falls now; from the second tap on, taps set the tempo, too.
    ///
    /// # Errors
    /// No microphone is listened to.
    pub fn tap_beat(&mut self) -> Result<(), JsError> {
        let why = "Here only the beat of a microphone can be tapped, not that of a song.";
        let live = self.live.as_mut().ok_or_else(|| JsError::new(why))?;
        let follower = &mut live.ear.follower;
        follower.tap(follower.now_secs());
        Ok(())
    }

    /// How the beats of a song are read, as JSON: for [`read_beats_as`](Self::read_beats_as) of another concert.
    ///
    /// # Errors
    /// A song that is not known.
    pub fn reading(&self, number: usize) -> Result<String, JsError> {
        let song = self.songs.get(number).ok_or_else(|| JsError::new("there is no such song"))?;
        Ok(serde_json::to_string(&song.reading)?)
    }

    /// Has the beats of a song read in another way from now on.
    ///
    /// # Errors
    /// Text that is not a reading.
    pub fn read_beats_as(&mut self, number: usize, reading: &str) -> Result<(), JsError> {
        Ok(self.read_otherwise(number, serde_json::from_str(reading)?)?)
    }

    /// The number of bands of the sound that was heard last; 0 where nothing was.
    pub fn bands(&self) -> usize {
        self.spectrum()
            .map_or(0, |(heard, bands_hz)| bands_hz.len().min(heard.mid.len()).min(heard.side.len()))
    }

    /// Where the frequencies of these bands, in Hz and ascending, begin in the module's memory.
    pub fn bands_hz(&self) -> *const f32 {
        self.spectrum().map_or(std::ptr::null(), |(_, bands_hz)| bands_hz.as_ptr())
    }

    /// Where the amplitudes of their middle begin, about [0, 1].
    pub fn mid(&self) -> *const f32 {
        self.spectrum().map_or(std::ptr::null(), |(heard, _)| heard.mid.as_ptr())
    }

    /// Where the amplitudes of their sides begin, times the side gain.
    pub fn side(&self) -> *const f32 {
        self.spectrum().map_or(std::ptr::null(), |(heard, _)| heard.side.as_ptr())
    }
}

impl Concert {
    /// The sound that was heard last, and the frequencies of its bands.
    fn spectrum(&self) -> Option<(&Spectrum, &[f32])> {
        let Some(live) = &self.live else { return self.hearing.spectrum() };
        let analyzer = live.ear.analyzer();
        Some((analyzer.spectrum(), analyzer.bands_hz()))
    }

    /// The number of the song that is heard.
    fn heard_song(&self) -> Option<usize> {
        self.hearing.stretch().filter(|_| self.live.is_none())?.song
    }

    /// Its beats, as they are read.
    fn known_beats(&self) -> Option<&Beats> {
        self.hearing.song(self.heard_song()?)?.beats.as_ref()
    }

    /// Doubles the tempo of the song that is heard, or halves it for −1.
    fn change_octave(&mut self, by: i32) -> Result<(), Error> {
        let song = self.heard_song().and_then(|number| Some((number, self.songs.get(number)?.reading)));
        let (number, mut reading) = song.ok_or_else(|| Error::input("No song is heard that has a beat."))?;
        reading.change_octave(by);
        // A show that is played is the user's own from then on.
        self.leave_script();
        self.read_otherwise(number, reading)
    }

    fn read_otherwise(&mut self, number: usize, reading: BeatReading) -> Result<(), Error> {
        let song = self.songs.get_mut(number).filter(|song| song.reading != reading);
        let Some(song) = song else { return Ok(()) };
        song.reading = reading;
        let Some(beats) = &song.beats else { return Ok(()) };
        self.hearing.know_beats(number, read_beats(beats, reading));
        self.count_beats()
    }

    /// What was done so far was done at the beats that are known now.
    pub(super) fn count_beats(&mut self) -> Result<(), Error> {
        self.instrument = self.instrument.with_beats(|moment| self.hearing.beats_at(moment))?;
        Ok(())
    }
}
