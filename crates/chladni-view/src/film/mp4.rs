//! MP4 through an ffmpeg child process.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::feed::Feed;
use super::ffmpeg::{add_input, ffmpeg, file_argument, unwritten_by_ffmpeg};
use super::whole::{UNFINISHED, is_whole};
use super::{Encode, FilmSettings, beside, on_black, persist};
use crate::cpu::halved_chroma;
use crate::{Picture, ViewError};

/// How the file is laid out.
pub(super) enum Layout {
    /// With its index in front, which is written in the end: the file appears when it is complete.
    Whole,
    /// In pieces of a second, which can be read without those that follow, and while they do. Encoded beside a show, in
    /// half of the time that the other takes and two thirds larger.
    Pieces,
}

/// Frames go into ffmpeg's standard input; it writes to a temporary file, or in pieces to the file itself.
pub(super) struct Mp4 {
    path: PathBuf,
    /// Before the file: what writes it ends first.
    feed: Feed,
    file: Option<tempfile::NamedTempFile>,
    opaque: Vec<u8>,
    planes: Vec<u8>,
}

impl Mp4 {
    pub(super) fn create(path: &Path, settings: &FilmSettings, layout: Layout) -> Result<Self, ViewError> {
        let file = match layout {
            Layout::Whole => Some(beside(path)?),
            Layout::Pieces => None,
        };
        let written = file.as_ref().map_or(path, |file| file.path());
        let mut command = ffmpeg();
        // H.264 with halved chroma needs even sides; players assume BT.709.
        let bt709 = [
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "bt709",
            "-color_range",
            "tv",
        ];
        command.args(["-y", "-nostdin", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "yuv420p"]);
        command.args(["-video_size", &format!("{}x{}", settings.width & !1, settings.height & !1)]);
        command.args(bt709);
        command.args(["-framerate", &format!("{}/{}", settings.rate.numerator, settings.rate.denominator)]);
        command.args(["-i", "pipe:0"]);
        if let Some(audio) = &settings.audio {
            add_input(&mut command, audio, &["wav"]);
            // Endless silence after the sound, cut where the pictures end: -shortest would let the sound run on.
            let length_secs = settings.rate.start_secs(settings.frames);
            command.args(["-map", "0:v", "-map", "1:a", "-af", "apad", "-t", &format!("{length_secs:.6}")]);
            command.args(["-c:a", "aac", "-b:a", "192k"]);
        }
        // The best H.264 encoder it has. The settings are those of libx264; others leave them aside. Encoding shares the
        // processor with drawing: `superfast` at 21 looks like `fast` at 18 in a quarter of its time, a third larger.
        let preset = match layout {
            Layout::Whole => "superfast",
            Layout::Pieces => "ultrafast",
        };
        command.args(["-c:v", "h264", "-preset", preset, "-crf", "21"]);
        command.args(bt709);
        command.args(match layout {
            Layout::Whole => &["-movflags", "+faststart"][..],
            Layout::Pieces => &[
                "-movflags",
                "+empty_moov+default_base_moof",
                "-frag_duration",
                "1000000",
                "-flush_packets",
                "1",
            ],
        });
        command.args(["-f", "mp4"]).arg(file_argument(written));
        let feed = Feed::start(&mut command).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => ViewError::NoFfmpeg,
            _ => ViewError::Ffmpeg(error.to_string()),
        })?;
        Ok(Self { path: path.to_owned(), file, feed, opaque: Vec::new(), planes: Vec::new() })
    }
}

impl Encode for Mp4 {
    fn frame(&mut self, picture: &Picture) -> Result<(), ViewError> {
        let rgba = on_black(&picture.rgba, &mut self.opaque);
        halved_chroma(rgba, [picture.width as usize, picture.height as usize], &mut self.planes);
        self.feed.write(&self.planes).map_err(|said| unwritten_by_ffmpeg(said, &self.path))
    }

    fn finish(mut self: Box<Self>) -> Result<(), ViewError> {
        self.feed.finish().map_err(|said| unwritten_by_ffmpeg(said, &self.path))?;
        let written = self.file.as_ref().map_or(self.path.as_path(), |file| file.path());
        let is_whole = File::open(written).and_then(|mut film| is_whole(&mut film));
        if !is_whole.map_err(ViewError::at(&self.path))? {
            return Err(unwritten_by_ffmpeg(self.feed.complaint(UNFINISHED), &self.path));
        }
        self.file.map_or(Ok(()), |file| persist(file, &self.path))
    }
}
