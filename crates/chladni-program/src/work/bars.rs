//! Beats and bars, as corrected by hand and as the director takes them.

use std::ops::Range;

use chladni_music::{BarLine, BeatReading, TappedBeats};
use chladni_sound::{Bar, Beats, ENERGY_RATE_HZ, Section};

/// Beats as a person wants them read.
pub fn read_beats(beats: &Beats, reading: BeatReading) -> Beats {
    let bars_secs: Vec<f64> = beats.bars.iter().map(|bar| bar.at_secs).collect();
    let factor = 2f64.powi(reading.octave) * reading.tapped.map_or(1.0, |tapped| tapped.per_found);
    let (bars, sections) = match reading.tapped {
        Some(tapped) => in_bars_of(tapped, beats),
        None => (beats.bars.clone(), beats.sections.clone()),
    };
    Beats {
        tempo_bpm: factor * beats.tempo_bpm,
        beats_secs: reading.of(&beats.beats_secs, &bars_secs),
        // Who taps them knows.
        confidence: reading.tapped.map_or(beats.confidence, |_| 1.0),
        other_octaves_bpm: beats.other_octaves_bpm.map(|bpm| factor * bpm),
        // A bar stays one, however its beats are counted.
        bars: (bars.into_iter())
            .map(|bar| Bar { at_secs: bar.at_secs + reading.shift_secs, ..bar })
            .collect(),
        sections: (sections.into_iter())
            .map(|section| Section { at_secs: section.at_secs + reading.shift_secs, ..section })
            .collect(),
        energy: beats.energy.clone(),
    }
}

/// The bars of beats that were tapped, and the sections: each begins with the nearest bar.
fn in_bars_of(tapped: TappedBeats, found: &Beats) -> (Vec<Bar>, Vec<Section>) {
    let firsts = tapped.among(&found.beats_secs).into_iter().filter(|(place, _)| *place == 0);
    let bars: Vec<Bar> = firsts.map(|(_, at_secs)| Bar { at_secs, beats: 4 }).collect();
    let nearest = |secs: f64| {
        let begin = bars.iter().map(|bar| bar.at_secs);
        begin.min_by(|a, b| (a - secs).abs().total_cmp(&(b - secs).abs()))
    };
    let sections = found.sections.iter();
    let mut sections: Vec<Section> = sections
        .filter_map(|section| Some(Section { at_secs: nearest(section.at_secs)?, ..*section }))
        .collect();
    sections.dedup_by_key(|section| section.at_secs);
    (bars, sections)
}

/// The bars of a song, as a director gets them.
pub fn bar_lines(beats: &Beats) -> impl Iterator<Item = BarLine> {
    bar_lines_among(beats, 0..beats.bars.len())
}

