//! Long work beside the interpreter: without its lock, stopped by Ctrl-C, seen by a progress callback.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use chladni_task::{Progress, Task};
use pyo3::prelude::*;

use crate::failure::{Failure, InputError};

/// Between two looks at signals and progress; work that is done is noticed at once.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work` on a thread of its own. `progress` is called with the stage, steps done and steps in all (0 where that is
/// not known) whenever they change; what it raises stops the work and comes out here.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Task) -> Result<T, Failure> + Send,
) -> PyResult<T> {
    if let Some(callback) = progress
        && !callback.is_callable()
    {
        return Err(InputError::new_err("progress is nothing that can be called with (stage, done, total)"));
    }
    let task = Task::new();
    let (done, waiting) = (AtomicBool::new(false), std::thread::current());
    let mut stopped = None;
    let finished = std::thread::scope(|scope| {
        let worker = std::thread::Builder::new().spawn_scoped(scope, || {
            let _done = OnDrop(|| {
                done.store(true, Ordering::Release);
                waiting.unpark();
            });
            work(&task)
        });
        let worker = match worker {
            Ok(worker) => worker,
            Err(error) => {
                return Ok(Err(Failure::Internal(format!("no thread could be started: {error}"))));
            }
        };
        let mut seen = Progress::default();
        while !done.load(Ordering::Acquire) {
            py.detach(|| std::thread::park_timeout(LOOK));
            if stopped.is_none() {
                stopped = look(py, progress, &task, &mut seen).err();
                if stopped.is_some() {
                    task.cancel();
                }
            }
        }
        py.detach(|| worker.join())
    });
    match (finished, stopped) {
        (Ok(Ok(result)), None) => Ok(result),
        (_, Some(stopped)) => Err(stopped),
        (Ok(Err(failure)), None) => Err(failure.into()),
        (Err(_), None) => {
            Err(Failure::Internal("the engine panicked: this is a bug, its message was printed above".into())
                .into())
        }
    }
}

fn look(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    task: &Task,
    seen: &mut Progress,
) -> PyResult<()> {
    py.check_signals()?;
    let now = task.progress();
    if let Some(callback) = progress
        && now != *seen
    {
        callback.call1((&now.stage, now.done, now.total))?;
        *seen = now;
    }
    Ok(())
}

/// Calls its function also where a panic leaves the scope.
struct OnDrop<F: Fn()>(F);

impl<F: Fn()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        self.0();
    }
}
