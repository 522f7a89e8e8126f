//! Frame after frame: actions, sound, shape, picture.

use std::time::Instant;

use chladni_harmonics::Body;
use chladni_music::{Beat, Ensemble, Instrument, LoggedAction, Moment, Parameter, Switch, react};
use chladni_sound::Song;
use chladni_synth::{CpuSynthesizer, FrameSettings, Item, SynthModel, Synthesizer};
use chladni_task::Task;
use chladni_view::{
    Background, Camera, Canvas, Cell, Figure, Film, FrameRate, Gpu, ItemBuffers, Lights, Material, Rect,
    Renderer, Topology, ViewError, layout,
};

use super::guard::FrameGuard;
use super::hearing::Hearing;
use super::record::Recording;
use super::{Seconds, failure, view_failure};
use crate::cli::Failure;

/// How the film looks.
pub struct Look {
    pub lights: Lights,
    pub material: Material,
    pub background: Background,
    pub yaw_rad: f32,
}

/// What came of it.
#[derive(Default)]
pub struct Done {
    pub recording: Recording,
    pub largest_displacement: f32,
    pub most_flashes: usize,
    pub damped_frames: usize,
}

/// All that changes from frame to frame.
pub struct Show {
    hearing: Hearing,
    instrument: Instrument,
    script: std::iter::Peekable<std::vec::IntoIter<LoggedAction>>,
    ensemble: Ensemble,
    synthesizer: CpuSynthesizer,
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
            synthesizer: CpuSynthesizer::new(SynthModel::new(body).map_err(Failure::other)?),
            triangles: body.triangles.clone(),
            start_secs,
            rate,
            flashes_allowed: false,
        })
    }

    pub fn song(&self) -> &Song {
        self.hearing.song()
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
            done.recording.push(time_secs, items.first().unwrap_or(&Item::default()));
            stage.advance(1);
        }
        Ok(done)
    }

    /// Draws all frames of `film` and finishes it.
    pub fn film(
        &mut self,
        mut film: Film,
        look: &Look,
        recording: bool,
        seconds: &mut Seconds,
        task: &Task,
    ) -> Result<Done, Failure> {
        let (width, height, frames) = (film.settings().width, film.settings().height, film.settings().frames);
        let model = self.synthesizer.model();
        let limit = self.instrument.parameters().get(Parameter::Limit);
        let room = self.ensemble.dancer().room(model.rest_positions(), limit);
        let mut theatre = Theatre::new(model, &self.triangles, room, width, height)?;
        let mut guard =
            FrameGuard::new(!self.flashes_allowed && self.instrument.parameters().is_on(Switch::FlashLimit));
        let stage = task.stage("filming", frames);
        let mut done = Done::default();
        for frame in 0..frames {
            task.check()?;
            let (time_secs, beat, items) = self.play(frame, seconds)?;
            let items = items.to_vec();
            if recording {
                done.recording.push(time_secs, items.first().unwrap_or(&Item::default()));
            }
            self.synthesize(&items, seconds)?;
            done.largest_displacement = done.largest_displacement.max(self.largest_displacement());
            let drawing = Instant::now();
            theatre.draw(self, look, beat, items.len()).map_err(view_failure)?;
            let mut picture = theatre.canvas.read(&theatre.gpu).map_err(view_failure)?;
            seconds.drawing += drawing.elapsed().as_secs_f64();
            let guarding = Instant::now();
            guard.pass(time_secs, &mut picture);
            seconds.guarding += guarding.elapsed().as_secs_f64();
            let encoding = Instant::now();
            film.push(picture).map_err(view_failure)?;
            seconds.encoding += encoding.elapsed().as_secs_f64();
            stage.advance(1);
        }
        let encoding = Instant::now();
        film.finish().map_err(view_failure)?;
        seconds.encoding += encoding.elapsed().as_secs_f64();
        done.most_flashes = guard.most_flashes();
        done.damped_frames = guard.damped_frames();
        Ok(done)
    }

    fn synthesize(&mut self, items: &[Item], seconds: &mut Seconds) -> Result<(), Failure> {
        let synthesis = Instant::now();
        self.synthesizer.synthesize_positions(items).map_err(Failure::other)?;
        seconds.synthesis += synthesis.elapsed().as_secs_f64();
        let normals = Instant::now();
        // Full blending is the paper's: the mean of the exact and the rest normal.
        let normal_blending = 0.5 * self.instrument.parameters().get(Parameter::NormalBlending);
        self.synthesizer.synthesize_normals(&FrameSettings { normal_blending }).map_err(Failure::other)?;
        seconds.normals += normals.elapsed().as_secs_f64();
        Ok(())
    }

    /// The farthest any vertex of the first item went, as a share of the diagonal.
    fn largest_displacement(&self) -> f32 {
        let rest = self.synthesizer.model().rest_positions();
        let squared = |a: &[f32; 3], b: &[f32; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>();
        let moved = self.synthesizer.positions(0);
        let farthest = moved.iter().zip(rest).map(|(a, b)| squared(a, b)).fold(0.0, f32::max).sqrt();
        farthest / self.ensemble.dancer().box_diagonal
    }
}

