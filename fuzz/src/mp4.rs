//! MP4 files: the boxes of good ones, changed, around which all lengths are right unless one is said to lie.

use std::sync::LazyLock;

use arbitrary::Arbitrary;

use crate::song;
use crate::stated::Stated;

const MOST_EDITS: usize = 32;
/// The most rows of a table.
const MOST_ROWS: usize = 256;
/// Boxes of boxes.
const WITHIN: [&[u8; 4]; 10] =
    [b"moov", b"trak", b"mdia", b"minf", b"stbl", b"edts", b"udta", b"moof", b"traf", b"mvex"];
/// Tables, each of rows of so many 32-bit numbers.
const TABLES: [(&[u8; 4], usize); 7] =
    [(b"elst", 3), (b"stts", 2), (b"stsc", 3), (b"stsz", 1), (b"stco", 1), (b"co64", 2), (b"ctts", 2)];
const NAMES: [&[u8; 4]; 8] = [b"free", b"mvhd", b"tkhd", b"mdhd", b"hdlr", b"stsd", b"tfhd", b"trun"];

/// A good file and what is changed in it.
#[derive(Arbitrary, Debug)]
pub struct Mp4<'a> {
    file: u8,
    edits: Vec<Edit<'a>>,
}

#[derive(Arbitrary, Debug)]
struct Edit<'a> {
    place: u8,
    change: Change<'a>,
}

#[derive(Arbitrary, Debug)]
enum Change<'a> {
    Byte { at: u16, to: u8 },
    Number { at: u8, to: u32 },
    Own(&'a [u8]),
    Table { kind: u8, version: Stated<u8>, rows: Vec<[u32; 3]>, count: Stated<u32> },
    Name { name: u8, own: Stated<[u8; 4]> },
    Length(u32),
    Remove,
    Twice,
    Swap,
}

#[derive(Clone)]
struct Part {
    name: [u8; 4],
    /// What it states, where that is not true.
    length: Option<u32>,
    content: Content,
}

#[derive(Clone)]
enum Content {
    Bytes(Vec<u8>),
    Parts(Vec<Part>),
}

/// Reads the file, which keeps what songs promise.
pub fn mp4(file: &Mp4<'_>) {
    static GOOD: LazyLock<[Vec<Part>; 5]> = LazyLock::new(|| {
        [
            &include_bytes!("../seeds/song_mp4/aac.m4a")[..],
            include_bytes!("../seeds/song_mp4/fragments.m4a"),
            include_bytes!("../seeds/song_mp4/alac.m4a"),
            include_bytes!("../seeds/song_mp4/opus.mp4"),
            include_bytes!("../seeds/song_mp4/mp3.mp4"),
        ]
        .map(parts_of)
    });
    let mut parts = GOOD[usize::from(file.file) % GOOD.len()].clone();
    for Edit { place, change } in file.edits.iter().take(MOST_EDITS) {
        let all = count(&parts);
        if all > 0 {
            edit(&mut parts, &mut (usize::from(*place) % all), change);
        }
    }
    song(&parts.iter().flat_map(Part::to_bytes).collect::<Vec<_>>());
}

/// The boxes of good bytes.
fn parts_of(mut bytes: &[u8]) -> Vec<Part> {
    let mut parts = Vec::new();
    while let Some((head, rest)) = bytes.split_first_chunk::<8>() {
        let [a, b, c, d, name @ ..] = *head;
        let length = u32::from_be_bytes([a, b, c, d]) as usize;
        let (content, others) = rest.split_at(length - head.len());
        let is_of_parts = WITHIN.contains(&&name);
        let content =
            if is_of_parts { Content::Parts(parts_of(content)) } else { Content::Bytes(content.to_vec()) };
        parts.push(Part { name, length: None, content });
        bytes = others;
    }
    parts
}

/// How many boxes there are, at any depth.
fn count(parts: &[Part]) -> usize {
    parts.iter().map(|part| 1 + count(part.parts())).sum()
}

/// Changes the box at `place` among all, a box before those in it; `place` is counted down to it.
fn edit(parts: &mut Vec<Part>, place: &mut usize, change: &Change<'_>) {
    for at in 0..parts.len() {
        if *place == 0 {
            return match change {
                Change::Remove => drop(parts.remove(at)),
                Change::Twice => parts.insert(at, parts[at].clone()),
                Change::Swap => {
                    let next = (at + 1) % parts.len();
                    parts.swap(at, next);
                }
                _ => parts[at].change(change),
            };
        }
        *place -= 1;
        let within = count(parts[at].parts());
        if *place < within {
            if let Content::Parts(inner) = &mut parts[at].content {
                edit(inner, place, change);
            }
            return;
        }
        *place -= within;
    }
}

impl Part {
    fn parts(&self) -> &[Self] {
        match &self.content {
            Content::Bytes(_) => &[],
            Content::Parts(parts) => parts,
        }
    }

    fn to_bytes(&self) -> Vec<u8> {
        let content = match &self.content {
            Content::Bytes(bytes) => bytes.clone(),
            Content::Parts(parts) => parts.iter().flat_map(Self::to_bytes).collect(),
        };
        let length = self.length.unwrap_or(8 + content.len() as u32);
        [&length.to_be_bytes()[..], &self.name, &content].concat()
    }

    fn change(&mut self, change: &Change<'_>) {
        match (change, &mut self.content) {
            (Change::Byte { at, to }, Content::Bytes(bytes)) => {
                let count = bytes.len().max(1);
                bytes.get_mut(usize::from(*at) % count).into_iter().for_each(|byte| *byte = *to);
            }
            (Change::Number { at, to }, Content::Bytes(bytes)) => {
                let count = bytes.len().div_ceil(4).max(1);
                let number = bytes.chunks_mut(4).nth(usize::from(*at) % count);
                number.into_iter().flatten().zip(to.to_be_bytes()).for_each(|(byte, to)| *byte = to);
            }
            (Change::Own(bytes), content) => *content = Content::Bytes(bytes.to_vec()),
            (Change::Table { kind, version, rows, count }, content) => {
                let (name, columns) = TABLES[usize::from(*kind) % TABLES.len()];
                let rows = &rows[..rows.len().min(MOST_ROWS)];
                let numbers = rows.iter().flat_map(|row| &row[..columns]).map(|number| number.to_be_bytes());
                // Sizes have one for all before them.
                let begin = &[version.or(0), 0, 0, 0, 0, 0, 0, 0][..if name == b"stsz" { 8 } else { 4 }];
                let count = count.or(rows.len() as u32).to_be_bytes();
                self.name = *name;
                *content =
                    Content::Bytes(begin.iter().copied().chain(count).chain(numbers.flatten()).collect());
            }
            (Change::Name { name, own }, _) => self.name = own.or(*NAMES[usize::from(*name) % NAMES.len()]),
            (Change::Length(length), _) => self.length = Some(*length),
            _ => {}
        }
    }
}
