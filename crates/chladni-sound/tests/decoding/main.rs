//! Decodes real files, generated files and damaged files.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod chained;
mod damaged;

use std::path::Path;
use std::process::Command;

use chladni_sound::{Song, SongOptions, SongReader, SoundError, WavSample, wav_bytes, write_wav};
use chladni_task::Task;
use chladni_testdata::shared;

fn read_bytes(name: &str, bytes: Vec<u8>) -> Result<Song, SoundError> {
    Song::read(&mut SongReader::from_bytes(name, bytes)?, &SongOptions::default(), &Task::new())
}

/// Two seconds of a stereo chirp, which no shift maps to itself.
fn chirp(rate_hz: u32) -> Song {
    let wave = |f0: f64, slope: f64| {
        (0..2 * rate_hz)
            .map(|n| {
                let t = f64::from(n) / f64::from(rate_hz);
                (0.5 * (std::f64::consts::TAU * (f0 * t + slope * t * t)).sin()) as f32
            })
            .collect()
    };
    Song { rate_hz, left: wave(200.0, 700.0), right: wave(900.0, -150.0) }
}

/// The shift of `b` against `a` in frames, within ±`reach`, and the relative error that remains.
fn alignment(a: &[f32], b: &[f32], reach: i64) -> (i64, f64) {
    let error_at = |shift: i64| {
        let (mut error, mut power) = (0.0, 0.0);
        for n in (reach as usize)..(a.len().min(b.len()).saturating_sub(reach as usize)) {
            let (x, y) = (f64::from(a[n]), f64::from(b[(n as i64 + shift) as usize]));
            error += (x - y).powi(2);
            power += x * x;
        }
        (error / power).sqrt()
    };
    let errors = (-reach..=reach).map(|shift| (shift, error_at(shift)));
    errors.min_by(|a, b| a.1.total_cmp(&b.1)).expect("at least one shift")
}

#[test]
fn what_the_manifest_lists_is_read_as_listed() {
    let listed = [
        ("sample.wav", 44_100, 1, 2.800),
        ("techno_loop.mp3", 44_100, 2, 30.720),
        ("dubstep.flac", 44_100, 2, 6.850),
        ("impulses_1second_22050_st.ogg", 22_050, 2, 10.0),
        ("lmms24bit.wav", 44_100, 2, 1.712),
        ("audacity32bit.wav", 44_100, 1, 3.0),
        ("audacity32bit_int.wav", 44_100, 2, 0.511),
        ("audacity24bit_level5.flac", 44_100, 1, 3.0),
        ("4channels.wav", 44_100, 4, 5.0),
        ("music.ogg", 44_100, 2, 69.329),
    ];
    for (name, rate_hz, channels, secs) in listed {
        let Some(path) = shared(&format!("audio/{name}")) else { return };
        let mut reader = SongReader::open(&path).unwrap();
        assert_eq!((reader.rate_hz(), reader.channels()), (rate_hz, channels), "{name}");
        let song = Song::read(&mut reader, &SongOptions::default(), &Task::new()).unwrap();
        assert!((song.duration_secs() - secs).abs() < 0.06, "{name}: {}", song.duration_secs());
    }
}

#[test]
fn four_codecs_give_one_song() {
    let Some(wav) = shared("audio/dubstep.wav") else { return };
    let truth = Song::open(&wav).unwrap();
    let flac = Song::open(&wav.with_extension("flac")).unwrap();
    assert_eq!(truth, flac);
    // The MP3 has no LAME tag: the encoder's own delay (576 frames, 13 ms) stays.
    for (extension, delay, most_error) in [("mp3", 576, 0.25), ("ogg", 0, 0.25)] {
        let lossy = Song::open(&wav.with_extension(extension)).unwrap();
        let (shift, error) = alignment(&truth.left[..60_000], &lossy.left[..60_000], 1500);
        eprintln!(
            "dubstep.{extension}: shifted by {shift} frames, relative error {error:.3}, {} frames",
            lossy.frames()
        );
        assert!((shift - delay).abs() <= 44 && error < most_error, "{extension}: {shift} {error}");
    }
}

