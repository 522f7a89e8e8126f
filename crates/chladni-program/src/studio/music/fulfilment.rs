//! Doing what bars, drawers and keys have asked for.

use chladni_music::{Action, Which};

use super::MusicRoom;
use super::drawer::Drawer;
use super::hands::action_on;
use super::listening::Listening;
use super::shows::take;
use super::wish::Wish;
use crate::studio::room::{Room, Shared};
use crate::studio::theme;

impl MusicRoom {
    pub(super) fn fulfil(&mut self, wish: Wish, shared: &mut Shared<'_>) {
        let done = match (wish, &mut self.concert) {
            (Wish::Choose(then), _) => return self.ask_for(then, shared),
            (Wish::Open(path), _) => return self.open(&[path], shared),
            (Wish::Do(action @ Action::NewGallery { .. }), _) => return self.begin_gallery(action, shared),
            (Wish::Record, _) => return self.record(shared),
            (Wish::RecordAtOnce, _) => return self.record_at_once(shared),
            (Wish::Calibrate, _) => return self.calibrate(shared),
            (Wish::Press(target), _) => {
                let mut wishes = Vec::new();
                self.ask(target, &Which::Press, shared, &mut wishes);
                return wishes.into_iter().for_each(|wish| self.fulfil(wish, shared));
            }
            (_, None) => return,
            (Wish::Do(action), Some(concert)) => concert.act(action),
            (Wish::Dance(target, item), Some(concert)) => match action_on(target, item, concert) {
                Some(action) => concert.act(action),
                None => return,
            },
            (Wish::Black, Some(concert)) => return concert.house.toggle_black(),
            (Wish::Freeze, Some(concert)) => {
                concert.house.frozen ^= true;
                return;
            }
            // The end of the autopilot returns knobs to where they were: it comes before they are set.
            (Wish::Experiment, Some(concert)) => {
                concert.end_piloting().and_then(|()| concert.act_all(concert.experiment()))
            }
            (Wish::Stand(given), Some(concert)) => return concert.stand(given),
            (Wish::Show(view), Some(concert)) => return concert.look_at(view),
            (Wish::TryOut(preset), Some(concert)) => return concert.try_out(&preset),
            (Wish::Mark { right, down }, Some(concert)) => return concert.mark_neighbor(right, down),
            (Wish::Autopilot, Some(concert)) => {
                self.drawers.shelf.ready(shared.folders.dances.as_deref(), shared.notices);
                concert.pilot(self.drawers.shelf.kept(), &shared.settings.music.look())
            }
            (Wish::Hold, Some(concert)) => return concert.hold(),
            (Wish::StepFavorite(forward) | Wish::StepInTurn(forward), Some(concert))
                if concert.is_piloted() =>
            {
                concert.overrule(forward)
            }
            (Wish::StepFavorite(forward), Some(concert)) => match concert.next_favorite(forward) {
                Some(action) => concert.act(action),
                None => return,
            },
            (Wish::StepInTurn(forward), Some(concert)) => match concert.next_in_turn(forward) {
                Some(action) => concert.act(action),
                None => return,
            },
            (Wish::Keep(item), Some(concert)) => {
                self.drawers.open = Drawer::Shelf;
                return self.drawers.shelf.ask(concert.instrument(), item);
            }
            (Wish::Take(preset), Some(concert)) => {
                let name = preset.name.clone();
                take(concert, *preset, shared).map(|item| self.taken.became(item, name))
            }
            (Wish::Discard(path), Some(_)) => self.drawers.shelf.discard(&path),
            (Wish::Film, Some(_)) => {
                let named = |ears: &Listening| Some((ears.song_number()?, ears.source_name()));
                let titles = shared.settings.music.song_titles;
                self.filming.ask(self.listening.as_ref().and_then(named), titles)
            }
        };
        if let Err(why) = done {
            // Errors of the engine begin in lower case.
            shared.notices.warn(theme::capitalized(&why.to_string()));
        }
    }
}
