//! Films of the dance: the form that asks for subject, size and rate; they are made in the background.

mod as_it_is;

use std::path::{Path, PathBuf};

use chladni_music::{BeatReading, Show};
use chladni_view::{Draw, FrameRate, Look, ffmpeg_is_there};
use egui::{RichText, Ui};

pub use self::as_it_is::OnStage;
use self::as_it_is::as_it_is;
use super::view::View;
use super::wish::Then;
use crate::studio::author_id::AuthorId;
use crate::studio::file_window::Request;
use crate::studio::job::{self, Job};
use crate::studio::keys::filming::LEAVE;
use crate::studio::room::Shared;
use crate::studio::theme;
use crate::work::film::{self, Film, Output};
use crate::work::{Aside, Error, Warning};

/// Tooltip in the menu.
pub const TIP: &str = "With its sound, in any size: what dances now for a whole song, or all that was done";

/// Sizes that are offered, in pixels.
const SIZES: [(&str, [u32; 2]); 6] = [
    ("720p", [1280, 720]),
    ("1080p", [1920, 1080]),
    ("4K", [3840, 2160]),
    ("Square", [1080, 1080]),
    ("Upright", [1080, 1920]),
    ("Small", [640, 360]),
];
/// Rates that are a click away, in frames a second.
const RATES: [u32; 6] = [12, 24, 25, 30, 50, 60];
/// The longest side of a film, in pixels.
const LONGEST_SIDE: u32 = 8192;

/// The form that asks, and the film that is being made.
#[derive(Default)]
pub struct Filming {
    form: Option<Form>,
    /// The form as it was left, with which the next one begins.
    last: Option<Form>,
    running: Option<Job<Made>>,
    /// The folder of a film in pictures.
    folder: Option<PathBuf>,
}

/// A film, and its warnings.
struct Made {
    path: PathBuf,
    warnings: Vec<Warning>,
}

/// The content of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    /// The current dance, for a whole song.
    AsItIs,
    /// All actions since the show began.
    TheShow,
}

#[derive(Clone, Debug)]
struct Form {
    what: What,
    size: [u32; 2],
    /// Frames a second.
    fps: f64,
    /// Range of the song or the show; to the end where `to_secs` is 0.
    from_secs: f64,
    to_secs: f64,
    /// By its name; none is the look of the dance itself.
    look: Option<&'static str>,
    titles: bool,
    /// Whether there can be an MP4.
    has_ffmpeg: bool,
    /// Number and name of the song that was heard when the form was opened. Where there was none, it is the one that is
    /// heard when the film begins.
    song: Option<(usize, String)>,
}

/// The contents that could be filmed now, and how.
pub struct Scene {
    /// All that was done, as it would be saved.
    pub show: Show,
    /// The shape or caricature, as `dance` calls it.
    pub body: String,
    /// The show's songs, as `dance` calls them, by number.
    pub songs: Vec<(String, BeatReading)>,
    /// The number of the one that is heard; none of live input.
    pub song: Option<usize>,
    /// The content of the middle of the room.
    pub view: View,
    /// What is on stage.
    pub on_stage: Option<OnStage>,
    /// How many favorites there are.
    pub favorites: usize,
    /// The choice of the device that draws.
    pub draw: Draw,
}

impl Scene {
    /// Whether nothing but the gallery dances now.
    fn is_gallery(&self) -> bool {
        !matches!(self.view, View::CloseUp(_)) && self.on_stage.is_none() && self.favorites == 0
    }
}

impl Filming {
    /// Opens the form as it was left, where this `song` is heard (its number in the show and its name), and `titles` of
    /// songs are shown on stage or not.
    pub fn ask(&mut self, song: Option<(usize, String)>, titles: bool) -> Result<(), Error> {
        if self.running.is_some() {
            return Err(Error::input("A film is being made already."));
        }
        let form = self.form.get_or_insert_with(|| Form {
            titles,
            has_ffmpeg: ffmpeg_is_there(),
            ..self.last.take().unwrap_or(Form::FIRST)
        });
        form.song = song;
        Ok(())
    }

