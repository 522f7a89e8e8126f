//! Opens the sound track of a file and its decoder, or says why it cannot.

use std::io::{self, Read, SeekFrom};
use std::sync::LazyLock;

use symphonia::core::audio::Channels;
use symphonia::core::codecs::audio::{
    AudioCodecId, AudioCodecParameters, AudioDecoder, AudioDecoderOptions, well_known,
};
use symphonia::core::codecs::registry::CodecRegistry;
use symphonia::core::errors::Error as CodecError;
use symphonia::core::formats::well_known::FORMAT_ID_MKV;
use symphonia::core::formats::{FormatReader, Track, TrackType};
use symphonia::core::io::MediaSource;
use symphonia::core::units::TimeBase;

use super::downmix::usual;
use super::mp4_edits::Audible;
use super::opus::{self, OpusDecoder};
use super::panics::caught;
use super::vorbis::bytes_of_books;
use crate::SoundError;

/// Every MP3 decoder has this delay in frames (ISO/IEC 11172-3: polyphase filters and overlap). A LAME tag
/// states the encoder's share as well; without one only this much is certain, and what is left before the
/// sound is the encoder's own delay, 576 frames for LAME.
const MP3_DECODER_DELAY: u64 = 529;

/// The most samples, of all channels, that a packet may be stated to hold: decoders of PCM and ADPCM make room for them before
/// they read any. In the widest, of 8 bytes, these take 4 MiB. A block of ADPCM has up to 131,063; packets of WAV and AIFF
/// have 1152 frames, so that 455 channels can be read.
const MOST_SAMPLES: u64 = 1 << 19;

/// The most bytes that the code books of Vorbis may take. Those of the usual encoder take up to 5.6 MiB.
const MOST_BYTES_OF_BOOKS: u64 = 12 << 20;

static CODECS: LazyLock<CodecRegistry> = LazyLock::new(|| {
    let mut codecs = CodecRegistry::new();
    symphonia::default::register_enabled_codecs(&mut codecs);
    codecs.register_audio_decoder::<OpusDecoder>();
    codecs
});

/// The sound track of a file, ready to be decoded.
pub(super) struct OpenedTrack {
    /// The audible part of the decoded frames, as far as the track states it.
    pub audible: Audible,
    pub track_id: u32,
    pub time_base: Option<TimeBase>,
    pub frames: Option<u64>,
    /// Whether those frames may be a guess from the size of the file, of which no packet must be cut off.
    pub is_guess: bool,
    pub decoder: Box<dyn AudioDecoder>,
}

/// Opens the track that `format` plays by default.
pub(super) fn open_track(name: &str, format: &dyn FormatReader) -> Result<OpenedTrack, SoundError> {
    let no_track = || SoundError::Unrecognized {
        name: name.to_owned(),
        reason: format!("a {} file without a sound track", format.format_info().long_name),
    };
    let track: &Track = format.default_track(TrackType::Audio).ok_or_else(no_track)?;
    let params = track.codec_params.as_ref().and_then(|p| p.audio()).ok_or_else(no_track)?;
    // MP4 cannot state rates above 65535 Hz and leaves them at 0; that of the first decoded block is checked, too.
    if let Some(rate_hz) = params.sample_rate.filter(|rate_hz| *rate_hz > 0) {
        crate::check_rate(name, rate_hz)?;
    }
    check_packets(name, params)?;
    check_books(name, params)?;
    let placed = if format.format_info().format == FORMAT_ID_MKV { with_speakers(params) } else { None };
    let params_of_decoder = placed.as_ref().unwrap_or(params);
    let decoder =
        caught(name, || CODECS.make_audio_decoder(params_of_decoder, &AudioDecoderOptions::default()))?
            .map_err(|error| unsupported(name, params.codec, &error))?;
    Ok(OpenedTrack {
        audible: audible_of(track, params),
        track_id: track.id,
        time_base: track.time_base,
        frames: track.num_frames,
        is_guess: params.codec == well_known::CODEC_ID_MP3 && track.delay.unwrap_or(0) == 0,
        decoder,
    })
}

/// Refuses packets so large that there is no room for them.
fn check_packets(name: &str, params: &AudioCodecParameters) -> Result<(), SoundError> {
    let frames = params.max_frames_per_packet.unwrap_or(0);
    let channels = params.channels.as_ref().map_or(0, Channels::count);
    if frames.saturating_mul(channels as u64) <= MOST_SAMPLES {
        return Ok(());
    }
    let what = format!("it states packets of {frames} frames in {channels} channels, too many for a song");
    Err(SoundError::Damaged { name: name.to_owned(), what })
}

/// Refuses code books that take more memory than those of any song.
fn check_books(name: &str, params: &AudioCodecParameters) -> Result<(), SoundError> {
    let headers = params.extra_data.as_deref().filter(|_| params.codec == well_known::CODEC_ID_VORBIS);
    let bytes = headers.map_or(0, bytes_of_books);
    if bytes <= MOST_BYTES_OF_BOOKS {
        return Ok(());
    }
    let what = format!("its code books would take {} MiB, too much for a song", bytes >> 20);
    Err(SoundError::Damaged { name: name.to_owned(), what })
}

