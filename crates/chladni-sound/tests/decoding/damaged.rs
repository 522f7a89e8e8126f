//! Files that are empty, truncated, absurd or endless.

use chladni_testdata::vorbis_of_books;

use super::*;

#[test]
fn empty_files_say_so() {
    for name in ["empty.wav", "empty.ogg"] {
        let Some(path) = shared(&format!("audio/{name}")) else { return };
        let error = Song::open(&path).expect_err(name);
        assert!(matches!(error, SoundError::Empty { .. }), "{name}: {error}");
    }
    // This file holds a single frame of padding; both silence and an error are right.
    if let Some(path) = shared("audio/empty.mp3")
        && let Ok(song) = Song::open(&path)
    {
        assert!(song.frames() <= 2 * 1152);
    }
    assert!(matches!(read_bytes("nothing", Vec::new()), Err(SoundError::Empty { .. })));
    assert!(matches!(
        read_bytes("text.ogg", b"this is no music at all".repeat(50)),
        Err(SoundError::Unrecognized { .. })
    ));
    assert!(matches!(Song::open(Path::new("/")), Err(SoundError::Read { .. })));
    assert!(matches!(Song::open(Path::new("no/such/file")), Err(SoundError::Read { .. })));
}

#[test]
fn a_damaged_opus_file_is_not_called_one_of_a_codec_that_is_missing() {
    // The head of a stream without its checksum, and half of its tags.
    let page = |kind: u8, number: u8, length: u8| {
        let head = [b"OggS", &[0, kind][..], &[0; 8], &[1, 0, 0, 0], &[number, 0, 0, 0]].concat();
        [&head[..], &[0; 4], &[1, length]].concat()
    };
    let head = b"OpusHead\x01\x02\x38\x01\x80\xbb\x00\x00\x00\x00\x00";
    let (begun, tagged) = (page(2, 0, head.len() as u8), page(0, 1, 40));
    let file = [&begun[..], head, &tagged[..], b"OpusTags\x10\x00\x00\x00half"].concat();
    let error = read_bytes("x.opus", file).expect_err("there is no sound");
    assert!(!error.to_string().contains("not supported"), "{error}");
    assert!(error.to_string().contains("x.opus"), "{error}");
}

#[test]
fn truncated_files_play_as_far_as_they_go() {
    for name in ["dubstep.wav", "dubstep.flac", "dubstep.mp3", "dubstep.ogg"] {
        let Some(path) = shared(&format!("audio/{name}")) else { return };
        let bytes = std::fs::read(&path).unwrap();
        let whole = read_bytes(name, bytes.clone()).unwrap();
        let half = read_bytes(name, bytes[..bytes.len() / 2].to_vec()).unwrap();
        let share = half.frames() as f64 / whole.frames() as f64;
        assert!((0.3..0.7).contains(&share), "{name}: {share}");
        let same = half.left.iter().zip(&whole.left).take(half.frames() / 2).all(|(a, b)| a == b);
        assert!(same, "{name}");
        // Missing parts are reported as far as the file format reveals them.
        let mut holed = bytes.clone();
        holed[bytes.len() / 2..bytes.len() / 2 + 400].fill(0x55);
        let half = bytes[..bytes.len() / 2].to_vec();
        let checked = name.ends_with("flac") || name.ends_with("ogg");
        for (bytes, damaged) in [(bytes.clone(), false), (half, !name.ends_with("mp3")), (holed, checked)] {
            let (_, damage) = played(name, bytes);
            assert_eq!(damage.is_some(), damaged, "{name}: {damage:?}");
        }
        for keep in [1, 3, 12, 40, 44, 60, 200] {
            // Too short for any sound: an error or a few samples are right, a panic is not.
            if let Ok(song) = read_bytes(name, bytes[..keep].to_vec()) {
                assert!(song.frames() < 5000);
            }
        }
    }
}

/// The sound of a file, and what is missing from it.
fn played(name: &str, bytes: Vec<u8>) -> (Song, Option<String>) {
    let mut reader = SongReader::from_bytes(name, bytes).unwrap_or_else(|error| panic!("{error}"));
    let song = Song::read(&mut reader, &SongOptions::default(), &Task::new()).unwrap();
    (song, reader.damage())
}

/// A file without its last byte, and the first 60 % of it.
fn cuts(bytes: &[u8]) -> [Vec<u8>; 2] {
    [bytes.len() - 1, bytes.len() * 3 / 5].map(|keep| bytes[..keep].to_vec())
}