    /// Another show numbers other songs: the form takes the one that is heard when its film begins.
    pub fn forget_song(&mut self) {
        self.form.iter_mut().for_each(|form| form.song = None);
    }

    /// Closes the form, and keeps it for the next film.
    fn close(&mut self) {
        self.last = self.form.take();
    }

    /// Draws the form; once the person wants the film, says as what.
    pub fn show_form(&mut self, ctx: &egui::Context, window: [u32; 2], show_secs: f64) -> Option<Then> {
        let form = self.form.as_mut()?;
        let (mut wanted, mut open) = (None, true);
        // Escape first ends an open list, a number being typed, or a question in front.
        let leaves = LEAVE.pressed(ctx);
        // Above older messages, below those that it causes itself.
        let dialog =
            egui::Window::new("Film").order(egui::Order::Foreground).collapsible(false).resizable(false);
        dialog.anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO).open(&mut open).show(ctx, |ui| {
            form.show(ui, window, show_secs);
            ui.add_space(theme::GAP);
            wanted = form.choose_kind(ui);
        });
        if leaves || !open {
            self.close();
            return None;
        }
        wanted
    }

    /// Whether the form is open: it has the keys.
    pub fn asks(&self) -> bool {
        self.form.is_some()
    }

    /// Where a film in one file can go to, to be asked.
    pub fn where_to(&self) -> Request {
        let kinds: [(&str, &[&str]); 3] = [
            ("MP4 with sound", &["mp4"]),
            ("GIF", &["gif"]),
            ("GLB with morph targets, for Blender", &["glb"]),
        ];
        let has_ffmpeg = self.form.as_ref().is_some_and(|form| form.has_ffmpeg);
        let (kinds, name) = if has_ffmpeg { (&kinds[..], "dance.mp4") } else { (&kinds[1..], "dance.gif") };
        Request::save(kinds, Path::new(name))
    }

    /// Begins the film of the form, to a file or into a folder.
    pub fn begin(
        &mut self,
        scene: Scene,
        path: &Path,
        is_folder: bool,
        ctx: &egui::Context,
    ) -> Result<(), Error> {
        let form = self.form.clone();
        let form = form.ok_or_else(|| Error::input("No film is made: its form was closed meanwhile."))?;
        let path = path.to_owned();
        let output = if is_folder { into_folder(path.clone())? } else { Output::to(path.clone()) };
        let film = form.film(scene, output)?;
        // The form stays where it has to be corrected.
        film.check()?;
        self.close();
        self.folder = is_folder.then(|| path.clone());
        let label = format!("Filming {}", path.file_name().unwrap_or_default().to_string_lossy());
        self.running = Some(Job::start(label, ctx, move |task| {
            let aside = Aside::new(task);
            film::make(film, &aside)?;
            Ok(Made { path, warnings: aside.warnings() })
        }));
        Ok(())
    }

    /// Reports the result.
    pub fn poll(&mut self, shared: &mut Shared<'_>) {
        match self.running.as_ref().and_then(Job::ended) {
            None => return,
            Some(Ok(made)) => {
                made.warnings.into_iter().for_each(|warning| shared.notices.warn(warning));
                shared.notices.done(format!("Filmed {}", made.path.display()));
            }
            Some(Err(why)) => {
                match self.folder.as_ref().filter(|folder| why.is_cancelled() && folder.is_dir()) {
                    Some(folder) => {
                        let folder = folder.display();
                        shared.notices.done(format!("Cancelled; frames that were finished stay in {folder}"));
                    }
                    None => shared.notices.failed(why),
                }
            }
        }
        self.running = None;
    }

    /// The film being made.
    pub fn unfinished(&self) -> Option<&str> {
        self.running.as_ref().map(Job::label)
    }

    /// Cancels the film being made, so that nothing half written stays, except finished frames in a folder: the window
    /// closes.
    pub fn stop(&mut self) {
        if let Some(running) = self.running.take() {
            running.stop();
        }
    }

    /// Shows progress while a film is being made; draws nothing otherwise.
    pub fn show(&self, ui: &mut Ui) {
        if let Some(running) = &self.running {
            egui::Panel::bottom("filming").resizable(false).show(ui, |ui| job::show_progress(ui, running));
        }
    }
}

