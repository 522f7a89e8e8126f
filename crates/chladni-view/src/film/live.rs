//! A film recorded live: nobody waits for its encoder, and pictures that come too fast are left out and
//! counted.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use fast_image_resize::images::{CroppedImageMut, Image, ImageRef};
use fast_image_resize::{FilterType, PixelType, ResizeAlg, ResizeOptions, Resizer};
use image::RgbaImage;

use super::cut_off::RecordingFolder;
use super::mp4::{Layout, Mp4};
use super::{Encode, FilmFormat, FilmSettings, FrameRate, ffmpeg_is_there, unwritten};
use crate::{Picture, ViewError};

/// Pictures that may wait for the encoder.
const MOST_WAITING: usize = 4;
/// Messages that may wait; sound comes in small pieces.
const MOST_MESSAGES: usize = 4096;
/// Sound that lags behind the picture by more than this is preceded by silence, and of sound that runs ahead by more, what
/// is too much is left out: no device's clock keeps exactly this one's time.
const LATE_SECS: f64 = 0.1;
/// Silence is written in pieces of this many frames.
const SILENT_FRAMES: usize = 4096;

/// An MP4 with sound that is written while it happens. Dropped before it is finished, it leaves nothing behind; if it
/// fails, its folder stays ([`CutOff`](super::CutOff)).
#[derive(Debug)]
pub struct LiveFilm {
    folder: PathBuf,
    path: PathBuf,
    sender: Option<SyncSender<Message>>,
    waiting: Arc<AtomicUsize>,
    /// How many pictures long it is, once it is finished; 0 before.
    slots: Arc<AtomicU64>,
    rate: FrameRate,
    sound_hz: u32,
    /// The slot of the last picture, and frames of sound so far.
    last: Option<u64>,
    sounded: u64,
    left_out: u64,
    thread: Option<JoinHandle<Result<(u64, PathBuf), ViewError>>>,
}

enum Message {
    Frame(u64, Picture),
    Sound(Vec<f32>),
    /// So many frames of it.
    Silence(u64),
}

impl LiveFilm {
    /// Begins one of `width`×`height` pixels at the given frame rate, with sound at `sound_hz`.
    ///
    /// # Errors
    /// [`ViewError::NoFfmpeg`], [`ViewError::Film`] for settings that no film has, [`ViewError::File`] where nothing
    /// can be written.
    pub fn begin(
        path: &Path,
        (width, height): (u32, u32),
        rate: FrameRate,
        sound_hz: u32,
    ) -> Result<Self, ViewError> {
        let settings = FilmSettings { width, height, rate, frames: u64::MAX, first: 0, audio: None };
        settings.check_for(FilmFormat::Mp4)?;
        if !ffmpeg_is_there() {
            return Err(ViewError::NoFfmpeg);
        }
        let folder = RecordingFolder::create(path, sound_hz).map_err(unwritten(path))?;
        let sound = std::fs::File::create(folder.sound()).map_err(unwritten(path))?;
        let encoder = Mp4::create(&folder.picture(), &settings, Layout::Pieces)?;
        let place = folder.path().to_owned();
        let slots = Arc::default();
        let blank = RgbaImage::from_pixel(width, height, image::Rgba([0, 0, 0, 255]));
        let writer = Writer {
            folder,
            encoder,
            sound: BufWriter::new(sound),
            slots: Arc::clone(&slots),
            rate,
            shown: Picture { width, height, rgba: blank.into_raw() },
            written: 0,
        };
        let (sender, receiver) = sync_channel(MOST_MESSAGES);
        let waiting = Arc::new(AtomicUsize::new(0));
        let taken = Arc::clone(&waiting);
        let thread = std::thread::Builder::new()
            .name("recording".into())
            .spawn(move || writer.run(&receiver, &taken))
            .map_err(|error| ViewError::Film(format!("no thread to encode on: {error}")))?;
        let thread = Some(thread);
        Ok(Self {
            folder: place,
            path: path.to_owned(),
            sender: Some(sender),
            waiting,
            slots,
            rate,
            sound_hz,
            last: None,
            sounded: 0,
            left_out: 0,
            thread,
        })
    }

