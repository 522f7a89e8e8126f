//! A room of the window, and the parts that rooms share.

use std::path::{Path, PathBuf};

use super::choose::Dialogs;
use super::folders::Folders;
use super::icon::Icon;
use super::measure::OnStage;
use super::notices::Notices;
use super::pictures::Pictures;
use super::screen::Screen;
use super::settings::Settings;
use super::shortcut::Shortcut;

/// One room: the caricature studio or the music gallery.
pub trait Room {
    /// Its name in the switch at the top.
    fn name(&self) -> &'static str;

    /// Its icon in the switch.
    fn icon(&self) -> Icon;

    /// One sentence on the start screen about the purpose of the room.
    fn invitation(&self) -> &'static str;

    /// The keys of this room.
    fn shortcuts(&self) -> &'static [Shortcut];

    /// Draws the room below the top bar and handles its input.
    fn show(&mut self, ui: &mut egui::Ui, shared: &mut Shared<'_>);

    /// Takes files that were dropped on the window or chosen in a dialog.
    fn open(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>);

    /// Takes files that were chosen on the start screen or dropped there, which begin something of their own.
    fn open_anew(&mut self, paths: &[PathBuf], shared: &mut Shared<'_>) {
        self.open(paths, shared);
    }

    /// What taking `paths` does, in words for the hand that holds them over the window; `anew` where they begin something of
    /// their own. `None` where none of them is opened here.
    fn drop_does(&self, paths: &[PathBuf], anew: bool) -> Option<String>;

    /// Extensions of the files that it opens, without dots.
    fn extensions(&self) -> Vec<&'static str>;

    /// Whether a file on the command line is meant for this room rather than for another.
    fn claims(&self, _path: &Path) -> bool {
        false
    }

    /// Does what goes on whichever room is on screen, and draws what must be seen then.
    fn show_over(&mut self, _shared: &mut Shared<'_>) {}

    /// Offers work that a crash left behind, whichever room is on screen; true asks for the room to be shown.
    fn recovers(&mut self, _shared: &mut Shared<'_>) -> bool {
        false
    }

    /// Whether the room wants the whole window for itself now, without the top bar.
    fn hides_the_window(&self) -> bool {
        false
    }

    /// Whether it is going to, untouched, as soon as something is ready.
    fn will_hide_the_window(&self) -> bool {
        false
    }

    /// Whether a form of the room is open, whose answers are to be seen.
    fn asks(&self) -> bool {
        false
    }

    /// Position in the song that is heard, in seconds, and underruns so far; `None` where none is.
    fn sound(&self) -> Option<(f64, u64)> {
        None
    }

    /// Size of the dance; `None` where nothing dances.
    fn stage(&self) -> Option<OnStage> {
        None
    }

    /// Pictures that a recording of the set has left out so far.
    fn left_out(&self) -> Option<u64> {
        None
    }

    /// Something unsaved that closing the window would lose; `None` when all is safe.
    fn unsaved(&self) -> Option<String> {
        None
    }

    /// Name of the work in the background that closing would stop, as in its progress.
    fn being_made(&self) -> Option<&str> {
        None
    }

    /// Saves all that is unsaved, asking for names where there are none; false where something
    /// still is.
    fn save_all(&mut self, _shared: &mut Shared<'_>) -> bool {
        true
    }

    /// Puts its pictures on the device of another window: its own was lost, with all that was on it.
    fn change_device(&mut self, shared: &mut Shared<'_>);

    /// The program must end: keeps unsaved work for the next time, without a question.
    fn interrupt(&mut self, _shared: &mut Shared<'_>) {}

    /// The window closes, and all that matters is saved or given up.
    fn leave(&mut self) {}
}

/// The parts of the window that rooms may use.
pub struct Shared<'a> {
    /// The context, to start jobs and ask for repaints.
    pub ctx: egui::Context,
    /// The device that draws, and how pictures are shown.
    pub screen: &'a Screen,
    /// Messages to the user.
    pub notices: &'a mut Notices,
    /// Small pictures of recent files.
    pub pictures: &'a mut Pictures,
    /// Preferences and recent files.
    pub settings: &'a mut Settings,
    /// Where things are kept.
    pub folders: &'a Folders,
    /// The file dialogs.
    pub chooser: &'a mut Dialogs,
    /// How long work takes is measured by this clock.
    pub now: fn() -> std::time::Instant,
}
