//! How much later a picture is seen than sound is heard, from a person's taps.
//!
//! A person taps to clicks alone, then to flashes alone. The person's own reaction time is part of both and cancels in
//! their difference. Nothing here plays, draws or reads a clock: how long after a click or flash each tap came is an argument.

use crate::MusicError;

/// Time between two clicks, or two flashes.
pub const CALIBRATION_PERIOD_SECS: f64 = 1.0;
/// Taps of each kind that are needed, outliers not counted.
pub const CALIBRATION_TAPS: usize = 8;
/// The largest measurable lateness: beyond it, a flash cannot be distinguished from the one before or after.
const FARTHEST_SECS: f64 = 0.45;
/// Of a person who taps along, three taps in four lie within this of the middle one.
const WIDEST_SECS: f64 = 0.06;
/// A tap that lies this many spreads from the middle one is left out, and never one that is nearer than the seconds.
const OUTLIER: (f64, f64) = (3.0, 0.03);
/// Rise and decay times of a flash.
const FLASH_SECS: (f64, f64) = (0.05, 0.4);

/// A signal to tap to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Clicks, without a picture.
    Click,
    /// Flashes, in silence.
    Flash,
}

/// How much later the picture is seen than the sound is heard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latency {
    /// In seconds; negative where the sound is the later one.
    pub secs: f64,
    /// How far it may be off, as one standard error of the medians.
    pub spread_secs: f64,
}

/// The taps so far.
#[derive(Clone, Debug, Default)]
pub struct Calibration {
    clicks: Vec<f64>,
    flashes: Vec<f64>,
}

/// The middle of taps to one signal, and how they lie around it.
struct Taps {
    median_secs: f64,
    /// Standard deviation, from the median of the distances.
    spread_secs: f64,
    kept: usize,
}

impl Calibration {
    /// Adds a tap at this time after any of the clicks or flashes, which are all a period apart.
    pub fn tap(&mut self, signal: Signal, after_secs: f64) {
        if after_secs.is_finite() {
            self.taps_mut(signal).push(after_secs.rem_euclid(CALIBRATION_PERIOD_SECS));
        }
    }

    /// Begins anew with the taps to one signal.
    pub fn forget(&mut self, signal: Signal) {
        self.taps_mut(signal).clear();
    }

    /// How many taps to a signal count so far: all but those that lie apart.
    pub fn count(&self, signal: Signal) -> usize {
        Taps::of(self.taps(signal)).map_or(0, |taps| taps.kept)
    }

    /// The difference of the medians.
    ///
    /// # Errors
    /// [`MusicError::Calibration`] where there are too few taps, where they lie too far from each other, or where the
    /// difference is so large that it may be one of another flash.
    pub fn latency(&self) -> Result<Latency, MusicError> {
        let [clicks, flashes] = [Signal::Click, Signal::Flash].map(|signal| {
            let taps = Taps::of(self.taps(signal)).filter(|taps| taps.kept >= CALIBRATION_TAPS);
            let taps = taps.ok_or_else(|| refused(format!("at least {CALIBRATION_TAPS} taps are needed")))?;
            match taps.spread_secs <= WIDEST_SECS {
                true => Ok(taps),
                false => {
                    let to = if signal == Signal::Click { "clicks" } else { "flashes" };
                    let off = 1e3 * taps.spread_secs;
                    Err(refused(format!(
                        "the taps to the {to} are {off:.0} ms apart, too far to say anything"
                    )))
                }
            }
        });
        let (clicks, flashes) = (clicks?, flashes?);
        let secs = centered(flashes.median_secs - clicks.median_secs);
        if secs.abs() > FARTHEST_SECS {
            return Err(refused(
                "picture and sound are about half a second apart, which taps cannot measure".to_owned(),
            ));
        }
        let error = |taps: &Taps| std::f64::consts::FRAC_PI_2 * taps.spread_secs.powi(2) / taps.kept as f64;
        Ok(Latency { secs, spread_secs: (error(&clicks) + error(&flashes)).sqrt() })
    }

    fn taps(&self, signal: Signal) -> &[f64] {
        match signal {
            Signal::Click => &self.clicks,
            Signal::Flash => &self.flashes,
        }
    }

    fn taps_mut(&mut self, signal: Signal) -> &mut Vec<f64> {
        match signal {
            Signal::Click => &mut self.clicks,
            Signal::Flash => &mut self.flashes,
        }
    }
}

impl Taps {
    fn of(after_secs: &[f64]) -> Option<Self> {
        // Taps lie on a circle, the period: it is cut open opposite to where most of them lie.
        let turn = std::f64::consts::TAU / CALIBRATION_PERIOD_SECS;
        let (sin, cos) = after_secs
            .iter()
            .map(|secs| (turn * secs).sin_cos())
            .fold((0.0, 0.0), |(s, c), (sin, cos)| (s + sin, c + cos));
        let middle_secs = sin.atan2(cos) / turn;
        let mut around: Vec<f64> = after_secs.iter().map(|secs| centered(secs - middle_secs)).collect();
        let (median, spread) = middle(&mut around)?;
        around.retain(|secs| (secs - median).abs() <= (OUTLIER.0 * spread).max(OUTLIER.1));
        let kept = around.len();
        let (median, spread_secs) = middle(&mut around)?;
        Some(Self { median_secs: middle_secs + median, spread_secs, kept })
    }
}

