//! A small window that asks for a file, for systems whose own dialog does not come up.
//!
//! It runs as a separate process, as such dialogs do: the caller waits for its answer.

mod browser;

use std::cell::RefCell;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::rc::Rc;
use std::sync::Arc;

use chladni_task::{Needs, other_program};
use chladni_view::Draw;
use egui::text::{CCursor, CCursorRange};
use egui::{Key, RichText, Ui};
use winit::window::Window;

pub use browser::{Purpose, Request};

use super::device;
use super::error::StudioError;
use super::fitting::Fitting;
use super::focus;
use super::folders::Folders;
use super::icon::{self, Icon};
use super::processor_window::{self, Program};
use super::settings::Settings;
use super::theme;
use crate::studio::author_id::AuthorId;
use browser::{Browser, Entry, MAX_ENTRIES, Verdict};

/// The name of the command that opens the window; see `ask`.
pub const COMMAND: &str = "choose-file";

/// The fewest points on which everything has room.
const SMALLEST: [f32; 2] = [460.0, 360.0];

/// Asks in a separate process, whose window is drawn as `draw` says, and waits; empty if the user cancels.
pub fn ask(request: &Request, draw: Draw) -> io::Result<Vec<PathBuf>> {
    let question = serde_json::to_string(request)?;
    let mut command = other_program(std::env::current_exe()?, Needs::Window);
    command.args(["--draw", draw.name(), COMMAND, &question]);
    let asked = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output()?;
    if !asked.status.success() {
        return Err(io::Error::other(format!("the file window ended with {}", asked.status)));
    }
    Ok(serde_json::from_slice(&asked.stdout)?)
}

/// Opens the window, drawn as `draw` says, and returns the answer when it is closed.
pub fn open(request: Request, draw: Draw) -> Result<Vec<PathBuf>, StudioError> {
    let answer = Rc::new(RefCell::new(Vec::new()));
    let given = Rc::clone(&answer);
    let viewport = egui::ViewportBuilder::default()
        .with_title(title(request.purpose))
        .with_app_id("chladni")
        .with_inner_size([640.0, 520.0])
        .with_min_inner_size(SMALLEST);
    // Unreadable preferences are reported in the main window.
    let settings =
        Folders::of_user().settings.and_then(|path| Settings::load(&path).ok()).unwrap_or_default();
    if !draw.means_graphics() {
        let create = |ctx: &egui::Context, _: &Arc<Window>| -> Box<dyn Program> {
            Box::new(FileWindow::new(ctx, request, &settings, given))
        };
        processor_window::open(viewport, create)?;
        return Ok(answer.take());
    }
    device::open("chladni-files", viewport, move |creation| {
        Ok(Box::new(FileWindow::new(&creation.egui_ctx, request, &settings, given)))
    })?;
    Ok(answer.take())
}

fn title(purpose: Purpose) -> &'static str {
    match purpose {
        Purpose::Open => "Open a file",
        Purpose::OpenSeveral => "Open files",
        Purpose::Save => "Save as",
    }
}

/// The window.
pub struct FileWindow {
    title: &'static str,
    browser: Browser,
    /// Folders to jump to, with their icons.
    places: Vec<(Icon, PathBuf)>,
    light: bool,
    /// The zoom of the preferences.
    zoom: f32,
    fitting: Fitting,
    said: Option<String>,
    /// The button says that it replaces a file.
    replaces: bool,
    begun: bool,
    /// A name is proposed, which the first letter that is typed replaces.
    proposes: bool,
    /// The last click in the list opened a folder: a second one, of a double click, was meant for that.
    entered: bool,
    answer: Rc<RefCell<Vec<PathBuf>>>,
}

impl FileWindow {
    /// Asks `request` and puts the choice into `answer`.
    pub fn new(
        ctx: &egui::Context,
        request: Request,
        settings: &Settings,
        answer: Rc<RefCell<Vec<PathBuf>>>,
    ) -> Self {
        focus::install(ctx);
        ctx.set_zoom_factor(settings.zoom);
        let mut places: Vec<(Icon, PathBuf)> = Vec::new();
        let mut add = |mark, folder: &Path| {
            if folder.is_dir() && !places.iter().any(|(_, known)| known == folder) {
                places.push((mark, folder.to_owned()));
            }
        };
        if let Some(user) = directories::UserDirs::new() {
            add(Icon::House, user.home_dir());
        }
        if let Ok(here) = std::env::current_dir() {
            add(Icon::Folder, &here);
        }
        settings.recent.iter().filter_map(|path| path.parent()).for_each(|folder| add(Icon::History, folder));
        let title = title(request.purpose);
        let browser = Browser::new(request);
        let proposes = !browser.typed.is_empty();
        Self {
            title,
            browser,
            places,
            light: settings.light,
            zoom: settings.zoom,
            fitting: Fitting::default(),
            said: None,
            replaces: false,
            begun: false,
            proposes,
            entered: false,
            answer,
        }
    }

