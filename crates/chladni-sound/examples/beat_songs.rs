//! Writes test songs whose beats are known exactly: `beat_songs FOLDER` makes NAME.wav and NAME.beats.txt, and for
//! songs with a form NAME.bars.txt and NAME.sections.txt, too.

#[allow(dead_code, reason = "tests use more of it")]
#[path = "../tests/songs/mod.rs"]
mod songs;

use chladni_sound::{WavSample, write_wav};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("which folder?")?);
    std::fs::create_dir_all(&folder)?;
    let write = |name: &str, times_secs: &[f64]| {
        let lines: String = times_secs.iter().map(|b| format!("{b:.4}\n")).collect();
        std::fs::write(folder.join(format!("{name}.txt")), lines)
    };
    for made in songs::songs() {
        write_wav(&folder.join(format!("{}.wav", made.name)), &made.song, WavSample::Int16)?;
        write(&format!("{}.beats", made.name), &made.beats_secs)?;
    }
    for (i, formed) in songs::formed().into_iter().enumerate() {
        // In their order of creation: every second one was held out.
        let name = format!("form-{i:02}-{}", formed.made.name);
        write_wav(&folder.join(format!("{name}.wav")), &formed.made.song, WavSample::Int16)?;
        write(&format!("{name}.beats"), &formed.made.beats_secs)?;
        write(&format!("{name}.bars"), &formed.downbeats_secs)?;
        write(&format!("{name}.sections"), &formed.sections_secs)?;
    }
    Ok(())
}
