//! The set as it is played, as a film: what the stage shows and what is heard.

use std::path::{Path, PathBuf};

use chladni_sound::StereoResampler;
use chladni_view::Picture;
use chladni_view::film::LiveFilm;

use super::listening::HeardSound;
use super::outgoing::RATE;
use super::salvage::Note;
use crate::work::Error;

/// Of the film's sound.
const SOUND_HZ: u32 = 48_000;

/// One recording.
pub struct Recorder {
    film: LiveFilm,
    path: PathBuf,
    since_secs: f64,
    resampler: Option<(u32, StereoResampler)>,
    ends: bool,
    /// Lets the next session find what this one may not finish.
    note: Option<Note>,
}

impl Recorder {
    /// Begins a film of `size` pixels at `now_secs` of the window.
    pub fn begin(path: &Path, size: [u32; 2], now_secs: f64) -> Result<Self, Error> {
        // H.264 wants even sides.
        let [width, height] = size.map(|length| (length & !1).max(2));
        let film = LiveFilm::begin(path, (width, height), RATE, SOUND_HZ)?;
        let path = path.to_owned();
        Ok(Self { film, path, since_secs: now_secs, resampler: None, ends: false, note: None })
    }

    /// Notes it in the folder of recovery copies.
    pub fn note(&mut self, recovery: &Path) -> Result<(), Error> {
        let note = Note::write(recovery, self.film.folder());
        self.note = Some(note.map_err(|why| Error::unwritten(recovery, why))?);
        Ok(())
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How long it is, and how many pictures were left out.
    pub fn progress(&self, now_secs: f64) -> (f64, u64) {
        (now_secs - self.since_secs, self.film.left_out())
    }

    /// Takes what was seen at `now_secs`.
    pub fn picture(&mut self, now_secs: f64, picture: Picture) {
        if !self.ends {
            self.film.picture(now_secs - self.since_secs, picture);
        }
    }

    /// Takes what was heard up to now.
    pub fn sound(&mut self, now_secs: f64, heard: &HeardSound) -> Result<(), Error> {
        let at_secs = now_secs - self.since_secs;
        if heard.rate_hz == SOUND_HZ || heard.left.is_empty() {
            self.film.sound(at_secs, &heard.left, &heard.right);
            return Ok(());
        }
        let fitting = self.resampler.take().filter(|(rate_hz, _)| *rate_hz == heard.rate_hz);
        let (rate_hz, mut resampler) = match fitting {
            Some(known) => known,
            None => (heard.rate_hz, StereoResampler::new(heard.rate_hz, SOUND_HZ)?),
        };
        let pairs = heard.left.iter().zip(&heard.right);
        let interleaved: Vec<f32> = pairs.flat_map(|(left, right)| [*left, *right]).collect();
        let mut out = Vec::new();
        resampler.process(&interleaved, &mut out)?;
        self.resampler = Some((rate_hz, resampler));
        let (left, right): (Vec<f32>, Vec<f32>) =
            out.as_chunks::<2>().0.iter().map(|[l, r]| (*l, *r)).unzip();
        self.film.sound(at_secs, &left, &right);
        Ok(())
    }

    /// It ends now; its file appears a little later.
    pub fn finish(&mut self, now_secs: f64) {
        if !std::mem::replace(&mut self.ends, true) {
            self.film.finish(now_secs - self.since_secs);
        }
    }

    /// How many frames it has, once its file is there, or why it is not; then its note stays.
    pub fn ended(&mut self) -> Option<Result<u64, Error>> {
        let ended = self.film.ended()?;
        if ended.is_err() {
            self.note.take().into_iter().for_each(Note::leave);
        }
        Some(ended.map_err(Error::from))
    }

    /// As [`ended`](Self::ended), but waits: the window closes.
    pub fn wait(&mut self) {
        if let Some(Err(_)) = self.film.wait() {
            self.note.take().into_iter().for_each(Note::leave);
        }
    }
}
