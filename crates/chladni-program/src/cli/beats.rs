//! `chladni beats`: tempo and beats of a song.

use chladni_sound::{track_beats, track_beats_causally};
use clap::Args;

use super::inputs::open_song;
use super::{Failure, Terminal};

/// Find tempo and beats of a song.
#[derive(Args)]
pub struct Beats {
    /// A song (WAV, FLAC, MP3, Ogg Vorbis, Opus, M4A, AIFF) or sample:tune.
    song: String,
    /// Print `tempo_bpm`, `beats_secs` and `confidence` as JSON.
    #[arg(long)]
    json: bool,
    /// Use at each moment only what was heard by then, as the live window does.
    #[arg(long)]
    causal: bool,
}

impl Beats {
    /// Runs the command.
    pub fn run(self, terminal: &Terminal) -> Result<(), Failure> {
        let song = open_song(&self.song, 0.0, None, terminal)?;
        let found = terminal.watch("beats", |task| {
            if self.causal { track_beats_causally(&song, task) } else { track_beats(&song, task) }
        });
        let beats = found.map_err(sound_failure)?;
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

/// Cancelling is not the song's fault; everything else that reading reports is.
pub(super) fn sound_failure(error: chladni_sound::SoundError) -> Failure {
    match error {
        chladni_sound::SoundError::Cancelled(cancelled) => cancelled.into(),
        chladni_sound::SoundError::Write { .. } | chladni_sound::SoundError::Device { .. } => {
            Failure::other(error)
        }
        other => Failure::input(other),
    }
}
