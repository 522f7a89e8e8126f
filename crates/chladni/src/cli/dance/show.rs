//! Frame after frame: actions, sound, shape, picture.

use std::time::Instant;

use chladni_harmonics::Body;
use chladni_music::{Beat, Ensemble, Instrument, LoggedAction, Moment, Parameter, Switch, react};
use chladni_sound::Song;
use chladni_synth::{AutoSynthesizer, Backend, FrameSettings, GpuContext, Item, SynthModel, Synthesizer};
use chladni_task::Task;
use chladni_view::film::shoot_retouched;
use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, Film, FrameRate, Gpu, ItemBuffers, Lights, Material, Rect,
    Renderer, Samples, Topology, ViewError, layout,
};

use super::guard::FrameGuard;
use super::hearing::Hearing;
use super::record::Recording;
use super::{Seconds, failure, view_failure};
use crate::cli::Failure;
use crate::cli::sheet::dots;

/// How the film looks.
pub struct Look {
    pub lights: Lights,
    pub material: Material,
    pub background: Background,
    pub yaw_rad: f32,
    /// The shape at rest is shown, too.
    pub rest: bool,
}

/// Who computes and draws; where nothing is said, what suits the device.
#[derive(Clone, Copy, Default)]
pub struct Means {
    pub samples: Option<Samples>,
    pub synthesis: Backend,
}

/// What came of it.
#[derive(Default)]
pub struct Done {
    pub recording: Recording,
    /// Unknown where the positions never leave the device.
    pub largest_displacement: Option<f32>,
    /// Who drew, and how; none where nothing was drawn.
    pub drawn: Option<Drawn>,
    /// What went otherwise than asked.
    pub warnings: Vec<String>,
    pub most_flashes: usize,
    pub damped_frames: usize,
}

/// Who drew.
pub struct Drawn {
    /// The adapter.
    pub device: String,
    pub samples: Samples,
    /// The processor's instructions, or the device.
    pub synthesis: String,
    /// The device is a processor.
    pub software: bool,
}

/// All that changes from frame to frame.
pub struct Show {
    hearing: Hearing,
    instrument: Instrument,
    script: std::iter::Peekable<std::vec::IntoIter<LoggedAction>>,
    ensemble: Ensemble,
    model: SynthModel,
    triangles: Vec<[u32; 3]>,
    start_secs: f64,
    rate: FrameRate,
    flashes_allowed: bool,
}

impl Show {
    pub fn new(
        body: &Body,
        ensemble: Ensemble,
        hearing: Hearing,
        instrument: Instrument,
        script: Vec<LoggedAction>,
        start_secs: f64,
        rate: FrameRate,
    ) -> Result<Self, Failure> {
        Ok(Self {
            hearing,
            instrument,
            script: script.into_iter().peekable(),
            ensemble,
            model: SynthModel::new(body).map_err(Failure::other)?,
            triangles: body.triangles.clone(),
            start_secs,
            rate,
            flashes_allowed: false,
        })
    }

    pub fn song(&self) -> &Song {
        self.hearing.song()
    }

    pub fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    pub fn allow_flashes(&mut self) {
        self.flashes_allowed = true;
    }

    /// Does what the session did up to this frame and plays it; the time of the frame and its
    /// beat, and the items to draw.
    fn play(&mut self, frame: u64, seconds: &mut Seconds) -> Result<(f64, Beat, &[Item]), Failure> {
        let time_secs = self.rate.start_secs(frame);
        while let Some(line) = self.script.next_if(|line| line.moment.at_secs <= self.start_secs + time_secs)
        {
            // Beats are those of this film, which may begin elsewhere than the session did.
            let at_secs = line.moment.at_secs;
            let at_beat = self.hearing.beat(at_secs - self.start_secs).count;
            self.instrument.apply(Moment { at_secs, at_beat }, line.action).map_err(failure)?;
        }
        let dt_secs = self.rate.start_secs(1);
        let beat = self.hearing.beat(time_secs);
        let listening = Instant::now();
        let bands = self.hearing.bands(time_secs, dt_secs, self.instrument.parameters())?;
        seconds.analysis += listening.elapsed().as_secs_f64();
        let mapping = Instant::now();
        let items = self.ensemble.play(&self.instrument, &bands, beat).map_err(failure)?;
        seconds.mapping += mapping.elapsed().as_secs_f64();
        Ok((time_secs, beat, items))
    }

    /// Plays without drawing, for the coefficients.
    pub fn rehearse(&mut self, frames: u64, seconds: &mut Seconds, task: &Task) -> Result<Done, Failure> {
        let stage = task.stage("dancing", frames);
        let mut done = Done::default();
        for frame in 0..frames {
            task.check()?;
            let (time_secs, _, items) = self.play(frame, seconds)?;
            let first = items.first().cloned().unwrap_or_default();
            done.recording.push(time_secs, self.instrument.parameters().form, &first);
            stage.advance(1);
        }
        Ok(done)
    }

