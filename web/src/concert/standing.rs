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

    /// Seen as in a show, in its look if it names one; and the body stands as there, if that is the show's own.
    pub(super) fn set_as_in(&mut self, show: &Show) {
        self.shows_body = show.body.clone().filter(|body| is_called(&body.path, &self.name));
        if self.shows_body.is_some() {
            self.stand_as(show.stands);
        }
        self.viewpoint = show.viewpoint;
        if let Some(looks) = &show.looks {
            self.looks.clone_from(looks);
        }
    }

    fn stand_as(&mut self, given: Option<Orientation>) {
        let stands = given.unwrap_or(self.found);
        if stands != self.staging.stands() {
            let dancer = Arc::new(self.ensemble.dancer().standing(self.sand.body(), &stands));
            self.ensemble.give_to(Arc::clone(&dancer));
            self.staging.stand(dancer, stands);
        }
        self.given = given;
    }
}
