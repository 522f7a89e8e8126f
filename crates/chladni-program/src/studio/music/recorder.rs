//! The set as it is played, as a film: the stage and its sound.

use std::path::{Path, PathBuf};
use std::time::Instant;

use chladni_sound::{Seam, SoundError, StereoResampler};
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
    part: Option<SoundPart>,
    sound_clock: Option<SoundClock>,
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
        Ok(Self {
            film,
            asked_secs: now_secs,
            since_secs: None,
            begins: Vec::new(),
            spans_shows: false,
            duration_secs: 0.0,
            part: None,
            sound_clock: None,
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

    /// Its file; see [`LiveFilm::path`].
    pub fn path(&self) -> &Path {
        self.film.path()
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

    /// Takes the sound up to the moment at which it was `taken`, in the frame that began at `now_secs`.
    pub fn sound(&mut self, now_secs: f64, taken: Instant, heard: &HeardSound) -> Result<(), Error> {
        let had_begun = self.start(now_secs);
        if self.since_secs.is_none() {
            return Ok(());
        }
        let frame_secs = self.at_secs(now_secs);
        let clock = self.sound_clock.get_or_insert(SoundClock { first: taken, begun_secs: frame_secs });
        let at_secs = clock.at_secs(taken, frame_secs);
        if !had_begun {
            // From before it began.
            return Ok(());
        }
        let mut out = Vec::new();
        // Sound ends before that of another rate, and where the film goes on in silence: what the resampler holds back comes
        // before the pause.
        let ends = |part: &mut SoundPart| {
            if heard.left.is_empty() {
                self.film.lacks_sound(at_secs)
            } else {
                part.resampler.from_hz() != heard.rate_hz
            }
        };
        if let Some(last) = self.part.take_if(ends) {
            last.finish(&mut out)?;
            if heard.left.is_empty() {
                self.pass_on_rest(&std::mem::take(&mut out));
            }
        }
        if self.part.is_none() && !heard.left.is_empty() {
            self.part = Some(SoundPart::begin(heard.rate_hz)?);
        }
        if let Some(part) = &mut self.part {
            part.process(heard, &mut out)?;
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
            path: self.path().to_owned(),
            begins: self.begins.clone(),
            duration_secs: self.duration_secs,
        })
    }

    /// It ends now; its file appears a little later.
    pub fn finish(&mut self, now_secs: f64) {
        if !std::mem::replace(&mut self.ends, true) {
            self.duration_secs = self.at_secs(now_secs);
            let mut rest = Vec::new();
            if self.part.take().is_some_and(|last| last.finish(&mut rest).is_ok()) {
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

/// Brings the moments at which sound is taken to the film's time. A picture is dated when its frame begins, and sound is
/// taken later, in a slow frame much later: the frame that was quickest shows how the two lie to each other.
struct SoundClock {
    first: Instant,
    /// When in the film that was, as the frames so far show.
    begun_secs: f64,
}

impl SoundClock {
    /// When in the film sound was `taken`, in the frame that began at `frame_secs` of it.
    fn at_secs(&mut self, taken: Instant, frame_secs: f64) -> f64 {
        let since_secs = taken.saturating_duration_since(self.first).as_secs_f64();
        self.begun_secs = self.begun_secs.max(frame_secs - since_secs);
        self.begun_secs + since_secs
    }
}

/// Sound of one rate on its way into the film: it fades in, over what does not follow, and out, as a player lets it.
struct SoundPart {
    resampler: StereoResampler,
    seam: Seam,
}

impl SoundPart {
    fn begin(rate_hz: u32) -> Result<Self, SoundError> {
        let (resampler, mut seam) = (StereoResampler::new(rate_hz, SOUND_HZ)?, Seam::new(rate_hz));
        seam.begin();
        Ok(Self { resampler, seam })
    }

    /// Appends what is ready as interleaved sound of the film's rate.
    fn process(&mut self, heard: &HeardSound, out: &mut Vec<f32>) -> Result<(), SoundError> {
        let mut interleaved = Vec::with_capacity(2 * heard.left.len());
        for (n, (left, right)) in heard.left.iter().zip(&heard.right).enumerate() {
            if heard.breaks.contains(&n) {
                self.seam.begin();
            }
            interleaved.extend(self.seam.over([*left, *right]));
        }
        if heard.breaks.contains(&heard.left.len()) {
            self.seam.begin();
        }
        self.resampler.process(&interleaved, out)
    }

    /// Appends the rest, faded out.
    fn finish(mut self, out: &mut Vec<f32>) -> Result<(), SoundError> {
        self.seam.begin();
        let frames = self.seam.frames();
        let fade: Vec<f32> = (0..frames).flat_map(|_| self.seam.over([0.0; 2])).collect();
        self.resampler.process(&fade, out)?;
        self.resampler.finish(out)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    /// The moment `secs` after another one.
    fn after(begun: Instant, secs: f64) -> Instant {
        begun + Duration::from_secs_f64(secs)
    }

    #[test]
    fn sound_is_dated_when_it_is_taken_however_slow_the_frame_is() {
        let begun = Instant::now();
        let mut clock = SoundClock { first: after(begun, 0.25), begun_secs: 0.0 };
        // Beginnings of frames, and how long after them the sound is taken: the first frame is a slow one, too.
        let frames = [(0.0, 0.25), (0.3, 0.02), (0.35, 0.4), (0.8, 0.03), (0.85, 0.02)];
        let late = frames.map(|(frame_secs, late_secs)| {
            let taken_secs = frame_secs + late_secs;
            taken_secs - clock.at_secs(after(begun, taken_secs), frame_secs)
        });
        // From the quickest frame on all lie alike.
        assert!((late[0] - 0.25).abs() < 1e-6, "{late:?}");
        assert!(late[1..].iter().all(|secs| (secs - 0.02).abs() < 1e-6), "{late:?}");
    }

    #[test]
    fn sound_fades_over_a_jump_and_at_both_ends() {
        let mut part = SoundPart::begin(SOUND_HZ).unwrap();
        let piece = |level: f32, breaks: Vec<usize>| {
            let mut heard = HeardSound::default();
            let sides = [level, -level].map(|level| vec![level; 1_000]);
            (heard.rate_hz, [heard.left, heard.right], heard.breaks) = (SOUND_HZ, sides, breaks);
            heard
        };
        let mut out = Vec::new();
        // The second jump lies behind the third piece.
        for (level, breaks) in [(0.5, vec![0]), (-0.5, vec![0]), (-0.5, vec![1_000]), (0.5, vec![])] {
            part.process(&piece(level, breaks), &mut out).unwrap();
        }
        part.finish(&mut out).unwrap();
        let left: Vec<f32> = out.iter().copied().step_by(2).collect();
        assert_eq!(left.len(), 4_384);
        assert_eq!([0, 999, 1_999, 3_999].map(|n: usize| left[n]), [0.0, 0.5, -0.5, 0.5]);
        assert!(left[4_383].abs() < 0.01);
        let largest = left.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        assert!(largest < 1.01 / 384.0, "{largest}");
    }

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
        let begun = Instant::now();
        recorder.sound(10.0, after(begun, 10.0), &tone).unwrap();
        // Somebody took five seconds.
        for frame in 0..30 {
            let now_secs = 15.0 + f64::from(frame) / 30.0;
            recorder.sound(now_secs, after(begun, now_secs), &tone).unwrap();
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
            std::thread::sleep(Duration::from_millis(5));
        };
        assert_eq!(frames, 30);
    }

    /// How loud a film is at most between two times, in hundredths of a second. Each of its parts lasts half a second: a
    /// tone, by its rate and level, or no sound at all.
    fn loudest_in_film_of(parts: [Option<(u32, f32)>; 3]) -> impl Fn(usize, usize) -> f32 {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.mp4");
        let mut recorder = Recorder::begin(&path, [64, 48], 10.0).unwrap();
        let begun = Instant::now();
        for frame in 0..=45_usize {
            let mut heard = HeardSound::default();
            if let Some((rate_hz, level)) = parts[frame.saturating_sub(1) / 15] {
                let radians = std::f32::consts::TAU * 600.0 / rate_hz as f32;
                let tone: Vec<f32> = (0..rate_hz / 30).map(|n| level * (radians * n as f32).sin()).collect();
                (heard.rate_hz, heard.left, heard.right) = (rate_hz, tone.clone(), tone);
            }
            // A little late after the first part: a pause is noticed at any time.
            let now_secs = 15.0 + frame as f64 / 30.0 + if frame > 15 { 0.01 } else { 0.0 };
            recorder.sound(now_secs, after(begun, now_secs), &heard).unwrap();
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