    /// Draws all frames of `film` and finishes it.
    pub fn film(
        &mut self,
        film: Film,
        look: &Look,
        means: Means,
        recording: bool,
        seconds: &mut Seconds,
        task: &Task,
    ) -> Result<Done, Failure> {
        let (width, height) = (film.settings().width, film.settings().height);
        let gpu = Gpu::headless().map_err(view_failure)?;
        let samples = means.samples.unwrap_or_else(|| gpu.live_samples());
        let canvas = Canvas::with_samples(&gpu, width, height, samples).map_err(view_failure)?;
        let mut theatre = Theatre::new(&gpu, self, means.synthesis)?;
        let (rate, mut done) = (self.rate, Done::default());
        let mut guard =
            FrameGuard::new(!self.flashes_allowed && self.instrument.parameters().is_on(Switch::FlashLimit));
        let mut guarding = 0.0;
        let draw = |renderer: &mut Renderer, canvas: &Canvas, frame| -> Result<(), Failure> {
            let (time_secs, beat, items) = self.play(frame, seconds)?;
            let items = items.to_vec();
            if let Some(first) = items.first().filter(|_| recording) {
                done.recording.push(time_secs, self.instrument.parameters().form, first);
            }
            // Full blending is the paper's: the mean of the exact and the rest normal.
            let normal_blending = 0.5 * self.instrument.parameters().get(Parameter::NormalBlending);
            theatre.synthesize(&items, &FrameSettings { normal_blending }, seconds)?;
            if let Some(fallback) = theatre.synthesizer.take_fallback() {
                done.warnings.push(fallback.to_string());
            }
            if let Some(displacement) = theatre.largest_displacement() {
                let share = displacement / self.ensemble.dancer().box_diagonal;
                done.largest_displacement =
                    Some(done.largest_displacement.map_or(share, |most| most.max(share)));
            }
            let drawing = Instant::now();
            theatre.draw(renderer, canvas, self, look, beat).map_err(view_failure)?;
            seconds.drawing += drawing.elapsed().as_secs_f64();
            Ok(())
        };
        let retouch = |frame, picture: &mut _| {
            let start = Instant::now();
            guard.pass(rate.start_secs(frame), picture);
            guarding += start.elapsed().as_secs_f64();
        };
        let waits = shoot_retouched(&mut Renderer::new(&gpu), &canvas, film, task, draw, retouch)?;
        seconds.drawing += waits.device_secs;
        seconds.encoding += waits.encoder_secs;
        seconds.guarding += guarding;
        done.most_flashes = guard.most_flashes();
        done.damped_frames = guard.damped_frames();
        done.drawn = Some(Drawn {
            device: gpu.description(),
            samples,
            synthesis: theatre.synthesizer.device_name(),
            software: gpu.is_software(),
        });
        Ok(done)
    }
}

/// What is kept from frame to frame beside the canvas.
struct Theatre {
    synthesizer: AutoSynthesizer,
    topology: Topology,
    /// What has to fit into the picture, for a limit of displacement.
    room: (f32, Vec<[f32; 3]>),
}

impl Theatre {
    fn new(gpu: &Gpu, show: &Show, synthesis: Backend) -> Result<Self, Failure> {
        let model = &show.model;
        let context = GpuContext::new(&gpu.device, &gpu.queue, gpu.loss());
        let topology = Topology::new(gpu, model.vertices(), &show.triangles).map_err(view_failure)?;
        Ok(Self {
            topology,
            room: (0.0, Vec::new()),
            synthesizer: AutoSynthesizer::new(&context, model.clone(), synthesis),
        })
    }

    fn synthesize(
        &mut self,
        items: &[Item],
        settings: &FrameSettings,
        seconds: &mut Seconds,
    ) -> Result<(), Failure> {
        let synthesis = Instant::now();
        self.synthesizer.synthesize_positions(items).map_err(Failure::other)?;
        seconds.synthesis += synthesis.elapsed().as_secs_f64();
        let normals = Instant::now();
        self.synthesizer.synthesize_normals(settings).map_err(Failure::other)?;
        seconds.normals += normals.elapsed().as_secs_f64();
        Ok(())
    }

    /// The farthest any vertex of the first item went; `None` where the positions are on the device.
    fn largest_displacement(&self) -> Option<f32> {
        let cpu = self.synthesizer.cpu()?;
        let squared = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>();
        let pairs = cpu.positions(0).iter().zip(cpu.model().rest_positions());
        Some(pairs.map(|(a, b)| squared(a, b)).fold(0.0, f32::max).sqrt())
    }

    fn draw(
        &mut self,
        renderer: &mut Renderer,
        canvas: &Canvas,
        show: &Show,
        look: &Look,
        beat: Beat,
    ) -> Result<(), ViewError> {
        let parameters = show.instrument.parameters();
        let reaction = react(beat, show.instrument.seed(), parameters);
        let limit = parameters.get(Parameter::Limit);
        if self.room.0 != limit {
            self.room = (limit, show.ensemble.dancer().room(show.model.rest_positions(), limit));
        }
        let buffers = ItemBuffers::of_frame(&self.synthesizer.frame())?;
        let items = buffers.items();
        let area = Rect::of_size(canvas.width(), canvas.height());
        let (rows, columns) = layout::rows_and_columns(area.width, area.height, items, 1.0);
        let viewports = layout::grid(area, rows, columns, 0, items);
        let aspect = viewports.iter().map(Rect::aspect).fold(f32::INFINITY, f32::min);
        let mut camera = Camera { pitch_rad: 0.14, ..Camera::default() };
        camera.fit_turntable(&self.room.1, aspect, 0.98);
        camera.yaw_rad = look.yaw_rad - reaction.turn_rad;
        let mut lights = look.lights.turned(reaction.light_turn_rad);
        lights.exposure *= reaction.light_gain;
        let figures: Vec<Figure<'_>> = (0..items)
            .map(|item| Figure { material: look.material, ..Figure::new(&self.topology, &buffers, item) })
            .collect();
        let placed = viewports.into_iter().zip(&figures);
        let dots = if look.rest { dots(show.model.rest_positions().iter().copied()) } else { Vec::new() };
        let mut cells = Cell::gallery(area, look.background, camera, lights, placed);
        // The first is the background.
        cells.iter_mut().skip(1).for_each(|cell| cell.markers = &dots);
        renderer.draw(canvas, &cells)?;
        Ok(())
    }
}
