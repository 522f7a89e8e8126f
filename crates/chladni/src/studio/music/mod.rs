//! The music room: a gallery of living shapes, breeding, and the stage.

mod concert;
mod gallery;
mod knobs;
mod listening;
mod transport;

use std::path::{Path, PathBuf};

use chladni_caricature::ShapeSource;
use chladni_music::{Action, Preset, Session};
use egui::{Key, Ui};

use self::concert::{Concert, Ready};
use self::listening::Listening;
use super::icon::Icon;
use super::job::{self, Job, Outcome};
use super::room::{Room, Shared};
use super::shortcut::Shortcut;
use super::theme;

const PLAY: Shortcut = Shortcut::key(Key::Space, "Play or pause");
const BREED: Shortcut = Shortcut::key(Key::Enter, "Breed the chosen ones");
const BACK: Shortcut = Shortcut::command(Key::Z, "Back to the generation before");
const FAVOURITE: Shortcut = Shortcut::key(Key::F, "Favourite the item under the pointer");
const LOCK: Shortcut = Shortcut::key(Key::L, "Lock the item under the pointer");
const MUTATE: Shortcut = Shortcut::key(Key::M, "Change the item under the pointer a little");
const STAGE: Shortcut = Shortcut::key(Key::S, "Put the item under the pointer on stage");
const LEAVE: Shortcut = Shortcut::key(Key::Escape, "Leave the stage");
const TAP: Shortcut = Shortcut::key(Key::T, "Tap the beat");
const KEYS: [Shortcut; 9] = [PLAY, BREED, BACK, FAVOURITE, LOCK, MUTATE, STAGE, LEAVE, TAP];

/// Extensions of songs that can be heard.
const SONGS: [&str; 9] = ["wav", "flac", "mp3", "ogg", "oga", "m4a", "aac", "aiff", "aif"];

/// The room: one body, one gallery, one playlist.
#[derive(Default)]
pub struct MusicRoom {
    loading: Option<Job<Result<Ready, String>>>,
    concert: Option<Concert>,
    listening: Option<Listening>,
    refused: bool,
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
            self.load(ShapeSource::Sample("octopus".into()), shared);
        }
        if self.listening.is_none() && !self.refused {
            match Listening::start() {
                Ok(listening) => self.listening = Some(listening),
                Err(why) => {
                    self.refused = true;
                    shared.notices.error(why);
                }
            }
        }
        self.poll(shared);
        self.handle_keys(shared);
        let on_stage = self.concert.as_ref().is_some_and(Concert::on_stage);
        if !on_stage {
            self.panels(ui, shared);
        }
        egui::CentralPanel::default().frame(egui::Frame::new()).show(ui, |ui| {
            if let Some(loading) = &self.loading {
                job::show_progress(ui, loading);
            }
            let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
            if let Err(why) = concert.show(ui, shared, listening) {
                shared.notices.error(why);
            }
        });
        if let Some(listening) = &mut self.listening {
            for message in listening.messages() {
                shared.notices.warn(message);
            }
        }
        // The shapes dance: every frame is a new one.
        shared.ctx.request_repaint();
    }

    fn claims(&self, path: &Path) -> bool {
        let extension = extension(path);
        extension == "toml" || SONGS.contains(&extension.as_str())
    }

    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        let mut songs = Vec::new();
        for path in paths {
            match extension(path).as_str() {
                "toml" => self.open_text(path, shared),
                song if SONGS.contains(&song) => songs.push(path.clone()),
                _ => self.load(ShapeSource::File(path.clone()), shared),
            }
            shared.settings.remember(path);
        }
        if !songs.is_empty()
            && let Some(listening) = &mut self.listening
        {
            listening.play_list(songs);
        }
    }
}

impl MusicRoom {
    fn load(&mut self, source: ShapeSource, shared: &Shared<'_>) {
        let harmonics = shared.settings.harmonics.min(512);
        let label = format!("Opening {source}");
        self.loading =
            Some(Job::start(label, &shared.ctx, move |task| concert::load(&source, harmonics, task)));
    }

    /// A preset goes into the gallery, a session replaces it.
    fn open_text(&mut self, path: &Path, shared: &mut Shared<'_>) {
        let Some(concert) = &mut self.concert else {
            return shared.notices.warn("Open a shape first.");
        };
        let opened = match Preset::load(path) {
            Ok(preset) => {
                concert.act(Action::Load { item: 0, name: preset.name.clone(), mapping: preset.mapping })
            }
            Err(not_preset) => match Session::load(path) {
                Ok(session) => concert.replay(&session),
                Err(_) => Err(format!("{}: {not_preset}", path.display())),
            },
        };
        if let Err(why) = opened {
            shared.notices.error(why);
        }
    }

