//! Writes test songs with known beats: `beat_songs FOLDER` makes NAME.wav and NAME.beats.txt.

#[allow(dead_code, reason = "tests use more of it")]
#[path = "../tests/songs/mod.rs"]
mod songs;

use chladni_sound::{WavSample, write_wav};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("which folder?")?);
    std::fs::create_dir_all(&folder)?;
    for made in songs::songs() {
        write_wav(&folder.join(format!("{}.wav", made.name)), &made.song, WavSample::Int16)?;
        let lines: String = made.beats_secs.iter().map(|b| format!("{b:.4}\n")).collect();
        std::fs::write(folder.join(format!("{}.beats.txt", made.name)), lines)?;
    }
    Ok(())
}
