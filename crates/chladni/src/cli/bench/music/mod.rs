//! `chladni bench music`: how fast the music instrument is, and how true.

mod stereo;
mod timing;
mod truth;

use clap::Args;
use serde::Serialize;

use crate::cli::{Failure, Terminal};

/// Measure the music instrument: the time from spectrum to a whole gallery's normals; how far left
/// and right move apart; how a preset bred on one shape moves another.
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
    /// Print JSON instead of lines.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    timing: Vec<timing::Measured>,
    stereo: Vec<stereo::Stereo>,
    transfer: truth::Transfer,
}

impl BenchMusic {
    /// Measures all of it.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let timing = timing::measure(&self, terminal)?;
        let octopus = truth::Ready::sample("octopus", terminal)?;
        let head = truth::Ready::sample("head", terminal)?;
        let mut stereo = stereo::stereo(&octopus)?;
        stereo.extend(stereo::stereo(&head)?);
        let report = Report { timing, stereo, transfer: truth::transfer(&octopus, &head)? };
        if self.json {
            return terminal.json(&report);
        }
        for r in &report.timing {
            terminal.result(format_args!(
                "{:?}: n = {}, K = {}, S = {}: spectrum {:.3} ms, mapping {:.3} ms, synthesis {:.2} ms, normals {:.2} ms, \
                 together {:.2} ms",
                r.form, r.vertices, r.harmonics, r.items, r.spectrum_ms, r.mapping_ms, r.synthesis_ms, r.normals_ms, r.total_ms
            ))?;
        }
        for r in &report.stereo {
            terminal.result(format_args!(
                "{}, {:?}, tone of {:.0} Hz, {}: that half moves {:.2} times the energy of the other, outwards by {:+.2}, \
                 mirror error {:.1e}",
                r.shape, r.form, r.tone_hz, r.channel, r.energy_ratio, r.direction, r.mirror_error
            ))?;
        }
        let t = &report.transfer;
        terminal.result(format_args!(
            "{} presets bred on the octopus: displacement over the calibrated amount {:.3} to {:.3} there, {:.3} to {:.3} on \
             the head",
            t.presets, t.own[0], t.own[1], t.other[0], t.other[1]
        ))
    }
}