/// A ramp of 8000 frames in 16 bits, in the order of their bytes, and the song that it is.
fn ramp(bytes: fn(i16) -> [u8; 2]) -> (Vec<u8>, Song) {
    let values = || (0..8000).map(|n| 4 * n - 16_000);
    let wave: Vec<f32> = values().map(|value| f32::from(value) / 32_768.0).collect();
    let data = values().flat_map(|value| [bytes(value), bytes(value)]).flatten().collect();
    (data, Song { rate_hz: 8000, right: wave.clone(), left: wave })
}

#[test]
fn an_aiff_file_plays_as_far_as_it_goes() {
    let (data, song) = ramp(i16::to_be_bytes);
    let file = |form: u32, frames: u32, sound: u32| {
        let common = [&[0, 2][..], &frames.to_be_bytes(), b"\0\x10\x40\x0b\xfa\0\0\0\0\0\0\0"].concat();
        let common = [b"COMM\0\0\0\x12", &common[..]].concat();
        [b"FORM", &form.to_be_bytes()[..], b"AIFF", &common, b"SSND", &sound.to_be_bytes(), &[0; 8], &data]
            .concat()
    };
    let whole = file(32_046, 8000, 32_008);
    for unknown in [0, u32::MAX] {
        for (form, frames) in [(32_046, 8000), (unknown, unknown)] {
            assert!(played("whole.aiff", file(form, frames, unknown)) == (song.clone(), None), "{unknown}");
        }
    }
    assert!(played("whole.aiff", whole.clone()) == (song.clone(), None));
    for (cut, frames, said) in [
        (1, 7999, "the file ends in the middle"),
        (12_800, 4800, "the file ends in the middle, 0.4 s are missing"),
    ] {
        let (half, damage) = played("cut.aiff", whole[..whole.len() - cut].to_vec());
        assert_eq!((half.frames(), damage.as_deref()), (frames, Some(said)));
        assert!(half.left == song.left[..frames]);
    }
    let mut reader = SongReader::from_bytes("cut.aiff", whole[..whole.len() / 2].to_vec()).unwrap();
    for (frame, plays) in [(3000, true), (6000, false), (9000, false), (0, true)] {
        reader.seek(frame).unwrap();
        assert_eq!(reader.next_block().unwrap().is_some(), plays, "{frame}");
    }
}

#[test]
fn a_matroska_file_plays_as_far_as_it_goes() {
    let (data, song) = ramp(i16::to_le_bytes);
    let element = |id: &[u8], content: &[u8]| {
        let length = (1 << 56) | content.len() as u64;
        [id, &length.to_be_bytes(), content].concat()
    };
    let head = element(b"\x1a\x45\xdf\xa3", &element(b"\x42\x82", b"matroska"));
    let about = [element(b"\x4d\x80", b"test"), element(b"\x57\x41", b"test")].concat();
    let sound = [element(b"\x9f", &[2]), element(b"\x62\x64", &[16])].concat();
    let (number, uid, kind) = (element(b"\xd7", &[1]), element(b"\x73\xc5", &[1]), element(b"\x83", &[2]));
    let track = [number, uid, kind, element(b"\x86", b"A_PCM/INT/LIT"), element(b"\xe1", &sound)].concat();
    let tracks = element(b"\x16\x54\xae\x6b", &element(b"\xae", &track));
    // Blocks of a tenth of a second, each in a cluster.
    let clusters = (0_u16..).zip(data.chunks(3200)).flat_map(|(n, samples)| {
        let block = element(b"\xa3", &[b"\x81\0\0\x80", samples].concat());
        element(b"\x1f\x43\xb6\x75", &[element(b"\xe7", &(100 * n).to_be_bytes()), block].concat())
    });
    let content = [element(b"\x15\x49\xa9\x66", &about), tracks, clusters.collect()].concat();
    let sized = [&head[..], &element(b"\x18\x53\x80\x67", &content)].concat();
    let live = [&head[..], b"\x18\x53\x80\x67\x01", &[0xff; 7], &content].concat();
    for (name, whole) in [("sized.mka", sized), ("live.mka", live)] {
        assert!(played(name, whole.clone()) == (song.clone(), None), "{name}");
        for (cut, blocks) in cuts(&whole).into_iter().zip([9, 5]) {
            let (half, damage) = played(name, cut.clone());
            assert_eq!(damage.as_deref(), Some("the file ends in the middle"), "{name}");
            assert!(half.left == song.left[..800 * blocks], "{name}: {} frames", half.frames());
            let mut reader = SongReader::from_bytes(name, cut).unwrap();
            reader.seek(2400).unwrap();
            assert_eq!(reader.next_block().unwrap().unwrap()[0], song.left[2400], "{name}");
        }
    }
}

