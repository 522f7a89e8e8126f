//! `chladni-bench caricature`: how long a user waits for what a user does.

mod gallery;
mod keeping;
mod rehearsal;

pub use gallery::BenchGallery;
pub use keeping::BenchKeeping;

use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use chladni_caricature::{
    Action, Brush, Dab, History, Layer, LayerId, Model, PaintEdit, Painted, Project, Property, RollOff,
    ScaleCurve, Seen, ShapeSource, Smoothing, Stack, Surface, SurfacePoint, Template, flipped_triangles,
    furthest,
};
use chladni_harmonics::{HeatFlow, Laplacian};
use chladni_mesh::surface::vec3::single;
use chladni_mesh::{MirrorPlane, MirrorSearch};
use chladni_task::Task;
use rayon::prelude::*;
use serde::Serialize;

use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Subject, body, make};

/// Time what the caricature studio does between an action and its picture.
#[derive(clap::Args)]
pub struct BenchCaricature {
    /// The shape: a mesh file or sample:NAME.
    #[arg(default_value = "sample:head")]
    shape: String,
    /// K, the number of harmonics.
    #[arg(short = 'k', long, value_name = "K", default_value_t = 512)]
    harmonics: usize,
    /// How often each thing is done; the median counts.
    #[arg(long, default_value_t = 15)]
    repeats: usize,
    /// Only what has this in its name.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// One thing a user does.
#[derive(Serialize)]
struct Row {
    what: String,
    vertices: usize,
    harmonics: usize,
    threads: usize,
    median_ms: f64,
    fastest_ms: f64,
}

impl BenchCaricature {
    /// Times everything and prints a row for each.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let subject = Subject::open(&ShapeSource::named(Path::new(&self.shape)), terminal)?;
        let (body, _) =
            body::build(&self.shape, &subject.mesh, self.harmonics, Laplacian::Delaunay, terminal)?;
        let (vertices, harmonics) = (body.basis.vertices(), body.basis.harmonics());
        let project = project(harmonics)?;
        let mut stack = make(subject, Arc::new(body), &project, false, terminal)?.stack;
        let mut history = History::new(project);
        let basis = stack.body().basis.clone();
        let rows = RefCell::new(Vec::new());
        let row = |what: String, (median_ms, fastest_ms): (f64, f64)| {
            let threads = rayon::current_num_threads();
            rows.borrow_mut().push(Row { what, vertices, harmonics, threads, median_ms, fastest_ms });
        };
        let mut time = |what: &'static str, act: &mut dyn FnMut(usize) -> Result<(), Trouble>| {
            if !what.contains(&self.only) {
                return Ok(());
            }
            row(what.to_owned(), timed(self.repeats.max(1), act).map_err(Error::other)?);
            Ok(())
        };
        time("reading H once: the floor of a transform or a synthesis", &mut |_| {
            std::hint::black_box(basis.vectors.par_chunks(1 << 16).map(summed).sum::<f64>());
            Ok(())
        })?;
        painting(&stack, &mut time)?;
        controls(&mut stack, &mut history, &mut time)?;
        folds(&mut stack, &mut history, &mut time)?;
        drop(stack);
        rehearsal::rehearse(&self.shape, harmonics, &mut time, &row)?;
        let rows = rows.into_inner();
        if self.json {
            return terminal.json(&rows);
        }
        terminal.result(format_args!("{}, N = {vertices}, K = {harmonics}", self.shape))?;
        for row in &rows {
            let Row { what, median_ms, fastest_ms, .. } = row;
            terminal.result(format_args!("{median_ms:8.2} ms  (fastest {fastest_ms:.2})  {what}"))?;
        }
        Ok(())
    }
}

/// Σ h by eight sums, as one alone waits for each addition rather than for memory.
fn summed(h: &[f64]) -> f64 {
    let (eights, rest) = h.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for eight in eights {
        for (sum, h) in sums.iter_mut().zip(eight) {
            *sum += h;
        }
    }
    sums.iter().chain(rest).sum()
}

/// Why something could not be done.
type Trouble = Box<dyn std::error::Error + Send + Sync>;

