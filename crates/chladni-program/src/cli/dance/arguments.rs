//! `chladni dance MESH SONG`: what can be asked for, and the film that is meant by it.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use chladni_music::{
    Action, BeatReading, Choir, Dancer, Form, GalleryShape, Instrument, LoggedAction, Mapping, Moment,
    PAPER_MODE, Parameter, Preset, Show, Switch, setting,
};
use chladni_synth::Backend;
use chladni_view::{Background, FrameRate, Lights, Material, Samples};

use super::{Begin, Output, Request, failure};
use crate::cli::stance::Stance;
use crate::cli::{Failure, Terminal};
use crate::dance::{FIRST_VIEW, HARMONICS, Look, look_named, resolve};

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
    /// The film: .mp4 with sound (needs ffmpeg), .gif or .png (animated, silent).
    #[arg(short, long, value_name = "FILM")]
    output: Option<PathBuf>,
    /// Write PNG frames and sound.wav into this folder; needs no other program.
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    frames: Option<PathBuf>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720")]
    size: Size,
    /// Frames per second: a number, or a fraction such as 30000/1001.
    #[arg(long, default_value = "30")]
    fps: Fps,
    /// Where in the song, or in the show, to begin, in seconds.
    #[arg(long, default_value_t = 0.0)]
    start: f64,
    /// How much of it, in seconds; all unless given.
    #[arg(long)]
    duration: Option<f64>,
    /// Seed of all that is random: the reactions to the beat and, without preset and show,
    /// a mapping bred from the gallery of this seed instead of the direct one.
    #[arg(long)]
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
    #[arg(long, value_parser = parse_form)]
    form: Option<Form>,
    /// Which harmonics may sound: all, symmetric or antisymmetric.
    #[arg(long, value_parser = parse_choir)]
    choir: Option<Choir>,
    /// How strongly it moves, 0 to 20.
    #[arg(long)]
    gain: Option<f32>,
    /// One µ for all dances, 0 to 1, instead of each one's own.
    #[arg(long)]
    mu: Option<f32>,
    /// Turn any knob or switch of the window, by the name that it has over OSC, such as decay=0.7,
    /// beat-turns=off, form=modal or harmonics=128.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// K, the number of harmonics: the show's own, else 512, unless given.
    #[arg(short = 'k', long, value_name = "K")]
    harmonics: Option<usize>,
    /// Paper mode: harmonics of the plain cotangent Laplacian, which not every mesh can have, their
    /// classes by the vote of the extrema, the filter form, linear bands and blended normals.
    #[arg(long)]
    paper: bool,
    /// Write times_secs and coefficients (frames×K×3, or frames×K for the modal form) here.
    #[arg(long, value_name = "C.npz")]
    coefficients: Option<PathBuf>,
    /// Write the mapping of each item of the gallery into this folder, as presets.
    #[arg(long, value_name = "DIR")]
    presets: Option<PathBuf>,
    /// Show the shape at rest, too, as dots.
    #[arg(long)]
    rest: bool,
    /// Lights: studio, soft, dramatic, stage. Those of the show unless given, as all of the look.
    #[arg(long, value_parser = named(Lights::named, names(&Lights::PRESETS)))]
    lights: Option<Lights>,
    /// Material: clay, porcelain, bronze, pearl, dark.
    #[arg(long, value_parser = named(Material::named, names(&Material::PRESETS)))]
    material: Option<Material>,
    /// Background: paper, slate, night, white, transparent.
    #[arg(long, value_parser = named(Background::named, names(&Background::PRESETS)))]
    background: Option<Background>,
    /// Turn of the shape in degrees, to begin with.
    #[arg(long, allow_negative_numbers = true)]
    yaw: Option<f32>,
    #[command(flatten)]
    stance: Stance,
    /// Samples a pixel: 4, or 1 with edges smoothed afterwards. Unless given, 4 on a graphics card and by
    /// the processor, which knows no others, and 1 on a software device.
    #[arg(long, value_name = "1|4")]
    samples: Option<Samples>,
    /// Where shapes are deformed: cpu, gpu, or auto, which is the graphics card where there is one.
    #[arg(long, value_name = "WHERE", default_value = "auto", value_parser = parse_backend)]
    synthesis: Backend,
    /// Do not limit flashes to three a second.
    #[arg(long)]
    allow_flashes: bool,
    /// Print a report as JSON: what was made, and where the time went.
    #[arg(long)]
    json: bool,
}

