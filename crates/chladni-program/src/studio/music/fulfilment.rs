//! Doing what bars, drawers and keys have asked for.

use chladni_music::{Action, Which};

use super::MusicRoom;
use super::drawer::Drawer;
use super::listening::Listening;
use super::shows::take;
use super::wish::Wish;
use crate::studio::room::Shared;

impl MusicRoom {
    pub(super) fn fulfil(&mut self, wish: Wish, shared: &mut Shared<'_>) {
        match wish {
            Wish::Choose(then) => return self.ask_for(then, shared),
            Wish::Do(action @ Action::NewGallery { .. }) => return self.begin_gallery(action, shared),
            Wish::Record => return self.record(shared),
            Wish::Calibrate => return self.calibrate(shared),
            Wish::Press(target) => {
                let mut wishes = Vec::new();
                self.ask(target, &Which::Press, shared, &mut wishes);
                return wishes.into_iter().for_each(|wish| self.fulfil(wish, shared));
            }
            _ => {}
        }
        let Some(concert) = &mut self.concert else { return };
        let done = match wish {
            Wish::Do(action) => concert.act(action),
            // The end of the autopilot returns knobs to where they were: it comes before they are set.
            Wish::Experiment => concert.end_piloting().and_then(|()| concert.act_all(concert.experiment())),
            Wish::Show(view) => {
                concert.look_at(view);
                Ok(())
            }
            Wish::TryOut(preset) => {
                concert.try_out(&preset);
                Ok(())
            }
            Wish::Mark { right, down } => {
                concert.mark_neighbor(right, down);
                Ok(())
            }
            Wish::Autopilot => {
                self.drawers.shelf.ready(shared.folders.dances.as_deref(), shared.notices);
                concert.pilot(self.drawers.shelf.kept())
            }
            Wish::Hold => {
                concert.hold();
                Ok(())
            }
            Wish::StepFavorite(forward) | Wish::StepInTurn(forward) if concert.is_piloted() => {
                concert.overrule(forward)
            }
            Wish::StepFavorite(forward) => match concert.next_favorite(forward) {
                Some(action) => concert.act(action),
                None => Ok(()),
            },
            Wish::StepInTurn(forward) => match concert.next_in_turn(forward) {
                Some(action) => concert.act(action),
                None => Ok(()),
            },
            Wish::Keep(item) => {
                self.drawers.open = Drawer::Shelf;
                self.drawers.shelf.ask(concert.instrument(), item);
                Ok(())
            }
            Wish::Take(preset) => {
                let name = preset.name.clone();
                take(concert, *preset, shared).map(|item| self.taken.became(item, name))
            }
            Wish::Discard(path) => self.drawers.shelf.discard(&path),
            Wish::Film => {
                let named = |ears: &Listening| Some((ears.song_number()?, ears.source_name()));
                self.filming.ask(self.listening.as_ref().and_then(named))
            }
            Wish::Choose(_) | Wish::Record | Wish::Calibrate | Wish::Press(_) => Ok(()),
        };
        if let Err(why) = done {
            shared.notices.warn(why);
        }
    }
}
