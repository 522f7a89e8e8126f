//! `chladni bench music`: from sound to twelve shapes, frame by frame.

use std::sync::Arc;
use std::time::Instant;

use chladni_mesh::TriMesh;
use chladni_music::{Action, Bands, Dancer, Ensemble, Form, GalleryShape, Instrument, Moment, Symmetry};
use chladni_sound::{SpectrumAnalyser, SpectrumSettings, sample_tune};
use chladni_synth::{CpuSynthesizer, FrameSettings, SynthModel, Synthesizer};
use clap::Args;
use serde::Serialize;

use super::sphere::bumpy_sphere;
use crate::cli::inputs::build_body;
use crate::cli::{Failure, Terminal};

/// Measure the music instrument: spectrum, mapping, synthesis and normals of a whole gallery.
#[derive(Args)]
pub struct BenchMusic {
    /// Vertices of the generated shape.
    #[arg(long, default_value_t = 25_000)]
    vertices: usize,
    /// Harmonics K.
    #[arg(short = 'k', long, default_value_t = 512)]
    harmonics: usize,
    /// Items S: 6, 9, 12 or 16.
    #[arg(long, default_value_t = 12)]
    items: usize,
    /// Frames measured.
    #[arg(long, default_value_t = 100)]
    frames: usize,
    /// Print JSON instead of lines.
    #[arg(long)]
    json: bool,
}

/// Medians per frame, in milliseconds, on the processor.
#[derive(Serialize)]
struct Measured {
    vertices: usize,
    harmonics: usize,
    items: usize,
    form: Form,
    threads: usize,
    spectrum_ms: f64,
    mapping_ms: f64,
    synthesis_ms: f64,
    normals_ms: f64,
    total_ms: f64,
}

impl BenchMusic {
    /// Measures the three forms.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let (positions, triangles) = bumpy_sphere(self.vertices);
        let mesh = TriMesh { positions, triangles, ..TriMesh::default() };
        let (body, _) = build_body("bumpy sphere", &mesh, self.harmonics, terminal)?;
        let symmetry =
            terminal.watch("finding the mirror", |task| Symmetry::of(&body, task)).map_err(Failure::other)?;
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes).map_err(Failure::other)?);
        let mut synthesizer = CpuSynthesizer::new(SynthModel::new(&body).map_err(Failure::other)?);
        let mut rows = Vec::new();
        for form in [Form::Filter, Form::Modal, Form::HalfMask] {
            rows.push(self.measure(form, &dancer, &mut synthesizer)?);
        }
        if self.json {
            return terminal.json(&rows);
        }
        rows.iter().try_for_each(|r| {
            terminal.result(format_args!(
                "{:?}: n = {}, K = {}, S = {}: spectrum {:.3} ms, mapping {:.3} ms, synthesis {:.2} ms, normals {:.2} ms, \
                 together {:.2} ms",
                r.form, r.vertices, r.harmonics, r.items, r.spectrum_ms, r.mapping_ms, r.synthesis_ms, r.normals_ms, r.total_ms
            ))
        })
    }

    fn measure(
        &self,
        form: Form,
        dancer: &Arc<Dancer>,
        synthesizer: &mut CpuSynthesizer,
    ) -> Result<Measured, Failure> {
        let song = sample_tune();
        let settings = SpectrumSettings::new(song.rate_hz);
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: settings.bands };
        let mut instrument = Instrument::new(1, self.items, shape).map_err(Failure::input)?;
        instrument.apply(Moment::default(), Action::SetForm { form }).map_err(Failure::other)?;
        let mut analyser = SpectrumAnalyser::new(settings).map_err(Failure::other)?;
        let mut ensemble = Ensemble::new(dancer.clone());
        let window = analyser.window_frames();
        let hop = song.rate_hz as usize / 60;
        let frames = self.frames.clamp(1, (song.frames() - window) / hop);
        let mut times: [Vec<f64>; 5] = std::array::from_fn(|_| Vec::with_capacity(frames));
        for frame in 0..frames {
            let from = frame * hop;
            let start = Instant::now();
            let (left, right) = (&song.left[from..from + window], &song.right[from..from + window]);
            let s = analyser.analyse(left, right, 1.0 / 60.0);
            let heard = start.elapsed().as_secs_f64();
            let bands = Bands { left: &s.left, right: &s.right, mid: &s.mid, side: &s.side };
            let items =
                ensemble.play(&instrument, &bands, chladni_music::Beat::default()).map_err(Failure::other)?;
            let mapped = start.elapsed().as_secs_f64();
            synthesizer.synthesize_positions(items).map_err(Failure::other)?;
            let moved = start.elapsed().as_secs_f64();
            synthesizer.synthesize_normals(&FrameSettings::default()).map_err(Failure::other)?;
            let lit = start.elapsed().as_secs_f64();
            let parts = [heard, mapped - heard, moved - mapped, lit - moved, lit];
            times.iter_mut().zip(parts).for_each(|(t, secs)| t.push(1e3 * secs));
        }
        let [spectrum_ms, mapping_ms, synthesis_ms, normals_ms, total_ms] = times.map(median);
        Ok(Measured {
            vertices: synthesizer.model().vertices(),
            harmonics: dancer.harmonics(),
            items: self.items,
            form,
            threads: rayon::current_num_threads(),
            spectrum_ms,
            mapping_ms,
            synthesis_ms,
            normals_ms,
            total_ms,
        })
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