#[test]
fn left_and_right_are_never_swapped() {
    let Some(path) = shared("audio/impulses_left_right_offset.wav") else { return };
    let song = Song::open(&path).unwrap();
    let first = |channel: &[f32]| channel.iter().position(|x| x.abs() > 0.3).unwrap() as f64 / 44_100.0;
    assert!((first(&song.left) - 0.5).abs() < 0.01, "{}", first(&song.left));
    assert!((first(&song.right) - 1.0).abs() < 0.01);
}

#[test]
fn wav_files_come_back_as_they_were_written() {
    let song = chirp(44_100);
    let float = read_bytes("float.wav", wav_bytes(&song, WavSample::Float32).unwrap()).unwrap();
    assert_eq!(float, song);
    let int = read_bytes("int.wav", wav_bytes(&song, WavSample::Int16).unwrap()).unwrap();
    let worst = int.left.iter().zip(&song.left).fold(0.0f32, |a, (x, y)| a.max((x - y).abs()));
    assert!(worst <= 0.5 / 32768.0 + 1e-9, "{worst}");
    let again = read_bytes("int.wav", wav_bytes(&int, WavSample::Int16).unwrap()).unwrap();
    assert_eq!(again, int);
}

#[test]
fn every_format_that_ffmpeg_writes_comes_back_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let song = chirp(44_100);
    let source = folder.path().join("source.wav");
    write_wav(&source, &song, WavSample::Float32).unwrap();
    let fragments = "frag_keyframe+empty_moov+delay_moov";
    let formats: [(&str, &[&str], i64, f64); 15] = [
        ("u8.wav", &["-c:a", "pcm_u8"], 0, 0.02),
        ("s24.wav", &["-c:a", "pcm_s24le"], 0, 1e-5),
        ("s32.wav", &["-c:a", "pcm_s32le"], 0, 1e-6),
        ("f64.wav", &["-c:a", "pcm_f64le"], 0, 1e-6),
        ("ms.wav", &["-c:a", "adpcm_ms"], 0, 0.05),
        ("ima.wav", &["-c:a", "adpcm_ima_wav"], 0, 0.05),
        ("s16.aiff", &["-c:a", "pcm_s16be"], 0, 1e-3),
        ("s16.flac", &["-c:a", "flac"], 0, 1e-3),
        ("alac.m4a", &["-c:a", "alac"], 0, 1e-3),
        ("aac.m4a", &["-c:a", "aac", "-b:a", "192k"], 0, 0.05),
        ("fragments.m4a", &["-c:a", "aac", "-b:a", "192k", "-movflags", fragments], 0, 0.05),
        ("lame.mp3", &["-c:a", "libmp3lame", "-b:a", "192k"], 0, 0.05),
        ("vorbis.ogg", &["-c:a", "libvorbis", "-q:a", "6"], 0, 0.05),
        ("flac.ogg", &["-c:a", "flac"], 0, 1e-3),
        ("vorbis.mka", &["-c:a", "libvorbis", "-q:a", "6"], 0, 0.05),
    ];
    for (name, arguments, most_frames, most_error) in formats {
        let path = folder.path().join(name);
        if !ffmpeg(&source, arguments, &path) {
            eprintln!("skipped {name}: ffmpeg is not here or cannot write it");
            continue;
        }
        let read = Song::open(&path).unwrap_or_else(|e| panic!("{e}"));
        let (shift, error) = alignment(&song.left, &read.left, 1300);
        eprintln!(
            "{name}: shifted by {shift}, relative error {error:.6}, {} frames of {}",
            read.frames(),
            song.frames()
        );
        assert!(shift.abs() <= most_frames && error <= most_error, "{name}: {shift} {error}");
        assert!(read.frames().abs_diff(song.frames()) <= 1152, "{name}: {}", read.frames());
        if !name.ends_with("mka") {
            seeks_land_exactly(&path, &read, 2e-3);
        }
    }
}