impl Form {
    const FIRST: Self = Self {
        what: What::AsItIs,
        size: SIZES[0].1,
        fps: 30.0,
        from_secs: 0.0,
        to_secs: 0.0,
        look: None,
        titles: true,
        has_ffmpeg: true,
        song: None,
    };

    fn show(&mut self, ui: &mut Ui, window: [u32; 2], show_secs: f64) {
        ui.label(RichText::new("What").strong());
        let all = format!("All that was done so far ({show_secs:.0} s)");
        for (what, name, tip) in [
            (
                What::AsItIs,
                "What dances now",
                "This song from its beginning, with the dance of a close-up, else what is on stage, else the favorites in \
                 turn, else the gallery",
            ),
            (What::TheShow, all.as_str(), "With every song, pause and leap, as it was seen"),
        ] {
            if ui.selectable_label(self.what == what, name).on_hover_text(tip).clicked() {
                self.what = what;
            }
        }
        if let Some((_, name)) = self.song.as_ref().filter(|_| self.what == What::AsItIs) {
            theme::weak(ui, format!("Song: {name}"));
        }
        ui.label(RichText::new("Size").strong());
        theme::group(ui, "Size", |ui| {
            ui.horizontal_wrapped(|ui| {
                for (name, size) in SIZES.into_iter().chain([("As here", window)]) {
                    let [width, height] = size;
                    let button = ui.selectable_label(self.size == size, name);
                    if button.author_id(format!("size/{width}x{height}")).clicked() {
                        self.size = size;
                    }
                }
            });
            ui.horizontal(|ui| {
                for (side, name) in self.size.iter_mut().zip(["Width", "Height"]) {
                    let label = ui.label(name);
                    ui.add(theme::number(side).range(16..=LONGEST_SIDE)).labelled_by(label.id);
                }
            });
        });
        ui.label(RichText::new("Look").strong());
        theme::group(ui, "Look", |ui| self.choose_look(ui));
        ui.label(RichText::new("Frames a second").strong());
        theme::group(ui, "Frames a second", |ui| {
            ui.horizontal(|ui| {
                for fps in RATES {
                    let button = ui.selectable_value(&mut self.fps, f64::from(fps), fps.to_string());
                    button.author_id(format!("fps/{fps}"));
                }
                let label = ui.label("Rate");
                let number = theme::number(&mut self.fps).range(FrameRate::WANTED_PER_SECOND);
                ui.add(number.max_decimals(3)).labelled_by(label.id).author_id("fps");
            });
        });
        ui.label(RichText::new("Range").strong());
        theme::group(ui, "Range", |ui| {
            ui.horizontal(|ui| {
                let from = ui.label("From");
                let number = theme::number_in(&mut self.from_secs, " s").range(0.0..=86_400.0);
                ui.add(number).labelled_by(from.id);
                let mut whole = self.to_secs <= 0.0;
                let to = ui.label("to");
                let least = self.from_secs + 0.1;
                if !whole {
                    let number = theme::number_in(&mut self.to_secs, " s").range(least..=86_400.0);
                    ui.add(number).labelled_by(to.id);
                }
                if theme::checkbox(ui, &mut whole, "the end").changed() {
                    self.to_secs = if whole { 0.0 } else { least + 10.0 };
                }
            });
        });
    }

