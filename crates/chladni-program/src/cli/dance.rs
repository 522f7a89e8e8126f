//! `chladni dance MESH SONG`: its arguments, and the film that they ask for.

mod changes;

use std::path::{Path, PathBuf};

use chladni_mesh::Format;
use chladni_music::{BeatReading, CHOIRS, Choir, FORMS, Form, Looks, Preset, Show, SongRef};
use chladni_synth::Backend;
use chladni_view::film::RawFormat;
use chladni_view::{Answer, Background, Effect, FilmFormat, Lights, Look, Material, Palette, Samples};

use self::changes::{Ring, rings};
use super::Terminal;
use super::choice::one_of;
use super::frames::{Fps, Size};
use super::number::seconds;
use super::portrait::check_drawn;
use super::stance::StanceOptions;
use crate::work::film::{self, Beginning, Film, Output};
use crate::work::formats::is_project;
use crate::work::{
    Error, OWN_COLORS, Piece, Warning, Watcher, blur, cautions, placed, resolve, resolve_looks,
};

/// Film a shape that dances to a song.
#[derive(clap::Args)]
#[command(group(clap::ArgGroup::new("result").required(true).multiple(true).args(["output", "frames", "coefficients"])))]
pub struct Dance {
    /// A mesh file or sample:NAME; or a caricature (.chladni), whose layers become
    /// voices that the song drives: the bass, the beat, the side and the treble in turn, unless a
    /// show says otherwise. The show's own unless given.
    #[arg(required_unless_present = "show")]
    mesh: Option<String>,
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF, Matroska) or sample:tune. What was heard in the
    /// show unless given.
    #[arg(required_unless_present = "show")]
    song: Option<String>,
    /// The film: .mp4 with sound (needs ffmpeg), .gif or .png (animated, silent). Or .glb: the shape with
    /// morph targets and their weights as an animation, for Blender and other programs; the sound is written
    /// beside it as .wav. Or -: frames as they are on standard output, silent, for a program that reads them.
    #[arg(short, long, value_name = "FILM")]
    output: Option<PathBuf>,
    /// What -o - writes: rgba (8 bits each, row by row; the reader has to know size and rate), the default,
    /// or y4m, which says both.
    #[arg(long, value_name = "FORMAT", value_parser = one_of(RawFormat::NAMED))]
    format: Option<RawFormat>,
    /// Write PNG frames and sound.wav into this folder; needs no other program.
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    frames: Option<PathBuf>,
    /// Only these frames, exactly those of the whole film: A..B counts from 0 and leaves B out, I/N is piece I of N. An MP4
    /// has no sound then (docs/scale.md).
    #[arg(long, value_name = "A..B|I/N")]
    piece: Option<Piece>,
    /// Leave what is there already: a film, or the first frames of a folder, which are whole or missing.
    #[arg(long)]
    resume: bool,
    /// The largest number of morph targets in a .glb, beside one for the offset, 48 unless given: more come nearer to the
    /// film.
    #[arg(long, value_name = "N")]
    targets: Option<usize>,
    /// Width and height in pixels [default: 1280x720]; an MP4 leaves out the last column or row of odd ones.
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<Size>,
    /// Frames per second: a number, or a fraction such as 30000/1001.
    #[arg(long, default_value = "30", allow_negative_numbers = true)]
    fps: Fps,
    /// Where in the song, or in the show, to begin, in seconds.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = seconds)]
    start: f64,
    /// How much of it, in seconds; all unless given.
    #[arg(long, allow_negative_numbers = true, value_parser = seconds)]
    duration: Option<f64>,
    /// Seed of all that is random: the reactions to the beat and, without preset, a mapping bred from the
    /// gallery of this seed instead of the direct one. A show has its own.
    #[arg(long, value_parser = super::layer_options::seed, conflicts_with = "show")]
    seed: Option<u64>,
    /// Dance as this preset says.
    #[arg(long, value_name = "P.toml", conflicts_with = "show")]
    preset: Option<PathBuf>,
    /// Repeat this show, which the window has saved.
    #[arg(long, alias = "session", value_name = "S.toml")]
    show: Option<PathBuf>,
    /// Show the whole gallery of this many items (6, 9, 12 or 16) instead of one.
    #[arg(long, value_name = "S", conflicts_with_all = ["preset", "show"])]
    gallery: Option<usize>,
    /// half-mask: each half dances to its own channel; modal: along the normals, as a sounding plate;
    /// filter: the paper's, which shows left and right alike. A show's or preset's own form unless given,
    /// else half-mask.
    #[arg(long, value_parser = one_of(FORMS))]
    form: Option<Form>,
    /// How harmonics ring when the sound strikes them; none: they follow its level, as in the paper. A show's or
    /// preset's own unless given, else rubber.
    #[arg(long, value_parser = one_of(rings()))]
    timbre: Option<Ring>,
    /// Which harmonics may sound.
    #[arg(long, value_parser = one_of(CHOIRS))]
    choir: Option<Choir>,
    /// How strongly it moves, 0 to 20. This and all such options hold throughout a show, whatever it does with them.
    #[arg(long, allow_negative_numbers = true)]
    gain: Option<f32>,
    /// One µ for all dances, 0 to 1, instead of each one's own; not in half-mask, where each half hears its own channel.
    #[arg(long, allow_negative_numbers = true)]
    mu: Option<f32>,
    /// Turn any knob or switch of the window, by the name that it has over OSC, such as decay=0.7,
    /// beat-turns=off, form=modal or harmonics=128.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// K, the number of harmonics [default: the show's own, else 512; those of a project that has fewer].
    #[arg(short = 'k', long, value_name = "K")]
    harmonics: Option<usize>,
    /// Paper mode: harmonics of the plain cotangent Laplacian, which not every mesh can have, their
    /// classes by the vote of the extrema, the filter form, linear bands and blended normals.
    #[arg(long)]
    paper: bool,
    /// Lean back: dances, looks and strength change with the music, where sections and bars begin. A look that is given
    /// stays, and so does what --form, --timbre, --choir, --mu, --paper and --set say; --gain is the strength around
    /// which it changes.
    #[arg(long, conflicts_with_all = ["preset", "show", "gallery", "coefficients"])]
    autopilot: bool,
    /// Write times_secs and coefficients (frames×K×3, or frames×K for the modal form) here; in the half-mask form these
    /// are those of the left half, and coefficients_right those of the right. Beside them mask and mask_right, by which the
    /// movement of each vertex is multiplied. Not with --resume, which makes only what is missing.
    #[arg(long, value_name = "C.npz", conflicts_with = "resume")]
    coefficients: Option<PathBuf>,
    /// Write the mapping of each item of the gallery into this folder, as presets: as they are when all of the film is
    /// made.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["resume", "piece"])]
    presets: Option<PathBuf>,
    /// Strew sand on the shape and set all up for it, throughout a show, too: form modal, little gain, nothing turns on the
    /// beat, and, where nothing else says what dances, a higher tone draws a finer figure. What else is given comes after.
    /// On a flat sheet this is how it begins, unless --form, --preset, --show, --paper or --autopilot is given.
    #[arg(long)]
    sand: bool,
    /// Show the shape at rest, too, as dots.
    #[arg(long)]
    rest: bool,
    /// The whole scene. That of the show unless given, else that in which the shape opens (aurora for most), or plain where
    /// --material, --lights or --background is given.
    #[arg(long, value_name = "LOOK", value_parser = one_of(Look::PRESETS))]
    look: Option<Look>,
    /// Color by movement; or own: the colors that the shape brings, its texture or those of its vertices. The look's own
    /// unless given.
    #[arg(long, value_name = "PALETTE", value_parser = one_of(colorings()))]
    palette: Option<Coloring>,
    /// Lights. Those of the look unless given.
    #[arg(long, value_parser = one_of(Lights::PRESETS))]
    lights: Option<Lights>,
    /// Material; without palette, unless one is given.
    #[arg(long, value_parser = one_of(Material::PRESETS))]
    material: Option<Material>,
    /// Background. That of the look unless given.
    #[arg(long, value_parser = one_of(Background::PRESETS))]
    background: Option<Background>,
    /// A picture behind all, in the place of the background: a PNG or JPEG file, or a film (MP4, MKV, MOV, WebM), which
    /// goes around and needs ffmpeg.
    #[arg(long, value_name = "FILE")]
    picture: Option<String>,
    /// Light from all around, which shapes mirror: an HDR, PNG or JPEG file of all directions, twice as wide as high.
    #[arg(long, value_name = "FILE")]
    panorama: Option<String>,
    /// How soft is what is not in focus, percent: what lies before or behind the front of the shape. That of each look
    /// unless given; 0 is sharp everywhere.
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(0..=100))]
    blur: Option<u8>,
    /// Leave these effects out of every look, also of those that come on stage: trails, glow, dark corners, grain. With a
    /// show, beside those that it leaves out.
    #[arg(long, value_name = "EFFECT", value_delimiter = ',', value_parser = one_of(Effect::NAMED))]
    without: Vec<Effect>,
    /// Turn of the shape in degrees, to begin with.
    #[arg(long, allow_negative_numbers = true)]
    yaw: Option<f32>,
    #[command(flatten)]
    stance: StanceOptions,
    /// Samples a pixel: 4, or 1 with edges smoothed afterwards. Unless given, 4 on a graphics card and by
    /// the processor, which knows no others, and 1 on a software device.
    #[arg(long, value_name = "1|4")]
    samples: Option<Samples>,
    /// Where shapes are deformed; auto is the graphics card where there is one.
    #[arg(long, value_name = "WHERE", default_value = "auto", value_parser = one_of(BACKENDS))]
    synthesis: Backend,
    /// Name each song as it begins, as on stage: its tags' artist and title, else its file.
    #[arg(long)]
    titles: bool,
    /// Do not limit flashes to three a second. Unless given, a show that limits them at any time is limited throughout.
    #[arg(long)]
    allow_flashes: bool,
    /// Limit them in any field of view of 10° (a third of the picture across and down), too, for people who sit close.
    #[arg(long, conflicts_with = "allow_flashes")]
    flash_fields: bool,
    /// Print a report as JSON: what was made, and where the time went.
    #[arg(long)]
    json: bool,
}