#[test]
fn matroska_has_a_length_and_is_sought_to_a_millisecond() {
    let folder = tempfile::tempdir().unwrap();
    let (song, source) = (chirp(48_000), folder.path().join("source.wav"));
    write_wav(&source, &song, WavSample::Float32).unwrap();
    for (name, codec) in [("opus.webm", "libopus"), ("vorbis.mka", "libvorbis"), ("aac.mka", "aac")] {
        let path = folder.path().join(name);
        // Four clusters: seeks look up the later ones.
        if !ffmpeg(&source, &["-c:a", codec, "-cluster_time_limit", "600"], &path) {
            eprintln!("skipped {name}: ffmpeg is not here or cannot write it");
            continue;
        }
        let mut reader = SongReader::open(&path).unwrap();
        let stated = reader.total_frames().unwrap();
        assert!(stated.abs_diff(96_000) < 2_500, "{name}: {stated}");
        let whole = Song::open(&path).unwrap();
        for frame in [48_000, 75_000, 0] {
            reader.seek(frame as u64).unwrap();
            let mut left = Vec::new();
            while left.len() < 8000 {
                left.extend(reader.next_block().unwrap().unwrap().iter().step_by(2));
            }
            let (shift, error) = alignment(&whole.left[frame..frame + 8000], &left[..8000], 1300);
            assert!(shift.abs() <= 48 && error < 0.1, "{name} at {frame}: {shift} {error}");
        }
        reader.seek(200_000).unwrap();
        assert!(reader.next_block().unwrap().is_none(), "{name}");
    }
}

#[test]
fn adts_that_is_whole_misses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source.wav");
    // Noise, so that frames differ in length: what the reader guesses from their mean is too long.
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 25) as f32 - 0.25
    };
    let left: Vec<f32> = (0..60 * 44_100).map(|_| noise()).collect();
    write_wav(&source, &Song { rate_hz: 44_100, right: left.clone(), left }, WavSample::Int16).unwrap();
    for rate in ["64k", "96k", "128k"] {
        let path = folder.path().join(format!("{rate}.aac"));
        if !ffmpeg(&source, &["-c:a", "aac", "-b:a", rate, "-f", "adts"], &path) {
            return eprintln!("skipped: ffmpeg is not here or cannot write ADTS");
        }
        let mut reader = SongReader::open(&path).unwrap();
        while reader.next_block().unwrap().is_some() {}
        assert_eq!(reader.damage(), None, "{rate}");
    }
}

/// The header of an MP4 has no room for rates above 65535 Hz.
#[test]
fn aac_of_a_high_rate_is_read_from_mp4() {
    let folder = tempfile::tempdir().unwrap();
    let (source, path) = (folder.path().join("source.wav"), folder.path().join("aac.m4a"));
    let truth = chirp(96_000);
    write_wav(&source, &truth, WavSample::Int16).unwrap();
    if !ffmpeg(&source, &["-c:a", "aac", "-b:a", "256k"], &path) {
        return eprintln!("skipped: no ffmpeg that writes AAC here");
    }
    let song = Song::open(&path).unwrap();
    assert!(song.rate_hz == 96_000 && song.frames().abs_diff(truth.frames()) < 1024, "{}", song.frames());
    let (shift, error) = alignment(&truth.left[..20_000], &song.left[..20_000], 100);
    assert!(shift == 0 && error < 0.1, "{shift} {error}");
}

/// The clock of an MP4 need not tick once a frame: with HE-AAC it ticks twice.
#[test]
fn an_edit_list_counts_ticks_of_the_clock_and_not_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (source, path) = (folder.path().join("source.wav"), folder.path().join("aac.m4a"));
    write_wav(&source, &chirp(44_100), WavSample::Int16).unwrap();
    if !ffmpeg(&source, &["-c:a", "aac", "-b:a", "192k"], &path) {
        return eprintln!("skipped: no ffmpeg that writes AAC here");
    }
    let mut bytes = std::fs::read(&path).unwrap();
    halve_clock(&mut bytes);
    let slow = folder.path().join("slow.m4a");
    std::fs::write(&slow, bytes).unwrap();
    let (whole, song) = (Song::open(&path).unwrap(), Song::open(&slow).unwrap());
    assert_eq!(SongReader::open(&slow).unwrap().total_frames(), Some(whole.frames() as u64));
    assert!(song == whole, "{} frames of {}", song.frames(), whole.frames());
    seeks_land_exactly(&slow, &whole, 2e-3);
}

