//! A whole frame of a gallery on which sand lies, up to what is drawn.

use std::sync::Arc;
use std::time::Instant;

use chladni_music::{Action, Ensemble, GalleryShape, Instrument, Moment, Parameter, Stretch, Switch};
use chladni_sound::sample_tune;
use chladni_synth::{CpuSynthesizer, SynthModel, Synthesizer};
use chladni_view::Look;
use serde::Serialize;

use super::BenchMusic;
use super::ready::Ready;
use super::timing::median;
use chladni_program::cli::Terminal;
use chladni_program::work::{Error, Hearing, KnownSong, SandTable, source};

/// Frames a second; sand takes two steps in each.
const RATE_HZ: f64 = 30.0;
/// Where in the tune it begins: the sand lies by then.
const FROM_SECS: f64 = 4.0;
/// All dances together have so many.
const GRAINS: f32 = 50_000.0;

/// Medians per frame, in milliseconds, on the processor.
#[derive(Serialize)]
pub struct Frame {
    pub shape: String,
    pub vertices: usize,
    pub harmonics: usize,
    pub items: usize,
    pub grains: usize,
    pub threads: usize,
    /// Steps of the sand, with the spectra, oscillators and mappings at their times.
    pub sand_ms: f64,
    /// Spectrum and oscillators of the frame itself.
    pub sound_ms: f64,
    pub mapping_ms: f64,
    pub synthesis_ms: f64,
    pub normals_ms: f64,
    /// Where the grains are drawn.
    pub grains_ms: f64,
    pub total_ms: f64,
}

/// Measures a gallery of octopuses with sand, and without.
pub fn measure(bench: &BenchMusic, terminal: &Terminal) -> Result<Vec<Frame>, Error> {
    let name = "octopus";
    let mesh = source::mesh(source::sample_path(name), terminal)?;
    let octopus = Ready::new(name, &mesh, bench.harmonics, terminal)?;
    [false, true].into_iter().map(|sand| bench.frame(&octopus, sand)).collect()
}

impl BenchMusic {
    fn frame(&self, Ready { name, body, dancer }: &Ready, sand: bool) -> Result<Frame, Error> {
        let bands = Parameter::Bands.initial() as usize;
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands };
        let mut instrument = Instrument::new(1, self.items, shape)?;
        for action in [
            Action::Switch { switch: Switch::Sand, on: sand },
            Action::Set { parameter: Parameter::Grains, value: GRAINS },
        ] {
            instrument.apply(Moment::default(), action)?;
        }
        let mut hearing = Hearing::default();
        hearing.know(0, KnownSong::new(Arc::new(sample_tune())).map_err(Error::other)?);
        hearing.tune(0.0, instrument.parameters());
        let song =
            Stretch { at_secs: 0.0, song: Some(0), song_secs: 0.0, playing: true, crossfade_secs: 0.0 };
        hearing.begin(song).map_err(Error::other)?;
        let (mut ensemble, mut table) =
            (Ensemble::new(Arc::clone(dancer)), SandTable::new(body.clone(), 0.0));
        let mut synthesizer = CpuSynthesizer::new(SynthModel::new(body)?);
        let settings = instrument.parameters().frame_settings();
        table.follow(&mut hearing, &mut ensemble, &instrument, None, FROM_SECS)?;
        let (mut times, mut grains) = ([const { Vec::new() }; 7], 0);
        for frame in 1..=self.frames {
            let at_secs = FROM_SECS + frame as f64 / RATE_HZ;
            let start = Instant::now();
            let mut passed = 0.0;
            let mut lap = |start: &Instant| {
                let (now, before) = (start.elapsed().as_secs_f64(), passed);
                passed = now;
                now - before
            };
            table.follow(&mut hearing, &mut ensemble, &instrument, None, at_secs)?;
            let strewn = lap(&start);
            let heard = hearing.hear(at_secs).map_err(Error::other)?;
            let heard = heard.ok_or_else(|| Error::input("the tune is too short for so many frames"))?;
            let sounded = lap(&start);
            let items = ensemble.play(&instrument, &heard.bands, heard.beat)?;
            let mapped = lap(&start);
            synthesizer.synthesize_positions(items)?;
            let moved = lap(&start);
            synthesizer.synthesize_normals(&settings)?;
            let lit = lap(&start);
            grains = table.drawn(&Look::AURORA).iter().map(|sand| sand.grains.len()).sum();
            let parts = [strewn, sounded, mapped, moved, lit, lap(&start), start.elapsed().as_secs_f64()];
            times.iter_mut().zip(parts).for_each(|(t, secs)| t.push(1e3 * secs));
        }
        let [sand_ms, sound_ms, mapping_ms, synthesis_ms, normals_ms, grains_ms, total_ms] =
            times.map(median);
        Ok(Frame {
            shape: name.clone(),
            vertices: synthesizer.model().vertices(),
            harmonics: dancer.harmonics(),
            items: self.items,
            grains,
            threads: rayon::current_num_threads(),
            sand_ms,
            sound_ms,
            mapping_ms,
            synthesis_ms,
            normals_ms,
            grains_ms,
            total_ms,
        })
    }
}
