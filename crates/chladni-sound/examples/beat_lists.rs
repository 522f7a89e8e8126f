//! Beats of songs by both trackers, one JSON line each: `beat_lists SONG …`.

use chladni_sound::{Beats, Song, SoundError, track_beats, track_beats_causally};
use chladni_task::Task;
use std::error::Error;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

type Tracker = fn(&Song, &Task) -> Result<Beats, SoundError>;

fn main() -> Result<(), Box<dyn Error>> {
    let mut out = std::io::stdout().lock();
    for path in std::env::args().skip(1) {
        let song = Song::open(Path::new(&path))?;
        write!(out, "{{\"song\": {path:?}, \"duration_secs\": {}", song.duration_secs())?;
        let trackers: [(&str, Tracker); 2] = [("whole", track_beats), ("causal", track_beats_causally)];
        for (name, tracker) in trackers {
            let start = Instant::now();
            let beats = tracker(&song, &Task::new())?;
            write!(
                out,
                ", \"{name}\": {{\"tempo_bpm\": {}, \"beats_secs\": {:?}, \"bars_secs\": {:?}, \"sections_secs\": {:?}, \
                 \"confidence\": {}, \"took_secs\": {}}}",
                beats.tempo_bpm,
                beats.beats_secs,
                beats.bars.iter().map(|bar| bar.at_secs).collect::<Vec<_>>(),
                beats.sections.iter().map(|section| section.at_secs).collect::<Vec<_>>(),
                beats.confidence,
                start.elapsed().as_secs_f64()
            )?;
        }
        writeln!(out, "}}")?;
    }
    Ok(())
}
