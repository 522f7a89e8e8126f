//! Pictures of the stage, on their way from the device to a film and to other programs.

use std::collections::VecDeque;

use chladni_music::Veil;
use chladni_view::film::{CameraTarget, LiveCamera, RawFormat};
use chladni_view::{Canvas, Device, Picture, Readback};

use super::recorder::{RATE, RecordedSet, Recorder};
use super::song_title::{SeenTitle, SongTitle};
use crate::work::Error;

/// Pictures on their way back from the device.
const FLYING: usize = 2;

/// Who gets the pictures, and their size if one was chosen.
type Wanted = (CameraTarget, Option<[u32; 2]>);

/// The other receivers of the stage's pictures.
#[derive(Default)]
pub struct Outgoing {
    /// Films the set.
    pub recorder: Option<Recorder>,
    /// Recordings of this show that are finished, the first one first.
    pub recorded: Vec<RecordedSet>,
    camera: Option<(Wanted, LiveCamera)>,
    /// From when on pictures are counted.
    since_secs: f64,
    last: Option<u64>,
    flying: VecDeque<Flying>,
    resting: Vec<Flying>,
    landed: Picture,
}

struct Flying {
    now_secs: f64,
    readback: Readback,
    size: (u32, u32),
    over: Over,
}

/// What lies over a picture of the stage.
#[derive(Clone, Copy, Debug)]
pub struct Over {
    /// The black of the stage, and what the flash guard adds.
    pub veil: Veil,
    /// The title of the song.
    pub title: SeenTitle,
}

impl Outgoing {
    /// Records from now on.
    pub fn record(&mut self, recorder: Recorder, now_secs: f64) {
        (self.recorder, self.since_secs, self.last) = (Some(recorder), now_secs, None);
    }

    /// The set is being recorded: a recording whose file is still being written is not.
    pub fn is_recording(&self) -> bool {
        self.recorder.as_ref().is_some_and(|recorder| !recorder.ends())
    }

    /// Another show begins: what was recorded is not heard in it.
    pub fn change_show(&mut self) {
        self.recorded.clear();
        self.recorder.iter_mut().for_each(Recorder::change_show);
    }

    /// The film ends now; its last pictures are fetched.
    pub fn end_recording(
        &mut self,
        device: &Device,
        now_secs: f64,
        song_title: &mut SongTitle,
    ) -> Result<(), Error> {
        while !self.flying.is_empty() {
            self.land(device, song_title)?;
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.finish(now_secs);
        }
        Ok(())
    }

    /// Gives pictures from now on as they are `wanted`, else as large as the `stage`, or to nobody; nothing changes where it
    /// does so already.
    pub fn show_to(&mut self, wanted: Option<Wanted>, stage: [u32; 2]) -> Result<(), Error> {
        if wanted.as_ref() == self.camera.as_ref().map(|(wanted, _)| wanted) {
            return Ok(());
        }
        // One that goes on under the same name is ended first.
        self.camera = None;
        if let Some((target, size)) = wanted {
            // Programs that halve the chroma want even sides.
            let [width, height] = size.unwrap_or(stage).map(|length| (length & !1).max(2));
            let camera = LiveCamera::open(&target, (width, height), RATE)?;
            self.camera = Some(((target, size), camera));
        }
        Ok(())
    }

    /// Writes frames of `size` on standard output from now on, in place of a camera.
    pub fn stream(&mut self, format: RawFormat, size: [u32; 2]) -> Result<(), Error> {
        self.show_to(Some((CameraTarget::StandardOutput(format), Some(size))), size)
    }

    /// Frames go to standard output.
    pub fn is_streaming(&self) -> bool {
        matches!(&self.camera, Some(((CameraTarget::StandardOutput(_), _), _)))
    }

    /// The camera through which other programs see the stage.
    pub fn camera(&self) -> Option<&LiveCamera> {
        self.camera.as_ref().map(|(_, camera)| camera)
    }

    /// Why the camera is gone, once it is.
    pub fn lost_camera(&mut self) -> Option<Error> {
        let why = self.camera.as_mut()?.1.trouble()?;
        self.camera = None;
        Some(why.into())
    }

