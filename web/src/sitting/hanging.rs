//! The gallery in place of the figure, and the caricatures taken from it.

use chladni_caricature::Layer;
use chladni_harmonics::Body;
use chladni_mesh::Orientation;
use chladni_program::work::{Error, Swelling, hung, swollen_at};
use chladni_synth::SynthModel;
use chladni_view::{Camera, Device, Figure, ItemBuffers, Rect, Topology, View, layout};
use wasm_bindgen::prelude::*;

use super::Sitting;
use super::stage::Placed;
use crate::coarse::coarse;

/// Vertices of a figure that is a twelfth of the picture: with fewer, strong caricatures have holes.
const SMALL: usize = 12_000;
/// A figure's share of its cell.
const FILL: f32 = 0.84;

/// Figures of one shape that hang beside each other.
pub struct Hanging {
    pub camera: Camera,
    topology: Topology,
    buffers: ItemBuffers,
    swelling: Swelling,
    /// Where all vertices are when the figures have swollen as far as they do.
    positions: Vec<[f32; 3]>,
    count: usize,
    fitted: bool,
    cells: Vec<Rect>,
}

impl Hanging {
    fn new(device: &Device, positions: &[f32], body: &Body, stands: Orientation) -> Result<Self, Error> {
        let vertices = body.positions.len();
        let positions = positions.as_chunks::<3>().0.to_vec();
        let count = positions.len() / vertices.max(1);
        // No harmonic takes part: each figure is the shape and what its vertices moved by.
        let mut swelling = Swelling::new(SynthModel::from_parts(&body.positions, &body.triangles, &[])?);
        swelling.hang(positions.chunks_exact(vertices.max(1)));
        let mut buffers = ItemBuffers::new(device, vertices, count);
        let mut small = None;
        if let Some(frame) = swelling.swell(1.0)? {
            buffers.take_frame(device, frame)?;
            small = coarse(frame.positions(0), frame.normals(0), &body.triangles, SMALL);
        }
        Ok(Self {
            camera: Camera::on(stands, View::ThreeQuarter),
            topology: Topology::new(device, vertices, small.as_deref().unwrap_or(&body.triangles))?,
            buffers,
            swelling,
            positions,
            count,
            fitted: false,
            cells: Vec::new(),
        })
    }

    /// Swells all of them; whether that is another picture.
    fn swell(&mut self, device: &Device, share: f32) -> Result<bool, Error> {
        let Some(frame) = self.swelling.swell(share)? else { return Ok(false) };
        self.buffers.take_frame(device, frame)?;
        Ok(true)
    }

    /// Each in a cell of `area`.
    pub fn placed(&mut self, area: Rect) -> Vec<Placed<'_>> {
        self.cells = layout::arranged(area, self.count, 0.9, 2);
        if !self.fitted {
            let aspect = self.cells.first().map_or(1.0, Rect::aspect);
            self.camera.fit(self.positions.iter().copied(), aspect, FILL);
            self.fitted = true;
        }
        let placed = |(item, viewport): (usize, &Rect)| Placed {
            viewport: *viewport,
            camera: self.camera,
            figures: vec![Figure::new(&self.topology, &self.buffers, item)],
            markers: Vec::new(),
        };
        self.cells.iter().enumerate().map(placed).collect()
    }

    pub fn fit(&mut self) {
        self.fitted = false;
    }

    /// Turns the viewer where the shape stands otherwise.
    pub fn stand(&mut self, stands: Orientation) {
        if self.camera.stands != stands {
            self.camera.stands = stands;
            self.fit();
        }
    }
}

#[wasm_bindgen]
impl Sitting {
    /// Shows caricatures of the shape in its place, from the coordinates that [`Wall`](crate::Wall) gives; from where they
    /// were seen before, if some hang already.
    ///
    /// # Errors
    /// Bugs only.
    pub fn show_gallery(&mut self, positions: &[f32]) -> Result<(), JsError> {
        let camera = self.hanging.as_ref().map(|hanging| hanging.camera);
        let mut hanging = Hanging::new(self.stage.device(), positions, self.stack.body(), self.stands_now())?;
        if let Some(camera) = camera {
            (hanging.camera, hanging.fitted) = (camera, true);
        }
        (self.hanging, self.landmarks) = (Some(hanging), None);
        self.stage.stir();
        Ok(())
    }

    /// Swells the caricatures as far as they have at a time of any steady clock; without one, as far as they do.
    ///
    /// # Errors
    /// Bugs only.
    pub fn swell_gallery(&mut self, at_secs: Option<f64>) -> Result<(), JsError> {
        let share = at_secs.map_or(1.0, swollen_at);
        if let Some(hanging) = &mut self.hanging
            && hanging.swell(self.stage.device(), share)?
        {
            self.stage.stir();
        }
        Ok(())
    }

    /// Back to the figure.
    pub fn leave_gallery(&mut self) {
        self.hanging = None;
        self.stage.stir();
    }

    /// x, y, width and height, in pixels, of the cell of each caricature, or of each model, in the last picture.
    pub fn cells(&self) -> Vec<u32> {
        let of = |cell: &Rect| [cell.x, cell.y, cell.width, cell.height];
        let cells = self.hanging.as_ref().map_or(self.stage.lineup_cells(), |hanging| &hanging.cells);
        cells.iter().flat_map(of).collect()
    }

    /// Puts the layers of a caricature on top, as one step.
    ///
    /// # Errors
    /// Text that is none.
    pub fn hang(&mut self, layers: &str) -> Result<(), JsError> {
        let layers: Vec<Layer> = serde_json::from_str(layers)?;
        let surface = self.stack.surface().clone();
        self.history.apply_together(&hung(self.history.project(), layers), Some(&surface))?;
        self.selected = self.history.project().layers().last().map(|(id, _)| *id);
        Ok(self.refresh()?)
    }
}
