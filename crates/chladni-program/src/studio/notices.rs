//! Short messages in the corner: successes, warnings and errors. Errors stay until they are read.

use std::fmt::Display;
use std::time::{Duration, Instant};

use egui::accesskit::Live;

use super::icon::{self, Icon};
use super::theme;
use crate::work::Error;

/// How long a message that is not an error stays once it was on screen.
const LINGER: Duration = Duration::from_secs(6);
/// How many are on screen at once, and one more where these are errors and it is none.
const MOST: usize = 5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Severity {
    Done,
    Warning,
    Error,
}

#[derive(Debug)]
struct Notice {
    severity: Severity,
    text: String,
    /// Whether a frame has shown it.
    is_shown: bool,
    /// When a frame that had shown it was over: a busy machine takes long for it.
    since: Option<Instant>,
    /// The topic; a new notice on the same topic replaces this one.
    matter: Option<&'static str>,
}

/// The messages on screen, newest last.
#[derive(Debug, Default)]
pub struct Notices {
    shown: Vec<Notice>,
    errors: usize,
}

impl Notices {
    /// Something the user asked for is done.
    pub fn done(&mut self, text: impl Display) {
        self.push(Severity::Done, text.to_string());
    }

    /// Something was done, but not quite as asked.
    pub fn warn(&mut self, text: impl Display) {
        self.push(Severity::Warning, text.to_string());
    }

    /// It failed; the text says what, where and why.
    pub fn error(&mut self, text: impl Display) {
        self.push(Severity::Error, text.to_string());
    }

    /// Work was not done. If the user cancelled it, that is not shown as an error.
    pub fn failed(&mut self, error: impl Into<Error>) {
        match error.into() {
            Error::Cancelled => self.done("Cancelled; no unfinished file is left."),
            error => self.error(error),
        }
    }

    /// A warning in the place of the last one on the same `matter`, which it outdates.
    pub fn update(&mut self, matter: &'static str, text: impl Display) {
        self.replace(matter, Severity::Warning, text.to_string());
    }

    /// Good news in the place of the last notice on the same `matter`.
    pub fn settle(&mut self, matter: &'static str, text: impl Display) {
        self.replace(matter, Severity::Done, text.to_string());
    }

    /// The last notice on a `matter` holds no longer.
    pub fn withdraw(&mut self, matter: &'static str) {
        self.shown.retain(|notice| notice.matter != Some(matter));
    }

    fn replace(&mut self, matter: &'static str, severity: Severity, text: String) {
        self.withdraw(matter);
        self.push(severity, text);
        if let Some(notice) = self.shown.last_mut() {
            notice.matter = Some(matter);
        }
    }

    /// Errors were seen by a person who went on: those on screen go soon, like all else.
    pub fn outdate_errors(&mut self) {
        for notice in &mut self.shown {
            if notice.severity == Severity::Error {
                (notice.severity, notice.since) = (Severity::Warning, None);
            }
        }
    }

    /// How many errors there were so far, read or not.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// The oldest error on screen.
    pub fn first_error(&self) -> Option<&str> {
        self.shown.iter().find(|notice| notice.severity == Severity::Error).map(|notice| notice.text.as_str())
    }

    fn push(&mut self, severity: Severity, text: String) {
        self.errors += usize::from(severity == Severity::Error);
        self.shown.retain(|notice| notice.text != text);
        self.shown.push(Notice { severity, text, is_shown: false, since: None, matter: None });
        while self.shown.len() > MOST {
            // An error is to be read.
            let before = &self.shown[..self.shown.len() - 1];
            let oldest = before.iter().position(|notice| notice.severity != Severity::Error);
            let Some(oldest) = oldest.or((severity == Severity::Error).then_some(0)) else { break };
            self.shown.remove(oldest);
        }
    }

