//! Keys and controllers of this room.

use chladni_music::{Action, Cue, Target, Which, preceding};

use super::MusicRoom;
use super::hands::{Stand, dance};
use super::look;
use super::remote::{Asked, Now};
use super::view::View;
use super::wish::{Then, Wish};
use crate::studio::keys::music::{
    AUTOPILOT, BACK, BLACKOUT, BREED, CHOOSE, DOUBLE, DRAW, FAVORITE, FILM, FOLLOW_CLOCK, FORTH, FORTH_BY_Y,
    FREEZE, GO, HALVE, HOLD, LEAVE, LIVE, LOCK, LOCK_BEAT, MARK_ABOVE, MARK_BELOW, MARK_LEFT, MARK_RIGHT,
    MUTATE, NEXT_SONG, NEXT_UP, NUDGE_BACK, NUDGE_ON, OPEN, PLAY, PREVIOUS_SONG, RECORD, REPEAT, SAVE, SHOW,
    SHUFFLE, STAGE, TAP,
};
use crate::studio::room::Shared;
use crate::studio::shortcut::Shortcut;
use crate::work::look_on_stage;

/// To the left, to the right, above, below.
const MARKS: [Shortcut; 4] = [MARK_LEFT, MARK_RIGHT, MARK_ABOVE, MARK_BELOW];

/// Keys of the sound, done at once: a tap counts when it is pressed.
const HEARING: [(Shortcut, Target); 9] = [
    (PLAY, Target::PlayPause),
    (TAP, Target::Tap),
    (NEXT_SONG, Target::NextSong),
    (PREVIOUS_SONG, Target::PreviousSong),
    (HALVE, Target::Halve),
    (DOUBLE, Target::Double),
    (LOCK_BEAT, Target::HoldTempo),
    (NUDGE_BACK, Target::NudgeLater),
    (NUDGE_ON, Target::NudgeSooner),
];

/// Keys of the dance that is marked.
const MARKED: [(Shortcut, Target); 6] = [
    (CHOOSE, Target::Choose),
    (FAVORITE, Target::Favorite),
    (LOCK, Target::Lock),
    (MUTATE, Target::Mutate),
    (STAGE, Target::Stage),
    (NEXT_UP, Target::Cue),
];

/// What keys do as controllers do it, wherever the dance is.
const PRESSES: [(Shortcut, Target); 4] = [
    (SHUFFLE, Target::Shuffle),
    (REPEAT, Target::Repeat),
    (LIVE, Target::Live),
    (FOLLOW_CLOCK, Target::FollowClock),
];

