//! Measures where a match spends its time, how often it reports progress, and how soon it stops when
//! cancelled.
//!
//! Usage: `stages [SHAPE TEMPLATE]`, two files; without them, pair A of the shared data.
#![allow(clippy::print_stdout, reason = "a program")]

use std::time::{Duration, Instant};

use chladni_match::{MatchError, MatchSettings, match_shapes};
use chladni_mesh::{TriMesh, load_mesh};
use chladni_task::{Progress, Task};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let named: Vec<_> = std::env::args_os().skip(1).map(Into::into).collect();
    let [shape, template] = match &named[..] {
        [shape, template] => [shape, template].map(|path: &std::path::PathBuf| load_mesh(path)),
        [] => {
            let shared = |name| chladni_testdata::shared(name).ok_or("no shared data");
            [shared("meshes/heads/igea.ply")?, shared("meshes/heads/decimated-max.obj")?]
                .map(|p| load_mesh(&p))
        }
        _ => return Err("expected a shape and a template, or nothing".into()),
    };
    let (shape, template) = (shape?.mesh, template?.mesh);
    let total = watch(&shape, &template)?;
    let slowest = (1..8)
        .map(|i| cancelled_after(&shape, &template, total * i / 8))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .max();
    println!("stops within {:.3} s of being cancelled", slowest.unwrap_or_default().as_secs_f64());
    Ok(())
}

/// Prints the seconds of every stage and the longest time without a report.
fn watch(shape: &TriMesh, template: &TriMesh) -> Result<Duration, MatchError> {
    let task = Task::new();
    let start = Instant::now();
    let mut stages: Vec<(Progress, Instant)> = Vec::new();
    let (mut heard, mut silence) = (start, Duration::ZERO);
    let found = std::thread::scope(|scope| {
        let worker = scope.spawn(|| match_shapes(shape, template, &MatchSettings::default(), &task));
        while !worker.is_finished() {
            let now = task.progress();
            if stages.last().is_none_or(|(last, _)| *last != now) {
                silence = silence.max(heard.elapsed());
                heard = Instant::now();
                match stages.last_mut() {
                    Some((last, _)) if (&last.stage, last.total) == (&now.stage, now.total) => *last = now,
                    _ => stages.push((now, heard)),
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        worker.join()
    });
    let end = Instant::now();
    let ends = stages.iter().skip(1).map(|s| s.1).chain([end]);
    for ((progress, begin), until) in stages.iter().zip(ends) {
        println!(
            "{:<24} {:>5} of {:>5}  {:.3} s",
            progress.stage,
            progress.done,
            progress.total,
            (until - *begin).as_secs_f64()
        );
    }
    println!(
        "{:<24} {:.3} s, longest silence {:.3} s",
        "all",
        (end - start).as_secs_f64(),
        silence.as_secs_f64()
    );
    match found {
        Ok(found) => found.map(|_| end - start),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// How long the match continues after it was cancelled, which happens `delay` after its start.
fn cancelled_after(shape: &TriMesh, template: &TriMesh, delay: Duration) -> Result<Duration, MatchError> {
    let task = Task::new();
    let (result, end, cancelled) = std::thread::scope(|scope| {
        let cancelling = scope.spawn(|| {
            std::thread::sleep(delay);
            task.cancel();
            Instant::now()
        });
        let result = match_shapes(shape, template, &MatchSettings::default(), &task);
        (result, Instant::now(), cancelling.join())
    });
    match (result, cancelled) {
        (Ok(_) | Err(MatchError::Cancelled(_)), Ok(at)) => Ok(end.saturating_duration_since(at)),
        (Err(error), _) => Err(error),
        (_, Err(panic)) => std::panic::resume_unwind(panic),
    }
}
