//! The set as it is played, as a film: the stage and its sound.

use std::path::{Path, PathBuf};

use chladni_sound::StereoResampler;
use chladni_view::film::LiveFilm;
use chladni_view::{FrameRate, Picture};

use super::listening::HeardSound;
use super::salvage::Note;
use crate::work::Error;

/// Pictures a second.
pub const RATE: FrameRate = FrameRate::per_second(30);
/// Rate of the film's sound.
const SOUND_HZ: u32 = 48_000;

/// A finished recording, from which live input can be heard again.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedSet {
    /// Its file.
    pub path: PathBuf,
    /// Its beginning in seconds since the show began, each from a time of the show on: while it goes on, the show may stand.
    pub begins: Vec<(f64, f64)>,
    /// Its length.
    pub duration_secs: f64,
}

/// One recording.
pub struct Recorder {
    film: LiveFilm,
    path: PathBuf,
    /// When it was asked for.
    asked_secs: f64,
    /// When it began: in the first frame after that, as choosing its file may have taken any time.
    since_secs: Option<f64>,
    /// The same moment since the show began, by each stretch that is heard.
    begins: Vec<(f64, f64)>,
    /// Another show began meanwhile.
    spans_shows: bool,
    /// Its length, once it ends.
    duration_secs: f64,
    resampler: Option<StereoResampler>,
    /// When something came last.
    last_secs: f64,
    ends: bool,
    /// Lets the next start find a recording that this one may not finish.
    note: Option<Note>,
}

impl Recorder {
    /// A film of `size` pixels, which begins in the first frame after `now_secs` of the window.
    pub fn begin(path: &Path, size: [u32; 2], now_secs: f64) -> Result<Self, Error> {
        // H.264 wants even sides.
        let [width, height] = size.map(|length| (length & !1).max(2));
        let film = LiveFilm::begin(path, (width, height), RATE, SOUND_HZ)?;
        let path = path.to_owned();
        Ok(Self {
            film,
            path,
            asked_secs: now_secs,
            since_secs: None,
            begins: Vec::new(),
            spans_shows: false,
            duration_secs: 0.0,
            resampler: None,
            last_secs: now_secs,
            ends: false,
            note: None,
        })
    }

