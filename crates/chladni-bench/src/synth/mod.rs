//! `chladni-bench synth`: the papers' frame rates, here and now.

mod clock;
mod report;
mod rows;
pub mod stage;
mod timing;

use chladni_synth::{Coefficients, CpuSynthesizer, GpuSynthesizer, Item, SynthModel, Term};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::sphere::{bumpy_sphere, waves};
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Warning, Watcher};
use report::{HEAD, Measured, Times};
use rows::{ROWS, Row};
use stage::Stage;

/// Reproduce the papers' tables of frame rates on generated shapes of the same n and K.
#[derive(Args)]
pub struct BenchSynth {
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Only these rows, such as bunny,cow.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    rows: Vec<String>,
    /// Only this backend.
    #[arg(long)]
    backend: Option<BackendName>,
    /// Draw nothing.
    #[arg(long)]
    no_draw: bool,
    /// Threads of the CPU backend; all cores if left out.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BackendName {
    Cpu,
    Gpu,
}

impl BenchSynth {
    /// Measures and prints.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let known = |name: &String| ROWS.iter().any(|row| row.model == name);
        if let Some(name) = self.rows.iter().find(|name| !known(name)) {
            let names: Vec<&str> = ROWS.iter().map(|row| row.model).collect();
            return Err(Error::input(format!(
                "--rows: no row is named {name}; there are {}",
                names.join(", ")
            )));
        }
        let mut pool = rayon::ThreadPoolBuilder::new();
        if let Some(threads) = self.threads {
            pool = pool.num_threads(threads);
        }
        let pool = pool.build().map_err(Error::other)?;
        // The CPU needs a device for drawing only.
        let cpu_only = self.no_draw && self.backend == Some(BackendName::Cpu);
        let stage = match (!cpu_only).then(Stage::new).transpose() {
            Ok(stage) => stage,
            Err(failure) if self.backend == Some(BackendName::Gpu) => return Err(failure),
            Err(failure) => {
                terminal.warn(Warning::of("nothing is drawn, and only the CPU measured", failure));
                None
            }
        };
        let rows: Vec<&Row> = ROWS
            .iter()
            .filter(|row| self.rows.is_empty() || self.rows.iter().any(|name| name == row.model))
            .collect();
        if !self.json {
            terminal.result(HEAD)?;
        }
        let measured = pool.install(|| self.measure(terminal, &rows, stage))?;
        if self.json { terminal.json(&measured) } else { Ok(()) }
    }

    fn measure(
        &self,
        terminal: &Terminal,
        rows: &[&Row],
        mut stage: Option<Stage>,
    ) -> Result<Vec<Measured>, Error> {
        let mut measured = Vec::new();
        for row in rows {
            let (positions, triangles) = bumpy_sphere(row.vertices);
            let basis = waves(&positions, row.harmonics);
            let model = SynthModel::from_parts(&positions, &triangles, &basis)?;
            drop(basis);
            for backend in [BackendName::Cpu, BackendName::Gpu] {
                if self.backend.is_some_and(|only| only != backend) {
                    continue;
                }
                for (items, times) in
                    self.measure_row(terminal, row, backend, &model, &triangles, stage.as_mut())?
                {
                    let published = row.published.iter().find(|(count, _)| *count == items);
                    let published = published.map(|(_, fps)| *fps).filter(|fps| !fps.is_nan());
                    let line = times.report(row, items, backend, published, &model);
                    if !self.json {
                        terminal.result(line.line())?;
                    }
                    measured.push(line);
                }
            }
        }
        Ok(measured)
    }

    /// The times of a row on a backend for each number of items.
    fn measure_row(
        &self,
        terminal: &Terminal,
        row: &Row,
        backend: BackendName,
        model: &SynthModel,
        triangles: &[[u32; 3]],
        mut stage: Option<&mut Stage>,
    ) -> Result<Vec<(usize, Times)>, Error> {
        let mut measured = Vec::new();
        let bytes = model.basis_bytes();
        match (backend, &mut stage) {
            (BackendName::Cpu, stage) => {
                let copy = timing::copy_secs(bytes)?;
                let mut synthesizer = CpuSynthesizer::new(model.clone());
                for &(count, _) in row.published {
                    check(terminal)?;
                    let stage = stage.as_deref_mut().filter(|_| !self.no_draw);
                    let items = items_of(row, count);
                    let times = timing::on_cpu(&mut synthesizer, &items, triangles, stage, copy)?;
                    measured.push((count, times));
                }
            }
            (BackendName::Gpu, Some(stage)) => {
                let copy = timing::copy_on_device_secs(&stage.gpu, bytes)?;
                let mut synthesizer = match GpuSynthesizer::new(stage.gpu.synthesis(), model.clone()) {
                    Ok(synthesizer) => synthesizer,
                    Err(error) => {
                        terminal.warn(Warning::of(row.model, error));
                        return Ok(measured);
                    }
                };
                for &(count, _) in row.published {
                    check(terminal)?;
                    let items = items_of(row, count);
                    let draw = !self.no_draw;
                    let times = timing::on_gpu(&mut synthesizer, &items, triangles, stage, draw, copy)?;
                    measured.push((count, times));
                }
            }
            (BackendName::Gpu, None) => {}
        }
        Ok(measured)
    }
}

fn check(terminal: &Terminal) -> Result<(), Error> {
    if terminal.task().is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
}

/// Items that give every harmonic weight.
fn items_of(row: &Row, count: usize) -> Vec<Item> {
    (0..count)
        .map(|s| {
            let weight = |k: usize, c: usize| 0.05 * ((k + 7 * s + 3 * c) as f32).sin() / (1.0 + k as f32);
            let coefficients =
                Coefficients::Vector((0..row.harmonics).map(|k| [0, 1, 2].map(|c| weight(k, c))).collect());
            Item { terms: vec![Term { coefficients, residual: None, residual_gain: 0.0, mask: None }] }
        })
        .collect()
}
