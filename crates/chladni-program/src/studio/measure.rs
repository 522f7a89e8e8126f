//! Measures the window's frame times, and whether the sound kept up.

use std::cell::RefCell;
use std::time::{Instant, SystemTime};

use serde::Serialize;

/// Waits for the first picture of the opened files.
#[derive(Debug)]
pub struct FirstPicture {
    began: Instant,
    outcome: RefCell<Option<Result<f64, String>>>,
}

impl FirstPicture {
    /// From now on.
    pub fn since(began: Instant) -> Self {
        Self { began, outcome: RefCell::new(None) }
    }

    /// A picture is on screen.
    pub fn seen(&self, now: Instant) {
        self.settle(Ok((now - self.began).as_secs_f64()));
    }

    /// There will be none, for this reason.
    pub fn failed(&self, why: &str) {
        self.settle(Err(why.to_owned()));
    }

    fn settle(&self, outcome: Result<f64, String>) {
        self.outcome.borrow_mut().get_or_insert(outcome);
    }

    /// How many seconds it took, or why there is no picture; `None` before either is known.
    pub fn outcome(&self) -> Option<Result<f64, String>> {
        self.outcome.borrow().clone()
    }
}

/// Frames that are counted for a while.
#[derive(Clone, Debug)]
pub struct Measure {
    secs: f64,
    began: Option<Instant>,
    /// When each frame came, and where in the song it was.
    frames: Vec<(f64, Option<f64>)>,
    underruns: u64,
    /// The frames in which their number had grown, and by how much.
    underruns_at: Vec<(f64, u64)>,
    stage: Option<OnStage>,
    left_out: Option<u64>,
}

/// Size of the dance on stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct OnStage {
    /// Deformed shapes.
    pub items: usize,
    /// Vertices of each.
    pub vertices: usize,
    /// How many of them were drawn, in the mean of all shapes.
    pub drawn_vertices: usize,
}

/// The result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// From the first counted frame to the last.
    pub secs: f64,
    /// Frames drawn.
    pub frames: usize,
    /// The middle one of all pauses between frames.
    pub median_frame_secs: f64,
    /// The same of each quarter of the time, one after the other.
    pub median_quarters_secs: [f64; 4],
    /// The longest pause between frames.
    pub longest_frame_secs: f64,
    /// How far the song moved on from the first frame to the last.
    pub song_secs: Option<f64>,
    /// The largest difference between the song's clock and the wall's, after the mean is taken off.
    pub largest_drift_secs: Option<f64>,
    /// How often the sound device was given silence.
    pub underruns: u64,
    /// When that was noticed, in seconds since 1970, and how often it had been since the time before.
    pub underruns_at: Vec<(f64, u64)>,
    /// Pictures that a recording left out, where there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<u64>,
    /// Size of the dance, if there was one.
    pub stage: Option<OnStage>,
}

impl Measure {
    /// Counts for a number of seconds, from the first frame on that has a song.
    pub fn new(secs: f64) -> Self {
        Self {
            secs,
            began: None,
            frames: Vec::new(),
            underruns: 0,
            underruns_at: Vec::new(),
            stage: None,
            left_out: None,
        }
    }

    /// Counts a frame; `sound` is the position in the song and the underruns so far, where one
    /// plays. True when all is counted.
    pub fn frame(&mut self, now: Instant, sound: Option<(f64, u64)>) -> bool {
        if self.began.is_none() && sound.is_none_or(|(position_secs, _)| position_secs <= 0.0) {
            return false;
        }
        if self.frames.last().is_some_and(|(at, _)| *at >= self.secs) {
            return true;
        }
        let began = *self.began.get_or_insert(now);
        let at = (now - began).as_secs_f64();
        self.frames.push((at, sound.map(|sound| sound.0)));
        if let Some((_, underruns)) = sound {
            if underruns > self.underruns {
                self.underruns_at.push((at, underruns - self.underruns));
            }
            self.underruns = underruns;
        }
        at >= self.secs
    }

