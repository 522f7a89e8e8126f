//! Where the dance is shown: a picture, judged before it is seen. The window has one, the stage may have another.

use chladni_music::FlashGuard;
use chladni_view::Gpu;

use super::super::glimpse::Glimpse;
use super::super::stillness::StillPicture;
use crate::studio::viewport::Viewport;
use eframe::egui_wgpu::RenderState;

/// One picture, and what is known of it.
pub struct Pane {
    pub viewport: Viewport,
    pub glimpse: Glimpse,
    pub guard: FlashGuard,
    /// The last picture; `None` where something else was shown.
    pub shown: Option<StillPicture>,
    /// The brightness of the kept picture is known.
    pub judged: bool,
}

impl Pane {
    /// A picture on the window's own device.
    pub fn new(state: &RenderState) -> Self {
        Self::with(Viewport::new(state))
    }

    /// A second picture, on the device of the first.
    pub fn on(gpu: Gpu) -> Self {
        Self::with(Viewport::on(gpu))
    }

    fn with(viewport: Viewport) -> Self {
        Self {
            viewport,
            glimpse: Glimpse::default(),
            guard: FlashGuard::default(),
            shown: None,
            judged: false,
        }
    }

    /// What was being judged no longer matters.
    pub fn forget(&mut self) {
        (self.glimpse, self.judged, self.shown) = (Glimpse::default(), false, None);
    }
}
