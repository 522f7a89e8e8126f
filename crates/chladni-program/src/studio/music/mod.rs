//! The music room: a gallery of living shapes, breeding, and the stage.

mod close_up;
mod coarse;
mod concert;
mod curve;
mod drawer;
mod film;
mod gallery;
mod glimpse;
mod harmonics;
mod knobs;
mod lineage;
mod listening;
mod loading;
mod look;
mod meters;
mod pace;
mod preferences;
mod remote;
mod shelf;
mod songs;
mod stage;
mod stillness;
mod study;
mod transport;
mod voices;
mod wish;

use std::path::{Path, PathBuf};

use chladni_music::{Action, BeatReading, Cue, Preset, Show, SongRef};
use chladni_sound::Capture;
use egui::{Key, Ui};

use self::concert::{Concert, View};
use self::drawer::{Drawer, Drawers};
use self::film::{Filming, Scene};
use self::listening::{Listening, ShowSong};
use self::loading::Ready;
pub use self::preferences::Preferences;
use self::stage::Curtain;
use self::wish::Wish;
use super::Trace;
use super::icon::{self, Icon};
use super::job::{self, Job};
use super::room::{Room, Shared};
use super::shortcut::Shortcut;
use super::theme;
use crate::work::formats::{self, Kind, MESHES, PROJECT, SONGS, TEXT};
use crate::work::source::sample_path;
use crate::work::{Error, refer, resolve};

/// So often a room at rest looks for sound and controllers.
const LISTENING: std::time::Duration = std::time::Duration::from_millis(50);

const OPEN: Shortcut = Shortcut::command(Key::O, "Open a shape, songs, a preset or a show");
const SAVE: Shortcut = Shortcut::command(Key::S, "Save the show");
const FILM: Shortcut = Shortcut::command(Key::E, "Film what dances");
const PLAY: Shortcut = Shortcut::key(Key::Space, "Play or pause");
const NEXT_SONG: Shortcut = Shortcut::key(Key::PageDown, "The next song");
const PREVIOUS_SONG: Shortcut = Shortcut::key(Key::PageUp, "The song before");
const TAP: Shortcut = Shortcut::key(Key::T, "Tap the beat");
const HALVE: Shortcut = Shortcut::key(Key::OpenBracket, "The beat half as fast");
const DOUBLE: Shortcut = Shortcut::key(Key::CloseBracket, "The beat twice as fast");
const BREED: Shortcut = Shortcut::key(Key::Enter, "Breed the chosen ones");
const BACK: Shortcut = Shortcut::command(Key::Z, "Back to the generation before");
const FORTH: Shortcut = Shortcut::command_shift(Key::Z, "On to the generation after");
const MARK: [Shortcut; 4] = [
    Shortcut::key(Key::ArrowLeft, "Mark the dance to the left (on stage: the favourite before)"),
    Shortcut::key(Key::ArrowRight, "Mark the dance to the right (on stage: the next favourite)"),
    Shortcut::key(Key::ArrowUp, "Mark the dance above"),
    Shortcut::key(Key::ArrowDown, "Mark the dance below"),
];
const CHOOSE: Shortcut = Shortcut::key(Key::C, "Choose the marked dance as a parent, or no longer");
const FAVOURITE: Shortcut = Shortcut::key(Key::F, "Favourite");
const LOCK: Shortcut = Shortcut::key(Key::L, "Lock in its place");
const MUTATE: Shortcut = Shortcut::key(Key::M, "Change it a little");
const DRAW: Shortcut = Shortcut::key(Key::E, "Name it and draw its curves");
const STAGE: Shortcut = Shortcut::key(Key::S, "Put it on stage");
const SHOW: Shortcut = Shortcut::key(Key::G, "Put the favourites on stage");
const LEAVE: Shortcut = Shortcut::key(Key::Escape, "Leave the stage, or back to the gallery");
const KEYS: [Shortcut; 24] = [
    OPEN,
    SAVE,
    FILM,
    PLAY,
    NEXT_SONG,
    PREVIOUS_SONG,
    TAP,
    HALVE,
    DOUBLE,
    BREED,
    BACK,
    FORTH,
    MARK[0],
    MARK[1],
    MARK[2],
    MARK[3],
    CHOOSE,
    FAVOURITE,
    LOCK,
    MUTATE,
    DRAW,
    STAGE,
    SHOW,
    LEAVE,
];

