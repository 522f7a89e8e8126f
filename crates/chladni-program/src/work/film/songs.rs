//! The songs of a film: read, tracked, and laid one after the other as they were heard.

use std::sync::Arc;

use chladni_harmonics::available_memory;
use chladni_music::{BeatReading, ClockTrack, Stretch};
use chladni_sound::{Beats, SEAM_SECS, Song, StereoResampler, crossfade_gain, track_beats};

use crate::work::sand::BEFORE_SECS;
use crate::work::{Error, Hearing, KnownSong, Warning, Watcher, read_beats, source};

/// Sampling rate of a film's sound without any song.
const SILENT_RATE_HZ: u32 = 44_100;
/// The highest sampling rate of a film's sound: AAC knows no higher one.
const MOST_RATE_HZ: u32 = 96_000;

/// All songs of a show that its film needs.
pub struct Songs {
    /// By their numbers; none of those that are not heard. Of those that are over before the film begins only the
    /// beats are known.
    songs: Vec<Option<KnownSong>>,
    /// Numbers and names of songs that are over before the film begins, whose beats it still counts.
    over: Vec<(usize, String)>,
    readings: Vec<BeatReading>,
    heard: Vec<Stretch>,
    start_secs: f64,
    film_secs: f64,
}

impl Songs {
    /// Reads those that are heard in `range`: where the film begins, and how much of the show is filmed. Beats are those
    /// of `clock` while it was followed.
    ///
    /// # Errors
    /// The first song that cannot be read, with its name, and the first for which there is no memory beside the others.
    pub fn open(
        names: &[(String, BeatReading)],
        mut heard: Vec<Stretch>,
        show_secs: Option<f64>,
        range: (f64, Option<f64>),
        clock: &ClockTrack,
        watcher: &impl Watcher,
    ) -> Result<Self, Error> {
        if heard.is_empty() {
            heard.push(Stretch {
                at_secs: 0.0,
                song: Some(0),
                song_secs: 0.0,
                playing: true,
                crossfade_secs: 0.0,
            });
        }
        let (start_secs, wanted_secs) = range;
        let end_secs = wanted_secs.map_or(f64::INFINITY, |secs| start_secs + secs);
        // A jump fades from the sound before it, and sand has been lying for a while.
        let over = |next: &Stretch| next.at_secs + (0.5 * next.crossfade_secs).max(BEFORE_SECS);
        let overs = heard.iter().skip(1).map(over).chain([f64::INFINITY]);
        let reached = heard.iter().zip(overs).filter(|(stretch, over_secs)| {
            stretch.at_secs - 0.5 * stretch.crossfade_secs < end_secs && *over_secs > start_secs
        });
        let numbers: Vec<usize> = reached.filter_map(|(stretch, _)| stretch.song).collect();
        let film_secs = show_secs.map(|show_secs| end_secs.min(show_secs) - start_secs);
        let mut left_bytes = source::most_bytes_of_all(available_memory(), film_secs);
        let mut songs = Vec::new();
        for (number, (name, _)) in names.iter().enumerate() {
            let song = if numbers.contains(&number) {
                let song = Arc::new(source::long_song_within(left_bytes, name, watcher)?);
                left_bytes = left_bytes.saturating_sub(8 * song.frames());
                Some(KnownSong::new(song)?)
            } else {
                None
            };
            songs.push(song);
        }
        let counted = counted_before(start_secs, &heard, clock);
        let over = (0..).zip(names).filter(|(song, _)| counted.contains(song) && !numbers.contains(song));
        let over = over.map(|(song, (name, _))| (song, name.clone())).collect();
        let last = heard.last().copied();
        let length = |song: usize| songs.get(song)?.as_ref().map(|known| known.song.duration_secs());
        let last_song_secs = last.and_then(|last| Some(last.at_secs + length(last.song?)? - last.song_secs));
        let show_secs = show_secs.or(last_song_secs).unwrap_or(0.0);
        let film_secs = end_secs.min(show_secs) - start_secs;
        if film_secs <= 0.0 {
            return Err(Error::Input(format!("what is heard ends after {show_secs:.1} s")));
        }
        let readings = names.iter().map(|(_, reading)| *reading).collect();
        Ok(Self { songs, over, readings, heard, start_secs, film_secs })
    }

