//! The beat for other machines, as MIDI clock to a device.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use chladni_music::ClockOut;

use super::beat_out::Now;
use super::midi::Outputs;

/// Below this confidence the beat is a guess, and the outgoing clock stops.
const SURE: f32 = 0.1;

/// Where a MIDI clock goes, and the beat as the last frame knew it.
#[derive(Clone, Debug)]
struct Given {
    device: String,
    count: f64,
    per_sec: f64,
    at: Instant,
}

impl Given {
    fn of(device: &str, now: &Now<'_>) -> Self {
        Self {
            device: device.to_owned(),
            // Others keep to what is heard.
            count: now.beat.count - now.ahead_secs * now.tempo_bpm / 60.0,
            per_sec: now.tempo_bpm / 60.0,
            at: now.beat_at,
        }
    }

    fn count_at(&self, at: Instant) -> f64 {
        self.count + self.per_sec * at.saturating_duration_since(self.at).as_secs_f64()
    }
}

/// The beat of a frame is valid for this long.
const STALE: Duration = Duration::from_secs(2);

/// Sends MIDI clock from a thread of its own, since frames are too far apart for it.
pub struct ClockSender {
    given: Arc<Mutex<Option<Given>>>,
    closed: Arc<AtomicBool>,
}

impl ClockSender {
    /// Starts to send; nothing is sent before the first [`tell`](Self::tell).
    pub fn start(outputs: Outputs) -> std::io::Result<Self> {
        let given = Arc::new(Mutex::new(None));
        let closed = Arc::new(AtomicBool::new(false));
        let (last, ended) = (Arc::clone(&given), Arc::clone(&closed));
        std::thread::Builder::new().name("clock out".into()).spawn(move || {
            let mut out = ClockOut::default();
            let mut device = String::new();
            loop {
                let closes = ended.load(Ordering::Relaxed);
                let now: Option<Given> = last.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let now = now.filter(|now| !closes && now.at.elapsed() < STALE);
                // One device stops before another starts. One that is not open yet would miss the start.
                let goes_on = now
                    .as_ref()
                    .filter(|now| (device.is_empty() || now.device == device) && outputs.opens(&now.device));
                let count = goes_on.map(|now| now.count_at(Instant::now()));
                if let Some(now) = goes_on {
                    device.clone_from(&now.device);
                }
                out.due(count).into_iter().for_each(|message| outputs.send(&device, &[message]));
                if count.is_none() {
                    device.clear();
                }
                if closes {
                    return;
                }
                std::thread::sleep(Duration::from_millis(if count.is_some() { 1 } else { 20 }));
            }
        })?;
        Ok(Self { given, closed })
    }

    /// The beat now; it is sent to `device`, or to none.
    pub fn tell(&self, device: Option<&str>, now: &Now<'_>) {
        let device = device.filter(|_| now.tempo_bpm > 0.0 && now.beat.confidence >= SURE);
        let given = device.map(|device| Given::of(device, now));
        *self.given.lock().unwrap_or_else(PoisonError::into_inner) = given;
    }
}

impl Drop for ClockSender {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use chladni_music::Beat;

    use super::*;
    use crate::studio::music::listening::Progress;

    #[test]
    fn a_beat_goes_on_from_when_it_was_heard() {
        let sender = ClockSender { given: Arc::default(), closed: Arc::default() };
        let beat_at = Instant::now();
        let now = Now {
            at_secs: 1.0,
            beat: Beat { count: 8.0, confidence: 1.0 },
            beat_at,
            tempo_bpm: 120.0,
            progress: Progress::default(),
            bands: &[],
            ahead_secs: 0.0,
        };
        // The beat is of that moment, however much later it is sent.
        std::thread::sleep(Duration::from_millis(5));
        sender.tell(Some("drum machine"), &now);
        let given = sender.given.lock().unwrap().clone().unwrap();
        let count = given.count_at(beat_at + Duration::from_millis(50));
        assert!((count - 8.1).abs() < 1e-9, "{count}");
    }
}