    /// Notes it in the folder of recovery copies.
    pub fn note(&mut self, recovery: &Path) -> Result<(), Error> {
        let note = Note::write(recovery, self.film.folder());
        self.note = Some(note.map_err(|why| Error::unwritten(recovery, why))?);
        Ok(())
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How long it is, and how many pictures were left out.
    pub fn progress(&self, now_secs: f64) -> (f64, u64) {
        let secs = if self.ends { self.duration_secs } else { self.at_secs(now_secs) };
        (secs, self.film.left_out())
    }

    /// Nothing more comes; its file is still being written.
    pub fn ends(&self) -> bool {
        self.ends
    }

    /// When its film began.
    pub fn since_secs(&self) -> Option<f64> {
        self.since_secs
    }

    fn at_secs(&self, now_secs: f64) -> f64 {
        self.since_secs.map_or(0.0, |since_secs| (now_secs - since_secs).max(0.0))
    }

    /// It begins where it is to; whether it had begun before.
    fn start(&mut self, now_secs: f64) -> bool {
        let had_begun = self.since_secs.is_some();
        self.last_secs = now_secs;
        if !had_begun && now_secs > self.asked_secs {
            self.since_secs = Some(now_secs);
        }
        had_begun
    }

    /// Takes the picture shown at `now_secs`.
    pub fn picture(&mut self, now_secs: f64, picture: Picture) {
        self.start(now_secs);
        if !self.ends && self.since_secs.is_some() {
            self.film.picture(self.at_secs(now_secs), picture);
        }
    }

    /// Takes the sound up to now.
    pub fn sound(&mut self, now_secs: f64, heard: &HeardSound) -> Result<(), Error> {
        if !self.start(now_secs) {
            // From before it began.
            return Ok(());
        }
        let (at_secs, mut out) = (self.at_secs(now_secs), Vec::new());
        // Sound ends before that of another rate, and where the film goes on in silence: what the resampler holds back comes
        // before the pause.
        let ends = |known: &mut StereoResampler| {
            if heard.left.is_empty() {
                self.film.lacks_sound(at_secs)
            } else {
                known.from_hz() != heard.rate_hz
            }
        };
        if let Some(mut last) = self.resampler.take_if(ends) {
            last.finish(&mut out)?;
            if heard.left.is_empty() {
                self.pass_on_rest(&std::mem::take(&mut out));
            }
        }
        if !heard.left.is_empty() {
            let mut resampler = match self.resampler.take() {
                Some(known) => known,
                None => StereoResampler::new(heard.rate_hz, SOUND_HZ)?,
            };
            let pairs = heard.left.iter().zip(&heard.right);
            let interleaved: Vec<f32> = pairs.flat_map(|(left, right)| [*left, *right]).collect();
            resampler.process(&interleaved, &mut out)?;
            self.resampler = Some(resampler);
        }
        self.pass_on(at_secs, &out);
        Ok(())
    }

    /// Gives the film interleaved sound up to `at_secs`.
    fn pass_on(&mut self, at_secs: f64, interleaved: &[f32]) {
        let pairs = interleaved.as_chunks::<2>().0.iter();
        let (left, right): (Vec<f32>, Vec<f32>) = pairs.map(|[left, right]| (*left, *right)).unzip();
        self.film.sound(at_secs, &left, &right);
    }

    /// Gives the film what a resampler held back, right behind the sound so far: for a later time, silence would come first.
    fn pass_on_rest(&mut self, interleaved: &[f32]) {
        let rest_secs = (interleaved.len() / 2) as f64 / f64::from(SOUND_HZ);
        self.pass_on(self.film.sounded_secs() + rest_secs, interleaved);
    }

    /// Notes where in the show it begins: at `now_secs` of the window the show is at `show_secs`, in a stretch that has been
    /// heard since `heard_since_secs`.
    pub fn follow_show(&mut self, now_secs: f64, show_secs: f64, heard_since_secs: Option<f64>) {
        let Some(since_secs) = self.since_secs else { return };
        let begins_secs = show_secs - (now_secs - since_secs);
        let from_secs = match self.begins.last() {
            None => Some(show_secs),
            Some((known_secs, _)) => heard_since_secs.filter(|secs| secs > known_secs && !self.ends),
        };
        self.begins.extend(from_secs.map(|from_secs| (from_secs, begins_secs)));
    }

    /// Another show goes on in the same film, which then is a set of neither.
    pub fn change_show(&mut self) {
        self.spans_shows = true;
    }

    /// The set as it can be heard again; `None` until it ends, if it never began, or has more than one show.
    pub fn set(&self) -> Option<RecordedSet> {
        let is_one = self.ends && !self.spans_shows && !self.begins.is_empty();
        is_one.then(|| RecordedSet {
            path: self.path.clone(),
            begins: self.begins.clone(),
            duration_secs: self.duration_secs,
        })
    }

    /// It ends now; its file appears a little later.
    pub fn finish(&mut self, now_secs: f64) {
        if !std::mem::replace(&mut self.ends, true) {
            self.duration_secs = self.at_secs(now_secs);
            let mut rest = Vec::new();
            if self.resampler.take().is_some_and(|mut last| last.finish(&mut rest).is_ok()) {
                self.pass_on_rest(&rest);
            }
            self.film.finish(self.duration_secs);
        }
    }

    /// How many frames it has, once its file is there, or why it is not; then its note stays.
    pub fn ended(&mut self) -> Option<Result<u64, Error>> {
        let ended = self.film.ended()?;
        self.settle(&ended);
        Some(ended.map_err(Error::from))
    }

    /// As [`ended`](Self::ended), but waits: the window closes.
    pub fn wait(&mut self) {
        if let Some(ended) = self.film.wait() {
            self.settle(&ended);
        }
    }

    /// Leaves the note of a film that failed: by it, the finished part is found.
    fn settle<T, E>(&mut self, ended: &Result<T, E>) {
        if ended.is_err() {
            self.note.take().into_iter().for_each(Note::leave);
        }
    }
}

/// A set is not lost with a window that breaks off, as in a panic or without a graphics device: its film ends there.
impl Drop for Recorder {
    fn drop(&mut self) {
        self.finish(self.last_secs);
        self.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choosing_a_file_is_not_in_the_film() {
        if !chladni_view::film::ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        let folder = tempfile::tempdir().unwrap();
        let mut recorder = Recorder::begin(&folder.path().join("set.mp4"), [64, 48], 10.0).unwrap();
        let gray = || Picture { width: 64, height: 48, rgba: vec![128; 4 * 64 * 48] };
        let mut tone = HeardSound::default();
        (tone.rate_hz, tone.left, tone.right) = (SOUND_HZ, vec![0.5; 1600], vec![0.5; 1600]);
        recorder.sound(10.0, &tone).unwrap();
        // Somebody took five seconds.
        for frame in 0..30 {
            let now_secs = 15.0 + f64::from(frame) / 30.0;
            recorder.sound(now_secs, &tone).unwrap();
            recorder.picture(now_secs, gray());
        }
        assert!((recorder.progress(16.0).0 - 1.0).abs() < 1e-9);
        // Until another stretch begins, the show stands for a quarter of a second.
        recorder.follow_show(15.5, 7.5, Some(3.0));
        recorder.follow_show(15.75, 7.625, Some(3.0));
        recorder.follow_show(16.0, 7.75, Some(7.625));
        assert_eq!(recorder.set(), None);
        recorder.finish(16.0);
        // While its file is written it grows no longer, and the show knows it.
        assert!((recorder.progress(20.0).0 - 1.0).abs() < 1e-9);
        let set = recorder.set().unwrap();
        assert_eq!(set.begins, [(7.5, 7.0), (7.625, 6.75)]);
        assert!((set.duration_secs - 1.0).abs() < 1e-9, "{set:?}");
        let frames = loop {
            if let Some(ended) = recorder.ended() {
                break ended.unwrap();
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        };
        assert_eq!(frames, 30);
    }

    /// How loud a film is at most between two times, in hundredths of a second. Each of its parts lasts half a second: a
    /// tone, by its rate and level, or no sound at all.
    fn loudest_in_film_of(parts: [Option<(u32, f32)>; 3]) -> impl Fn(usize, usize) -> f32 {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.mp4");
        let mut recorder = Recorder::begin(&path, [64, 48], 10.0).unwrap();
        for frame in 0..=45_usize {
            let mut heard = HeardSound::default();
            if let Some((rate_hz, level)) = parts[frame.saturating_sub(1) / 15] {
                let radians = std::f32::consts::TAU * 600.0 / rate_hz as f32;
                let tone: Vec<f32> = (0..rate_hz / 30).map(|n| level * (radians * n as f32).sin()).collect();
                (heard.rate_hz, heard.left, heard.right) = (rate_hz, tone.clone(), tone);
            }
            // A little late after the first part: a pause is noticed at any time.
            let now_secs = 15.0 + frame as f64 / 30.0 + if frame > 15 { 0.01 } else { 0.0 };
            recorder.sound(now_secs, &heard).unwrap();
            recorder.picture(now_secs, Picture { width: 64, height: 48, rgba: vec![128; 4 * 64 * 48] });
        }
        recorder.finish(16.5);
        recorder.wait();
        let song = chladni_sound::Song::open(&path).unwrap();
        move |from, to| {
            let part = &song.left[from * 480..to * 480];
            part.iter().fold(0.0_f32, |most, sample| most.max(sample.abs()))
        }
    }

    #[test]
    fn sound_of_one_rate_ends_where_that_of_another_begins() {
        if !chladni_view::film::ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        // A song, silent live input, and a silent song.
        let parts = [Some((44_100, 0.5)), Some((SOUND_HZ, 0.0)), Some((44_100, 0.0))];
        let loudest = loudest_in_film_of(parts);
        assert!(loudest(10, 40) > 0.4, "{}", loudest(10, 40));
        assert!(loudest(90, 140) < 0.01, "{}", loudest(90, 140));
    }

    #[test]
    fn a_song_is_heard_to_its_end_before_a_pause_and_not_after_it() {
        if !chladni_view::film::ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        // A song, a pause, and silent live input.
        let loudest = loudest_in_film_of([Some((44_100, 0.5)), None, Some((SOUND_HZ, 0.0))]);
        assert!(loudest(49, 50) > 0.3, "{}", loudest(49, 50));
        assert!(loudest(56, 140) < 0.01, "{}", loudest(56, 140));
    }
}
