//! Somebody who drops a song and leans back.

use egui::Context;

/// So long after the last touch it counts as leaning back.
const REST_SECS: f64 = 8.0;

/// Waits, after a song was opened, until nobody touches anything.
#[derive(Debug, Default)]
pub struct Leaning {
    since_secs: Option<f64>,
}

impl Leaning {
    /// Songs were opened.
    pub fn begin(&mut self, ctx: &Context) {
        self.since_secs = Some(ctx.input(|input| input.time));
    }

    /// No longer waits.
    pub fn end(&mut self) {
        self.since_secs = None;
    }

    /// True once, when nothing was touched for a while.
    pub fn is_at_rest(&mut self, ctx: &Context) -> bool {
        let Some(since_secs) = &mut self.since_secs else { return false };
        let (now_secs, touched) = ctx.input(|input| (input.time, !input.events.is_empty()));
        if touched {
            *since_secs = now_secs;
        }
        let rests = now_secs - *since_secs > REST_SECS;
        if rests {
            self.end();
        }
        rests
    }
}
