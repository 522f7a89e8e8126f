//! An Opus decoder (RFC 6716) for Symphonia, which reads the containers of Opus but cannot decode it.

mod framing;

use symphonia::core::audio::{
    AsGenericAudioBufferRef, Audio, AudioBuffer, AudioMut, AudioSpec, Channels, GenericAudioBufferRef,
};
use symphonia::core::codecs::CodecInfo;
use symphonia::core::codecs::audio::well_known::CODEC_ID_OPUS;
use symphonia::core::codecs::audio::{
    AudioCodecParameters, AudioDecoder, AudioDecoderOptions, FinalizeResult,
};
use symphonia::core::codecs::registry::{RegisterableAudioDecoder, SupportedAudioCodec};
use symphonia::core::errors::{Result, decode_error, unsupported_error};
use symphonia::core::packet::PacketRef;

use super::downmix::usual;

/// The decoder's rate; the rate of the original recording does not matter (RFC 7845 §5.1).
const RATE_HZ: u32 = 48_000;
/// The longest packet is 120 ms (RFC 6716 §3.2.5).
const MOST_FRAMES: usize = 5760;
/// For each number of channels: the place in the stream (Vorbis order, RFC 7845 §5.1.1.2) of each channel
/// in WAVE order.
const WAVE_ORDER: [&[usize]; 8] = [
    &[0],
    &[0, 1],
    &[0, 2, 1],
    &[0, 1, 2, 3],
    &[0, 2, 1, 3, 4],
    &[0, 2, 1, 5, 3, 4],
    &[0, 2, 1, 6, 5, 3, 4],
    &[0, 2, 1, 7, 5, 6, 3, 4],
];

const INFO: CodecInfo = CodecInfo { short_name: "opus", long_name: "Opus", profiles: &[] };

/// How many frames the encoder put before the sound, from the identification header of a track.
pub(super) fn lead_in_frames(params: &AudioCodecParameters) -> Option<u64> {
    let bytes = params.extra_data.as_deref()?.get(10..12)?;
    Some(u64::from(u16::from_le_bytes([bytes[0], bytes[1]])))
}

/// One Opus track of up to eight channels.
pub(super) struct OpusDecoder {
    params: AudioCodecParameters,
    head: Head,
    /// The stereo streams come first.
    streams: Vec<Stream>,
    /// The packet of one stream.
    packet: Vec<u8>,
    planes: AudioBuffer<f32>,
}

/// One of the mono or stereo streams that form a track.
struct Stream {
    decoder: rusty_opus::OpusDecoder,
    channels: usize,
    interleaved: Vec<f32>,
}

/// The fields of the identification header that decoding needs (RFC 7845 §5.1).
#[derive(Clone)]
struct Head {
    gain: f32,
    streams: usize,
    stereo_streams: usize,
    /// For each channel of the track, its index among the channels of all streams; 255 for silence.
    mapping: Vec<u8>,
}

impl Head {
    fn parse(bytes: &[u8]) -> Result<Self> {
        if bytes.len() < 19 || &bytes[..8] != b"OpusHead" {
            return decode_error("opus: the identification header is missing");
        }
        let channels = usize::from(bytes[9]);
        let gain_db = f32::from(i16::from_le_bytes([bytes[16], bytes[17]])) / 256.0;
        let gain = 10f32.powf(gain_db / 20.0);
        if !(1..=WAVE_ORDER.len()).contains(&channels) {
            return unsupported_error("opus: only one to eight channels are decoded");
        }
        match (bytes[18], bytes.get(19..21 + channels)) {
            (0, _) if channels <= 2 => {
                Ok(Self { gain, streams: 1, stereo_streams: channels - 1, mapping: vec![0, 1] })
            }
            (1 | 255, Some(table)) => {
                let (streams, stereo_streams) = (usize::from(table[0]), usize::from(table[1]));
                if streams == 0 || stereo_streams > streams {
                    return decode_error("opus: no such streams");
                }
                // Each takes a quarter of a megabyte. Encoders make no more of them than there are channels.
                if streams > WAVE_ORDER.len() {
                    return unsupported_error("opus: more than eight streams");
                }
                Ok(Self { gain, streams, stereo_streams, mapping: table[2..].to_vec() })
            }
            (1 | 255, None) => decode_error("opus: the identification header is cut off"),
            _ => unsupported_error("opus: channels that are no speakers"),
        }
    }