    /// The folder in which it is made, beside its file. If the program ends before the film does, [`CutOff`](super::CutOff)
    /// makes a film of the pieces there.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its file. Once it has [`ended`](Self::ended), the name has a number where another file has come there meanwhile.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a picture is wanted at `at_secs` since it began.
    pub fn is_due(&self, at_secs: f64) -> bool {
        self.last.is_none_or(|last| self.rate.live_slot(at_secs) > last)
    }

    /// Takes the picture of `at_secs`, of any size; it is shown until the next one. A picture that is not due is
    /// ignored; one that comes while the encoder is too far behind is left out and counted.
    pub fn picture(&mut self, at_secs: f64, picture: Picture) {
        let slot = self.rate.live_slot(at_secs);
        if !self.is_due(at_secs) {
            return;
        }
        self.last = Some(slot);
        let sent = self.waiting.load(Ordering::Relaxed) < MOST_WAITING
            && self.sender.as_ref().is_some_and(|sender| {
                self.waiting.fetch_add(1, Ordering::Relaxed);
                let sent = sender.try_send(Message::Frame(slot, picture)).is_ok();
                if !sent {
                    self.waiting.fetch_sub(1, Ordering::Relaxed);
                }
                sent
            });
        self.left_out += u64::from(!sent);
    }

    /// Takes the sound up to `at_secs`; a gap before it is silence, and what is too much is left out at its beginning.
    pub fn sound(&mut self, at_secs: f64, left: &[f32], right: &[f32]) {
        let (due, late) = (self.due(at_secs), self.late());
        let frames = left.len().min(right.len());
        let with_all = self.sounded + frames as u64;
        let beyond = |surplus: u64| if surplus > late { surplus } else { 0 };
        let silence = beyond(due.saturating_sub(with_all));
        let dropped = beyond(with_all.saturating_sub(due)).min(frames as u64) as usize;
        if silence > 0 {
            self.send_sound(silence, Message::Silence(silence));
        }
        if dropped < frames {
            let pairs = left.iter().zip(right).skip(dropped);
            let samples = pairs.flat_map(|(left, right)| [*left, *right]).collect();
            self.send_sound((frames - dropped) as u64, Message::Sound(samples));
        }
    }

    /// Whether so much sound is missing up to `at_secs` that silence takes its place now ([`sound`](Self::sound)).
    pub fn lacks_sound(&self, at_secs: f64) -> bool {
        self.due(at_secs).saturating_sub(self.sounded) > self.late()
    }

    /// How much sound there is.
    pub fn sounded_secs(&self) -> f64 {
        self.sounded as f64 / f64::from(self.sound_hz)
    }

    /// How many frames of sound there are to be up to `at_secs`.
    fn due(&self, at_secs: f64) -> u64 {
        (at_secs.max(0.0) * f64::from(self.sound_hz)) as u64
    }

    /// By how many it may lag behind or run ahead.
    fn late(&self) -> u64 {
        (LATE_SECS * f64::from(self.sound_hz)) as u64
    }

    /// Sound that the queue does not take is silence in the film.
    fn send_sound(&mut self, frames: u64, message: Message) {
        if self.sender.as_ref().is_some_and(|sender| sender.try_send(message).is_ok()) {
            self.sounded += frames;
        }
    }

    /// Pictures that were left out because the encoder was behind.
    pub fn left_out(&self) -> u64 {
        self.left_out
    }

