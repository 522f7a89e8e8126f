//! Films of what dances, made beside the window by the command `dance`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use chladni_music::{Action, Instrument, Moment, Session};
use chladni_view::ffmpeg_is_there;
use egui::Ui;

use super::concert::View;
use super::preferences::Preferences;
use crate::cli;
use crate::studio::job::{self, Job, Outcome};
use crate::studio::room::Shared;

/// What the menu says of it.
pub const TIP: &str = "The whole song with its sound: of a close-up this dance, else the favourites in turn, or the \
                       gallery. `chladni dance` films in any size";

/// How long a closing window waits for a film to end.
const PATIENCE: Duration = Duration::from_secs(5);

/// A film that is being made.
#[derive(Default)]
pub struct Filming(Option<Job<Result<Made, String>>>);

/// A film, and what went otherwise than asked.
struct Made {
    path: PathBuf,
    warnings: Vec<String>,
}

/// What is filmed.
pub struct Scene<'a> {
    /// The shape or caricature, as `dance` calls it.
    pub body: OsString,
    /// The song, as `dance` calls it.
    pub song: OsString,
    pub harmonics: usize,
    pub instrument: &'a Instrument,
    pub view: View,
}

impl Filming {
    /// Asks where to, and begins.
    pub fn begin(&mut self, scene: Scene<'_>, shared: &mut Shared<'_>) -> Result<(), String> {
        if self.0.is_some() {
            return Err("A film is being made already.".into());
        }
        let kinds: [(&str, &[&str]); 2] = [("MP4 with sound", &["mp4"]), ("GIF", &["gif"])];
        let (kinds, name) =
            if ffmpeg_is_there() { (&kinds[..], "dance.mp4") } else { (&kinds[1..], "dance.gif") };
        let Some(path) = shared.chooser.save(kinds, Path::new(name)) else { return Ok(()) };
        let session = tempfile::Builder::new()
            .prefix("chladni-")
            .suffix(".toml")
            .tempfile()
            .map_err(|error| format!("no room for the session: {error}"))?;
        as_it_is(&scene).save(session.path()).map_err(|error| error.to_string())?;
        let words = words(&scene, session.path(), &path, &shared.settings.music);
        let label = format!("Filming {}", path.file_name().unwrap_or_default().to_string_lossy());
        self.0 = Some(Job::start(label, &shared.ctx, move |task| {
            // It lies there until the film is made.
            let _session = session;
            let warnings = cli::beside(&words, task).map_err(|failure| failure.to_string())?;
            Ok(Made { path, warnings })
        }));
        Ok(())
    }

    /// Tells what came of it.
    pub fn poll(&mut self, shared: &mut Shared<'_>) {
        match self.0.as_ref().map(Job::poll) {
            None | Some(Outcome::Running) => return,
            Some(Outcome::Done(Ok(made))) => {
                made.warnings.into_iter().for_each(|warning| shared.notices.warn(warning));
                shared.notices.done(format!("Filmed {}", made.path.display()));
            }
            Some(Outcome::Done(Err(why))) => shared.notices.error(why),
            Some(Outcome::Lost) => shared.notices.error("Filming broke off; this is a bug.".to_owned()),
        }
        self.0 = None;
    }

    /// Ends what is being made, so that nothing half written stays: the window closes.
    pub fn stop(&mut self) {
        let Some(running) = self.0.take() else { return };
        running.cancel();
        let began = Instant::now();
        while matches!(running.poll(), Outcome::Running) && began.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Shows progress while a film is being made; draws nothing otherwise.
    pub fn show(&self, ui: &mut Ui) {
        if let Some(running) = &self.0 {
            egui::Panel::bottom("filming").resizable(false).show(ui, |ui| job::show_progress(ui, running));
        }
    }
}

/// The session that begins where the instrument stands now.
fn as_it_is(scene: &Scene<'_>) -> Session {
    let mut session = Session::of(scene.instrument, "");
    let shown = match scene.view {
        View::CloseUp(item) => Some(Action::Perform { item }),
        _ if !scene.instrument.favourites().is_empty() => Some(Action::PerformFavourites { first: 0 }),
        _ => None,
    };
    for line in &mut session.actions {
        line.moment = Moment::default();
    }
    let line = |action| chladni_music::LoggedAction { moment: Moment::default(), action };
    session.actions.extend(shown.map(line));
    session
}

fn words(scene: &Scene<'_>, session: &Path, path: &Path, look: &Preferences) -> Vec<OsString> {
    let mut words: Vec<OsString> = vec!["dance".into()];
    let options: [(&str, OsString); 6] = [
        ("--session", session.into()),
        ("--output", path.into()),
        ("--harmonics", scene.harmonics.to_string().into()),
        ("--material", look.material.clone().into()),
        ("--lights", look.lights.clone().into()),
        ("--background", look.background.clone().into()),
    ];
    words.extend(options.into_iter().flat_map(|(option, value)| [option.into(), value]));
    // Nothing after this is an option, whatever the files are called.
    words.extend(["--".into(), scene.body.clone(), scene.song.clone()]);
    words
}
