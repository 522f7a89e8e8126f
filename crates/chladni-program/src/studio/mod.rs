//! The window: a bar to switch between its rooms, and the parts that rooms share.
//!
//! Rooms read their engines' state and emit actions; only the engines change state.

mod age;
mod author_id;
mod awake;
mod card;
mod caricature;
mod choose;
mod closing;
mod context_menu;
mod copying;
mod curve_keys;
mod device;
mod dropping;
mod effort;
mod error;
mod file_window;
mod fitting;
mod focus;
mod folders;
mod handover;
mod icon;
mod job;
mod key_sheet;
mod keys;
mod measure;
mod music;
mod newest;
mod notices;
mod opening;
mod pictures;
mod processor_window;
mod room;
mod screen;
#[cfg(target_os = "linux")]
mod screen_changes;
mod settings;
mod shortcut;
mod standing;
mod start;
mod theme;
mod top_bar;
mod unsaved;
mod viewport;
mod zoom;

use std::cell::RefCell;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Duration, Instant};

use chladni_synth::DeviceLoss;
use chladni_task::Task;
use egui::Key;

pub use caricature::Rehearsal;
pub use choose::{Chooser, SystemDialogs};
pub use error::StudioError;
pub use file_window::{COMMAND as CHOOSE_FILE, FileWindow, Purpose, Request, open as choose_file};
pub use folders::Folders;
pub use handover::Handover;
pub use measure::{FirstPicture, FrameReport, Measure};
pub use opening::{Live, Opening, PlayedFrame, SetOutput, SetPlan, SetTarget, Trace, open};
pub use processor_window::Painter;
pub use settings::Settings;

use choose::Dialogs;
use closing::Closing;
use fitting::Fitting;
use key_sheet::KeySheet;
use keys::window::{FULL_SCREEN, HELP, SWITCH_ROOM};
use notices::Notices;
use pictures::Pictures;
use processor_window::Program;
use room::{Room, Shared};
use screen::Screen;

use crate::work::source::from_anywhere;

/// The place of the music room among the rooms.
const MUSIC: usize = 1;

/// The whole window.
pub struct Studio {
    screen: Screen,
    loss: DeviceLoss,
    handover: Handover,
    /// Seconds on the clock when the window opened, if it continues another window.
    inherited_secs: Option<f64>,
    folders: Folders,
    chooser: Dialogs,
    measure: Option<Rc<RefCell<Measure>>>,
    first_picture: Option<Rc<FirstPicture>>,
    now: fn() -> Instant,
    settings: Settings,
    saved_settings: Settings,
    /// Those that could not be written, if it failed.
    refused_settings: Option<Settings>,
    /// When they were written last.
    settings_written: Option<Instant>,
    notices: Notices,
    pictures: Pictures,
    rooms: Vec<Box<dyn Room>>,
    /// The room on screen; `None` is the start screen.
    current: Option<usize>,
    key_sheet: KeySheet,
    closing: Closing,
    /// Nobody has chosen preferences yet.
    first_run: bool,
    fitting: Fitting,
    /// Cancelled where the system asks the program to end.
    ends: Option<Task>,
}

impl Studio {
    /// The state of a window that eframe opens.
    ///
    /// Fails where a graphics device is asked for and eframe offers none.
    pub fn new(
        creation: &eframe::CreationContext<'_>,
        opening: Opening,
    ) -> Result<Self, Box<dyn std::error::Error + Send + Sync>> {
        let screen = Screen::of(creation, opening.draw)?;
        Ok(Self::on(&creation.egui_ctx, screen, opening))
    }

