//! Reading a song takes a bounded number of bytes of memory for each byte of its file, and of what is kept of it.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use chladni_sound::{Song, SongOptions, SongReader, SoundError, WavSample, wav_bytes};
use chladni_task::Task;
use chladni_testdata::{crc, ogg_page, vorbis_of_books};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What `SongReader` promises for each byte of a file, and besides.
const EACH: usize = 64;
const BESIDES: usize = 16 << 20;

/// Rows of a file.
const COUNT: usize = 60_000;

/// The name of a file, and its bytes.
type File = (&'static str, Vec<u8>);

/// The most bytes that were in use at once while `work` ran, what was in use before left aside.
fn peak<T>(work: impl FnOnce() -> T) -> (usize, T) {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let result = work();
    (MEMORY.peak_usage() - before, result)
}

/// A tag of ID3v2.4 with these frames.
fn id3(frames: &[u8]) -> Vec<u8> {
    let size = frames.len();
    let size = [21, 14, 7, 0].map(|shift| (size >> shift) as u8 & 0x7f);
    [b"ID3\x04\x00\x00", &size[..], frames].concat()
}

fn mp3_files() -> Vec<File> {
    // Frames of silence at 128 kbit/s.
    let silence = [&[0xff, 0xfb, 0x90, 0x00][..], &[0; 413]].concat().repeat(4);
    let frame = |name: &str, content: &[u8]| {
        [name.as_bytes(), &[0, 0, 0, content.len() as u8], &[0, 0], content].concat()
    };
    let file = |row: Vec<u8>| [id3(&row.repeat(COUNT)), silence.clone()].concat();
    vec![
        ("titles", file(frame("TIT2", b"\x03a"))),
        ("own texts", file(frame("TXXX", b"\x03a\0b"))),
        ("pictures", file(frame("APIC", b"\x00image/png\0\x03\0x"))),
        ("comments", file(frame("COMM", b"\x03engd\0e"))),
        ("unknown frames", file(frame("ABCD", b"x"))),
        ("tags", [id3(&frame("TIT2", b"\x03a")).repeat(COUNT), silence].concat()),
    ]
}

fn wav_files() -> Vec<File> {
    let song = Song { rate_hz: 8000, left: vec![0.25; 800], right: vec![-0.25; 800] };
    let good = wav_bytes(&song, WavSample::Int16).unwrap();
    let (head, data) = good.split_at(good.windows(4).position(|name| name == b"data").unwrap());
    let file = |chunks: Vec<u8>| {
        let mut bytes = [head, &chunks, data].concat();
        let size = (bytes.len() - 8) as u32;
        bytes[4..8].copy_from_slice(&size.to_le_bytes());
        bytes
    };
    let info = b"INAM\x02\x00\x00\x00a\0".repeat(COUNT);
    let list = [b"LIST", &(info.len() as u32 + 4).to_le_bytes()[..], b"INFO", &info].concat();
    vec![
        ("titles", file(list)),
        ("lists", file(b"LIST\x0e\x00\x00\x00INFOINAM\x02\x00\x00\x00a\0".repeat(COUNT))),
        ("unknown chunks", file(b"abcd\0\0\0\0".repeat(COUNT))),
    ]
}

/// A frame of 4096 equal samples a side.
fn flac_frame() -> Vec<u8> {
    let mut frame = vec![0xff, 0xf8, 0xc9, 0x18, 0];
    frame.push(crc(&frame, 8, 0x07) as u8);
    frame.extend([0, 1, 0, 0, 2, 0]);
    let check = crc(&frame, 16, 0x8005) as u16;
    frame.extend(check.to_be_bytes());
    frame
}

fn flac_files() -> Vec<File> {
    let block = |kind: u8, content: &[u8]| {
        [&[kind][..], &(content.len() as u32).to_be_bytes()[1..], content].concat()
    };
    let about =
        [&[16, 0, 16, 0, 0, 0, 0, 0, 0, 0, 0x0a, 0xc4, 0x42, 0xf0, 0, 0, 0, 0][..], &[0; 16]].concat();
    let file = |blocks: &[u8], frames: usize| {
        [b"fLaC", &block(0, &about)[..], blocks, &block(0x81, &[0; 4]), &flac_frame().repeat(frames)].concat()
    };
    let comments =
        [&[0; 4], &(COUNT as u32).to_le_bytes(), &b"\x03\x00\x00\x00A=b".repeat(COUNT)[..]].concat();
    let no_picture = [&[0, 0, 0, 3, 0, 0, 0, 1, b'x', 0, 0, 0, 0][..], &[0; 16], &[0, 0, 0, 1, 9]].concat();
    let point = [&[0; 16][..], &[16, 0]].concat();
    vec![
        ("comments", file(&block(4, &comments), 1)),
        ("pictures", file(&block(6, &no_picture).repeat(COUNT), 1)),
        ("seek points", file(&block(3, &point.repeat(COUNT)), 1)),
        ("equal samples", file(&[], 2000)),
    ]
}

fn opus_files() -> Vec<File> {
    let head = b"OpusHead\x01\x02\x38\x01\x80\xbb\x00\x00\x00\x00\x00";
    let file = |tags: &[u8], sounds: u32| {
        // Pages hold 255 lengths; a part that ends its packet has one more than it is full.
        let parts = tags.chunks(254 * 255);
        let count = parts.len() as u32;
        let tags =
            (0..).zip(parts).map(|(i, part)| ogg_page(1 + i, u8::from(i > 0), 0, part, i + 1 == count));
        // Each 20 ms of nothing.
        let sound = |i: u32| ogg_page(1 + count + i, 0, 960 * u64::from(i + 1), &[0xfc], true);
        let pages = tags.chain((0..sounds).map(sound));
        [ogg_page(0, 2, 0, head, true)].into_iter().chain(pages).flatten().collect()
    };
    let tags = |count: usize| {
        [b"OpusTags", &[0; 4][..], &(count as u32).to_le_bytes(), &b"\x03\x00\x00\x00A=b".repeat(count)]
            .concat()
    };
    vec![("comments", file(&tags(COUNT), 5)), ("silence", file(&tags(0), COUNT as u32 / 10))]
}

/// An AIFF file that ends where its sound would begin.
fn aiff_header(channels: u16, bits: u16) -> Vec<u8> {
    let rate_8000_hz = b"\x40\x0b\xfa\0\0\0\0\0\0\0";
    [
        b"FORM\0\0\0\x1eAIFFCOMM\0\0\0\x12",
        &channels.to_be_bytes()[..],
        &[0; 4],
        &bits.to_be_bytes(),
        rate_8000_hz,
    ]
    .concat()
}

#[test]
fn memory_is_bounded_by_the_length_of_the_file() {
    let kinds = [("MP3", mp3_files()), ("WAV", wav_files()), ("FLAC", flac_files()), ("Opus", opus_files())];
    let options = SongOptions { max_bytes: 8 << 20, ..SongOptions::default() };
    for (kind, files) in kinds {
        for (what, bytes) in files {
            let length = bytes.len();
            let (opening, reader) = peak(|| SongReader::from_bytes(what, bytes));
            let mut reader = reader.unwrap_or_else(|error| panic!("{kind}, {what}: {error}"));
            let (reading, song) = peak(|| Song::read(&mut reader, &options, &Task::new()));
            let each = opening as f64 / length as f64;
            println!(
                "{kind}, {what}, {length} bytes: {opening} to open ({each:.1} for each), {reading} to read"
            );
            match song {
                Ok(song) => assert!(song.frames() > 0),
                Err(error) => assert!(matches!(error, SoundError::TooLong { .. }), "{kind}, {what}: {error}"),
            }
            assert!(opening <= EACH * length + BESIDES, "{kind}, {what}: {opening} bytes for {length}");
            assert!(reading <= EACH * length + 3 * options.max_bytes + BESIDES, "{kind}, {what}: {reading}");
        }
    }
    // Room for a packet in all of these channels would take 21 and 75 MB.
    for (channels, bits) in [(9_114, 16), (u16::MAX, 8), (16_383, 32)] {
        let bytes = aiff_header(channels, bits);
        let length = bytes.len();
        let (opening, reader) = peak(|| SongReader::from_bytes("header.aiff", bytes));
        assert!(reader.is_err(), "{channels} channels");
        assert!(opening <= EACH * length + BESIDES, "{channels} channels: {opening} bytes for {length}");
    }
}

/// The first bits of a code book with 2^17 words of 17 bits, in the order of their lengths.
const MOST_WORDS: [(u32, u32); 6] =
    [(0x0056_4342, 24), (31, 16), (1 << 17, 24), (1, 1), (16, 5), (1 << 17, 18)];

#[test]
fn streams_of_opus_that_would_take_much_are_not_made() {
    let head = b"OpusHead\x01\x01\x38\x01\x80\xbb\x00\x00\x00\x00\x01\xff\xff\x00";
    let tags = b"OpusTags\0\0\0\0\0\0\0\0";
    let pages =
        [ogg_page(0, 2, 0, head, true), ogg_page(1, 0, 0, tags, true), ogg_page(2, 4, 960, &[0xfc], true)];
    let bytes = pages.concat();
    let length = bytes.len();
    let (opening, reader) = peak(|| SongReader::from_bytes("streams.opus", bytes));
    let error = reader.err().unwrap().to_string();
    println!("{length} bytes: {opening} to open; {error}");
    assert!(opening <= EACH * length + BESIDES, "{opening} bytes for {length}");
}

#[test]
fn books_of_vorbis_that_would_take_much_are_not_made() {
    // A lattice of one value, and none.
    let lattice = [(1, 4), (0, 32), (0, 32), (0, 4), (0, 1), (0, 1)];
    // Lengths from 32 to 272 without a word, then all of 273, which the decoder keeps as 17.
    let mut wrapped = [&MOST_WORDS[..4], &[(31, 5)], &[(0, 18); 241]].concat();
    wrapped.push((1 << 17, 18));
    let no_lattice = &[(0, 4)][..];
    let books =
        [(1, &MOST_WORDS[..], &lattice[..]), (256, &MOST_WORDS, &lattice), (1, &MOST_WORDS, no_lattice)];
    for (count, words, end) in
        books.into_iter().chain([(256, &MOST_WORDS[..], no_lattice), (100, &wrapped, no_lattice)])
    {
        let bytes = vorbis_of_books(count, &[words, end].concat());
        let length = bytes.len();
        let (opening, reader) = peak(|| SongReader::from_bytes("books.ogg", bytes));
        let error = reader.err().unwrap().to_string();
        println!("{length} bytes: {opening} to open; {error}");
        assert!(error.contains("code books"), "{error}");
        assert!(opening <= EACH * length + BESIDES, "{opening} bytes for {length}");
    }
}
