//! A body that dances: instrument, synthesizer and the picture of all items.

use std::sync::Arc;

use chladni_caricature::ShapeSource;
use chladni_harmonics::{BasisSettings, Body};
use chladni_music::{
    Action, Dancer, Ensemble, FlashLimiter, GalleryShape, Instrument, Moment, Parameter, Session, Switch,
    Symmetry, react,
};
use chladni_synth::{CpuSynthesizer, FrameSettings, SynthModel, Synthesizer};
use chladni_task::Task;
use chladni_view::{Background, Camera, Cell, Figure, ItemBuffers, Lights, Material, Rect, Topology, layout};
use eframe::egui_wgpu::RenderState;
use egui::Ui;

use super::gallery;
use super::listening::Listening;
use crate::source;
use crate::studio::room::Shared;
use crate::studio::viewport::{self, Viewport};

/// Seed of the first gallery; every further one is shown to the user, too.
const FIRST_SEED: u64 = 2012;
/// How much of its cell the shape at rest fills: dancing takes room.
const FILL: f32 = 0.56;

/// What loading brings back.
pub struct Ready {
    body: Body,
    dancer: Arc<Dancer>,
    /// What was mended in the file.
    pub warnings: Vec<String>,
}

/// Loads a shape, its harmonics and their symmetry classes.
pub fn load(source: &ShapeSource, harmonics: usize, task: &Task) -> Result<Ready, String> {
    let (mesh, warnings) = source::shape(source, None)?;
    let harmonics = harmonics.min(mesh.positions.len().saturating_sub(1)).max(1);
    let cache = crate::cli::basis_cache();
    let (body, _) = Body::load_or_build(&mesh, &BasisSettings::new(harmonics), cache.as_ref(), task)
        .map_err(|error| error.to_string())?;
    let symmetry = Symmetry::of(&body, task).map_err(|error| error.to_string())?;
    let body = symmetry.rotated(&body);
    let dancer = Dancer::new(&body, &symmetry.classes).map_err(|error| error.to_string())?;
    Ok(Ready { body, dancer: Arc::new(dancer), warnings })
}

/// Everything that moves on screen.
pub struct Concert {
    instrument: Instrument,
    ensemble: Ensemble,
    synthesizer: CpuSynthesizer,
    viewport: Viewport,
    topology: Topology,
    buffers: ItemBuffers,
    rest: Vec<[f32; 3]>,
    camera: Camera,
    limiter: FlashLimiter,
    moment: Moment,
    hovered: Option<usize>,
    preset_wish: Option<usize>,
    /// Index into [`Material::PRESETS`].
    pub material: usize,
}

