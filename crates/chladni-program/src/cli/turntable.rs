//! `caricature --turntable`: the result turning once around, as a film.

use std::path::{Path, PathBuf};

use chladni_mesh::surface::vec3::single;
use chladni_view::{
    Camera, Film, FilmSettings, FrameRate, PictureRequest, PictureShape, Rect, Renderer, Style,
    film_turntable,
};

use super::Terminal;
use super::ink::InkOptions;
use super::number::number;
use crate::work::outputs::{earlier_frames, odd_sides};
use crate::work::{Error, Inked, OwnLook, Sculpture, Watcher};

/// A film of the result.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct TurntableOptions {
    /// Film the result turning once around: .mp4 (through ffmpeg, of even sides), .gif, .png or .apng (animated), or a
    /// folder of pictures. In ink with --ink.
    #[arg(long, value_name = "FILM", conflicts_with = "batch")]
    pub turntable: Option<PathBuf>,
    /// How long the turn takes.
    #[arg(long, value_name = "SECS", requires = "turntable", conflicts_with = "batch",
        default_value_t = 6.0, allow_negative_numbers = true, value_parser = secs)]
    turn_secs: f64,
}

fn secs(text: &str) -> Result<f64, Error> {
    number(text, |x| (0.1..=120.0).contains(x), "a number of seconds from 0.1 to 120")
}

const FRAMES_A_SECOND: u32 = 25;

impl TurntableOptions {
    /// Films the result in the shape's `own` look, seen from where `from` stands.
    pub fn film(
        &self,
        path: &Path,
        sculpture: &Sculpture,
        own: Option<&OwnLook>,
        from: Camera,
        [width, height]: [u32; 2],
        ink: &InkOptions,
        terminal: &Terminal,
    ) -> Result<(), Error> {
        let rate = FrameRate::per_second(FRAMES_A_SECOND);
        let frames = rate.frames_in(self.turn_secs);
        terminal.warn_each(earlier_frames(path, frames));
        terminal.warn_each(odd_sides(path, [width, height]));
        let film = Film::create(path, FilmSettings { width, height, rate, frames, first: 0, audio: None })?;
        let positions = single(&sculpture.evaluation.result.positions);
        let triangles = &sculpture.body.triangles;
        let label = "filming the turntable";
        if ink.is_asked_for() {
            let (pen, cell) = (ink.pen(), Rect::of_size(width, height));
            let shapes = [Inked::moved(&positions, sculpture.body.positions.iter().copied())];
            let plates: Vec<_> =
                pen.plates(&shapes, triangles)?.into_iter().map(|plate| (plate, cell)).collect();
            let style = pen.ink;
            let filmed = terminal
                .watch(label, |task| chladni_view::ink::film_turntable(&plates, &style, from, film, task));
            return Ok(filmed?);
        }
        let colors = own.and_then(OwnLook::colors);
        let shapes = [PictureShape {
            positions: &positions,
            triangles,
            colors: colors.as_deref(),
            image: own.and_then(OwnLook::image),
            ..PictureShape::default()
        }];
        let request = PictureRequest { shapes: &shapes, width, height, from, style: Style::default() };
        let mut renderer = Renderer::new(terminal.device()?);
        Ok(terminal.watch(label, |task| film_turntable(&mut renderer, &request, film, task))?)
    }
}
