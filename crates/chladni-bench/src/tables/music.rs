//! A row of the music paper's table: harmonics and symmetry once, then galleries of 1, 6 and 12.

use std::time::Instant;

use chladni_music::{Beat, Ensemble, GalleryShape, Instrument, Moment, PAPER_MODE};
use chladni_sound::{SpectrumAnalyzer, SpectrumSettings, sample_tune};
use chladni_synth::SynthModel;
use serde::Serialize;

use super::frame::Projector;
use super::{BenchTables, median_ms};
use crate::easel::Easel;
use chladni_program::cli::Terminal;
use chladni_program::work::dancer::{Dancing, classes};
use chladni_program::work::source;
use chladni_program::work::{Error, Watcher, bands_of};

/// Frame rates of the sizes of gallery that the paper prints.
const SIZES: [usize; 3] = [1, 6, 12];

#[derive(Serialize)]
pub struct Row {
    mesh: String,
    vertices: usize,
    harmonics: usize,
    items: usize,
    /// Harmonics and their classes.
    preprocess_secs: f64,
    /// Spectrum and mapping.
    mapping_ms: f64,
    synthesis_ms: f64,
    normals_ms: f64,
    drawing_ms: f64,
    fps: f64,
}

impl BenchTables {
    pub fn music_rows(
        &self,
        name: &str,
        harmonics: usize,
        easel: &mut Easel,
        terminal: &Terminal,
    ) -> Result<Vec<Row>, Error> {
        let mesh = source::mesh(name, terminal)?;
        let (body, solved_secs) = self.solve(name, &mesh, harmonics, terminal)?;
        let start = Instant::now();
        let symmetry = terminal.watch("finding the mirror", |task| classes(&body, self.paper, task))?;
        let Dancing { body, dancer, .. } =
            Dancing::new(&body, symmetry, &chladni_mesh::Orientation::default())?;
        let preprocess_secs = solved_secs + start.elapsed().as_secs_f64();
        let model = SynthModel::new(&body)?;
        let mut projector = Projector::new(easel, &model, &body.triangles)?;
        let song = sample_tune();
        let mut rows = Vec::new();
        for items in SIZES {
            let settings = SpectrumSettings::new(song.rate_hz);
            let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: settings.bands };
            // One is an item on stage of the smallest gallery.
            let mut instrument = Instrument::new(1, items.max(6), shape)?;
            for action in PAPER_MODE {
                instrument.apply(Moment::default(), action)?;
            }
            let mut analyzer = SpectrumAnalyzer::new(settings)?;
            let mut ensemble = Ensemble::new(dancer.clone());
            let (window, hop) = (analyzer.window_frames(), song.rate_hz as usize / 20);
            let mut parts: [Vec<f64>; 5] = std::array::from_fn(|_| Vec::new());
            for frame in 0..=self.frames.max(1) {
                let from = (frame * hop).min(song.frames().saturating_sub(window));
                let start = Instant::now();
                let (left, right) = (&song.left[from..from + window], &song.right[from..from + window]);
                let s = analyzer.analyze(left, right, 0.05);
                let played = ensemble.play(&instrument, &bands_of(s), Beat::default())?;
                let mapped = start.elapsed().as_secs_f64();
                let secs = projector.show(easel, &played[..items.min(played.len())])?;
                let total = start.elapsed().as_secs_f64();
                // The first one warms up.
                if frame > 0 {
                    let measured = [mapped, secs.synthesis, secs.normals, secs.drawing, total];
                    parts.iter_mut().zip(measured).for_each(|(part, secs)| part.push(secs));
                }
            }
            let [mapping_ms, synthesis_ms, normals_ms, drawing_ms, total_ms] = parts.map(median_ms);
            rows.push(Row {
                mesh: name.to_owned(),
                vertices: body.basis.vertices(),
                harmonics: body.basis.harmonics(),
                items,
                preprocess_secs,
                mapping_ms,
                synthesis_ms,
                normals_ms,
                drawing_ms,
                fps: 1e3 / total_ms,
            });
        }
        Ok(rows)
    }
}
