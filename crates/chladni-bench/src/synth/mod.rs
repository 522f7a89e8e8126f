//! `chladni-bench synth`: the papers' frame rates, here and now.

mod clock;
mod report;
mod rows;
mod timing;

use chladni_synth::{Coefficients, CpuPath, CpuSynthesizer, GpuSynthesizer, Item, SynthModel, Term};
use chladni_view::Gpu;
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::sphere::{bumpy_sphere, waves};
use crate::easel::Easel;
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Warning, Watcher};
use report::{HEAD, Measured, Times};
use rows::{ROWS, Row};

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
    /// Instructions of the CPU backend, such as avx2; the fastest if left out.
    #[arg(long, value_name = "NAME", value_parser = path)]
    path: Option<CpuPath>,
}

/// The instructions of this name, if this processor has them.
fn path(name: &str) -> Result<CpuPath, Error> {
    let available = CpuPath::available();
    available.iter().copied().find(|path| path.to_string().eq_ignore_ascii_case(name)).ok_or_else(|| {
        let names: Vec<String> = available.iter().map(ToString::to_string).collect();
        Error::input(format!("this processor has {}", names.join(", ")))
    })
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
        let easel = (!self.no_draw).then(Easel::new).transpose()?;
        let graphics = self.graphics(terminal, easel.as_ref())?;
        let rows: Vec<&Row> = ROWS
            .iter()
            .filter(|row| self.rows.is_empty() || self.rows.iter().any(|name| name == row.model))
            .collect();
        if !self.json {
            terminal.result(HEAD)?;
        }
        let measured = pool.install(|| self.measure(terminal, &rows, easel, graphics.as_ref()))?;
        if self.json { terminal.json(&measured) } else { Ok(()) }
    }

    /// The graphics device that synthesizes: the one that draws, else any, even in software. `None` where only the
    /// CPU is asked for, and, with a warning, where there is no device but the CPU may be measured.
    fn graphics(&self, terminal: &Terminal, easel: Option<&Easel>) -> Result<Option<Gpu>, Error> {
        if self.backend == Some(BackendName::Cpu) {
            return Ok(None);
        }
        let drawing = easel.and_then(|easel| easel.device.gpu()).cloned();
        match drawing.map_or_else(Gpu::headless, Ok) {
            Ok(gpu) => Ok(Some(gpu)),
            Err(failure) if self.backend == Some(BackendName::Gpu) => Err(failure.into()),
            Err(failure) => {
                terminal.warn(Warning::of("only the CPU is measured", failure));
                Ok(None)
            }
        }
    }

    fn measure(
        &self,
        terminal: &Terminal,
        rows: &[&Row],
        mut easel: Option<Easel>,
        graphics: Option<&Gpu>,
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
                let times = match (backend, graphics) {
                    (BackendName::Cpu, _) => {
                        self.cpu_row(terminal, row, &model, &triangles, easel.as_mut())?
                    }
                    (BackendName::Gpu, Some(graphics)) => {
                        gpu_row(terminal, row, &model, &triangles, easel.as_mut(), graphics)?
                    }
                    (BackendName::Gpu, None) => Vec::new(),
                };
                for (items, times) in times {
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

    /// The times of a row on the CPU for each number of items.
    fn cpu_row(
        &self,
        terminal: &Terminal,
        row: &Row,
        model: &SynthModel,
        triangles: &[[u32; 3]],
        mut easel: Option<&mut Easel>,
    ) -> Result<Vec<(usize, Times)>, Error> {
        let copy = timing::copy_secs(model.basis_bytes())?;
        let mut synthesizer = match self.path {
            None => CpuSynthesizer::new(model.clone()),
            Some(path) => CpuSynthesizer::with_path(model.clone(), path)
                .ok_or_else(|| Error::input(format!("this processor does not have {path}")))?,
        };
        let mut measured = Vec::new();
        for &(count, _) in row.published {
            check(terminal)?;
            let items = items_of(row, count);
            let easel = easel.as_deref_mut();
            measured.push((count, timing::on_cpu(&mut synthesizer, &items, triangles, easel, copy)?));
        }
        Ok(measured)
    }
}

/// The times of a row on a graphics device for each number of items; drawn only where the same device draws.
fn gpu_row(
    terminal: &Terminal,
    row: &Row,
    model: &SynthModel,
    triangles: &[[u32; 3]],
    easel: Option<&mut Easel>,
    gpu: &Gpu,
) -> Result<Vec<(usize, Times)>, Error> {
    let copy = timing::copy_on_device_secs(gpu, model.basis_bytes())?;
    let mut measured = Vec::new();
    let mut synthesizer = match GpuSynthesizer::new(gpu.synthesis(), model.clone()) {
        Ok(synthesizer) => synthesizer,
        Err(error) => {
            terminal.warn(Warning::of(row.model, error));
            return Ok(measured);
        }
    };
    let mut easel = easel.filter(|easel| easel.device.gpu().is_some());
    for &(count, _) in row.published {
        check(terminal)?;
        let (items, easel) = (items_of(row, count), easel.as_deref_mut());
        measured.push((count, timing::on_gpu(&mut synthesizer, &items, triangles, gpu, easel, copy)?));
    }
    Ok(measured)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_one_that_this_processor_has() {
        assert_eq!(path("Portable").unwrap(), CpuPath::Portable);
        let refused = path("abacus").unwrap_err().to_string();
        assert!(refused.contains("portable"), "{refused}");
    }
}