    /// The buttons that begin; as what the film is wanted, once it is.
    fn choose_kind(&self, ui: &mut Ui) -> Option<Then> {
        if !self.has_ffmpeg {
            let why = "There is no ffmpeg here, so no MP4: PNG frames and WAV have the sound without it.";
            theme::weak(ui, why);
        }
        let mut wanted = None;
        ui.horizontal(|ui| {
            let folder = "Name a new folder for them, and begin";
            for (name, id, tip, then) in [
                ("Film to …", "film-begin", "Choose where it goes, and begin", Then::Film),
                ("PNG frames and WAV to …", "film-frames", folder, Then::Frames),
            ] {
                if ui.button(name).author_id(id).on_hover_text(tip).clicked() {
                    wanted = Some(then);
                }
            }
        });
        wanted
    }

    fn choose_look(&mut self, ui: &mut Ui) {
        let own = "As it was seen";
        let shown = self.look.map_or_else(|| own.to_owned(), theme::capitalized);
        let list = egui::ComboBox::from_id_salt("film look").width(160.0).height(480.0).selected_text(shown);
        let response = list.show_ui(ui, |ui| {
            ui.selectable_value(&mut self.look, None, own);
            for (name, _) in Look::PRESETS {
                ui.selectable_value(&mut self.look, Some(name), theme::capitalized(name));
            }
        });
        response.response.on_hover_text("The whole scene of the film");
        let tip = "Each song is named for a few seconds when it begins";
        theme::checkbox(ui, &mut self.titles, "Titles of songs").on_hover_text(tip);
    }

    fn film(&self, scene: Scene, to: Output) -> Result<Film, Error> {
        let [width, height] = self.size;
        let rate = FrameRate::decimal(self.fps);
        let output = Output { width, height, rate, titles: self.titles, draw: scene.draw, ..to };
        let mut film = match self.what {
            What::TheShow => Film::of_show(scene.show, scene.body, scene.songs, output),
            What::AsItIs => {
                let number = self.song.as_ref().map(|(number, _)| *number).or(scene.song);
                let song = number.and_then(|number| scene.songs.get(number).cloned());
                let song = song.ok_or_else(|| Error::input("Live input cannot be filmed: choose a song."))?;
                if output.animation.is_some() && scene.is_gallery() {
                    let why = "A GLB holds one dance: put one on stage, or make it a favorite.";
                    return Err(Error::input(why));
                }
                let show = as_it_is(scene.show, scene.view, scene.on_stage.as_ref(), scene.favorites);
                Film::of_show(show, scene.body, vec![song], output)
            }
        };
        film.beginning.keeps_look = self.look.is_some();
        if let Some(look) = self.look.and_then(Look::named) {
            film.look = look.in_place_of(&film.look);
        }
        let duration_secs = (self.to_secs > 0.0).then_some(self.to_secs - self.from_secs);
        Ok(Film { start_secs: self.from_secs, duration_secs, ..film })
    }
}