impl Dance {
    /// Makes the film.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let json = self.json;
        let request = self.request(terminal)?;
        let made = [request.output.film.clone(), request.output.coefficients.clone()];
        let report = super::make(request, terminal)?;
        if json {
            return terminal.json(&report);
        }
        made.iter().flatten().try_for_each(|path| terminal.wrote(path))?;
        report.tell(terminal);
        Ok(())
    }

    fn request(self, terminal: &Terminal) -> Result<Request, Failure> {
        let changes = self.changes()?;
        let output = Output {
            film: self.output.clone().or_else(|| self.frames.clone()),
            is_folder: self.frames.is_some(),
            coefficients: self.coefficients.clone(),
            presets: self.presets.clone(),
            shows_rest: self.rest,
            width: self.size.width,
            height: self.size.height,
            rate: self.fps.0,
            samples: self.samples,
            synthesis: self.synthesis,
            allow_flashes: self.allow_flashes,
        };
        let mut request = match &self.show {
            Some(path) => {
                let show = Show::load(path).map_err(|error| in_file(path, error))?;
                if let Some(caution) = show.caution() {
                    terminal.note(format_args!("{}: {caution}", path.display()));
                }
                let folder = path.parent();
                let file = |file: &chladni_music::FileRef| -> Result<String, Failure> {
                    let (found, warning) = resolve(file, folder).map_err(Failure::BadInput)?;
                    if let Some(warning) = warning {
                        terminal.warn(warning);
                    }
                    Ok(found.to_string_lossy().into_owned())
                };
                let missing = |what: &str| {
                    let path = path.display();
                    Failure::BadInput(format!("{path}: names no {what}: give one on the command line"))
                };
                let body = match (&self.mesh, &show.body) {
                    (Some(mesh), _) => mesh.clone(),
                    (None, Some(body)) => file(body)?,
                    (None, None) => return Err(missing("shape")),
                };
                let mut show = show;
                let songs = match &self.song {
                    Some(song) => {
                        (show.heard, show.duration_secs) = (Vec::new(), None);
                        vec![(song.clone(), BeatReading::default())]
                    }
                    None => {
                        let songs = show.songs.iter();
                        songs
                            .map(|song| Ok((file(&song.file())?, song.reading)))
                            .collect::<Result<_, Failure>>()?
                    }
                };
                if songs.is_empty() {
                    return Err(missing("song"));
                }
                Request::of_show(show, body, songs, output)
            }
            None => {
                let (Some(body), Some(song)) = (self.mesh.clone(), self.song.clone()) else {
                    return Err(Failure::BadInput("a shape and a song, or --show, are needed".into()));
                };
                let look = look_named(&crate::studio::first_looks()).0;
                Request {
                    body,
                    songs: vec![(song, BeatReading::default())],
                    stance: Stance::default(),
                    harmonics: HARMONICS,
                    paper: false,
                    heard: Vec::new(),
                    show_secs: None,
                    begin: self.beginning()?,
                    look,
                    viewpoint: FIRST_VIEW,
                    start_secs: 0.0,
                    duration_secs: None,
                    output,
                }
            }
        };
        request.harmonics = self.harmonics.unwrap_or(request.harmonics);
        request.stance = self.stance;
        request.paper = self.paper;
        request.start_secs = self.start;
        request.duration_secs = self.duration;
        let Look { material, lights, background } = request.look;
        request.look = Look {
            material: self.material.unwrap_or(material),
            lights: self.lights.unwrap_or(lights),
            background: self.background.unwrap_or(background),
        };
        if let Some(yaw) = self.yaw {
            request.viewpoint.yaw_rad = yaw.to_radians();
        }
        let begin = request.begin;
        request.begin = Box::new(move |dancer: &Dancer| {
            let (mut instrument, script) = begin(dancer)?;
            for action in changes {
                instrument.apply(Moment::default(), action).map_err(failure)?;
            }
            Ok((instrument, script))
        });
        Ok(request)
    }

    /// What the arguments change before anything else is done.
    fn changes(&self) -> Result<Vec<Action>, Failure> {
        let mut changes = Vec::new();
        changes.extend(self.paper.then_some(PAPER_MODE).into_iter().flatten());
        changes.extend(self.form.map(|form| Action::SetForm { form }));
        changes.extend(self.choir.map(|choir| Action::SetChoir { choir }));
        changes.extend(self.gain.map(|value| Action::Set { parameter: Parameter::Gain, value }));
        if let Some(value) = self.mu {
            changes.push(Action::Switch { switch: Switch::OwnMu, on: false });
            changes.push(Action::Set { parameter: Parameter::StereoMu, value });
        }
        for text in &self.set {
            let action = text.split_once('=').and_then(|(name, value)| setting(name.trim(), value.trim()));
            changes.push(action.ok_or_else(|| {
                Failure::BadInput(format!(
                    "--set {text}: expected NAME=VALUE, such as decay=0.7 or form=modal"
                ))
            })?);
        }
        Ok(changes)
    }

    /// The instrument as the film begins where no show says how.
    fn beginning(&self) -> Result<Begin, Failure> {
        let preset = self.preset.as_deref();
        let preset =
            preset.map(|path| Preset::load(path).map_err(|error| in_file(path, error))).transpose()?;
        let (seed, gallery) = (self.seed, self.gallery);
        Ok(Box::new(move |dancer| {
            let bands = Parameter::Bands.initial() as usize;
            let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
            let size = gallery.unwrap_or(6);
            let mut instrument = Instrument::new(seed.unwrap_or(1), size, shape).map_err(failure)?;
            let mut act = |action| instrument.apply(Moment::default(), action).map_err(failure);
            if let Some(preset) = preset {
                act(Action::Take { item: 0, preset: Box::new(preset) })?;
                act(Action::Perform { item: 0 })?;
            } else if gallery.is_none() {
                if seed.is_some() {
                    (0..size).try_for_each(|item| act(Action::Choose { item, on: true }))?;
                    act(Action::Breed)?;
                } else {
                    let mapping = Mapping::direct(&dancer.eigenvalues, bands);
                    act(Action::Load { item: 0, name: "direct".into(), mapping })?;
                }
                act(Action::Perform { item: 0 })?;
            }
            Ok((instrument, Vec::<LoggedAction>::new()))
        }))
    }
}