/// Lets the clock of the sound in an MP4 of one track tick half as often.
fn halve_clock(mp4: &mut [u8]) {
    let body = |mp4: &[u8], kind: &[u8]| 4 + mp4.windows(4).position(|name| name == kind).unwrap();
    let word = |mp4: &[u8], at: usize| u32::from_be_bytes(mp4[at..at + 4].try_into().unwrap());
    let mut fields = vec![body(mp4, b"mdhd") + 12, body(mp4, b"mdhd") + 16];
    for (list, width, field) in [(body(mp4, b"elst"), 12, 4), (body(mp4, b"stts"), 8, 4)] {
        fields.extend((0..word(mp4, list + 4) as usize).map(|entry| list + 8 + width * entry + field));
    }
    for at in fields {
        let ticks = word(mp4, at);
        assert!(ticks.is_multiple_of(2), "{ticks} ticks");
        mp4[at..at + 4].copy_from_slice(&(ticks / 2).to_be_bytes());
    }
}

#[test]
fn an_mp3_whose_length_is_guessed_too_short_is_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let (source, path) = (folder.path().join("noise.wav"), folder.path().join("noise.mp3"));
    // A loud second and quiet ones: without a table of contents, the length is guessed from the first frames.
    let mut noise = 1u32;
    let mut next = |n: u32| {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if n < 48_000 { (noise >> 16) as f32 / 65_536.0 - 0.5 } else { 0.0 }
    };
    let left: Vec<f32> = (0..6 * 48_000).map(&mut next).collect();
    write_wav(&source, &Song { rate_hz: 48_000, right: left.clone(), left }, WavSample::Int16).unwrap();
    let options = ["-c:a", "libmp3lame", "-q:a", "0", "-write_xing", "0", "-id3v2_version", "0"];
    if !ffmpeg(&source, &options, &path) {
        return eprintln!("skipped: no ffmpeg that writes MP3 here");
    }
    let mut reader = SongReader::open(&path).unwrap();
    assert!(reader.total_frames().unwrap() < 4 * 48_000, "it is guessed");
    let song = Song::read(&mut reader, &SongOptions::default(), &Task::new()).unwrap();
    assert!((6.0..6.1).contains(&song.duration_secs()), "{} s", song.duration_secs());
}

fn ffmpeg(source: &Path, arguments: &[&str], target: &Path) -> bool {
    Command::new("ffmpeg")
        .args(["-v", "error", "-y", "-i"])
        .arg(source)
        .args(arguments)
        .arg(target)
        .output()
        .is_ok_and(|output| output.status.success())
}

/// After a seek, the samples are those that a reading from the start has at the same place.
fn seeks_land_exactly(path: &Path, whole: &Song, most_error: f32) {
    let mut reader = SongReader::open(path).unwrap();
    for frame in [50_000usize, 0, 70_001, 31_337] {
        reader.seek(frame as u64).unwrap();
        let mut left = Vec::new();
        while left.len() < 4000 {
            let Some(block) = reader.next_block().unwrap() else { break };
            left.extend(block.iter().step_by(2));
        }
        let worst = left
            .iter()
            .zip(&whole.left[frame..])
            .fold(0.0f32, |a, (x, y): (&f32, &f32)| a.max((x - y).abs()));
        assert!(left.len() >= 4000 && worst < most_error, "{} at {frame}: off by {worst}", path.display());
    }
}

/// libopus codes speech, speech with treble, and music in three different modes (SILK, hybrid, CELT), in
/// packets of 2.5 to 60 ms.
#[test]
fn opus_is_what_libopus_decodes() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source.wav");
    write_wav(&source, &chirp(48_000), WavSample::Int16).unwrap();
    let manners: [(&str, &[&str]); 6] = [
        ("silk.opus", &["-application", "voip", "-b:a", "12k", "-ac", "1"]),
        ("hybrid.opus", &["-application", "voip", "-b:a", "32k"]),
        ("celt.opus", &["-b:a", "128k"]),
        ("long.opus", &["-b:a", "48k", "-frame_duration", "60"]),
        ("short.opus", &["-application", "lowdelay", "-frame_duration", "2.5", "-b:a", "160k"]),
        ("celt.mka", &["-b:a", "128k"]),
    ];
    for (name, arguments) in manners {
        let path = folder.path().join(name);
        let decoded = folder.path().join("decoded.wav");
        let encoded = ffmpeg(&source, &[&["-c:a", "libopus"], arguments].concat(), &path);
        if !encoded || !ffmpeg_decodes_opus(&path, &decoded) {
            eprintln!("skipped {name}: no ffmpeg with libopus here");
            return;
        }
        let (ours, theirs) = (Song::open(&path).unwrap(), Song::open(&decoded).unwrap());
        assert_eq!(ours.rate_hz, 48_000);
        let (shift, error) = alignment(&theirs.left, &ours.left, 400);
        eprintln!("{name}: shifted by {shift}, error {error:.2e}, {} of {}", ours.frames(), theirs.frames());
        // The samples of libopus are rounded to 16 bits.
        assert!(shift == 0 && error < 1e-3, "{name}: {shift} {error}");
        assert!(ours.frames().abs_diff(theirs.frames()) <= 960, "{name}: {}", ours.frames());
        if name.ends_with("opus") {
            assert_eq!(ours.frames(), theirs.frames(), "{name}");
            // SILK predicts from earlier samples: after 0.15 s, an error of 3 % may remain.
            seeks_land_exactly(&path, &ours, 0.03);
        }
    }
}