/// The most harmonics that dance live.
const MOST_HARMONICS: usize = 512;

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
    trace: Option<Trace>,
    drawers: Drawers,
    curtain: Curtain,
    /// Presets and shows that wait for a shape.
    waiting: Vec<PathBuf>,
    /// A show that waits for its own shape.
    coming: Option<(PathBuf, Show)>,
    refused: bool,
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
        &KEYS
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
        let on_stage = self.concert.as_ref().is_some_and(Concert::on_stage);
        self.curtain.follow(&shared.ctx, on_stage, shared.settings.music.screen);
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
            if let Err(why) = concert.show(ui, shared, listening, self.trace.as_ref(), &mut wishes) {
                shared.notices.failed(why);
            }
            if on_stage {
                self.curtain.show(ui, concert);
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
                favourites: concert.instrument().favourites().len(),
            };
            if let Err(why) = self.filming.begin(scene, shared) {
                shared.notices.warn(why);
            }
        }
        for wish in wishes {
            self.fulfil(wish, shared);
        }
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

    fn stage(&self) -> Option<super::measure::Stage> {
        let concert = self.concert.as_ref()?;
        let (vertices, drawn_vertices) = concert.drawn_vertices();
        let items = concert.instrument().gallery().items().len();
        Some(super::measure::Stage { items, vertices, drawn_vertices })
    }

    fn hides_the_window(&self) -> bool {
        self.concert.as_ref().is_some_and(Concert::on_stage)
    }

    fn unsaved(&self) -> Option<String> {
        let concert = self.concert.as_ref().filter(|concert| concert.has_unsaved_work())?;
        let favourites = match concert.instrument().favourites().len() {
            0 => "dances that were changed by hand".to_owned(),
            1 => "one favourite".to_owned(),
            count => format!("{count} favourites"),
        };
        Some(format!("The show of the music room, with {favourites}, is not saved."))
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
        [TEXT].into_iter().chain(SONGS).collect()
    }

    fn claims(&self, path: &Path) -> bool {
        matches!(formats::kind(path), Kind::Text | Kind::Song)
    }

    fn change_device(&mut self, shared: &mut Shared<'_>) {
        // The new window has to fill the screen again.
        self.curtain = Curtain::default();
        if let Some(concert) = &mut self.concert
            && let Err(why) = concert.change_device(shared.gpu)
        {
            self.concert = None;
            self.refuse(why, shared);
        }
    }

    fn leave(&mut self) {
        self.filming.stop();
    }

    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        let mut songs = Vec::new();
        for path in paths {
            match formats::kind(path) {
                Kind::Text => self.waiting.push(path.clone()),
                Kind::Song => songs.push(path.clone()),
                Kind::Project | Kind::Mesh => self.load(path.clone(), shared),
            }
            if chladni_mesh::ShapeSource::sample_name(path).is_none() {
                shared.settings.remember(path);
            }
        }
        if !songs.is_empty() {
            match self.listening(shared) {
                Some(listening) => listening.add(songs),
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
            match Listening::start(music.volume, music.output_device.clone()) {
                Ok(mut listening) => {
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
            coarsely: super::viewport::gpu_of(shared.gpu).is_software(),
        }
    }

    /// A preset goes into the gallery, a show replaces it, with its shape and its songs.
    fn open_text(&mut self, path: PathBuf, shared: &mut Shared<'_>) {
        let Some(concert) = &mut self.concert else { return };
        let opened = match Preset::load(&path) {
            Ok(preset) => take(concert, preset, shared),
            Err(not_preset) => match Show::load(&path) {
                Ok(show) => return self.open_show(path, show, shared),
                Err(not_show) => {
                    let unread = matches!(not_preset, chladni_music::Error::File { .. });
                    let why = if !unread && is_like_a_show(&path) { not_show } else { not_preset };
                    Err(Error::from(why).of(path.display()))
                }
            },
        };
        if let Err(why) = opened {
            shared.notices.failed(why);
        }
    }

    /// Opens a show's shape first where another one dances.
    fn open_show(&mut self, path: PathBuf, show: Show, shared: &mut Shared<'_>) {
        let Some(concert) = &self.concert else { return };
        if let Some(caution) = show.caution() {
            shared.notices.warn(format!("{}: {caution}", path.display()));
        }
        let Some(body) = show.body.clone() else { return self.go_on_with(&path, &show, shared) };
        match resolve(&body, path.parent()) {
            Ok((body, warning)) => {
                warning.into_iter().for_each(|warning| shared.notices.warn(warning));
                let dances = concert.instrument().shape().eigenvalues.len();
                let wanted = show.harmonics.map_or(dances, |harmonics| harmonics.min(MOST_HARMONICS));
                if self.names.dancing == body && dances == wanted {
                    return self.go_on_with(&path, &show, shared);
                }
                if show.harmonics.is_some_and(|harmonics| harmonics > MOST_HARMONICS) {
                    let told = format!("{}: more harmonics than dance live; films have all.", path.display());
                    shared.notices.warn(told);
                }
                self.coming = Some((path, show));
                self.load(body, shared);
            }
            Err(why) => {
                shared.notices.warn(format!("{why}. It goes on with the shape that dances now."));
                self.go_on_with(&path, &show, shared);
            }
        }
    }

    /// Goes on with a show on the shape that dances.
    fn go_on_with(&mut self, path: &Path, show: &Show, shared: &mut Shared<'_>) {
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
        if let Err(why) = concert.replay(show) {
            return shared.notices.error(format!("{}: {why}", path.display()));
        }
        if let Some(looks) = &show.looks {
            shared.settings.music.look_like(looks);
        }
        let mut songs: Vec<ShowSong> = Vec::new();
        for song in &show.songs {
            let found = resolve(&song.file(), path.parent());
            let (file, warning) = match found {
                Ok(found) => found,
                Err(why) => {
                    shared.notices.warn(why);
                    (PathBuf::from(&song.path), None)
                }
            };
            warning.into_iter().for_each(|warning| shared.notices.warn(warning));
            songs.push(ShowSong::new(file, song.reading));
        }
        // What was heard is numbered by these songs; an older file has none, and the song goes on.
        if show.body.is_some() || !songs.is_empty() {
            let last = show.actions.iter().map(|line| line.moment.at_secs).fold(0.0, f64::max);
            listening.go_on(songs, &show.heard, show.duration_secs.unwrap_or(0.0).max(last));
        }
    }

    fn poll(&mut self, shared: &mut Shared<'_>) {
        match self.loading.as_ref().and_then(Job::ended) {
            Some(Ok(ready)) => {
                self.loading = None;
                for warning in &ready.warnings {
                    shared.notices.warn(warning.clone());
                }
                let concert = Concert::new(shared.gpu, ready).and_then(|mut concert| {
                    // Another shape dances what was bred on the one before.
                    self.concert.as_ref().map_or(Ok(()), |before| concert.go_on_from(before))?;
                    Ok(concert)
                });
                match concert {
                    Ok(concert) => {
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

    /// Tells what went wrong and does not try the same again by itself.
    fn refuse(&mut self, why: Error, shared: &mut Shared<'_>) {
        (self.loading, self.coming) = (None, None);
        self.refused |= self.concert.is_none();
        shared.notices.failed(why);
    }

    /// What the keys ask for.
    fn keys(&mut self, ctx: &egui::Context) -> Vec<Wish> {
        let mut wishes = Vec::new();
        if self.concert.is_none() && OPEN.pressed(ctx) {
            wishes.push(Wish::Open);
        }
        let (Some(concert), Some(listening)) = (&self.concert, &mut self.listening) else { return wishes };
        // An open menu has the keys.
        if egui::Popup::is_any_open(ctx) || self.filming.asks() {
            return wishes;
        }
        type Hearing = fn(&mut Listening);
        let hearing: [(Shortcut, Hearing); 6] = [
            (PLAY, Listening::toggle),
            (TAP, Listening::tap),
            (NEXT_SONG, |listening| listening.player().next()),
            (PREVIOUS_SONG, |listening| listening.player().previous()),
            (HALVE, Listening::halve),
            (DOUBLE, Listening::double),
        ];
        hearing.iter().filter(|(key, _)| key.pressed(ctx)).for_each(|(_, act)| act(listening));
        let when = |wishes: &mut Vec<Wish>, shortcut: Shortcut, wish: Wish| {
            if shortcut.pressed(ctx) {
                wishes.push(wish);
            }
        };
        if concert.on_stage() {
            when(&mut wishes, LEAVE, Wish::Do(Action::LeaveStage));
            when(&mut wishes, MARK[0], Wish::StepFavourite(false));
            when(&mut wishes, MARK[1], Wish::StepFavourite(true));
            return wishes;
        }
        when(&mut wishes, OPEN, Wish::Open);
        when(&mut wishes, SAVE, Wish::SaveShow);
        when(&mut wishes, FILM, Wish::Film);
        when(&mut wishes, BREED, Wish::Do(Action::Breed));
        let gallery = concert.instrument().gallery();
        // With Shift first: the key without it would answer, too.
        let go = [
            (FORTH, Some(gallery.current() + 1).filter(|&after| after < gallery.generations().len())),
            (BACK, gallery.current().checked_sub(1)),
        ];
        for (key, generation) in go {
            if key.pressed(ctx)
                && let Some(generation) = generation
            {
                wishes.push(Wish::Do(Action::GoTo { generation }));
            }
        }
        if !concert.instrument().favourites().is_empty() {
            when(&mut wishes, SHOW, Wish::Do(Action::PerformFavourites { first: 0 }));
        }
        if let Some(item) = concert.marked() {
            let marks = concert.marks(item);
            when(&mut wishes, CHOOSE, Wish::Do(Action::Choose { item, on: !marks.chosen }));
            when(&mut wishes, FAVOURITE, Wish::Do(Action::Favourite { item, on: !marks.favourite }));
            when(&mut wishes, LOCK, Wish::Do(Action::Lock { item, on: !marks.locked }));
            when(&mut wishes, MUTATE, Wish::Do(Action::Mutate { item, amount: 0.2 }));
            when(&mut wishes, DRAW, Wish::Show(View::CloseUp(item)));
            when(&mut wishes, STAGE, Wish::Do(Action::Perform { item }));
        }
        if concert.view() != View::Gallery {
            when(&mut wishes, LEAVE, Wish::Show(View::Gallery));
            return wishes;
        }
        for (key, (right, down)) in MARK.iter().zip([(-1, 0), (1, 0), (0, -1), (0, 1)]) {
            when(&mut wishes, *key, Wish::Mark { right, down });
        }
        wishes
    }

    /// What controllers ask for.
    fn follow_remote(&mut self, shared: &mut Shared<'_>, wishes: &mut Vec<Wish>) {
        let (Some(concert), Some(listening)) = (&self.concert, &mut self.listening) else { return };
        let parameters = concert.instrument().parameters();
        for cue in self.drawers.remote.cues(&mut shared.settings.music, parameters) {
            match cue {
                Cue::Do(action) => wishes.push(Wish::Do(action)),
                Cue::StepFavourite(forward) => wishes.push(Wish::StepFavourite(forward)),
                Cue::Tap => listening.tap(),
                Cue::PlayPause => listening.toggle(),
            }
        }
    }

    fn panels(&mut self, ui: &mut Ui, shared: &mut Shared<'_>, wishes: &mut Vec<Wish>) {
        let (Some(concert), Some(listening)) = (&self.concert, &mut self.listening) else { return };
        egui::Panel::top("transport").resizable(false).exact_size(40.0).show(ui, |ui| {
            transport::show(ui, listening, concert, wishes);
        });
        egui::Panel::right("drawer").resizable(false).exact_size(theme::PANEL_WIDTH - 24.0).show(ui, |ui| {
            self.drawers.show(ui, concert, listening, shared, wishes);
        });
        self.filming.show(ui);
        egui::Panel::bottom("meters")
            .resizable(false)
            .exact_size(meters::HEIGHT)
            .show(ui, |ui| meters::show(ui, listening));
    }

    fn fulfil(&mut self, wish: Wish, shared: &mut Shared<'_>) {
        if let Wish::Open | Wish::AddSongs = wish {
            return self.choose_files(matches!(wish, Wish::AddSongs), shared);
        }
        let (Some(concert), Some(listening)) = (&mut self.concert, &self.listening) else { return };
        let done = match wish {
            Wish::Do(action) => concert.act(action),
            Wish::Show(view) => {
                concert.look_at(view);
                Ok(())
            }
            Wish::TryOut(preset) => {
                concert.try_out(&preset);
                Ok(())
            }
            Wish::Mark { right, down } => {
                concert.mark_neighbour(right, down);
                Ok(())
            }
            Wish::StepFavourite(forward) => match concert.next_favourite(forward) {
                Some(first) => concert.act(Action::PerformFavourites { first }),
                None => Ok(()),
            },
            Wish::Keep(item) => {
                self.drawers.open = Drawer::Shelf;
                self.drawers.shelf.ask(concert.instrument(), item);
                Ok(())
            }
            Wish::Take(path) => match self.drawers.shelf.find(&path) {
                Some(preset) => take(concert, preset.clone(), shared),
                None => Ok(()),
            },
            Wish::Discard(path) => self.drawers.shelf.discard(&path),
            Wish::SavePreset(item) => match concert.instrument().item(item) {
                Some(item) => {
                    let preset = Preset::of(concert.instrument(), item, Vec::new());
                    let save = |path: &Path| preset.save(path).map_err(Error::unsaved);
                    save_as("dance.toml", shared, save).map(drop)
                }
                None => Ok(()),
            },
            Wish::SaveShow => save_show(concert, listening, &self.names, shared).map(drop),
            Wish::Film => self.filming.ask(),
            Wish::Open | Wish::AddSongs => Ok(()),
        };
        if let Err(why) = done {
            shared.notices.warn(why);
        }
    }

    fn choose_files(&mut self, songs_only: bool, shared: &mut Shared<'_>) {
        let all: Vec<&str> = MESHES.into_iter().chain(self.extensions()).chain([PROJECT]).collect();
        let kinds = [("All that dances or sounds", &all[..]), ("Meshes", &MESHES), ("Songs", &SONGS)];
        let paths = shared.chooser.open_several(if songs_only { &kinds[2..] } else { &kinds });
        if !paths.is_empty() {
            self.open(&paths, shared);
        }
    }
}

/// What the room offers where the first shape could not be opened.
fn nothing_dances(ui: &mut Ui, wishes: &mut Vec<Wish>) {
    ui.vertical_centered(|ui| {
        ui.add_space(ui.available_height() * 0.4);
        ui.label("Nothing dances yet: drop a shape anywhere, or open one.");
        ui.add_space(theme::GAP);
        if ui.button(icon::label(Icon::FolderOpen, "Open …")).on_hover_text(OPEN.tooltip(ui.ctx())).clicked()
        {
            wishes.push(Wish::Open);
        }
    });
}

/// Whether a text that is neither a preset nor a show was rather meant as the latter.
fn is_like_a_show(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("actions") || table.contains_key("size"))
}

/// A preset goes where nothing is lost that was chosen or loved: the last such place. The
/// generation before stays as it was; the knobs are those of the preset.
fn take(concert: &mut Concert, preset: Preset, shared: &mut Shared<'_>) -> Result<(), Error> {
    let instrument = concert.instrument();
    let items = instrument.gallery().items();
    let loved = |id| instrument.favourites().iter().any(|favourite| favourite.id == id);
    let free = items.iter().rposition(|item| !item.chosen && !item.locked && !loved(item.id));
    let item = free.unwrap_or(items.len().saturating_sub(1));
    let (caution, before) = (preset.caution(), instrument.parameters().clone());
    concert.look_at(View::Gallery);
    concert.act(Action::Take { item, preset: Box::new(preset) })?;
    if let Some(caution) = caution {
        shared.notices.warn(caution);
    } else if *concert.instrument().parameters() != before {
        shared.notices.done("Form and knobs are those of the preset now.".to_owned());
    }
    Ok(())
}

/// All that was done so far, to be saved in `folder`.
fn the_show(
    concert: &Concert,
    listening: &Listening,
    names: &Names,
    shared: &Shared<'_>,
    folder: Option<&Path>,
) -> Show {
    let (heard, songs) = listening.heard();
    let song = |song: &ShowSong| SongRef { reading: song.reading, ..SongRef::of(refer(&song.path, folder)) };
    Show {
        body: Some(refer(&names.dancing, folder)),
        looks: Some(shared.settings.music.looks()),
        viewpoint: concert.viewpoint(),
        songs: songs.iter().map(song).collect(),
        heard,
        duration_secs: Some(listening.at_secs()),
        ..Show::of(concert.instrument())
    }
}

/// The songs of the show as the command line calls them.
fn songs_of(listening: &Listening) -> Vec<(String, BeatReading)> {
    let (_, songs) = listening.heard();
    songs.iter().map(|song| (song.path.to_string_lossy().into_owned(), song.reading)).collect()
}

/// False where the person thinks better of it.
fn save_show(
    concert: &mut Concert,
    listening: &Listening,
    names: &Names,
    shared: &mut Shared<'_>,
) -> Result<bool, Error> {
    let Some(path) = shared.chooser.save(&[("Text", &[TEXT])], Path::new("show.toml")) else {
        return Ok(false);
    };
    let show = the_show(concert, listening, names, shared, path.parent());
    show.save(&path).map_err(Error::unsaved)?;
    shared.notices.done(format!("Saved {}", path.display()));
    concert.mark_saved();
    Ok(true)
}

/// False where the person thinks better of it.
fn save_as(
    name: &str,
    shared: &mut Shared<'_>,
    save: impl FnOnce(&Path) -> Result<(), Error>,
) -> Result<bool, Error> {
    let Some(path) = shared.chooser.save(&[("Text", &[TEXT])], Path::new(name)) else { return Ok(false) };
    save(&path)?;
    shared.notices.done(format!("Saved {}", path.display()));
    Ok(true)
}
