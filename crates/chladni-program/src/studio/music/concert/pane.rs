//! Where the dance is shown: a picture, judged before it is seen. The window has one, the stage may have another.

use chladni_music::{FlashGuard, Veil};
use egui::{Color32, Rect, TextureId, Ui};

use super::super::glimpse::Glimpse;
use super::super::stillness::StillPicture;
use crate::studio::screen::Screen;
use crate::studio::viewport::Viewport;
use crate::work::Error;

/// One picture, and whether it was judged and shown.
pub struct Pane {
    pub viewport: Viewport,
    pub glimpse: Glimpse,
    pub guard: FlashGuard,
    /// What the guard has laid over the last picture.
    pub veil: Veil,
    /// The last picture; `None` where something else was shown.
    pub shown: Option<StillPicture>,
    /// When it was another one for the last time, in the show.
    pub changed_secs: f64,
    /// The brightness of the kept picture is known.
    pub judged: bool,
}

impl Pane {
    /// A picture on the window's own device.
    pub fn new(screen: &Screen) -> Self {
        Self {
            viewport: Viewport::new(screen),
            glimpse: Glimpse::default(),
            guard: FlashGuard::default(),
            veil: Veil::Clear,
            shown: None,
            changed_secs: 0.0,
            judged: false,
        }
    }

    /// Keeps the picture that was drawn last once its brightness is known.
    pub fn judge(&mut self) -> Result<(), Error> {
        if self.glimpse.look(self.viewport.device())? {
            self.viewport.keep();
            self.judged = true;
        }
        Ok(())
    }

    /// Lays the guard's veil over `rect`, where the picture is.
    pub fn lay_veil(&self, ui: &Ui, rect: Rect) {
        let veil = match self.veil {
            Veil::Clear => return,
            Veil::Black(opacity) => Color32::from_black_alpha(opacity),
            Veil::White(opacity) => Color32::from_white_alpha(opacity),
        };
        ui.painter().rect_filled(rect, 0.0, veil);
    }

    /// The picture that is shown: where flashes are limited, the last one whose brightness is known.
    pub fn texture(&self, limited: bool) -> Option<TextureId> {
        if limited { self.viewport.kept_texture() } else { self.viewport.drawn_texture() }
    }

    /// Drops the picture that is being judged, and the veil.
    pub fn forget(&mut self) {
        (self.glimpse, self.judged, self.shown) = (Glimpse::default(), false, None);
        self.veil = Veil::Clear;
    }
}
