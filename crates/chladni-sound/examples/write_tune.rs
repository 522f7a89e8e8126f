//! Writes the sample tune as a WAV file: `write_tune FILE`.

use chladni_sound::{WavSample, sample_tune, write_wav};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    Ok(write_wav(Path::new(&path), &sample_tune(), WavSample::Int16)?)
}