    /// How long the film is.
    pub fn film_secs(&self) -> f64 {
        self.film_secs
    }

    /// A number that other songs do not have, from a thousand samples of all that are heard.
    pub fn draw(&self) -> u64 {
        let songs = self.songs.iter().flatten().map(|known| &known.song.left);
        let samples = songs.flat_map(|left| left.iter().step_by(left.len() / 1000 + 1));
        samples.fold(0, |draw: u64, sample| draw.rotate_left(5).wrapping_add(u64::from(sample.to_bits())))
    }

    /// Which song is heard when.
    pub fn stretches(&self) -> &[Stretch] {
        &self.heard
    }

    /// Finds the beats of each, and of those that are over before the film begins.
    ///
    /// # Errors
    /// Cancelled; a song that is heard whose rate no beat can be tracked at.
    pub fn track_beats(&mut self, watcher: &impl Watcher) -> Result<(), Error> {
        for (known, reading) in self.songs.iter_mut().zip(&self.readings) {
            let Some(known) = known else { continue };
            let beats = watcher.watch("tracking the beat", |task| track_beats(&known.song, task));
            known.beats = Some(read_beats(&beats?, *reading));
        }
        self.count_those_over(watcher)
    }

    /// Finds the beats of the songs that are over before the film, one after the other, since their samples are many. One
    /// that cannot be read any more is not counted, with a warning: nothing else of it is in the film.
    ///
    /// # Errors
    /// Cancelled.
    fn count_those_over(&mut self, watcher: &impl Watcher) -> Result<(), Error> {
        for (number, name) in &self.over {
            let beats = match beats_of(name, watcher) {
                Ok(beats) => beats,
                Err(Error::Cancelled) => return Err(Error::Cancelled),
                Err(error) => {
                    watcher.warn(Warning::Plain(format!("{error}: its beats are not counted")));
                    continue;
                }
            };
            let mut known = KnownSong::of_loudness(Arc::default(), 0.0);
            known.beats = self.readings.get(*number).map(|reading| read_beats(&beats, *reading));
            if let Some(place) = self.songs.get_mut(*number) {
                *place = Some(known);
            }
        }
        Ok(())
    }

    /// Tempo and confidence of the song that the film begins with.
    pub fn tempo(&self) -> (f64, f64) {
        let begun = self.heard.partition_point(|stretch| stretch.at_secs <= self.start_secs);
        let song = self.heard.get(begun.saturating_sub(1)).and_then(|stretch| stretch.song);
        let beats: Option<&Beats> = song.and_then(|song| self.songs.get(song)?.as_ref()?.beats.as_ref());
        beats.map_or((0.0, 0.0), |beats| (beats.tempo_bpm, beats.confidence))
    }

    /// Hands them over.
    pub fn tell(&self, hearing: &mut Hearing) {
        for (number, known) in self.songs.iter().enumerate() {
            if let Some(known) = known {
                hearing.know(number, known.clone());
            }
        }
    }

