//! Scores both trackers: `beat_scores SONG TRUTH [SONG TRUTH …]`, one line each with the
//! tempo, the F-measure with the whole song known, and the F-measure while listening.

use chladni_sound::{Song, beat_score, track_beats, track_beats_causally};
use chladni_task::Task;
use std::error::Error;
use std::io::Write;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut out = std::io::stdout().lock();
    for pair in arguments.chunks_exact(2) {
        let song = Song::open(Path::new(&pair[0]))?;
        let text = std::fs::read_to_string(&pair[1])?;
        let truth: Vec<f64> = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .filter_map(|line| line.split_whitespace().next()?.parse().ok())
            .collect();
        let gaps = truth.last().zip(truth.first()).map(|(b, a)| b - a).unwrap_or(0.0);
        let true_bpm = 60.0 * (truth.len().saturating_sub(1)) as f64 / gaps;
        let whole = track_beats(&song, &Task::new())?;
        let causal = track_beats_causally(&song, &Task::new())?;
        // What a listener announces in the first five seconds is still a guess.
        let later = |beats: &[f64]| beats.iter().copied().filter(|b| *b > 5.0).collect::<Vec<_>>();
        writeln!(
            out,
            "{:34} true {:6.1}  whole {:6.1} bpm F {:.3} conf {:.2}  causal {:6.1} bpm F {:.3} (after 5 s {:.3}) conf {:.2}",
            Path::new(&pair[0]).file_stem().unwrap_or_default().to_string_lossy(),
            true_bpm,
            whole.tempo_bpm,
            beat_score(&whole.beats_secs, &truth, 0.07).f_measure,
            whole.confidence,
            causal.tempo_bpm,
            beat_score(&causal.beats_secs, &truth, 0.07).f_measure,
            beat_score(&later(&causal.beats_secs), &later(&truth), 0.07).f_measure,
            causal.confidence,
        )?;
    }
    Ok(())
}
