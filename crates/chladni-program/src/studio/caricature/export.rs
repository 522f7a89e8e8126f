//! The export window: what to write, how large, and where.

use std::path::{Path, PathBuf};

use chladni_caricature::{LayerState, Template};
use chladni_mesh::Format;
use chladni_view::{Background, FilmFormat, FilmSettings, FrameRate, ffmpeg_is_there};
use egui::{RichText, Ui};

use super::CaricatureRoom;
use super::center::update_stage;
use super::overlay::backdrop;
use super::session::Session;
use crate::studio::author_id::AuthorId;
use crate::studio::choose::ask_where_to_save;
use crate::studio::job::{self, Job};
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::outputs::{check_apart, check_size, check_textures, odd_sides};
use crate::work::{Error, Warning, write_file};

/// The most frames a second that are offered.
const MOST_FPS: u32 = 60;

/// The note while layers wait for matches.
const STILL_WORKING: &str =
    "Layers are still being matched, or harmonics solved for: export again once that is done.";

/// While it is not known how far layers are held back.
const STILL_SETTLING: &str = "How far triangles allow is still being computed: what is written is held back by what is \
                              known so far. Export again once the meter shows a share.";

/// A file that was written, and a warning about it.
type Written = (PathBuf, Option<Warning>);

/// The kind of file to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Mesh(Format),
    Picture,
    Drawing,
    Mp4,
    Gif,
}

impl What {
    /// By rows: name of the row, and its choices.
    const ROWS: [(&'static str, &'static [Self]); 3] = [
        (
            "Shape",
            &[
                Self::Mesh(Format::Glb),
                Self::Mesh(Format::Obj),
                Self::Mesh(Format::Ply),
                Self::Mesh(Format::Stl),
            ],
        ),
        ("Picture", &[Self::Picture, Self::Drawing]),
        ("Turntable", &[Self::Mp4, Self::Gif]),
    ];

    fn extension(self) -> &'static str {
        match self {
            Self::Mesh(Format::Glb) => "glb",
            Self::Mesh(Format::Obj) => "obj",
            Self::Mesh(Format::Stl) => "stl",
            Self::Mesh(_) => "ply",
            Self::Picture => "png",
            Self::Drawing => "svg",
            Self::Mp4 => "mp4",
            Self::Gif => "gif",
        }
    }

    /// Extensions of the names under which it may be written: the name of a mesh or a film says what is in it.
    fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Mesh(_) => &["glb", "obj", "ply", "stl"],
            Self::Picture => &["png"],
            Self::Drawing => &["svg"],
            Self::Mp4 | Self::Gif => &["mp4", "gif", "png", "apng"],
        }
    }

    fn explanation(self) -> &'static str {
        match self {
            Self::Mesh(Format::Glb) => {
                "The original with one slider (morph target) per layer, named like it. Opens in Blender; all \
                 sliders at 1 are the caricature. Rigs, sliders and animations of a GLB stay in it. It keeps the \
                 file's axes; viewers take y for up."
            }
            Self::Mesh(Format::Obj) => {
                "The caricature, in the file's own vertex order, with UVs and materials."
            }
            Self::Mesh(Format::Stl) => "The caricature for printing: triangles only, rounded to 32 bits.",
            Self::Mesh(_) => "The caricature with every digit of its coordinates, and vertex colors.",
            Self::Picture => "What the view shows, at any size.",
            Self::Drawing => "What the view shows as a drawing in ink: outlines that print at any size.",
            Self::Mp4 => "What the view shows, turning once around: an H.264 film.",
            Self::Gif => "What the view shows, turning once around: a film that loops anywhere.",
        }
    }
}

/// The background of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Behind {
    Nothing,
    Window,
    Preset(usize),
}

/// The choices, kept while the window is open.
#[derive(Debug)]
pub struct Export {
    open: bool,
    what: What,
    size: [u32; 2],
    behind: Behind,
    secs: f64,
    fps: u32,
    ffmpeg: Option<bool>,
    running: Option<Job<Written>>,
}