    /// The sound of the film, at the highest rate of its songs up to 96 kHz: pauses are silent, and so is live input.
    ///
    /// # Errors
    /// A song that cannot be resampled to that rate.
    pub fn sound(&self) -> Result<Song, Error> {
        let audible = |known: &&KnownSong| known.song.frames() > 0;
        let rate_hz = self.songs.iter().flatten().filter(audible).map(|known| known.song.rate_hz).max();
        let rate_hz = rate_hz.map_or(SILENT_RATE_HZ, |rate_hz| rate_hz.min(MOST_RATE_HZ));
        let frames = |secs: f64| (secs * f64::from(rate_hz)).round() as usize;
        let silence = vec![0.0; frames(self.film_secs)];
        let mut sound = Song { rate_hz, left: silence.clone(), right: silence };
        let sounding = self.sounding();
        let breaks = sounding.windows(2).filter(|pair| !fades(&pair[0], &pair[1]));
        let breaks_secs: Vec<f64> = breaks.map(|pair| pair[1].at_secs).collect();
        let ends = sounding.iter().skip(1).map(|next| (next.at_secs, next.crossfade_secs));
        let ends = ends.chain([(f64::INFINITY, 0.0)]);
        let mut played: Vec<_> = sounding.iter().zip(ends).filter(|(stretch, _)| stretch.playing).collect();
        // Song by song, so that only one is held at another rate than its own.
        played.sort_by_key(|(stretch, _)| stretch.song);
        let mut resampled: Option<(usize, Arc<Song>)> = None;
        for (stretch, (end_secs, fade_out_secs)) in played {
            let known = stretch.song.and_then(|number| Some((number, self.songs.get(number)?.as_ref()?)));
            let Some((number, known)) = known.filter(|(_, known)| audible(known)) else { continue };
            let before = resampled.take().filter(|(of, _)| *of == number);
            let (_, song) = match before {
                Some(before) => resampled.insert(before),
                None => resampled.insert((number, at_rate(&known.song, rate_hz)?)),
            };
            let begin_secs = stretch.at_secs - 0.5 * stretch.crossfade_secs;
            let over_secs = end_secs + 0.5 * fade_out_secs;
            // No fade reaches over a leap, a pause or live input.
            let broken = breaks_secs.partition_point(|secs| *secs <= stretch.at_secs);
            let (before, after) = breaks_secs.split_at(broken);
            let from_secs = before.last().map_or(begin_secs, |secs| begin_secs.max(*secs));
            let from_secs = from_secs.max(self.start_secs);
            let to_secs = after.first().map_or(over_secs, |secs| over_secs.min(*secs));
            let to_secs = to_secs.min(self.start_secs + self.film_secs);
            if to_secs <= from_secs {
                continue;
            }
            let from = frames(from_secs - self.start_secs).min(sound.left.len());
            let to = frames(to_secs - self.start_secs).min(sound.left.len());
            let begin = (stretch.song_secs_at(from_secs) * f64::from(rate_hz)).round() as i64;
            let end = begin + (to - from) as i64;
            let [mut left, mut right] = [vec![0.0; to - from], vec![0.0; to - from]];
            song.window_ending_at(end, &mut left, &mut right);
            let gain = |frame: usize| {
                let at_secs = from_secs + frame as f64 / f64::from(rate_hz);
                let part =
                    |gone_secs: f64, of_secs: f64| if of_secs > 0.0 { gone_secs / of_secs } else { 1.0 };
                crossfade_gain(part(at_secs - begin_secs, stretch.crossfade_secs))
                    * crossfade_gain(part(over_secs - at_secs, fade_out_secs))
            };
            for (all, heard) in [(&mut sound.left, left), (&mut sound.right, right)] {
                let all = all[from..to].iter_mut().zip(heard).enumerate();
                all.for_each(|(frame, (all, heard))| *all += gain(frame) * heard);
            }
        }
        self.join(&sounding, &mut sound);
        Ok(sound)
    }

    /// The stretches as they sound: one that goes on without a jump, as after an absence, is part of the one before it.
    fn sounding(&self) -> Vec<Stretch> {
        let mut all: Vec<Stretch> = Vec::new();
        for next in &self.heard {
            let goes_on = all.last().is_some_and(|last| follows(next, last, 1e-6));
            if !goes_on || next.crossfade_secs > 0.0 {
                all.push(*next);
            }
        }
        all
    }

    /// Joins what does not follow from each other, at leaps and at pauses, as the player does: what was heard last fades out
    /// under what comes.
    fn join(&self, sounding: &[Stretch], sound: &mut Song) {
        let rate_hz = f64::from(sound.rate_hz);
        let length = ((SEAM_SECS * sound.rate_hz as f32) as usize).max(1);
        for (before, next) in sounding.iter().zip(sounding.iter().skip(1)) {
            let seam = ((next.at_secs - self.start_secs) * rate_hz).round();
            if seam < 1.0 || fades(before, next) || follows(next, before, 1.0 / rate_hz) {
                continue;
            }
            for side in [&mut sound.left, &mut sound.right] {
                let Some((heard, coming)) = side.split_at_mut_checked(seam as usize) else { continue };
                let Some(&last) = heard.last() else { continue };
                for (i, sample) in coming.iter_mut().take(length).enumerate() {
                    *sample += (1.0 - i as f32 / length as f32) * (last - *sample);
                }
            }
        }
    }
}

