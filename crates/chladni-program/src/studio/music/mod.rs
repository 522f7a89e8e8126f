//! The music room: a gallery of living shapes, breeding, and the stage.

mod asking;
mod calibrating;
mod close_up;
mod concert;
mod curtain;
mod curve;
mod drawer;
mod film;
mod fulfilment;
mod gallery;
mod hands;
mod harmonics;
mod keepsake;
mod keyboard;
mod knobs;
mod leaning;
mod legible;
mod lineage;
mod listening;
mod loading;
mod look;
#[cfg(target_os = "linux")]
mod media_keys;
mod meters;
mod outgoing;
mod place;
mod preferences;
mod projection;
mod recorder;
mod recording;
mod remote;
mod room;
mod salvage;
mod shelf;
mod show_bar;
mod shows;
mod song_title;
mod songs;
mod transport;
mod view;
mod voices;
mod wish;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use chladni_music::{Action, FileRef, Show};
use chladni_sound::Capture;

use self::calibrating::Calibrating;
use self::concert::Concert;
use self::curtain::Curtain;
use self::drawer::{Drawer, Drawers};
use self::film::Filming;
use self::hands::Taken;
use self::keepsake::Keepsake;
use self::leaning::Leaning;
use self::listening::Listening;
pub use self::listening::MOST_GAIN_DB;
use self::loading::Ready;
pub use self::preferences::Preferences;
use self::salvage::Salvage;
use self::shows::MOST_HARMONICS;
use self::wish::Then;
use super::Trace;
use super::awake::Awake;
use super::job::Job;
use super::opening::{Live, SetOutput, SetPlan};
use super::room::Shared;
use crate::work::formats;
use crate::work::{Error, Warning, shown_name};

/// The room: one body, one gallery, one playlist.
#[derive(Default)]
pub struct MusicRoom {
    /// The name of the body that is loading, as in `body`, and its job.
    loading: Option<(PathBuf, Job<Ready>)>,
    /// The name of the body that dances, as the command line uses it.
    body: PathBuf,
    filming: Filming,
    /// A person taps, so that picture and sound come together.
    calibrating: Option<Calibrating>,
    keepsake: Keepsake,
    /// The use of the files that are being chosen.
    asking: Option<Then>,
    concert: Option<Concert>,
    listening: Option<Listening>,
    /// The live input to open once there are ears.
    input: Option<Capture>,
    /// Which live input to listen to then.
    live: Option<Live>,
    /// The autopilot is to begin as soon as the shape is there.
    autopilot: bool,
    #[cfg(target_os = "linux")]
    media_keys: Option<media_keys::MediaKeys>,
    trace: Option<Trace>,
    /// Where the set is to go once there is a picture.
    output: Option<SetOutput>,
    /// The folder of the last recording.
    recordings: Option<PathBuf>,
    drawers: Drawers,
    curtain: Curtain,
    leaning: Leaning,
    awake: Awake,
    /// The time, by the window's clock, at which something moved last.
    moved_secs: f64,
    /// Presets and shows that wait for a shape.
    waiting: Vec<PathBuf>,
    /// Songs that wait for the show that was opened with them: it would replace them.
    late_songs: Vec<PathBuf>,
    /// That show has come with songs of its own, behind which these play.
    late_songs_follow: bool,
    /// A show that waits for an answer: unsaved dances are in its way.
    replacing: Option<(PathBuf, Show)>,
    /// The action that begins another gallery, while it waits for the same answer.
    renewing: Option<Action>,
    coming: Option<Coming>,
    /// The files of other machines that the show names, by their places beside it: only there are they looked for.
    far: BTreeMap<PathBuf, FileRef>,
    /// The ears or the first shape could not be had: it is not tried again by itself.
    refused: bool,
    /// The preset of the shelf that a controller took last.
    preset: Option<usize>,
    taken: Taken,
    /// The stage has a window of its own.
    apart: bool,
    /// The number of the pass in which the room was shown last.
    pass: u64,
    /// The time of the last frame, by the window's clock.
    last_secs: f64,
    salvage: Salvage,
}

/// A show that waits for its own shape.
struct Coming {
    path: PathBuf,
    show: Show,
    /// The number of actions before that: work that was done later is asked about.
    since: usize,
}

impl MusicRoom {
    /// A room that begins the `set`, listens to `input`, where there is one, and records its items in `trace`.
    pub fn beginning(set: SetPlan, input: Option<Capture>, trace: Option<Trace>) -> Self {
        let SetPlan { live, autopilot, output } = set;
        Self { input, live, autopilot, trace, output, ..Self::default() }
    }

    /// Loads a shape, or a caricature, whose voices are shown.
    fn load(&mut self, path: PathBuf, shared: &mut Shared<'_>) {
        let means = self.means(shared);
        if formats::is_project(&path) {
            self.drawers.open = Drawer::Body;
        }
        let (label, loads) = (format!("Opening {}", shown_name(&path)), path.clone());
        let settings = shared.settings.clone();
        let knows = move |document: &Path, file: &Path| settings.knows(document, file);
        let job = Job::start(label, &shared.ctx, move |task| loading::load(&loads, knows, means, task));
        self.loading = Some((path, job));
    }