/// The median, and the standard deviation of a normal distribution with such distances to it.
fn middle(values: &mut [f64]) -> Option<(f64, f64)> {
    let median = median(values)?;
    let mut distances: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
    Some((median, 1.4826 * self::median(&mut distances)?))
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let above = *values.get(values.len() / 2)?;
    let below = *values.get((values.len() - 1) / 2)?;
    Some(0.5 * (below + above))
}

/// The same place on the circle, within half a period of 0.
fn centered(secs: f64) -> f64 {
    (secs + 0.5 * CALIBRATION_PERIOD_SECS).rem_euclid(CALIBRATION_PERIOD_SECS) - 0.5 * CALIBRATION_PERIOD_SECS
}

fn refused(why: String) -> MusicError {
    MusicError::Calibration { why }
}

/// How bright the field is that flashes, in [0, 1], so long after a flash: one each period, which grows quickly and fades
/// slowly. The flash is where it is half as bright as it gets.
pub fn calibration_flash(after_secs: f64) -> f32 {
    let (grows, fades) = FLASH_SECS;
    let since = (after_secs + 0.5 * grows).rem_euclid(CALIBRATION_PERIOD_SECS);
    let smooth = |share: f64| 0.5 - 0.5 * (std::f64::consts::PI * share.clamp(0.0, 1.0)).cos();
    let light = if since < grows { smooth(since / grows) } else { 1.0 - smooth((since - grows) / fades) };
    light as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FLASH_STEP, MAX_FLASHES, most_flashes_per_second};

    /// A person who taps so long after what is heard or seen, a little early or late.
    fn tapped(click_secs: f64, flash_secs: f64, off_secs: &[f64]) -> Calibration {
        let mut calibration = Calibration::default();
        for (n, off) in off_secs.iter().enumerate() {
            calibration.tap(Signal::Click, n as f64 + click_secs + off);
            calibration.tap(Signal::Flash, n as f64 + flash_secs - off);
        }
        calibration
    }

    const OFF: [f64; 9] = [0.0, 0.012, -0.018, 0.02, -0.007, 0.004, -0.011, 0.009, -0.002];

    #[test]
    fn the_difference_is_that_of_picture_and_sound_whoever_taps() {
        for reaction_secs in [-0.06, 0.0, 0.21, 0.47] {
            for late_secs in [0.0, 0.083, -0.12, 0.4, -0.4] {
                let latency = tapped(reaction_secs, reaction_secs + late_secs, &OFF).latency().unwrap();
                assert!((latency.secs - late_secs).abs() < 1e-9, "{reaction_secs} {late_secs} {latency:?}");
                assert!((0.001..0.02).contains(&latency.spread_secs), "{latency:?}");
            }
        }
    }

    #[test]
    fn a_slip_does_not_count() {
        let mut calibration = tapped(0.1, 0.18, &OFF);
        let before = calibration.latency().unwrap();
        calibration.tap(Signal::Click, 0.45);
        calibration.tap(Signal::Flash, 0.9);
        calibration.tap(Signal::Flash, f64::NAN);
        assert_eq!([Signal::Click, Signal::Flash].map(|signal| calibration.count(signal)), [9, 9]);
        let after = calibration.latency().unwrap();
        assert!((after.secs - before.secs).abs() < 0.003, "{before:?} {after:?}");
    }

    #[test]
    fn what_says_nothing_is_refused() {
        let why = |calibration: &Calibration| calibration.latency().unwrap_err().to_string();
        assert!(why(&tapped(0.1, 0.2, &OFF[..7])).contains("8 taps"), "too few");
        let mut only_clicks = tapped(0.1, 0.2, &OFF);
        only_clicks.forget(Signal::Flash);
        assert!(why(&only_clicks).contains("8 taps"));
        let anywhere: Vec<f64> = (0..16).map(|n| f64::from(n * n % 17) / 17.0).collect();
        assert!(why(&tapped(0.1, 0.2, &anywhere)).contains("apart"));
        assert!(why(&tapped(0.0, 0.48, &OFF)).contains("half a second"));
        assert_eq!(Calibration::default().count(Signal::Click), 0);
    }

    #[test]
    fn the_field_flashes_once_a_second_and_the_limit_allows_it() {
        let times: Vec<f64> = (0..600).map(|frame| f64::from(frame) / 60.0).collect();
        let light: Vec<f32> = times.iter().map(|secs| calibration_flash(*secs)).collect();
        let flashes = most_flashes_per_second(&times, &light);
        assert!(flashes > 0 && flashes <= MAX_FLASHES, "{flashes}");
        assert!((calibration_flash(0.0) - 0.5).abs() < 1e-6 && (calibration_flash(7.0) - 0.5).abs() < 1e-4);
        assert!(calibration_flash(0.025) > 0.999 && calibration_flash(0.5) < FLASH_STEP);
        assert!(times.iter().all(|secs| (0.0..=1.0).contains(&calibration_flash(*secs))));
    }
}