/// The beats of the song that is called `name`.
fn beats_of(name: &str, watcher: &impl Watcher) -> Result<Beats, Error> {
    let song = source::long_song(name, watcher)?;
    let beats = watcher.watch("tracking the beat", |task| track_beats(&song, task));
    beats.map_err(|error| Error::from(error).of(name))
}

/// The songs heard before `start_secs` whose own beats count. A stretch is left out only if `clock` was followed all through
/// it. A paused stretch counts, too, since the count goes on from its place in the song.
fn counted_before(start_secs: f64, heard: &[Stretch], clock: &ClockTrack) -> Vec<usize> {
    let ends = heard.iter().skip(1).map(|next| next.at_secs).chain([f64::INFINITY]);
    let begun = heard.iter().zip(ends).filter(|(stretch, _)| stretch.at_secs < start_secs);
    let counted = begun.filter(|(stretch, end_secs)| {
        let since_secs = clock.followed_since(end_secs.min(start_secs));
        since_secs.is_none_or(|since_secs| since_secs > stretch.at_secs)
    });
    counted.filter_map(|(stretch, _)| stretch.song).collect()
}

/// Whether one stretch fades into the next: a leap, a pause or live input ends what is heard at once.
fn fades(before: &Stretch, next: &Stretch) -> bool {
    let sounds = |stretch: &Stretch| stretch.playing && stretch.song.is_some();
    next.crossfade_secs > 0.0 && sounds(before) && sounds(next)
}

/// Whether a stretch goes on with the song where the one before it ends, but for less than `off_secs`.
fn follows(next: &Stretch, before: &Stretch, off_secs: f64) -> bool {
    let is_near = (before.song_secs_at(next.at_secs) - next.song_secs).abs() < off_secs;
    before.playing && next.playing && before.song == next.song && is_near
}

fn at_rate(song: &Arc<Song>, rate_hz: u32) -> Result<Arc<Song>, Error> {
    if song.rate_hz == rate_hz {
        return Ok(Arc::clone(song));
    }
    let mut resampler = StereoResampler::new(song.rate_hz, rate_hz)?;
    let mut stereo = Vec::new();
    let interleaved: Vec<f32> = song.left.iter().zip(&song.right).flat_map(|(l, r)| [*l, *r]).collect();
    resampler.process(&interleaved, &mut stereo)?;
    resampler.finish(&mut stereo)?;
    let (left, right) = stereo.as_chunks().0.iter().map(|[l, r]: &[f32; 2]| (*l, *r)).unzip();
    Ok(Arc::new(Song { rate_hz, left, right }))
}

#[cfg(test)]
mod tests {
    use chladni_task::Task;

    use super::*;
    use crate::work::Aside;

    /// Two songs, the latter faded into at 3 s of the show.
    const FADED: [Stretch; 2] = {
        let first =
            Stretch { at_secs: 0.0, song: Some(0), song_secs: 0.0, playing: true, crossfade_secs: 0.0 };
        [first, Stretch { at_secs: 3.0, song: Some(1), song_secs: 1.0, crossfade_secs: 2.0, ..first }]
    };

    /// The sound of a show of 6 s and two songs, the one on the left and the other on the right.
    fn sound_of(heard: &[Stretch], range: (f64, Option<f64>)) -> Song {
        let folder = tempfile::tempdir().unwrap();
        let names = ["left.wav", "right.wav"].map(|name| {
            let (level, silence) = (vec![0.5; 4_000], vec![0.0; 4_000]);
            let (left, right) = if name == "left.wav" { (level, silence) } else { (silence, level) };
            let path = folder.path().join(name);
            let song = Song { rate_hz: 1_000, left, right };
            chladni_sound::write_wav(&path, &song, chladni_sound::WavSample::Float32).unwrap();
            (path.to_str().unwrap().to_owned(), BeatReading::default())
        });
        let (heard, clock, task) = (heard.to_vec(), ClockTrack::default(), Task::new());
        let songs = Songs::open(&names, heard, Some(6.0), range, &clock, &Aside::new(&task));
        songs.unwrap().sound().unwrap()
    }

