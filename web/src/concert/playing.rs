//! A saved show, played: what was done is done again, at its times. What is heard is up to the page, which is told.

use std::collections::VecDeque;

use chladni_music::{LoggedAction, Show, Stretch};
use chladni_program::work::{Error, Hearing, ShowClock};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::Concert;
use super::beat::ShowSong;

/// The rest of a show.
pub(super) struct Script {
    actions: VecDeque<LoggedAction>,
    heard: VecDeque<Stretch>,
    ends_secs: f64,
}

/// The sound that the page is to play from now on.
#[derive(Serialize)]
struct Cue {
    /// By its number among the show's songs; none is live input, which was not recorded.
    song: Option<usize>,
    song_secs: f64,
    playing: bool,
}

#[wasm_bindgen]
impl Concert {
    /// Plays a show from its beginning. The page makes its songs known, by their numbers in the show, and follows
    /// [`cue`](Self::cue).
    ///
    /// # Errors
    /// Text that is not a show, and a show that cannot be danced here.
    pub fn play_show(&mut self, text: &str) -> Result<(), JsError> {
        let show = Show::from_text(text)?;
        self.instrument = show.begin(self.instrument.shape().clone())?;
        self.set_as_in(&show);
        let ends_secs = show.ends_secs();
        let first =
            Stretch { at_secs: 0.0, song: Some(0), song_secs: 0.0, playing: true, crossfade_secs: 0.0 };
        let heard = if show.heard.is_empty() { vec![first] } else { show.heard };
        let last_secs = heard.last().map_or(0.0, |stretch| stretch.at_secs);
        self.script = Some(Script {
            actions: show.actions.into(),
            heard: heard.into(),
            ends_secs: ends_secs.max(last_secs),
        });
        (self.programme, self.before_sand, self.live) = (None, None, None);
        (self.hearing, self.clock) = (Hearing::default(), ShowClock::default());
        self.hearing.know_clock(show.clock);
        self.hearing.tune(0.0, self.instrument.parameters());
        self.songs = show.songs.into_iter().map(ShowSong::from).collect();
        Ok(())
    }

    /// The change of sound that is due now in the show being played, as JSON, once; none where nothing changes.
    ///
    /// # Errors
    /// Bugs only.
    pub fn cue(&mut self) -> Result<Option<String>, JsError> {
        let now_secs = self.clock.at_secs();
        let Some(script) = &mut self.script else { return Ok(None) };
        let mut cue = None;
        while let Some(due) = script.heard.pop_front_if(|stretch| stretch.at_secs <= now_secs) {
            let song_secs = due.song_secs_at(now_secs);
            cue = Some(Cue { song: due.song, song_secs, playing: due.playing });
        }
        Ok(cue.map(|cue| serde_json::to_string(&cue)).transpose()?)
    }

    /// A show is played.
    pub fn plays_show(&self) -> bool {
        self.script.is_some()
    }

    /// The show that is played is one's own from now on.
    pub fn stop_show(&mut self) {
        self.leave_script();
    }
}

impl Concert {
    /// What follows is not of the show that was played, nor is its clock.
    pub(super) fn leave_script(&mut self) {
        if self.script.take().is_some() {
            self.hearing.give_up_clock(self.clock.at_secs());
        }
    }

    /// Repeats the actions up to a time of the show that is played.
    pub(super) fn follow_script(&mut self, now_secs: f64) -> Result<(), Error> {
        loop {
            let Some(script) = &mut self.script else { return Ok(()) };
            let Some(line) = script.actions.pop_front_if(|line| line.moment.at_secs <= now_secs) else {
                let is_over = script.actions.is_empty() && script.heard.is_empty();
                if is_over && now_secs >= script.ends_secs {
                    self.leave_script();
                }
                return Ok(());
            };
            self.act_at(line.moment.at_secs, line.action)?;
        }
    }
}