impl Default for Export {
    fn default() -> Self {
        Self {
            open: false,
            what: What::Mesh(Format::Glb),
            size: [1920, 1080],
            behind: Behind::Nothing,
            secs: 6.0,
            fps: 30,
            ffmpeg: None,
            running: None,
        }
    }
}

impl CaricatureRoom {
    /// Opens the export window.
    pub(super) fn export(&mut self) {
        self.export.open = self.session.is_some();
    }

    /// Draws the export window.
    pub(super) fn show_export(&mut self, ui: &Ui, shared: &mut Shared<'_>) {
        if !self.export.open {
            return;
        }
        let ink = self.look.ink;
        let (begin, dismissed) = theme::modal(ui.ctx(), "Export", 470.0, |ui| self.export.choices(ui, ink));
        if begin {
            self.begin_export(ui, shared);
        } else if dismissed {
            self.export.open = false;
        }
    }

    fn begin_export(&mut self, ui: &Ui, shared: &mut Shared<'_>) {
        let (Some(session), Some(stage)) = (&mut self.session, &mut self.stage) else { return };
        if session.is_working() {
            return shared.notices.warn(STILL_WORKING);
        }
        let Export { what, size: [width, height], secs, .. } = self.export;
        if !matches!(what, What::Mesh(_))
            && let Err(why) = check_size(width, height)
        {
            return shared.notices.failed(why);
        }
        let extension = what.extension();
        let suggested = session.beside_named("caricature", extension);
        let (kind, endings) = (extension.to_uppercase(), what.endings());
        let asked = ask_where_to_save(shared.chooser, &[(&kind, &[extension])], endings, &suggested);
        let Some(path) = asked else { return };
        if let Err(why) = check_apart(&path, &session.project().files()) {
            return shared.notices.failed(why);
        }
        // What is written is the document as it is now.
        let newest = session
            .catch_up(&shared.ctx)
            .and_then(|()| update_stage(session, stage, &mut self.heat, self.look, &mut self.stale));
        if let Err(why) = newest {
            return shared.notices.failed(why);
        }
        if session.is_settling() {
            shared.notices.warn(STILL_SETTLING);
        }
        for layer in &session.shown.evaluation.layers {
            if let LayerState::Failed(why) = &layer.state {
                shared.notices.warn(format!("Written without the layer {}: {why}.", layer.name));
            }
        }
        let label = format!("Writing {}", path.file_name().unwrap_or_default().to_string_lossy());
        let shot = stage.shot(self.look, self.export.background(ui));
        let spares_textures = sparing_textures(session);
        let job = match (what, shot) {
            (What::Mesh(_), _) => {
                let sculpture = session.sculpture();
                Job::start(label, &shared.ctx, move |task| {
                    sculpture.save(&path, task).map(|warning| (path, warning))
                })
            }
            (_, Err(error)) => return shared.notices.failed(error),
            (What::Picture | What::Drawing, Ok(shot)) => Job::start(label, &shared.ctx, move |task| {
                spares_textures(&path)?;
                let bytes = match what {
                    What::Drawing => shot.drawing(width, height).map(|drawing| drawing.to_svg().into_bytes()),
                    _ => shot.picture(width, height).and_then(|picture| Ok(picture.to_png()?)),
                };
                let bytes = bytes.map_err(|error| error.of(path.display()))?;
                task.check()?;
                write_file(&path, &bytes)?;
                Ok((path, None))
            }),
            (What::Mp4 | What::Gif, Ok(shot)) => {
                let warning = odd_sides(&path, [width, height]);
                let rate = FrameRate::per_second(self.export.fps());
                let settings =
                    FilmSettings { width, height, rate, frames: rate.frames_in(secs), first: 0, audio: None };
                Job::start(label, &shared.ctx, move |task| {
                    spares_textures(&path)?;
                    let made = shot.turntable(&path, settings, task);
                    made.map_err(|error| Error::from(error).of(path.display()))?;
                    Ok((path, warning))
                })
            }
        };
        self.export.running = Some(job);
        self.export.open = false;
    }
}

