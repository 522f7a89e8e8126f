//! Beginning and ending a recording of the set, and the camera that other programs see.

use std::path::{Path, PathBuf};

use chladni_task::{counted, folder_of};
use chladni_view::{ViewError, ffmpeg_is_there};

use super::MusicRoom;
use super::preferences::Camera;
use super::recorder::Recorder;
use super::wish::Then;
use crate::studio::opening::{SetOutput, SetTarget};
use crate::studio::room::Shared;
use crate::work::Error;
use crate::work::outputs::check_apart;

const STILL_WRITTEN: &str = "The last recording is still being written: try again when it is there.";

impl MusicRoom {
    /// Asks where to record the set; or ends a recording.
    pub(super) fn record(&mut self, shared: &mut Shared<'_>) {
        if self.may_record(shared) {
            self.ask_for(Then::Record, shared);
        }
    }

    /// Records the set beside the last recording, or in the user's folder, under a name that is free; or ends a recording.
    pub(super) fn record_at_once(&mut self, shared: &mut Shared<'_>) {
        if !self.may_record(shared) {
            return;
        }
        let folder = self.recordings.as_deref().or(shared.folders.recordings.as_deref());
        let Some(path) = folder.map(free_path) else { return self.ask_for(Then::Record, shared) };
        match self.record_to(&path, None, shared) {
            Ok(()) => shared.notices.done(format!("Recording {}", path.display())),
            Err(why) => shared.notices.failed(why),
        }
    }

    /// Whether a recording can begin; one that goes on is ended instead.
    fn may_record(&mut self, shared: &mut Shared<'_>) -> bool {
        if self.end_recording(shared) {
            return false;
        }
        let (Some(concert), Some(_)) = (&self.concert, &self.listening) else { return false };
        // A recorder that is still there has ended; its file is being written.
        if concert.outgoing.recorder.is_some() {
            shared.notices.warn(STILL_WRITTEN);
            return false;
        }
        let is_there = ffmpeg_is_there();
        if !is_there {
            shared.notices.failed(ViewError::NoFfmpeg);
        }
        is_there
    }

