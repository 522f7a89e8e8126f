//! How the body stands, which can be corrected while it dances.

use std::sync::Arc;

use chladni_mesh::{Axis, Orientation};
use chladni_music::Show;
use wasm_bindgen::prelude::*;

use super::{Concert, is_called};

#[wasm_bindgen]
impl Concert {
    /// Says which axis of the shape's file points up, such as `z` or `-y`; `""` leaves it to what was found.
    ///
    /// # Errors
    /// A name that no axis has.
    pub fn stand(&mut self, up: &str) -> Result<(), JsError> {
        let given = if up.is_empty() { None } else { Some(self.staging.stands().with_up(up.parse()?)) };
        self.stand_as(given);
        Ok(())
    }

    /// Another side of the body is the front: the next one around.
    pub fn turn_front(&mut self) {
        self.stand_as(Some(self.staging.stands().quarters(1)));
    }
}

impl Concert {
    /// The axis that was set to point up: none where nothing was set, `other` where it is no axis of the file.
    pub(super) fn up(&self) -> String {
        let Some(given) = self.given else { return String::new() };
        Axis::of(given.up()).map_or_else(|| "other".to_owned(), |axis| axis.to_string())
    }

    /// The body stands as in a show, if that is its own.
    pub(super) fn stand_as_in(&mut self, show: &Show) {
        if show.body.as_ref().is_some_and(|body| is_called(&body.path, &self.name)) {
            self.stand_as(show.stands);
        }
    }

    fn stand_as(&mut self, given: Option<Orientation>) {
        let stands = given.unwrap_or(self.found);
        if stands != self.staging.stands() {
            let dancer = Arc::new(self.ensemble.dancer().standing(&self.body, &stands));
            self.ensemble.give_to(Arc::clone(&dancer));
            self.staging.stand(dancer, stands);
        }
        self.given = given;
    }
}
