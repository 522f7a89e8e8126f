//! `chladni demo [-o DIR]`: a taste of both instruments from the samples.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use chladni_caricature::{DEFAULT_HARMONICS, Layer, Project, ShapeSource, Template};
use chladni_music::{Action, Form, Parameter};
use chladni_view::{FrameRate, ffmpeg_is_there};

use super::Terminal;
use super::ink::InkOptions;
use super::portrait::{self, Portrait};
use super::sheet::SheetOptions;
use crate::work::film::{self, Beginning, Film, Output};
use crate::work::formats::TUNE;
use crate::work::outputs::check_folders;
use crate::work::source;
use crate::work::{Error, Watcher, body, make, make_folder};

/// Make a caricature and a dancing clip from the samples.
#[derive(clap::Args)]
pub struct Demo {
    /// Folder for what is made.
    #[arg(short, long, value_name = "DIR", default_value = "chladni-demo")]
    output: PathBuf,
}

/// Size, frames a second and seconds of a film that a software driver on four cores draws in seconds.
struct Clip {
    file: &'static str,
    size: [u32; 2],
    fps: u32,
    secs: f64,
}

const CLIP: Clip = Clip { file: "dance.gif", size: [480, 360], fps: 15, secs: 4.0 };
const FILM: Clip = Clip { file: "dance.mp4", size: [640, 480], fps: 24, secs: 6.0 };

impl Demo {
    /// Makes everything, and prints the files and the commands for them.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let folder = &self.output;
        check_folders(folder)?;
        make_folder(folder)?;
        caricature(folder, terminal)?;
        dance(folder, &CLIP, terminal)?;
        if ffmpeg_is_there() {
            dance(folder, &FILM, terminal)?;
        } else {
            terminal.note("ffmpeg is not on the PATH: no MP4 with sound this time");
        }
        Ok(())
    }
}

fn caricature(folder: &Path, terminal: &Terminal) -> Result<(), Error> {
    let (out, picture) = (folder.join("caricature.glb"), folder.join("caricature.png"));
    terminal.note(format_args!(
        "$ chladni caricature sample:head sample:template --mu -0.7 -o {} --render {}",
        out.display(),
        picture.display()
    ));
    let shape = ShapeSource::Sample("head".into());
    let mut project = Project::new(shape.clone(), DEFAULT_HARMONICS);
    let template = Template::Sample("template".into());
    project.push(Layer { mu: -0.7, ..project.new_layer("caricature", template) })?;
    let mesh = source::shape(&project.shape, terminal)?;
    let name = shape.to_string();
    let (body, _) = body::build(&name, &mesh, project.harmonics, project.laplacian, terminal)?;
    let mut made = make(mesh, Arc::new(body), &project, false, terminal)?;
    made.sculpture.save(&out, terminal.task())?;
    terminal.wrote(&out)?;
    let (portrait, sheet, ink) = (Portrait::default(), SheetOptions::default(), InkOptions::default());
    // The sample has no colors of its own.
    let from = portrait.camera(&name, &made.sculpture.subject.mesh, project.stands, made.stands, terminal)?;
    let view = (from, portrait.size());
    portrait::render(&mut made, None, &project, &picture, view, (&sheet, false), &ink, terminal)?;
    terminal.wrote(&picture)
}

fn dance(folder: &Path, clip: &Clip, terminal: &Terminal) -> Result<(), Error> {
    let (out, [width, height]) = (folder.join(clip.file), clip.size);
    terminal.note(format_args!(
        "$ chladni dance sample:octopus {TUNE} -o {} --form half-mask --gain 1.5 --size {width}x{height} --fps {} \
         --duration {}",
        out.display(),
        clip.fps,
        clip.secs
    ));
    let output = Output {
        width,
        height,
        rate: FrameRate::per_second(clip.fps),
        draw: terminal.draw(),
        ..Output::to(out.clone())
    };
    let changes = vec![
        Action::SetForm { form: Form::HalfMask },
        Action::Set { parameter: Parameter::Gain, value: 1.5 },
    ];
    let beginning = Beginning { changes, ..Beginning::default() };
    let mut film = Film::new("sample:octopus".into(), TUNE.into(), beginning, output);
    film.duration_secs = Some(clip.secs);
    let report = film::make(film, terminal)?;
    terminal.wrote(&out)?;
    report.lines().iter().for_each(|line| terminal.note(line));
    Ok(())
}
