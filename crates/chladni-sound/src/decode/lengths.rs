//! Files that state no length or a wrong one: streams, interrupted recordings, and files that were cut.

use symphonia::core::io::MediaSource;

use super::mended::{Ending, Lengths, Mended};
use super::{aiff_lengths, cut_files, wav_lengths};

/// `source` itself or, where its lengths are not true, one that can be read as far as it goes; where its sound ends, and how
/// many frames it states, where fewer are left. `start` are its first bytes.
pub(super) fn with_true_lengths(
    mut source: Box<dyn MediaSource>,
    start: &[u8],
) -> (Box<dyn MediaSource>, Ending, Option<u64>) {
    let found = match start {
        [b'R', b'I', b'F', b'F', ..] => wav_lengths::lengths(source.as_mut()),
        [b'F', b'O', b'R', b'M', ..] => aiff_lengths::lengths(source.as_mut()),
        [b'O', b'g', b'g', b'S', ..] => cut_files::ogg(source.as_mut()),
        [0x1a, 0x45, 0xdf, 0xa3, ..] => cut_files::matroska(source.as_mut()),
        [_, _, _, _, b'f', b't', b'y', b'p', ..] => cut_files::mp4(source.as_mut()),
        _ => Ok(Lengths::default()),
    };
    // A file whose lengths cannot be found is read as it is.
    let lengths = found.unwrap_or_default();
    let (ending, frames) = (lengths.ending, lengths.frames);
    if lengths.patches.is_empty() && lengths.end.is_none() && !lengths.is_stream {
        return (source, ending, frames);
    }
    (Box::new(Mended { source, lengths }), ending, frames)
}
