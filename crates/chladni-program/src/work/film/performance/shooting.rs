//! From a performance to the pictures of a film.

use std::time::Instant;

use chladni_music::{Action, FlashArea, LoggedAction, Switch, Viewpoint};
use chladni_synth::{Backend, Item};
use chladni_task::Task;
use chladni_view::film::shoot_retouched;
use chladni_view::{Canvas, Device, Draw, Figure, Film, Gpu, Look, Rect, Renderer, Samples, ViewError};

use super::{Done, Performance, Shot};
use crate::work::film::Seconds;
use crate::work::{Deformed, Error, FrameGuard, Scenery, Wardrobe, dots, look_on_stage};

/// A piece of a film starts drawing this much before its first frame: the flash guard has to know what was seen during
/// the last second, and so have trails.
const LEAD_SECS: f64 = 2.0;

/// The means to compute and draw; by default those that suit the device.
#[derive(Clone, Copy, Default)]
pub struct Means {
    pub draw: Draw,
    pub samples: Option<Samples>,
    pub synthesis: Backend,
}

impl Means {
    /// The device to draw on: shapes that a graphics device deforms stay there to be drawn.
    ///
    /// # Errors
    /// Shapes that are deformed where they cannot be drawn.
    pub fn drawing(self) -> Result<Draw, Error> {
        match (self.draw, self.synthesis) {
            (Draw::Auto, Backend::Gpu) => Ok(Draw::Gpu),
            (Draw::Cpu, Backend::Gpu) => {
                let why = "what --synthesis gpu deforms stays on the device: --draw cpu cannot see it";
                Err(Error::input(why))
            }
            (draw, _) => Ok(draw),
        }
    }
}

/// The device that drew.
pub struct Drawn {
    /// The adapter, or the processor.
    pub device: String,
    pub samples: Samples,
    /// The processor's instructions, or the device.
    pub synthesis: String,
    /// Whether the graphics device is a software device.
    pub software: bool,
}

impl Performance {
    /// Draws all frames of `film`, the first of which is frame `film.settings().first` of the performance, and finishes it.
    ///
    /// # Errors
    /// Cancelled; a sound, a dance, a picture or the file that fails. No unfinished film is left.
    pub fn film(
        &mut self,
        film: Film,
        (look, viewpoint, scenery): (&Look, &Viewpoint, &Scenery),
        means: Means,
        recording: bool,
        seconds: &mut Seconds,
        task: &Task,
    ) -> Result<Done, Error> {
        let (width, height) = (film.settings().width, film.settings().height);
        self.look = *look;
        let device = Device::open(means.drawing()?)?;
        let samples = means.samples.unwrap_or_else(|| device.live_samples());
        let canvas = Canvas::with_samples(&device, width, height, samples)?;
        let topology = self.staging.topology(&device, &self.triangles, None)?;
        let mut deformed = Deformed::new(&device, &self.model, topology, means.synthesis);
        let wardrobe = self.staging.wardrobe(&device)?;
        let (rate, mut done) = (self.rate, Done::default());
        let area = self.guarded_area();
        let mut guard = FrameGuard::new(area);
        done.warnings.extend(self.note_of_limit(area));
        let first = film.settings().first;
        let lead = rate.frames_in(LEAD_SECS).min(first);
        let begin = first - lead;
        self.play_until(begin, seconds, task)?;
        let (mut guarding, mut titles) = (0.0, std::mem::take(&mut self.titles));
        let start_secs = self.start_secs;
        if canvas.samples() != samples {
            done.warnings.push(format!("the processor draws {}, whatever --samples says", canvas.samples()));
        }
        let (mut surroundings, mut behind) = (scenery.on(&device)?, scenery.film()?);
        if let Some(film) = &behind {
            // The scenery has its first picture as the window shows it: smaller.
            surroundings = surroundings.before(&device, film.picture())?;
        }
        let mut renderer = Renderer::new(&device);
        renderer.surround(&surroundings)?;
        let draw = |renderer: &mut Renderer, canvas: &Canvas, frame| -> Result<(), Error> {
            let (shot, items) = self.play(begin + frame, seconds)?;
            if let Some(item) = items.first().filter(|_| recording && frame >= lead) {
                done.recording.push(shot.time_secs, self.instrument.parameters().form, item);
            }
            self.deform(&mut deformed, &items, &mut done, seconds)?;
            let drawing = Instant::now();
            if let Some(film) = &mut behind
                && film.go_to(start_secs + shot.time_secs, || true)?
            {
                surroundings = std::mem::take(&mut surroundings).before(&device, film.picture())?;
                renderer.surround(&surroundings)?;
            }
            self.draw((&deformed, &wardrobe), renderer, canvas, viewpoint, shot)?;
            seconds.drawing += drawing.elapsed().as_secs_f64();
            Ok(())
        };
        let retouch = |frame, picture: &mut _| {
            let start = Instant::now();
            let at_secs = rate.start_secs(begin + frame);
            guard.pass(at_secs, picture);
            titles.lay(start_secs + at_secs, picture);
            guarding += start.elapsed().as_secs_f64();
        };
        let waits = shoot_retouched(&mut renderer, &canvas, film, lead, task, draw, retouch)?;
        seconds.drawing += waits.device_secs;
        seconds.encoding += waits.encoder_secs;
        seconds.guarding += guarding;
        done.most_flashes = guard.most_flashes();
        done.longest_stripes_secs = guard.longest_stripes_secs();
        done.damped_frames = guard.damped_frames();
        if lead > 0 && done.damped_frames > 0 {
            done.warnings.push(
                "the flash guard acted, which knows only the last two seconds before a piece: its first frames may be \
                 veiled otherwise than in the whole film"
                    .into(),
            );
        }
        done.drawn = Some(Drawn {
            device: device.description(),
            samples: canvas.samples(),
            synthesis: deformed.device_name(),
            software: device.gpu().is_some_and(Gpu::is_software),
        });
        Ok(done)
    }

