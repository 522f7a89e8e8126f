//! Messages between clocks: MIDI clock in and out, and its like over OSC.

/// Ticks of a MIDI clock in a quarter note.
pub const TICKS_PER_QUARTER: f64 = 24.0;

/// A message from an external clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClockMessage {
    /// One of [`TICKS_PER_QUARTER`].
    Tick,
    /// Ticks that came here but could not be kept, between the tick that was heard last and the next one.
    Lost {
        /// How many.
        ticks: u32,
    },
    /// The next tick begins the song.
    Start,
    /// The next tick goes on where the song stopped.
    Continue,
    /// The song stops; ticks that still come tell the tempo.
    Stop,
    /// When the next tick falls, in quarters after the beginning of the song.
    Position {
        /// At least 0.
        quarters: f64,
    },
    /// Quarters a minute.
    Tempo {
        /// In [20, 400]; others are ignored.
        bpm: f64,
    },
    /// A quarter begins now: a tap, or a beat over OSC.
    Beat {
        /// Which one of its bar, from 1; `None` where that is not said.
        in_bar: Option<u32>,
    },
}

impl ClockMessage {
    /// Reads one MIDI message; `None` where it is not about the clock.
    pub fn from_midi(bytes: &[u8]) -> Option<Self> {
        Some(match *bytes {
            [0xf8] => Self::Tick,
            [0xfa] => Self::Start,
            [0xfb] => Self::Continue,
            [0xfc] => Self::Stop,
            // Counted in sixteenth notes, 14 bits, the lower ones first.
            [0xf2, low, high] if low < 128 && high < 128 => {
                Self::Position { quarters: f64::from(u16::from(low) | u16::from(high) << 7) / 4.0 }
            }
            _ => return None,
        })
    }

    /// Reads an OSC message: `/tempo BPM`, `/beat` with or without its number in the bar, from 1, `/bar`, `/start`,
    /// `/stop` and `/continue`, with `/chladni` before it or not. `None` where it is not about the clock, and where its
    /// value is 0.
    pub fn from_osc(address: &str, value: Option<f32>) -> Option<Self> {
        // A button is let go.
        if value == Some(0.0) {
            return None;
        }
        Some(match address.strip_prefix("/chladni").unwrap_or(address) {
            "/tempo" => Self::Tempo { bpm: f64::from(value?) },
            "/beat" => Self::Beat { in_bar: value.filter(|value| *value >= 1.0).map(|value| value as u32) },
            "/bar" => Self::Beat { in_bar: Some(1) },
            "/start" => Self::Start,
            "/stop" => Self::Stop,
            "/continue" => Self::Continue,
            _ => return None,
        })
    }
}

/// Counts the ticks of a MIDI clock that goes out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClockOut {
    sent: Option<i64>,
}

impl ClockOut {
    /// The messages to send where `count` beats have gone by; `None` where there is no beat. It begins on a whole beat
    /// with a start, and no tick is taken back: if the beat is set back, the clock waits for it. Of a jump, whole beats are
    /// left out either way, so that the ticks stay in phase with the beat.
    pub fn due(&mut self, count: Option<f64>) -> Vec<u8> {
        let Some(count) = count.filter(|count| count.is_finite()) else {
            return self.sent.take().map(|_| 0xfc).into_iter().collect();
        };
        let now = (count * TICKS_PER_QUARTER + 1e-6).floor() as i64;
        let Some(sent) = self.sent else {
            if now.rem_euclid(TICKS_PER_QUARTER as i64) != 0 {
                return Vec::new();
            }
            self.sent = Some(now);
            return vec![0xfa, 0xf8];
        };
        let beat = TICKS_PER_QUARTER as i64;
        let sent = sent - (sent - now).max(0) / beat * beat;
        self.sent = Some(sent.max(now));
        vec![0xf8; ((now - sent).max(0) % beat) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Tempo;

    #[test]
    fn midi_and_osc_are_read() {
        let midi = ClockMessage::from_midi;
        assert_eq!([0xf8, 0xfa, 0xfb, 0xfc].map(|byte| midi(&[byte])), {
            use ClockMessage::*;
            [Tick, Start, Continue, Stop].map(Some)
        });
        assert_eq!(midi(&[0xf2, 8, 1]), Some(ClockMessage::Position { quarters: 34.0 }));
        for other in [&[][..], &[0xf2], &[0xf2, 1], &[0xf2, 200, 0], &[0xb0, 1, 2], &[0xfe]] {
            assert_eq!(midi(other), None, "{other:?}");
        }
        let osc = ClockMessage::from_osc;
        assert_eq!(osc("/tempo", Some(128.0)), Some(ClockMessage::Tempo { bpm: 128.0 }));
        assert_eq!(osc("/chladni/beat", Some(3.0)), Some(ClockMessage::Beat { in_bar: Some(3) }));
        assert_eq!(osc("/beat", Some(f32::NAN)), Some(ClockMessage::Beat { in_bar: None }));
        assert_eq!(osc("/bar", Some(17.0)), Some(ClockMessage::Beat { in_bar: Some(1) }));
        assert_eq!((osc("/tempo", None), osc("/gain", Some(1.0))), (None, None));
        for button in ["/beat", "/bar", "/chladni/start", "/stop", "/continue"] {
            assert!(osc(button, Some(1.0)).is_some() && osc(button, None).is_some(), "{button}");
            assert_eq!(osc(button, Some(0.0)), None, "{button} is let go");
        }
    }

    #[test]
    fn a_clock_goes_out_without_a_tick_too_many() {
        let mut out = ClockOut::default();
        assert!(out.due(Some(3.4)).is_empty());
        assert_eq!(out.due(Some(4.0)), [0xfa, 0xf8]);
        let mut ticks = 0;
        for step in 0..=1000 {
            // The beat wavers, and is set back now and then.
            let count = 4.0 + 0.004 * f64::from(step) - if step % 50 == 49 { 0.05 } else { 0.0 };
            ticks += out.due(Some(count)).len();
        }
        assert_eq!(ticks, 4 * TICKS_PER_QUARTER as usize);
        // Jumps keep the phase: half a beat is caught up, whole beats are not, nor waited for.
        assert_eq!(out.due(Some(1e6)).len(), 0);
        assert_eq!(out.due(Some(2e6 + 0.5)).len(), 12);
        assert_eq!(out.due(Some(7.25)).len(), 0);
        assert_eq!(out.due(Some(8.0)).len(), 12);
        assert_eq!((out.due(None), out.due(None)), (vec![0xfc], vec![]));
        // The clock that we send can be followed.
        let (mut out, mut tempo) = (ClockOut::default(), Tempo::default());
        for step in 0..20_000 {
            let secs = 1e-3 * f64::from(step);
            for byte in out.due(Some(secs * 140.0 / 60.0)) {
                tempo.hear(ClockMessage::from_midi(&[byte]).unwrap(), secs);
            }
        }
        assert!((tempo.bpm().unwrap() - 140.0).abs() < 0.3, "{:?}", tempo.bpm());
    }
}
