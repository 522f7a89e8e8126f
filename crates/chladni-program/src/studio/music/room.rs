//! The room as the window sees it: how it is shown, kept and opened.

use std::path::{Path, PathBuf};

use egui::Ui;

use super::MusicRoom;
use super::concert::Concert;
use super::curtain::Curtain;
use super::drawer::Drawer;
use super::film::{OnStage, Scene};
use super::listening::{Listening, Message};
use super::shows::{songs_of, songs_of_list};
use super::view::View;
use super::wish::{Then, Wish};
use super::{meters, show_bar, transport};
use crate::studio::author_id::AuthorId;
use crate::studio::dropping::named;
use crate::studio::icon::{self, Icon};
use crate::studio::job;
use crate::studio::keys::music::OPEN;
use crate::studio::room::{Room, Shared};
use crate::studio::shortcut::Shortcut;
use crate::studio::{keys, measure, theme};
use crate::work::formats::{self, Kind, LISTS, SONGS, TEXT};
use crate::work::source::sample_path;
use crate::work::{Error, playlist, unread};

/// How often a room at rest checks for sound and controllers.
const LISTENING: std::time::Duration = std::time::Duration::from_millis(50);
/// The matter of notices about whether there is sound.
const SOUND: &str = "sound";
/// What other programs see has come to an end when nothing has moved for longer: not in a pause between two songs.
const REST_SECS: f64 = 300.0;

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
        match self.calibrating {
            Some(_) => keys::calibrating::ALL,
            None if self.filming.asks() => keys::filming::ALL,
            None => keys::music::ALL,
        }
    }

    fn show(&mut self, ui: &mut Ui, shared: &mut Shared<'_>) {
        if self.concert.is_none() && self.loading.is_none() && !self.refused {
            self.load(sample_path("octopus"), shared);
        }
        self.notice_absence(shared);
        self.listening(shared);
        self.poll(shared);
        self.follow_dialog(shared);
        self.leaning.notice(&shared.ctx);
        let mut wishes = self.keys(shared);
        // A control that is touched later is meant for something else.
        if self.hides_the_window() || self.drawers.open != Drawer::Remote {
            self.drawers.remote.stop_learning();
        }
        self.follow_remote(shared, &mut wishes);
        let staged = self.concert.as_ref().is_some_and(Concert::on_stage);
        self.apart = shared.settings.music.own_window;
        // Whether the stage has this window.
        let on_stage = staged && !self.apart;
        self.lean_back(staged, shared, &mut wishes);
        self.keep_the_screen(on_stage, shared);
        if !on_stage {
            self.panels(ui, shared, &mut wishes);
        }
        self.dance(ui, on_stage, shared, &mut wishes);
        self.follow_taps(shared);
        self.ask_for_a_film(shared);
        self.ask_to_replace(shared);
        for wish in wishes {
            self.fulfil(wish, shared);
        }
        self.last_secs = shared.ctx.input(|input| input.time);
        self.salvage.follow(shared);
        self.begin_output(shared);
        self.follow_recording(shared);
        self.follow_camera(shared);
        if let Some(listening) = &mut self.listening {
            for message in listening.messages() {
                match message {
                    Message::Warning(text) => shared.notices.warn(text),
                    Message::Silence(text) => shared.notices.update(SOUND, text),
                    Message::Sound => shared.notices.withdraw(SOUND),
                }
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

    fn stage(&self) -> Option<measure::OnStage> {
        let concert = self.concert.as_ref()?;
        let (vertices, drawn_vertices) = concert.drawn_vertices();
        let items = concert.instrument().gallery().items().len();
        Some(measure::OnStage { items, vertices, drawn_vertices })
    }

    fn left_out(&self) -> Option<u64> {
        let recorder = self.concert.as_ref()?.outgoing.recorder.as_ref()?;
        Some(recorder.progress(self.last_secs).1)
    }

    fn hides_the_window(&self) -> bool {
        !self.apart && self.concert.as_ref().is_some_and(Concert::on_stage)
    }

    fn will_hide_the_window(&self) -> bool {
        self.autopilot && !self.apart && !self.refused
    }

    fn asks(&self) -> bool {
        self.filming.asks()
    }

    fn show_over(&mut self, shared: &mut Shared<'_>) {
        // The songs go on in another room.
        #[cfg(target_os = "linux")]
        self.follow_media_keys(shared);
        // In another room nobody taps to the clicks.
        if self.pass != shared.ctx.cumulative_pass_nr() {
            self.end_calibrating();
            // The stage stands still there, and its own window is closed.
            self.awake.keep(false);
            // Nor does the other room fill the stage's screen.
            self.curtain.follow(&shared.ctx, false, &shared.settings.music.screen, Vec::new);
        }
        // A window that closes waits for it, whichever room is on screen.
        self.filming.poll(shared);
        // Also where the room was left right after the last action.
        self.keep_show(false, shared);
    }

    fn recovers(&mut self, shared: &mut Shared<'_>) -> bool {
        self.offer_show(shared)
    }

    fn interrupt(&mut self, shared: &mut Shared<'_>) {
        self.leave_show(shared);
    }

    fn unsaved(&self) -> Option<String> {
        self.unsaved_show()
    }

    fn being_made(&self) -> Option<&str> {
        self.filming.unfinished()
    }

    fn save_all(&mut self, shared: &mut Shared<'_>) -> bool {
        self.save_dances(shared)
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
        // So is the dialog: it belonged to the one that is gone.
        self.asking = None;
        if let Some(listening) = &mut self.listening {
            listening.change_window(&shared.ctx);
        }
        if let Some(concert) = &mut self.concert
            && let Err(why) = concert.change_device(shared.screen)
        {
            // The next start offers the show that cannot go on.
            self.leave_show(shared);
            self.concert = None;
            self.refuse(why, shared);
        }
    }

    fn leave(&mut self) {
        self.save_recording();
        self.drop_show();
        self.filming.stop();
    }

    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        let mut songs = Vec::new();
        let (opened, left_out) = formats::opened_together(paths);
        left_out.into_iter().for_each(|why| shared.notices.warn(why));
        let shape = shape_among(&opened);
        for path in &opened {
            match formats::kind(path) {
                _ if playlist::is_list(path) => songs.extend(songs_of_list(path, shared)),
                Kind::Text => self.waiting.push(path.clone()),
                Kind::Song => songs.push(path.clone()),
                Kind::Project | Kind::Mesh | Kind::List => {
                    if let Some(first) = shape.filter(|first| *first != path) {
                        let (first, other) = (first.display(), path.display());
                        shared
                            .notices
                            .warn(format!("{other}: one shape dances at a time, and {first} is opened"));
                        continue;
                    }
                    if let Some(coming) = self.coming.take() {
                        let show = coming.path.display();
                        shared.notices.warn(format!("{show} was not opened: another shape was chosen."));
                    }
                    self.load(path.clone(), shared);
                }
            }
            // A project is remembered once it dances.
            if chladni_mesh::ShapeSource::sample_name(path).is_none() && !formats::is_project(path) {
                shared.settings.remember(path);
            }
        }
        // A show needs a shape: the first one is tried once more.
        if self.concert.is_none() && self.loading.is_none() && !self.waiting.is_empty() {
            self.refused = false;
        }
        self.late_songs.extend(songs);
        self.add_songs(shared);
    }

    fn drop_does(&self, paths: &[PathBuf], _anew: bool) -> Option<String> {
        let (opened, _) = formats::opened_together(paths);
        let is_text = |path: &&PathBuf| !playlist::is_list(path) && formats::kind(path) == Kind::Text;
        let is_song = |path: &&PathBuf| playlist::is_list(path) || formats::kind(path) == Kind::Song;
        let texts = opened.iter().filter(is_text);
        let begun: Vec<PathBuf> = shape_among(&opened).into_iter().chain(texts).cloned().collect();
        let songs: Vec<PathBuf> = opened.iter().filter(is_song).cloned().collect();
        match (named(&begun), named(&songs)) {
            (Some(begun), None) => Some(format!("Open {begun}")),
            (Some(begun), Some(songs)) => Some(format!("Open {begun}, and play {songs}")),
            (None, songs) => Some(format!("Play {}", songs?)),
        }
    }
}

impl MusicRoom {
    /// While another room is shown, the system closes the stage's own window, nothing is recorded, and controls move
    /// nothing.
    fn notice_absence(&mut self, shared: &mut Shared<'_>) {
        let pass = shared.ctx.cumulative_pass_nr();
        let was_away = std::mem::replace(&mut self.pass, pass) + 1 < pass;
        if !was_away {
            return;
        }
        self.drawers.remote.forget_touches();
        self.drawers.remote.stop_learning();
        let Some(concert) = &mut self.concert else { return };
        concert.come_back();
        if concert.outgoing.is_recording() {
            shared.notices.warn("The recording stood still while another room was open.");
        }
    }

    /// The warning about work that is in no file, if there is any.
    pub(super) fn unsaved_show(&self) -> Option<String> {
        let concert = self.concert.as_ref().filter(|concert| concert.has_unsaved_work())?;
        let favorites = match concert.instrument().favorites().len() {
            0 => "what was bred or changed by hand".to_owned(),
            1 => "one favorite".to_owned(),
            count => format!("{count} favorites"),
        };
        Some(format!("The show of the music room, with {favorites}, is not saved."))
    }

    /// The autopilot takes over where songs play and nobody is there; and at the start, where it is to begin at once.
    fn lean_back(&mut self, staged: bool, shared: &mut Shared<'_>, wishes: &mut Vec<Wish>) {
        // A show that is still to come would end it.
        let is_open = self.loading.is_none() && self.waiting.is_empty();
        if self.autopilot
            && is_open
            && self.listening.is_some()
            && let Some(concert) = &self.concert
        {
            self.autopilot = false;
            if !concert.is_piloted() {
                return wishes.push(Wish::Autopilot);
            }
        }
        let plays = self.concert.is_some() && self.listening.as_ref().is_some_and(Listening::plays_songs);
        if staged || !shared.settings.music.leans_back {
            self.leaning.end();
        } else if self.leaning.is_at_rest(&shared.ctx, plays) {
            wishes.push(Wish::Autopilot);
        }
    }

    /// The screen stays on while something is on stage or recorded, or moves where other programs see it, and the stage
    /// fills the one that was chosen for it.
    fn keep_the_screen(&mut self, on_stage: bool, shared: &mut Shared<'_>) {
        let now_secs = shared.ctx.input(|input| input.time);
        if self.concert.as_ref().is_some_and(Concert::is_moving) {
            self.moved_secs = now_secs;
        }
        // A camera is chosen for good, a stream only for this start.
        let moves = now_secs - self.moved_secs < REST_SECS;
        let plays = |concert: &Concert| {
            let outgoing = &concert.outgoing;
            let is_seen = outgoing.is_streaming() || (moves && outgoing.camera().is_some());
            concert.on_stage() || outgoing.recorder.is_some() || is_seen
        };
        if let Some(why) = self.awake.keep(self.concert.as_ref().is_some_and(plays)) {
            shared.notices.warn(why);
        }
        let names = || shared.screen.monitors();
        if let Some(why) = self.curtain.follow(&shared.ctx, on_stage, &shared.settings.music.screen, names) {
            shared.notices.warn(why);
        }
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

    /// The gallery, or the stage where this window is its own.
    fn dance(&mut self, ui: &mut Ui, on_stage: bool, shared: &mut Shared<'_>, wishes: &mut Vec<Wish>) {
        // Words stand on the theme's own ground; the dance brings its own.
        let ground =
            if self.concert.is_some() { egui::Color32::TRANSPARENT } else { ui.visuals().panel_fill };
        let backdrop = egui::Frame::new().fill(ground);
        egui::CentralPanel::default().frame(backdrop).show(ui, |ui| {
            if let Some((_, loading)) = &self.loading {
                egui::Panel::bottom("loading").resizable(false).show(ui, |ui| {
                    ui.add_space(theme::GAP_SMALL);
                    job::show_progress(ui, loading);
                    ui.add_space(theme::GAP_SMALL);
                });
            }
            let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else {
                if self.loading.is_none() {
                    nothing_dances(ui, wishes);
                }
                return;
            };
            concert.adjusts = self.drawers.adjusts;
            if let Err(why) = concert.show(ui, shared, listening, self.trace.as_ref(), wishes) {
                shared.notices.failed(why);
            }
            if on_stage {
                // The curtain comes last: it sees the keys that nothing else has taken.
                if self.drawers.adjusts {
                    let screen = ui.max_rect();
                    shared.settings.music.projection.adjust(ui, screen);
                }
                self.curtain.show(ui, concert, shared.settings.music.projection);
            }
        });
    }

    /// Shows the form for a film while it is open, and asks where the film is to go.
    fn ask_for_a_film(&mut self, shared: &mut Shared<'_>) {
        if let (Some(concert), Some(listening)) = (&self.concert, &self.listening)
            && let Some(then) =
                self.filming.show_form(&shared.ctx, concert.picture_size(), listening.at_secs())
        {
            self.ask_for(then, shared);
        }
    }

    /// Begins the film that was asked for.
    pub(super) fn film_to(
        &mut self,
        path: &Path,
        is_folder: bool,
        shared: &mut Shared<'_>,
    ) -> Result<(), Error> {
        if let (Some(concert), Some(listening), Some(show)) =
            (&self.concert, &self.listening, self.the_show(shared, unread))
        {
            let look = concert.instrument().look().unwrap_or_default().to_owned();
            let on_stage = OnStage { place: concert.place_in_turn(), look };
            let scene = Scene {
                songs: songs_of(&show),
                show,
                body: self.body.to_string_lossy().into_owned(),
                song: listening.song_number(),
                // A close-up behind the stage is not seen.
                view: if self.hides_the_window() { View::Gallery } else { concert.view() },
                on_stage: concert.on_stage().then_some(on_stage),
                favorites: concert.instrument().favorites().len(),
                draw: shared.screen.draw(),
            };
            self.filming.begin(scene, path, is_folder, &shared.ctx)?;
        }
        Ok(())
    }
}

/// The one of `paths` that dances: a project brings its mesh by itself.
fn shape_among(paths: &[PathBuf]) -> Option<&PathBuf> {
    let project = paths.iter().find(|path| formats::is_project(path));
    project.or_else(|| paths.iter().find(|path| is_shape(path)))
}

fn is_shape(path: &Path) -> bool {
    !playlist::is_list(path) && formats::kind(path) == Kind::Mesh
}

/// The room's offer if the first shape could not be opened.
fn nothing_dances(ui: &mut Ui, wishes: &mut Vec<Wish>) {
    ui.vertical_centered(|ui| {
        ui.add_space(ui.available_height() * 0.4);
        ui.label("Nothing dances yet: open a shape.");
        ui.add_space(theme::GAP);
        let open = ui.button(icon::label(Icon::FolderOpen, "Open …")).author_id("open");
        if open.on_hover_text(OPEN.tooltip(ui.ctx())).clicked() {
            wishes.push(Wish::Choose(Then::Open));
        }
    });
}
