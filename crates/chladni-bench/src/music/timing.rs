//! From sound to twelve shapes, frame by frame.

use std::sync::Arc;
use std::time::Instant;

use chladni_mesh::TriMesh;
use chladni_music::{Action, Dancer, Ensemble, Form, GalleryShape, Instrument, Moment, Resonators};
use chladni_sound::{SpectrumAnalyzer, SpectrumSettings, sample_tune};
use chladni_synth::{CpuSynthesizer, FrameSettings, SynthModel, Synthesizer};
use serde::Serialize;

use super::BenchMusic;
use super::ready::Ready;
use crate::sphere::bumpy_sphere;
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, bands_of};

/// Medians per frame, in milliseconds, on the processor.
#[derive(Serialize)]
pub struct Measured {
    pub vertices: usize,
    pub harmonics: usize,
    pub items: usize,
    pub form: Form,
    pub threads: usize,
    pub spectrum_ms: f64,
    /// The bank of oscillators hears the spectrum and rings.
    pub resonators_ms: f64,
    pub mapping_ms: f64,
    pub synthesis_ms: f64,
    pub normals_ms: f64,
    pub total_ms: f64,
}

/// Measures the three forms.
pub fn measure(bench: &BenchMusic, terminal: &Terminal) -> Result<Vec<Measured>, Error> {
    let (positions, triangles) = bumpy_sphere(bench.vertices);
    let mesh = TriMesh { positions, triangles, ..TriMesh::default() };
    let Ready { body, dancer, .. } = Ready::new("bumpy sphere", &mesh, bench.harmonics, terminal)?;
    let mut synthesizer = CpuSynthesizer::new(SynthModel::new(&body)?);
    let forms = [Form::Filter, Form::Modal, Form::HalfMask];
    forms.into_iter().map(|form| bench.time(form, &dancer, &mut synthesizer)).collect()
}

impl BenchMusic {
    fn time(
        &self,
        form: Form,
        dancer: &Arc<Dancer>,
        synthesizer: &mut CpuSynthesizer,
    ) -> Result<Measured, Error> {
        let song = sample_tune();
        let settings = SpectrumSettings::new(song.rate_hz);
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: settings.bands };
        let mut instrument = Instrument::new(1, self.items, shape)?;
        instrument.apply(Moment::default(), Action::SetForm { form })?;
        let mut analyzer = SpectrumAnalyzer::new(settings)?;
        let mut ensemble = Ensemble::new(dancer.clone());
        let window = analyzer.window_frames();
        let hop = song.rate_hz as usize / 60;
        let frames = self.frames.clamp(1, (song.frames() - window) / hop);
        let mut bank = None;
        let mut times: [Vec<f64>; 6] = std::array::from_fn(|_| Vec::with_capacity(frames));
        for frame in 0..frames {
            let from = frame * hop;
            let start = Instant::now();
            let (left, right) = (&song.left[from..from + window], &song.right[from..from + window]);
            let s = analyzer.analyze(left, right, 1.0 / 60.0);
            let heard = start.elapsed().as_secs_f64();
            let timbre = instrument.parameters().playing().timbre;
            Resonators::follow(&mut bank, timbre.as_ref(), s.mid.len());
            let mut bands = bands_of(s);
            if let Some(bank) = &mut bank {
                bank.hear(&bands, 1.0 / 60.0);
                bands.ringing = Some(bank.ring(0.5 / 60.0));
            }
            let rung = start.elapsed().as_secs_f64();
            let items = ensemble.play(&instrument, &bands, chladni_music::Beat::default())?;
            let mapped = start.elapsed().as_secs_f64();
            synthesizer.synthesize_positions(items)?;
            let moved = start.elapsed().as_secs_f64();
            synthesizer.synthesize_normals(&FrameSettings::default())?;
            let lit = start.elapsed().as_secs_f64();
            let parts = [heard, rung - heard, mapped - rung, moved - mapped, lit - moved, lit];
            times.iter_mut().zip(parts).for_each(|(t, secs)| t.push(1e3 * secs));
        }
        let [spectrum_ms, resonators_ms, mapping_ms, synthesis_ms, normals_ms, total_ms] = times.map(median);
        Ok(Measured {
            vertices: synthesizer.model().vertices(),
            harmonics: dancer.harmonics(),
            items: self.items,
            form,
            threads: rayon::current_num_threads(),
            spectrum_ms,
            resonators_ms,
            mapping_ms,
            synthesis_ms,
            normals_ms,
            total_ms,
        })
    }
}

pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
