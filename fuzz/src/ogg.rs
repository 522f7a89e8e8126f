//! Ogg files: the packets of good ones, changed, in pages whose checksums are right. The reader refuses any other page, so
//! that mutation alone hardly reaches what the pages hold.

use std::sync::LazyLock;

use arbitrary::Arbitrary;

use crate::song;
use crate::stated::Stated;

/// The most links, streams of a link, edits of a stream, and pages of a stream.
const MOST_LINKS: usize = 3;
const MOST_STREAMS: usize = 3;
const MOST_EDITS: usize = 32;
const MOST_PAGES: usize = 64;

/// Where a page holds what is stated of it (RFC 3533 §6).
const POSITION_AT: usize = 6;
const CHECKSUM_AT: usize = 22;
const COUNT_AT: usize = 26;
const LACING_AT: usize = 27;
/// Flags of a page.
const CONTINUED: u8 = 1;
const FIRST: u8 = 2;
const LAST: u8 = 4;

/// The position of a page on which no packet ends.
const NO_POSITION: u64 = u64::MAX;

/// A chain of links.
#[derive(Arbitrary, Debug)]
pub struct Ogg<'a> {
    links: Vec<Link<'a>>,
}

/// Streams side by side.
#[derive(Arbitrary, Debug)]
struct Link<'a> {
    streams: Vec<Stream<'a>>,
    /// Whose page comes next.
    turns: &'a [u8],
}

#[derive(Arbitrary, Debug)]
struct Stream<'a> {
    serial: Stated<u32>,
    codec: Codec,
    edits: Vec<Edit<'a>>,
    /// How many segments the pages have; each page ends with its packet where there are no more of these.
    cuts: &'a [u8],
    pages: Vec<Page>,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Codec {
    Vorbis,
    Opus,
    OpusShort,
    OpusSpeech,
    OpusSurround,
    Flac,
}

/// A change to a packet.
#[derive(Arbitrary, Debug)]
struct Edit<'a> {
    packet: u8,
    change: Change<'a>,
}

#[derive(Arbitrary, Debug)]
enum Change<'a> {
    Byte { at: u16, to: u8 },
    Cut { length: u16 },
    More(&'a [u8]),
    Own(&'a [u8]),
    Remove,
    Twice,
    Swap { with: u8 },
    Vorbis { channels: u8, rate_hz: Stated<u32>, blocks: u8, framing: bool },
    Opus { version: u8, channels: u8, skip: u16, rate_hz: u32, gain: i16, family: u8, table: &'a [u8] },
    Comments { vendor: &'a [u8], comments: Vec<Comment<'a>>, count: Stated<u32> },
}

#[derive(Arbitrary, Debug)]
struct Comment<'a> {
    name: u8,
    text: &'a [u8],
    length: Stated<u32>,
}

/// What a page says of itself.
#[derive(Arbitrary, Debug, Default)]
struct Page {
    version: Stated<u8>,
    flags: Stated<u8>,
    position: Stated<u64>,
    serial: Stated<u32>,
    number: Stated<u32>,
    checksum: Stated<u32>,
}

/// A packet, and the position in the sound where it ends.
type Packet = (Vec<u8>, u64);

/// Reads the file, which keeps what songs promise.
pub fn ogg(file: &Ogg<'_>) {
    song(&file.links.iter().take(MOST_LINKS).flat_map(Link::to_bytes).collect::<Vec<_>>());
}

impl Link<'_> {
    fn to_bytes(&self) -> Vec<u8> {
        let streams = (0..).zip(self.streams.iter().take(MOST_STREAMS));
        let mut pages: Vec<_> =
            streams.map(|(number, stream)| stream.to_pages(number).into_iter().peekable()).collect();
        // All streams begin before any goes on.
        let mut bytes: Vec<u8> = pages.iter_mut().filter_map(Iterator::next).flatten().collect();
        for turn in self.turns {
            let next = pages.get_mut(usize::from(*turn) % MOST_STREAMS).and_then(Iterator::next);
            bytes.extend(next.into_iter().flatten());
        }
        while pages.iter_mut().any(|stream| stream.peek().is_some()) {
            bytes.extend(pages.iter_mut().filter_map(Iterator::next).flatten());
        }
        bytes
    }
}