    fn open_streams(&self) -> Result<Vec<Stream>> {
        let open = |i| {
            let channels = if i < self.stereo_streams { 2 } else { 1 };
            let decoder = rusty_opus::OpusDecoder::new(RATE_HZ as i32, channels)
                .or_else(|_| unsupported_error("opus: no decoder for this rate"))?;
            Ok(Stream { decoder, channels, interleaved: vec![0.0; MOST_FRAMES * channels] })
        };
        (0..self.streams).map(open).collect()
    }

    /// The stream, and the channel in it, of a channel of the track; `None` for silence.
    fn source(&self, channel: usize) -> Option<(usize, usize)> {
        let at = usize::from(self.mapping[channel]);
        let stereo = 2 * self.stereo_streams;
        let (stream, part) = if at < stereo { (at / 2, at % 2) } else { (at - self.stereo_streams, 0) };
        (stream < self.streams).then_some((stream, part))
    }
}

impl OpusDecoder {
    fn try_new(params: &AudioCodecParameters) -> Result<Self> {
        let extra_data = params.extra_data.as_deref().unwrap_or_default();
        let head = Head::parse(extra_data)?;
        let count = usize::from(extra_data[9]);
        // Matroska states only their number, and what it states may be wrong.
        let channels = if extra_data[18] == 1 { usual(count) } else { Channels::Discrete(count as u16) };
        let spec = AudioSpec::new(RATE_HZ, channels);
        let mut params = params.clone();
        params.with_sample_rate(RATE_HZ).with_channels(spec.channels().clone());
        Ok(Self {
            params,
            streams: head.open_streams()?,
            head,
            packet: Vec::new(),
            planes: AudioBuffer::new(spec, MOST_FRAMES),
        })
    }

    /// Decodes the packet of every stream. Returns the number of frames.
    fn decode_streams(&mut self, mut data: &[u8]) -> Option<usize> {
        let mut shortest = MOST_FRAMES;
        let last = self.streams.len().checked_sub(1)?;
        for (i, stream) in self.streams.iter_mut().enumerate() {
            let packet = if i == last {
                data
            } else {
                data = framing::split_off(data, &mut self.packet)?;
                &self.packet
            };
            // The decoder would take an empty packet for a lost one and conceal it with invented sound.
            if packet.is_empty() {
                return None;
            }
            let frames = stream.decoder.decode(packet, MOST_FRAMES, &mut stream.interleaved).ok()?;
            shortest = shortest.min(frames);
        }
        Some(shortest)
    }

    fn decode_into_planes(&mut self, packet: &[u8]) -> Result<()> {
        let Some(frames) = self.decode_streams(packet) else {
            return decode_error("opus: a damaged packet");
        };
        let positions = self.planes.spec().channels().count();
        self.planes.resize_uninit(frames);
        for (to, &channel) in WAVE_ORDER[positions - 1].iter().enumerate() {
            let Some(plane) = self.planes.plane_mut(to) else { continue };
            let Some((stream, part)) = self.head.source(channel) else {
                plane.fill(0.0);
                continue;
            };
            let Stream { channels, interleaved, .. } = &self.streams[stream];
            for (value, frame) in plane.iter_mut().zip(interleaved.chunks_exact(*channels)) {
                *value = self.head.gain * frame[part];
            }
        }
        Ok(())
    }
}

impl AudioDecoder for OpusDecoder {
    fn reset(&mut self) {
        // The streams for this header have been opened before; opening them again cannot fail.
        if let Ok(streams) = self.head.open_streams() {
            self.streams = streams;
        }
        self.planes.clear();
    }

    fn codec_info(&self) -> &CodecInfo {
        &INFO
    }

    fn codec_params(&self) -> &AudioCodecParameters {
        &self.params
    }

