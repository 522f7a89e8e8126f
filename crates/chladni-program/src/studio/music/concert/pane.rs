//! Where the dance is shown: a picture, judged before it is seen. The window has one, the stage may have another.

use chladni_music::FlashGuard;

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
    /// The last picture; `None` where something else was shown.
    pub shown: Option<StillPicture>,
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
            shown: None,
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

    /// Drops the picture that is being judged.
    pub fn forget(&mut self) {
        (self.glimpse, self.judged, self.shown) = (Glimpse::default(), false, None);
    }
}