    /// The state of a window whose pictures come to `screen`.
    fn on(ctx: &egui::Context, screen: Screen, opening: Opening) -> Self {
        let mut notices = Notices::default();
        let Opening {
            mut folders,
            chooser,
            files,
            measure,
            first_picture,
            input,
            set,
            trace,
            handover,
            now,
            patience,
            ends,
            ..
        } = opening;

        let first_run = folders.settings.as_ref().is_some_and(|path| !path.exists());
        let settings = match folders.settings.as_deref().map(Settings::read) {
            Some(Ok((settings, unread))) => {
                if !unread.is_empty() {
                    let names = unread.join(", ");
                    notices.warn(format!(
                        "Not understood in the preferences, and left there as it is: {names}. The usual values are used."
                    ));
                }
                settings
            }
            Some(Err(error)) => {
                let path = folders.settings.take().unwrap_or_default();
                let kept = match Settings::set_aside(&path) {
                    Ok(aside) => {
                        folders.settings = Some(path);
                        format!("They are kept as {}.", aside.display())
                    }
                    Err(why) => format!("Those of now are not saved: {}: {why}.", path.display()),
                };
                notices.error(format!("Preferences could not be read, defaults are used: {error}. {kept}"));
                Settings::default()
            }
            None => Settings::default(),
        };
        // Before the ring of the focus, which sees no key that is dropped.
        let chooser = Dialogs::new(chooser, ctx);
        focus::install(ctx);
        ctx.set_zoom_factor(settings.zoom);
        let left = handover.take();
        let inherited_secs = left.as_ref().map(|left| left.at_secs);
        let (rooms, current): (Vec<Box<dyn Room>>, _) = match left {
            Some(left) => {
                let drawn = if left.falls_to_processor {
                    "; the processor draws from now on, until the program starts again"
                } else {
                    ""
                };
                notices.warn(format!(
                    "The graphics device was lost ({}); the window opened again with all that was open{drawn}.",
                    left.why
                ));
                (left.rooms, left.current)
            }
            None => {
                let current = (set != SetPlan::default()).then_some(MUSIC);
                let music = music::MusicRoom::beginning(set, input, trace);
                (vec![Box::new(caricature::CaricatureRoom::waiting(patience)), Box::new(music)], current)
            }
        };
        let mut studio = Self {
            pictures: Pictures::new(screen.device().clone(), folders.pictures.clone()),
            loss: screen.loss(),
            screen,
            handover,
            inherited_secs,
            saved_settings: settings.clone(),
            refused_settings: None,
            settings_written: None,
            settings,
            folders,
            chooser,
            measure,
            first_picture,
            now,
            notices,
            rooms,
            current,
            key_sheet: KeySheet::default(),
            closing: Closing::No,
            first_run,
            fitting: Fitting::default(),
            ends,
        };
        if let Some(ends) = &studio.ends {
            closing::wake_to_end(ctx, ends.clone());
        }
        if inherited_secs.is_some() {
            for index in 0..studio.rooms.len() {
                studio.with_room(ctx, index, |room, shared| room.change_device(shared));
            }
        }
        if !files.is_empty() {
            studio.open_files(ctx, &files);
        }
        studio
    }

    /// Opens files in the room that they are meant for, else in the one on screen.
    fn open_files(&mut self, ctx: &egui::Context, files: &[PathBuf]) {
        let files: Vec<PathBuf> = files.iter().map(|path| from_anywhere(path)).collect();
        let index = self.room_for(&files);
        let at_start = self.current.is_none();
        self.current = Some(index);
        self.with_room(ctx, index, |room, shared| {
            if at_start { room.open_anew(&files, shared) } else { room.open(&files, shared) }
        });
    }

    /// The room that `files` are meant for, else the one on screen.
    fn room_for(&self, files: &[PathBuf]) -> usize {
        let meant = self.rooms.iter().position(|room| files.iter().any(|path| room.claims(path)));
        meant.or(self.current).unwrap_or(0)
    }

    /// While files are held over the window: what dropping them does.
    fn say_what_a_drop_does(&self, ctx: &egui::Context) {
        let held = |input: &egui::InputState| {
            let paths = input.raw.hovered_files.iter().filter_map(|file| file.path.as_deref());
            paths.map(from_anywhere).collect::<Vec<PathBuf>>()
        };
        let files = ctx.input(held);
        if files.is_empty() {
            return;
        }
        let room = self.rooms.get(self.room_for(&files));
        if let Some(does) = room.and_then(|room| room.drop_does(&files, self.current.is_none())) {
            dropping::show(ctx, &does);
        }
    }

