//! What dances now, as a show of its own.

use chladni_music::{Action, LoggedAction, Moment, Show, Switch};

use crate::studio::music::view::View;

/// What is on stage now.
#[derive(Clone, Debug, Default)]
pub struct OnStage {
    /// The place of the dance among those that are shown in turn, where it is one of them.
    pub place: Option<usize>,
    /// The name of the look over it; empty where that is the show's own.
    pub look: String,
}

/// The show that begins where this one stands now, and lasts for one song.
pub fn as_it_is(mut show: Show, view: View, on_stage: Option<&OnStage>, favorites: usize) -> Show {
    for line in &mut show.actions {
        line.moment = Moment::default();
    }
    let mut now = |action| show.actions.push(at_first(action));
    match (view, on_stage) {
        // Alone, even if the beat was set to step.
        (View::CloseUp(item), _) => now(Action::Perform { item }),
        (_, Some(OnStage { place: Some(place), look })) => go_on_in_turn(&mut show.actions, *place, look),
        (_, None) if favorites > 0 => {
            // In turn, even if the beat was not set to step.
            now(Action::Switch { switch: Switch::BeatSteps, on: true });
            now(Action::PerformFavorites { first: 0 });
        }
        _ => {}
    }
    // What left the stage long ago does not come back to fade out.
    if let Some(last) = show.actions.iter().rposition(|line| line.action.opens_stage()) {
        show.actions.insert(last, at_first(Action::LeaveStage));
    }
    show.unheard()
}

/// An action at the very beginning.
fn at_first(action: Action) -> LoggedAction {
    LoggedAction { moment: Moment::default(), action }
}

/// The dances in turn begin with the one that the beat, or a hand, has come to, in its look.
fn go_on_in_turn(actions: &mut Vec<LoggedAction>, place: usize, look: &str) {
    let opens_list = |line: &LoggedAction| {
        matches!(line.action, Action::PerformGallery { .. } | Action::PerformFavorites { .. })
    };
    let Some(at) = actions.iter().rposition(opens_list) else { return };
    if let Some(LoggedAction { action: Action::PerformGallery { first }, .. }) = actions.get_mut(at) {
        // The gallery as it was then; nothing is brought that has come already.
        *first = place;
        let since = actions.split_off(at + 1);
        let brings = |action: &Action| matches!(action, Action::Go | Action::CueUp { .. });
        actions.extend(since.into_iter().filter(|line| !brings(&line.action)));
    } else {
        // The favorites as they are now.
        actions.push(at_first(Action::PerformFavorites { first: place }));
    }
    actions.push(at_first(Action::SetLook { look: look.to_owned() }));
}

#[cfg(test)]
mod tests {
    use chladni_music::{GalleryShape, Instrument, Parameter};

    use super::*;

    /// What a film of the stage as it is after `beat` beats begins with.
    fn filmed(instrument: &Instrument, beat: f64) -> Instrument {
        let look = instrument.look().unwrap_or_default().to_owned();
        let on_stage = OnStage { place: instrument.place_in_turn(beat), look };
        let show = as_it_is(Show::of(instrument), View::Gallery, Some(&on_stage), 3);
        show.replay(instrument.shape().clone()).unwrap()
    }

