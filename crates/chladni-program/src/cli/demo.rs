//! `chladni demo [-o DIR]`: a taste of both instruments from the samples, made with the same
//! commands that a user would type.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use chladni_view::ffmpeg_is_there;

use super::{Failure, Terminal};

/// Make a caricature and a dancing clip from the samples.
#[derive(clap::Args)]
pub struct Demo {
    /// Folder for what is made.
    #[arg(short, long, value_name = "DIR", default_value = "chladni-demo")]
    output: PathBuf,
}

/// Sizes and lengths that a software driver on four cores draws in seconds.
const CLIP: [&str; 10] =
    ["--form", "half-mask", "--gain", "1.5", "--size", "480x360", "--fps", "15", "--duration", "4"];
const FILM: [&str; 10] =
    ["--form", "half-mask", "--gain", "1.5", "--size", "640x480", "--fps", "24", "--duration", "6"];

impl Demo {
    /// Makes everything and says what it made.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let folder = &self.output;
        std::fs::create_dir_all(folder).map_err(|error| Failure::writing(folder, error))?;
        let mut caricature = words(&["caricature", "sample:head", "sample:template", "--mu", "-0.7"]);
        caricature.extend(["-o".into(), folder.join("caricature.glb").into()]);
        caricature.extend(["--render".into(), folder.join("caricature.png").into()]);
        show_and_run(&caricature, terminal)?;
        show_and_run(&dance(folder, "dance.gif", &CLIP), terminal)?;
        if ffmpeg_is_there() {
            show_and_run(&dance(folder, "dance.mp4", &FILM), terminal)?;
        } else {
            terminal.note("ffmpeg is not on the PATH: no MP4 with sound this time");
        }
        Ok(())
    }
}

fn words(texts: &[&str]) -> Vec<OsString> {
    texts.iter().map(OsString::from).collect()
}

fn dance(folder: &Path, film: &str, options: &[&str]) -> Vec<OsString> {
    let mut dance = words(&["dance", "sample:octopus", "sample:tune"]);
    dance.extend(["-o".into(), folder.join(film).into()]);
    dance.extend(words(options));
    dance
}

/// Prints the command as one would type it, then runs it.
fn show_and_run(command: &[OsString], terminal: &Terminal) -> Result<(), Failure> {
    let line: Vec<_> = command.iter().map(|word| word.to_string_lossy()).collect();
    terminal.note(format_args!("$ chladni {}", line.join(" ")));
    super::follow(command, terminal)
}