    /// The ears, started when they are first needed; `None` where that failed.
    fn listening(&mut self, shared: &mut Shared<'_>) -> Option<&mut Listening> {
        if self.listening.is_none() && !self.refused {
            let music = &shared.settings.music;
            match Listening::start(&shared.ctx, music.volume, music.output_device.clone()) {
                Ok(mut listening) => {
                    listening.set_song_fade_secs(music.song_fade_secs);
                    listening.show_ahead(music.late_secs());
                    listening.set_input(music.input());
                    match self.live.take() {
                        Some(Live::Named(name)) => listening.listen_to_named(&name, &shared.ctx),
                        Some(Live::Last) => listening.toggle_live(music.live_input.as_deref(), &shared.ctx),
                        None => {}
                    }
                    if let Some(input) = self.input.take() {
                        listening.listen_on(input, "Live input".into());
                    }
                    self.listening = Some(listening);
                }
                Err(why) => {
                    self.refused = true;
                    shared.notices.failed(why);
                }
            }
        }
        self.listening.as_mut()
    }

    /// How a shape is made ready: with as many harmonics as the show has that waits for it.
    fn means(&self, shared: &Shared<'_>) -> loading::Means {
        let of_show = self.coming.as_ref().and_then(|coming| coming.show.harmonics);
        loading::Means {
            harmonics: of_show.unwrap_or(shared.settings.harmonics).min(MOST_HARMONICS),
            coarsely: shared.screen.device().is_software(),
        }
    }

    fn poll(&mut self, shared: &mut Shared<'_>) {
        let loaded = self.loading.as_ref();
        let loaded = loaded.and_then(|(path, job)| job.ended().map(|ended| (path.clone(), ended)));
        if let Some((path, ended)) = loaded {
            self.loading = None;
            match ended.and_then(|ready| self.bring_on(ready, shared)) {
                Ok(()) => {
                    // Only now: of a project that is known, files of other machines are looked for.
                    if formats::is_project(&path) && self.coming.is_none() {
                        shared.settings.remember(&path);
                    }
                    self.body = path;
                    self.go_on_with_coming(shared);
                }
                Err(why) => self.refuse(why, shared),
            }
        }
        while self.concert.is_some() && self.loading.is_none() && !self.waiting.is_empty() {
            let path = self.waiting.remove(0);
            self.open_text(path, shared);
        }
        self.add_songs(shared);
    }

    /// A shape that is ready dances, in place of the one before.
    fn bring_on(&mut self, ready: Ready, shared: &mut Shared<'_>) -> Result<(), Error> {
        // A show that has waited for the shape may say how it stands.
        let is_said = self.coming.as_ref().is_some_and(|coming| coming.show.stands.is_some());
        for warning in &ready.warnings {
            match warning {
                Warning::InDoubt { .. } if is_said => {}
                Warning::InDoubt { .. } => {
                    let way_out = "set it with the arrow beside the scene, in the drawer Look";
                    shared.notices.warn(format!("{warning}; {way_out}"));
                }
                warning => shared.notices.warn(warning),
            }
        }
        let mut concert = Concert::new(shared.screen, ready)?;
        if let Some(before) = &self.concert {
            // Another shape dances the gallery bred on the one before.
            concert.go_on_from(before)?;
        }
        if let Some(caution) = self.caution_on(concert.instrument().shape().eigenvalues.len()) {
            shared.notices.warn(caution);
        }
        // Another shape goes on in the same film, by the same autopilot, on a stage as black as it is.
        if let Some(before) = self.concert.take() {
            concert.go_on_as(before);
        }
        self.concert = Some(concert);
        Ok(())
    }

    /// A warning where what was bred goes on with another number of harmonics; none where a show that has waited for the
    /// shape takes its place unasked.
    fn caution_on(&self, harmonics: usize) -> Option<String> {
        let before = self.concert.as_ref()?;
        let gives_way = |coming: &Coming| !before.has_unsaved_work_since(coming.since);
        let caution = Show::of(before.instrument()).caution_on(harmonics);
        caution.filter(|_| !self.coming.as_ref().is_some_and(gives_way))
    }

    /// Reports what went wrong, and does not retry automatically.
    fn refuse(&mut self, why: Error, shared: &mut Shared<'_>) {
        (self.loading, self.coming) = (None, None);
        self.refused |= self.concert.is_none();
        shared.notices.failed(why);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_said_that_children_will_be_others_unless_a_show_takes_their_place_unasked() {
        let mut concert = Concert::of_ball(32).unwrap();
        let parents = [1, 2].map(|item| Action::Choose { item, on: true });
        parents.into_iter().chain([Action::Breed]).for_each(|action| concert.act(action).unwrap());
        let (show, since) = (Show::of(concert.instrument()), concert.instrument().log().len());
        let mut room = MusicRoom { concert: Some(concert), ..MusicRoom::default() };
        assert!(room.caution_on(48).is_some() && room.caution_on(32).is_none());
        room.coming = Some(Coming { path: "evening.toml".into(), show, since });
        assert_eq!(room.caution_on(48), None);
        // Then it is asked whether the show may come.
        room.concert.as_mut().unwrap().act(Action::Favorite { item: 2, on: true }).unwrap();
        assert!(room.caution_on(48).is_some());
    }
}