impl Stream<'_> {
    fn packets(&self) -> Vec<Packet> {
        static GOOD: LazyLock<[Vec<Packet>; 6]> = LazyLock::new(|| {
            [
                &include_bytes!("../seeds/song_ogg/vorbis.ogg")[..],
                include_bytes!("../seeds/song_ogg/opus.ogg"),
                include_bytes!("../seeds/song_ogg/opus_short.ogg"),
                include_bytes!("../seeds/song_ogg/opus_speech.ogg"),
                include_bytes!("../seeds/song_ogg/opus_surround.ogg"),
                include_bytes!("../seeds/song_ogg/flac.ogg"),
            ]
            .map(packets_of)
        });
        let mut packets = GOOD[self.codec as usize].clone();
        for edit in self.edits.iter().take(MOST_EDITS) {
            edit.apply(&mut packets, self.codec);
        }
        packets
    }

    fn to_pages(&self, number: u32) -> Vec<Vec<u8>> {
        let packets = self.packets();
        let segments = packets.iter().flat_map(segments_of).collect::<Vec<_>>();
        let (mut pages, mut cuts, mut rest) = (Vec::new(), self.cuts.iter(), &segments[..]);
        let mut continues = false;
        while !rest.is_empty() && pages.len() < MOST_PAGES {
            let packet = 1 + rest.iter().position(|(_, end)| end.is_some()).unwrap_or(rest.len() - 1);
            let cut = cuts.next().map_or(packet, |cut| usize::from((*cut).max(1)));
            let (own, others) = rest.split_at(cut.min(rest.len()).min(255));
            let flags = (if continues { CONTINUED } else { 0 })
                | (if pages.is_empty() { FIRST } else { 0 })
                | (if others.is_empty() { LAST } else { 0 });
            let place = pages.len() as u32;
            pages.push(page(own, flags, self.serial.or(number), place, self.pages.get(pages.len())));
            continues = own.last().is_some_and(|(_, end)| end.is_none());
            rest = others;
        }
        pages
    }
}

/// A part of a packet, of at most 255 bytes, and the position where the packet ends that it ends.
type Segment<'a> = (&'a [u8], Option<u64>);

/// The last segment of a packet, and no other, is shorter than 255 bytes; it may be empty.
fn segments_of((bytes, position): &Packet) -> Vec<Segment<'_>> {
    let (full, rest) = bytes.as_chunks::<255>();
    full.iter().map(|part| (&part[..], None)).chain([(rest, Some(*position))]).collect()
}

