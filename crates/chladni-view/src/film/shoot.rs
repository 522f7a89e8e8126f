//! Drawing, fetching and encoding at the same time.

use std::collections::VecDeque;
use std::time::Instant;

use chladni_task::Task;

use super::Film;
use crate::canvas::Readback;
use crate::{Canvas, Picture, Renderer, ViewError};

/// Frames that may be on their way back from the device.
const IN_FLIGHT: usize = 3;

/// How long the caller had to wait for drawing and for encoding, which run at the same time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waits {
    /// For finished pictures, with fetching them.
    pub device_secs: f64,
    /// For the encoder.
    pub encoder_secs: f64,
}

/// Draws all frames of `film` and finishes it. `draw` gets the index of the frame and draws on
/// the canvas it gets, which is `canvas` or one like it; while the device works on it, earlier frames are
/// fetched and encoded. Progress counts frames.
///
/// # Errors
/// Whatever `draw` returns, whatever stops the film, and [`ViewError::Cancelled`]; in each case no
/// file is left.
pub fn shoot<E: From<ViewError>>(
    renderer: &mut Renderer,
    canvas: &Canvas,
    film: Film,
    task: &Task,
    draw: impl FnMut(&mut Renderer, &Canvas, u64) -> Result<(), E>,
) -> Result<(), E> {
    shoot_retouched(renderer, canvas, film, 0, task, draw, |_, _| ())?;
    Ok(())
}

/// As [`shoot`], with `lead` more frames before those of the film. They are drawn and retouched but not encoded;
/// indices count from the first of them. `retouch` gets the index of each frame and its picture, in order, before it is
/// encoded, some frames after it was drawn.
///
/// # Errors
/// See [`shoot`].
pub fn shoot_retouched<E: From<ViewError>>(
    renderer: &mut Renderer,
    canvas: &Canvas,
    mut film: Film,
    lead: u64,
    task: &Task,
    mut draw: impl FnMut(&mut Renderer, &Canvas, u64) -> Result<(), E>,
    mut retouch: impl FnMut(u64, &mut Picture),
) -> Result<Waits, E> {
    let device = renderer.device().clone();
    let frames = lead + film.settings().frames;
    let stage = task.stage("filming", frames);
    let mut idle: Vec<Readback> =
        (0..IN_FLIGHT).map(|_| Readback::new(&device, canvas)).collect::<Result<_, _>>()?;
    let mut flying: VecDeque<Readback> = VecDeque::with_capacity(IN_FLIGHT);
    let (mut waits, mut fetched, mut starting_secs) = (Waits::default(), 0, 0.0);
    let mut fetch = |readback: &mut Readback, film: &mut Film| -> Result<(), ViewError> {
        let mut picture = film.spent();
        (picture.width, picture.height) = (canvas.width(), canvas.height());
        let start = Instant::now();
        readback.finish_into(&device, &mut picture.rgba)?;
        waits.device_secs += start.elapsed().as_secs_f64();
        retouch(fetched, &mut picture);
        fetched += 1;
        let start = Instant::now();
        if fetched > lead {
            film.push(picture)?;
        }
        waits.encoder_secs += start.elapsed().as_secs_f64();
        stage.advance(1);
        Ok(())
    };
    // Two canvases: the next frame is begun before the last one is asked for.
    let twin = canvas.twin(&device)?;
    for frame in 0..=frames {
        task.check().map_err(ViewError::from)?;
        let (on, before) = if frame % 2 == 0 { (canvas, &twin) } else { (&twin, canvas) };
        if frame < frames {
            draw(renderer, on, frame)?;
        }
        if frame == 0 {
            continue;
        }
        let mut readback = match idle.pop() {
            Some(readback) => readback,
            None => {
                // All are flying: the oldest lands.
                let Some(mut oldest) = flying.pop_front() else { break };
                fetch(&mut oldest, &mut film)?;
                oldest
            }
        };
        let start = Instant::now();
        readback.start(&device, before)?;
        starting_secs += start.elapsed().as_secs_f64();
        flying.push_back(readback);
    }
    for mut readback in flying {
        task.check().map_err(ViewError::from)?;
        fetch(&mut readback, &mut film)?;
    }
    waits.device_secs += starting_secs;
    let start = Instant::now();
    film.finish()?;
    waits.encoder_secs += start.elapsed().as_secs_f64();
    Ok(waits)
}