impl MusicRoom {
    /// The wishes of the keys.
    pub(super) fn keys(&mut self, shared: &mut Shared<'_>) -> Vec<Wish> {
        let mut wishes = Vec::new();
        if self.concert.is_none() && OPEN.pressed(&shared.ctx) {
            wishes.push(Wish::Choose(Then::Open));
        }
        if self.concert.is_none() || self.listening.is_none() {
            return wishes;
        }
        if let Some(calibrating) = &mut self.calibrating {
            calibrating.take_keys(&shared.ctx);
            return wishes;
        }
        if self.filming.asks() {
            return wishes;
        }
        for (key, target) in HEARING {
            if key.pressed(&shared.ctx) {
                self.ask(target, &Which::Press, shared, &mut wishes);
            }
        }
        let Some(concert) = &self.concert else { return wishes };
        let ctx = &shared.ctx;
        let when = |wishes: &mut Vec<Wish>, shortcut: Shortcut, wish: Wish| {
            if shortcut.pressed(ctx) {
                wishes.push(wish);
            }
        };
        when(&mut wishes, AUTOPILOT, Wish::Autopilot);
        when(&mut wishes, RECORD, Wish::Record);
        for (key, target) in PRESSES {
            when(&mut wishes, key, Wish::Press(target));
        }
        if concert.on_stage() {
            when(&mut wishes, HOLD, Wish::Hold);
            // Beside a stage with a window of its own, a close-up is left first.
            let is_closer = self.apart && concert.view() != View::Gallery;
            let leave = if is_closer { Wish::Show(View::Gallery) } else { Wish::Do(Action::LeaveStage) };
            when(&mut wishes, LEAVE, leave);
            when(&mut wishes, GO, Wish::Do(Action::Go));
            for (key, target) in [(BLACKOUT, Target::Blackout), (FREEZE, Target::Freeze)] {
                when(&mut wishes, key, Wish::Press(target));
            }
        }
        when(&mut wishes, FILM, Wish::Film);
        if concert.on_stage() && !self.apart {
            when(&mut wishes, MARK_LEFT, Wish::StepInTurn(false));
            when(&mut wishes, MARK_RIGHT, Wish::StepInTurn(true));
            return wishes;
        }
        when(&mut wishes, OPEN, Wish::Choose(Then::Open));
        when(&mut wishes, SAVE, Wish::Choose(Then::SaveShow));
        when(&mut wishes, BREED, Wish::Do(Action::Breed));
        let gallery = concert.instrument().gallery();
        // With Shift first: the key without it would answer, too.
        let go = [(FORTH, gallery.forth()), (FORTH_BY_Y, gallery.forth()), (BACK, gallery.back())];
        for (key, generation) in go {
            if key.pressed(ctx)
                && let Some(generation) = generation
            {
                wishes.push(Wish::Do(Action::GoTo { generation }));
            }
        }
        if !concert.instrument().favorites().is_empty() {
            when(&mut wishes, SHOW, Wish::Do(Action::PerformFavorites { first: 0 }));
        }
        if let Some(item) = concert.marked() {
            for (key, target) in MARKED {
                if key.pressed(ctx) {
                    wishes.extend(dance(target, &Which::Press, concert));
                }
            }
            when(&mut wishes, DRAW, Wish::Show(View::CloseUp(item)));
        }
        if concert.view() != View::Gallery {
            when(&mut wishes, LEAVE, Wish::Show(View::Gallery));
            return wishes;
        }
        for (key, (right, down)) in MARKS.iter().zip([(-1, 0), (1, 0), (0, -1), (0, 1)]) {
            when(&mut wishes, *key, Wish::Mark { right, down });
        }
        wishes
    }

    /// Adds the wishes of the controllers.
    pub(super) fn follow_remote(&mut self, shared: &mut Shared<'_>, wishes: &mut Vec<Wish>) {
        let (Some(concert), Some(listening)) = (&self.concert, &mut self.listening) else { return };
        let parameters = concert.instrument().parameters();
        let music = &mut shared.settings.music;
        let stand = Stand {
            concert,
            listening,
            looks: look::seen(concert.instrument(), music.looks()),
            blur: look_on_stage(concert.instrument(), music.look()).finish.blur,
            follows_clock: music.follows_clock,
            shelf: &self.drawers.shelf,
            taken: &self.taken,
        };
        let standing = |target: Target, number: Option<u32>| stand.of(target, number);
        let Asked { cues, clock } = self.drawers.remote.asked(music, parameters, &standing, shared.notices);
        let now_secs = shared.ctx.input(|input| input.time);
        listening.want_clock(music.follows_clock);
        for (said, came) in clock {
            listening.hear_clock(said, now_secs - came.elapsed().as_secs_f64());
        }
        let now = Now {
            at_secs: now_secs,
            beat: listening.sent_beat(),
            beat_at: listening.heard_at(),
            tempo_bpm: listening.beat_moment().tempo_bpm,
            progress: listening.progress(),
            bands: &listening.spectrum().0.mid,
            ahead_secs: listening.ahead_secs(),
        };
        self.drawers.remote.tell(music, &now, &shared.ctx);
        if !cues.is_empty() {
            self.leaning.end();
        }
        for cue in cues {
            match cue {
                Cue::Do(action) => {
                    let before = self
                        .concert
                        .as_ref()
                        .and_then(|concert| preceding(&action, concert.instrument().parameters()));
                    if before.is_some() {
                        shared.notices.done(
                            "All dances have the µ of the knob now (Knobs, Each its own µ).".to_owned(),
                        );
                    }
                    wishes.extend(before.into_iter().chain([action]).map(Wish::Do));
                }
                Cue::Ask(target, which) => self.ask(target, &which, shared, wishes),
            }
        }
    }
}