    /// Notes the size of the dance.
    pub fn shows(&mut self, stage: Option<OnStage>) {
        self.stage = stage.or(self.stage);
    }

    /// Notes how many pictures a recording has left out.
    pub fn records(&mut self, left_out: Option<u64>) {
        self.left_out = left_out.or(self.left_out);
    }

    /// The report; `None` where there were too few frames.
    pub fn report(&self) -> Option<FrameReport> {
        let [first, .., last] = self.frames[..] else { return None };
        let began = unix_secs(self.began?);
        let secs = last.0 - first.0;
        // Each pause belongs to the quarter in which it begins.
        let quarter_of = |at: f64| ((4.0 * (at - first.0) / secs) as usize).min(3);
        let mut pauses: Vec<f64> = Vec::with_capacity(self.frames.len());
        let mut of_quarters: [Vec<f64>; 4] = Default::default();
        for pair in self.frames.windows(2) {
            let pause = pair[1].0 - pair[0].0;
            pauses.push(pause);
            of_quarters[quarter_of(pair[0].0)].push(pause);
        }
        let longest_frame_secs = pauses.iter().copied().fold(0.0, f64::max);
        let offsets: Vec<f64> =
            self.frames.iter().filter_map(|(at, position)| Some((*position)? - at)).collect();
        let mean = offsets.iter().sum::<f64>() / offsets.len().max(1) as f64;
        let drift = offsets.iter().map(|offset| (offset - mean).abs()).fold(0.0, f64::max);
        Some(FrameReport {
            secs,
            frames: self.frames.len(),
            median_frame_secs: median(pauses),
            median_quarters_secs: of_quarters.map(median),
            longest_frame_secs,
            song_secs: last.1.zip(first.1).map(|(last, first)| last - first),
            largest_drift_secs: (!offsets.is_empty()).then_some(drift),
            underruns: self.underruns,
            underruns_at: self.underruns_at.iter().map(|(at, count)| (began + at, *count)).collect(),
            left_out: self.left_out,
            stage: self.stage,
        })
    }
}

/// The seconds from 1970 to a time that is past, by the system's clock of now: other programs know no instants.
fn unix_secs(then: Instant) -> f64 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    now.as_secs_f64() - then.elapsed().as_secs_f64()
}

/// The median; 0 if there are no values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn pauses_and_drift_are_measured() {
        let (mut measure, start) = (Measure::new(1.0), Instant::now());
        assert_eq!(measure.report(), None);
        assert!(!measure.frame(start, None));
        let at = |ms: u64| start + Duration::from_millis(ms);
        for (ms, position_secs) in [(100, 5.0), (200, 5.1), (500, 5.42), (600, 5.5)] {
            assert!(!measure.frame(at(ms), Some((position_secs, 1))));
        }
        assert!(measure.frame(at(1100), Some((6.0, 2))));
        // The window closes; frames until then do not count.
        assert!(measure.frame(at(1200), None));
        let report = measure.report().unwrap();
        assert_eq!((report.frames, report.underruns), (5, 2));
        // One in the first frame that counts, and one a second later.
        let [(first, 1), (second, 1)] = report.underruns_at[..] else { panic!("{:?}", report.underruns_at) };
        assert!((second - first - 1.0).abs() < 1e-3, "{first}, then {second}");
        assert!((report.secs - 1.0).abs() < 1e-9 && (report.longest_frame_secs - 0.5).abs() < 1e-9);
        assert!((report.median_frame_secs - 0.3).abs() < 1e-9);
        for (found, exact) in report.median_quarters_secs.iter().zip([0.3, 0.1, 0.5, 0.0]) {
            assert!((found - exact).abs() < 1e-9, "{:?}", report.median_quarters_secs);
        }
        assert!((report.largest_drift_secs.unwrap() - 0.016).abs() < 1e-9);
        assert!((report.song_secs.unwrap() - 1.0).abs() < 1e-9);
    }
}