fn page(segments: &[Segment<'_>], flags: u8, serial: u32, number: u32, stated: Option<&Page>) -> Vec<u8> {
    let position = segments.iter().rev().find_map(|(_, end)| *end).unwrap_or(NO_POSITION);
    let right = Page::default();
    let stated = stated.unwrap_or(&right);
    let mut bytes = [
        &b"OggS"[..],
        &[stated.version.or(0), stated.flags.or(flags)],
        &stated.position.or(position).to_le_bytes(),
        &stated.serial.or(serial).to_le_bytes(),
        &stated.number.or(number).to_le_bytes(),
        &[0, 0, 0, 0, segments.len() as u8],
    ]
    .concat();
    bytes.extend(segments.iter().map(|(part, _)| part.len() as u8));
    bytes.extend(segments.iter().flat_map(|(part, _)| *part));
    let checksum = stated.checksum.or(checksum(&bytes));
    bytes[CHECKSUM_AT..COUNT_AT].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

/// The remainder of a page by the polynomial of RFC 3533, the highest bit first.
fn checksum(page: &[u8]) -> u32 {
    page.iter().fold(0, |sum: u32, byte| {
        (0..8).fold(sum ^ (u32::from(*byte) << 24), |sum, _| {
            (sum << 1) ^ if sum >> 31 == 0 { 0 } else { 0x04c1_1db7 }
        })
    })
}

/// The packets of a good file of one stream. Those that end within a page end evenly between its position and the one before.
fn packets_of(file: &[u8]) -> Vec<Packet> {
    let (mut packets, mut begun, mut before, mut rest) = (Vec::new(), Vec::new(), 0, file);
    while !rest.is_empty() {
        let (lacing, body) = rest[LACING_AT..].split_at(usize::from(rest[COUNT_AT]));
        let position = rest[POSITION_AT..].first_chunk().map_or(0, |position| u64::from_le_bytes(*position));
        let count = lacing.iter().filter(|length| **length < 255).count() as u64;
        let (mut ended, mut at) = (0, 0);
        for length in lacing.iter().map(|length| usize::from(*length)) {
            begun.extend(&body[at..at + length]);
            at += length;
            if length < 255 {
                ended += 1;
                let end = before + position.saturating_sub(before) * ended / count;
                packets.push((std::mem::take(&mut begun), end));
            }
        }
        if count > 0 {
            before = position;
        }
        rest = &body[at..];
    }
    packets
}

impl Edit<'_> {
    fn apply(&self, packets: &mut Vec<Packet>, codec: Codec) {
        let place = usize::from(self.packet) % packets.len().max(1);
        let Some((packet, _)) = packets.get_mut(place) else { return };
        match &self.change {
            Change::Byte { at, to } => {
                let at = usize::from(*at) % packet.len().max(1);
                packet.splice(at..(at + 1).min(packet.len()), [*to]);
            }
            Change::Cut { length } => packet.truncate(usize::from(*length)),
            Change::More(bytes) => packet.extend(*bytes),
            Change::Own(bytes) => *packet = bytes.to_vec(),
            Change::Remove => drop(packets.remove(place)),
            Change::Twice => packets.insert(place, packets[place].clone()),
            Change::Swap { with } => {
                let other = usize::from(*with) % packets.len();
                packets.swap(place, other);
            }
            Change::Vorbis { channels, rate_hz, blocks, framing } => {
                let rate = rate_hz.or(8000).to_le_bytes();
                let end = [*blocks, u8::from(*framing)];
                *packet = [&b"\x01vorbis\0\0\0\0"[..], &[*channels], &rate, &[0; 12], &end].concat();
            }
            Change::Opus { version, channels, skip, rate_hz, gain, family, table } => {
                let begin = [&b"OpusHead"[..], &[*version, *channels], &skip.to_le_bytes()].concat();
                let end = [&rate_hz.to_le_bytes()[..], &gain.to_le_bytes(), &[*family], table].concat();
                *packet = [begin, end].concat();
            }
            Change::Comments { vendor, comments, count } => {
                *packet = commented(codec, vendor, comments, count);
            }
        }
    }
}

/// A header of comments, as each codec has it.
fn commented(codec: Codec, vendor: &[u8], comments: &[Comment<'_>], count: &Stated<u32>) -> Vec<u8> {
    const NAMES: [&str; 6] =
        ["TITLE=", "ARTIST=", "METADATA_BLOCK_PICTURE=", "R128_TRACK_GAIN=", "COVERART=", ""];
    let mut bytes = [&(vendor.len() as u32).to_le_bytes()[..], vendor].concat();
    bytes.extend(count.or(comments.len() as u32).to_le_bytes());
    for Comment { name, text, length } in comments {
        let text = [NAMES[usize::from(*name) % NAMES.len()].as_bytes(), text].concat();
        bytes.extend(length.or(text.len() as u32).to_le_bytes());
        bytes.extend(text);
    }
    match codec {
        Codec::Vorbis => [b"\x03vorbis", &bytes[..], &[1]].concat(),
        Codec::Flac => [&[4], &(bytes.len() as u32).to_be_bytes()[1..], &bytes].concat(),
        _ => [b"OpusTags", &bytes[..]].concat(),
    }
}
