//! Decodes sound files to stereo samples, streamed or whole.

mod aiff_lengths;
mod cut_files;
mod downmix;
mod lengths;
mod mended;
mod mp4_edits;
mod opus;
mod panics;
mod reader;
mod resample;
mod song;
mod source;
mod track;
mod vorbis;
mod wav;
mod wav_lengths;

pub use panics::is_decoding;
pub use reader::{SongReader, SongTags};
pub use resample::StereoResampler;
pub use song::{Song, SongOptions};
pub use wav::{WavSample, wav_bytes, write_wav};

/// Extensions of the files that can be decoded, without dots, for file dialogs. The decoder recognizes the
/// format by the first bytes of a file.
pub const SONG_EXTENSIONS: [&str; 17] = [
    "wav", "wave", "flac", "mp3", "ogg", "oga", "opus", "m4a", "m4b", "mp4", "aac", "aiff", "aif", "aifc",
    "mka", "mkv", "webm",
];
