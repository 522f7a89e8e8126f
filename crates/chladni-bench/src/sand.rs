//! How long a step of sand takes.

use std::sync::Arc;
use std::time::Instant;

use chladni_music::{SAND_STEP_SECS, Sand, Tray};
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, body, source};
use chladni_synth::{Coefficients, Item, Term};

/// Measure sand: a step of 1/60 s on sample shapes, with the figure changing every second.
#[derive(clap::Args)]
pub struct BenchSand {
    /// Grains.
    #[arg(long, default_value_t = 50_000)]
    grains: usize,
    /// K.
    #[arg(short = 'k', long, default_value_t = 128)]
    harmonics: usize,
}

impl BenchSand {
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        for name in ["plate", "bell", "octopus"] {
            let path = source::sample_path(name);
            let mesh = Arc::new(source::shape(&chladni_mesh::ShapeSource::named(&path), terminal)?);
            let (body, _) = body::build(name, &mesh, self.harmonics, body::laplacian(false), terminal)?;
            let mut sand = Sand::pour(Arc::new(Tray::new(&body)), self.grains, 1);
            let second = (1.0 / SAND_STEP_SECS).round() as usize;
            let mut millis: Vec<f64> = (0..10 * second)
                .map(|step| {
                    let item = tone(self.harmonics, 5 + 9 * (step / second));
                    let began = Instant::now();
                    sand.step(&item, 0.1);
                    1e3 * began.elapsed().as_secs_f64()
                })
                .collect();
            millis.sort_by(f64::total_cmp);
            let [median, late] = [0.5, 0.95].map(|share| millis[(share * millis.len() as f64) as usize]);
            terminal.result(format_args!(
                "{name}: {} vertices, {} grains: {median:.2} ms a step (median), {late:.2} ms (19 of 20)",
                body.positions.len(),
                sand.count(),
            ))?;
        }
        Ok(())
    }
}

/// A few neighboring harmonics that sound along the normals.
fn tone(harmonics: usize, first: usize) -> Item {
    let mut c = vec![0.0; harmonics];
    c.iter_mut().skip(first).zip([0.05, 0.04, 0.03, 0.03, 0.02, 0.02]).for_each(|(c, a)| *c = a);
    let coefficients = Coefficients::Normal(c);
    Item { terms: vec![Term { coefficients, residual: None, residual_gain: 0.0, mask: None }] }
}