    fn go_ahead(&mut self, ctx: &egui::Context) {
        (self.said, self.replaces) = (None, false);
        // Enter takes the focus from the field; give it back so that the user can type on.
        self.begun = false;
        match self.browser.go_ahead() {
            Verdict::Done(files) => {
                self.answer.replace(files);
                ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            }
            Verdict::Entered => {}
            Verdict::Refused(why) => self.said = Some(why),
            Verdict::Replaces(path) => {
                self.replaces = true;
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                self.said = Some(format!("{name} is there already. Go ahead again to replace it."));
            }
        }
    }

    /// The field; true where it was finished with Enter.
    fn head(&mut self, ui: &mut Ui) -> bool {
        let palette = theme::palette(ui);
        ui.add_space(theme::GAP_SMALL);
        ui.horizontal(|ui| {
            let up = ui.button(icon::text(Icon::ArrowUp)).accessible_name("Folder above");
            if up.on_hover_text("The folder around this one").clicked() {
                self.browser.leave();
            }
            ui.add(egui::Label::new(self.browser.folder().display().to_string()).truncate());
        });
        let field = egui::TextEdit::singleline(&mut self.browser.typed)
            .hint_text("A name or a path; Tab completes it")
            .desired_width(f32::INFINITY)
            .lock_focus(true)
            .margin(egui::vec2(8.0, 6.0));
        let mut shown = field.show(ui);
        shown.response.response =
            shown.response.response.accessible_name("File name or path").author_id("path");
        if !std::mem::replace(&mut self.begun, true) {
            shown.response.request_focus();
            if std::mem::take(&mut self.proposes) {
                let end = CCursor::new(self.browser.stem_length());
                shown.state.cursor.set_char_range(Some(CCursorRange::two(CCursor::default(), end)));
                shown.state.clone().store(ui.ctx(), shown.response.id);
            }
        }
        if shown.response.changed() {
            (self.said, self.replaces) = (None, false);
            self.browser.retyped();
        }
        let entered = shown.response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if shown.response.has_focus() && ui.input(|input| input.key_pressed(Key::Tab)) {
            let before = self.browser.typed.clone();
            self.browser.complete();
            if self.browser.typed == before {
                // Nothing more to complete: Tab moves on, as usual.
                shown.response.surrender_focus();
                ui.memory_mut(|memory| memory.move_focus(egui::FocusDirection::Next));
            }
            (self.said, self.replaces) = (None, false);
            let mut state = shown.state;
            let end = CCursor::new(self.browser.typed.chars().count());
            state.cursor.set_char_range(Some(CCursorRange::one(end)));
            state.store(ui.ctx(), shown.response.id);
        }
        match &self.said {
            Some(why) => {
                let why = RichText::new(why).color(palette.warning).small();
                ui.add(egui::Label::new(why).wrap().selectable(true))
            }
            None => {
                // The first kind of files to read has all that the others have; a file to write is of one of them.
                let Request { purpose, kinds, .. } = self.browser.request();
                let shown = if *purpose == Purpose::Save { kinds.len() } else { 1 };
                let kinds: Vec<&str> = kinds.iter().take(shown).map(|(name, _)| name.as_str()).collect();
                ui.label(RichText::new(kinds.join(" · ")).color(palette.weak).small())
            }
        };
        entered
    }

    fn places(&mut self, ui: &mut Ui) {
        let mut enter = None;
        for (mark, folder) in &self.places {
            let name = folder.file_name().map_or_else(|| "/".into(), |name| name.to_string_lossy());
            let here = folder == self.browser.folder();
            let line = egui::Button::selectable(here, icon::label(*mark, &name)).truncate();
            if ui.add(line).on_hover_text(folder.display().to_string()).clicked() {
                enter = Some(folder.clone());
            }
        }
        if let Some(folder) = enter {
            self.browser.enter(&folder);
        }
    }

