//! What dances now, as a show of its own.

use chladni_music::{Action, LoggedAction, Moment, Show, Switch};

use crate::studio::music::view::View;

/// The show that begins where this one stands now, and lasts for one song.
pub fn as_it_is(mut show: Show, view: View, on_stage: bool, favorites: usize) -> Show {
    for line in &mut show.actions {
        line.moment = Moment::default();
    }
    let mut now = |action| show.actions.push(LoggedAction { moment: Moment::default(), action });
    match view {
        // Alone, even if the beat was set to step.
        View::CloseUp(item) => now(Action::Perform { item }),
        _ if on_stage => {}
        _ if favorites > 0 => {
            // In turn, even if the beat was not set to step.
            now(Action::Switch { switch: Switch::BeatSteps, on: true });
            now(Action::PerformFavorites { first: 0 });
        }
        _ => {}
    }
    // What left the stage long ago does not come back to fade out.
    if let Some(last) = show.actions.iter().rposition(|line| line.action.opens_stage()) {
        let line = |action| LoggedAction { moment: Moment::default(), action };
        let opening = if goes_on_in_turn(&show.actions[..=last]) {
            Vec::from(brought_at_once(&show.actions[..last]).map(line))
        } else {
            vec![line(Action::LeaveStage), show.actions[last].clone()]
        };
        show.actions.splice(last..=last, opening);
    }
    show.unheard()
}

/// Whether the last of these actions brings a dance from which a gallery on stage may go on in turn.
fn goes_on_in_turn(actions: &[LoggedAction]) -> bool {
    let mut latest_first = actions.iter().rev().map(|line| &line.action);
    let is_brought = latest_first.next() == Some(&Action::Go);
    let opens_or_leaves =
        |action: &Action| *action == Action::LeaveStage || *action != Action::Go && action.opens_stage();
    let before = latest_first.find(|action| opens_or_leaves(action));
    is_brought && matches!(before, Some(Action::PerformGallery { .. }))
}

/// [`Action::Go`] without the transition, where something is on stage: by the fader, which then stands where it did after
/// the actions `before`.
fn brought_at_once(before: &[LoggedAction]) -> [Action; 4] {
    let fade = |share| Action::Crossfade { share };
    let stood = before.iter().rev().find_map(|line| match line.action {
        Action::Crossfade { share } => Some(share),
        _ => None,
    });
    // Its far end is one of both. It keeps the look, unlike what it stands for.
    [fade(0.0), fade(1.0), fade(stood.unwrap_or(0.0)), Action::SetLook { look: String::new() }]
}

#[cfg(test)]
mod tests {
    use chladni_music::{GalleryShape, Instrument, Parameter};

    use super::*;

    #[test]
    fn favorites_in_turn_are_all_seen() {
        let shape = GalleryShape { eigenvalues: (0..32).map(f64::from).collect(), bands: 16 };
        let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
        for (item, secs) in [(1, 2.0), (4, 5.0), (5, 9.0)] {
            let moment = Moment { at_secs: secs, at_beat: 2.0 * secs };
            instrument.apply(moment, Action::Favorite { item, on: true }).unwrap();
        }
        let show = as_it_is(Show::of(&instrument), View::Gallery, false, 3);
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
            let filmed = as_it_is(Show::of(&instrument), View::Gallery, true, 0);
            let filmed = filmed.replay(shape.clone()).unwrap();
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
            let show = as_it_is(Show::of(&instrument), view, favorites == 0, favorites);
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
        let seen = |view, on_stage| {
            let show = as_it_is(Show::of(&instrument), view, on_stage, 1);
            show.replay(shape.clone()).unwrap().scene(8.0).unwrap().to
        };
        let items = instrument.gallery().items();
        assert_eq!(seen(View::CloseUp(2), true), items[2].id);
        assert_eq!(seen(View::Gallery, true), items[4].id);
        assert_eq!(seen(View::Gallery, false), items[1].id);
    }
}