    /// It ends at `at_secs`; its file appears a little later ([`ended`](Self::ended)). Nobody waits here either, though the
    /// queue may be full.
    pub fn finish(&mut self, at_secs: f64) {
        let silence = LATE_SECS + 1.0 / f64::from(self.sound_hz);
        self.sound(at_secs + silence, &[], &[]);
        if self.sender.is_some() {
            self.slots.store(self.rate.slot(at_secs).max(1), Ordering::Release);
            self.sender = None;
        }
    }

    /// How many frames it has, once its file is there, or why it is not; `None` before.
    pub fn ended(&mut self) -> Option<Result<u64, ViewError>> {
        if self.thread.as_ref().is_some_and(|thread| !thread.is_finished()) {
            return None;
        }
        self.wait()
    }

    /// As [`ended`](Self::ended), but waits for it.
    pub fn wait(&mut self) -> Option<Result<u64, ViewError>> {
        let stopped = || Err(ViewError::Film("its encoder stopped".into()));
        let ended = self.thread.take()?.join().unwrap_or_else(|_| stopped());
        Some(ended.map(|(frames, path)| {
            self.path = path;
            frames
        }))
    }
}

/// On a thread of its own.
struct Writer {
    /// Before the folder: what writes into it ends first.
    encoder: Mp4,
    sound: BufWriter<std::fs::File>,
    folder: RecordingFolder,
    /// As [`LiveFilm::slots`].
    slots: Arc<AtomicU64>,
    rate: FrameRate,
    shown: Picture,
    written: u64,
}

impl Writer {
    /// How many frames it has, and where it is.
    fn run(
        mut self,
        messages: &Receiver<Message>,
        waiting: &AtomicUsize,
    ) -> Result<(u64, PathBuf), ViewError> {
        match self.take(messages, waiting) {
            Ok(true) => self.finish(),
            // Dropped: nobody wants it.
            Ok(false) => Ok((0, self.folder.film().to_owned())),
            Err(why) => {
                // The frames so far can still become a film.
                drop(self.encoder);
                self.folder.keep();
                Err(why)
            }
        }
    }

    /// Takes pictures and sound until it is finished, which is true, or dropped.
    fn take(&mut self, messages: &Receiver<Message>, waiting: &AtomicUsize) -> Result<bool, ViewError> {
        for message in messages {
            match message {
                Message::Frame(slot, picture) => {
                    waiting.fetch_sub(1, Ordering::Relaxed);
                    self.hold(slot)?;
                    self.shown = fit(picture, self.shown.width, self.shown.height);
                    self.hold(slot + 1)?;
                }
                Message::Sound(samples) => self.write_sound(&samples)?,
                Message::Silence(frames) => {
                    let silence = [0.0; 2 * SILENT_FRAMES];
                    let mut left = frames;
                    while left > 0 {
                        let now = left.min(SILENT_FRAMES as u64);
                        self.write_sound(&silence[..2 * now as usize])?;
                        left -= now;
                    }
                }
            }
        }
        let slots = self.slots.load(Ordering::Acquire);
        self.hold(slots)?;
        Ok(slots > 0)
    }

    fn write_sound(&mut self, samples: &[f32]) -> Result<(), ViewError> {
        for sample in samples {
            let written = self.sound.write_all(&sample.to_le_bytes());
            written.map_err(unwritten(self.folder.film()))?;
        }
        Ok(())
    }

