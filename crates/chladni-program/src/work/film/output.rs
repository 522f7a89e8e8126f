//! The files of a film, and how its pictures are drawn.

use std::ops::Range;
use std::path::{Path, PathBuf};

use chladni_music::GALLERY_SIZES;
use chladni_synth::Backend;
use chladni_task::counted;
use chladni_view::film::{RawFormat, frame_path};
use chladni_view::{Draw, FilmFormat, FilmSettings, FrameRate, Samples};

use super::performance::Means;
use super::{preset_in, sound_beside, sound_in};
use crate::work::formats::ends_in;
use crate::work::outputs::{check_apart, check_arrays, check_distinct, check_file, check_film, check_folder};
use crate::work::{Cast, Error, Piece};

/// Morph targets of an animation unless said.
pub const TARGETS: usize = 48;
/// The largest number of them: more than programs can show in one mesh.
const MOST_TARGETS: usize = 1024;

/// The files to write, and how their pictures are drawn.
#[derive(Clone, Debug)]
pub struct Output {
    /// The film's file or folder; none is drawn without.
    pub film: Option<PathBuf>,
    /// It is a folder of pictures, with the sound beside them.
    pub is_folder: bool,
    /// Only these frames are made, exactly those of the whole film; an MP4 of them has no sound.
    pub piece: Option<Piece>,
    /// Frames that are in the folder already stay as they are.
    pub resume: bool,
    /// The film's frames go to standard output as they are, silent.
    pub pipe: Option<RawFormat>,
    /// Where the shape goes with its movement, as a GLB file with morph targets; its sound lies beside it.
    pub animation: Option<PathBuf>,
    /// The largest number of morph targets.
    pub targets: usize,
    /// Where the coefficients of every frame go.
    pub coefficients: Option<PathBuf>,
    /// Where the mapping of each item of the gallery goes, as presets.
    pub presets: Option<PathBuf>,
    /// The shape at rest is shown, too, as dots.
    pub shows_rest: bool,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Frames a second.
    pub rate: FrameRate,
    /// The choice of the device that draws.
    pub draw: Draw,
    /// Samples of each pixel; by default as many as suit the device.
    pub samples: Option<Samples>,
    /// The choice of the device that deforms.
    pub synthesis: Backend,
    /// More than three a second.
    pub allow_flashes: bool,
    /// They are counted in any field of view of 10°, too.
    pub flash_fields: bool,
    /// Songs are named as they begin, as on stage.
    pub titles: bool,
}

impl Output {
    /// To one file: an animation where it ends in .glb, else a film in HD, 30 frames a second, drawn by
    /// whatever device there is.
    pub fn to(path: PathBuf) -> Self {
        if ends_in(&path, &["glb"]) {
            Self { animation: Some(path), ..Self::nowhere() }
        } else {
            Self { film: Some(path), ..Self::nowhere() }
        }
    }

    /// To a folder of pictures, drawn like those of [`to`](Self::to), with the sound beside them.
    pub fn frames(folder: PathBuf) -> Self {
        Self { film: Some(folder), is_folder: true, ..Self::nowhere() }
    }

    /// No file at all.
    pub fn nowhere() -> Self {
        Self {
            film: None,
            is_folder: false,
            piece: None,
            resume: false,
            pipe: None,
            animation: None,
            targets: TARGETS,
            coefficients: None,
            presets: None,
            shows_rest: false,
            width: 1280,
            height: 720,
            rate: FrameRate::per_second(30),
            draw: Draw::Auto,
            samples: None,
            synthesis: Backend::Auto,
            allow_flashes: false,
            flash_fields: false,
            titles: false,
        }
    }

    /// How its pictures are computed and drawn.
    pub(super) fn means(&self) -> Means {
        Means { draw: self.draw, samples: self.samples, synthesis: self.synthesis }
    }

    /// The folder of pictures, where it is one.
    pub(super) fn folder(&self) -> Option<&Path> {
        self.film.as_deref().filter(|_| self.is_folder)
    }

    /// The one file of the film or the animation, where it is there already and is to stay. An animation without the
    /// sound beside it was not finished.
    pub fn kept(&self) -> Option<&Path> {
        let film = self.film.as_deref().filter(|path| !self.is_folder && path.is_file());
        let is_whole = |path: &&Path| path.is_file() && sound_beside(path).is_file();
        film.or_else(|| self.animation.as_deref().filter(is_whole)).filter(|_| self.resume)
    }

