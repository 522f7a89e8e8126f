//! The music room: a gallery of living shapes, breeding, and the stage.

mod close_up;
mod coarse;
mod concert;
mod curtain;
mod curve;
mod drawer;
mod film;
mod fulfilment;
mod gallery;
mod glimpse;
mod hands;
mod harmonics;
mod keyboard;
mod knobs;
mod leaning;
mod lineage;
mod listening;
mod loading;
mod look;
#[cfg(target_os = "linux")]
mod media_keys;
mod meters;
mod outgoing;
mod pace;
mod place;
mod preferences;
mod projection;
mod recorder;
mod recording;
mod remote;
mod salvage;
mod shelf;
mod show_bar;
mod shows;
mod song_title;
mod songs;
mod stillness;
mod study;
mod transport;
mod view;
mod voices;
mod wish;

use std::path::{Path, PathBuf};

use chladni_music::Show;
use chladni_sound::Capture;
use egui::Ui;

use self::concert::Concert;
use self::curtain::Curtain;
use self::drawer::{Drawer, Drawers};
use self::film::{Filming, Scene};
use self::leaning::Leaning;
use self::listening::Listening;
use self::loading::Ready;
pub use self::preferences::Preferences;
use self::salvage::Salvage;
use self::shows::{MOST_HARMONICS, save_show, songs_of, the_show};
use self::wish::Wish;
use super::Trace;
use super::awake::Awake;
use super::icon::{self, Icon};
use super::job::{self, Job};
use super::room::{Room, Shared};
use super::shortcut::Shortcut;
use super::{keys, theme};
use crate::studio::author_id::AuthorId;
use crate::studio::keys::music::OPEN;
use crate::work::Error;
use crate::work::formats::{self, Kind, LISTS, SONGS, TEXT};
use crate::work::playlist;
use crate::work::source::sample_path;

/// How often a room at rest checks for sound and controllers.
const LISTENING: std::time::Duration = std::time::Duration::from_millis(50);

/// The room: one body, one gallery, one playlist.
#[derive(Default)]
pub struct MusicRoom {
    loading: Option<Job<Ready>>,
    /// What is being loaded and what dances, as the command line calls them.
    names: Names,
    filming: Filming,
    concert: Option<Concert>,
    listening: Option<Listening>,
    /// What to listen to once there are ears.
    input: Option<Capture>,
    #[cfg(target_os = "linux")]
    media_keys: Option<media_keys::MediaKeys>,
    trace: Option<Trace>,
    drawers: Drawers,
    curtain: Curtain,
    leaning: Leaning,
    awake: Awake,
    /// Presets and shows that wait for a shape.
    waiting: Vec<PathBuf>,
    /// A show that waits for its own shape.
    coming: Option<(PathBuf, Show)>,
    refused: bool,
    /// The preset of the shelf that a controller took last.
    preset: Option<usize>,
    /// The stage has a window of its own.
    apart: bool,
    /// The time of the last frame, by the window's clock.
    recorded_secs: f64,
    salvage: Salvage,
}

/// Bodies by the names that the command line knows them by.
#[derive(Default)]
struct Names {
    loading: PathBuf,
    dancing: PathBuf,
}