impl Concert {
    /// A gallery of twelve on what was loaded.
    pub fn new(state: &RenderState, ready: Ready) -> Result<Self, String> {
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: ready.dancer.eigenvalues.clone(), bands };
        let instrument = Instrument::new(FIRST_SEED, 12, shape).map_err(|error| error.to_string())?;
        let model = SynthModel::new(&ready.body).map_err(|error| error.to_string())?;
        let viewport = Viewport::new(state);
        let gpu = viewport.gpu();
        let topology =
            Topology::new(gpu, model.vertices(), &ready.body.triangles).map_err(|error| error.to_string())?;
        let buffers = ItemBuffers::new(gpu, model.vertices(), 12);
        let rest = model.rest_positions().to_vec();
        Ok(Self {
            instrument,
            ensemble: Ensemble::new(ready.dancer),
            synthesizer: CpuSynthesizer::new(model),
            topology,
            buffers,
            rest,
            viewport,
            camera: Camera { pitch_rad: 0.14, ..Camera::default() },
            limiter: FlashLimiter::default(),
            moment: Moment::default(),
            hovered: None,
            preset_wish: None,
            material: 3,
        })
    }

    /// The state that the panels read.
    pub fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    /// Does what the user asked, at the moment that is heard.
    pub fn act(&mut self, action: Action) -> Result<(), String> {
        self.instrument.apply(self.moment, action).map_err(|error| error.to_string())
    }

    /// Replaces the gallery by that of a session, as it was in the end.
    pub fn replay(&mut self, session: &Session) -> Result<(), String> {
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: self.ensemble.dancer().eigenvalues.clone(), bands };
        self.instrument = session.replay(shape).map_err(|error| error.to_string())?;
        Ok(())
    }

    /// Which generation is shown.
    pub fn generation(&self) -> usize {
        self.instrument.gallery().current()
    }

    /// The item under the pointer.
    pub fn hovered(&self) -> Option<usize> {
        self.hovered
    }

    /// Whether an item is a favourite, and whether it is locked.
    pub fn marks(&self, item: usize) -> (bool, bool) {
        let Some(item) = self.instrument.gallery().items().get(item) else { return (false, false) };
        (self.instrument.favourites().iter().any(|favourite| favourite.id == item.id), item.locked)
    }

    /// Whether something is on stage.
    pub fn on_stage(&self) -> bool {
        self.instrument.scene(self.moment.at_beat).is_some()
    }

    /// The item that is to be saved as a preset; handed out once.
    pub fn take_preset_wish(&mut self) -> Option<usize> {
        self.preset_wish.take()
    }

    /// Hears, deforms and draws one frame, and handles clicks on the items.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        shared: &Shared<'_>,
        listening: &mut Listening,
    ) -> Result<(), String> {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
        let (status, beat, bands) = listening.hear(self.instrument.parameters())?;
        self.moment = Moment { at_secs: status.position_secs, at_beat: beat.count };
        let items = self.ensemble.play(&self.instrument, &bands, beat).map_err(|error| error.to_string())?;
        let count = items.len();
        // Full blending is the paper's: the mean of the exact and the rest normal.
        let normal_blending = 0.5 * self.instrument.parameters().get(Parameter::NormalBlending);
        self.synthesizer
            .synthesize(items, &FrameSettings { normal_blending })
            .map_err(|error| error.to_string())?;
        if self.buffers.items() != count {
            self.buffers = ItemBuffers::new(self.viewport.gpu(), self.rest.len(), count);
        }
        for item in 0..count {
            let (positions, normals) = (self.synthesizer.positions(item), self.synthesizer.normals(item));
            self.buffers
                .write(self.viewport.gpu(), item, positions, normals)
                .map_err(|error| error.to_string())?;
        }
        viewport::navigate(ui, &response, &mut self.camera);
        self.viewport.invalidate();
        let scale = ui.pixels_per_point();
        let area = Rect::of_size(
            ((rect.width() * scale).round() as u32).max(1),
            ((rect.height() * scale).round() as u32).max(1),
        );
        let (rows, columns) = layout::rows_and_columns(area.width, area.height, count, 1.0);
        let cells = layout::grid(area, rows, columns, 6, count);
        self.draw(ui, shared, rect, &cells, beat)?;
        if self.on_stage() {
            self.hovered = None;
            return Ok(());
        }
        let places: Vec<egui::Rect> = cells.iter().map(|cell| viewport::to_points(ui, rect, *cell)).collect();
        let clicks = gallery::overlay(ui, &response, &places, &self.instrument, &mut self.hovered);
        for click in clicks {
            match click {
                gallery::Click::Do(action) => self.act(action)?,
                gallery::Click::SavePreset(item) => self.preset_wish = Some(item),
            }
        }
        Ok(())
    }

    fn draw(
        &mut self,
        ui: &mut Ui,
        shared: &Shared<'_>,
        rect: egui::Rect,
        cells: &[Rect],
        beat: chladni_music::Beat,
    ) -> Result<(), String> {
        let parameters = self.instrument.parameters();
        let reaction = react(beat, self.instrument.seed(), parameters);
        let aspect = cells.iter().map(Rect::aspect).fold(f32::INFINITY, f32::min);
        let mut camera = self.camera;
        let zoom = camera.distance / Camera::default().distance;
        camera.fit_turntable(&self.rest, aspect, FILL);
        camera.distance *= zoom;
        camera.yaw_rad = self.camera.yaw_rad - reaction.turn_rad;
        let mut lights = Lights::STAGE.turned(reaction.light_turn_rad);
        let seconds = ui.input(|input| input.time);
        lights.exposure *= if parameters.is_on(Switch::FlashLimit) {
            self.limiter.limit(seconds, reaction.light_gain)
        } else {
            reaction.light_gain
        };
        let material = Material::PRESETS.get(self.material).map_or(Material::PEARL, |preset| preset.1);
        let figures: Vec<Figure<'_>> = (0..cells.len())
            .map(|item| Figure { material, ..Figure::new(&self.topology, &self.buffers, item) })
            .collect();
        self.viewport
            .show(ui, shared.gpu, rect, |_| {
                cells
                    .iter()
                    .zip(&figures)
                    .map(|(cell, figure)| Cell {
                        viewport: *cell,
                        camera,
                        lights,
                        background: Background::NIGHT,
                        figures: std::slice::from_ref(figure),
                        markers: &[],
                    })
                    .collect()
            })
            .map_err(|error| error.to_string())
    }
}
