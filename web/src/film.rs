//! The frame of a film whose pictures and sound the browser has encoded: an MP4 file without what fills it.
//!
//! Pieces stand in the file in the order in which they were added, behind an index that says where each is (ISO/IEC
//! 14496-12; VP9 and Opus in it by their own bindings), so that a film can be played while it is still being fetched.

mod boxes;

use wasm_bindgen::prelude::*;

use self::boxes::{Boxed, boxed, full, language};

/// Units of a second of the film as a whole.
const FILM_RATE: u32 = 1000;

/// Pictures or sound.
struct Track {
    /// Units of its times in a second.
    rate: u32,
    /// The description of its codec.
    sample_entry: Vec<u8>,
    size: Option<[u16; 2]>,
    /// Units at its beginning that are not heard.
    skipped: u32,
    pieces: Vec<Piece>,
}

struct Piece {
    bytes: u32,
    units: u32,
    /// It can be decoded without those before it.
    is_key: bool,
    /// Bytes of the film's content before it.
    before: u64,
}

/// A film that is being written.
#[wasm_bindgen]
pub struct FilmFrame {
    tracks: Vec<Track>,
    bytes: u64,
}

#[wasm_bindgen]
impl FilmFrame {
    /// A film of pictures of `width` × `height` pixels, encoded by `codec`, as WebCodecs name it (`avc1.42002a`,
    /// `vp09.00.40.08`) with its description, if it has one; times are in 1/`rate` s. `colors` are the numbers of their
    /// primaries, transfer and matrix (ISO/IEC 23091-2), and 1 where they have their whole range.
    ///
    /// # Errors
    /// A codec that the film cannot hold.
    #[wasm_bindgen(constructor)]
    pub fn new(
        codec: &str,
        description: &[u8],
        width: u16,
        height: u16,
        rate: u32,
        colors: &[u8],
    ) -> Result<Self, JsError> {
        let &[primaries, transfer, matrix, range] = colors else {
            return Err(JsError::new("colors are four numbers"));
        };
        let colors = [primaries, transfer, matrix, range];
        let sample_entry = picture_entry(codec, description, [width, height], colors)?;
        let size = Some([width, height]);
        let pictures = Track { rate, sample_entry, size, skipped: 0, pieces: Vec::new() };
        Ok(Self { tracks: vec![pictures], bytes: 0 })
    }

    /// It has sound, too: of two channels, encoded by `codec` (`mp4a.40.2`, `opus`); times are in 1/`rate` s.
    ///
    /// # Errors
    /// A codec that the film cannot hold.
    pub fn with_sound(&mut self, codec: &str, description: &[u8], rate: u32) -> Result<(), JsError> {
        let (sample_entry, skipped) = sound_entry(codec, description, rate)?;
        self.tracks.push(Track { rate, sample_entry, size: None, skipped, pieces: Vec::new() });
        Ok(())
    }

    /// The next piece of the film's content: a picture, or sound, of this many `bytes`, which lasts this many
    /// `units`.
    pub fn add(&mut self, is_sound: bool, bytes: u32, units: u32, is_key: bool) {
        if let Some(track) = self.tracks.get_mut(usize::from(is_sound)) {
            track.pieces.push(Piece { bytes, units, is_key, before: self.bytes });
            self.bytes += u64::from(bytes);
        }
    }

    /// The part of the file before its content.
    pub fn head(&self) -> Vec<u8> {
        let kinds = [&b"isom"[..], &512_u32.to_be_bytes(), b"isomiso2mp41"].concat();
        let kind = boxed(b"ftyp", &kinds);
        // The index is as long wherever the content begins.
        let index = self.index(0).len();
        let content = 16_u64;
        let begins = (kind.len() + index) as u64 + content;
        let long = [&1_u32.to_be_bytes()[..], b"mdat", &(content + self.bytes).to_be_bytes()].concat();
        [kind, self.index(begins), long].concat()
    }
}

