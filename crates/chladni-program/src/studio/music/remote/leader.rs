//! Which of several devices' clocks is followed.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::midi::Said;

/// A clock that is silent for this long stops leading. At 20 beats a minute a clock ticks every 125 ms.
const SILENT: Duration = Duration::from_millis(500);

/// The port that is followed, and when it was heard last: two clocks at once would double the tempo.
#[derive(Default)]
pub struct Leader(Option<(Arc<str>, Instant)>);

impl Leader {
    /// Whether this is to be followed: of several that speak at once, the one that began. Never `own`, the
    /// device that our own clock is sent to, which may send it back.
    pub fn follows(&mut self, said: &Said, own: Option<&str>) -> bool {
        let leads = own != Some(&*said.device)
            && self.0.as_ref().is_none_or(|(leader, heard)| {
                *leader == said.port || said.came.saturating_duration_since(*heard) > SILENT
            });
        if leads {
            self.0 = Some((Arc::clone(&said.port), said.came));
        }
        leads
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::ClockMessage;

    fn tick(port: &str, device: &str, came: Instant) -> Said {
        Said { port: port.into(), device: device.into(), message: ClockMessage::Tick, came }
    }

    #[test]
    fn of_two_clocks_one_is_followed_until_it_is_silent() {
        let began = Instant::now();
        let mut leader = Leader::default();
        // Two of the same kind, one a moment after the other; the first is unplugged after two seconds.
        let followed: Vec<_> = (0..160)
            .flat_map(|i| [("24:0", i, 0), ("28:0", i, 7)])
            .filter(|(port, i, _)| *port != "24:0" || *i < 80)
            .map(|(port, i, later)| (port, Duration::from_millis(25 * i + later)))
            .filter(|(port, after)| leader.follows(&tick(port, "Drum 1", began + *after), None))
            .collect();
        assert!(followed.windows(2).all(|pair| pair[1].1 - pair[0].1 >= Duration::from_millis(25)));
        assert_eq!(followed.iter().filter(|(port, _)| *port == "24:0").count(), 80);
        assert!(followed.iter().filter(|(port, _)| *port == "28:0").count() > 55);
    }

    #[test]
    fn what_we_send_is_not_followed_when_it_comes_back() {
        let mut leader = Leader::default();
        let now = Instant::now();
        assert!(!leader.follows(&tick("24:0", "Drum 1", now), Some("Drum 1")));
        assert!(leader.follows(&tick("28:0", "Mixer", now), Some("Drum 1")));
    }
}