/// The parameters with the usual speakers: Matroska states only the number of channels, which PCM has in WAVE order. Other codecs
/// know their own.
fn with_speakers(params: &AudioCodecParameters) -> Option<AudioCodecParameters> {
    if params.codec == well_known::CODEC_ID_OPUS {
        return None;
    }
    let Some(Channels::Discrete(count @ 3..=8)) = params.channels else { return None };
    let mut placed = params.clone();
    placed.with_channels(usual(count.into()));
    Some(placed)
}

fn audible_of(track: &Track, params: &AudioCodecParameters) -> Audible {
    let delay = track.delay.map(u64::from);
    match params.codec {
        well_known::CODEC_ID_MP3 if delay.unwrap_or(0) == 0 => {
            Audible { skip: MP3_DECODER_DELAY, frames: None, in_ticks: false }
        }
        // The demuxers leave an Opus encoder's lead-in to the decoder, and the decoder leaves it to its
        // caller. Only Ogg states it for the track and counts it in the track's frames.
        well_known::CODEC_ID_OPUS => {
            let skip = delay.or_else(|| opus::lead_in_frames(params)).unwrap_or(0);
            let frames = track.num_frames.filter(|_| delay.is_some());
            Audible { skip, frames: frames.map(|frames| frames.saturating_sub(skip)), in_ticks: false }
        }
        _ => Audible { skip: 0, frames: None, in_ticks: false },
    }
}

const CONVERT: &str = "convert it to FLAC, WAV, MP3, M4A (AAC-LC), Ogg Vorbis or Opus";

/// The error for sound of a codec, or of a kind of it, that no decoder takes.
fn unsupported(name: &str, id: AudioCodecId, error: &CodecError) -> SoundError {
    let (codec, advice) = match (codec_name(id), error) {
        (Some(codec), _) => (codec, CONVERT),
        // The decoder of AAC says only that it is too complex.
        (None, CodecError::Unsupported(_)) if id == well_known::CODEC_ID_AAC => {
            let advice = "convert it to stereo AAC-LC, FLAC or WAV";
            ("multichannel or non-LC AAC".to_owned(), advice)
        }
        (None, error) => (error.to_string(), CONVERT),
    };
    SoundError::UnsupportedCodec { name: name.to_owned(), codec, advice }
}

fn codec_name(id: AudioCodecId) -> Option<String> {
    use well_known as known;
    let names = [
        (known::CODEC_ID_SPEEX, "Speex"),
        (known::CODEC_ID_MP1, "MPEG layer I"),
        (known::CODEC_ID_MP2, "MPEG layer II"),
        (known::CODEC_ID_AC3, "AC-3"),
        (known::CODEC_ID_EAC3, "E-AC-3"),
        (known::CODEC_ID_DCA, "DTS"),
        (known::CODEC_ID_WMA, "Windows Media"),
        (known::CODEC_ID_WAVPACK, "WavPack"),
    ];
    names.iter().find(|(known, _)| *known == id).map(|(_, name)| (*name).to_owned())
}

/// Reads the first bytes of a source that cannot be decoded, to find out what kind of file it is.
pub(super) fn look_at_start(name: &str, source: &mut dyn MediaSource) -> Result<Vec<u8>, SoundError> {
    let mut start = Vec::new();
    (&mut *source)
        .take(4096)
        .read_to_end(&mut start)
        .map_err(|error| SoundError::Read { name: name.to_owned(), source: error })?;
    if start.is_empty() {
        return Err(SoundError::Empty { name: name.to_owned() });
    }
    rewind(name, source)?;
    Ok(start)
}

/// Seeks to the first byte.
pub(super) fn rewind(name: &str, source: &mut dyn MediaSource) -> Result<(), SoundError> {
    source
        .seek(SeekFrom::Start(0))
        .map(|_| ())
        .map_err(|error| SoundError::Read { name: name.to_owned(), source: error })
}

/// The error for a file that begins with `start` and cannot be opened.
pub(super) fn unrecognized(name: &str, start: &[u8], error: &CodecError) -> SoundError {
    let holds = |mark: &[u8]| start.windows(mark.len()).any(|window| window == mark);
    for (mark, codec) in [(&b"Speex   "[..], "Speex"), (b"wvpk", "WavPack")] {
        if holds(mark) {
            let codec = codec.to_owned();
            return SoundError::UnsupportedCodec { name: name.to_owned(), codec, advice: CONVERT };
        }
    }
    let reason = match error {
        CodecError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            "it ends before any sound".to_owned()
        }
        other => other.to_string(),
    };
    SoundError::Unrecognized { name: name.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_hold_no_more_than_there_is_room_for() {
        let is_read = |frames: u64, channels: u16| {
            let mut params = AudioCodecParameters::new();
            params.with_max_frames_per_packet(frames).with_channels(Channels::Discrete(channels));
            check_packets("a song", &params).is_ok()
        };
        // AIFF, the longest block of ADPCM, and QuickTime.
        for (frames, channels) in [(1152, 455), (131_063, 1), (1, 32)] {
            assert!(is_read(frames, channels), "{frames} frames, {channels} channels");
        }
        for (frames, channels) in [(1152, 456), (1152, u16::MAX), (u64::from(u32::MAX), 1), (u64::MAX, 2)] {
            assert!(!is_read(frames, channels), "{frames} frames, {channels} channels");
        }
    }
}
