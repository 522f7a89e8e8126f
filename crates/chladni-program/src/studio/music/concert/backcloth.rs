//! The pictures around the dancers, as the preferences name them: read beside the window, shown once they are there.

use super::Concert;
use crate::studio::job::Job;
use crate::studio::room::Shared;
use crate::work::{Error, LiveBackFilm, Scenery};

/// The scenery that is shown, and the one that is being read.
#[derive(Default)]
pub struct Backcloth {
    named: [String; 2],
    reading: Option<Job<Scenery>>,
    scenery: Scenery,
    /// Where it is a film that stands behind.
    film: Option<LiveBackFilm>,
    /// Changes with the scenery.
    version: u64,
}

impl Backcloth {
    /// Whether the picture behind is a film.
    pub fn moves(&self) -> bool {
        self.film.is_some()
    }

    /// Follows the preferences.
    pub fn follow(&mut self, shared: &mut Shared<'_>) {
        if let Some(why) = self.film.as_mut().and_then(LiveBackFilm::trouble) {
            shared.notices.failed(why);
            self.film = None;
        }
        let music = &shared.settings.music;
        let named = [&music.picture, &music.panorama].map(String::clone);
        if self.named != named {
            self.named.clone_from(&named);
            let [picture, panorama] = named;
            let read = move |_: &_| Scenery::open(&picture, &panorama);
            self.reading = Some(Job::start("Reading the pictures around the stage", &shared.ctx, read));
        }
        match self.reading.as_ref().and_then(Job::ended) {
            None => return,
            Some(Ok(scenery)) => {
                self.film = scenery.live_film();
                (self.scenery, self.version) = (scenery, self.version + 1);
            }
            Some(Err(why)) => shared.notices.failed(why),
        }
        self.reading = None;
    }
}

impl Concert {
    /// Puts up the pictures that the preferences name, on the pane that is drawn.
    pub(super) fn hang(&mut self) -> Result<(), Error> {
        let Backcloth { scenery, version, film, .. } = &mut self.backcloth;
        self.pane.viewport.surround(*version, scenery)?;
        if let Some((number, picture)) = film.as_mut().map(|film| film.at(self.moment.at_secs))
            && number > 0
        {
            self.pane.viewport.put_behind(number, picture)?;
        }
        Ok(())
    }
}