#[test]
fn cut_files_of_ffmpeg_play_as_far_as_they_go() {
    let folder = tempfile::tempdir().unwrap();
    let (song, source) = (chirp(44_100), folder.path().join("source.wav"));
    write_wav(&source, &song, WavSample::Int16).unwrap();
    let fragments = "frag_keyframe+empty_moov+delay_moov";
    let formats: [(&str, &[&str]); 6] = [
        ("alac.m4a", &["-c:a", "alac", "-movflags", "faststart"]),
        ("aac.m4a", &["-c:a", "aac", "-movflags", "faststart"]),
        ("fragments.m4a", &["-c:a", "alac", "-movflags", fragments]),
        ("flac.ogg", &["-c:a", "flac"]),
        ("flac.mka", &["-c:a", "flac"]),
        ("mulaw.aifc", &["-c:a", "pcm_mulaw", "-f", "aiff"]),
    ];
    for (name, arguments) in formats {
        let path = folder.path().join(name);
        if !ffmpeg(&source, arguments, &path) {
            eprintln!("skipped {name}: ffmpeg is not here or cannot write it");
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        let (whole, damage) = played(name, bytes.clone());
        assert_eq!(damage, None, "{name}");
        for (cut, least) in cuts(&bytes).into_iter().zip([0.5, 0.2]) {
            let (half, damage) = played(name, cut);
            let share = half.frames() as f64 / whole.frames() as f64;
            assert!((least..=1.0).contains(&share), "{name}: {share}");
            assert!(half.left[..] == whole.left[..half.frames()], "{name}");
            // The last byte of fragments is not of their sound.
            let is_whole = name == "fragments.m4a" && half == whole;
            assert!(damage.is_some() || is_whole, "{name}");
        }
    }
}

#[test]
fn the_name_of_a_file_does_not_matter() {
    let bytes = wav_bytes(&chirp(8_000), WavSample::Int16).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("really-a-wav.mp3");
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(Song::open(&path).unwrap().rate_hz, 8_000);
}

/// A WAV header with these numbers and a little sound after it.
fn wav_header(rate_hz: u32, channels: u16, data_bytes: u32) -> Vec<u8> {
    let mut bytes = wav_bytes(&chirp(8_000), WavSample::Int16).unwrap();
    bytes[22..24].copy_from_slice(&channels.to_le_bytes());
    bytes[24..28].copy_from_slice(&rate_hz.to_le_bytes());
    bytes[28..32].copy_from_slice(&rate_hz.wrapping_mul(2 * u32::from(channels)).to_le_bytes());
    bytes[32..34].copy_from_slice(&channels.wrapping_mul(2).to_le_bytes());
    bytes[4..8].copy_from_slice(&data_bytes.saturating_add(36).to_le_bytes());
    bytes[40..44].copy_from_slice(&data_bytes.to_le_bytes());
    bytes
}

#[test]
fn absurd_headers_are_errors() {
    for (rate_hz, channels) in [(0, 2), (1, 2), (u32::MAX, 2), (44_100, 0), (44_100, u16::MAX)] {
        let error = read_bytes("absurd.wav", wav_header(rate_hz, channels, 4000));
        assert!(error.is_err(), "{rate_hz} Hz, {channels} channels");
    }
}

#[test]
fn a_wav_file_of_more_than_4_gib_is_refused_by_its_kind() {
    let mut bytes = wav_header(8_000, 2, u32::MAX);
    bytes[..4].copy_from_slice(b"RF64");
    let error = read_bytes("long.wav", bytes).expect_err("its sizes are not read");
    assert!(matches!(&error, SoundError::Unrecognized { reason, .. } if reason.contains("RF64")), "{error}");
}

#[test]
fn a_header_that_promises_hours_takes_no_memory() {
    // The header states two and a half hours of 48 kHz stereo; the file holds two seconds.
    let song = read_bytes("promise.wav", wav_header(48_000, 2, u32::MAX - 64)).unwrap();
    assert_eq!(song.frames(), 16_000);
    assert!(song.left.capacity() < 100_000);
}

#[test]
fn a_wav_file_without_a_stated_length_is_read_to_its_end() {
    let whole = wav_bytes(&chirp(8_000), WavSample::Int16).unwrap();
    let song = read_bytes("whole.wav", whole.clone()).unwrap();
    let sized = |riff: u32, data: u32| {
        let mut bytes = whole.clone();
        bytes[4..8].copy_from_slice(&riff.to_le_bytes());
        bytes[40..44].copy_from_slice(&data.to_le_bytes());
        bytes
    };
    // SoX states a count of frames, too, where the samples are no integers.
    let piped = sized(0x7fff_f024, 0x7fff_f000);
    let counted = [&piped[..36], b"fact\x04\0\0\0\0\xfc\xff\x1f", &piped[36..]].concat();
    for bytes in [
        piped,
        counted,
        sized(u32::MAX, u32::MAX),
        sized(64_036, u32::MAX),
        sized(0, 0),
        sized(36, 0),
        sized(64_036, 0),
        sized(0, 64_000),
    ] {
        let start = format!("{:?}", &bytes[..56]);
        let mut reader = SongReader::from_bytes("pipe.wav", bytes).unwrap();
        let read = Song::read(&mut reader, &SongOptions::default(), &Task::new()).unwrap();
        assert_eq!((reader.damage(), read == song), (None, true), "{start}");
        reader.seek(15_000).unwrap();
        assert_eq!(reader.next_block().unwrap().unwrap()[0], song.left[15_000], "{start}");
    }
    let silent = [&sized(48, 0)[..44], b"LIST\x04\0\0\0INFO"].concat();
    assert!(matches!(read_bytes("silent.wav", silent), Err(SoundError::Empty { .. })));
    let (_, damage) = played("cut.wav", sized(3_000_000_036, 3_000_000_000));
    assert!(damage.is_some());
}

#[test]
fn a_song_beyond_the_memory_allowed_is_refused() {
    let bytes = wav_bytes(&chirp(44_100), WavSample::Int16).unwrap();
    let options = SongOptions { max_bytes: 8 * 44_100, ..SongOptions::default() };
    let read = |options: &SongOptions| {
        Song::read(&mut SongReader::from_bytes("long.wav", bytes.clone()).unwrap(), options, &Task::new())
    };
    let error = read(&options).unwrap_err();
    assert!(matches!(error, SoundError::TooLong { .. }));
    assert_eq!(error.to_string(), "long.wav: longer than the 1 s that can be read as a whole");
    let part = SongOptions { start_secs: 0.5, duration_secs: Some(0.25), ..options };
    let song = read(&part).unwrap();
    assert_eq!(song.frames(), 11_025);
    assert!((song.left[0] - chirp(44_100).left[22_050]).abs() < 1e-4);
    for (wrong, start_secs, duration_secs) in [("start", 60.0, None), ("duration", 0.5, Some(0.0))] {
        let error = read(&SongOptions { start_secs, duration_secs, ..SongOptions::default() }).unwrap_err();
        assert!(matches!(&error, SoundError::Setting { what } if what.contains(wrong)), "{wrong}: {error}");
    }
    let resampled = read(&SongOptions { rate_hz: Some(48_000), ..SongOptions::default() }).unwrap();
    assert_eq!((resampled.rate_hz, resampled.frames()), (48_000, 96_000));
}

/// A hundred hours of silence at 8 kHz, mono, in half a megabyte of FLAC: each frame says "65535 times 0".
fn hundred_hours_of_flac() -> Vec<u8> {
    const BLOCK: u64 = 65_535;
    let total = 100 * 3600 * 8000_u64;
    let crc = |bytes: &[u8], width: u32, polynomial: u32| {
        bytes.iter().fold(0_u32, |crc, &byte| {
            (0..8).fold(crc ^ (u32::from(byte) << (width - 8)), |crc, _| {
                let carry = (crc >> (width - 1)) & 1;
                ((crc << 1) ^ (carry * polynomial)) & ((1 << width) - 1)
            })
        })
    };
    let mut bytes = b"fLaC\x80\0\0\x22\xff\xff\xff\xff\0\0\0\0\0\0".to_vec();
    // Rate, channels − 1, bits − 1 and the number of samples, in 20, 3, 5 and 36 bits.
    bytes.extend(((8000_u64 << 44) | (7 << 36) | total).to_be_bytes());
    bytes.extend([0; 16]);
    for n in 0..(total / BLOCK) as u32 {
        let mut frame = vec![0xff, 0xf8, 0x74, 0x02];
        frame.extend(char::from_u32(n).unwrap_or('\0').to_string().bytes());
        frame.extend((BLOCK as u16 - 1).to_be_bytes());
        frame.push(crc(&frame, 8, 0x07) as u8);
        frame.extend([0, 0]);
        let check = crc(&frame, 16, 0x8005) as u16;
        frame.extend(check.to_be_bytes());
        bytes.extend(frame);
    }
    bytes
}

#[test]
fn a_hundred_hours_of_silence_stream_and_are_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let wav = folder.path().join("long.wav");
    let mut header = wav_header(8000, 1, 2_880_000_000);
    header.truncate(44);
    std::fs::write(&wav, header).unwrap();
    // The file is sparse: nothing but its length is on the disk.
    std::fs::File::options().write(true).open(&wav).unwrap().set_len(44 + 2_880_000_000).unwrap();
    let flac = hundred_hours_of_flac();
    assert!(flac.len() < 1 << 20);
    let open: [&dyn Fn() -> SongReader; 2] =
        [&|| SongReader::open(&wav).unwrap(), &|| SongReader::from_bytes("long.flac", flac.clone()).unwrap()];
    for open in open {
        let mut reader = open();
        let hours = reader.total_frames().unwrap() as f64 / 8000.0 / 3600.0;
        assert!((49.9..100.1).contains(&hours), "{hours}");
        // Even far into the song, only one packet is in memory.
        let far = reader.total_frames().unwrap() - 100_000;
        reader.seek(far).unwrap();
        let mut frames = 0;
        while let Some(block) = reader.next_block().unwrap() {
            assert!(block.len() <= 2 * 65_535 && block.iter().all(|x| x.abs() < 0.01));
            frames += block.len() as u64 / 2;
        }
        assert!(frames.abs_diff(100_000) <= 65_535, "{frames}");
        let options = SongOptions { max_bytes: 1 << 24, ..SongOptions::default() };
        let error = Song::read(&mut open(), &options, &Task::new()).unwrap_err();
        assert!(matches!(error, SoundError::TooLong { .. }), "{error}");
    }
}