/// Width and height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |t: &str| t.parse::<u32>().ok().filter(|n| (1..=16_384).contains(n));
        let (width, height) = text.split_once(['x', 'X']).ok_or("expected WIDTHxHEIGHT, such as 1280x720")?;
        match (number(width), number(height)) {
            (Some(width), Some(height)) => Ok(Self { width, height }),
            _ => Err("width and height are whole numbers from 1 to 16384".into()),
        }
    }
}

/// Frames per second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fps(pub FrameRate);

impl FromStr for Fps {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected frames per second from 1 to 240, such as 30, 29.97 or 30000/1001".to_owned();
        let rate = |numerator: u32, denominator: u32| FrameRate { numerator, denominator };
        let rate = if let Some((n, d)) = text.split_once('/') {
            rate(n.parse().map_err(|_| wrong())?, d.parse().map_err(|_| wrong())?)
        } else if let Ok(whole) = text.parse::<u32>() {
            rate(whole, 1)
        } else {
            let fps: f64 = text.parse().map_err(|_| wrong())?;
            let ntsc = (fps.ceil() - fps / 0.999_000_999).abs() < 0.01;
            if ntsc {
                rate(1000 * fps.ceil() as u32, 1001)
            } else {
                rate((fps * 1000.0).round() as u32, 1000)
            }
        };
        let fps = f64::from(rate.numerator) / f64::from(rate.denominator.max(1));
        if rate.denominator > 0 && (1.0..=240.0).contains(&fps) { Ok(Self(rate)) } else { Err(wrong()) }
    }
}

fn parse_backend(text: &str) -> Result<Backend, String> {
    match text {
        "auto" => Ok(Backend::Auto),
        "cpu" => Ok(Backend::Cpu),
        "gpu" => Ok(Backend::Gpu),
        _ => Err("expected auto, cpu or gpu".into()),
    }
}

fn parse_form(text: &str) -> Result<Form, String> {
    match text {
        "filter" => Ok(Form::Filter),
        "modal" => Ok(Form::Modal),
        "half-mask" => Ok(Form::HalfMask),
        _ => Err("expected filter, modal or half-mask".into()),
    }
}

fn parse_choir(text: &str) -> Result<Choir, String> {
    match text {
        "all" => Ok(Choir::All),
        "symmetric" => Ok(Choir::Symmetric),
        "antisymmetric" => Ok(Choir::Antisymmetric),
        _ => Err("expected all, symmetric or antisymmetric".into()),
    }
}

fn named<T: Send + Sync + Clone + 'static>(
    find: fn(&str) -> Option<T>,
    known: String,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |name| find(name).ok_or_else(|| format!("expected one of {known}"))
}

fn names<T>(presets: &[(&str, T)]) -> String {
    presets.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn in_file(path: &Path, error: chladni_music::Error) -> Failure {
    match error {
        chladni_music::Error::File { .. } => Failure::input(error),
        error => Failure::BadInput(format!("{}: {error}", path.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_sizes() {
        let fps = |t: &str| t.parse::<Fps>().map(|f| (f.0.numerator, f.0.denominator));
        assert_eq!(fps("30"), Ok((30, 1)));
        assert_eq!(fps("29.97"), Ok((30000, 1001)));
        assert_eq!(fps("23.976"), Ok((24000, 1001)));
        assert_eq!(fps("12.5"), Ok((12500, 1000)));
        assert!(fps("0").is_err() && fps("1/0").is_err() && fps("-3").is_err() && fps("nan").is_err());
        assert_eq!("640x360".parse(), Ok(Size { width: 640, height: 360 }));
        assert!("640".parse::<Size>().is_err() && "0x5".parse::<Size>().is_err());
    }
}
