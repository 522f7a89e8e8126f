//! `chladni beats`: tempo and beats of a song.

use chladni_sound::{track_beats, track_beats_causally};
use clap::Args;

use super::Terminal;
use crate::work::{Error, Watcher, source};

/// Find tempo and beats of a song.
#[derive(Args)]
pub struct Beats {
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF, Matroska) or sample:tune.
    song: String,
    /// Print beats, tempo, bars, sections and energy as JSON (docs/beats.md).
    #[arg(long)]
    json: bool,
    /// Use at each moment only what was heard by then, as the live window does.
    #[arg(long)]
    causal: bool,
}

impl Beats {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Error> {
        let song = source::long_song(&self.song, terminal)?;
        let found = terminal.watch("beats", |task| {
            if self.causal { track_beats_causally(&song, task) } else { track_beats(&song, task) }
        });
        let beats = found?;
        if self.json {
            return terminal.json(&beats);
        }
        if beats.beats_secs.is_empty() {
            return terminal.result("no beat found");
        }
        let [half, double] = beats.other_octaves_bpm;
        terminal.result(format_args!(
            "{:.1} beats per minute (or {half:.1}, or {double:.1}), {} beats, confidence {:.2}",
            beats.tempo_bpm,
            beats.beats_secs.len(),
            beats.confidence
        ))?;
        for beat in &beats.beats_secs {
            terminal.result(format_args!("{beat:.3}"))?;
        }
        Ok(())
    }
}
