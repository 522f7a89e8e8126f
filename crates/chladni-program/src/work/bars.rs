//! Beats and bars, as corrected by hand and as the director takes them.

use chladni_music::{BarLine, BeatReading};
use chladni_sound::{Bar, Beats, ENERGY_RATE_HZ, Section};

/// Beats as a person wants them read.
pub fn read_beats(beats: &Beats, reading: BeatReading) -> Beats {
    let factor = 2f64.powi(reading.octave);
    Beats {
        tempo_bpm: factor * beats.tempo_bpm,
        beats_secs: reading.of(&beats.beats_secs),
        confidence: beats.confidence,
        other_octaves_bpm: beats.other_octaves_bpm.map(|bpm| factor * bpm),
        // A bar stays one, however its beats are counted.
        bars: beats
            .bars
            .iter()
            .map(|bar| Bar { at_secs: bar.at_secs + reading.shift_secs, ..*bar })
            .collect(),
        sections: beats
            .sections
            .iter()
            .map(|section| Section { at_secs: section.at_secs + reading.shift_secs, ..*section })
            .collect(),
        energy: beats.energy.clone(),
    }
}

/// The bars of a song, as a director gets them.
pub fn bar_lines(beats: &Beats) -> impl Iterator<Item = BarLine> {
    let bars = &beats.bars;
    bars.iter().enumerate().map(move |(i, bar)| {
        let next = bars.get(i + 1).map(|next| next.at_secs - bar.at_secs);
        let beat_secs = if beats.tempo_bpm > 0.0 { 60.0 / beats.tempo_bpm } else { 0.5 };
        let secs = next.unwrap_or(f64::from(bar.beats) * beat_secs);
        let middle = ((bar.at_secs + 0.5 * secs) * ENERGY_RATE_HZ).round().max(0.0) as usize;
        let energy = beats.energy.get(middle).or(beats.energy.last()).copied().unwrap_or(0.5);
        let begins_section = beats.sections.iter().any(|section| section.at_secs == bar.at_secs);
        BarLine { at_secs: bar.at_secs, secs, energy, begins_section }
    })
}