    fn decode_ref(&mut self, packet: &PacketRef<'_>) -> Result<GenericAudioBufferRef<'_>> {
        self.planes.clear();
        self.decode_into_planes(packet.data)?;
        Ok(self.planes.as_generic_audio_buffer_ref())
    }

    fn finalize(&mut self) -> FinalizeResult {
        FinalizeResult::default()
    }

    fn last_decoded(&self) -> GenericAudioBufferRef<'_> {
        self.planes.as_generic_audio_buffer_ref()
    }
}

impl RegisterableAudioDecoder for OpusDecoder {
    fn try_registry_new(
        params: &AudioCodecParameters,
        _: &AudioDecoderOptions,
    ) -> Result<Box<dyn AudioDecoder>> {
        Ok(Box::new(Self::try_new(params)?))
    }

    fn supported_codecs() -> &'static [SupportedAudioCodec] {
        const { &[SupportedAudioCodec { id: CODEC_ID_OPUS, info: INFO }] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};
    use symphonia::core::audio::layouts;

    fn decoder(channels: u8) -> OpusDecoder {
        let head = [b"OpusHead\x01", &[channels][..], &[0; 6], &[0; 2], &[0]].concat();
        let mut params = AudioCodecParameters::new();
        params.for_codec(CODEC_ID_OPUS).with_extra_data(head.into());
        OpusDecoder::try_new(&params).unwrap()
    }

    #[test]
    fn channels_that_a_container_only_counts_have_speakers() {
        let mapping = [4_u8, 2, 0, 4, 1, 2, 3, 5];
        let head = [b"OpusHead\x01", &[6_u8][..], &[0; 8], &[1], &mapping].concat();
        let mut params = AudioCodecParameters::new();
        params.for_codec(CODEC_ID_OPUS).with_extra_data(head.into()).with_channels(Channels::Discrete(6));
        let decoder = OpusDecoder::try_new(&params).unwrap();
        assert_eq!(decoder.codec_params().channels, Some(layouts::CHANNEL_LAYOUT_5P1));
        for (i, order) in WAVE_ORDER.iter().enumerate() {
            assert_eq!(usual(i + 1).count(), order.len());
        }
    }

    /// A checksum protects the decoder from damaged pages in Ogg; other containers have none.
    #[test]
    fn damaged_packets_are_errors_or_noise() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for (application, bitrate) in [
            (rusty_opus::Application::Voip, 12_000),
            (rusty_opus::Application::Voip, 32_000),
            (rusty_opus::Application::Audio, 96_000),
        ] {
            let mut encoder = rusty_opus::OpusEncoder::new(48_000, 2, application).unwrap();
            encoder.bitrate_bps = bitrate;
            let mut decoder = decoder(2);
            let mut packet = [0; 1500];
            for n in 0..200 {
                let tone: Vec<f32> = (0..1920).map(|i| (((n * 1920 + i) as f32) * 0.02).sin()).collect();
                let len = encoder.encode(&tone, 960, &mut packet).unwrap();
                let mut bytes = packet[..len].to_vec();
                for _ in 0..rng.next_u32() % 6 {
                    let at = rng.next_u32() as usize % len;
                    bytes[at] = rng.next_u32() as u8;
                }
                bytes.truncate(len - rng.next_u32() as usize % len);
                if decoder.decode_into_planes(&bytes).is_ok() {
                    assert!(decoder.planes.iter_interleaved().all(f32::is_finite));
                }
            }
        }
    }

    #[test]
    fn absurd_headers_are_errors() {
        let heads: [&[u8]; 5] = [
            b"OpusHead",
            b"OpusHead\x01\x00\0\0\0\0\0\0\0\0\0",
            b"OpusHead\x01\x03\0\0\0\0\0\0\0\0\0",
            b"OpusHead\x01\x02\0\0\0\0\0\0\0\0\x01\x01\x02\x00\x01",
            b"OpusHead\x01\x02\0\0\0\0\0\0\0\0\x01\x01\x01",
        ];
        for head in heads {
            assert!(Head::parse(head).is_err(), "{head:?}");
        }
    }
}
