//! Losing the device, and finding it again: the song goes on where it was heard.

use std::time::{Duration, Instant};

use super::{Engine, PlayerEvent};
use crate::history::History;
use crate::player::output::Output;
use crate::player::queue::Stretch;
use crate::player::tail::Tail;

/// Pauses between attempts to find a device again; they double up to the longest one.
pub(super) const FIRST_RETRY: Duration = Duration::from_secs(1);
const LONGEST_RETRY: Duration = Duration::from_secs(16);

impl Engine {
    pub(super) fn look_after_output(&mut self) {
        let now = Instant::now();
        self.output.advance(&self.shared.clock, now);
        if let Some(reason) = self.output.trouble(&self.shared.clock, now) {
            self.tell(PlayerEvent::DeviceLost(reason));
            self.retry_after = FIRST_RETRY;
            self.fall_silent();
        } else if self.retry_at.is_some_and(|at| now >= at) {
            self.reopen();
        }
    }

    /// Tries the device again and continues at the position of the song; in silence if there is no device.
    pub(super) fn reopen(&mut self) {
        let was_silent = self.output.device.is_none();
        // The old stream is closed first: some devices allow only one.
        let place = if was_silent { None } else { self.change_output(Output::silence(), None) };
        match Output::device(self.device.as_deref(), &self.shared.clock) {
            Ok(output) => {
                let place = self.change_output(output, place);
                self.retry_at = None;
                self.retry_after = FIRST_RETRY;
                if let Some(name) = self.output.device.clone() {
                    self.tell(PlayerEvent::DeviceOpened(name));
                }
                self.go_on_at(place);
            }
            Err(error) => {
                // If the output was silent before, it continues without interruption.
                if !was_silent {
                    self.tell(PlayerEvent::DeviceLost(error.to_string()));
                    self.go_on_at(place);
                }
                self.retry_at = Some(Instant::now() + self.retry_after);
                self.retry_after = (2 * self.retry_after).min(LONGEST_RETRY);
            }
        }
    }

    pub(super) fn open_output(&mut self) {
        self.change_output(Output::silence(), None);
        if !self.audible {
            return;
        }
        self.reopen();
        if self.output.device.is_none() {
            self.tell(PlayerEvent::DeviceLost("no sound device".into()));
        }
    }

    fn fall_silent(&mut self) {
        let place = self.change_output(Output::silence(), None);
        self.go_on_at(place);
        self.retry_at = Some(Instant::now() + self.retry_after);
    }

    /// Starts an empty ring. Time stands still at the last sample heard, or at `place`. Returns that
    /// position.
    fn change_output(&mut self, output: Output, place: Option<Stretch>) -> Option<Stretch> {
        // This drops the old output, and with it the other writer of the clock.
        self.output = output;
        let place = self.place().or(place);
        self.written = 0;
        (self.song, self.tail) = (None, Tail::default());
        let mut timeline = self.shared.timeline();
        self.shared.clock.restart();
        timeline.rate_hz = self.output.rate_hz;
        timeline.device = self.output.device.clone();
        timeline.history = History::new(self.output.rate_hz);
        timeline.stretches.clear();
        if let Some(place) = place {
            timeline.stretches.begin(Stretch { ring_frame: 0, ..place });
        }
        place
    }

    fn go_on_at(&mut self, place: Option<Stretch>) {
        if let Some(place) = place {
            self.start(Some(place.song), place.song_secs, self.playing);
        }
    }
}
