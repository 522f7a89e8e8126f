//! Where the dance is shown: a picture, judged before it is seen. The window has one, the stage may have another.

use chladni_music::{FlashGuard, Veil};
use egui::{Color32, Rect, TextureId, Ui};

use super::glimpse::Glimpse;
use super::stillness::StillPicture;
use crate::studio::screen::Screen;
use crate::studio::viewport::Viewport;
use crate::work::Error;

/// One picture, and whether it was judged and shown.
pub struct Pane {
    pub viewport: Viewport,
    pub glimpse: Glimpse,
    pub guard: FlashGuard,
    /// What lies over the last picture: the black of the stage, and what the guard adds.
    pub veil: Veil,
    /// The last picture; `None` where something else was shown.
    pub shown: Option<StillPicture>,
    /// When it was another one for the last time, in the show.
    pub changed_secs: f64,
    /// The brightness of the kept picture is known.
    pub judged: bool,
    /// Flashes are limited: the kept picture is the one that is seen.
    limited: bool,
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
            limited: false,
        }
    }

    /// Limits flashes from now on, or no longer. The picture that is seen stays until the next one, which is drawn anew.
    pub fn limit(&mut self, limited: bool) {
        if std::mem::replace(&mut self.limited, limited) != limited {
            self.viewport.keep();
            self.viewport.invalidate();
            (self.glimpse, self.judged, self.veil) = (Glimpse::default(), false, Veil::Clear);
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

    /// Lays the veil over `rect`, where the picture is.
    pub fn lay_veil(&self, ui: &Ui, rect: Rect) {
        let veil = match self.veil {
            Veil::Clear => return,
            Veil::Black(opacity) => Color32::from_black_alpha(opacity),
            Veil::White(opacity) => Color32::from_white_alpha(opacity),
        };
        ui.painter().rect_filled(rect, 0.0, veil);
    }

    /// The picture that is shown: where flashes are limited, the last one whose brightness is known.
    pub fn texture(&self) -> Option<TextureId> {
        if self.limited { self.viewport.kept_texture() } else { self.viewport.drawn_texture() }
    }

    /// Drops the picture that is being judged, and the veil.
    pub fn forget(&mut self) {
        (self.glimpse, self.judged, self.shown) = (Glimpse::default(), false, None);
        self.veil = Veil::Clear;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_view::Device;

    #[test]
    fn the_picture_that_is_seen_stays_where_flashes_are_limited_or_no_longer() {
        let mut pane = Pane::new(&Screen::unseen(&Device::Processor));
        let ctx = egui::Context::default();
        let draw = |pane: &mut Pane, is_new: bool| {
            if is_new {
                pane.viewport.invalidate();
            }
            let mut drawn = false;
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                let rect = Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(8.0, 8.0));
                drawn = pane.viewport.draw(ui, rect, |_| Vec::new()).unwrap();
            });
            drawn
        };
        pane.limit(true);
        draw(&mut pane, true);
        pane.glimpse.begin(pane.viewport.device(), pane.viewport.canvas().unwrap(), Color32::BLACK);
        pane.judge().unwrap();
        // Another one, which is not judged yet.
        draw(&mut pane, true);
        let seen = pane.texture();
        assert!(pane.judged && seen.is_some() && !draw(&mut pane, false));
        pane.limit(false);
        assert_eq!((pane.texture(), pane.judged), (seen, false));
        assert!(draw(&mut pane, false), "the next one is drawn though all rests");
        let seen = pane.texture();
        pane.limit(true);
        assert_eq!(pane.texture(), seen);
        assert!(draw(&mut pane, false));
        pane.limit(true);
        assert!(pane.texture() == seen && !draw(&mut pane, false), "nothing has changed");
    }
}