    /// Shows the last picture until `slot`.
    fn hold(&mut self, slot: u64) -> Result<(), ViewError> {
        while self.written < slot {
            self.encoder.frame(&self.shown).map_err(of_film(self.folder.film()))?;
            self.written += 1;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<(u64, PathBuf), ViewError> {
        let flushed = self.sound.flush().map_err(unwritten(self.folder.film()));
        let Self { folder, encoder, rate, written, .. } = self;
        let encoded = flushed.and_then(|()| Box::new(encoder).finish().map_err(of_film(folder.film())));
        if let Err(why) = encoded {
            folder.keep();
            return Err(why);
        }
        Ok((written, folder.join(rate.start_secs(written))?))
    }
}

/// A fault of the encoder's file, which nobody chose, as one of the film that it is for.
fn of_film(film: &Path) -> impl Fn(ViewError) -> ViewError {
    move |why| match why {
        ViewError::File { source, .. } => ViewError::at(film)(source),
        why => why,
    }
}

/// A picture of another size as large as it fits, on black. One that is a pixel wider or higher, since films want even
/// sides, loses that: scaling all others by a thousandth would cost more than encoding them, and blur them.
pub(super) fn fit(mut picture: Picture, width: u32, height: u32) -> Picture {
    if (picture.width, picture.height) == (width, height) {
        return picture;
    }
    if (width..=width + 1).contains(&picture.width) && (height..=height + 1).contains(&picture.height) {
        let [from, to] = [picture.width, width].map(|width| 4 * width as usize);
        if picture.rgba.len() >= from * height as usize {
            (0..height as usize).for_each(|y| picture.rgba.copy_within(y * from..y * from + to, y * to));
            picture.rgba.truncate(to * height as usize);
            return Picture { width, height, ..picture };
        }
    }
    let black = [0, 0, 0, 255].repeat(width as usize * height as usize);
    let mut whole = Picture { width, height, rgba: black };
    // Sizes are right for as many bytes, or nothing is laid on the black.
    let _ = lay(&picture, &mut whole);
    whole
}

/// Lays `picture` on the middle of `whole`, as large as it fits.
fn lay(picture: &Picture, whole: &mut Picture) -> Option<()> {
    let (width, height) = (whole.width, whole.height);
    let scale = (f64::from(width) / f64::from(picture.width.max(1)))
        .min(f64::from(height) / f64::from(picture.height.max(1)));
    let scaled = |length: u32| ((f64::from(length) * scale).round() as u32).max(1);
    let (w, h) = (scaled(picture.width).min(width), scaled(picture.height).min(height));
    let from = ImageRef::new(picture.width, picture.height, &picture.rgba, PixelType::U8x4).ok()?;
    let mut to = Image::from_slice_u8(width, height, &mut whole.rgba, PixelType::U8x4).ok()?;
    let mut middle = CroppedImageMut::new(&mut to, (width - w) / 2, (height - h) / 2, w, h).ok()?;
    let smooth =
        ResizeOptions::new().resize_alg(ResizeAlg::Convolution(FilterType::Bilinear)).use_alpha(false);
    Resizer::new().resize(&from, &mut middle, &smooth).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;
    use std::time::{Duration, Instant};

    fn flat(width: u32, height: u32, shade: u8) -> Picture {
        let pixel = [shade, shade, shade, 255];
        Picture { width, height, rgba: pixel.repeat((width * height) as usize) }
    }

    fn wait(film: &mut LiveFilm) -> u64 {
        film.wait().unwrap().unwrap()
    }

    #[test]
    fn a_picture_with_a_pixel_too_many_loses_it_and_another_size_is_fitted_in() {
        let rgba: Vec<u8> = (0..5 * 3).flat_map(|i| [i, 0, 0, 255]).collect();
        let odd = Picture { width: 5, height: 3, rgba };
        let even = fit(odd.clone(), 4, 2);
        let reds: Vec<u8> = even.rgba.as_chunks::<4>().0.iter().map(|pixel| pixel[0]).collect();
        assert_eq!((even.width, even.height, reds), (4, 2, vec![0, 1, 2, 3, 5, 6, 7, 8]));
        // A wide one lies between black bars.
        let wide = fit(flat(8, 2, 200), 4, 4);
        let rows: Vec<u8> = wide.rgba.chunks(16).map(|row| row[0]).collect();
        assert_eq!(rows, [0, 200, 0, 0]);
    }

    #[test]
    fn pictures_are_held_and_sound_is_in_time() {
        if !ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.mp4");
        let mut film = LiveFilm::begin(&path, (64, 48), FrameRate::per_second(30), 8000).unwrap();
        // Two seconds of which every third picture comes, of changing sizes; the sound begins after one.
        for i in 0..60 {
            let at_secs = (f64::from(i) + 0.5) / 30.0;
            if i % 3 == 0 {
                assert!(film.is_due(at_secs));
                while film.waiting.load(Ordering::Relaxed) >= MOST_WAITING {
                    std::thread::sleep(Duration::from_millis(5));
                }
                let size = if i % 2 == 0 { (64, 48) } else { (40, 40) };
                film.picture(at_secs, flat(size.0, size.1, 200));
                assert!(!film.is_due(at_secs));
            }
            if i >= 30 {
                let tone: Vec<f32> = (0..266).map(|n| (0.4 * f64::from(n)).sin() as f32).collect();
                film.sound(at_secs, &tone, &tone);
            }
        }
        film.finish(2.0);
        assert_eq!((wait(&mut film), film.left_out()), (60, 0));
        let probe = Command::new("ffprobe")
            .args(["-v", "error", "-count_frames", "-show_entries"])
            .args(["stream=codec_type,nb_read_frames,duration", "-of", "csv=p=0"])
            .arg(&path)
            .output()
            .unwrap();
        let probed = String::from_utf8(probe.stdout).unwrap();
        assert!(probed.contains("video,2.000000,60"), "{probed}");
        assert!(probed.contains("audio,2.0") || probed.contains("audio,1.9"), "{probed}");
        // The first second is silent, the other is not.
        let raw = Command::new("ffmpeg")
            .args(["-v", "error", "-i"])
            .arg(&path)
            .args(["-f", "f32le", "-ac", "1", "-ar", "8000", "-"])
            .output()
            .unwrap()
            .stdout;
        let loudest = |range: std::ops::Range<usize>| {
            let samples = raw[4 * range.start..4 * range.end].as_chunks::<4>().0.iter();
            samples.map(|bytes| f32::from_le_bytes(*bytes).abs()).fold(0.0, f32::max)
        };
        assert!(loudest(0..7200) < 0.05 && loudest(9000..15_000) > 0.3);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_film_replaces_only_what_was_there_when_it_began() {
        if !ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.mp4");
        let begin = || LiveFilm::begin(&path, (64, 48), FrameRate::per_second(30), 8000).unwrap();
        let end = |mut film: LiveFilm| {
            film.picture(0.0, flat(64, 48, 200));
            film.finish(0.1);
            wait(&mut film);
            film.path().file_name().unwrap().to_owned()
        };
        // Two windows hear the same controller.
        let (one, other) = (begin(), begin());
        assert_eq!([end(one), end(other)], ["set.mp4", "set (2).mp4"]);
        assert_eq!(end(begin()), "set.mp4", "it was chosen");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    /// Only Unix removes a file that is being written.
    #[cfg(unix)]
    #[test]
    fn a_fault_of_the_hidden_picture_names_the_film() {
        if !ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.mp4");
        let mut film = LiveFilm::begin(&path, (64, 48), FrameRate::per_second(30), 8000).unwrap();
        film.picture(0.0, flat(64, 48, 200));
        let (picture, start) = (film.folder().join("picture.mp4"), Instant::now());
        while std::fs::remove_file(&picture).is_err() {
            assert!(start.elapsed() < chladni_testdata::HANGS);
            std::thread::sleep(Duration::from_millis(5));
        }
        film.finish(0.1);
        let why = film.wait().unwrap().unwrap_err();
        assert!(matches!(&why, ViewError::File { path: named, .. } if *named == path), "{why}");
    }

    /// A film without an encoder, and what would be written of it.
    fn not_written() -> (LiveFilm, Receiver<Message>) {
        let (sender, receiver) = sync_channel(MOST_MESSAGES);
        let film = LiveFilm {
            folder: PathBuf::new(),
            path: PathBuf::new(),
            sender: Some(sender),
            waiting: Arc::default(),
            slots: Arc::default(),
            rate: FrameRate::per_second(30),
            sound_hz: 8000,
            last: None,
            sounded: 0,
            left_out: 0,
            thread: None,
        };
        (film, receiver)
    }

    fn frames(message: &Message) -> u64 {
        match message {
            Message::Sound(samples) => samples.len() as u64 / 2,
            Message::Silence(frames) => *frames,
            Message::Frame(..) => 0,
        }
    }

    #[test]
    fn sound_of_a_device_that_runs_fast_or_slow_stays_beside_the_picture() {
        for each in [397, 400, 403] {
            let (mut film, receiver) = not_written();
            let tone = vec![0.5; each];
            let mut written = 0;
            for i in 1..=2000 {
                film.sound(0.05 * f64::from(i), &tone, &tone);
                written += receiver.try_iter().map(|message| frames(&message)).sum::<u64>();
                assert!(written.abs_diff(400 * i as u64) <= 800, "{written} frames in {i} pieces of {each}");
            }
        }
    }

    #[test]
    fn every_frame_has_a_picture_whatever_the_rate_of_the_screen() {
        for rate_hz in [30, 50, 60, 75, 120, 144] {
            let (mut film, receiver) = not_written();
            let (mut last, mut slots) = (None, Vec::new());
            for i in 0..10 * rate_hz {
                // No clock is even.
                let off_secs = [0.0, -0.001, 0.001, -0.0005][i as usize % 4];
                let at_secs = f64::from(i) / f64::from(rate_hz) + off_secs;
                // As they are thinned before they are fetched.
                let slot = film.rate.live_slot(at_secs);
                if last.is_none_or(|last| slot > last) {
                    last = Some(slot);
                    film.picture(at_secs, flat(2, 2, 0));
                    film.waiting.store(0, Ordering::Relaxed);
                }
                slots.extend(receiver.try_iter().filter_map(|message| match message {
                    Message::Frame(slot, _) => Some(slot),
                    _ => None,
                }));
            }
            assert!(slots.iter().copied().take(300).eq(0..300), "{rate_hz} Hz: {slots:?}");
        }
    }

    #[test]
    fn nobody_waits_for_a_full_queue_in_the_end() {
        let (mut film, receiver) = not_written();
        while film.sender.as_ref().is_some_and(|sender| sender.try_send(Message::Silence(1)).is_ok()) {}
        film.finish(2.0);
        assert!(film.sender.is_none());
        assert_eq!(film.slots.load(Ordering::Acquire), 60);
        assert_eq!(receiver.iter().count(), MOST_MESSAGES);
    }

    #[test]
    fn a_long_gap_needs_no_memory() {
        let (mut film, receiver) = not_written();
        film.sound(10.0 * 3600.0, &[0.5], &[0.5]);
        let messages: Vec<Message> = receiver.try_iter().collect();
        let held = |message: &Message| if let Message::Sound(samples) = message { samples.len() } else { 0 };
        assert!(messages.iter().all(|message| held(message) <= 2));
        assert_eq!(messages.iter().map(frames).sum::<u64>(), 36_000 * 8000);
    }

    #[test]
    fn what_comes_too_fast_is_left_out_and_nobody_waits() {
        if !ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("set.mp4");
        let mut film = LiveFilm::begin(&path, (640, 480), FrameRate::per_second(60), 8000).unwrap();
        for i in 0..2000 {
            film.picture(f64::from(i) / 60.0, flat(640, 480, (i % 256) as u8));
            assert!(film.waiting.load(Ordering::Relaxed) <= MOST_WAITING);
        }
        assert!(film.left_out() > 0);
        drop(film);
        // Its thread ends by itself, and leaves nothing behind.
        let start = Instant::now();
        while std::fs::read_dir(folder.path()).unwrap().count() > 0 {
            assert!(start.elapsed() < chladni_testdata::HANGS);
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
