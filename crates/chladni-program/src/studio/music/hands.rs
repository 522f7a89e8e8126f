//! Requests of controllers to the room, and the room's values for them.

use chladni_music::{Action, ItemId, Kind, Looks, REPEATS, SHOTS, Target, Which};
use chladni_sound::{LONGEST_CROSSFADE_SECS, PlayerState, Repeat};
use chladni_view::{Background, Lights, Look, Material, Palette};

use super::MusicRoom;
use super::concert::Concert;
use super::listening::Listening;
use super::look;
use super::remote::NUDGE_SECS;
use super::shelf::Shelf;
use super::wish::{A_LITTLE, Wish};
use crate::studio::room::Shared;
use crate::work::OWN_COLORS;

/// Where things stand, for knobs that take over softly and for the lights of pads.
pub struct Stand<'a> {
    pub concert: &'a Concert,
    pub listening: &'a Listening,
    /// Those that are seen.
    pub looks: Looks,
    /// How soft is what is not in focus, in [0, 1].
    pub blur: f32,
    pub follows_clock: bool,
    pub shelf: &'a Shelf,
    pub taken: &'a Taken,
}

/// The presets that were taken, by the dances that they became.
#[derive(Default)]
pub struct Taken(Vec<(ItemId, String)>);

impl Taken {
    /// A preset of this name is a dance of the gallery now.
    pub fn became(&mut self, item: ItemId, name: String) {
        self.0.retain(|(known, _)| *known != item);
        self.0.push((item, name));
    }

    /// The name of the preset that plays: on stage, or else the last one that the gallery has.
    fn playing(&self, concert: &Concert) -> Option<&str> {
        let items = concert.instrument().gallery().items();
        let plays = |id: ItemId| match concert.on_stage_now() {
            Some(staged) => staged == id,
            None => items.iter().any(|item| item.id == id),
        };
        self.0.iter().rev().find(|(id, _)| plays(*id)).map(|(_, name)| name.as_str())
    }
}

/// Repeats, in the order of their names.
const REPEAT: [Repeat; REPEATS.len()] = [Repeat::Off, Repeat::Song, Repeat::List];

impl Stand<'_> {
    /// In [0, 1]; of a choice or a dance, whether it is the one of that number.
    pub fn of(&self, target: Target, number: Option<u32>) -> Option<f32> {
        let instrument = self.concert.instrument();
        let share = |on: bool| Some(f32::from(u8::from(on)));
        let is = |at: Option<usize>| share(at == Some((number? as usize).checked_sub(1)?));
        let item = || {
            let marked = self.concert.marked();
            number.map_or(marked, |number| (number as usize).checked_sub(1))
        };
        let marks = || item().map(|item| self.concert.marks(item));
        match target {
            Target::Look | Target::Palette | Target::Material | Target::Lights | Target::Background => {
                let (chosen, names) = (chosen(target, &self.looks)?, names(target));
                is(names.iter().position(|name| name == chosen))
            }
            Target::Shot => is(self.listening.called_shot()),
            Target::Song => is(Some(self.listening.player().status().song)),
            Target::Choose => share(marks()?.chosen),
            Target::Favorite => share(marks()?.favorite),
            Target::Lock => share(marks()?.locked),
            Target::Stage | Target::Cue => {
                let id = instrument.gallery().items().get(item()?)?.id;
                let next = instrument.next_on_stage().map(|(next, _)| next);
                let there = if target == Target::Cue { next } else { self.concert.on_stage_now() };
                share(there == Some(id))
            }
            Target::Crossfade => Some(instrument.fader()),
            Target::Volume => Some(self.listening.volume()),
            Target::SongFade => Some((self.listening.song_fade_secs() / LONGEST_CROSSFADE_SECS) as f32),
            Target::Blackout => share(self.concert.house.is_black()),
            Target::Freeze => share(self.concert.house.frozen),
            Target::Autopilot => share(self.concert.is_piloted()),
            Target::Stay => share(self.concert.is_held()),
            Target::HoldTempo => share(self.listening.is_locked()),
            Target::PlayPause => share(self.listening.player().status().state == PlayerState::Playing),
            Target::LeaveStage => share(self.concert.on_stage()),
            Target::Blur => Some(self.blur),
            Target::Repeat => is(REPEAT.iter().position(|repeat| *repeat == self.listening.repeat())),
            Target::Live => share(self.listening.live().is_some()),
            Target::FollowClock => share(self.follows_clock),
            Target::Record => share(self.concert.outgoing.is_recording()),
            Target::Preset => {
                let preset = self.shelf.presets().nth((number? as usize).checked_sub(1)?)?;
                share(self.taken.playing(self.concert) == Some(preset.name.as_str()))
            }
            _ => target.standing(number, instrument.parameters()),
        }
    }
}