    /// Ends the recording; its file appears a little later. False where there is none.
    pub(super) fn end_recording(&mut self, shared: &mut Shared<'_>) -> bool {
        let now_secs = shared.ctx.input(|input| input.time);
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return false };
        if !concert.outgoing.is_recording() {
            return false;
        }
        listening.keep_sound(false);
        let device = concert.device().clone();
        if let Err(why) = concert.outgoing.end_recording(&device, now_secs, &mut concert.song_title) {
            shared.notices.failed(why);
        }
        true
    }

    /// Sends the set where the window was opened to send it, once there is a picture.
    pub(super) fn begin_output(&mut self, shared: &mut Shared<'_>) {
        let Some(concert) = self.concert.as_mut().filter(|concert| concert.has_picture()) else { return };
        let Some(SetOutput { to, size }) = self.output.take() else { return };
        let begun = match to {
            SetTarget::Film(path) => self.record_to(&path, size, shared),
            SetTarget::Frames(format) => {
                concert.outgoing.stream(format, size.unwrap_or_else(|| concert.picture_size()))
            }
        };
        if let Err(why) = begun {
            shared.notices.failed(why);
        }
    }

    /// Records the set from now on, in pictures of `size` or of the stage's.
    pub(super) fn record_to(
        &mut self,
        path: &Path,
        size: Option<[u32; 2]>,
        shared: &mut Shared<'_>,
    ) -> Result<(), Error> {
        let now_secs = shared.ctx.input(|input| input.time);
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else {
            return Ok(());
        };
        if let Some(recorder) = &concert.outgoing.recorder {
            let why = if recorder.ends() { STILL_WRITTEN } else { "The set is being recorded already." };
            return Err(Error::input(why));
        }
        let music = &shared.settings.music;
        let around = [&music.picture, &music.panorama].map(Path::new);
        let songs = listening.songs().iter().map(PathBuf::as_path);
        // A film of the show hears again what was heard, and what was recorded before.
        let heard = listening.heard().1.iter().map(|song| song.path.as_path());
        let recorded = concert.outgoing.recorded.iter().map(|set| set.path.as_path());
        let inputs: Vec<&Path> =
            songs.chain(heard).chain(recorded).chain(around).chain([self.body.as_path()]).collect();
        check_apart(path, &inputs)?;
        let mut recorder = Recorder::begin(path, size.unwrap_or_else(|| concert.picture_size()), now_secs)?;
        if let Some(recovery) = &shared.folders.recovery
            && let Err(why) = recorder.note(recovery)
        {
            shared.notices.warn(format!("A crash would lose the recording: {why}"));
        }
        concert.outgoing.record(recorder, now_secs);
        listening.keep_sound(true);
        self.recordings = Some(folder_of(path).to_owned());
        Ok(())
    }

    /// Gives a recording the sound, and reports how it ended.
    pub(super) fn follow_recording(&mut self, shared: &mut Shared<'_>) {
        let now_secs = shared.ctx.input(|input| input.time);
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
        let Some(recorder) = &mut concert.outgoing.recorder else { return };
        if let Some((age, heard)) = listening.take_sound() {
            let now = (shared.now)();
            let taken = now.checked_sub(age).unwrap_or(now);
            if let Err(why) = recorder.sound(now_secs, taken, &heard) {
                shared.notices.failed(why);
            }
        }
        recorder.follow_show(now_secs, listening.at_secs(), listening.heard_since_secs());
        let Some(ended) = recorder.ended() else { return };
        let (path, left_out) = (recorder.path().display().to_string(), recorder.progress(now_secs).1);
        listening.keep_sound(false);
        let set = recorder.set();
        concert.outgoing.recorder = None;
        concert.outgoing.recorded.extend(set.filter(|_| ended.is_ok()));
        match ended.map(|frames| counted(frames, "frame", "frames")) {
            Ok(frames) if left_out == 0 => shared.notices.done(format!("Recorded {path}: {frames}")),
            Ok(frames) => {
                let message = format!("Recorded {path}: {frames}, of which {left_out} repeat the one before");
                shared.notices.warn(message);
            }
            Err(why) => {
                // An error about the file itself names it already.
                let named = why.to_string().starts_with(&path);
                shared.notices.failed(if named { why } else { why.of(path) });
                self.salvage.look_again();
            }
        }
    }

    /// Gives the stage's pictures to the programs that the preferences name, or no longer.
    pub(super) fn follow_camera(&mut self, shared: &mut Shared<'_>) {
        let Some(concert) = &mut self.concert else { return };
        // Frames on standard output take the camera's place.
        let streams = concert.outgoing.is_streaming();
        let opened = if streams {
            Ok(())
        } else {
            let music = &shared.settings.music;
            let wanted = music.camera.target().map(|target| (target, music.camera_size.pixels()));
            concert.outgoing.show_to(wanted, concert.picture_size())
        };
        let Some(why) = opened.err().or_else(|| concert.outgoing.lost_camera()) else { return };
        if !streams {
            // It is tried again when somebody asks for it again.
            shared.settings.music.camera = Camera::Off;
        }
        shared.notices.failed(why);
    }

    /// The window closes: the film is ended first.
    pub(super) fn save_recording(&mut self) {
        let Some(mut recorder) = self.concert.as_mut().and_then(|concert| concert.outgoing.recorder.take())
        else {
            return;
        };
        // Its last pictures may be lost; the time is that of the last one.
        recorder.finish(self.last_secs);
        recorder.wait();
    }
}

/// A recording in `folder` that is not there yet.
fn free_path(folder: &Path) -> PathBuf {
    let mut number = 1;
    loop {
        let path = folder.join(format!("set {number}.mp4"));
        if !path.exists() {
            return path;
        }
        number += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_that_nobody_names_replaces_none() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["set 1.mp4", "set 3.mp4"] {
            std::fs::write(folder.path().join(name), "an evening").unwrap();
        }
        let free = free_path(folder.path());
        assert_eq!(free, folder.path().join("set 2.mp4"));
        std::fs::write(&free, "another").unwrap();
        assert_eq!(free_path(folder.path()), folder.path().join("set 4.mp4"));
    }
}