    #[test]
    fn a_film_fades_from_song_to_song_as_the_stage_did() {
        let sound = sound_of(&FADED, (0.0, None));
        assert_eq!(sound.left.len(), 6_000);
        let power = sound.left.iter().zip(&sound.right).map(|(l, r)| l * l + r * r);
        assert!(power.map(|power| (power - 0.25).abs()).fold(0.0, f32::max) < 1e-5);
        assert!((sound.left[3_000] - sound.right[3_000]).abs() < 1e-3);
        assert!(sound.left[2_000] == 0.5 && sound.left[1_999] == 0.5 && sound.left[4_000].abs() < 1e-6);
        // A film that begins or ends within the crossfade has both, too.
        let part = sound_of(&FADED, (3.5, Some(1.0)));
        assert!(part.left == sound.left[3_500..4_500] && part.right == sound.right[3_500..4_500]);
        let part = sound_of(&FADED, (1.0, Some(1.5)));
        assert!(part.right == sound.right[1_000..2_500] && part.right[1_400] > 0.1);
        // Absences within the crossfade change nothing.
        let [first, second] = FADED;
        let back = Stretch { at_secs: 2.5, song_secs: 2.5, ..first };
        let back_again = Stretch { at_secs: 3.5, song_secs: 1.5, crossfade_secs: 0.0, ..second };
        assert_eq!(sound_of(&[first, back, second, back_again], (0.0, None)), sound);
    }

    #[test]
    fn a_crossfade_ends_where_it_is_broken_off() {
        let [first, second] = FADED;
        let is_silent = |side: &[f32]| side.iter().all(|sample| *sample == 0.0);
        let paused = Stretch { at_secs: 3.5, song_secs: 1.5, playing: false, crossfade_secs: 0.0, ..second };
        // Live input has the crossfade of the song before it.
        for broken in [paused, Stretch { song: None, playing: true, crossfade_secs: 2.0, ..paused }] {
            let sound = sound_of(&[first, second, broken], (0.0, None));
            assert!(sound.left[3_400] > 0.1 && sound.right[3_400] > 0.1);
            assert!(is_silent(&sound.left[3_600..]) && is_silent(&sound.right[3_600..]));
        }
        // After a pause in its first half, the second song is not heard before that.
        let paused = Stretch { at_secs: 2.5, song_secs: 2.5, playing: false, ..first };
        let goes_on = Stretch { at_secs: 2.75, playing: true, ..paused };
        let second = Stretch { at_secs: 3.25, ..second };
        let sound = sound_of(&[first, paused, goes_on, second], (0.0, None));
        assert!(is_silent(&sound.right[..2_750]) && sound.right[2_900] > 0.1);
        assert!(is_silent(&sound.left[2_600..2_750]) && sound.left[2_900] > 0.1);
    }

    const SINE_HZ: f32 = 100.0;

    /// The sound of stretches of sines, one of each rate.
    fn of_sines(rates_hz: &[u32], heard: &[Stretch]) -> Song {
        let folder = tempfile::tempdir().unwrap();
        let names = rates_hz.iter().map(|rate_hz| {
            let turn = std::f32::consts::TAU * SINE_HZ / *rate_hz as f32;
            let left: Vec<f32> = (0..*rate_hz).map(|n| (turn * n as f32).sin()).collect();
            let song = Song { rate_hz: *rate_hz, right: left.clone(), left };
            let path = folder.path().join(format!("{rate_hz}.wav"));
            chladni_sound::write_wav(&path, &song, chladni_sound::WavSample::Float32).unwrap();
            (path.to_str().unwrap().to_owned(), BeatReading::default())
        });
        let names: Vec<_> = names.collect();
        let (range, clock) = ((0.0, None), ClockTrack::default());
        Songs::open(&names, heard.to_vec(), Some(1.0), range, &clock, &Aside::new(&Task::new()))
            .unwrap()
            .sound()
            .unwrap()
    }