impl FilmFrame {
    fn index(&self, begins: u64) -> Vec<u8> {
        let longest = self.tracks.iter().map(Track::film_units).max().unwrap_or_default();
        let mut head = Boxed::default();
        head.u32s(&[0, 0, FILM_RATE, longest, 0x0001_0000]).u16s(&[0x0100, 0]).u32s(&[0, 0]);
        head.matrix().u32s(&[0; 6]).u32s(&[self.tracks.len() as u32 + 1]);
        let mut index = full(b"mvhd", 0, 0, &head.bytes);
        for (i, track) in self.tracks.iter().enumerate() {
            index.extend(track.boxed(i as u32 + 1, begins));
        }
        boxed(b"moov", &index)
    }
}

impl Track {
    fn units(&self) -> u64 {
        self.pieces.iter().map(|piece| u64::from(piece.units)).sum()
    }

    /// How long it is seen or heard, in units of the film.
    fn film_units(&self) -> u32 {
        let units = self.units().saturating_sub(self.skipped.into());
        (units * u64::from(FILM_RATE)).div_ceil(u64::from(self.rate.max(1))) as u32
    }

    fn boxed(&self, number: u32, begins: u64) -> Vec<u8> {
        let mut head = Boxed::default();
        head.u32s(&[0, 0, number, 0, self.film_units(), 0, 0]);
        let [width, height] = self.size.unwrap_or_default();
        let volume = if self.size.is_some() { 0 } else { 0x0100 };
        head.u16s(&[0, 0, volume, 0]).matrix();
        head.u32s(&[u32::from(width) << 16, u32::from(height) << 16]);
        // Enabled, and part of the film.
        let head = full(b"tkhd", 0, 3, &head.bytes);
        let mut edit = Boxed::default();
        edit.u32s(&[1, self.film_units(), self.skipped]).u16s(&[1, 0]);
        let edits = boxed(b"edts", &full(b"elst", 0, 0, &edit.bytes));
        let mut media = Boxed::default();
        media.u32s(&[0, 0, self.rate, self.units() as u32]).u16s(&[language(b"und"), 0]);
        let mut handler = Boxed::default();
        let (kind, name) = if self.size.is_some() { (b"vide", "pictures\0") } else { (b"soun", "sound\0") };
        handler.u32s(&[0]).raw(kind).u32s(&[0; 3]).raw(name.as_bytes());
        let how = match self.size {
            Some(_) => full(b"vmhd", 0, 1, &[0; 8]),
            None => full(b"smhd", 0, 0, &[0; 4]),
        };
        // All of it is in this file.
        let here = [&1_u32.to_be_bytes()[..], &full(b"url ", 0, 1, &[])].concat();
        let data = boxed(b"dinf", &full(b"dref", 0, 0, &here));
        let information = [how, data, self.table(begins)].concat();
        let media = [
            full(b"mdhd", 0, 0, &media.bytes),
            full(b"hdlr", 0, 0, &handler.bytes),
            boxed(b"minf", &information),
        ];
        boxed(b"trak", &[head, edits, boxed(b"mdia", &media.concat())].concat())
    }

    /// The table of the track's pieces: codec, lengths and places.
    fn table(&self, begins: u64) -> Vec<u8> {
        let entries = [&1_u32.to_be_bytes()[..], &self.sample_entry].concat();
        let mut runs: Vec<[u32; 2]> = Vec::new();
        for piece in &self.pieces {
            match runs.last_mut() {
                Some([count, units]) if *units == piece.units => *count += 1,
                _ => runs.push([1, piece.units]),
            }
        }
        let mut table = full(b"stsd", 0, 0, &entries);
        let listed = |name, count: usize, values: &mut dyn Iterator<Item = u32>| {
            let mut list = Boxed::default();
            list.u32s(&[count as u32]);
            values.for_each(|value| {
                list.u32s(&[value]);
            });
            full(name, 0, 0, &list.bytes)
        };
        table.extend(listed(b"stts", runs.len(), &mut runs.iter().flatten().copied()));
        if self.size.is_some() {
            let keys: Vec<u32> =
                (1..).zip(&self.pieces).filter(|(_, piece)| piece.is_key).map(|(number, _)| number).collect();
            table.extend(listed(b"stss", keys.len(), &mut keys.iter().copied()));
        }
        // Each piece stands on its own.
        table.extend(listed(b"stsc", 1, &mut [1, 1, 1].into_iter()));
        let mut sizes = Boxed::default();
        sizes.u32s(&[0, self.pieces.len() as u32]);
        self.pieces.iter().for_each(|piece| {
            sizes.u32s(&[piece.bytes]);
        });
        table.extend(full(b"stsz", 0, 0, &sizes.bytes));
        let mut places = Boxed::default();
        places.u32s(&[self.pieces.len() as u32]);
        self.pieces.iter().for_each(|piece| {
            places.raw(&(begins + piece.before).to_be_bytes());
        });
        table.extend(full(b"co64", 0, 0, &places.bytes));
        boxed(b"stbl", &table)
    }
}

