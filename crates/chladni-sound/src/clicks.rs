//! Clicks at known times, to which a person taps.

use crate::Song;

/// Initial amplitude, pitch and decay of a click.
const LEVEL: f32 = 0.7;
const TONE_HZ: f32 = 2_000.0;
const FADE_SECS: f32 = 0.006;

/// A song of `count` clicks, one in the middle of each period: it can be repeated without an end.
#[must_use]
pub fn clicks(rate_hz: u32, period_secs: f64, count: usize) -> Song {
    let period = period_secs.max(0.0) * f64::from(rate_hz);
    let frames = (period * count as f64).round() as usize;
    let mut left = vec![0.0f32; frames];
    for click in 0..count {
        let begins = ((click as f64 + 0.5) * period).round() as usize;
        let Some(rest) = left.get_mut(begins..) else { break };
        for (n, sample) in rest.iter_mut().enumerate().take(rate_hz as usize / 20) {
            let secs = n as f32 / rate_hz as f32;
            // It begins at its loudest: what is heard first is what is tapped to.
            *sample = LEVEL * (std::f32::consts::TAU * TONE_HZ * secs).cos() * (-secs / FADE_SECS).exp();
        }
    }
    Song { rate_hz, right: left.clone(), left }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_click_begins_in_the_middle_of_its_period() {
        let song = clicks(8_000, 1.0, 3);
        assert_eq!((song.left.len(), &song.left), (24_000, &song.right));
        let loud: Vec<usize> = (0..24_000).filter(|n| song.left[*n].abs() > 0.5).collect();
        assert_eq!([loud[0], *loud.iter().find(|n| **n > 8_000).unwrap()], [4_000, 12_000]);
        assert!(loud.iter().all(|n| n % 8_000 - 4_000 < 80));
        assert!(song.left.iter().all(|x| x.abs() <= 1.0));
        assert!(song.left[..4_000].iter().chain(&song.left[4_500..12_000]).all(|x| x.abs() < 1e-3));
        assert!(clicks(8_000, 0.0, 3).left.is_empty());
    }
}