/// Canvas and buffers that are kept from frame to frame.
struct Theatre {
    gpu: Gpu,
    renderer: Renderer,
    canvas: Canvas,
    topology: Topology,
    buffers: ItemBuffers,
    /// What has to fit into the picture.
    room: Vec<[f32; 3]>,
}

impl Theatre {
    fn new(
        model: &SynthModel,
        triangles: &[[u32; 3]],
        room: Vec<[f32; 3]>,
        width: u32,
        height: u32,
    ) -> Result<Self, Failure> {
        let gpu = Gpu::headless().map_err(view_failure)?;
        let canvas = Canvas::new(&gpu, width, height).map_err(view_failure)?;
        let topology = Topology::new(&gpu, model.vertices(), triangles).map_err(view_failure)?;
        Ok(Self {
            renderer: Renderer::new(&gpu),
            canvas,
            topology,
            buffers: ItemBuffers::new(&gpu, model.vertices(), 0),
            room,
            gpu,
        })
    }

    fn draw(&mut self, show: &Show, look: &Look, beat: Beat, items: usize) -> Result<(), ViewError> {
        let parameters = show.instrument.parameters();
        let reaction = react(beat, show.instrument.seed(), parameters);
        if self.buffers.items() != items {
            self.buffers = ItemBuffers::new(&self.gpu, self.room.len(), items);
        }
        for item in 0..items {
            self.buffers.write(
                &self.gpu,
                item,
                show.synthesizer.positions(item),
                show.synthesizer.normals(item),
            )?;
        }
        let area = Rect::of_size(self.canvas.width(), self.canvas.height());
        let (rows, columns) = layout::rows_and_columns(area.width, area.height, items, 1.0);
        let viewports = layout::grid(area, rows, columns, 0, items);
        let aspect = viewports.iter().map(Rect::aspect).fold(f32::INFINITY, f32::min);
        let mut camera = Camera { pitch_rad: 0.14, ..Camera::default() };
        camera.fit_turntable(&self.room, aspect, 0.98);
        camera.yaw_rad = look.yaw_rad - reaction.turn_rad;
        let mut lights = look.lights.turned(reaction.light_turn_rad);
        lights.exposure *= reaction.light_gain;
        let figures: Vec<Figure<'_>> = (0..items)
            .map(|item| Figure {
                material: look.material,
                ..Figure::new(&self.topology, &self.buffers, item)
            })
            .collect();
        let placed = viewports.into_iter().zip(&figures);
        let cells = Cell::gallery(area, look.background, camera, lights, placed);
        self.renderer.draw(&self.canvas, &cells)?;
        Ok(())
    }
}