    /// Draws the messages over everything else, as they are at the time `now`.
    pub fn show(&mut self, ctx: &egui::Context, now: Instant) {
        let stays = |notice: &Notice| notice.since.is_none_or(|since| now.duration_since(since) < LINGER);
        self.shown.retain(|notice| notice.severity == Severity::Error || stays(notice));
        for notice in &mut self.shown {
            if std::mem::replace(&mut notice.is_shown, true) {
                notice.since.get_or_insert(now);
            }
        }
        if self.shown.is_empty() {
            return;
        }
        ctx.request_repaint_after(Duration::from_millis(500));
        let mut closed = None;
        egui::Area::new(egui::Id::unique("notices"))
            .anchor(egui::Align2::CENTER_BOTTOM, [0.0, -theme::GAP_LARGE])
            .order(egui::Order::Foreground)
            .show(ctx, |ui| {
                for (index, notice) in self.shown.iter().enumerate() {
                    if show_notice(ui, notice) {
                        closed = Some(index);
                    }
                }
            });
        if let Some(index) = closed {
            self.shown.remove(index);
        }
    }
}

/// Draws one message; true when its close button was clicked.
fn show_notice(ui: &mut egui::Ui, notice: &Notice) -> bool {
    let palette = theme::palette(ui);
    let (mark, color) = match notice.severity {
        Severity::Done => (Icon::CircleCheck, palette.good),
        Severity::Warning => (Icon::TriangleAlert, palette.warning),
        Severity::Error => (Icon::OctagonAlert, palette.error),
    };
    // Read aloud as soon as it is there: errors at once, others when there is a pause.
    let (role, live) = match notice.severity {
        Severity::Error => (egui::Role::Alert, Live::Assertive),
        Severity::Done | Severity::Warning => (egui::Role::Status, Live::Polite),
    };
    let said = egui::UiBuilder::new().accessibility_role(role).accessibility_label(&notice.text);
    ui.scope_builder(said, |ui| {
        ui.ctx().accesskit_node_builder(ui.unique_id(), |node| node.set_live(live));
        let frame = egui::Frame::popup(ui.style()).fill(palette.card);
        frame
            .show(ui, |ui| {
                ui.set_max_width(420.0);
                ui.horizontal(|ui| {
                    ui.label(egui::RichText::new(icon::text(mark)).color(color).size(18.0));
                    ui.add(egui::Label::new(&notice.text).wrap().selectable(true));
                    ui.small_button(icon::text(Icon::X)).on_hover_text("Close this message").clicked()
                })
                .inner
            })
            .inner
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_new_is_seen_beside_errors_that_nobody_has_read() {
        let mut notices = Notices::default();
        let texts = |notices: &Notices| -> Vec<String> {
            notices.shown.iter().map(|notice| notice.text.clone()).collect()
        };
        (0..MOST).for_each(|i| notices.error(format!("error {i}")));
        notices.warn("left out");
        assert_eq!((texts(&notices).len(), texts(&notices).last().unwrap().as_str()), (MOST + 1, "left out"));
        notices.update("matter", "later");
        assert_eq!((texts(&notices).len(), texts(&notices).last().unwrap().as_str()), (MOST + 1, "later"));
        (0..9).for_each(|i| notices.error(format!("another {i}")));
        assert!(texts(&notices).len() == MOST && texts(&notices).contains(&"another 8".to_owned()));
    }

    #[test]
    fn good_news_takes_the_place_of_the_warning_and_what_holds_no_longer_goes() {
        let mut notices = Notices::default();
        let all = |notices: &Notices| -> Vec<(Severity, String)> {
            notices.shown.iter().map(|notice| (notice.severity, notice.text.clone())).collect()
        };
        notices.update("sound", "No sound");
        notices.update("harmonics", "32 are in use");
        notices.settle("harmonics", "64 are in use");
        notices.withdraw("sound");
        assert_eq!(all(&notices), [(Severity::Done, "64 are in use".to_owned())]);
    }
}