    #[test]
    fn dances_in_turn_are_filmed_from_the_one_of_now() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let step = f64::from(Parameter::BeatsPerStep.initial());
        let steps = |on| Action::Switch { switch: Switch::BeatSteps, on };
        for of_gallery in [false, true] {
            let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
            let mut act = |at_beat: f64, action| {
                instrument.apply(Moment { at_secs: 0.5 * at_beat, at_beat }, action).unwrap();
            };
            (0..6).for_each(|item| act(0.0, Action::Favorite { item, on: true }));
            act(0.0, Action::Perform { item: 2 });
            act(0.0, steps(true));
            let [of_favorites, of_all] =
                [Action::PerformFavorites { first: 0 }, Action::PerformGallery { first: 0 }];
            act(1.0, if of_gallery { of_all } else { of_favorites });
            act(2.0, Action::SetLook { look: "ember".into() });
            act(3.0, Action::Favorite { item: 5, on: false });
            let beat = 1.0 + 3.5 * step;
            let ids: Vec<_> = instrument.gallery().items().iter().map(|item| item.id).collect();
            let film = filmed(&instrument, beat);
            let scene = film.scene(0.0).unwrap();
            assert_eq!((scene.from, scene.to, film.look()), (ids[3], ids[3], Some("ember")));
            assert_eq!(film.scene(1.5 * step).unwrap().to, ids[4]);
            // Where the beat steps no longer, it stays there.
            instrument.apply(Moment { at_secs: 0.5 * beat, at_beat: beat }, steps(false)).unwrap();
            assert_eq!(filmed(&instrument, beat + 100.0).scene(9.5 * step).unwrap().to, ids[3]);
        }
    }

    #[test]
    fn favorites_in_turn_are_all_seen() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
        for (item, secs) in [(1, 2.0), (4, 5.0), (5, 9.0)] {
            let moment = Moment { at_secs: secs, at_beat: 2.0 * secs };
            instrument.apply(moment, Action::Favorite { item, on: true }).unwrap();
        }
        let show = as_it_is(Show::of(&instrument), View::Gallery, None, 3);
        let filmed = show.replay(shape).unwrap();
        let step = f64::from(Parameter::BeatsPerStep.initial());
        let seen: Vec<_> = (0..4).map(|i| filmed.scene((f64::from(i) + 0.9) * step).unwrap().to).collect();
        let favorites: Vec<_> = instrument.favorites().iter().map(|item| item.id).collect();
        assert_eq!(seen, [favorites[0], favorites[1], favorites[2], favorites[0]]);
    }

    #[test]
    fn a_gallery_in_turn_goes_on_from_the_dance_that_was_brought() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        // The fader stands nearer to one end or to the other.
        for share in [0.25, 0.75] {
            let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
            for (secs, action) in [
                (0.0, Action::Switch { switch: Switch::BeatSteps, on: true }),
                (1.0, Action::Crossfade { share }),
                (2.0, Action::PerformGallery { first: 0 }),
                (3.0, Action::SetLook { look: "ember".into() }),
                (4.0, Action::CueUp { item: 3 }),
                (5.0, Action::Go),
            ] {
                instrument.apply(Moment { at_secs: secs, at_beat: 2.0 * secs }, action).unwrap();
            }
            let filmed = filmed(&instrument, 10.0);
            let step = f64::from(Parameter::BeatsPerStep.initial());
            let seen: Vec<_> =
                (0..4).map(|i| filmed.scene((f64::from(i) + 0.9) * step).unwrap().to).collect();
            let ids: Vec<_> = instrument.gallery().items().iter().map(|item| item.id).collect();
            assert_eq!(seen, [ids[3], ids[4], ids[5], ids[0]]);
            let first = filmed.scene(0.0).unwrap();
            assert_eq!((first.from, first.to), (ids[3], ids[3]));
            assert_eq!((filmed.fader(), filmed.look(), filmed.next_on_stage()), (share, None, None));
        }
    }

    #[test]
    fn a_film_begins_with_what_dances_now_alone() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
        for (i, secs) in [(0, 2.0), (1, 9.0), (2, 16.0)] {
            let moment = Moment { at_secs: secs, at_beat: 2.0 * secs };
            instrument.apply(moment, Action::Favorite { item: 5 - i, on: true }).unwrap();
            instrument.apply(moment, Action::Perform { item: i }).unwrap();
        }
        let first = |view, favorites| {
            let on_stage = (favorites == 0).then(OnStage::default);
            let show = as_it_is(Show::of(&instrument), view, on_stage.as_ref(), favorites);
            show.replay(shape.clone()).unwrap().scene(0.0).unwrap()
        };
        let items = instrument.gallery().items();
        for (view, favorites, dances) in [
            (View::Gallery, 0, items[2].id),
            (View::CloseUp(4), 0, items[4].id),
            (View::Gallery, 3, instrument.favorites()[0].id),
        ] {
            let scene = first(view, favorites);
            assert_eq!((scene.from, scene.to), (dances, dances), "{view:?}");
        }
    }

    #[test]
    fn a_close_up_is_filmed_before_the_stage_and_the_stage_before_favorites() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
        let moment = Moment { at_secs: 2.0, at_beat: 4.0 };
        instrument.apply(moment, Action::Favorite { item: 1, on: true }).unwrap();
        instrument.apply(moment, Action::Perform { item: 4 }).unwrap();
        let seen = |view, on_stage: bool| {
            let on_stage = on_stage.then(OnStage::default);
            let show = as_it_is(Show::of(&instrument), view, on_stage.as_ref(), 1);
            show.replay(shape.clone()).unwrap().scene(8.0).unwrap().to
        };
        let items = instrument.gallery().items();
        assert_eq!(seen(View::CloseUp(2), true), items[2].id);
        assert_eq!(seen(View::Gallery, true), items[4].id);
        assert_eq!(seen(View::Gallery, false), items[1].id);
    }
}
