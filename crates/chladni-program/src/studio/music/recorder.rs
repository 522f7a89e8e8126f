//! The set as it is played, as a film: what the stage shows and what is heard.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use chladni_music::Veil;
use chladni_sound::StereoResampler;
use chladni_view::film::LiveFilm;
use chladni_view::{Canvas, Device, FrameRate, Gpu, Picture, Readback};

use super::listening::HeardSound;
use crate::work::Error;

/// Frames a second.
const RATE: FrameRate = FrameRate::per_second(30);
/// Of the film's sound.
const SOUND_HZ: u32 = 48_000;
/// Pictures on their way back from the device.
const FLYING: usize = 2;

/// One recording.
pub struct Recorder {
    film: LiveFilm,
    path: PathBuf,
    since_secs: f64,
    flying: VecDeque<Flying>,
    resampler: Option<(u32, StereoResampler)>,
    ends: bool,
}

struct Flying {
    at_secs: f64,
    readback: Readback,
    size: (u32, u32),
    veil: Veil,
    /// How black the stage was, in [0, 1].
    dark: f32,
}

impl Recorder {
    /// Begins a film of `size` pixels at `now_secs` of the window.
    pub fn begin(path: &Path, size: [u32; 2], now_secs: f64) -> Result<Self, Error> {
        // H.264 wants even sides.
        let [width, height] = size.map(|length| (length & !1).max(2));
        let film = LiveFilm::begin(path, (width, height), RATE, SOUND_HZ)?;
        let path = path.to_owned();
        Ok(Self { film, path, since_secs: now_secs, flying: VecDeque::new(), resampler: None, ends: false })
    }

    /// Its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How long it is, and how many pictures were left out.
    pub fn progress(&self, now_secs: f64) -> (f64, u64) {
        (now_secs - self.since_secs, self.film.left_out())
    }

    /// Whether a picture is wanted now.
    pub fn is_due(&self, now_secs: f64) -> bool {
        !self.ends && self.film.is_due(now_secs - self.since_secs)
    }

    /// Takes what `canvas` shows, behind a veil and the black of the stage. It is fetched while later ones are drawn.
    pub fn picture(
        &mut self,
        gpu: &Gpu,
        canvas: &Canvas,
        now_secs: f64,
        (veil, dark): (Veil, f32),
    ) -> Result<(), Error> {
        if !self.is_due(now_secs) {
            return Ok(());
        }
        let device = Device::from(gpu);
        let mut readback = Readback::new(&device, canvas)?;
        readback.start(&device, canvas)?;
        let (at_secs, size) = (now_secs - self.since_secs, (canvas.width(), canvas.height()));
        self.flying.push_back(Flying { at_secs, readback, size, veil, dark });
        if self.flying.len() > FLYING {
            self.land(&device)?;
        }
        Ok(())
    }

    fn land(&mut self, device: &Device) -> Result<(), Error> {
        let Some(mut flying) = self.flying.pop_front() else { return Ok(()) };
        let mut rgba = Vec::new();
        flying.readback.finish_into(device, &mut rgba)?;
        shade(&mut rgba, flying.veil, flying.dark);
        let (width, height) = flying.size;
        self.film.picture(flying.at_secs, Picture { width, height, rgba });
        Ok(())
    }

    /// Takes what was heard up to now.
    pub fn sound(&mut self, now_secs: f64, heard: &HeardSound) -> Result<(), Error> {
        let at_secs = now_secs - self.since_secs;
        if heard.rate_hz == SOUND_HZ || heard.left.is_empty() {
            self.film.sound(at_secs, &heard.left, &heard.right);
            return Ok(());
        }
        let fitting = self.resampler.take().filter(|(rate_hz, _)| *rate_hz == heard.rate_hz);
        let (rate_hz, mut resampler) = match fitting {
            Some(known) => known,
            None => (heard.rate_hz, StereoResampler::new(heard.rate_hz, SOUND_HZ)?),
        };
        let pairs = heard.left.iter().zip(&heard.right);
        let interleaved: Vec<f32> = pairs.flat_map(|(left, right)| [*left, *right]).collect();
        let mut out = Vec::new();
        resampler.process(&interleaved, &mut out)?;
        self.resampler = Some((rate_hz, resampler));
        let (left, right): (Vec<f32>, Vec<f32>) =
            out.as_chunks::<2>().0.iter().map(|[l, r]| (*l, *r)).unzip();
        self.film.sound(at_secs, &left, &right);
        Ok(())
    }

    /// It ends now; its file appears a little later.
    pub fn finish(&mut self, gpu: Option<&Gpu>, now_secs: f64) -> Result<(), Error> {
        if std::mem::replace(&mut self.ends, true) {
            return Ok(());
        }
        while let (Some(gpu), false) = (gpu, self.flying.is_empty()) {
            self.land(&Device::from(gpu))?;
        }
        self.film.finish(now_secs - self.since_secs);
        Ok(())
    }

    /// The device is another one: what was on its way is lost.
    pub fn change_device(&mut self) {
        self.flying.clear();
    }

    /// How many frames it has, once its file is there, or why it is not.
    pub fn ended(&mut self) -> Option<Result<u64, Error>> {
        self.film.ended().map(|ended| ended.map_err(Error::from))
    }

    /// As [`ended`](Self::ended), but waits: the window closes.
    pub fn wait(&mut self) {
        self.film.wait();
    }
}

/// A picture behind what covers it.
fn shade(rgba: &mut [u8], veil: Veil, dark: f32) {
    let (to, opacity) = match veil {
        Veil::Clear => (0.0, 0.0),
        Veil::Black(opacity) => (0.0, f32::from(opacity) / 255.0),
        Veil::White(opacity) => (255.0, f32::from(opacity) / 255.0),
    };
    if opacity == 0.0 && dark == 0.0 {
        return;
    }
    for pixel in rgba.as_chunks_mut::<4>().0 {
        for channel in &mut pixel[..3] {
            let veiled = f32::from(*channel) + opacity * (to - f32::from(*channel));
            *channel = ((1.0 - dark) * veiled).round() as u8;
        }
    }
}