/// Times `act`, which gets how often it ran before.
type Timer<'a> =
    dyn FnMut(&'static str, &mut dyn FnMut(usize) -> Result<(), Trouble>) -> Result<(), Error> + 'a;

/// Two layers: the first against an ellipsoid in a painted region, the second on its result.
fn project(harmonics: usize) -> Result<Project, Error> {
    let mut project = Project::new(ShapeSource::Sample("bench".into()), harmonics);
    project.push(Layer { model: Model::Normal, mu: -0.3, ..Layer::new("first", Template::Ellipsoid) })?;
    let second = Layer { curve: ScaleCurve::mid(), mu: -0.3, ..Layer::new("second", Template::Original) };
    project.push(second)?;
    Ok(project)
}

fn ids(history: &History) -> Vec<LayerId> {
    history.project().layers().iter().map(|(id, _)| *id).collect()
}

/// A press of a brush of `radius` somewhere on a surface at rest, seen from outside.
fn press(surface: &Surface, i: usize, radius: f64, mirror: Option<MirrorPlane>) -> PaintEdit {
    let triangle = ((i * 7919) % surface.triangles.len().max(1)) as u32;
    let at = SurfacePoint { triangle, weights: [0.3, 0.3, 0.4] };
    let positions = single(&surface.positions);
    let eye = surface.position(&at).map(|p| p.map(|c| 4.0 * c));
    let seen = Seen { surface, positions: &positions, eye, blocked: None };
    let reach = Brush { radius, hardness: 1.0, mirror }.reach(&seen, &at);
    PaintEdit::Dab(Dab::of(&reach, 1.0, false))
}

fn painting(stack: &Stack, time: &mut Timer<'_>) -> Result<(), Error> {
    let surface = stack.surface().clone();
    let mut painted = Painted::Everywhere;
    time("one dab of a brush, a tenth of the shape's half size", &mut |i| {
        painted = press(&surface, i, 0.1, None).apply(&painted, &surface)?;
        Ok(())
    })?;
    time("one dab, half of the shape's half size", &mut |i| {
        painted = press(&surface, i, 0.5, None).apply(&painted, &surface)?;
        Ok(())
    })?;
    let painted = painted.values(&surface.file_positions());
    let flow = HeatFlow::of(stack.body()).map(Arc::new)?;
    let step = flow.step(0.01)?;
    time("region smoothing, heat: one solve", &mut |_| {
        std::hint::black_box(step.apply(&painted));
        Ok(())
    })?;
    time("region smoothing, heat: factorization for another softness", &mut |i| {
        flow.step(0.01 + 1e-4 * i as f64)?;
        Ok(())
    })?;
    time("region smoothing, heat: Laplacian and its order, once a shape", &mut |_| {
        HeatFlow::of(stack.body())?;
        Ok(())
    })?;
    let sharp = Smoothing { roll_off: RollOff::Sharp, ..Smoothing::default() };
    time("region smoothing, sharp", &mut |_| {
        sharp.apply(stack.body(), &painted)?;
        Ok(())
    })?;
    time("mirror plane, once a shape", &mut |_| {
        let search = MirrorSearch::of(&surface.positions, &surface.triangles);
        search.ok_or("no extent")?.best(&[], &Task::new())?;
        Ok(())
    })
}

fn controls(stack: &mut Stack, history: &mut History, time: &mut Timer<'_>) -> Result<(), Error> {
    let (lower, upper) = (ids(history)[0], ids(history)[1]);
    let mut change = |what, layer, properties: &mut dyn FnMut(usize) -> Property| {
        time(what, &mut |i| {
            let to = properties(i);
            history.apply_live(&Action::Set { layer, to }, None)?;
            stack.evaluate(history.project());
            Ok(())
        })
    };
    let mu = |i: usize| Property::Mu(-0.2 - 0.001 * i as f64);
    let curve = |i: usize| {
        let mut curve = ScaleCurve::mid();
        curve.set_point(0.4, 1.0 + 0.01 * i as f64);
        Property::Curve(curve)
    };
    change("μ of the top layer", upper, &mut |i| mu(i))?;
    change("scale curve of the top layer", upper, &mut |i| curve(i))?;
    let set = |history: &mut History, to| history.apply(&Action::Set { layer: upper, to }, None);
    for (what, model) in [
        ("a result as the new shape, coordinate model, all scales", None),
        ("a result as the new shape, coordinate model, curved", Some(Model::Coordinate)),
        ("a result as the new shape, normal model, curved", Some(Model::Normal)),
        ("a result as the new shape, distance model, curved", Some(Model::Distance)),
    ] {
        let curve = if model.is_some() { ScaleCurve::mid() } else { ScaleCurve::flat(1.0) };
        set(history, Property::Curve(curve))?;
        set(history, Property::Model(model.unwrap_or(Model::Coordinate)))?;
        // A change below gives the top layer a new shape to start from.
        time(what, &mut |i| {
            history.apply_live(&Action::Set { layer: lower, to: mu(i) }, None)?;
            stack.evaluate(history.project());
            Ok(())
        })?;
    }
    time("a result as the new shape, terms of all three models", &mut |i| {
        history.apply_live(&Action::Set { layer: lower, to: mu(i) }, None)?;
        stack.terms(history.project(), upper);
        Ok(())
    })?;
    time("action to terms: μ of the top layer", &mut |i| {
        history.apply_live(&Action::Set { layer: upper, to: mu(i) }, None)?;
        stack.terms(history.project(), upper);
        Ok(())
    })
}

fn folds(stack: &mut Stack, history: &mut History, time: &mut Timer<'_>) -> Result<(), Error> {
    let evaluation = stack.evaluate(history.project());
    let surface = stack.surface().clone();
    let (base, moved) = (&stack.original().positions, &evaluation.result.positions);
    let displacement = evaluation.displacement();
    time("fold meter", &mut |_| {
        flipped_triangles(&surface, base, moved);
        Ok(())
    })?;
    time("as far as it goes", &mut |_| {
        furthest(&surface, base, &displacement, 1.0, 0);
        Ok(())
    })
}

/// Median and fastest of `repeats` runs in ms, after one that is not counted.
fn timed(repeats: usize, act: &mut dyn FnMut(usize) -> Result<(), Trouble>) -> Result<(f64, f64), Trouble> {
    act(0)?;
    let mut times = Vec::with_capacity(repeats);
    for i in 0..repeats {
        let start = Instant::now();
        act(i + 1)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(median_and_fastest(times))
}

/// Of at least one time.
fn median_and_fastest(mut times: Vec<f64>) -> (f64, f64) {
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], times[0])
}
