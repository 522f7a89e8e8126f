//! Streaming decoder: blocks of stereo samples at the file's own rate.

use std::io::{self, Cursor};
use std::path::Path;

use chladni_task::open_file;
use symphonia::core::codecs::audio::{AudioDecoder, well_known};
use symphonia::core::errors::Error as CodecError;
use symphonia::core::formats::probe::Hint;
use symphonia::core::formats::well_known::{
    FORMAT_ID_ADTS, FORMAT_ID_AIFF, FORMAT_ID_FLAC, FORMAT_ID_ISOMP4, FORMAT_ID_MKV, FORMAT_ID_MP3,
    FORMAT_ID_OGG, FORMAT_ID_WAVE,
};
use symphonia::core::formats::{FormatOptions, FormatReader, SeekMode, SeekTo};
use symphonia::core::io::{MediaSource, MediaSourceStream};
use symphonia::core::meta::{MetadataOptions, StandardTag, StandardVisualKey};
use symphonia::core::units::{Duration, TimeBase, Timestamp};

use super::downmix::Downmix;
use super::lengths::with_true_lengths;
use super::mended::Ending;
use super::mp4_edits::{self, Audible};
use super::panics::caught;
use super::source::SharedSource;
use super::track::{OpenedTrack, look_at_start, open_track, rewind, unrecognized};
use crate::SoundError;

/// The longest part of a tag that is used, in characters.
const LONGEST_TAG: usize = 200;
/// How many packets in a row may fail before the file is given up.
const MAX_FAILURES_IN_A_ROW: u32 = 256;
/// Decoders carry state (overlap, bit reservoir) from packet to packet. A seek therefore decodes this much
/// before its target and drops it.
const PREROLL_SECS: f64 = 0.15;
/// A difference up to this between the length in the header and the actual one is ignored.
const MISSED_SECS: f64 = 0.1;

/// What the tags of a song say; `None` where they do not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SongTags {
    /// The song's own title.
    pub title: Option<String>,
    /// Who plays it.
    pub artist: Option<String>,
}

/// Decodes a sound file block by block: WAV, AIFF, FLAC, MP3, Ogg Vorbis, Opus, M4A (AAC-LC, ALAC) and
/// Matroska with any of these codecs. Mono is played on both sides; more than two channels are mixed down
/// (ITU-R BS.775), but AAC is decoded with one or two only. Encoder padding is removed if the file states its length (in
/// Matroska, only that before the sound). Seeking is exact to the frame (in Matroska, whose clock is coarse, to 1 ms).
///
/// Ogg files may be a chain of several ones, as recordings of radio stations are; all links are read. The length of those
/// that were not reached yet is not known.
///
/// Memory does not depend on the length of the song, only on its tags and tables: it is bounded by 64 bytes for each byte
/// of the file, and 16 MiB (48 MiB of Vorbis, for two links of a chain).
pub struct SongReader {
    name: String,
    source: SharedSource,
    format: Box<dyn FormatReader>,
    decoder: Box<dyn AudioDecoder>,
    track_id: u32,
    time_base: Option<TimeBase>,
    rate_hz: u32,
    channels: usize,
    declared_frames: Option<u64>,
    /// Whether that may be a guess.
    is_guess: bool,
    ending: Ending,
    audible: Audible,
    /// Frames of the song before this link of a chain; 0 in any other file.
    link_begin: u64,
    /// Frames of the link before the next block.
    position: u64,
    /// Decoded frames still to be dropped.
    skip: u64,
    /// After a seek: the frame of the container that was requested, until a packet shows which one was
    /// reached.
    sought: Option<u64>,
    /// The first tick of what is decoded for it; earlier packets are passed over.
    decoded_from: i64,
    /// What was sought lies beyond the end.
    is_beyond: bool,
    /// When the first sound begins, in ticks; 0 but in Matroska, which counts from the codec's delay.
    first_ticks: i64,
    interleaved: Vec<f32>,
    stereo: Vec<f32>,
    /// Whether `stereo` holds a block that has not been returned yet.
    pending: bool,
    failures_in_a_row: u32,
    damaged_packets: u64,
    cut_short: bool,
    /// At the end: how many frames fewer than stated in the header were found.
    missing_frames: u64,
    /// Those that were missing in links before this one.
    missing_before: u64,
}