    /// How large a flash must be for the guard to act; none where it never does. A limit that is on at any time of the show
    /// holds for all of it.
    fn guarded_area(&self) -> Option<FlashArea> {
        let is_limited = self.fields_judged || self.is_ever(Switch::FlashLimit, true);
        if self.flashes_allowed || !is_limited {
            return None;
        }
        let judges_fields = self.fields_judged || self.is_ever(Switch::FlashFields, true);
        Some(if judges_fields { FlashArea::Field } else { FlashArea::Screen })
    }

    /// A warning where the film is guarded and the show is not.
    fn note_of_limit(&self, area: Option<FlashArea>) -> Option<String> {
        let is_asked_for = area.is_none() || self.fields_judged;
        (!is_asked_for && self.is_ever(Switch::FlashLimit, false)).then(|| {
            "the limit of flashes, which is off in a part of the show, is on in all of the film; dance \
             --allow-flashes films without it"
                .into()
        })
    }

    /// Whether a switch is so now, or is turned so later in the show.
    fn is_ever(&self, switch: Switch, on: bool) -> bool {
        let turned = |line: LoggedAction| match line.action {
            Action::Switch { switch: turned, on: so } => turned == switch && so == on,
            Action::Take { preset, .. } => preset.settings.switches.get(&switch) == Some(&on),
            _ => false,
        };
        self.instrument.parameters().is_on(switch) == on || self.script.clone().any(turned)
    }

    /// Deforms the shape for one picture, and notes how that went.
    fn deform(
        &self,
        deformed: &mut Deformed,
        items: &[Item],
        done: &mut Done,
        seconds: &mut Seconds,
    ) -> Result<(), Error> {
        let settings = self.instrument.parameters().frame_settings();
        let [synthesis_secs, normals_secs] = deformed.synthesize(items, &settings)?;
        seconds.synthesis += synthesis_secs;
        seconds.normals += normals_secs;
        if let Some(fallback) = deformed.take_fallback() {
            done.warnings.push(fallback.to_string());
        }
        if let Some(displacement) = deformed.largest_displacement() {
            let share = displacement / self.ensemble.dancer().box_diagonal;
            done.largest_displacement = Some(done.largest_displacement.map_or(share, |most| most.max(share)));
        }
        Ok(())
    }

    /// Draws one picture.
    fn draw(
        &mut self,
        (deformed, wardrobe): (&Deformed, &Wardrobe),
        renderer: &mut Renderer,
        canvas: &Canvas,
        viewpoint: &Viewpoint,
        Shot { time_secs, reaction, framing, mood, count }: Shot,
    ) -> Result<(), ViewError> {
        let buffers = deformed.buffers()?;
        let area = Rect::of_size(canvas.width(), canvas.height());
        let instrument = &self.instrument;
        let on_stage = look_on_stage(instrument, self.look);
        let look = on_stage.answering(&mood);
        let from = (viewpoint, framing.as_ref());
        let staged = self.staging.set(area, count, from, &look, reaction, instrument);
        let grains = self.sand.drawn(&on_stage);
        let figure = |item| Figure {
            grains: grains.get(item).copied(),
            ..staged.figure(&deformed.topology, &buffers, item, wardrobe)
        };
        let figures: Vec<Figure<'_>> = (0..count).map(figure).collect();
        let cell = staged.viewports.first().copied().unwrap_or(area);
        let dots = match self.shows_rest {
            true => dots(self.model.rest_positions().iter().copied(), cell),
            false => Vec::new(),
        };
        let mut cells = staged.cells(&figures);
        // The first is the background.
        cells.iter_mut().skip(1).for_each(|cell| cell.markers = &dots);
        renderer.draw_finished(canvas, &cells, &staged.look.finish, self.start_secs + time_secs)?;
        Ok(())
    }
}
