//! Users' own pictures around a dance, from their files.

use std::path::Path;

use chladni_view::{Device, Panorama, Picture, Surroundings, ViewError};

use super::Error;
use super::back_film::{BackFilm, LONGEST_LIVE_SIDE, LONGEST_SIDE, is_film};
use super::live_back_film::LiveBackFilm;

/// The endings of files that may stand behind a shape, and of those that may shine on it.
pub const PICTURES: [&str; 3] = ["png", "jpg", "jpeg"];
/// As [`PICTURES`].
pub const PANORAMAS: [&str; 4] = ["hdr", "png", "jpg", "jpeg"];

/// No such file is larger.
const MOST_BYTES: u64 = 256 << 20;

/// The pictures and films read from these files.
#[derive(Clone, Debug, Default)]
pub struct Scenery {
    /// The picture behind; the first one if it is a film.
    behind: Option<Picture>,
    /// The film's name.
    film: Option<String>,
    around: Option<Panorama>,
}

impl Scenery {
    /// Reads the picture that stands behind, or the first one of a film, and the panorama that shines; empty names are
    /// none.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a picture of this kind; a film without ffmpeg.
    pub fn open(picture: &str, panorama: &str) -> Result<Self, Error> {
        let (scenery, failures) = Self::readable(picture, panorama);
        failures.into_iter().next().map_or(Ok(scenery), Err)
    }

    /// The same without what cannot be read, and why that cannot.
    pub fn readable(picture: &str, panorama: &str) -> (Self, Vec<Error>) {
        let mut failures = Vec::new();
        let behind = if is_film(picture) {
            BackFilm::open(picture, LONGEST_LIVE_SIDE).map(|film| Some(film.picture().clone()))
        } else {
            read(picture, opaque)
        };
        let behind = behind.unwrap_or_else(|why| {
            failures.push(why);
            None
        });
        let around = read(panorama, Panorama::decode).unwrap_or_else(|why| {
            failures.push(why);
            None
        });
        let film = (is_film(picture) && behind.is_some()).then(|| picture.to_owned());
        (Self { behind, film, around }, failures)
    }

    /// The film that stands behind, where it is one.
    ///
    /// # Errors
    /// As those of [`open`](Self::open).
    pub fn film(&self) -> Result<Option<BackFilm>, Error> {
        self.film.as_deref().map(|name| BackFilm::open(name, LONGEST_SIDE)).transpose()
    }

    /// The same for those who cannot wait for its pictures.
    pub fn live_film(&self) -> Option<LiveBackFilm> {
        self.film.as_deref().map(|name| LiveBackFilm::open(name.to_owned(), LONGEST_LIVE_SIDE))
    }

    /// For those who draw on `device`.
    ///
    /// # Errors
    /// A picture that is too long for the device.
    pub fn on(&self, device: impl Into<Device>) -> Result<Surroundings, ViewError> {
        Surroundings::new(device, self.behind.as_ref(), self.around.as_ref())
    }
}

/// A picture that stands as the camera was held, over black where it is translucent.
fn opaque(bytes: &[u8]) -> Result<Picture, ViewError> {
    let mut picture = Picture::decode_upright(bytes)?;
    for pixel in picture.rgba.as_chunks_mut::<4>().0 {
        let [r, g, b] = Picture::on_black(*pixel);
        *pixel = [r, g, b, 255];
    }
    Ok(picture)
}

fn read<T>(name: &str, decode: fn(&[u8]) -> Result<T, ViewError>) -> Result<Option<T>, Error> {
    if name.is_empty() {
        return Ok(None);
    }
    let unread = |why: std::io::Error| Error::Input(format!("{name}: {why}"));
    let bytes = chladni_task::read_file(Path::new(name), MOST_BYTES).map_err(unread)?;
    decode(&bytes).map(Some).map_err(|error| Error::Input(format!("{name}: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_translucent_picture_stands_over_black() {
        let folder = tempfile::tempdir().unwrap();
        let name = folder.path().join("logo.png").to_string_lossy().into_owned();
        let rgba = vec![255, 0, 255, 0, 200, 100, 50, 128, 10, 20, 30, 255];
        std::fs::write(&name, Picture { width: 3, height: 1, rgba }.to_png().unwrap()).unwrap();
        let behind = Scenery::open(&name, "").unwrap().behind.unwrap();
        assert_eq!(behind.rgba, [0, 0, 0, 255, 100, 50, 25, 255, 10, 20, 30, 255]);
    }

    #[test]
    fn what_is_no_picture_is_told_in_one_line_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        std::fs::write(path("text.png"), "no picture").unwrap();
        std::fs::write(path("square.png"), Picture::filled(8, 8, [9; 4]).to_png().unwrap()).unwrap();
        std::fs::write(path("wide.png"), Picture::filled(16, 8, [90; 4]).to_png().unwrap()).unwrap();
        let open = |picture: &str, panorama: &str| {
            let named = |name: &str| if name.is_empty() { String::new() } else { path(name) };
            Scenery::open(&named(picture), &named(panorama))
        };
        assert!(open("", "").is_ok() && open("square.png", "wide.png").is_ok());
        for (picture, panorama) in [("text.png", ""), ("gone.png", ""), ("", "text.png"), ("", "square.png")]
        {
            let error = open(picture, panorama).unwrap_err();
            let line = error.to_string();
            assert!(line.contains(&path(picture.max(panorama))) && !line.contains('\n'), "{line}");
        }
        // One that is missing takes nothing from the other.
        for gone in ["gone.png", "gone.mp4"] {
            let (scenery, failures) = Scenery::readable(&path(gone), &path("wide.png"));
            assert!(scenery.behind.is_none() && scenery.film.is_none() && scenery.around.is_some());
            assert_eq!(failures.len(), 1);
        }
        let (scenery, failures) = Scenery::readable(&path("square.png"), &path("gone.hdr"));
        assert!(scenery.behind.is_some() && scenery.around.is_none() && failures.len() == 1);
    }
}