mod any_bytes {
    use super::*;
    use proptest::prelude::*;

    fn starts() -> impl Strategy<Value = Vec<u8>> {
        let folder = shared("audio");
        let mut starts: Vec<Vec<u8>> = vec![Vec::new(), wav_header(44_100, 2, 4000)];
        if let Some(folder) = folder {
            for name in ["dubstep.flac", "dubstep.mp3", "dubstep.ogg"] {
                let bytes = std::fs::read(folder.join(name)).expect("the file is listed");
                starts.push(bytes[..bytes.len().min(30_000)].to_vec());
            }
        }
        proptest::sample::select(starts)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn never_panic(
            start in starts(),
            noise in proptest::collection::vec(any::<u8>(), 0..400),
            flips in proptest::collection::vec((any::<u16>(), any::<u8>()), 0..40),
        ) {
            let mut bytes = start;
            bytes.extend(noise);
            let len = bytes.len();
            for (at, value) in flips {
                if let Some(byte) = bytes.get_mut(usize::from(at) % len.max(1)) {
                    *byte = value;
                }
            }
            if let Ok(song) = read_bytes("noise", bytes) {
                prop_assert!(song.frames() < 100_000_000);
                prop_assert!(song.left.iter().all(|x| x.is_finite()));
            }
        }
    }
}

#[test]
fn a_header_that_its_reader_takes_for_impossible_is_damage() {
    // The reader of Ogg asserts that 2^32 is more than four, in 32 bits.
    let words = [(0x0056_4342, 24), (32, 16), (4, 24), (0, 1), (0, 1), (1, 5), (1, 5), (1, 5), (1, 5)];
    let book = [&words[..], &[(1, 4), (0, 32), (0, 32), (0, 4), (0, 1), (0, 1)]].concat();
    let error = read_bytes("x.ogg", vorbis_of_books(1, &book)).expect_err("there is no sound");
    assert!(matches!(error, SoundError::Damaged { .. }), "{error}");
}