impl Room for MusicRoom {
    fn name(&self) -> &'static str {
        "Music"
    }

    fn icon(&self) -> Icon {
        Icon::AudioWaveform
    }

    fn invitation(&self) -> &'static str {
        "Let a shape dance to a song. Breed the dances you love, and put one on stage."
    }

    fn shortcuts(&self) -> &'static [Shortcut] {
        keys::music::ALL
    }

    fn show(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        if self.concert.is_none() && self.loading.is_none() && !self.refused {
            self.load(sample_path("octopus"), shared);
        }
        self.listening(shared);
        self.poll(shared);
        self.filming.poll(shared);
        let mut wishes = self.keys(&shared.ctx);
        self.follow_remote(shared, &mut wishes);
        #[cfg(target_os = "linux")]
        self.follow_media_keys(shared);
        let staged = self.concert.as_ref().is_some_and(Concert::on_stage);
        self.apart = shared.settings.music.own_window;
        // Whether the stage has this window.
        let on_stage = staged && !self.apart;
        let plays = self.listening.as_ref().is_some_and(Listening::plays_songs);
        if staged || !shared.settings.music.leans_back {
            self.leaning.end();
        } else if self.leaning.is_at_rest(&shared.ctx) && plays {
            self.drawers.shelf.ready(shared.folders.dances.as_deref(), shared.notices);
            wishes.push(Wish::Autopilot);
        }
        let piloted = self.concert.as_ref().is_some_and(Concert::is_piloted);
        if let Some(why) = self.awake.keep(piloted) {
            shared.notices.warn(why);
        }
        let names = || shared.screen.monitors();
        if let Some(why) = self.curtain.follow(&shared.ctx, on_stage, &shared.settings.music.screen, names) {
            shared.notices.warn(why);
        }
        if !on_stage {
            self.panels(ui, shared, &mut wishes);
        }
        // Words stand on the theme's own ground; the dance brings its own.
        let ground =
            if self.concert.is_some() { egui::Color32::TRANSPARENT } else { ui.visuals().panel_fill };
        let backdrop = egui::Frame::new().fill(ground);
        egui::CentralPanel::default().frame(backdrop).show(ui, |ui| {
            if let Some(loading) = &self.loading {
                job::show_progress(ui, loading);
            }
            let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else {
                if self.loading.is_none() {
                    nothing_dances(ui, &mut wishes);
                }
                return;
            };
            concert.adjusts = self.drawers.adjusts;
            if let Err(why) = concert.show(ui, shared, listening, self.trace.as_ref(), &mut wishes) {
                shared.notices.failed(why);
            }
            if on_stage {
                self.curtain.show(ui, concert);
                if self.drawers.adjusts {
                    let screen = ui.max_rect();
                    shared.settings.music.projection.adjust(ui, screen);
                }
            }
        });
        if let (Some(concert), Some(listening)) = (&self.concert, &self.listening)
            && self.filming.show_form(&shared.ctx, concert.picture_size(), listening.at_secs())
        {
            let scene = Scene {
                show: the_show(concert, listening, &self.names, shared, None),
                body: self.names.dancing.to_string_lossy().into_owned(),
                songs: songs_of(listening),
                song: listening.song_number(),
                view: concert.view(),
                favorites: concert.instrument().favorites().len(),
            };
            if let Err(why) = self.filming.begin(scene, shared) {
                shared.notices.warn(why);
            }
        }
        for wish in wishes {
            self.fulfil(wish, shared);
        }
        self.recorded_secs = shared.ctx.input(|input| input.time);
        self.salvage.follow(shared);
        self.follow_recording(shared);
        self.follow_camera(shared);
        if let Some(listening) = &mut self.listening {
            for message in listening.messages() {
                shared.notices.warn(message);
            }
        }
        // While the shapes dance every frame is a new one; else something may begin by itself.
        if self.concert.as_ref().is_some_and(Concert::is_moving) {
            shared.ctx.request_repaint();
        } else {
            shared.ctx.request_repaint_after(LISTENING);
        }
    }

    fn sound(&self) -> Option<(f64, u64)> {
        // Until the shapes dance, the window waits for them.
        self.concert.as_ref()?;
        let status = self.listening.as_ref()?.player().status();
        Some((status.position_secs, status.underruns))
    }

    fn stage(&self) -> Option<super::measure::OnStage> {
        let concert = self.concert.as_ref()?;
        let (vertices, drawn_vertices) = concert.drawn_vertices();
        let items = concert.instrument().gallery().items().len();
        Some(super::measure::OnStage { items, vertices, drawn_vertices })
    }

    fn hides_the_window(&self) -> bool {
        !self.apart && self.concert.as_ref().is_some_and(Concert::on_stage)
    }

    fn unsaved(&self) -> Option<String> {
        let concert = self.concert.as_ref().filter(|concert| concert.has_unsaved_work())?;
        let favorites = match concert.instrument().favorites().len() {
            0 => "dances that were changed by hand".to_owned(),
            1 => "one favorite".to_owned(),
            count => format!("{count} favorites"),
        };
        Some(format!("The show of the music room, with {favorites}, is not saved."))
    }

    fn save_all(&mut self, shared: &mut Shared<'_>) -> bool {
        let (Some(concert), Some(listening)) = (&mut self.concert, &self.listening) else { return true };
        let saved = if concert.has_unsaved_work() {
            save_show(concert, listening, &self.names, shared)
        } else {
            Ok(true)
        };
        saved.unwrap_or_else(|why| {
            shared.notices.failed(why);
            false
        })
    }

    fn extensions(&self) -> Vec<&'static str> {
        [TEXT].into_iter().chain(LISTS).chain(SONGS).collect()
    }

    fn claims(&self, path: &Path) -> bool {
        matches!(formats::kind(path), Kind::Text | Kind::Song) || playlist::is_list(path)
    }

    fn change_device(&mut self, shared: &mut Shared<'_>) {
        // The new window has to fill the screen again.
        self.curtain = Curtain::default();
        if let Some(concert) = &mut self.concert
            && let Err(why) = concert.change_device(shared.screen)
        {
            self.concert = None;
            self.refuse(why, shared);
        }
    }

    fn leave(&mut self) {
        self.save_recording();
        self.filming.stop();
    }

    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        let mut songs = Vec::new();
        for path in paths {
            match formats::kind(path) {
                _ if playlist::is_list(path) => match playlist::songs_of(path) {
                    Ok(found) => {
                        songs.extend(found.songs);
                        found.warning.into_iter().for_each(|warning| shared.notices.warn(warning));
                    }
                    Err(why) => shared.notices.failed(why),
                },
                Kind::Text => self.waiting.push(path.clone()),
                Kind::Song => songs.push(path.clone()),
                Kind::Project | Kind::Mesh | Kind::List => self.load(path.clone(), shared),
            }
            if chladni_mesh::ShapeSource::sample_name(path).is_none() {
                shared.settings.remember(path);
            }
        }
        if !songs.is_empty() {
            match self.listening(shared) {
                Some(listening) => {
                    listening.add(songs);
                    self.leaning.begin(&shared.ctx);
                }
                None => shared.notices.warn("There is no player for these songs."),
            }
        }
    }
}

