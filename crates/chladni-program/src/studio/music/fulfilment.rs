//! Doing what bars, drawers and keys have asked for.

use std::path::Path;

use chladni_music::{Action, Preset, Which};

use super::MusicRoom;
use super::drawer::Drawer;
use super::shows::{save_as, save_show, take};
use super::wish::Wish;
use crate::studio::room::{Room, Shared};
use crate::work::Error;
use crate::work::formats::{LISTS, MESHES, PROJECT, SONGS};

impl MusicRoom {
    pub(super) fn fulfil(&mut self, wish: Wish, shared: &mut Shared<'_>) {
        if let Wish::Open | Wish::AddSongs = wish {
            return self.choose_files(matches!(wish, Wish::AddSongs), shared);
        }
        if let Wish::Record = wish {
            if let Err(why) = self.record(shared) {
                shared.notices.failed(why);
            }
            return;
        }
        if let Wish::Press(target) = wish {
            return self.ask(target, &Which::Press, shared, &mut Vec::new());
        }
        let (Some(concert), Some(listening)) = (&mut self.concert, &self.listening) else { return };
        let done = match wish {
            Wish::Do(action) => concert.act(action),
            Wish::Experiment => concert.experiment().into_iter().try_for_each(|action| concert.act(action)),
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
            Wish::Autopilot => concert.pilot(self.drawers.shelf.kept()),
            Wish::Hold => {
                concert.hold();
                Ok(())
            }
            Wish::StepFavorite(forward) if concert.is_piloted() => concert.overrule(forward),
            Wish::StepFavorite(forward) => match concert.next_favorite(forward) {
                Some(first) => concert.act(Action::PerformFavorites { first }),
                None => Ok(()),
            },
            Wish::Keep(item) => {
                self.drawers.open = Drawer::Shelf;
                self.drawers.shelf.ask(concert.instrument(), item);
                Ok(())
            }
            Wish::Take(preset) => take(concert, *preset, shared),
            Wish::Discard(path) => self.drawers.shelf.discard(&path),
            Wish::SavePreset(item) => match concert.instrument().item(item) {
                Some(item) => {
                    let preset = Preset::of(concert.instrument(), item, Vec::new());
                    let save = |path: &Path| preset.save(path).map_err(Error::unsaved);
                    save_as("dance.toml", shared, save).map(drop)
                }
                None => Ok(()),
            },
            Wish::SaveShow => save_show(concert, listening, &self.names, shared).map(drop),
            Wish::Film => self.filming.ask(),
            Wish::Open | Wish::AddSongs | Wish::Press(_) | Wish::Record => Ok(()),
        };
        if let Err(why) = done {
            shared.notices.warn(why);
        }
    }

    fn choose_files(&mut self, songs_only: bool, shared: &mut Shared<'_>) {
        let all: Vec<&str> = MESHES.into_iter().chain(self.extensions()).chain([PROJECT]).collect();
        let songs: Vec<&str> = SONGS.into_iter().chain(LISTS).collect();
        let kinds =
            [("All that dances or sounds", &all[..]), ("Meshes", &MESHES), ("Songs and lists", &songs)];
        let paths = shared.chooser.open_several(if songs_only { &kinds[2..] } else { &kinds });
        if !paths.is_empty() {
            self.open(&paths, shared);
        }
    }
}