    fn stretch(at_secs: f64, song: usize, song_secs: f64, playing: bool) -> Stretch {
        Stretch { at_secs, song: Some(song), song_secs, playing, crossfade_secs: 0.0 }
    }

    #[test]
    fn a_song_that_is_over_and_cannot_be_read_is_not_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        let song = Song { rate_hz: 8_000, left: vec![0.5; 8_000], right: vec![0.5; 8_000] };
        for name in ["over.wav", "heard.wav"] {
            let path = folder.path().join(name);
            chladni_sound::write_wav(&path, &song, chladni_sound::WavSample::Float32).unwrap();
        }
        let names = ["gone.wav", "over.wav", "heard.wav"].map(|name| (path(name), BeatReading::default()));
        let heard = [0, 1, 2].map(|number: usize| stretch(number as f64, number, 0.0, true));
        let (start_secs, clock, task) = (BEFORE_SECS + 3.0, ClockTrack::default(), Task::new());
        let (range, show_secs) = ((start_secs, None), Some(start_secs + 1.0));
        let aside = Aside::new(&task);
        let mut songs = Songs::open(&names, heard.to_vec(), show_secs, range, &clock, &aside).unwrap();
        songs.track_beats(&aside).unwrap();
        let said: Vec<String> = aside.warnings().iter().map(ToString::to_string).collect();
        assert!(said.len() == 1 && said[0].contains("gone.wav"), "{said:?}");
        assert!(said[0].ends_with("its beats are not counted"), "{said:?}");
        assert_eq!([0, 1, 2].map(|number: usize| songs.songs[number].is_some()), [false, true, true]);
        task.cancel();
        assert!(songs.count_those_over(&Aside::new(&task)).unwrap_err().is_cancelled());
    }

    #[test]
    fn a_film_has_the_rate_of_its_best_song() {
        let heard = [stretch(0.0, 0, 0.0, true), stretch(0.5, 1, 0.0, true)];
        let sound = of_sines(&[8_000, 48_000], &heard);
        assert_eq!((sound.rate_hz, sound.left.len()), (48_000, 48_000));
        // Songs that are not heard do not count.
        assert_eq!(of_sines(&[8_000, 48_000], &heard[..1]).rate_hz, 8_000);
        // Films have no higher one than this.
        let sound = of_sines(&[8_000, 192_000], &heard);
        assert_eq!((sound.rate_hz, sound.left.len()), (96_000, 96_000));
    }

    #[test]
    fn leaps_and_pauses_neither_click_nor_clip() {
        // From a crest to a trough and back, and a pause at a crest.
        let heard = [
            stretch(0.0, 0, 0.0, true),
            stretch(0.2025, 0, 0.1075, true),
            stretch(0.4025, 0, 0.0125, true),
            stretch(0.6025, 0, 0.2125, false),
            stretch(0.8, 0, 0.2125, true),
        ];
        let sound = of_sines(&[8_000], &heard);
        let steps = sound.left.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let largest = steps.fold(0.0, f32::max);
        // That of the sine, and that of a fade over twice its amplitude.
        let slope = std::f32::consts::TAU * SINE_HZ / 8_000.0 + 2.1 / (SEAM_SECS * 8_000.0);
        assert!(largest < slope, "{largest} of {slope}");
        let loudest = sound.left.iter().fold(0.0_f32, |most, sample| most.max(sample.abs()));
        assert!(loudest < 1.0 + 1e-6, "louder than the song: {loudest}");
        assert!(sound.left[5_000..6_400].iter().all(|sample| *sample == 0.0));
        // What goes on where it was is the song.
        let whole = of_sines(&[8_000], &heard[..1]);
        let goes_on = [stretch(0.0, 0, 0.0, true), stretch(0.2025, 0, 0.2025, true)];
        assert_eq!(of_sines(&[8_000], &goes_on), whole);
    }
}