/// The names that a part of the look may have; empty for targets that are none.
fn names(target: Target) -> Vec<&'static str> {
    match target {
        Target::Look => Look::PRESETS.iter().map(|preset| preset.0).collect(),
        Target::Palette => Palette::ALL.map(Palette::name).into_iter().chain([OWN_COLORS]).collect(),
        Target::Material => Material::PRESETS.map(|preset| preset.0).to_vec(),
        Target::Lights => Lights::PRESETS.map(|preset| preset.0).to_vec(),
        Target::Background => Background::PRESETS.map(|preset| preset.0).to_vec(),
        _ => Vec::new(),
    }
}

fn chosen(target: Target, looks: &Looks) -> Option<&String> {
    Some(match target {
        Target::Look => &looks.look,
        Target::Palette => &looks.palette,
        Target::Material => &looks.material,
        Target::Lights => &looks.lights,
        Target::Background => &looks.background,
        _ => return None,
    })
}

/// The one of `names` that is asked for; a press takes the one after `now`.
fn pick(names: &[impl AsRef<str>], now: Option<usize>, which: &Which) -> Option<usize> {
    let count = names.len();
    let at = match which {
        Which::Press => now.map_or(0, |now| (now + 1) % count.max(1)),
        Which::Number(number) => (*number as usize).checked_sub(1)?,
        Which::Name(name) => called(names, name).or_else(|| numbered(name))?,
        Which::Level(share) => ((share * count as f32) as usize).min(count.saturating_sub(1)),
    };
    (at < count).then_some(at)
}

/// The same, of things that have several names each: `names` holds all of one kind, then all of the next.
fn pick_by_any(names: &[Vec<String>], now: Option<usize>, which: &Which) -> Option<usize> {
    let by_name = match which {
        Which::Name(name) => names.iter().find_map(|names| called(names, name)),
        _ => None,
    };
    by_name.or_else(|| pick(names.first()?, now, which))
}

fn called(names: &[impl AsRef<str>], name: &str) -> Option<usize> {
    let name = name.to_lowercase();
    names.iter().position(|known| known.as_ref().to_lowercase() == name)
}

/// The place that a text means which is no name but a number, from 1.
fn numbered(text: &str) -> Option<usize> {
    text.parse::<usize>().ok()?.checked_sub(1)
}

/// The names of the songs of the list. Those of their files come first: they stay the same once tags are read.
fn names_of_songs(listening: &Listening) -> [Vec<String>; 3] {
    let kinds: [fn(&Listening, usize) -> String; 3] =
        [Listening::file_name_of, Listening::name_of, Listening::title_of];
    kinds.map(|name| (0..listening.songs().len()).map(|song| name(listening, song)).collect())
}

