//! Edits of the project that the panels request: the window never changes it directly.

use chladni_caricature::{Action, LayerId, Property};

/// One request to the engine.
#[derive(Clone, Debug)]
pub enum Edit {
    /// An action that is a step of its own in the history.
    Once(Action),
    /// An action of a drag; drags of one kind become one step.
    Live(Action),
    /// Actions that are one step.
    Together(Vec<Action>),
    /// The drag ended.
    Finish,
}

/// The requests of one frame, in order.
#[derive(Debug, Default)]
pub struct Edits(Vec<Edit>);

impl Edits {
    /// A step of its own.
    pub fn once(&mut self, action: Action) {
        self.0.push(Edit::Once(action));
    }

    /// Several actions as one step.
    pub fn together(&mut self, actions: Vec<Action>) {
        self.0.push(Edit::Together(actions));
    }

    /// A property set at once, such as by a button.
    pub fn set(&mut self, layer: LayerId, to: Property) {
        self.once(Action::Set { layer, to });
    }

    /// A property that follows a slider: live while `response` drags, one step in the history, as a click is, too.
    pub fn drag(&mut self, layer: LayerId, response: &egui::Response, to: impl FnOnce() -> Property) {
        if response.changed() {
            self.0.push(Edit::Live(Action::Set { layer, to: to() }));
        }
        let clicked = response.clicked() || response.secondary_clicked();
        if response.drag_stopped() || clicked || response.lost_focus() {
            self.finish();
        }
    }

    /// Part of a brush stroke.
    pub fn live(&mut self, action: Action) {
        self.0.push(Edit::Live(action));
    }

    /// The pointer was released.
    pub fn finish(&mut self) {
        self.0.push(Edit::Finish);
    }

    /// Hands the requests over.
    pub fn take(&mut self) -> Vec<Edit> {
        std::mem::take(&mut self.0)
    }
}
