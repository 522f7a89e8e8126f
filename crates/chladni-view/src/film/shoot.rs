//! Drawing, fetching and encoding at the same time.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};
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
    /// For retouching and encoding beside it.
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
/// encoded, on a thread of its own, some frames after it was drawn.
///
/// # Errors
/// See [`shoot`].
pub fn shoot_retouched<E: From<ViewError>>(
    renderer: &mut Renderer,
    canvas: &Canvas,
    film: Film,
    lead: u64,
    task: &Task,
    mut draw: impl FnMut(&mut Renderer, &Canvas, u64) -> Result<(), E>,
    retouch: impl FnMut(u64, &mut Picture) + Send,
) -> Result<Waits, E> {
    let device = renderer.device().clone();
    let frames = lead + film.settings().frames;
    let stage = task.stage("filming", frames);
    std::thread::scope(|scope| {
        let mut desk = Desk::open(scope, film, lead, retouch)?;
        let mut idle: Vec<Readback> =
            (0..IN_FLIGHT).map(|_| Readback::new(&device, canvas)).collect::<Result<_, _>>()?;
        let mut flying: VecDeque<Readback> = VecDeque::with_capacity(IN_FLIGHT);
        let mut device_secs = 0.0;
        let fetch = |readback: &mut Readback, desk: &mut Desk<'_>| -> Result<f64, ViewError> {
            let mut picture = desk.spent();
            (picture.width, picture.height) = (canvas.width(), canvas.height());
            let start = Instant::now();
            readback.finish_into(&device, &mut picture.rgba)?;
            let fetching_secs = start.elapsed().as_secs_f64();
            desk.hand(picture)?;
            stage.advance(1);
            Ok(fetching_secs)
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
                    device_secs += fetch(&mut oldest, &mut desk)?;
                    oldest
                }
            };
            let start = Instant::now();
            readback.take(&device, before)?;
            device_secs += start.elapsed().as_secs_f64();
            flying.push_back(readback);
        }
        for mut readback in flying {
            task.check().map_err(ViewError::from)?;
            device_secs += fetch(&mut readback, &mut desk)?;
        }
        Ok(Waits { device_secs, encoder_secs: desk.close()? })
    })
}

/// Where pictures are retouched and encoded, while the next ones are drawn.
struct Desk<'scope> {
    /// None once it has ended.
    thread: Option<ScopedJoinHandle<'scope, Result<(), ViewError>>>,
    pictures: Option<SyncSender<Picture>>,
    /// To be filled again.
    spent: Receiver<Picture>,
    waited_secs: f64,
}

impl<'scope> Desk<'scope> {
    fn open<'env>(
        scope: &'scope Scope<'scope, 'env>,
        mut film: Film,
        lead: u64,
        mut retouch: impl FnMut(u64, &mut Picture) + Send + 'scope,
    ) -> Result<Self, ViewError> {
        let (pictures, waiting) = sync_channel::<Picture>(1);
        let (give_back, spent) = channel();
        let work = move || {
            for (frame, mut picture) in (0..).zip(waiting) {
                retouch(frame, &mut picture);
                if frame >= lead {
                    film.push(&picture)?;
                }
                // Nobody takes it after the last frame.
                let _ = give_back.send(picture);
            }
            film.finish()
        };
        let thread = Builder::new()
            .name("film".into())
            .spawn_scoped(scope, work)
            .map_err(|error| ViewError::Film(format!("no thread to encode on: {error}")))?;
        Ok(Self { thread: Some(thread), pictures: Some(pictures), spent, waited_secs: 0.0 })
    }

    fn spent(&self) -> Picture {
        self.spent.try_recv().unwrap_or_default()
    }

    /// Hands the next picture over; waits while one lies there.
    fn hand(&mut self, picture: Picture) -> Result<(), ViewError> {
        let start = Instant::now();
        let is_taken = self.pictures.as_ref().is_some_and(|pictures| pictures.send(picture).is_ok());
        self.waited_secs += start.elapsed().as_secs_f64();
        if is_taken { Ok(()) } else { self.end() }
    }

    /// Waits for the end of the film; says how long all waits were.
    fn close(mut self) -> Result<f64, ViewError> {
        let start = Instant::now();
        self.end()?;
        Ok(self.waited_secs + start.elapsed().as_secs_f64())
    }

    fn end(&mut self) -> Result<(), ViewError> {
        self.pictures = None;
        match self.thread.take().map(ScopedJoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) | None => Err(ViewError::Film("its encoder stopped".into())),
        }
    }
}
