//! Results on standard output, progress and messages on standard error, Ctrl-C to cancel.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use chladni_task::{Task, asks_another_machine};
use chladni_view::{Device, Draw};
use indicatif::{ProgressBar, ProgressStyle};

use crate::work::source::lies_below;
use crate::work::{Error, Warning, Watcher};

/// Work shorter than this shows no progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// The output of a command, and the task to which its long work reports.
pub struct Terminal {
    quiet: bool,
    task: Task,
    /// The choice of the device that draws.
    draw: Draw,
    /// Whether the command has the options --up and --front.
    takes_stance: bool,
}

/// The task of the running command, which Ctrl-C or a signal to end cancels.
static RUNNING: Mutex<Option<Task>> = Mutex::new(None);

impl Terminal {
    /// A terminal for one command. The first Ctrl-C (or, on Unix, SIGTERM or SIGHUP) cancels its task, so that temporary
    /// files are cleaned up; the second ends the process at once.
    pub fn new(quiet: bool) -> Self {
        let task = Task::new();
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Some(task.clone());
        static INSTALLED: AtomicBool = AtomicBool::new(false);
        if !INSTALLED.swap(true, Ordering::SeqCst) {
            // If the handler cannot be installed, Ctrl-C ends the process as usual.
            let _ = ctrlc::set_handler(|| {
                let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
                match running.as_ref() {
                    Some(task) if !task.is_cancelled() => task.cancel(),
                    _ => std::process::exit(130),
                }
            });
        }
        Self { quiet, task, draw: Draw::Auto, takes_stance: false }
    }

    /// The same, with another choice of who draws.
    pub fn drawing(self, draw: Draw) -> Self {
        Self { draw, ..self }
    }

    /// The same for a command that has, or has not, the options --up and --front.
    pub fn taking_stance(self, takes_stance: bool) -> Self {
        Self { takes_stance, ..self }
    }

    /// The choice of the device that draws.
    pub fn draw(&self) -> Draw {
        self.draw
    }

    /// The device that draws the command's pictures.
    pub fn device(&self) -> Result<Device, Error> {
        Ok(Device::open(self.draw)?)
    }

    /// Prints one line of the result to standard output.
    ///
    /// If the reader closes the pipe, as `head` does, that is not a failure: the remaining work is still
    /// done.
    pub fn result(&self, line: impl Display) -> Result<(), Error> {
        match writeln!(std::io::stdout().lock(), "{}", plain(line)) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            written => written.map_err(|error| Error::unwritten(Path::new("standard output"), error)),
        }
    }

    /// Prints a text of several lines, none of which holds a name with a line break, to standard output.
    pub fn page(&self, text: &str) -> Result<(), Error> {
        text.lines().try_for_each(|line| self.result(line))
    }

    /// Prints a JSON value, whose names have no line breaks, to standard output.
    pub fn json(&self, value: &impl serde::Serialize) -> Result<(), Error> {
        self.page(&serde_json::to_string_pretty(value).map_err(Error::other)?)
    }

    /// Reports a file that was written.
    pub fn wrote(&self, path: &Path) -> Result<(), Error> {
        self.result(format_args!("wrote {}", path.display()))
    }

    /// A line for the person at the terminal, on standard error.
    pub fn note(&self, line: impl Display) {
        // If standard error is closed, there is nowhere to report it.
        let _ = writeln!(std::io::stderr().lock(), "{}", plain(line));
    }

    /// The one line with which a command fails.
    pub fn error(&self, error: &Error) {
        self.note(format_args!("chladni: {error}"));
    }
}

impl Watcher for Terminal {
    fn task(&self) -> &Task {
        &self.task
    }

    fn warn(&self, warning: Warning) {
        self.note(format_args!("warning: {}", advised(&warning, self.takes_stance)));
    }