impl SongReader {
    /// Opens a file.
    ///
    /// # Errors
    /// The file cannot be read, its format is unknown, its codec is not supported, or it holds no sound.
    pub fn open(path: &Path) -> Result<Self, SoundError> {
        let name = path.display().to_string();
        let unreadable = |source| SoundError::Read { name: name.clone(), source };
        let file = open_file(path).map_err(unreadable)?;
        Self::from_source(&name, Box::new(file))
    }

    /// Reads a file that is in memory; `name` is used in messages.
    ///
    /// # Errors
    /// The format is unknown, the codec is not supported, or there is no sound.
    pub fn from_bytes(name: &str, bytes: Vec<u8>) -> Result<Self, SoundError> {
        Self::from_source(name, Box::new(Cursor::new(bytes)))
    }

    fn from_source(name: &str, mut source: Box<dyn MediaSource>) -> Result<Self, SoundError> {
        let start = look_at_start(name, source.as_mut())?;
        let mp4 = start.get(4..8) == Some(b"ftyp");
        let audible = if mp4 { mp4_edits::audible_part(source.as_mut()) } else { None };
        let (mut source, ending, frames) = with_true_lengths(source, &start);
        rewind(name, source.as_mut())?;
        let source = SharedSource::new(source);
        let format = probe(name, &source)?;
        let opened = open_track(name, format.as_ref())?;
        let audible = audible.unwrap_or(opened.audible);
        let mut reader = Self {
            name: name.to_owned(),
            source,
            format,
            decoder: opened.decoder,
            track_id: opened.track_id,
            time_base: opened.time_base,
            rate_hz: 0,
            channels: 0,
            declared_frames: frames.or(opened.frames),
            is_guess: opened.is_guess,
            ending,
            audible,
            link_begin: 0,
            position: 0,
            skip: audible.skip,
            sought: None,
            decoded_from: i64::MIN,
            is_beyond: false,
            first_ticks: 0,
            interleaved: Vec::new(),
            stereo: Vec::new(),
            pending: false,
            failures_in_a_row: 0,
            damaged_packets: 0,
            cut_short: false,
            missing_frames: 0,
            missing_before: 0,
        };
        // The header may state a wrong rate or number of channels; the first decoded block is right.
        reader.pending = reader.decode_block()?;
        if !reader.pending {
            return Err(SoundError::Empty { name: name.to_owned() });
        }
        Ok(reader)
    }

    /// The name of the file, as the caller gave it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Frames per second.
    pub fn rate_hz(&self) -> u32 {
        self.rate_hz
    }

    /// The number of channels in the file, before they are mixed down.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The short names of the container and the codec, for example "wave/pcm_s16le".
    pub fn kind(&self) -> String {
        let container = self.format.format_info().short_name;
        format!("{container}/{}", self.decoder.codec_info().short_name)
    }

    /// Artist and title, or the title alone, from the tags of the file; `None` if it has no title.
    pub fn title(&mut self) -> Option<String> {
        let tags = self.tags();
        let title = tags.title?;
        Some(tags.artist.map_or_else(|| title.clone(), |artist| format!("{artist} – {title}")))
    }

    /// What the tags of the file say.
    pub fn tags(&mut self) -> SongTags {
        let mut metadata = self.format.metadata();
        let Some(latest) = metadata.skip_to_latest() else { return SongTags::default() };
        let tags = &latest.media.tags;
        let find = |of: fn(&StandardTag) -> Option<&str>| {
            let found = tags.iter().find_map(|tag| tag.std.as_ref().and_then(of))?;
            let shown: String = found.trim().chars().filter(|c| !c.is_control()).take(LONGEST_TAG).collect();
            Some(shown).filter(|shown| !shown.is_empty())
        };
        let title = find(|tag| match tag {
            StandardTag::TrackTitle(title) => Some(title.as_str()),
            _ => None,
        });
        let artist = find(|tag| match tag {
            StandardTag::Artist(artist) => Some(artist.as_str()),
            _ => None,
        });
        SongTags { title, artist }
    }

