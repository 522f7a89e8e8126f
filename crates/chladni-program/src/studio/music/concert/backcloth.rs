//! The pictures around the dancers, as the preferences name them: read beside the window, shown once they are there.

use chladni_view::Finish;

use super::Concert;
use crate::studio::job::Job;
use crate::studio::room::Shared;
use crate::work::{Error, LiveBackFilm, Scenery};

/// The number of no scenery at all.
const NOTHING: u64 = u64::MAX;

/// The scenery that is shown, and the one that is being read.
#[derive(Default)]
pub struct Backcloth {
    named: [String; 2],
    /// With the reasons why parts of it cannot be read.
    reading: Option<Job<(Scenery, Vec<Error>)>>,
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
            let read = move |_: &_| Ok(Scenery::readable(&picture, &panorama));
            self.reading = Some(Job::start("Reading the pictures around the stage", &shared.ctx, read));
        }
        let Some(read) = self.reading.as_ref().and_then(Job::ended) else { return };
        self.reading = None;
        let (scenery, failures) = read.unwrap_or_else(|why| (Scenery::default(), vec![why]));
        failures.into_iter().for_each(|why| shared.notices.failed(why));
        self.film = scenery.live_film();
        (self.scenery, self.version) = (scenery, self.version + 1);
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

    /// Takes them down, and the finish of the dance: what is drawn next on the pane is as it is.
    pub(super) fn take_down(&mut self) -> Result<(), Error> {
        self.pane.viewport.finish(Finish::NOTHING, 0.0);
        self.pane.viewport.surround(NOTHING, &Scenery::default())?;
        Ok(())
    }
}