    /// The list; true where a file was double-clicked.
    fn list(&mut self, ui: &mut Ui) -> bool {
        let palette = theme::palette(ui);
        let listing = match self.browser.listing() {
            Ok(listing) => listing,
            Err(why) => {
                ui.label(RichText::new(why).color(palette.error));
                return false;
            }
        };
        if listing.entries.is_empty() {
            ui.label(RichText::new("Nothing of this kind is here.").color(palette.weak));
        }
        if listing.is_cut {
            let most = format!("There are more than these {MAX_ENTRIES}; type the name of any other.");
            ui.label(RichText::new(most).color(palette.warning).small());
        }
        let row = ui.text_style_height(&egui::TextStyle::Button) + 2.0 * ui.spacing().button_padding.y;
        let row = row.max(ui.spacing().interact_size.y);
        let (mut enter, mut pick, mut go) = (None, None, false);
        let lines = egui::ScrollArea::vertical().auto_shrink(false);
        // The layout around the list: inside, ids would change with the first row in sight, and the focus be lost.
        ui.with_layout(egui::Layout::top_down_justified(egui::Align::LEFT), |ui| {
            lines.show_rows(ui, row, listing.entries.len(), |ui, rows| {
                for Entry { name, is_folder } in listing.entries.get(rows).unwrap_or_default() {
                    let mark = if *is_folder { Icon::Folder } else { Icon::File };
                    let chosen = self.browser.is_chosen(name);
                    let line = egui::Button::selectable(chosen, icon::label(mark, name)).truncate();
                    let line = ui.add(line.min_size(egui::vec2(0.0, row)));
                    let twice = line.double_clicked();
                    if !line.clicked() || twice && self.entered {
                        continue;
                    }
                    let chosen = if *is_folder { &mut enter } else { &mut pick };
                    *chosen = Some(name.clone());
                    go |= !is_folder && twice;
                }
            });
        });
        if let Some(name) = enter {
            let folder = self.browser.folder().join(name);
            self.browser.enter(&folder);
            self.entered = true;
        }
        if let Some(name) = pick {
            self.entered = false;
            (self.said, self.replaces) = (None, false);
            self.browser.pick(&name, ui.input(|input| input.modifiers.command));
        }
        go
    }

    fn foot(&mut self, ui: &mut Ui) -> bool {
        let mut go = false;
        ui.add_space(theme::GAP_SMALL);
        ui.horizontal(|ui| {
            let why = "Chladni's own file window: this system offers none.";
            ui.label(RichText::new(why).color(theme::palette(ui).weak).small()).on_hover_text(
                "On Linux the system's dialog comes from xdg-desktop-portal or zenity; neither answered.",
            );
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let label = match (self.browser.request().purpose, self.replaces) {
                    (Purpose::Save, true) => "Replace",
                    (Purpose::Save, false) => "Save",
                    _ => "Open",
                };
                go = theme::primary_button(ui, label).clicked();
                if ui.button("Cancel").author_id("cancel").on_hover_text("Escape").clicked() {
                    ui.ctx().send_viewport_cmd(egui::ViewportCommand::Close);
                }
            });
        });
        ui.add_space(theme::GAP_SMALL);
        go
    }
}

impl eframe::App for FileWindow {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }
}

impl Program for FileWindow {
    fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        focus::name_window(&ctx, self.title);
        ctx.set_theme(if self.light { egui::Theme::Light } else { egui::Theme::Dark });
        self.fitting.zoom(&ctx, self.zoom, SMALLEST);
        if ctx.input(|input| input.key_pressed(Key::Escape)) {
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        // A button that has the focus takes Enter for itself.
        let nothing_has_focus = ctx.memory(|memory| memory.focused().is_none());
        let mut go = nothing_has_focus && ctx.input(|input| input.key_pressed(Key::Enter));
        egui::Panel::top("path").resizable(false).show(ui, |ui| go |= self.head(ui));
        egui::Panel::bottom("answer").resizable(false).show(ui, |ui| go |= self.foot(ui));
        egui::Panel::left("places").resizable(false).exact_size(150.0).show(ui, |ui| {
            egui::ScrollArea::vertical().show(ui, |ui| self.places(ui));
        });
        egui::CentralPanel::default().show(ui, |ui| {
            go |= self.list(ui);
        });
        if go {
            self.go_ahead(&ctx);
        }
    }
}