    /// Takes what `canvas` shows, behind what lies `over` it, where somebody wants it now. It is fetched while later ones
    /// are drawn.
    pub fn take(
        &mut self,
        device: &Device,
        canvas: &Canvas,
        now_secs: f64,
        over: Over,
        song_title: &mut SongTitle,
    ) -> Result<(), Error> {
        if self.recorder.is_none() && self.camera.is_none() {
            // Pictures on their way would be old when they are wanted again.
            self.flying.clear();
            return Ok(());
        }
        if !self.is_due(now_secs) {
            return Ok(());
        }
        let size = (canvas.width(), canvas.height());
        self.resting.retain(|rests| rests.size == size);
        let mut readback = match self.resting.pop() {
            Some(rests) => rests.readback,
            None => Readback::new(device, canvas)?,
        };
        readback.start(device, canvas)?;
        self.flying.push_back(Flying { now_secs, readback, size, over });
        if self.flying.len() > FLYING {
            self.land(device, song_title)?;
        }
        Ok(())
    }

    /// Whether the picture shown now is the first for its frame; counted as the film counts them, from its beginning on.
    fn is_due(&mut self, now_secs: f64) -> bool {
        let begun = self.recorder.as_ref().and_then(Recorder::since_secs);
        if let Some(since_secs) = begun.filter(|since_secs| *since_secs > self.since_secs) {
            (self.since_secs, self.last) = (since_secs, None);
        }
        let slot = RATE.live_slot(now_secs - self.since_secs);
        let is_due = self.last.is_none_or(|last| slot > last);
        if is_due {
            self.last = Some(slot);
        }
        is_due
    }

    fn land(&mut self, device: &Device, song_title: &mut SongTitle) -> Result<(), Error> {
        let Some(mut flying) = self.flying.pop_front() else { return Ok(()) };
        flying.readback.finish_into(device, &mut self.landed.rgba)?;
        (self.landed.width, self.landed.height) = flying.size;
        shade(&mut self.landed.rgba, flying.over.veil);
        song_title.lay(&mut self.landed, flying.over.title);
        if let Some(recorder) = &mut self.recorder {
            let is_shared = self.camera.is_some();
            let picture = if is_shared { self.landed.clone() } else { std::mem::take(&mut self.landed) };
            recorder.picture(flying.now_secs, picture);
        }
        if let Some((_, camera)) = &mut self.camera {
            camera.picture(&mut self.landed);
        }
        self.resting.push(flying);
        Ok(())
    }

    /// The device is another one: pictures on their way are lost.
    pub fn change_device(&mut self) {
        self.flying.clear();
        self.resting.clear();
    }
}

/// A picture behind what covers it.
fn shade(rgba: &mut [u8], veil: Veil) {
    let (to, opacity) = match veil {
        Veil::Clear => (0.0, 0.0),
        Veil::Black(opacity) => (0.0, f32::from(opacity) / 255.0),
        Veil::White(opacity) => (255.0, f32::from(opacity) / 255.0),
    };
    if opacity == 0.0 {
        return;
    }
    for pixel in rgba.as_chunks_mut::<4>().0 {
        for channel in &mut pixel[..3] {
            let veiled = f32::from(*channel) + opacity * (to - f32::from(*channel));
            *channel = veiled.round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::super::listening::HeardSound;
    use super::*;

    #[test]
    fn pictures_are_taken_for_the_frames_of_the_film() {
        if !chladni_view::film::ffmpeg_is_there() {
            return println!("skipped: no ffmpeg");
        }
        let folder = tempfile::tempdir().unwrap();
        let mut outgoing = Outgoing::default();
        let recorder = Recorder::begin(&folder.path().join("set.mp4"), [64, 48], 10.0).unwrap();
        outgoing.record(recorder, 10.0);
        assert!(outgoing.is_due(10.0));
        // It begins between two frames as they are counted from when it was asked for.
        let begins_secs = 15.0 + 0.5 / 30.0;
        let recorder = outgoing.recorder.as_mut().unwrap();
        recorder.sound(begins_secs, Instant::now(), &HeardSound::default()).unwrap();
        let due = [0, 1, 2, 3, 4].map(|i| outgoing.is_due(begins_secs + f64::from(i) / 60.0));
        assert_eq!(due, [true, false, true, false, true]);
    }
}