/// Frames and sound go into a folder that holds nothing: its dialog does not ask before files are replaced.
fn into_folder(folder: PathBuf) -> Result<Output, Error> {
    if folder.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        let folder = folder.display();
        return Err(Error::Input(format!("{folder}: holds files already; name a new folder for the frames")));
    }
    Ok(Output::frames(folder))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::OWN_COLORS;
    use chladni_music::{GalleryShape, Instrument, Looks};

    #[test]
    fn a_film_looks_as_it_was_seen_unless_a_look_is_chosen() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let film = |palette: &str, form: Form| {
            let instrument = Instrument::new(1, 6, shape.clone()).unwrap();
            let looks = Some(Looks { look: "ember".into(), palette: palette.to_owned(), ..Looks::default() });
            let scene = Scene {
                show: Show { looks, ..Show::of(&instrument) },
                body: "sample:ring".into(),
                songs: vec![("sample:tune".into(), BeatReading::default())],
                song: Some(0),
                view: View::Gallery,
                on_stage: None,
                favorites: 0,
                draw: Draw::Cpu,
            };
            form.film(scene, Output::to("film.gif".into())).unwrap()
        };
        let as_seen = film("", Form::FIRST);
        assert_eq!(as_seen.look, Look::EMBER);
        assert!(as_seen.output.titles, "as on stage");
        assert_eq!(as_seen.output.draw, Draw::Cpu, "by what draws the window");
        for (name, look) in Look::PRESETS {
            let chosen = Form { look: Some(name), titles: false, ..Form::FIRST };
            let film = |palette: &str| film(palette, chosen.clone());
            assert!(film("").look == look && !film("").output.titles, "{name}");
            // The colors that the shape brings stay.
            assert_eq!(film(OWN_COLORS).look, Look { own_colors: true, ..look }, "{name}");
        }
    }

    #[test]
    fn the_song_is_the_one_that_was_heard_when_the_form_was_opened() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let song = |filming: &Filming| {
            let named = |name: &str| (name.to_owned(), BeatReading::default());
            let scene = Scene {
                show: Show::of(&Instrument::new(1, 6, shape.clone()).unwrap()),
                body: "sample:ring".into(),
                songs: vec![named("first.wav"), named("second.wav")],
                song: Some(1),
                view: View::Gallery,
                on_stage: None,
                favorites: 0,
                draw: Draw::Cpu,
            };
            let film = filming.form.as_ref().unwrap().film(scene, Output::to("film.gif".into())).unwrap();
            film.songs[0].0.clone()
        };
        let mut filming = Filming::default();
        filming.ask(Some((0, "first".into())), true).unwrap();
        assert_eq!(song(&filming), "first.wav");
        filming.forget_song();
        assert_eq!(song(&filming), "second.wav");
        filming.ask(None, true).unwrap();
        assert_eq!(song(&filming), "second.wav");
    }

    #[test]
    fn the_form_begins_as_it_was_left_with_titles_where_the_stage_has_them() {
        let mut filming = Filming::default();
        filming.ask(Some((0, "first".into())), false).unwrap();
        let form = filming.form.as_mut().unwrap();
        assert_eq!((form.titles, form.size), (false, Form::FIRST.size));
        (form.size, form.fps, form.to_secs) = ([1920, 1080], 60.0, 5.0);
        filming.close();
        filming.ask(None, true).unwrap();
        let form = filming.form.unwrap();
        assert_eq!((form.size, form.fps, form.to_secs), ([1920, 1080], 60.0, 5.0));
        assert_eq!((form.titles, form.song), (true, None));
    }

    #[test]
    fn a_film_whose_form_was_closed_is_refused_in_words() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let scene = Scene {
            show: Show::of(&Instrument::new(1, 6, shape).unwrap()),
            body: "sample:ring".into(),
            songs: Vec::new(),
            song: None,
            view: View::Gallery,
            on_stage: None,
            favorites: 0,
            draw: Draw::Cpu,
        };
        let (path, ctx) = (Path::new("film.gif"), egui::Context::default());
        let begun = Filming::default().begin(scene, path, false, &ctx);
        assert!(begun.unwrap_err().to_string().contains("form was closed"));
    }

    #[test]
    fn a_gallery_is_no_dance_for_a_glb() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let film = |view, on_stage: bool, favorites| {
            let scene = Scene {
                show: Show::of(&Instrument::new(1, 6, shape.clone()).unwrap()),
                body: "sample:ring".into(),
                songs: vec![("sample:tune".into(), BeatReading::default())],
                song: Some(0),
                view,
                on_stage: on_stage.then(OnStage::default),
                favorites,
                draw: Draw::Cpu,
            };
            Form::FIRST.film(scene, Output::to("dance.glb".into()))
        };
        assert!(film(View::Gallery, false, 0).is_err());
        assert!(film(View::Gallery, true, 0).is_ok() && film(View::Gallery, false, 1).is_ok());
        assert!(film(View::CloseUp(3), false, 0).is_ok());
    }
}
