//! Sound files to stereo samples, streamed or whole.

mod downmix;
mod mp4_edits;
mod opus;
mod reader;
mod resample;
mod song;
mod wav;

pub use reader::SongReader;
pub use resample::StereoResampler;
pub use song::{Song, SongOptions};
pub use wav::{WavSample, wav_bytes, write_wav};