impl MusicRoom {
    /// Does a controller's request to the room, or says that there is no such thing.
    pub(super) fn ask(
        &mut self,
        target: Target,
        which: &Which,
        shared: &mut Shared<'_>,
        wishes: &mut Vec<Wish>,
    ) {
        if let (Target::Tap, Some(calibrating)) = (target, &mut self.calibrating) {
            return calibrating.tap(shared.ctx.input(|input| input.time));
        }
        let (Some(concert), Some(listening)) = (&mut self.concert, &mut self.listening) else { return };
        let found = match (target, which) {
            (Target::Shot, which) => call_shot(which, listening),
            (Target::Preset | Target::RandomPreset, which) => {
                self.take_preset(target == Target::RandomPreset, which, shared, wishes)
            }
            (Target::Song, which) => {
                let now = Some(listening.player().status().song);
                let song = pick_by_any(&names_of_songs(listening), now, which);
                song.inspect(|song| listening.select(*song)).is_some()
            }
            (Target::Crossfade, Which::Level(share)) => {
                wishes.push(Wish::Do(Action::Crossfade { share: *share }));
                true
            }
            (Target::Volume, Which::Level(share)) => {
                listening.set_volume(*share);
                shared.settings.music.volume = *share;
                true
            }
            (Target::SongFade, Which::Level(share)) => {
                shared.settings.music.song_fade_secs = f64::from(*share) * LONGEST_CROSSFADE_SECS;
                listening.set_song_fade_secs(shared.settings.music.song_fade_secs);
                true
            }
            (Target::Blur, Which::Level(share)) => {
                take_look(concert, shared);
                shared.settings.music.blur_percent = Some((100.0 * share).round() as u8);
                true
            }
            (Target::Repeat, which) => {
                let now = REPEAT.iter().position(|repeat| *repeat == listening.repeat());
                let repeat = pick(&REPEATS, now, which).and_then(|at| REPEAT.get(at));
                repeat.inspect(|repeat| listening.set_repeat(**repeat)).is_some()
            }
            (Target::FollowClock, Which::Press) => {
                shared.settings.music.follows_clock ^= true;
                true
            }
            (Target::Live, Which::Press) => {
                let name = shared.settings.music.live_input.as_deref();
                listening.toggle_live(name, &shared.ctx);
                true
            }
            (Target::Shuffle, Which::Press) => {
                // When a hand presses is random enough.
                listening.shuffle((1e6 * shared.ctx.input(|input| input.time)) as u64);
                true
            }
            (Target::Record, Which::Press) => {
                // On stage a question would stand before the audience.
                wishes.push(Wish::RecordAtOnce);
                true
            }
            (
                Target::Look | Target::Palette | Target::Material | Target::Lights | Target::Background,
                which,
            ) => choose_look(target, which, concert, shared),
            (target, which) => match dance(target, which, concert) {
                Some(wish) => {
                    wishes.push(wish);
                    true
                }
                None => press(target, concert, listening, wishes),
            },
        };
        if !found {
            let wanted = wanted(target, which);
            shared.notices.warn(format!("A controller asked for {wanted}, but there is none."));
        }
    }

    /// Takes a preset of the shelf; false where it has none of that name or number.
    fn take_preset(
        &mut self,
        any: bool,
        which: &Which,
        shared: &mut Shared<'_>,
        wishes: &mut Vec<Wish>,
    ) -> bool {
        let shelf = &mut self.drawers.shelf;
        shelf.ready(shared.folders.dances.as_deref(), shared.notices);
        let presets: Vec<_> = shelf.presets().collect();
        let names: Vec<&str> = presets.iter().map(|preset| preset.name.as_str()).collect();
        let at = if any {
            // When a hand presses is random enough.
            let micros = (1e6 * shared.ctx.input(|input| input.time)) as usize;
            Some(micros.wrapping_mul(2_654_435_761) % names.len().max(1))
        } else {
            pick(&names, self.preset, which)
        };
        let preset = at.and_then(|at| presets.get(at));
        self.preset = at.or(self.preset);
        wishes.extend(preset.map(|preset| Wish::Take(Box::new((*preset).clone()))));
        preset.is_some()
    }
}

/// The thing that `target` was to do something with, in words.
fn wanted(target: Target, which: &Which) -> String {
    let thing = match target {
        Target::RandomPreset => "preset",
        Target::Lights => "light",
        _ if target.kind() == Kind::Dance => "dance",
        _ => target.name(),
    };
    match which {
        Which::Number(number) => format!("{thing} {number}"),
        Which::Name(name) => format!("a {thing} called {name}"),
        Which::Press if target.kind() == Kind::Dance => format!("a marked {thing}"),
        Which::Press | Which::Level(_) => format!("a {thing}"),
    }
}