/// Those of the bars with these numbers; the others cost nothing.
pub fn bar_lines_among(beats: &Beats, numbers: Range<usize>) -> impl Iterator<Item = BarLine> {
    let bars = &beats.bars;
    // The last bar goes on as the one before it: its beats are those that were found, whatever the tempo is read as.
    let last_beat_secs = match bars.as_slice() {
        [.., before, last] => (last.at_secs - before.at_secs) / f64::from(before.beats.max(1)),
        _ if beats.tempo_bpm > 0.0 => 60.0 / beats.tempo_bpm,
        _ => 0.5,
    };
    bars.iter().enumerate().take(numbers.end).skip(numbers.start).map(move |(i, bar)| {
        let next = bars.get(i + 1).map(|next| next.at_secs - bar.at_secs);
        let secs = next.unwrap_or(f64::from(bar.beats) * last_beat_secs);
        let middle = ((bar.at_secs + 0.5 * secs) * ENERGY_RATE_HZ).round().max(0.0) as usize;
        let energy = beats.energy.get(middle).or(beats.energy.last()).copied().unwrap_or(0.5);
        let before = beats.sections.partition_point(|section| section.at_secs < bar.at_secs);
        let begins_section = beats.sections.get(before).is_some_and(|next| next.at_secs == bar.at_secs);
        BarLine { at_secs: bar.at_secs, secs, energy, begins_section }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beats_halved_fall_on_bars_after_a_pickup_and_the_last_bar_keeps_its_length() {
        let beats_secs: Vec<f64> = (0..42).map(|n| 1.0 + 0.5 * f64::from(n)).collect();
        let begins = beats_secs.iter().skip(1).step_by(4);
        let mut bars: Vec<Bar> = begins.map(|&at_secs| Bar { at_secs, beats: 4 }).collect();
        bars.last_mut().unwrap().beats = 1;
        let found = Beats { tempo_bpm: 120.0, beats_secs, confidence: 1.0, bars, ..Beats::default() };
        for octave in [-2, -1, 0, 1] {
            let read = read_beats(&found, BeatReading { octave, ..BeatReading::default() });
            assert!(read.bars.iter().all(|bar| read.beats_secs.contains(&bar.at_secs)), "{octave}");
            let last = bar_lines(&read).last().unwrap();
            assert!((last.secs - 0.5).abs() < 1e-9, "{octave}: {}", last.secs);
        }
    }

    #[test]
    fn beats_that_were_tapped_have_bars_and_sections_of_their_own() {
        let section = |at_secs, name| Section { at_secs, name, energy: 0.5 };
        let beats_secs: Vec<f64> = (0..60).map(|n| 1.0 + 0.75 * f64::from(n)).collect();
        let bars = beats_secs.iter().step_by(4).map(|&at_secs| Bar { at_secs, beats: 4 }).collect();
        let sections = vec![section(1.0, 'A'), section(22.0, 'B')];
        let found =
            Beats { tempo_bpm: 80.0, beats_secs, confidence: 0.3, bars, sections, ..Beats::default() };
        let tapped = Some(TappedBeats { per_found: 1.5, at_secs: 20.5 });
        let read = read_beats(&found, BeatReading { tapped, shift_secs: 0.25, octave: 0 });
        assert_eq!((read.tempo_bpm, read.confidence), (120.0, 1.0));
        assert!(read.beats_secs.windows(2).all(|pair| (pair[1] - pair[0] - 0.5).abs() < 1e-9));
        assert!(read.bars.iter().all(|bar| read.beats_secs.contains(&bar.at_secs) && bar.beats == 4));
        assert!(read.bars.windows(2).all(|pair| (pair[1].at_secs - pair[0].at_secs - 2.0).abs() < 1e-9));
        let begins = read.sections.iter().map(|section| section.at_secs);
        assert!(begins.zip([2.75, 22.75]).all(|(begin, expected)| (begin - expected).abs() < 1e-9));
        assert_eq!(bar_lines(&read).filter(|bar| bar.begins_section).count(), 2);
    }

    #[test]
    fn some_bars_are_as_they_are_among_all() {
        let bars = (0..9).map(|n| Bar { at_secs: 2.0 * f64::from(n), beats: 4 }).collect();
        let sections = [0.0, 6.0, 14.0].map(|at_secs| Section { at_secs, name: 'A', energy: 0.5 }).into();
        let energy = (0..200).map(|n| n as f32 / 200.0).collect();
        let beats = Beats { tempo_bpm: 120.0, bars, sections, energy, ..Beats::default() };
        let all: Vec<BarLine> = bar_lines(&beats).collect();
        let begins: Vec<bool> = all.iter().map(|bar| bar.begins_section).collect();
        assert_eq!(begins, [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|n| [0, 3, 7].contains(&n)));
        for numbers in [0..0, 0..1, 2..5, 7..9, 8..20, 12..20] {
            let some: Vec<BarLine> = bar_lines_among(&beats, numbers.clone()).collect();
            assert_eq!(some, all[numbers.start.min(9)..numbers.end.min(9)], "{numbers:?}");
        }
    }
}
