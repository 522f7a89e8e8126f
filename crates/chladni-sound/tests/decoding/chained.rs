//! Ogg files that are several ones behind each other, as internet radio stations record them.

use super::*;

/// Songs of these many frames, encoded one by one and as one file; `None` without ffmpeg.
fn chained(codec: &str, lengths: &[usize]) -> Option<(Vec<u8>, Vec<Song>)> {
    let folder = tempfile::tempdir().unwrap();
    let (mut file, mut songs) = (Vec::new(), Vec::new());
    for (i, &frames) in lengths.iter().enumerate() {
        let mut song = chirp(48_000);
        song.left.rotate_left(20_000 * i);
        song.left.truncate(frames);
        song.right.truncate(frames);
        let (source, target) = (folder.path().join("link.wav"), folder.path().join(format!("{i}.ogg")));
        write_wav(&source, &song, WavSample::Int16).unwrap();
        if !ffmpeg(&source, &["-c:a", codec, "-f", "ogg", "-serial_offset", &(i + 1).to_string()], &target) {
            return None;
        }
        let bytes = std::fs::read(&target).unwrap();
        songs.push(read_bytes("link.ogg", bytes.clone()).unwrap());
        file.extend(bytes);
    }
    Some((file, songs))
}

#[test]
fn one_song_behind_the_other_in_one_file_is_read_to_the_end() {
    for codec in ["libopus", "libvorbis"] {
        let lengths = [90_000, 40_000, 75_001];
        let Some((file, songs)) = chained(codec, &lengths) else {
            eprintln!("skipped: no ffmpeg with {codec} here");
            continue;
        };
        let mut reader = SongReader::from_bytes("chained.ogg", file).unwrap();
        let whole = Song::read(&mut reader, &SongOptions::default(), &Task::new()).unwrap();
        let truth = songs.iter().flat_map(|song| song.left.iter().copied()).collect::<Vec<f32>>();
        assert_eq!(songs.iter().map(Song::frames).collect::<Vec<_>>(), lengths, "{codec}");
        assert_eq!((whole.frames(), reader.damage()), (truth.len(), None), "{codec}");
        assert!(whole.left == truth, "{codec}");
        assert_eq!(reader.total_frames(), Some(truth.len() as u64), "{codec}");
        // Forth and back, within one of them and from one to another.
        for frame in [200_000, 100_000, 50_000, 0, 89_990, 90_000, 129_999, 130_001, 10, 205_000] {
            reader.seek(frame).unwrap();
            let mut left: Vec<f32> = Vec::new();
            while left.len() < 1000 {
                let Some(block) = reader.next_block().unwrap() else { break };
                left.extend(block.iter().step_by(2));
            }
            left.truncate(1000);
            let expected = &truth[frame as usize..(frame as usize + 1000).min(truth.len())];
            assert_eq!(left.len(), expected.len(), "{codec} from {frame}");
            let worst = left.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.02, "{codec} from {frame}: {worst}");
        }
        reader.seek(300_000).unwrap();
        assert!(reader.next_block().unwrap().is_none(), "{codec}");
        reader.seek(89_000).unwrap();
        assert!(reader.next_block().unwrap().is_some(), "{codec}");
    }
}
