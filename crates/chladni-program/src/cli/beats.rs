//! `chladni beats`: tempo and beats of a song.

use std::path::PathBuf;

use chladni_sound::{track_beats, track_beats_causally};
use clap::Args;

use super::Terminal;
use crate::work::{Error, Watcher, source};

/// Find tempo and beats of a song.
#[derive(Args)]
pub struct Beats {
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF, Matroska) or sample:tune.
    song: PathBuf,
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
        terminal.result(in_short(&beats))?;
        for beat in &beats.beats_secs {
            terminal.result(format_args!("{beat:.3}"))?;
        }
        Ok(())
    }
}

/// Tempo and number of the beats in one line.
fn in_short(found: &chladni_sound::Beats) -> String {
    let (bpm, [half, double], count) = (found.tempo_bpm, found.other_octaves_bpm, found.beats_secs.len());
    if bpm == 0.0 {
        return format!("too few beats for a tempo: {count}");
    }
    let confidence = found.confidence;
    format!(
        "{bpm:.1} beats per minute (or {half:.1}, or {double:.1}), {count} beats, confidence {confidence:.2}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_beat_has_no_tempo() {
        let beats_secs = vec![0.5, 1.0];
        let mut found = chladni_sound::Beats { tempo_bpm: 120.0, beats_secs, ..Default::default() };
        assert!(in_short(&found).starts_with("120.0 beats per minute (or "));
        (found.tempo_bpm, found.beats_secs) = (0.0, vec![0.5]);
        assert_eq!(in_short(&found), "too few beats for a tempo: 1");
    }
}