    /// The file of the picture in the tags, usually a JPEG or PNG: the front cover, or else the first one.
    /// Its bytes are those of the song's file and have not been checked.
    pub fn cover(&mut self) -> Option<Vec<u8>> {
        let mut metadata = self.format.metadata();
        let pictures = &metadata.skip_to_latest()?.media.visuals;
        let front = pictures.iter().find(|picture| picture.usage == Some(StandardVisualKey::FrontCover));
        front.or(pictures.first()).map(|picture| picture.data.to_vec())
    }

    /// Length in frames as stated in the header, which may be wrong; of a chain, up to the end of this link.
    pub fn total_frames(&self) -> Option<u64> {
        self.link_frames().map(|frames| self.link_begin + frames)
    }

    fn link_frames(&self) -> Option<u64> {
        self.audible.frames.or(self.declared_frames)
    }

    /// The length, where no sound lies behind it. Other containers may state an estimate, or the length of a part.
    fn exact_frames(&self) -> Option<u64> {
        let exact = [FORMAT_ID_AIFF, FORMAT_ID_FLAC, FORMAT_ID_MP3, FORMAT_ID_WAVE];
        let is_exact = !self.is_guess && exact.contains(&self.format.format_info().format);
        // What was written as a stream may state 0.
        self.link_frames().filter(|frames| is_exact && *frames > 0)
    }

    /// A description of the parts missing from the sound so far; `None` if nothing is.
    pub fn damage(&self) -> Option<String> {
        let packets = match self.damaged_packets {
            0 => None,
            1 => Some("1 damaged packet is left out".to_owned()),
            count => Some(format!("{count} damaged packets are left out")),
        };
        let end = self.cut_short.then(|| "the file ends in the middle".to_owned());
        let missing_secs = self.missing_frames as f64 / f64::from(self.rate_hz.max(1));
        let missing = (missing_secs > MISSED_SECS).then(|| format!("{missing_secs:.1} s are missing"));
        let said: Vec<String> = packets.into_iter().chain(end).chain(missing).collect();
        (!said.is_empty()).then(|| said.join(", "))
    }

    /// The next block of interleaved stereo samples, with full scale ±1 (which lossy codecs sometimes
    /// exceed); `None` at the end. Damaged packets are skipped and counted.
    ///
    /// # Errors
    /// The file cannot be read any further, its rate changes, or too many packets in a row are damaged.
    pub fn next_block(&mut self) -> Result<Option<&[f32]>, SoundError> {
        if !self.pending && !self.decode_block()? {
            return Ok(None);
        }
        self.pending = false;
        self.position += (self.stereo.len() / 2) as u64;
        Ok(Some(&self.stereo))
    }

    /// Seeks to exactly this frame of the song. Beyond the end, the next block is `None`. In Matroska everything before the
    /// frame is read, too.
    ///
    /// # Errors
    /// The file cannot be read again from its start.
    pub fn seek(&mut self, frame: u64) -> Result<(), SoundError> {
        self.pending = false;
        if frame < self.link_begin {
            self.reopen()?;
        }
        let position = frame - self.link_begin;
        self.is_beyond = self.exact_frames().is_some_and(|frames| position >= frames);
        if self.is_beyond {
            self.position = position;
            return Ok(());
        }
        let target = position.saturating_add(self.audible.skip);
        let preroll = (PREROLL_SECS * f64::from(self.rate_hz)) as u64;
        let begin = if self.is_adpcm() { 0 } else { target.saturating_sub(preroll) };
        // Some containers cannot seek to their end, or not at all. Then decoding continues from the start.
        let reached = self.seek_container(begin) || self.seek_container(0);
        if !reached {
            let what = "cannot be rewound".to_owned();
            return Err(SoundError::Damaged { name: self.name.clone(), what });
        }
        self.decoder.reset();
        self.skip = 0;
        self.sought = Some(target);
        self.position = position;
        Ok(())
    }

    /// Goes back to the first link of a chain: container readers seek only within one.
    fn reopen(&mut self) -> Result<(), SoundError> {
        self.restart()?;
        (self.link_begin, self.missing_before) = (0, 0);
        self.enter_link()
    }

