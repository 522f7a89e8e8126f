//! Thumbnails: a small picture of each layer's result.

use std::collections::HashMap;
use std::sync::Arc;

use chladni_caricature::{EvaluatedLayer, LayerId};
use chladni_mesh::surface::vec3::single;
use chladni_view::{Camera, Canvas, ColorMap, Renderer, Scale, VertexPaint, View, ViewError};

use super::session::Session;
use super::shot::{Coat, Shot};
use super::stage::Stage;
use crate::studio::screen::{Screen, Shown};

/// Pixels of a side.
const SIZE: u32 = 88;

/// The pictures of the open project's layers.
#[derive(Default)]
pub struct Thumbnails {
    renderer: Option<Renderer>,
    camera: Option<Camera>,
    pictures: HashMap<LayerId, Thumbnail>,
}

struct Thumbnail {
    canvas: Canvas,
    shown: Shown,
    /// The displacement that it shows.
    of: Arc<Vec<[f64; 3]>>,
}

impl Thumbnails {
    /// Another shape was opened, or this one stands otherwise.
    pub fn clear(&mut self) {
        self.pictures.clear();
        self.camera = None;
    }

    /// The picture of `layer`, where there is one yet.
    pub fn of(&self, layer: LayerId) -> Option<egui::TextureId> {
        self.pictures.get(&layer).map(|picture| picture.shown.id())
    }

    /// Draws one picture that is missing or out of date; true where more are.
    pub fn update(&mut self, screen: &Screen, stage: &Stage, session: &Session) -> Result<bool, ViewError> {
        if self.camera.is_some_and(|camera| camera.stands != session.stands()) {
            self.clear();
        }
        let layers = &session.shown.evaluation.layers;
        self.pictures.retain(|id, _| layers.iter().any(|layer| layer.id == *id));
        let current = |layer: &EvaluatedLayer| match (&layer.displacement, self.pictures.get(&layer.id)) {
            (Some(displacement), Some(picture)) => Arc::ptr_eq(displacement, &picture.of),
            (displacement, _) => displacement.is_none(),
        };
        let mut stale = (0..layers.len()).filter(|index| !current(&layers[*index]));
        let (Some(index), more) = (stale.next(), stale.next().is_some()) else { return Ok(false) };
        drop(stale);
        self.draw(screen, stage, session, index)?;
        Ok(more)
    }

    fn draw(
        &mut self,
        screen: &Screen,
        stage: &Stage,
        session: &Session,
        index: usize,
    ) -> Result<(), ViewError> {
        let layers = &session.shown.evaluation.layers;
        let Some(layer) = layers.get(index) else { return Ok(()) };
        let Some(displacement) = &layer.displacement else { return Ok(()) };
        let shape = layers.get(index + 1).map_or(&session.shown.evaluation.result, |above| &above.base);
        let pose = (single(&shape.positions), single(shape.normals()));
        let length: Vec<f32> = displacement.iter().map(|d| d[0].hypot(d[1]).hypot(d[2]) as f32).collect();
        let camera = *self.camera.get_or_insert_with(|| {
            let mut camera = Camera::on(session.stands(), View::ThreeQuarter);
            camera.fit(single(&session.stack.original().positions).iter().copied(), 1.0, 0.86);
            camera
        });
        let still = stage.shot_of(pose, Coat::Material);
        let values = VertexPaint::new(&still.device, length.len());
        values.write_values(&still.device, &length)?;
        let scale = Scale { low: 0.0, ..Scale::of(ColorMap::Viridis, &length) };
        let shot = Shot { coat: Coat::Values(values, scale), camera, ..still };
        let renderer = self.renderer.get_or_insert_with(|| Renderer::new(&shot.device));
        let picture = match self.pictures.entry(layer.id) {
            std::collections::hash_map::Entry::Occupied(held) => held.into_mut(),
            std::collections::hash_map::Entry::Vacant(place) => {
                let canvas = Canvas::new(&shot.device, SIZE, SIZE)?;
                let shown = screen.hang(&canvas, None)?;
                place.insert(Thumbnail { canvas, shown, of: Arc::clone(displacement) })
            }
        };
        picture.of = Arc::clone(displacement);
        shot.draw_on(renderer, &picture.canvas)?;
        picture.shown.refresh(&picture.canvas);
        Ok(())
    }
}