    /// Which of `total` frames have to be made; none if all exist already.
    pub(super) fn range(&self, total: u64) -> Result<Range<u64>, Error> {
        let Range { start, end } = match &self.piece {
            None => 0..total,
            Some(piece) => piece.frames(total).ok_or_else(|| {
                Error::Input(format!("--piece: the film has {}", counted(total, "frame", "frames")))
            })?,
        };
        if self.kept().is_some() {
            return Ok(end..end);
        }
        let folder = self.folder().filter(|_| self.resume);
        let is_there = |frame: &u64| folder.is_some_and(|folder| frame_path(folder, *frame).is_file());
        Ok((start..end).find(|frame| !is_there(frame)).unwrap_or(end)..end)
    }

    /// Checks, before any work, that it can be written.
    pub(super) fn check(&self) -> Result<(), Error> {
        if self.piece.is_some() && self.animation.is_some() {
            return Err(Error::input("--piece: a GLB holds the whole dance"));
        }
        if self.film.is_some() || self.pipe.is_some() {
            self.means().drawing()?;
        }
        if let Some(path) = &self.film {
            let format = self.format_of(path)?;
            let settings = FilmSettings {
                width: self.width,
                height: self.height,
                rate: self.rate,
                frames: 1,
                first: 0,
                audio: None,
            };
            settings.check_for(format).map_err(Error::input)?;
            let others = ".gif, .png, .glb, --frames and -o -";
            if self.is_folder { check_folder(path) } else { check_film(path, others) }?;
        }
        if let Some(path) = &self.animation {
            if !(1..=MOST_TARGETS).contains(&self.targets) {
                let why = format!("--targets {}: from 1 to {MOST_TARGETS} are possible", self.targets);
                return Err(Error::Input(why));
            }
            check_file(path)?;
        }
        self.presets.as_deref().map_or(Ok(()), check_folder)?;
        self.coefficients.as_deref().map_or(Ok(()), check_arrays)?;
        let files = self.files();
        check_distinct(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>())
    }

    /// The format of the film at `path`: pictures in a folder, however that is called, else what the name says.
    pub(super) fn format_of(&self, path: &Path) -> Result<FilmFormat, Error> {
        if self.is_folder {
            return Ok(FilmFormat::Frames);
        }
        match FilmFormat::of(path) {
            Err(_) | Ok(FilmFormat::Frames) => {
                let path = path.display();
                Err(Error::Input(format!(
                    "{path}: a film ends in .mp4, .gif or .png, and a shape with its movement in .glb; for a folder \
                     use --frames"
                )))
            }
            Ok(FilmFormat::Gif) if self.piece.is_some() => Err(Error::input(
                "--piece: a GIF has one palette for all frames: use --frames, -o -, or .mp4",
            )),
            Ok(format) => Ok(format),
        }
    }

    /// Checks that none of its files replaces one of `inputs`.
    pub(super) fn check_apart(&self, inputs: &[&Path]) -> Result<(), Error> {
        self.files().iter().try_for_each(|file| check_apart(file, inputs))?;
        let Some(folder) = self.folder() else { return Ok(()) };
        let mut frames = inputs.iter().filter(|input| is_frame_of(folder, input));
        frames.try_for_each(|frame| check_apart(frame, inputs))
    }

    /// Checks that none of its files replaces a texture of `cast`.
    pub(super) fn check_textures(&self, cast: &Cast) -> Result<(), Error> {
        let files = self.files();
        cast.check_textures(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>())
    }

    /// The files that are written, presets for as many items as a gallery may have; without the pictures in a folder.
    fn files(&self) -> Vec<PathBuf> {
        let film = self.film.clone().filter(|_| !self.is_folder);
        let beside = self.animation.as_deref().map(sound_beside);
        let within = self.folder().map(sound_in);
        let files = [film, self.animation.clone(), self.coefficients.clone(), beside, within];
        let items = GALLERY_SIZES.into_iter().max().unwrap_or(0);
        let presets = self.presets.iter().flat_map(|folder| (0..items).map(|item| preset_in(folder, item)));
        files.into_iter().flatten().chain(presets).collect()
    }
}

/// Whether `file` lies in `folder` and has the name of a frame there.
fn is_frame_of(folder: &Path, file: &Path) -> bool {
    let number = |file: &Path| {
        let name = file.file_name()?.to_str()?;
        name.strip_prefix("frame-")?.strip_suffix(".png")?.parse::<u64>().ok()
    };
    let (Ok(folder), Ok(file)) = (folder.canonicalize(), file.canonicalize()) else { return false };
    number(&file).is_some_and(|number| frame_path(&folder, number) == file)
}