    /// Reads the container from its first byte again.
    fn restart(&mut self) -> Result<(), SoundError> {
        rewind(&self.name, &mut self.source)?;
        self.format = probe(&self.name, &self.source)?;
        Ok(())
    }

    /// Opens the track of the link that begins here, which may be another one.
    fn enter_link(&mut self) -> Result<(), SoundError> {
        let OpenedTrack { audible, track_id, time_base, frames, is_guess, decoder } =
            open_track(&self.name, self.format.as_ref())?;
        (self.audible, self.track_id, self.time_base) = (audible, track_id, time_base);
        (self.declared_frames, self.is_guess, self.decoder) = (frames, is_guess, decoder);
        Ok(())
    }

    /// Goes on with the next link of a chain; where its end was sought, with what lies beyond that.
    fn next_link(&mut self) -> Result<(), SoundError> {
        let seeks = self.skip > 0 || self.sought.take().is_some();
        let declared = self.declared_frames.filter(|_| seeks);
        let frames = self.audible.frames.or(declared).unwrap_or(self.position);
        self.missing_before += self.link_frames().unwrap_or(0).saturating_sub(self.position);
        self.link_begin += frames;
        self.position = self.position.saturating_sub(frames);
        self.enter_link()?;
        self.skip = self.audible.skip.saturating_add(self.position);
        Ok(())
    }

    /// Whether the sound is ADPCM of a WAV, whose reader seeks as if a block of many frames held one.
    fn is_adpcm(&self) -> bool {
        let codec = self.decoder.codec_params().codec;
        [well_known::CODEC_ID_ADPCM_MS, well_known::CODEC_ID_ADPCM_IMA_WAV].contains(&codec)
    }

    fn seek_container(&mut self, frame: u64) -> bool {
        if self.format.format_info().format == FORMAT_ID_MKV {
            return self.seek_matroska(frame).is_ok();
        }
        self.ticks_of(frame).is_some_and(|ticks| {
            let ticks = ticks.saturating_add(self.first_ticks).max(0);
            let to = SeekTo::Timestamp { ts: Timestamp::new(ticks), track_id: self.track_id };
            caught(&self.name, || self.format.seek(SeekMode::Accurate, to)).is_ok_and(|sought| sought.is_ok())
        })
    }

    /// Passes over the packets before this frame: the reader of Matroska takes the wrong time for a cluster that it
    /// looks up. Packets need not state a length, so decoding begins a second earlier.
    fn seek_matroska(&mut self, frame: u64) -> Result<(), SoundError> {
        self.restart()?;
        let begin = frame.saturating_sub(u64::from(self.rate_hz));
        let ticks = self.ticks_of(begin).unwrap_or(i64::MAX).saturating_add(self.first_ticks);
        self.decoded_from = if begin == 0 { i64::MIN } else { ticks };
        Ok(())
    }

    /// Ticks of the container's clock per frame of sound, as (numerator, denominator).
    fn ticks_per_frame(&self) -> (u128, u128) {
        self.time_base.map_or((1, 1), |base| {
            (u128::from(base.denom.get()), u128::from(base.numer.get()) * u128::from(self.rate_hz))
        })
    }

    fn ticks_of(&self, frame: u64) -> Option<i64> {
        let (ticks, frames) = self.ticks_per_frame();
        i64::try_from(u128::from(frame) * ticks / frames.max(1)).ok()
    }

    fn frame_of(&self, ticks: u64) -> u64 {
        let (per, frames) = self.ticks_per_frame();
        let ticks = u128::from(ticks);
        u64::try_from((ticks * frames + per / 2) / per.max(1)).unwrap_or(u64::MAX)
    }

    /// Takes the rate and the number of channels of the first sound. From now on ticks can be counted in frames.
    fn begin(&mut self, rate_hz: u32, channels: usize) {
        (self.rate_hz, self.channels) = (rate_hz, channels);
        match self.format.format_info().format {
            FORMAT_ID_ISOMP4 => {
                self.declared_frames = self.declared_frames.map(|ticks| self.frame_of(ticks));
            }
            FORMAT_ID_MKV => self.declared_frames = self.frames_of_file(),
            _ => {}
        }
        let Audible { skip, frames, in_ticks } = self.audible;
        if in_ticks {
            let frames = frames.map(|ticks| self.frame_of(ticks));
            self.audible = Audible { skip: self.frame_of(skip), frames, in_ticks: false };
            self.skip = self.audible.skip;
        }
    }