impl MusicRoom {
    /// A room that listens to `input` from the beginning, where there is one, and tells `trace` what it plays.
    pub fn listening_to(input: Option<Capture>, trace: Option<Trace>) -> Self {
        Self { input, trace, ..Self::default() }
    }

    /// Loads a shape, or a caricature, whose voices are shown.
    fn load(&mut self, path: PathBuf, shared: &mut Shared<'_>) {
        let means = self.means(shared);
        if formats::is_project(&path) {
            self.drawers.open = Drawer::Body;
        }
        self.names.loading.clone_from(&path);
        let label = format!("Opening {}", path.display());
        self.loading = Some(Job::start(label, &shared.ctx, move |task| loading::load(&path, means, task)));
    }

    /// The ears, started when they are first needed; `None` where that failed.
    fn listening(&mut self, shared: &mut Shared<'_>) -> Option<&mut Listening> {
        if self.listening.is_none() && !self.refused {
            let music = &shared.settings.music;
            match Listening::start(&shared.ctx, music.volume, music.output_device.clone()) {
                Ok(mut listening) => {
                    listening.set_song_fade_secs(music.song_fade_secs);
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
        let of_show = self.coming.as_ref().and_then(|(_, show)| show.harmonics);
        loading::Means {
            harmonics: of_show.unwrap_or(shared.settings.harmonics).min(MOST_HARMONICS),
            coarsely: shared.screen.device().is_software(),
        }
    }

    fn poll(&mut self, shared: &mut Shared<'_>) {
        match self.loading.as_ref().and_then(Job::ended) {
            Some(Ok(ready)) => {
                self.loading = None;
                for warning in &ready.warnings {
                    shared.notices.warn(warning.clone());
                }
                let concert = Concert::new(shared.screen, ready).and_then(|mut concert| {
                    // Another shape dances what was bred on the one before.
                    self.concert.as_ref().map_or(Ok(()), |before| concert.go_on_from(before))?;
                    Ok(concert)
                });
                match concert {
                    Ok(mut concert) => {
                        // Another shape goes on in the same film.
                        if let Some(before) = self.concert.take() {
                            concert.outgoing = before.outgoing;
                        }
                        self.concert = Some(concert);
                        self.names.dancing = std::mem::take(&mut self.names.loading);
                        if let Some((path, show)) = self.coming.take() {
                            self.go_on_with(&path, &show, shared);
                        }
                    }
                    Err(why) => self.refuse(why, shared),
                }
            }
            Some(Err(why)) => self.refuse(why, shared),
            None => {}
        }
        while self.concert.is_some() && self.loading.is_none() && !self.waiting.is_empty() {
            let path = self.waiting.remove(0);
            self.open_text(path, shared);
        }
    }

    /// Reports what went wrong, and does not retry automatically.
    fn refuse(&mut self, why: Error, shared: &mut Shared<'_>) {
        (self.loading, self.coming) = (None, None);
        self.refused |= self.concert.is_none();
        shared.notices.failed(why);
    }

    fn panels(&mut self, ui: &mut Ui, shared: &mut Shared<'_>, wishes: &mut Vec<Wish>) {
        let (Some(concert), Some(listening)) = (&self.concert, &mut self.listening) else { return };
        egui::Panel::top("transport").resizable(false).exact_size(40.0).show(ui, |ui| {
            transport::show(ui, listening, concert, wishes);
        });
        if concert.on_stage() {
            egui::Panel::top("show").resizable(false).exact_size(36.0).show(ui, |ui| {
                show_bar::show(ui, concert, wishes);
            });
        }
        egui::Panel::right("drawer").resizable(false).exact_size(theme::PANEL_WIDTH - 24.0).show(ui, |ui| {
            self.drawers.show(ui, concert, listening, shared, wishes);
        });
        self.filming.show(ui);
        egui::Panel::bottom("meters")
            .resizable(false)
            .exact_size(meters::HEIGHT)
            .show(ui, |ui| meters::show(ui, listening));
    }
}

/// What the room offers if the first shape could not be opened.
fn nothing_dances(ui: &mut Ui, wishes: &mut Vec<Wish>) {
    ui.vertical_centered(|ui| {
        ui.add_space(ui.available_height() * 0.4);
        ui.label("Nothing dances yet: drop a shape anywhere, or open one.");
        ui.add_space(theme::GAP);
        let open = ui.button(icon::label(Icon::FolderOpen, "Open …")).author_id("open");
        if open.on_hover_text(OPEN.tooltip(ui.ctx())).clicked() {
            wishes.push(Wish::Open);
        }
    });
}
