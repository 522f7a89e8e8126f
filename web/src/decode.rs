//! From a song's file to its samples and beats: slow, too, and for a worker.

use chladni_sound::{Song, SongOptions, SongReader, SoundError, sample_tune, track_beats};
use chladni_task::Task;
use wasm_bindgen::prelude::*;

/// Bytes of samples that a page takes: 12 minutes at 44.1 kHz.
const MOST_BYTES: usize = 256 << 20;
/// Browsers need not play sound of fewer frames per second.
const LEAST_RATE_HZ: u32 = 8_000;

/// A song in memory, and where its beats are.
#[wasm_bindgen]
pub struct DecodedSong {
    song: Song,
    beats: String,
    loud: f32,
    damage: Option<String>,
}

#[wasm_bindgen]
impl DecodedSong {
    /// Frames per second.
    #[wasm_bindgen(getter)]
    pub fn rate_hz(&self) -> u32 {
        self.song.rate_hz
    }

    /// The left channel, once: it is given away.
    pub fn take_left(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.song.left)
    }

    /// The right channel, once.
    pub fn take_right(&mut self) -> Vec<f32> {
        std::mem::take(&mut self.song.right)
    }

    /// Its beats, bars and sections, as [`Concert::know_song`](crate::Concert::know_song) reads them.
    #[wasm_bindgen(getter)]
    pub fn beats(&self) -> String {
        self.beats.clone()
    }

    /// How loud it gets, which [`Concert::know_song`](crate::Concert::know_song) would otherwise have to find out.
    #[wasm_bindgen(getter)]
    pub fn loud(&self) -> f32 {
        self.loud
    }

    /// The fault of a file that could be played all the same.
    #[wasm_bindgen(getter)]
    pub fn damage(&self) -> Option<String> {
        self.damage.clone()
    }
}

/// Decodes a song by the same decoders as the desktop, and tracks its beats; without bytes, our own tune.
///
/// # Errors
/// A file that is not a song, or too long.
#[wasm_bindgen]
pub fn decode(name: &str, bytes: Option<Vec<u8>>) -> Result<DecodedSong, JsError> {
    let task = Task::new();
    let (song, damage) = match bytes {
        Some(bytes) => {
            let mut reader = SongReader::from_bytes(name, bytes)?;
            let options = SongOptions { max_bytes: MOST_BYTES, ..SongOptions::default() };
            let song = Song::read(&mut reader, &options, &task).map_err(in_words_of_the_page)?;
            if song.rate_hz < LEAST_RATE_HZ {
                let rate_hz = song.rate_hz;
                let why = format!(
                    "{name}: browsers play no sound of {rate_hz} Hz; the program for the desktop does"
                );
                return Err(JsError::new(&why));
            }
            (song, reader.damage().map(|damage| damage.to_string()))
        }
        None => (sample_tune(), None),
    };
    let beats = serde_json::to_string(&track_beats(&song, &task)?)?;
    let loud = song.loud_level()?;
    Ok(DecodedSong { song, beats, loud, damage })
}

/// A page takes songs whole, and has no start and duration to give.
fn in_words_of_the_page(error: SoundError) -> JsError {
    let SoundError::TooLong { name, limit_secs } = error else { return error.into() };
    let minutes = (limit_secs / 60.0).floor();
    JsError::new(&format!(
        "{name}: longer than the {minutes} minutes that a page has memory for; the program for the desktop plays it"
    ))
}