/// Calls a shot of the camera; false where there is none of that name or number.
fn call_shot(which: &Which, listening: &mut Listening) -> bool {
    let now = listening.called_shot();
    let shot = pick(&SHOTS, now, which);
    // The camera chooses again where its shot is called once more, or where it is asked to.
    listening.call_shot(shot.filter(|_| shot != now));
    shot.is_some() || matches!(which, Which::Name(name) if name == "auto")
}

/// Makes the autopilot's look the show's own, where there is one: a hand changes what is seen. At once, as another request of
/// this frame may change the look, too.
fn take_look(concert: &mut Concert, shared: &mut Shared<'_>) {
    let (instrument, music) = (concert.instrument(), &mut shared.settings.music);
    if instrument.look().is_some() {
        music.look_like(&look::seen(instrument, music.looks()));
        if let Err(why) = concert.act(Action::SetLook { look: String::new() }) {
            shared.notices.failed(why);
        }
    }
}

/// Chooses a look, or a part of one; false where there is none of that name or number.
fn choose_look(target: Target, which: &Which, concert: &mut Concert, shared: &mut Shared<'_>) -> bool {
    let looks = look::seen(concert.instrument(), shared.settings.music.looks());
    let names = names(target);
    let now = chosen(target, &looks).and_then(|now| names.iter().position(|name| name == now));
    let Some(name) = pick(&names, now, which).and_then(|at| names.get(at)) else { return false };
    let name = (*name).to_owned();
    take_look(concert, shared);
    let music = &mut shared.settings.music;
    match target {
        Target::Look => music.put_on(name),
        Target::Palette => music.palette = name,
        Target::Material => music.material = name,
        Target::Lights => music.lights = name,
        _ => music.background = name,
    }
    true
}

/// The wish for a dance of the gallery; `None` if there is no such dance, or the target is not about dances.
pub(super) fn dance(target: Target, which: &Which, concert: &Concert) -> Option<Wish> {
    let items = concert.instrument().gallery().items();
    let item = match which {
        Which::Number(number) => (*number as usize).checked_sub(1)?,
        Which::Name(name) => items.iter().position(|item| item.name == *name).or_else(|| numbered(name))?,
        _ => concert.marked()?,
    };
    items.get(item)?;
    (target.kind() == Kind::Dance).then_some(Wish::Dance(target, item))
}

/// The action of that wish, as the dance stands once earlier wishes are fulfilled.
pub(super) fn action_on(target: Target, item: usize, concert: &Concert) -> Option<Action> {
    let marks = concert.marks(item);
    Some(match target {
        Target::Choose => Action::Choose { item, on: !marks.chosen },
        Target::Favorite => Action::Favorite { item, on: !marks.favorite },
        Target::Lock => Action::Lock { item, on: !marks.locked },
        Target::Mutate => Action::Mutate { item, amount: A_LITTLE },
        Target::Stage => Action::PerformGallery { first: item },
        Target::Cue => Action::CueUp { item },
        _ => return None,
    })
}