impl Export {
    /// Shows progress while something is written; draws nothing otherwise.
    pub fn progress(&self, ui: &mut Ui) {
        if let Some(running) = &self.running {
            egui::Panel::bottom("export progress").resizable(false).show(ui, |ui| {
                ui.add_space(theme::GAP_SMALL);
                job::show_progress(ui, running);
                ui.add_space(theme::GAP_SMALL);
            });
        }
    }

    /// The export in progress.
    pub fn unfinished(&self) -> Option<&str> {
        self.running.as_ref().map(Job::label)
    }

    /// Cancels the export in progress, so that nothing half written stays: the window closes.
    pub fn stop(&mut self) {
        if let Some(running) = self.running.take() {
            running.stop();
        }
    }

    /// Takes in the finished export.
    pub fn poll(&mut self, shared: &mut Shared<'_>) {
        match self.running.as_ref().and_then(Job::ended) {
            Some(Ok((path, warning))) => {
                shared.notices.done(format!("Exported {}", path.display()));
                warning.into_iter().for_each(|warning| shared.notices.warn(warning));
            }
            Some(Err(why)) => shared.notices.failed(why),
            None => return,
        }
        self.running = None;
    }

    fn background(&self, ui: &Ui) -> Background {
        match self.behind {
            // Films have no transparency.
            Behind::Nothing if self.what == What::Picture => Background::TRANSPARENT,
            Behind::Nothing | Behind::Window => backdrop(ui),
            Behind::Preset(index) => {
                Background::PRESETS.get(index).map_or(Background::PAPER, |preset| preset.1)
            }
        }
    }

    /// Draws the choices for a shape that is shown in `ink` or not; true when the person goes ahead.
    fn choices(&mut self, ui: &mut Ui, ink: bool) -> bool {
        let weak = theme::palette(ui).weak;
        let ffmpeg = *self.ffmpeg.get_or_insert_with(ffmpeg_is_there);
        egui::Grid::new("export").num_columns(2).spacing([theme::GAP_LARGE, theme::GAP]).show(ui, |ui| {
            for (row, offers) in What::ROWS {
                ui.label(RichText::new(row).color(weak));
                ui.horizontal(|ui| {
                    for what in offers {
                        let possible = *what != What::Mp4 || ffmpeg;
                        let button =
                            egui::Button::selectable(self.what == *what, what.extension().to_uppercase());
                        let response = ui.add_enabled(possible, button);
                        let response = response.on_disabled_hover_text("Needs the program ffmpeg");
                        let response = response.author_id(format!("export/{}", what.extension()));
                        if response.on_hover_text(what.explanation()).clicked() {
                            self.what = *what;
                        }
                    }
                });
                ui.end_row();
            }
            if !matches!(self.what, What::Mesh(_)) {
                self.picture_choices(ui, weak, ink);
            }
        });
        ui.add_space(theme::GAP);
        ui.add(egui::Label::new(RichText::new(self.what.explanation()).color(weak)).wrap());
        ui.add_space(theme::GAP_LARGE);
        let mut begin = false;
        ui.horizontal(|ui| {
            let busy = self.running.is_some();
            ui.add_enabled_ui(!busy, |ui| {
                begin = theme::primary_button(ui, "Export…").author_id("export-begin").clicked();
            });
            if ui.button("Cancel").clicked() {
                self.open = false;
            }
            if busy {
                ui.label(RichText::new("Another export is still running.").color(weak));
            }
        });
        begin
    }

