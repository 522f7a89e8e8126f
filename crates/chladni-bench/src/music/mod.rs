//! `chladni-bench music`: how fast the music instrument is, and how true.

mod frame;
pub mod gallery;
pub mod ready;
mod stereo;
mod timing;
mod truth;

use clap::Args;
use serde::Serialize;

use chladni_program::cli::Terminal;
use chladni_program::work::Error;

/// Measure the music instrument: the time from spectrum to a whole gallery's normals; how far left
/// and right move apart; how a preset bred on one shape moves another; whether all of a gallery moves and
/// none of it turns over.
#[derive(Args)]
pub struct BenchMusic {
    /// Vertices of the generated shape that is timed.
    #[arg(long, default_value_t = 25_000)]
    vertices: usize,
    /// Harmonics K of it.
    #[arg(short = 'k', long, default_value_t = 512)]
    harmonics: usize,
    /// Items S: 6, 9, 12 or 16.
    #[arg(long, default_value_t = 12)]
    items: usize,
    /// Frames measured.
    #[arg(long, default_value_t = 100)]
    frames: usize,
    /// A mesh, beside octopus and head, on which galleries are measured; may be given several times.
    #[arg(long, value_name = "MESH")]
    shape: Vec<String>,
    /// A song, beside sample:tune, to which they move; may be given several times.
    #[arg(long, value_name = "SONG")]
    song: Vec<String>,
    /// Print JSON instead of lines.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    timing: Vec<timing::Measured>,
    frames: Vec<frame::Frame>,
    stereo: Vec<stereo::Stereo>,
    transfer: truth::Transfer,
    folds: Vec<gallery::Folds>,
    movement: Vec<gallery::Movement>,
}

impl BenchMusic {
    /// Measures all of it.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let timing = timing::measure(&self, terminal)?;
        let frames = frame::measure(&self, terminal)?;
        let octopus = ready::Ready::sample("octopus", terminal)?;
        let head = ready::Ready::sample("head", terminal)?;
        let mut stereo = stereo::stereo(&octopus)?;
        stereo.extend(stereo::stereo(&head)?);
        let transfer = truth::transfer(&octopus, &head)?;
        let mut report = Report { timing, frames, stereo, transfer, folds: Vec::new(), movement: Vec::new() };
        let songs = gallery::songs(&[vec!["sample:tune".to_owned()], self.song].concat(), terminal)?;
        let files = self.shape.iter().map(|file| gallery::shape(file, terminal));
        for ready in [Ok(octopus), Ok(head)].into_iter().chain(files) {
            let ready = ready?;
            report.folds.extend(gallery::folds(&ready)?);
            report.movement.extend(gallery::movement(&ready, &songs)?);
        }
        if self.json {
            return terminal.json(&report);
        }
        for r in &report.timing {
            terminal.result(format_args!(
                "{:?}: n = {}, K = {}, S = {}: spectrum {:.3} ms, resonators {:.3} ms, mapping {:.3} ms, synthesis {:.2} ms, normals {:.2} ms, \
                 together {:.2} ms",
                r.form, r.vertices, r.harmonics, r.items, r.spectrum_ms, r.resonators_ms, r.mapping_ms, r.synthesis_ms, r.normals_ms, r.total_ms
            ))?;
        }
        for r in &report.frames {
            terminal.result(format_args!(
                "{}: n = {}, K = {}, S = {}, {} grains: sand {:.2} ms, sound {:.2} ms, mapping {:.2} ms, synthesis {:.2} ms, normals {:.2} ms, \
                 grains to draw {:.2} ms, together {:.2} ms",
                r.shape, r.vertices, r.harmonics, r.items, r.grains, r.sand_ms, r.sound_ms, r.mapping_ms, r.synthesis_ms, r.normals_ms,
                r.grains_ms, r.total_ms
            ))?;
        }
        for r in &report.stereo {
            terminal.result(format_args!(
                "{}, {:?}, tone of {:.0} Hz, {}: that half moves {:.2} times the energy of the other, outwards by {:+.2}, \
                 mirror error {:.1e}",
                r.shape, r.form, r.tone_hz, r.channel, r.energy_ratio, r.direction, r.mirror_error
            ))?;
        }
        for r in &report.folds {
            terminal.result(format_args!(
                "{}, {:?}, {} gallery: {:.3} % of {} triangles turned over by all bands at full scale, {:.3} % by one",
                r.shape, r.form, r.gallery, 100.0 * r.all_bands, r.triangles, 100.0 * r.one_band
            ))?;
        }
        for r in &report.movement {
            terminal.result(format_args!(
                "{}, {} gallery: the least moved item goes {:.2} as far as the median one, changes {:.2} as much, and the \
                 least turned one turns its normals {:.2} as far",
                r.shape, r.gallery, r.least, r.least_change, r.least_turn
            ))?;
        }
        let t = &report.transfer;
        terminal.result(format_args!(
            "{} presets bred on the octopus move the head {:.2} to {:.2} times as far to the sample tune (median {:.2})",
            t.presets, t.ratio[0], t.ratio[2], t.ratio[1]
        ))
    }
}
