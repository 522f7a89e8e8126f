//! WAV and AIFF files: chunks of any order and length, whose headers are nearly right.

use arbitrary::Arbitrary;

use crate::song;
use crate::stated::Stated;

/// The most chunks, and the most bytes of samples in one.
const MOST_CHUNKS: usize = 24;
const MOST_SAMPLES: usize = 8 << 10;

/// Chunks that are no sound, and one of AVI.
const NAMES: [&[u8; 4]; 12] = [
    b"bext", b"JUNK", b"id3 ", b"ID3 ", b"INFO", b"NAME", b"AUTH", b"COMT", b"MARK", b"INST", b"fact",
    b"movi",
];
/// Tags of an `INFO` list.
const TAGS: [&[u8; 4]; 6] = [b"INAM", b"IART", b"IPRD", b"ICRD", b"ITRK", b"ICMT"];
/// Codecs of AIFF-C.
const PACKINGS: [&[u8; 4]; 8] = [b"NONE", b"sowt", b"fl32", b"fl64", b"alaw", b"ulaw", b"in24", b"ima4"];
const RATES_HZ: [u32; 6] = [8000, 44_100, 48_000, 96_000, 1000, 768_000];
const BITS: [u16; 6] = [16, 8, 24, 32, 64, 12];

/// A file of chunks.
#[derive(Arbitrary, Debug)]
pub struct Riff<'a> {
    form: Form,
    kind: Stated<[u8; 4]>,
    length: Stated<u32>,
    sound: Sound,
    chunks: Vec<Chunk<'a>>,
}

#[derive(Arbitrary, Clone, Copy, Debug, PartialEq)]
enum Form {
    Wave,
    /// RF64, whose true lengths are in the chunk `ds64`.
    Long,
    Aiff,
    AiffC,
}

/// The shape of the samples.
#[derive(Arbitrary, Debug)]
struct Sound {
    coding: Coding,
    channels: u8,
    rate: u8,
    bits: u8,
    stated_channels: Stated<u16>,
    stated_rate_hz: Stated<u32>,
    stated_bits: Stated<u16>,
    bytes_a_frame: Stated<u16>,
    bytes_a_second: Stated<u32>,
    extended: [u8; 10],
}

#[derive(Arbitrary, Debug)]
enum Coding {
    Pcm,
    Float,
    ALaw,
    MuLaw,
    Microsoft { frames: Stated<u16>, coefficients: Stated<u16> },
    Ima { frames: Stated<u16> },
    Extensible { valid_bits: Stated<u16>, speakers: u32, is_float: bool, kind: Stated<[u8; 16]> },
    Other(u16),
}

#[derive(Arbitrary, Debug)]
struct Chunk<'a> {
    content: Content<'a>,
    length: Stated<u32>,
}

#[derive(Arbitrary, Debug)]
enum Content<'a> {
    Sound,
    Samples { samples: &'a [u8], times: u8, offset: Stated<u32> },
    Frames(u32),
    Lengths { riff: u32, data: u32, frames: u64 },
    List { kind: Stated<[u8; 4]>, tags: Vec<Tag<'a>> },
    Other { name: u8, own: Stated<[u8; 4]>, bytes: &'a [u8] },
}

#[derive(Arbitrary, Debug)]
struct Tag<'a> {
    name: u8,
    text: &'a [u8],
    length: Stated<u32>,
}

/// Reads the file, which keeps what songs promise.
pub fn riff(file: &Riff<'_>) {
    song(&file.to_bytes());
}

impl Riff<'_> {
    fn to_bytes(&self) -> Vec<u8> {
        let (name, kind) = match self.form {
            Form::Wave => (b"RIFF", b"WAVE"),
            Form::Long => (b"RF64", b"WAVE"),
            Form::Aiff => (b"FORM", b"AIFF"),
            Form::AiffC => (b"FORM", b"AIFC"),
        };
        let mut bytes = self.kind.or(*kind).to_vec();
        for Chunk { content, length } in self.chunks.iter().take(MOST_CHUNKS) {
            let (name, content) = content.named(self);
            bytes.extend(self.chunk(name, &content, length));
        }
        self.chunk(*name, &bytes, &self.length)
    }

    fn is_big(&self) -> bool {
        matches!(self.form, Form::Aiff | Form::AiffC)
    }

    /// A chunk, which is as long as an even number of bytes.
    fn chunk(&self, name: [u8; 4], content: &[u8], length: &Stated<u32>) -> Vec<u8> {
        let length = length.or(content.len() as u32);
        let length = if self.is_big() { length.to_be_bytes() } else { length.to_le_bytes() };
        let end = &[0][..content.len() % 2];
        [&name[..], &length, content, end].concat()
    }
}