    /// Files below the current folder are where the user works. Of another machine than that folder's, none is looked for.
    fn knows(&self, _document: &Path, file: &Path) -> bool {
        std::env::current_dir()
            .is_ok_and(|folder| !asks_another_machine(file, &folder) && lies_below(file, &folder))
    }

    /// Draws the progress once the part has taken over a second, if the system gives a thread for it.
    fn watch<T>(&self, label: &str, part: impl FnOnce(&Task) -> T) -> T {
        let done = Arc::new(AtomicBool::new(false));
        let watcher = (!self.quiet).then(|| {
            let (task, done, label) = (self.task.clone(), Arc::clone(&done), label.to_owned());
            std::thread::Builder::new().spawn(move || draw_progress(&label, &task, &done)).ok()
        });
        let value = part(&self.task);
        done.store(true, Ordering::Release);
        if let Some(watcher) = watcher.flatten() {
            watcher.thread().unpark();
            let _ = watcher.join();
        }
        value
    }
}

/// The line, with control characters as JSON escapes them: names of files, and in them, may hold some, which would move the
/// cursor, pass for lines of their own, or turn the order of what follows around.
fn plain(line: impl Display) -> String {
    let mut plain = String::new();
    for c in line.to_string().chars() {
        let is_layout = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if c.is_control() || is_layout {
            plain.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            plain.push(c);
        }
    }
    plain
}

/// The warning, with the way out that the command offers.
fn advised(warning: &Warning, takes_stance: bool) -> String {
    match warning {
        Warning::InDoubt { .. } if takes_stance => {
            format!("{warning}: --up and --front say otherwise")
        }
        Warning::NearTie { .. } => {
            format!("{warning} (chladni match SHAPE TEMPLATE --render P.png shows it; --landmarks leads it)")
        }
        _ => warning.to_string(),
    }
}

fn draw_progress(label: &str, task: &Task, done: &AtomicBool) {
    let start = Instant::now();
    while !done.load(Ordering::Acquire) && start.elapsed() < PATIENCE {
        std::thread::park_timeout(PATIENCE.saturating_sub(start.elapsed()));
    }
    if done.load(Ordering::Acquire) {
        return;
    }
    if !std::io::stderr().is_terminal() {
        let _ = writeln!(std::io::stderr().lock(), "{label} …");
        return;
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{prefix}  {bar:32} {percent:>3} %  {msg}  {elapsed}") {
        bar.set_style(style);
    }
    bar.set_prefix(label.to_owned());
    while !done.load(Ordering::Acquire) {
        let progress = task.progress();
        bar.set_length(progress.total.max(1));
        bar.set_position(progress.done.min(progress.total));
        bar.set_message(progress.stage);
        std::thread::park_timeout(Duration::from_millis(100));
    }
    bar.finish_and_clear();
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_mesh::Orientation;

    #[test]
    fn names_in_files_move_no_cursor_and_make_no_lines() {
        let name = "a\u{1b}[2J\nwrote b\u{9b}é…\t";
        assert_eq!(plain(name), "a\\u001b[2J\\u000awrote b\\u009bé…\\u0009");
        // JSON stays JSON.
        let json = serde_json::to_string(&[name]).unwrap();
        let read: [String; 1] = serde_json::from_str(&plain(&json)).unwrap();
        assert_eq!(read, [name]);
    }

    #[test]
    fn only_commands_that_have_options_for_the_stance_advise_them() {
        let warning = Warning::InDoubt { name: "a.obj".into(), stands: Orientation::Y_UP };
        assert!(advised(&warning, true).contains("--up and --front"));
        assert!(advised(&warning, false).ends_with("which is in doubt"));
    }

    #[test]
    fn a_match_that_may_be_turned_round_can_be_looked_at() {
        let warning = Warning::NearTie { template: "b.obj".into() };
        let said = advised(&warning, false);
        assert!(said.starts_with("b.obj: another pose") && said.contains("--render P.png"), "{said}");
    }
}