impl Dance {
    /// Makes the film.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let (json, samples) = (self.json, self.samples);
        let film = self.film(terminal)?;
        let output = film.output.clone();
        if let Some(film) = output.kept() {
            terminal.note(format_args!("{} is there already", film.display()));
            // Nothing else is wanted, so nothing need be read.
            if !json {
                return Ok(());
            }
        }
        let report = film::make(film, terminal)?;
        if let Some((device, drawn)) = report.drawn_by_processor().filter(|_| samples.is_none()) {
            terminal.note(format_args!(
                "no graphics card: drawn by {device} with {drawn} (--samples 4 is slower and finer)"
            ));
        }
        if json {
            return terminal.json(&report);
        }
        if let Some(folder) = output.film.as_deref().filter(|_| output.is_folder && report.made_nothing()) {
            terminal.note(format_args!("{} is there already", folder.display()));
            return Ok(());
        }
        let sound = output.animation.as_deref().map(film::sound_beside);
        let made = [&output.presets, &output.film, &output.animation, &sound, &output.coefficients];
        for path in made.into_iter().flatten() {
            match output.pipe {
                // Frames alone are on standard output.
                Some(_) => terminal.note(format_args!("wrote {}", path.display())),
                None => terminal.wrote(path)?,
            }
        }
        report.lines().iter().for_each(|line| terminal.note(line));
        Ok(())
    }

    /// The film that is meant by the arguments.
    fn film(self, terminal: &Terminal) -> Result<Film, Error> {
        let (changes, output) = (self.changes()?, self.output(terminal)?);
        if self.picture.is_some() && self.is_transparent() {
            return Err(Error::input(
                "--picture stands in the place of a background: leave out --background transparent",
            ));
        }
        let mut film = match (&self.show, &self.mesh, &self.song) {
            (Some(path), ..) => self.film_of_show(path, output, terminal)?,
            (None, Some(body), Some(song)) => {
                Film::new(body.clone(), song.clone(), self.beginning(terminal)?, output)
            }
            _ => return Err(Error::input("a shape and a song, or --show, are needed")),
        };
        film.harmonics = self.harmonics;
        film.stance = self.stance.into();
        film.paper = self.paper;
        film.autopilot = self.autopilot;
        film.start_secs = self.start;
        film.duration_secs = self.duration;
        // A shape's own colors stay under any look.
        let is_colored = matches!(self.palette, Some(Coloring::By(_)));
        film.beginning.keeps_look = self.look.is_some() || is_colored || self.chooses_parts();
        film.look = self.look(film.look);
        film.picture = self.picture.clone().unwrap_or(film.picture);
        film.panorama = self.panorama.clone().unwrap_or(film.panorama);
        if let Some(yaw) = self.yaw {
            if !yaw.is_finite() {
                return Err(Error::Input(format!("--yaw {yaw}: a number of degrees is needed")));
            }
            film.viewpoint.yaw_rad = yaw.to_radians();
        }
        // A form that is named should be seen, and the autopilot changes what sand needs, so both turn sand off.
        let moves_itself = self.form.is_some() || self.paper || self.autopilot;
        film.beginning.sand = (self.sand || moves_itself).then_some(self.sand);
        film.beginning.changes = changes;
        film.read_from = self.show.or(self.preset);
        Ok(film)
    }

    /// The files to write, and how.
    fn output(&self, terminal: &Terminal) -> Result<Output, Error> {
        let (pipe, file) = match self.output.clone() {
            Some(path) if path == Path::new("-") => (Some(self.format.unwrap_or_default()), None),
            file => (None, file),
        };
        if self.format.is_some() && pipe.is_none() {
            return Err(Error::input(
                "--format says what -o - writes; the ending of a file's name says what it holds",
            ));
        }
        if pipe.is_some() && self.json {
            return Err(Error::input("-o - and --json would both write to standard output"));
        }
        if pipe.is_some() && self.resume {
            return Err(Error::input("--resume is for files: -o - has none"));
        }
        let is_mp4 = |path: &&PathBuf| FilmFormat::of(path).is_ok_and(|format| format == FilmFormat::Mp4);
        if let (Some(film), Some(Background::TRANSPARENT)) = (file.as_ref().filter(is_mp4), self.background) {
            terminal.warn(Warning::of(
                film.display(),
                "an MP4 is black where it would be transparent; --frames is not",
            ));
        }
        let to = match (file, &self.frames) {
            (Some(file), _) => Output::to(file),
            (None, Some(folder)) => Output::frames(folder.clone()),
            (None, None) => Output::nowhere(),
        };
        if self.targets.is_some() && to.animation.is_none() {
            return Err(Error::input("--targets is for a dance that is written as .glb"));
        }
        check_drawn(self.given_for_pictures(), pipe.is_some() || to.film.is_some())?;
        let (width, height) = self.size.map_or((to.width, to.height), |size| (size.width, size.height));
        Ok(Output {
            piece: self.piece.clone(),
            resume: self.resume,
            pipe,
            targets: self.targets.unwrap_or(film::TARGETS),
            coefficients: self.coefficients.clone(),
            presets: self.presets.clone(),
            shows_rest: self.rest,
            width,
            height,
            rate: self.fps.0,
            draw: terminal.draw(),
            samples: self.samples,
            synthesis: self.synthesis,
            allow_flashes: self.allow_flashes,
            flash_fields: self.flash_fields,
            titles: self.titles,
            ..to
        })
    }

    /// The first given option that changes nothing but pictures.
    fn given_for_pictures(&self) -> Option<&'static str> {
        let options = [
            (self.size.is_some(), "--size"),
            (self.rest, "--rest"),
            (self.look.is_some(), "--look"),
            (self.palette.is_some(), "--palette"),
            (self.lights.is_some(), "--lights"),
            (self.material.is_some(), "--material"),
            (self.background.is_some(), "--background"),
            (self.picture.is_some(), "--picture"),
            (self.panorama.is_some(), "--panorama"),
            (self.blur.is_some(), "--blur"),
            (!self.without.is_empty(), "--without"),
            (self.yaw.is_some(), "--yaw"),
            (self.samples.is_some(), "--samples"),
            (self.synthesis != Backend::Auto, "--synthesis"),
            (self.titles, "--titles"),
            (self.allow_flashes, "--allow-flashes"),
            (self.flash_fields, "--flash-fields"),
        ];
        options.into_iter().find_map(|(is_given, option)| is_given.then_some(option))
    }

    /// The film of the show at `path`, with the shape and the song of the arguments in the place of its own where they are
    /// given.
    fn film_of_show(&self, path: &Path, output: Output, terminal: &Terminal) -> Result<Film, Error> {
        check_no_shape(path)?;
        let mut show = Show::load(path).map_err(|error| in_file(path, error))?;
        for caution in cautions(&show) {
            terminal.note(format_args!("{}: {caution}", path.display()));
        }
        let folder = path.parent();
        let file = |file: &chladni_music::FileRef| -> Result<String, Error> {
            let (found, warning) = resolve(file, folder)?;
            if let Some(warning) = warning {
                terminal.warn(warning);
            }
            Ok(found.to_string_lossy().into_owned())
        };
        let missing = |what: &str| {
            let path = path.display();
            Error::Input(format!("{path}: names no {what}: give one on the command line"))
        };
        let body = match (&self.mesh, &show.body) {
            (Some(mesh), _) => {
                // How the show's own shape stands says nothing of another one.
                show.stands = None;
                mesh.clone()
            }
            (None, Some(body)) => file(body)?,
            (None, None) => return Err(missing("shape")),
        };
        let songs = match &self.song {
            Some(song) => {
                show = show.unheard();
                vec![(song.clone(), BeatReading::default())]
            }
            None => {
                // Only those that are heard are needed: a film says which of them is not there.
                let gone = |named: &str| placed(named, folder).to_string_lossy().into_owned();
                let found = |song: &SongRef| file(&song.file()).unwrap_or_else(|_| gone(&song.path));
                show.songs.iter().map(|song| (found(song), song.reading)).collect()
            }
        };
        if songs.is_empty() {
            return Err(missing("song"));
        }
        show.looks = show.looks.map(|looks| self.scenery(looks, folder, terminal));
        Ok(Film::of_show(show, body, songs, output))
    }

    /// The looks of a show in `folder`, whose picture and panorama were found; without what the arguments replace.
    fn scenery(&self, mut looks: Looks, folder: Option<&Path>, terminal: &Terminal) -> Looks {
        // A picture is part of the background, so none need be opened where that is transparent.
        if self.picture.is_some() || self.is_transparent() {
            looks.picture.clear();
        }
        if self.panorama.is_some() {
            looks.panorama.clear();
        }
        let (looks, warnings) = resolve_looks(looks, folder);
        terminal.warn_each(warnings);
        looks
    }

    /// Whether nothing is to stand behind the shape.
    fn is_transparent(&self) -> bool {
        self.background == Some(Background::TRANSPARENT)
    }

    /// Whether the arguments name parts of a scene, which a whole one may not suit.
    fn chooses_parts(&self) -> bool {
        self.material.is_some() || self.lights.is_some() || self.background.is_some()
    }

    /// A look, changed as the arguments say.
    fn look(&self, of_show: Look) -> Look {
        // Parts alone are those of the plain look.
        let whole = if self.chooses_parts() && self.show.is_none() { Look::PLAIN } else { of_show };
        let mut look = self.look.unwrap_or(whole).in_place_of(&whole);
        if let Some(material) = self.material {
            look = Look { material, answer: None, ..look };
        }
        match self.palette {
            Some(Coloring::By(palette)) => {
                look.answer = Some(Answer { palette, ..look.answer.unwrap_or(Answer::MOVED) });
                look.own_colors = false;
            }
            Some(Coloring::Own) => look.own_colors = true,
            None => {}
        }
        look.lights = self.lights.unwrap_or(look.lights);
        look.background = self.background.unwrap_or(look.background);
        if let Some(percent) = self.blur {
            (look.finish.blur, look.finish.keeps_blur) = (blur(percent), true);
        }
        look.finish = self.without.iter().fold(look.finish, |finish, effect| finish.without(*effect));
        look
    }

    /// How it begins where no show says it.
    fn beginning(&self, terminal: &Terminal) -> Result<Beginning, Error> {
        let load = |path: &Path| {
            check_no_shape(path)?;
            let preset = Preset::load(path).map_err(|error| in_file(path, error))?;
            if let Some(caution) = preset.caution() {
                terminal.note(format_args!("{}: {caution}", path.display()));
            }
            Ok::<_, Error>(preset)
        };
        let preset = self.preset.as_deref().map(load).transpose()?;
        Ok(Beginning { preset, seed: self.seed, gallery: self.gallery, ..Beginning::default() })
    }
}

/// Where colors come from.
#[derive(Clone, Copy)]
enum Coloring {
    Own,
    By(Palette),
}

fn colorings() -> impl Iterator<Item = (&'static str, Coloring)> {
    let palettes = Palette::ALL.into_iter().map(|palette| (palette.name(), Coloring::By(palette)));
    palettes.chain([(OWN_COLORS, Coloring::Own)])
}

const BACKENDS: [(&str, Backend); 3] =
    [("auto", Backend::Auto), ("cpu", Backend::Cpu), ("gpu", Backend::Gpu)];

/// Refuses a mesh or a caricature, whose format versions are others, in the place of a show or a preset.
fn check_no_shape(path: &Path) -> Result<(), Error> {
    let kind = match Format::of_path(path) {
        Some(_) => "a mesh",
        None if is_project(path) => "a caricature",
        None => return Ok(()),
    };
    let path = path.display();
    Err(Error::Input(format!("{path}: is {kind}: give it as MESH (dance {path} SONG)")))
}

fn in_file(path: &Path, error: chladni_music::MusicError) -> Error {
    match error {
        // It names the file itself.
        chladni_music::MusicError::File { .. } => error.into(),
        error => Error::from(error).of(path.display()),
    }
}