impl Content<'_> {
    /// The chunk's name, and what is in it.
    fn named(&self, file: &Riff<'_>) -> ([u8; 4], Vec<u8>) {
        match self {
            Self::Sound if file.is_big() => (*b"COMM", file.sound.common(file.form)),
            Self::Sound => (*b"fmt ", file.sound.format()),
            Self::Samples { samples, times, offset } => {
                let most = (MOST_SAMPLES / samples.len().max(1)).max(1);
                let samples = samples.repeat((1 + usize::from(times % 64)).min(most));
                if file.is_big() {
                    (*b"SSND", [&offset.or(0).to_be_bytes()[..], &[0; 4], &samples].concat())
                } else {
                    (*b"data", samples)
                }
            }
            Self::Frames(count) => (*b"fact", count.to_le_bytes().to_vec()),
            Self::Lengths { riff, data, frames } => {
                let lengths = [u64::from(*riff), u64::from(*data), *frames].map(u64::to_le_bytes);
                (*b"ds64", [lengths.as_flattened(), &[0; 4]].concat())
            }
            Self::List { kind, tags } => {
                let tags = tags.iter().take(MOST_CHUNKS);
                let tags = tags.flat_map(|tag| file.chunk(pick(&TAGS, tag.name), tag.text, &tag.length));
                (*b"LIST", kind.or(*b"INFO").into_iter().chain(tags).collect())
            }
            Self::Other { name, own, bytes } => (own.or(pick(&NAMES, *name)), bytes.to_vec()),
        }
    }
}

fn pick(names: &[&[u8; 4]], number: u8) -> [u8; 4] {
    *names[usize::from(number) % names.len()]
}

impl Sound {
    fn channels(&self) -> u16 {
        self.stated_channels.or(1 + u16::from(self.channels) % 8)
    }

    fn bits(&self) -> u16 {
        let bits = match self.coding {
            Coding::ALaw | Coding::MuLaw => 8,
            Coding::Microsoft { .. } | Coding::Ima { .. } => 4,
            Coding::Float => [32, 64][usize::from(self.bits) % 2],
            _ => BITS[usize::from(self.bits) % BITS.len()],
        };
        self.stated_bits.or(bits)
    }

    fn rate_hz(&self) -> u32 {
        self.stated_rate_hz.or(RATES_HZ[usize::from(self.rate) % RATES_HZ.len()])
    }

    /// What a WAV file says of its samples.
    fn format(&self) -> Vec<u8> {
        let (channels, bits, rate_hz) = (self.channels(), self.bits(), self.rate_hz());
        // A block of ADPCM, which is one frame to its container.
        const BLOCK: u16 = 64;
        let per_block = |header: u16| (2 * BLOCK / channels.max(1)).saturating_sub(header);
        let (tag, mut more) = match &self.coding {
            Coding::Pcm => (1, Vec::new()),
            Coding::Float => (3, Vec::new()),
            Coding::ALaw => (6, Vec::new()),
            Coding::MuLaw => (7, Vec::new()),
            Coding::Ima { frames } => (0x11, frames.or(per_block(8) + 1).to_le_bytes().to_vec()),
            Coding::Microsoft { frames, coefficients } => {
                // Those of the standard (RFC 2361).
                let known: [i16; 14] = [256, 0, 512, -256, 0, 0, 192, 64, 240, 0, 460, -208, 392, -232];
                let counts = [frames.or(per_block(14) + 2), coefficients.or(7)].map(u16::to_le_bytes);
                (2, [counts.as_flattened(), known.map(i16::to_le_bytes).as_flattened()].concat())
            }
            Coding::Extensible { valid_bits, speakers, is_float, kind } => {
                let mut guid = *b"\x01\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71";
                guid[0] = if *is_float { 3 } else { 1 };
                let bits = valid_bits.or(bits).to_le_bytes();
                (0xfffe, [&bits[..], &speakers.to_le_bytes(), &kind.or(guid)].concat())
            }
            Coding::Other(tag) => (*tag, Vec::new()),
        };
        if !more.is_empty() {
            more.splice(0..0, (more.len() as u16).to_le_bytes());
        }
        let frame = match self.coding {
            Coding::Microsoft { .. } | Coding::Ima { .. } => BLOCK,
            _ => u16::try_from(u32::from(channels) * u32::from(bits) / 8).unwrap_or(0),
        };
        let frame = self.bytes_a_frame.or(frame);
        let second = self.bytes_a_second.or(rate_hz.wrapping_mul(frame.into()));
        [
            &[tag, channels].map(u16::to_le_bytes).concat()[..],
            &[rate_hz, second].map(u32::to_le_bytes).concat(),
            &[frame, bits].map(u16::to_le_bytes).concat(),
            &more,
        ]
        .concat()
    }

    /// What an AIFF file says of them.
    fn common(&self, form: Form) -> Vec<u8> {
        let frames = self.bytes_a_second.or(64);
        // 80 bits of a floating-point number: a sign and exponent, and a whole mantissa.
        let shift = self.rate_hz().leading_zeros();
        let exponent = (0x3fff + 31 - shift.min(31)) as u16;
        let mantissa = u64::from(self.rate_hz().wrapping_shl(shift)) << 32;
        let rate = [&exponent.to_be_bytes()[..], &mantissa.to_be_bytes()].concat();
        let rate = if self.extended[9] > 224 { &self.extended[..] } else { &rate[..] };
        let packing = pick(&PACKINGS, self.bits);
        let packed = if form == Form::AiffC { [&packing[..], b"\0\0"].concat() } else { Vec::new() };
        [&self.channels().to_be_bytes()[..], &frames.to_be_bytes(), &self.bits().to_be_bytes(), rate, &packed]
            .concat()
    }
}
