//! Without arguments, lists the sources that can be captured. With the beginning of a name and a number of
//! seconds, captures and prints the loudest amplitude of each channel: `capture [NAME SECS]`.

use chladni_sound::{Capture, capture_sources};
use std::error::Error;
use std::io::Write;
use std::time::Duration;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut out = std::io::stdout().lock();
    let sources = capture_sources()?;
    let [name, secs] = arguments.as_slice() else {
        for source in sources {
            writeln!(out, "{:?}\t{}", source.kind, source.name)?;
        }
        return Ok(());
    };
    let source = sources.iter().find(|source| source.name.starts_with(name)).ok_or("no such source")?;
    let mut capture = Capture::start(source)?;
    let (mut left, mut right) = (Vec::new(), Vec::new());
    // Seconds of sound: a busy machine may be slow to begin.
    let wanted = secs.parse::<f64>()? * f64::from(capture.rate_hz());
    while (left.len() as f64) < wanted && !capture.is_lost() {
        capture.take(&mut left, &mut right);
        std::thread::sleep(Duration::from_millis(10));
    }
    let loudest = |channel: &[f32]| channel.iter().fold(0.0f32, |a, x| a.max(x.abs()));
    let rate_hz = capture.rate_hz();
    writeln!(
        out,
        "{} frames at {rate_hz} Hz, loudest {:.3} {:.3}",
        left.len(),
        loudest(&left),
        loudest(&right)
    )?;
    Ok(())
}
