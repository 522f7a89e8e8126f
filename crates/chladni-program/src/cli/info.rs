//! `chladni info MESH`: the health report.

use std::path::{Path, PathBuf};

use chladni_harmonics::{CoverReport, HarmonicsError};
use chladni_mesh::{Estimate, HealthReport, Known, ShapeSource};
use serde::Serialize;

use super::Terminal;
use crate::work::{Error, Watcher, health_rows, laplacian_row, source};

/// Report what a mesh file holds and how sound it is.
#[derive(clap::Args)]
pub struct Info {
    /// A mesh file (OBJ, PLY, OFF, STL, glTF, GLB or Medit) or sample:NAME.
    mesh: PathBuf,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
}

/// The output of `--json`: the report, what had to be mended, and what is done for the Laplacian.
#[derive(Serialize)]
struct Printed {
    #[serde(flatten)]
    report: HealthReport,
    stands: Stands,
    mended: Vec<String>,
    /// `null` where the mesh has no harmonics.
    cover: Option<CoverReport>,
}

/// How the shape most probably stands, in the file's axes.
#[derive(Serialize)]
struct Stands {
    up: [f64; 3],
    front: [f64; 3],
    in_doubt: bool,
    because: &'static str,
}

/// All that is found out about a mesh.
struct Examined {
    report: HealthReport,
    mended: Vec<String>,
    found: Estimate,
    cover: Result<CoverReport, HarmonicsError>,
}

/// Reads and examines the mesh called `name`; warns of repairs. Cancelling ends it after the step at hand.
fn examined(name: &Path, watcher: &impl Watcher) -> Result<Examined, Error> {
    let source = ShapeSource::named(name);
    let loaded = source::loaded(&source, watcher)?;
    // Samples are estimated, too: that shows how well it goes.
    let known = if source.stands().is_some() { Known::default() } else { source.known() };
    let found = watcher.watch("finding which way is up", |task| Estimate::of(&loaded.mesh, known, task))?;
    watcher.task().check()?;
    let report = watcher.watch("checking the mesh", |_| loaded.health());
    watcher.task().check()?;
    let cover = watcher.watch("covering the mesh for its Laplacian", |_| CoverReport::of(&loaded.mesh));
    watcher.task().check()?;
    let mended = loaded.mended.iter().map(ToString::to_string).collect();
    Ok(Examined { report, mended, found, cover })
}

impl Info {
    /// Prints the report.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let Examined { report, mended, found, cover } = examined(&self.mesh, terminal)?;
        if self.json {
            let stands = Stands {
                up: found.orientation.up(),
                front: found.orientation.front(),
                in_doubt: found.in_doubt,
                because: found.evidence.words(),
            };
            return terminal.json(&Printed { report, stands, mended, cover: cover.ok() });
        }
        for (name, value) in health_rows(&report).into_iter().chain([laplacian_row(cover.as_ref())]) {
            terminal.result(format_args!("{name:<22} {value}"))?;
        }
        let (why, doubt) = (found.evidence.words(), if found.in_doubt { ", but in doubt" } else { "" });
        terminal.result(format_args!("{:<22} {} (because {why}{doubt})", "stands", found.orientation))
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use chladni_task::Task;

    use super::*;
    use crate::work::Warning;

    /// Records the names of all parts, and is cancelled as soon as the one that is called so has returned.
    #[derive(Default)]
    struct Recorder {
        task: Task,
        labels: RefCell<Vec<String>>,
        cancelled_after: &'static str,
    }

    impl Watcher for Recorder {
        fn task(&self) -> &Task {
            &self.task
        }

        fn warn(&self, _: Warning) {}

        fn watch<T>(&self, label: &str, part: impl FnOnce(&Task) -> T) -> T {
            self.labels.borrow_mut().push(label.to_owned());
            let value = part(&self.task);
            if label == self.cancelled_after {
                self.task.cancel();
            }
            value
        }
    }

    #[test]
    fn each_step_has_a_name_and_is_the_last_one_where_it_is_cancelled() {
        let steps = [
            "reading the mesh",
            "finding which way is up",
            "checking the mesh",
            "covering the mesh for its Laplacian",
        ];
        let examine = |cancelled_after: &'static str| {
            let recorder = Recorder { cancelled_after, ..Recorder::default() };
            let done = examined(Path::new("sample:ring"), &recorder).map(drop);
            (done, recorder.labels.take())
        };
        let (done, labels) = examine("");
        done.unwrap();
        assert_eq!(labels, steps);
        for (i, step) in steps.into_iter().enumerate() {
            let (done, labels) = examine(step);
            assert!(done.is_err_and(|error| error.is_cancelled()), "{step}");
            assert_eq!(labels, steps[..=i]);
        }
    }
}