    fn with_room<R>(
        &mut self,
        ctx: &egui::Context,
        index: usize,
        act: impl FnOnce(&mut dyn Room, &mut Shared<'_>) -> R,
    ) -> Option<R> {
        let room = self.rooms.get_mut(index)?;
        let mut shared = Shared {
            ctx: ctx.clone(),
            screen: &self.screen,
            notices: &mut self.notices,
            pictures: &mut self.pictures,
            settings: &mut self.settings,
            folders: &self.folders,
            chooser: &mut self.chooser,
            now: self.now,
        };
        Some(act(room.as_mut(), &mut shared))
    }

    fn handle_keys(&mut self, ctx: &egui::Context) {
        if HELP.pressed_anywhere(ctx) {
            self.key_sheet.open = !self.key_sheet.open;
        }
        // A menu in front of the sheet has Escape first.
        if self.key_sheet.open
            && !egui::Popup::is_any_open(ctx)
            && ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Escape))
        {
            self.key_sheet.open = false;
        }
        if SWITCH_ROOM.pressed_anywhere(ctx) && !self.rooms.is_empty() {
            self.current = Some(self.current.map_or(0, |room| (room + 1) % self.rooms.len()));
        }
        self.zoom_by_keys(ctx);
        if FULL_SCREEN.pressed_anywhere(ctx) {
            let full = ctx.input(|input| input.viewport().fullscreen.unwrap_or(false));
            ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!full));
        }
    }

    /// The last frame is on screen now; after an error there may never be a picture.
    fn look_for_picture(&self, ctx: &egui::Context) {
        let Some(first_picture) = &self.first_picture else { return };
        match self.notices.first_error() {
            Some(why) => first_picture.failed(why),
            None if viewport::has_drawn(ctx) => first_picture.seen(Instant::now()),
            None => {}
        }
        if first_picture.outcome().is_some() {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        ctx.request_repaint();
    }

    fn count_frame(&mut self, ctx: &egui::Context) {
        let Some(measure) = &self.measure else { return };
        let room = self.current.and_then(|index| self.rooms.get(index));
        let mut measure = measure.borrow_mut();
        measure.shows(room.and_then(|room| room.stage()));
        measure.records(room.and_then(|room| room.left_out()));
        if measure.frame(Instant::now(), room.and_then(|room| room.sound())) {
            self.rooms.clear();
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
    }

    /// Keeps the preferences where they have changed: at once, but no more than once a second while a fader moves.
    fn save_settings(&mut self, ctx: &egui::Context) {
        const PAUSE: Duration = Duration::from_secs(1);
        if self.settings == self.saved_settings || self.refused_settings.as_ref() == Some(&self.settings) {
            return;
        }
        let gone = self.settings_written.map_or(PAUSE, |saved| saved.elapsed());
        if gone < PAUSE {
            return ctx.request_repaint_after(PAUSE - gone);
        }
        self.write_settings();
    }

    pub(super) fn write_settings(&mut self) {
        if self.settings == self.saved_settings {
            return;
        }
        self.settings_written = Some(Instant::now());
        if let Some(path) = &self.folders.settings {
            match self.settings.save_beside(&self.saved_settings, path) {
                Ok(None) => {}
                Ok(Some(aside)) => self.notices.warn(format!(
                    "{}: preferences could not be read any more; they are kept as {}.",
                    path.display(),
                    aside.display()
                )),
                Err(error) => {
                    self.notices.warn(format!("{}: preferences could not be kept: {error}", path.display()));
                    // With the next change, or in the end, they may.
                    self.refused_settings = Some(self.settings.clone());
                    return;
                }
            }
        }
        (self.saved_settings, self.refused_settings) = (self.settings.clone(), None);
    }
}

impl Program for Studio {
    fn show(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        focus::name_window(&ctx, opening::TITLE);
        if self.hand_over(&ctx) {
            return;
        }
        self.end_if_asked(&ctx);
        self.look_for_picture(&ctx);
        self.handle_keys(&ctx);
        let theme = if self.settings.light { egui::Theme::Light } else { egui::Theme::Dark };
        ctx.set_theme(theme);
        self.suit_the_screen(&ctx);
        self.zoom(&ctx);
        let dropped: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        if !dropped.is_empty() {
            self.open_files(&ctx, &dropped);
        }
        let room = self.current.and_then(|index| self.rooms.get(index));
        let hidden = room.is_some_and(|room| room.hides_the_window());
        if !hidden {
            self.top_bar(ui);
        }
        match self.current {
            Some(index) => {
                self.with_room(&ctx, index, |room, shared| room.show(ui, shared));
            }
            None => self.start_screen(ui),
        }
        // On stage a question would be in the picture: it is asked once the stage is left. One that is asked while the
        // stage is about to begin would vanish under the hand.
        let room = self.current.and_then(|index| self.rooms.get(index));
        let is_staged = room.is_some_and(|room| room.hides_the_window() || room.will_hide_the_window());
        for index in 0..self.rooms.len() {
            let recovers = self.with_room(&ctx, index, |room, shared| {
                room.show_over(shared);
                !is_staged && room.recovers(shared)
            });
            if recovers == Some(true) {
                self.current = Some(index);
            }
        }
        let room = self.current.and_then(|index| self.rooms.get(index));
        let (name, shortcuts) =
            room.map_or(("Start", keys::start::ALL), |room| (room.name(), room.shortcuts()));
        self.key_sheet.show(&ctx, name, shortcuts);
        // On stage they would be in the picture, but answers to a form or a question belong beside it.
        if !hidden || room.is_some_and(|room| room.asks()) || self.is_closing() {
            if let Some(trouble) = self.chooser.trouble() {
                self.notices.error(trouble);
            }
            self.notices.show(&ctx, (self.now)());
        }
        if !hidden {
            self.say_what_a_drop_does(&ctx);
        }
        self.save_settings(&ctx);
        self.count_frame(&ctx);
        self.handle_close(&ctx);
        self.hand_over(&ctx);
        if self.inherited_secs.is_some() {
            // Jobs started in the previous window wake that one when they are done.
            ctx.request_repaint_after(Duration::from_millis(500));
        }
    }

    fn leave(&mut self) {
        self.write_settings();
        self.rooms.iter_mut().for_each(|room| room.leave());
    }
}

impl eframe::App for Studio {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn raw_input_hook(&mut self, _ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        if let (Some(inherited_secs), Some(time)) = (self.inherited_secs, &mut raw_input.time) {
            *time += inherited_secs;
        }
    }

    fn on_exit(&mut self) {
        self.leave();
    }
}

#[cfg(test)]
mod tests {
    use super::handover::Left;
    use super::*;

    #[test]
    fn preferences_that_could_not_be_written_are_written_later() {
        let home = tempfile::tempdir().unwrap();
        let [path, away] = ["settings.toml", "away"].map(|name| home.path().join(name));
        Settings::default().save(&path).unwrap();
        let ctx = egui::Context::default();
        let folders = Folders { settings: Some(path.clone()), ..Folders::default() };
        let opening = Opening { folders, ..Opening::default() };
        let mut studio = Studio::on(&ctx, Screen::processor(&ctx, None), opening);
        // A folder lies there for a while.
        std::fs::rename(&path, &away).unwrap();
        std::fs::create_dir(&path).unwrap();
        studio.settings.light = true;
        studio.write_settings();
        std::fs::remove_dir(&path).unwrap();
        std::fs::rename(&away, &path).unwrap();
        studio.settings.harmonics = 128;
        studio.write_settings();
        let kept = Settings::load(&path).unwrap();
        assert!(kept.light && kept.harmonics == 128);
    }

    #[test]
    fn the_processor_is_said_to_take_over_only_where_it_does() {
        let said = |falls_to_processor: bool| {
            let (ctx, handover) = (egui::Context::default(), Handover::default());
            let (why, at_secs) = ("full".to_owned(), 0.0);
            handover.leave(Left { rooms: Vec::new(), current: None, why, at_secs, falls_to_processor });
            let opening = Opening { handover, ..Opening::default() };
            format!("{:?}", Studio::on(&ctx, Screen::processor(&ctx, None), opening).notices)
        };
        assert!(said(true).contains("(full)") && said(true).contains("the processor draws from now on"));
        // It drew before, too, where the window has no card.
        assert!(said(false).contains("(full)") && !said(false).contains("processor"));
    }
}