    fn picture_choices(&mut self, ui: &mut Ui, weak: egui::Color32, ink: bool) {
        ui.label(RichText::new("Size").color(weak));
        ui.horizontal(|ui| {
            let [width, height] = &mut self.size;
            let tip = "Pixels: width × height";
            ui.add(theme::number(width).range(16..=16_384)).accessible_name("Width").on_hover_text(tip);
            ui.label("×");
            ui.add(theme::number(height).range(16..=16_384)).accessible_name("Height").on_hover_text(tip);
            let usual = ui.menu_button("Usual sizes", |ui| {
                let sizes = [
                    ("HD", [1920, 1080]),
                    ("4K", [3840, 2160]),
                    ("Square", [1080, 1080]),
                    ("Small", [640, 480]),
                ];
                for (name, size) in sizes {
                    let [width, height] = size;
                    let button = ui.button(format!("{name}   {width} × {height}"));
                    if button.author_id(format!("size/{width}x{height}")).clicked() {
                        self.size = size;
                        ui.close();
                    }
                }
            });
            usual.response.author_id("sizes");
        });
        ui.end_row();
        // Ink is drawn on paper.
        if self.what != What::Drawing && !ink {
            self.background_choice(ui, weak);
        }
        if matches!(self.what, What::Mp4 | What::Gif) {
            self.length_choice(ui, weak);
        }
    }

    fn background_choice(&mut self, ui: &mut Ui, weak: egui::Color32) {
        ui.label(RichText::new("Background").color(weak));
        ui.horizontal_wrapped(|ui| {
            let picture = self.what == What::Picture;
            if picture {
                ui.selectable_value(&mut self.behind, Behind::Nothing, "None")
                    .on_hover_text("A transparent picture");
            } else if self.behind == Behind::Nothing {
                self.behind = Behind::Window;
            }
            ui.selectable_value(&mut self.behind, Behind::Window, "As here");
            for (index, (name, background)) in Background::PRESETS.iter().enumerate() {
                if background.opacity > 0.0 {
                    ui.selectable_value(&mut self.behind, Behind::Preset(index), theme::capitalized(name));
                }
            }
        });
        ui.end_row();
    }

    /// Frames a second; another kind of film keeps the choice.
    fn fps(&self) -> u32 {
        self.fps.min(self.most_fps())
    }

    fn most_fps(&self) -> u32 {
        if self.what == What::Gif { FilmFormat::GIF_MOST_FPS } else { MOST_FPS }
    }

    fn length_choice(&mut self, ui: &mut Ui, weak: egui::Color32) {
        ui.label(RichText::new("Length").color(weak));
        ui.horizontal(|ui| {
            let length = theme::number_in(&mut self.secs, " s").range(0.5..=120.0).speed(0.1);
            ui.add(length).accessible_name("Length").author_id("length");
            ui.label("at");
            let mut fps = self.fps();
            let field = theme::number_in(&mut fps, " frames/s").range(1..=self.most_fps());
            if ui.add(field).accessible_name("Frames a second").author_id("fps").changed() {
                self.fps = fps;
            }
        });
        ui.end_row();
    }
}

/// Checks, beside the window, that a picture replaces no texture of the meshes that `session` reads.
fn sparing_textures(session: &Session) -> impl Fn(&Path) -> Result<(), Error> + Send + use<> {
    let project = session.project();
    let (shape, subject) = (project.shape.clone(), session.subject.clone());
    let templates: Vec<Template> = project.layers().iter().map(|(_, layer)| layer.template.clone()).collect();
    move |path| check_textures(&[path], (&shape, subject.whole()), templates.iter())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gif_is_offered_no_more_frames_than_it_can_show() {
        let ctx = egui::Context::default();
        theme::install(&ctx);
        let mut export = Export { fps: MOST_FPS, ffmpeg: Some(true), ..Export::default() };
        for (what, fps) in [(What::Mp4, MOST_FPS), (What::Gif, FilmFormat::GIF_MOST_FPS)] {
            export.what = what;
            let _ = ctx.run_ui(egui::RawInput::default(), |ui| {
                export.choices(ui, false);
            });
            assert_eq!((export.fps(), export.fps), (fps, MOST_FPS));
        }
    }
}
