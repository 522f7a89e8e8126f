//! Somebody who drops a song and leans back.

use egui::{Context, Event};

/// Seconds without a touch after which the user counts as leaning back.
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

    /// No longer waits once something was pressed: the user wants something else. Comes before the keys, which take their
    /// presses out of the input.
    pub fn notice(&mut self, ctx: &Context) {
        // A pointer may be moved out of the way.
        let presses = |event: &Event| {
            matches!(event, Event::PointerButton { pressed: true, .. } | Event::Key { pressed: true, .. })
        };
        if ctx.input(|input| input.events.iter().any(presses)) {
            self.end();
        }
    }

    /// True once, when nothing was touched for a while. Only time in which a shape is there and a song `plays` counts.
    pub fn is_at_rest(&mut self, ctx: &Context, plays: bool) -> bool {
        let Some(since_secs) = &mut self.since_secs else { return false };
        let (now_secs, touched) = ctx.input(|input| (input.time, !input.events.is_empty()));
        if touched || !plays {
            *since_secs = now_secs;
        }
        let rests = now_secs - *since_secs > REST_SECS;
        if rests {
            self.end();
        }
        rests
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_ends_it_and_a_move_begins_it_anew() {
        let ctx = Context::default();
        let rests = |leaning: &mut Leaning, secs: f64, events: Vec<Event>, plays: bool| {
            let input = egui::RawInput { time: Some(secs), events, ..egui::RawInput::default() };
            let mut rests = false;
            let _ = ctx.run_ui(input, |ui| {
                leaning.notice(ui.ctx());
                rests = leaning.is_at_rest(ui.ctx(), plays);
            });
            rests
        };
        let at_rest = |leaning: &mut Leaning, secs: f64, events| rests(leaning, secs, events, true);
        let mut leaning = Leaning { since_secs: Some(0.0) };
        assert!(!at_rest(&mut leaning, 7.0, vec![Event::PointerMoved(egui::pos2(3.0, 4.0))]));
        assert!(!at_rest(&mut leaning, 9.0, Vec::new()));
        assert!(at_rest(&mut leaning, 15.5, Vec::new()) && !at_rest(&mut leaning, 30.0, Vec::new()));
        // A shape may take longer to open, and is looked at for as long all the same.
        leaning.since_secs = Some(30.0);
        assert!(!rests(&mut leaning, 50.0, Vec::new(), false) && !at_rest(&mut leaning, 57.9, Vec::new()));
        assert!(at_rest(&mut leaning, 58.1, Vec::new()));
        leaning.since_secs = Some(30.0);
        let press = Event::Key {
            key: egui::Key::C,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: egui::Modifiers::NONE,
        };
        assert!(!at_rest(&mut leaning, 31.0, vec![press]) && !at_rest(&mut leaning, 60.0, Vec::new()));
    }
}
