//! Drawing, fetching and encoding at the same time.

use std::collections::VecDeque;

use chladni_task::Task;

use super::Film;
use crate::canvas::Readback;
use crate::{Canvas, Renderer, ViewError};

/// Frames that may be on their way back from the device.
const IN_FLIGHT: usize = 3;

/// Draws all frames of `film` and finishes it. `draw` gets the index of the frame and draws on
/// the canvas; while the device works on it, earlier frames are fetched and encoded. Progress
/// counts frames.
///
/// # Errors
/// Whatever `draw` returns, whatever stops the film, and [`ViewError::Cancelled`]; in each case no
/// file is left.
pub fn shoot<E: From<ViewError>>(
    renderer: &mut Renderer,
    canvas: &Canvas,
    mut film: Film,
    task: &Task,
    mut draw: impl FnMut(&mut Renderer, &Canvas, u64) -> Result<(), E>,
) -> Result<(), E> {
    let gpu = renderer.gpu().clone();
    let frames = film.settings().frames;
    let stage = task.stage("filming", frames);
    let mut idle: Vec<Readback> = (0..IN_FLIGHT).map(|_| Readback::new(&gpu, canvas)).collect();
    let mut flying: VecDeque<Readback> = VecDeque::with_capacity(IN_FLIGHT);
    let fetch = |readback: &mut Readback, film: &mut Film| -> Result<(), ViewError> {
        let mut picture = film.spent();
        (picture.width, picture.height) = (canvas.width(), canvas.height());
        readback.finish_into(&gpu, &mut picture.rgba)?;
        film.push(picture)?;
        stage.advance(1);
        Ok(())
    };
    for frame in 0..frames {
        task.check().map_err(ViewError::from)?;
        let mut readback = match idle.pop() {
            Some(readback) => readback,
            None => {
                // All are flying: the oldest lands.
                let Some(mut oldest) = flying.pop_front() else { break };
                fetch(&mut oldest, &mut film)?;
                oldest
            }
        };
        draw(renderer, canvas, frame)?;
        readback.start(renderer.gpu(), canvas);
        flying.push_back(readback);
    }
    for mut readback in flying {
        task.check().map_err(ViewError::from)?;
        fetch(&mut readback, &mut film)?;
    }
    film.finish()?;
    Ok(())
}