#[test]
fn surround_keeps_its_sides() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source.wav");
    write_wav(&source, &chirp(48_000), WavSample::Int16).unwrap();
    // The left channel goes only to the rear left speaker, the right one only to the front right.
    let pan = "pan=5.1|FL=0*c0|FR=c1|FC=0*c0|LFE=0*c0|BL=c0|BR=0*c0";
    let truth = chirp(48_000);
    let likeness = |a: &[f32], b: &[f32]| {
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(x, y)| f64::from(x * y)).sum::<f64>();
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    };
    for (name, codec) in [("opus.opus", "libopus"), ("opus.mka", "libopus"), ("pcm.mka", "pcm_s16le")] {
        let path = folder.path().join(name);
        if !ffmpeg(&source, &["-af", pan, "-c:a", codec, "-b:a", "320k"], &path) {
            eprintln!("skipped {name}: ffmpeg is not here or cannot write it");
            continue;
        }
        let song = Song::open(&path).unwrap();
        for (ours, theirs) in [(&song.left, &truth.left), (&song.right, &truth.right)] {
            assert!(likeness(ours, theirs) > 0.98, "{name}: {}", likeness(ours, theirs));
        }
    }
}

#[test]
fn surround_aac_is_refused_with_advice_that_helps() {
    let folder = tempfile::tempdir().unwrap();
    let (source, path) = (folder.path().join("source.wav"), folder.path().join("surround.m4a"));
    write_wav(&source, &chirp(48_000), WavSample::Int16).unwrap();
    if !ffmpeg(&source, &["-ac", "6", "-c:a", "aac"], &path) {
        return eprintln!("skipped: no ffmpeg that writes AAC here");
    }
    let error = Song::open(&path).expect_err("it has six channels").to_string();
    assert!(error.contains("holds multichannel or non-LC AAC sound"), "{error}");
    assert!(error.ends_with("convert it to stereo AAC-LC, FLAC or WAV"), "{error}");
}

#[test]
fn tags_name_the_song() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source.wav");
    write_wav(&source, &chirp(44_100), WavSample::Int16).unwrap();
    assert_eq!(SongReader::open(&source).unwrap().title(), None);
    let (title, artist) = (["-metadata", "title=Slow Tide"], ["-metadata", "artist=No \u{f6}ne"]);
    for name in ["tagged.mp3", "tagged.flac", "tagged.ogg", "tagged.m4a"] {
        let path = folder.path().join(name);
        if !ffmpeg(&source, &[title, artist].concat(), &path) {
            eprintln!("skipped {name}: ffmpeg is not here or cannot write it");
            continue;
        }
        let found = SongReader::open(&path).unwrap().title();
        assert_eq!(found.as_deref(), Some("No \u{f6}ne – Slow Tide"), "{name}");
        let tags = SongReader::open(&path).unwrap().tags();
        assert_eq!([tags.title.as_deref(), tags.artist.as_deref()], [Some("Slow Tide"), Some("No \u{f6}ne")]);
        assert!(ffmpeg(&source, &title, &path));
        assert_eq!(SongReader::open(&path).unwrap().title().as_deref(), Some("Slow Tide"), "{name}");
    }
}

/// Makes ffmpeg decode with libopus instead of its own decoder.
fn ffmpeg_decodes_opus(opus: &Path, wav: &Path) -> bool {
    Command::new("ffmpeg")
        .args(["-v", "error", "-y", "-c:a", "libopus", "-i"])
        .arg(opus)
        .args(["-c:a", "pcm_s16le"])
        .arg(wav)
        .output()
        .is_ok_and(|output| output.status.success())
}