fn picture_entry(
    codec: &str,
    description: &[u8],
    [width, height]: [u16; 2],
    [primaries, transfer, matrix, range]: [u8; 4],
) -> Result<Vec<u8>, JsError> {
    let (name, configuration) = match codec.split('.').next() {
        Some("avc1") if !description.is_empty() => (b"avc1", boxed(b"avcC", description)),
        Some("vp09") => {
            let numbers: Vec<u8> = codec.split('.').skip(1).filter_map(|part| part.parse().ok()).collect();
            let [profile, level, depth, ..] = numbers[..] else { return Err(unknown(codec)) };
            // Halved chroma, beside the luminance of the left column.
            let sampling = depth << 4 | 1 << 1 | range;
            let bytes = [profile, level, sampling, primaries, transfer, matrix, 0, 0];
            (b"vp09", full(b"vpcC", 1, 0, &bytes))
        }
        _ => return Err(unknown(codec)),
    };
    let mut entry = Boxed::default();
    entry.u16s(&[0, 0, 0, 1, 0, 0]).u32s(&[0; 3]).u16s(&[width, height]);
    // 72 dots an inch, one picture a piece, no name, 24 bits.
    entry
        .u32s(&[0x0048_0000, 0x0048_0000, 0])
        .u16s(&[1])
        .raw(&[0; 32])
        .u16s(&[24, 0xFFFF])
        .raw(&configuration);
    let color = [&b"nclx"[..], &[0, primaries, 0, transfer, 0, matrix, range << 7]].concat();
    entry.raw(&boxed(b"colr", &color));
    Ok(boxed(name, &entry.bytes))
}

/// The description of the sound's codec, and how many units at its beginning are not heard.
fn sound_entry(codec: &str, description: &[u8], rate: u32) -> Result<(Vec<u8>, u32), JsError> {
    let (name, configuration, skipped) = match codec {
        "opus" => {
            // "OpusHead", version, channels, and numbers with their lowest byte first, which a film has last.
            let known = description.strip_prefix(b"OpusHead").and_then(|rest| rest.first_chunk::<11>());
            let Some([_, channels, a, b, c, d, e, f, g, h, mapping]) = known.copied() else {
                return Err(unknown(codec));
            };
            let bytes = [0, channels, b, a, f, e, d, c, h, g, mapping];
            (b"Opus", boxed(b"dOps", &bytes), u16::from_le_bytes([a, b]).into())
        }
        _ if codec.starts_with("mp4a") && (1..64).contains(&description.len()) => {
            (b"mp4a", full(b"esds", 0, 0, &boxes::aac_descriptor(description)), 0)
        }
        _ => return Err(unknown(codec)),
    };
    // Where 16 bits cannot hold the rate, only the configuration has it.
    let rate = u16::try_from(rate).unwrap_or(0);
    let mut entry = Boxed::default();
    entry.u16s(&[0, 0, 0, 1]).u32s(&[0, 0]).u16s(&[2, 16, 0, 0, rate, 0]).raw(&configuration);
    Ok((boxed(name, &entry.bytes), skipped))
}

fn unknown(codec: &str) -> JsError {
    JsError::new(&format!("this browser encodes films as {codec}, which the page cannot put into a file"))
}
