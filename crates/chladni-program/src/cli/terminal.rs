//! Results on standard output, progress and messages on standard error, Ctrl-C to cancel.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use chladni_task::Task;
use chladni_view::{Device, Draw};
use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;

/// Work shorter than this shows no progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Where a command speaks, and the task that its long work reports to.
pub struct Terminal {
    quiet: bool,
    task: Task,
    /// Who is asked to draw.
    draw: Draw,
    /// The warnings, where nobody sits before it.
    unheard: Option<Mutex<Vec<String>>>,
}

/// What Ctrl-C cancels: the task of the command that runs.
static RUNNING: Mutex<Option<Task>> = Mutex::new(None);

impl Terminal {
    /// A terminal for one command. The first Ctrl-C cancels its task, so that temporary files
    /// are cleaned up; the second ends the process at once.
    pub fn new(quiet: bool) -> Self {
        let task = Task::new();
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Some(task.clone());
        static INSTALLED: AtomicBool = AtomicBool::new(false);
        if !INSTALLED.swap(true, Ordering::SeqCst) {
            // Where the handler cannot be installed Ctrl-C ends the process, as everywhere.
            let _ = ctrlc::set_handler(|| {
                let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
                match running.as_ref() {
                    Some(task) if !task.is_cancelled() => task.cancel(),
                    _ => std::process::exit(130),
                }
            });
        }
        Self { quiet, task, draw: Draw::Auto, unheard: None }
    }

    /// Nobody's terminal: nothing is printed, `task` is watched and cancelled elsewhere, and
    /// [`unheard`](Self::unheard) has the warnings.
    pub fn nobodys(task: &Task) -> Self {
        Self { quiet: true, task: task.clone(), draw: Draw::Auto, unheard: Some(Mutex::default()) }
    }

    /// What nobody was warned of.
    pub fn unheard(self) -> Vec<String> {
        self.unheard.map_or_else(Vec::new, |lines| lines.into_inner().unwrap_or_else(PoisonError::into_inner))
    }

    /// The same, where `draw` is asked for.
    pub fn drawing(self, draw: Draw) -> Self {
        Self { draw, ..self }
    }

    /// Who is asked to draw.
    pub fn draw(&self) -> Draw {
        self.draw
    }

    /// Who draws the command's pictures.
    pub fn device(&self) -> Result<Device, Failure> {
        Device::open(self.draw).map_err(Failure::other)
    }

    /// The task of this command: hand it to long work.
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// Prints one line of the result to standard output.
    ///
    /// A reader who has had enough, such as `head`, is no failure: what remains to be done is done.
    pub fn result(&self, line: impl Display) -> Result<(), Failure> {
        match &self.unheard {
            Some(_) => Ok(()),
            None => match writeln!(std::io::stdout().lock(), "{line}") {
                Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
                written => written.map_err(Failure::other),
            },
        }
    }

    /// Prints a JSON value to standard output.
    pub fn json(&self, value: &impl serde::Serialize) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(value).map_err(Failure::other)?;
        self.result(text)
    }

    /// A line for the person at the terminal, on standard error.
    pub fn note(&self, line: impl Display) {
        if self.unheard.is_none() {
            // A closed standard error leaves nobody to tell.
            let _ = writeln!(std::io::stderr().lock(), "{line}");
        }
    }

    /// Something was mended or is not as asked, but work goes on.
    pub fn warn(&self, line: impl Display) {
        match &self.unheard {
            Some(lines) => lines.lock().unwrap_or_else(PoisonError::into_inner).push(line.to_string()),
            None => self.note(format_args!("warning: {line}")),
        }
    }

    /// The one line with which a command fails.
    pub fn error(&self, failure: &Failure) {
        self.note(format_args!("chladni: {failure}"));
    }

    /// Runs `work` and draws its progress once it has taken over a second.
    pub fn watch<T>(&self, label: &str, work: impl FnOnce(&Task) -> T) -> T {
        let done = Arc::new(AtomicBool::new(false));
        let watcher = (!self.quiet).then(|| {
            let (task, done, label) = (self.task.clone(), Arc::clone(&done), label.to_owned());
            std::thread::spawn(move || draw_progress(&label, &task, &done))
        });
        let value = work(&self.task);
        done.store(true, Ordering::Release);
        if let Some(watcher) = watcher {
            watcher.thread().unpark();
            let _ = watcher.join();
        }
        value
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
