//! Drawings that turn once around.

use chladni_task::Task;

use super::{Drawing, Ink, Plate};
use crate::{Camera, Film, Rect, Turntable, ViewError};

/// Films `plates`, each in its cell, turning once around in ink, and finishes the film; seen from `from`, moved back so
/// that nothing leaves its cell at any angle. Lines and tones follow the surface; hatching is laid anew in each frame.
///
/// # Errors
/// [`ViewError::Cancelled`], and whatever the film says.
pub fn film_turntable(
    plates: &[(Plate, Rect)],
    ink: &Ink,
    from: Camera,
    mut film: Film,
    task: &Task,
) -> Result<(), ViewError> {
    let (width, height, frames) = (film.settings().width, film.settings().height, film.settings().frames);
    let points: Vec<[f32; 3]> = plates.iter().flat_map(|(plate, _)| &plate.single).copied().collect();
    let aspect = plates.iter().map(|(_, cell)| cell.aspect()).fold(f32::INFINITY, f32::min);
    let turntable = Turntable::new(from, &points, aspect, frames);
    let stage = task.stage("drawing", frames);
    for frame in 0..frames {
        task.check().map_err(ViewError::from)?;
        let camera = turntable.at(frame);
        let mut drawing = Drawing::new(width, height, ink)?;
        for (plate, cell) in plates {
            drawing.add(plate, ink, &camera, *cell);
        }
        film.push(&drawing.to_picture())?;
        stage.advance(1);
    }
    film.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FilmSettings, FrameRate, Picture, View};
    use chladni_mesh::samples::icosphere;

    #[test]
    fn a_flat_body_looks_the_same_half_a_turn_later_and_not_a_quarter() {
        let mut ball = icosphere(3);
        ball.positions.iter_mut().for_each(|p| p[0] *= 0.4);
        let plate = Plate::new(&ball.positions, &ball.triangles, 0.01).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("turn");
        let rate = FrameRate::per_second(8);
        let settings = FilmSettings { width: 96, height: 72, rate, frames: 4, first: 0, audio: None };
        let ink = Ink { hatching: 0.0, tones: 2, ..Ink::default() };
        let from = Camera::looking(View::Front);
        let plates = [(plate, Rect::of_size(96, 72))];
        let film = |task: &Task| {
            let film = Film::create(&path, settings.clone()).unwrap();
            film_turntable(&plates, &ink, from, film, task)
        };
        film(&Task::new()).unwrap();
        let mut files: Vec<_> = std::fs::read_dir(&path).unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        // From the contour on the left to that on the right.
        let widths: Vec<u32> = files
            .iter()
            .map(|file| Picture::decode(&std::fs::read(file).unwrap()).unwrap())
            .map(|picture| {
                let inked: Vec<u32> = (0..96).filter(|x| picture.pixel(*x, 36).unwrap()[0] < 245).collect();
                inked[inked.len() - 1] - inked[0]
            })
            .collect();
        assert_eq!(widths.len(), 4);
        assert!(widths[0].abs_diff(widths[2]) <= 2 && widths[1] > widths[0] + 10, "{widths:?}");
        let task = Task::new();
        task.cancel();
        assert!(matches!(film(&task), Err(ViewError::Cancelled(_))));
    }
}