    fn poll(&mut self, shared: &mut Shared<'_>) {
        match self.loading.as_ref().map(Job::poll) {
            Some(Outcome::Done(Ok(ready))) => {
                self.loading = None;
                for warning in &ready.warnings {
                    shared.notices.warn(warning.clone());
                }
                match Concert::new(shared.gpu, ready) {
                    Ok(concert) => self.concert = Some(concert),
                    Err(why) => self.refuse(why, shared),
                }
            }
            Some(Outcome::Done(Err(why))) => self.refuse(why, shared),
            Some(Outcome::Lost) => self.refuse("Opening broke off; this is a bug.".into(), shared),
            Some(Outcome::Running) | None => {}
        }
    }

    /// Tells what went wrong and does not try the same again by itself.
    fn refuse(&mut self, why: String, shared: &mut Shared<'_>) {
        self.loading = None;
        self.refused |= self.concert.is_none();
        shared.notices.error(why);
    }

    fn handle_keys(&mut self, shared: &mut Shared<'_>) {
        let ctx = shared.ctx.clone();
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
        if PLAY.pressed(&ctx) {
            listening.toggle();
        }
        if TAP.pressed(&ctx) {
            listening.tap();
        }
        let mut actions = Vec::new();
        if BREED.pressed(&ctx) {
            actions.push(Action::Breed);
        }
        if BACK.pressed(&ctx) && concert.generation() > 0 {
            actions.push(Action::GoTo { generation: concert.generation() - 1 });
        }
        if concert.on_stage() && LEAVE.pressed(&ctx) {
            actions.push(Action::LeaveStage);
        }
        if let Some(item) = concert.hovered() {
            let (favourite, locked) = concert.marks(item);
            if FAVOURITE.pressed(&ctx) {
                actions.push(Action::Favourite { item, on: !favourite });
            }
            if LOCK.pressed(&ctx) {
                actions.push(Action::Lock { item, on: !locked });
            }
            if MUTATE.pressed(&ctx) {
                actions.push(Action::Mutate { item, amount: 0.2 });
            }
            if STAGE.pressed(&ctx) {
                actions.push(Action::Perform { item });
            }
        }
        for action in actions {
            if let Err(why) = concert.act(action) {
                shared.notices.warn(why);
            }
        }
    }

    fn panels(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
        let mut actions = Vec::new();
        let mut wish = None;
        let mut shape = None;
        egui::Panel::top("transport").exact_size(40.0).show(ui, |ui| {
            wish = transport::show(ui, listening, concert, &mut actions);
        });
        egui::Panel::right("knobs").exact_size(theme::PANEL_WIDTH - 24.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| knobs::show(ui, concert.instrument(), &mut actions));
        });
        egui::Panel::bottom("meters").exact_size(84.0).show(ui, |ui| transport::meters(ui, listening));
        for action in actions {
            if let Err(why) = concert.act(action) {
                shared.notices.warn(why);
            }
        }
        match wish {
            Some(transport::Wish::OpenSong) => {
                let songs = shared.chooser.open_several(&[("Songs", &SONGS)]);
                if !songs.is_empty() {
                    listening.play_list(songs);
                }
            }
            Some(transport::Wish::OpenShape) => {
                shape = shared.chooser.open(&[("Meshes", &super::caricature::MESHES)]);
            }
            Some(transport::Wish::SaveSession) => {
                let session = Session::of(concert.instrument(), &listening.song_name());
                save_as("session.toml", shared, |path| session.save(path).map_err(|error| error.to_string()));
            }
            None => {}
        }
        if let Some(item) = concert.take_preset_wish()
            && let Some(chosen) = concert.instrument().gallery().items().get(item).cloned()
        {
            let preset = Preset::of(concert.instrument(), &chosen, Vec::new());
            save_as("dance.toml", shared, |path| preset.save(path).map_err(|error| error.to_string()));
        }
        if let Some(path) = shape {
            self.load(ShapeSource::File(path), shared);
        }
    }
}

fn save_as(name: &str, shared: &mut Shared<'_>, save: impl FnOnce(&Path) -> Result<(), String>) {
    let Some(path) = shared.chooser.save(&[("Text", &["toml"])], Path::new(name)) else { return };
    match save(&path) {
        Ok(()) => shared.notices.done(format!("Saved {}", path.display())),
        Err(why) => shared.notices.error(why),
    }
}

fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |extension| extension.to_string_lossy().to_lowercase())
}