/// A button was pressed; false where the target is none.
fn press(target: Target, concert: &Concert, listening: &mut Listening, wishes: &mut Vec<Wish>) -> bool {
    let gallery = concert.instrument().gallery();
    match target {
        Target::Back => {
            wishes.extend(gallery.back().map(|generation| Wish::Do(Action::GoTo { generation })));
        }
        Target::Forth => {
            wishes.extend(gallery.forth().map(|generation| Wish::Do(Action::GoTo { generation })));
        }
        Target::NextFavorite => wishes.push(Wish::StepFavorite(true)),
        Target::PreviousFavorite => wishes.push(Wish::StepFavorite(false)),
        Target::Go => wishes.push(Wish::Do(Action::Go)),
        Target::Blackout => wishes.push(Wish::Black),
        Target::Freeze => wishes.push(Wish::Freeze),
        Target::Autopilot => wishes.push(Wish::Autopilot),
        Target::Stay => wishes.push(Wish::Hold),
        Target::Tap => listening.tap(),
        Target::Halve => listening.halve(),
        Target::Double => listening.double(),
        Target::HoldTempo => listening.lock(!listening.is_locked()),
        Target::NudgeLater => listening.nudge(-NUDGE_SECS),
        Target::NudgeSooner => listening.nudge(NUDGE_SECS),
        Target::PlayPause => listening.toggle(),
        Target::NextSong => listening.next_song(true),
        Target::PreviousSong => listening.previous_song(true),
        _ => return false,
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_several_is_picked() {
        let names = ["one", "Two", "three"];
        let picked = |now, which| pick(&names, now, &which);
        assert_eq!(picked(None, Which::Press), Some(0));
        assert_eq!(picked(Some(2), Which::Press), Some(0));
        assert_eq!(picked(Some(2), Which::Number(2)), Some(1));
        assert_eq!((picked(None, Which::Number(0)), picked(None, Which::Number(4))), (None, None));
        assert_eq!(picked(None, Which::Name("two".into())), Some(1));
        assert_eq!(["3", "0", "4"].map(|text| picked(None, Which::Name(text.into()))), [Some(2), None, None]);
        assert_eq!([0.0, 0.4, 1.0].map(|share| picked(None, Which::Level(share))), [0, 1, 2].map(Some));
        assert_eq!(pick(&[""; 0], None, &Which::Press), None);
    }

    #[test]
    fn a_song_is_found_by_file_title_and_both_names() {
        let files = ["01 dawn", "02 dusk"].map(str::to_owned).to_vec();
        let full = ["Ada – Dawn", "02 dusk"].map(str::to_owned).to_vec();
        let titles = ["Dawn", "02 dusk"].map(str::to_owned).to_vec();
        let names = [files, full, titles];
        let picked = |name: &str| pick_by_any(&names, Some(1), &Which::Name(name.into()));
        assert_eq!(["01 Dawn", "ada – dawn", "dawn", "02 dusk"].map(picked), [0, 0, 0, 1].map(Some));
        assert_eq!(picked("noon"), None);
        assert_eq!((picked("1"), picked("3")), (Some(0), None));
        assert_eq!(pick_by_any(&names, Some(1), &Which::Press), Some(0));
    }

    #[test]
    fn a_name_that_is_a_number_comes_before_that_number() {
        let files = ["02", "1999", "01"].map(str::to_owned).to_vec();
        let titles = ["Ebb", "Flow", "2"].map(str::to_owned).to_vec();
        let names = [files.clone(), files, titles];
        let picked = |name: &str| pick_by_any(&names, None, &Which::Name(name.into()));
        assert_eq!(["01", "1999", "02", "2", "1"].map(picked), [2, 1, 0, 2, 0].map(Some));
    }

    #[test]
    fn a_thing_that_is_not_there_is_named_and_not_what_was_to_be_done_with_it() {
        let named = || Which::Name("x".into());
        assert_eq!(wanted(Target::Stage, &Which::Number(99)), "dance 99");
        assert_eq!(wanted(Target::Choose, &named()), "a dance called x");
        assert_eq!(wanted(Target::Cue, &Which::Press), "a marked dance");
        assert_eq!(wanted(Target::Song, &Which::Number(7)), "song 7");
        assert_eq!(wanted(Target::Lights, &named()), "a light called x");
        assert_eq!(wanted(Target::RandomPreset, &Which::Press), "a preset");
        assert_eq!(wanted(Target::Volume, &Which::Level(0.5)), "a volume");
    }

    #[test]
    fn parts_of_the_look_have_names() {
        let parts = Target::all().filter(|target| chosen(*target, &Looks::default()).is_some());
        assert!(parts.inspect(|part| assert!(names(*part).len() > 2, "{part:?}")).count() == 5);
    }
}
