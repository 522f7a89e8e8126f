//! Finds, starts, watches and ends the processes of the ranks.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chladni_task::{Cancelled, Needs, Task, other_program};

use super::Ranks;
use crate::HarmonicsError;

/// Time between two checks whether the work was cancelled.
const LOOK: Duration = Duration::from_millis(50);
/// Time that mpirun gets to end its ranks before it is killed.
const FAREWELL: Duration = Duration::from_secs(10);
/// The number of lines of error output that are kept, the last ones.
const LINES: usize = 200;

/// The command that starts ranks on this machine.
pub(super) struct Launcher {
    python: PathBuf,
    is_open_mpi: bool,
}

fn missing(what: &str) -> HarmonicsError {
    let reason = format!("{what}: install Open MPI and slepc4py (scripts/setup --mpi does)");
    HarmonicsError::NoRanks { reason }
}

fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

impl Launcher {
    /// Finds mpirun, and a Python that has slepc4py: the one that `CHLADNI_MPI_PYTHON` names, otherwise the
    /// first on the PATH, otherwise the system's.
    pub(super) fn find(worker: &Path) -> Result<Self, HarmonicsError> {
        let version = output(other_program("mpirun", Needs::Ranks).arg("--version"));
        let version = version.ok_or_else(|| missing("mpirun is not on the PATH"))?;
        let named = std::env::var_os("CHLADNI_MPI_PYTHON").filter(|name| !name.is_empty());
        let candidates = match named {
            Some(python) => vec![PathBuf::from(python)],
            None => vec!["python3".into(), "/usr/bin/python3".into()],
        };
        let has_slepc = |python: &PathBuf| {
            output(other_program(python, Needs::Ranks).arg(worker).arg("--check")).is_some()
        };
        let python = candidates.into_iter().find(has_slepc);
        let python = python.ok_or_else(|| missing("no Python has slepc4py"))?;
        Ok(Self { python, is_open_mpi: version.contains("Open MPI") })
    }