    /// The length of the file, as Matroska states it: not that of a track.
    fn frames_of_file(&self) -> Option<u64> {
        let info = self.format.media_info();
        let (base, duration) = info.time_base.zip(info.duration)?;
        let ticks = u128::from(duration.get()) * u128::from(base.numer.get());
        u64::try_from(ticks * u128::from(self.rate_hz) / u128::from(base.denom.get())).ok()
    }

    /// How many frames of the link are still to be heard, as far as it states that.
    fn left(&self) -> u64 {
        self.audible.frames.unwrap_or(u64::MAX).saturating_sub(self.position)
    }

    /// Fills `stereo` with at least one frame. Returns false at the end.
    fn decode_block(&mut self) -> Result<bool, SoundError> {
        self.stereo.clear();
        while self.stereo.is_empty() {
            // Another link may follow.
            let is_over = self.left() == 0 && self.format.format_info().format != FORMAT_ID_OGG;
            if self.is_beyond || is_over || !self.decode_packet()? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Decodes one packet into `stereo`, as far as it is to be heard. Returns false at the end.
    fn decode_packet(&mut self) -> Result<bool, SoundError> {
        let mut packet = match caught(&self.name, || self.format.next_packet())? {
            Ok(Some(packet)) => packet,
            Ok(None) => {
                self.cut_short |= self.ending == Ending::Cut;
                self.count_missing();
                return Ok(false);
            }
            Err(CodecError::IoError(error)) if error.kind() == io::ErrorKind::UnexpectedEof => {
                // Without a stated length, a WAV file ends where its sound does.
                let states_length = self.link_frames().is_some();
                self.cut_short = match self.ending {
                    Ending::Stated => states_length || self.format.format_info().format != FORMAT_ID_WAVE,
                    ending => ending == Ending::Cut,
                };
                self.count_missing();
                return Ok(false);
            }
            Err(CodecError::IoError(source)) => {
                return Err(SoundError::Read { name: self.name.clone(), source });
            }
            Err(CodecError::ResetRequired) => {
                self.next_link()?;
                return Ok(true);
            }
            Err(error) => return self.failure(&error),
        };
        let is_before = self.sought.is_some() && packet.pts.get() < self.decoded_from;
        if packet.track_id != self.track_id || is_before {
            return Ok(true);
        }
        if self.is_guess {
            packet.trim_end = Duration::ZERO;
        }
        let (rate_hz, channels) = match caught(&self.name, || self.decoder.decode(&packet))? {
            Ok(decoded) => {
                let spec = decoded.spec();
                let shape = (spec.rate(), spec.channels().clone());
                decoded.copy_to_vec_interleaved(&mut self.interleaved);
                shape
            }
            Err(CodecError::IoError(error)) if error.kind() != io::ErrorKind::UnexpectedEof => {
                return Err(SoundError::Read { name: self.name.clone(), source: error });
            }
            Err(error) => return self.failure(&error),
        };
        self.failures_in_a_row = 0;
        if self.interleaved.is_empty() {
            return Ok(true);
        }
        let mix = Downmix::new(&channels).ok_or_else(|| SoundError::Damaged {
            name: self.name.clone(),
            what: "it has no channels".into(),
        })?;
        crate::check_rate(&self.name, rate_hz)?;
        if self.rate_hz == 0 {
            if self.format.format_info().format == FORMAT_ID_MKV {
                self.first_ticks = packet.pts.get();
            }
            self.begin(rate_hz, channels.count());
        } else if self.rate_hz != rate_hz {
            return Err(SoundError::Damaged {
                name: self.name.clone(),
                what: format!("the rate changes from {} to {rate_hz} Hz on the way", self.rate_hz),
            });
        }
        let frames = self.interleaved.len() / channels.count();
        if let Some(target) = self.sought.take() {
            // The decoder has already trimmed the samples that the packet names.
            let start = packet.pts.get().saturating_add_unsigned(packet.trim_start.get());
            let start = start.saturating_sub(self.first_ticks).max(0);
            let landed = self.frame_of(start.unsigned_abs());
            self.skip = target.saturating_sub(landed);
            self.position += landed.saturating_sub(target);
        }
        let dropped = self.skip.min(frames as u64);
        self.skip -= dropped;
        let first = dropped as usize;
        let last = frames.min(first.saturating_add(usize::try_from(self.left()).unwrap_or(usize::MAX)));
        mix.append(&self.interleaved, first..last, &mut self.stereo);
        Ok(true)
    }

    /// Counts missing frames. Some container readers skip damage silently, which the length in the header
    /// reveals. That of an MP3 or of ADTS may be an estimate, and Matroska's is that of its pictures, too.
    fn count_missing(&mut self) {
        let format = self.format.format_info().format;
        let known = self.decoder.codec_params().codec != well_known::CODEC_ID_MP3
            && ![FORMAT_ID_ADTS, FORMAT_ID_MKV].contains(&format);
        let stated = self.link_frames().filter(|_| known).unwrap_or(0);
        self.missing_frames = self.missing_before + stated.saturating_sub(self.position);
    }

    fn failure(&mut self, error: &CodecError) -> Result<bool, SoundError> {
        self.damaged_packets += 1;
        self.failures_in_a_row += 1;
        let fatal = !matches!(error, CodecError::DecodeError(_) | CodecError::IoError(_));
        if fatal || self.failures_in_a_row >= MAX_FAILURES_IN_A_ROW {
            return Err(SoundError::Damaged { name: self.name.clone(), what: error.to_string() });
        }
        Ok(true)
    }
}

fn probe(name: &str, source: &SharedSource) -> Result<Box<dyn FormatReader>, SoundError> {
    let mut source = source.clone();
    let start = look_at_start(name, &mut source)?;
    if start.starts_with(b"RF64") {
        // The probe does not know it, and might take some of its samples for another kind of file.
        let reason = "an RF64 file, a WAV of more than 4 GiB: convert it to FLAC".to_owned();
        return Err(SoundError::Unrecognized { name: name.to_owned(), reason });
    }
    let stream = MediaSourceStream::new(Box::new(source), Default::default());
    // No hint is given: the first bytes of a file are more reliable than its name.
    let (formats, tags) = (FormatOptions::default(), MetadataOptions::default());
    caught(name, || symphonia::default::get_probe().probe(&Hint::new(), stream, formats, tags))?
        .map_err(|error| unrecognized(name, &start, &error))
}

#[cfg(test)]
mod tests {
    use std::io::{Read, Seek, SeekFrom};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::{Song, WavSample, wav_bytes};

    /// A file, and how many bytes of it were read.
    struct Counted(Cursor<Vec<u8>>, Arc<AtomicUsize>);

    impl Read for Counted {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = self.0.read(buffer)?;
            self.1.fetch_add(count, Ordering::Relaxed);
            Ok(count)
        }
    }

    impl Seek for Counted {
        fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
            self.0.seek(to)
        }
    }

    impl MediaSource for Counted {
        fn is_seekable(&self) -> bool {
            true
        }

        fn byte_len(&self) -> Option<u64> {
            Some(self.0.get_ref().len() as u64)
        }
    }

    #[test]
    fn what_lies_beyond_the_end_is_not_looked_for() {
        let left = vec![0.25; 160_000];
        let song = Song { rate_hz: 8_000, right: left.clone(), left };
        let bytes = Cursor::new(wav_bytes(&song, WavSample::Int16).unwrap());
        let read = Arc::new(AtomicUsize::new(0));
        let source = Box::new(Counted(bytes, Arc::clone(&read)));
        let mut reader = SongReader::from_source("song.wav", source).unwrap();
        let opened = read.load(Ordering::Relaxed);
        for frame in [160_000, u64::MAX] {
            reader.seek(frame).unwrap();
            assert!(reader.next_block().unwrap().is_none());
        }
        assert_eq!(read.load(Ordering::Relaxed), opened);
        reader.seek(159_999).unwrap();
        assert_eq!(reader.next_block().unwrap().map(<[f32]>::len), Some(2));
    }
}
