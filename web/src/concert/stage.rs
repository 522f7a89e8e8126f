//! Deforms the dancers and draws them.

use chladni_program::work::{Error, FrameGuard, Staging, Wardrobe};
use chladni_synth::{CpuSynthesizer, FrameSettings, Item, SynthModel, Synthesizer};
use chladni_view::{Device, ItemBuffers, Renderer, Topology};

use crate::coarse::coarse;
use crate::screen::{Screen, device};

/// Vertices of a body in a gallery.
const SMALL: usize = 1600;

pub(super) struct Stage {
    synthesizer: CpuSynthesizer,
    triangles: Vec<[u32; 3]>,
    pub figures: Figures,
    pub guard: FrameGuard,
    /// x, y, width and height of each item's cell.
    pub cells: Vec<u32>,
}

/// The renderer and what it draws.
pub(super) struct Figures {
    pub topology: Topology,
    /// For a gallery, whose pictures are small; none where the body has few vertices anyway.
    pub small: Option<Topology>,
    pub wardrobe: Wardrobe,
    pub buffers: ItemBuffers,
    pub renderer: Renderer,
    pub screen: Screen,
}

impl Stage {
    pub fn new(model: SynthModel, triangles: Vec<[u32; 3]>, staging: &Staging) -> Result<Self, Error> {
        Ok(Self {
            figures: Figures::new(device(), &model, &triangles, staging)?,
            synthesizer: CpuSynthesizer::new(model),
            triangles,
            guard: FrameGuard::new(Some(chladni_music::FlashArea::Screen)),
            cells: Vec::new(),
        })
    }

    /// Somebody else draws from now on.
    pub fn draw_by(&mut self, device: Device, staging: &Staging) -> Result<(), Error> {
        self.figures = Figures::new(device, self.synthesizer.model(), &self.triangles, staging)?;
        Ok(())
    }

    pub fn deform(&mut self, items: &[Item], settings: &FrameSettings) -> Result<(), Error> {
        self.synthesizer.synthesize(items, settings)?;
        Ok(self.figures.buffers.take_frame(self.figures.screen.device(), &self.synthesizer)?)
    }
}

impl Figures {
    fn new(
        device: Device,
        model: &SynthModel,
        triangles: &[[u32; 3]],
        staging: &Staging,
    ) -> Result<Self, Error> {
        let vertices = model.vertices();
        let small = coarse(model.rest_positions(), model.rest_normals(), triangles, SMALL);
        let small = small.map(|fewer| staging.topology(&device, triangles, Some(&fewer))).transpose()?;
        Ok(Self {
            small,
            topology: staging.topology(&device, triangles, None)?,
            wardrobe: staging.wardrobe(&device)?,
            buffers: ItemBuffers::new(&device, vertices, 0),
            renderer: Renderer::new(&device),
            screen: Screen::new(device)?,
        })
    }
}