    fn command(&self, ranks: &Ranks, worker: &Path, folder: &Path) -> Command {
        let mut command = other_program("mpirun", Needs::Ranks);
        if self.is_open_mpi {
            // Ranks that yield while they wait are three times as fast on a machine that has other work to do.
            command.args(["--mca", "mpi_yield_when_idle", "1"]);
        }
        match (&ranks.hosts, self.is_open_mpi) {
            (Some(hosts), true) => command.arg("--hostfile").arg(hosts),
            (Some(hosts), false) => command.arg("-f").arg(hosts),
            // More ranks than cores are slow but not wrong. Without a host, ranks would go to all machines of a
            // cluster's job, which need not share the folder.
            (None, true) => command
                .args(["--oversubscribe", "--bind-to", "none", "--host"])
                .arg(format!("localhost:{}", ranks.count)),
            (None, false) => &mut command,
        };
        command.arg("-n").arg(ranks.count.to_string()).arg(&self.python).arg(worker).arg(folder);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs all ranks to their end. The stages that they report become those of `task`.
    pub(super) fn run(
        &self,
        ranks: &Ranks,
        worker: &Path,
        folder: &Path,
        task: &Task,
    ) -> Result<(), HarmonicsError> {
        let failed = |reason: String| HarmonicsError::RanksFailed { reason };
        let mut command = self.command(ranks, worker, folder);
        let mut running = Running(command.spawn().map_err(|error| failed(format!("mpirun: {error}")))?);
        let progress = as_they_arrive(running.0.stdout.take());
        let complaints = last_lines(running.0.stderr.take());
        loop {
            match progress.recv_timeout(LOOK) {
                Ok(line) => {
                    if let Some(stage) = line.strip_prefix("stage ") {
                        task.stage(stage, 0);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if task.is_cancelled() {
                return Err(Cancelled.into());
            }
        }
        let status = running.0.wait().map_err(|error| failed(format!("mpirun: {error}")))?;
        task.check()?;
        if status.success() {
            return Ok(());
        }
        let complaints = complaints.join().unwrap_or_default();
        Err(failed(reason(&Vec::from(complaints))))
    }
}

/// The lines of a pipe.
fn lines(pipe: impl Read) -> impl Iterator<Item = String> {
    let lines = BufReader::new(pipe).split(b'\n').map_while(Result::ok);
    lines.map(|line| String::from_utf8_lossy(&line).into_owned())
}

/// The lines of a pipe as they arrive. It is read to its end even if nobody takes them: a full pipe would block the ranks.
fn as_they_arrive(pipe: Option<impl Read + Send + 'static>) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in pipe.into_iter().flat_map(lines) {
            let _ = sender.send(line);
        }
    });
    receiver
}

/// The last lines of a pipe, once it has ended: a program says last why it ends.
fn last_lines(pipe: Option<impl Read + Send + 'static>) -> JoinHandle<VecDeque<String>> {
    std::thread::spawn(move || {
        let mut last = VecDeque::new();
        for line in pipe.into_iter().flat_map(lines) {
            if last.len() == LINES {
                last.pop_front();
            }
            last.push_back(line);
        }
        last
    })
}

/// The reason that a rank gave, or otherwise mpirun's first sentence.
fn reason(complaints: &[String]) -> String {
    if complaints.iter().any(|line| line.contains("attempt to run as root")) {
        return "Open MPI runs as root only where OMPI_ALLOW_RUN_AS_ROOT=1 and OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 are set"
            .into();
    }
    if complaints.iter().any(|line| line.contains("on signal 9")) {
        return "a rank was killed, as systems do where memory ends: --iterative (Python: iterative=True) solves \
                without factors, and more hosts have more memory"
            .into();
    }
    let of_rank = complaints.iter().find_map(|line| line.strip_prefix("chladni: "));
    let raised = || complaints.iter().find(|line| line.contains("Error: ")).map(|line| line.trim());
    let first =
        || complaints.iter().map(|line| line.trim()).find(|line| line.chars().any(char::is_alphabetic));
    of_rank.or_else(raised).or_else(first).unwrap_or("mpirun failed without a word").to_owned()
}

/// Ends mpirun, and with it all ranks, if it still runs when it is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        if matches!(self.0.try_wait(), Ok(Some(_))) {
            return;
        }
        // After a request to terminate, mpirun ends its ranks on all hosts; if it were killed, it would
        // leave them behind. The shell has a kill of its own, on machines without that program, too.
        let end = format!("kill -TERM {}", self.0.id());
        let asked = other_program("sh", Needs::Files).args(["-c", &end]).status();
        let until = Instant::now() + FAREWELL;
        while asked.as_ref().is_ok_and(std::process::ExitStatus::success) && Instant::now() < until {
            if matches!(self.0.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(LOOK);
        }
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_stay_on_this_machine_unless_there_are_hosts() {
        let launcher = Launcher { python: "python3".into(), is_open_mpi: true };
        let words = |ranks: &Ranks| {
            let command = launcher.command(ranks, Path::new("worker.py"), Path::new("folder"));
            command.get_args().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
        };
        let here = Ranks::here(3);
        assert!(
            words(&here).contains("--host localhost:3 -n 3 python3 worker.py folder"),
            "{}",
            words(&here)
        );
        let elsewhere = Ranks { hosts: Some("hosts.txt".into()), ..here };
        assert!(
            words(&elsewhere).contains("--hostfile hosts.txt -n 3") && !words(&elsewhere).contains("--host ")
        );
    }

    #[test]
    fn the_last_lines_of_many_are_kept() {
        let text = format!("{}chladni: rank 1 on a: out of memory\n", "a warning\n".repeat(1000));
        let last = Vec::from(last_lines(Some(std::io::Cursor::new(text))).join().unwrap());
        assert_eq!((last.len(), reason(&last).as_str()), (LINES, "rank 1 on a: out of memory"));
    }

    #[test]
    fn the_reason_is_the_rank_s_own_where_it_gave_one() {
        let reason_of = |text: &str| reason(&text.lines().map(str::to_owned).collect::<Vec<_>>());
        assert_eq!(
            reason_of("------\nPrimary job ended\nchladni: rank 1 on a: out of memory\n"),
            "rank 1 on a: out of memory"
        );
        assert_eq!(reason_of("-----\n\n  Bad hosts\n---"), "Bad hosts");
        let killed = "mpirun noticed that process rank 1 with PID 0 on node a exited on signal 9 (Killed).";
        assert!(reason_of(killed).contains("--iterative (Python: iterative=True)"));
        assert!(
            reason_of("mpirun has detected an attempt to run as root.").contains("OMPI_ALLOW_RUN_AS_ROOT=1")
        );
        assert_eq!(reason_of("Traceback:\n  File a\nImportError: no b"), "ImportError: no b");
        assert!(reason_of("").contains("without a word"));
    }
}
