//! The autopilot at work: dances, looks and strength change with the music, on any instrument.

use chladni_music::{
    Action, Autopilot, BarLine, Candidate, Form, GalleryItem, Instrument, ItemId, Parameter, Preset,
    Settings, Turn, repertoire,
};

use chladni_view::Look;

use super::Error;
use super::held::{holds_form, leave_out};

/// The dances while nobody chooses.
pub struct Programme {
    autopilot: Autopilot,
    dances: Vec<Preset>,
    /// Names of [`Look::PRESETS`]; none where the look stays.
    looks: Vec<&'static str>,
    /// Factor on the gain of each turn.
    gain: f32,
    /// The gain that the last turn set, and its own part of that.
    set: Option<(f32, f32)>,
    /// What the last dance's preset said.
    named: Settings,
    /// Bars up to then were heard.
    heard_secs: f64,
    /// The place in the gallery that the last turn took.
    place: usize,
    /// In which all dance, whatever their presets say, unless a form is held.
    form: Option<Form>,
    /// Changes that stay, whatever the presets say.
    held: Vec<Action>,
    /// Where the knobs of a dance stood when it began, and the generation that was seen.
    before: (Settings, usize),
    /// The first dance of that generation, by which it is known.
    first: Option<ItemId>,
}

impl Programme {
    /// The built-in dances and `favorites`, which come more often; from `at_secs` of a show on. Which come when follows
    /// from the instrument's seed and `draw`: another number, other dances and looks.
    ///
    /// # Errors
    /// Where the built-in dances cannot be read.
    pub fn new(
        instrument: &Instrument,
        favorites: Vec<Preset>,
        at_secs: f64,
        draw: u64,
    ) -> Result<Self, Error> {
        let mut dances = repertoire()?;
        let weights = vec![1; dances.len()].into_iter().chain(vec![Candidate::FAVORITE; favorites.len()]);
        let weights: Vec<u32> = weights.collect();
        dances.extend(favorites);
        let candidates =
            dances.iter().zip(weights).map(|(preset, weight)| Candidate::tagged(&preset.tags, weight));
        // Left out: the plain look, whose parts are chosen by hand, and near lenses, which need a chosen point
        // of view.
        let comes = |look: &Look| *look != Look::PLAIN && look.finish.blur <= 0.0;
        let looks: Vec<&str> =
            Look::PRESETS.iter().filter(|(_, look)| comes(look)).map(|(name, _)| *name).collect();
        Ok(Self {
            autopilot: Autopilot::new(
                instrument.seed().wrapping_add(draw),
                candidates.collect(),
                looks.len(),
            ),
            dances,
            looks,
            gain: instrument.parameters().get(Parameter::Gain),
            set: None,
            named: Settings::default(),
            heard_secs: at_secs,
            // The first turn takes the place before it.
            place: instrument.gallery().items().len().saturating_sub(1),
            form: None,
            held: Vec::new(),
            before: (instrument.parameters().of_a_dance(), instrument.gallery().current()),
            first: instrument.gallery().items().first().map(|item| item.id),
        })
    }

    /// On a flat sheet, where that is one: other forms than the modal one would not leave its plane.
    pub fn on_sheet(self, is_flat: bool) -> Self {
        Self { form: is_flat.then_some(Form::Modal), set: None, ..self }
    }

    /// In the look that there is, where that was chosen.
    pub fn keeping_look(self, keeps: bool) -> Self {
        Self { looks: if keeps { Vec::new() } else { self.looks }, ..self }
    }

    /// In this look until the second turn, as the first keeps it; not on a sheet, whose first turn has another one.
    pub fn opening_in(self, look: &Look) -> Self {
        // Effects may be left out of it, and a shape may have its own colors in it.
        let is_own =
            |known: Look| Look { finish: look.finish, own_colors: look.own_colors, ..known } == *look;
        let opening = self.looks.iter().position(|name| Look::named(name).is_some_and(is_own));
        let opening = opening.filter(|_| self.form.is_none());
        Self { autopilot: self.autopilot.opening_in(opening), ..self }
    }

    /// With what these changes set in all dances, whatever their presets say; a gain is still changed in each turn.
    pub fn keeping(self, held: Vec<Action>) -> Self {
        Self { held, ..self }
    }

    /// Bars up to then were heard.
    pub fn heard_secs(&self) -> f64 {
        self.heard_secs
    }

    /// Whether it keeps the current dance and look.
    pub fn holds(&self) -> bool {
        self.autopilot.holds()
    }

    /// Keeps the current dance and look, or goes on.
    pub fn hold(&mut self, on: bool) {
        self.autopilot.hold(on);
    }

    /// Hears the bars that begin up to `at_secs`; returns the actions to do, and when. While the fader brings the next
    /// dance, the current one stays: another would come with a jump.
    pub fn hear(&mut self, bars: &[BarLine], at_secs: f64, instrument: &Instrument) -> Vec<(f64, Action)> {
        self.follow_gain(instrument);
        self.heard_secs = at_secs;
        let (holds, next) = (self.holds(), instrument.next_on_stage());
        self.hold(holds || next.is_some_and(|(_, share)| share > 0.0));
        let mut actions = Vec::new();
        for bar in bars {
            if let Some(turn) = self.autopilot.hear(*bar) {
                actions.extend(self.actions(turn, instrument).map(|action| (bar.at_secs, action)));
            }
        }
        self.hold(holds);
        actions
    }

    /// The actions that bring the next dance on at once, or the one before.
    pub fn step(&mut self, at_secs: f64, forward: bool, instrument: &Instrument) -> Vec<Action> {
        self.follow_gain(instrument);
        let turn = self.autopilot.step(at_secs, forward);
        turn.into_iter().flat_map(|turn| self.actions(turn, instrument)).collect()
    }

    /// Whether it ends before `action` rather than after it: the gallery that then returns has the dance that is put on stage,
    /// and its others are to follow.
    pub fn ends_before(&self, action: &Action, instrument: &Instrument) -> bool {
        let Action::PerformGallery { first } = *action else { return false };
        let gallery = instrument.gallery();
        let dance = |items: &[GalleryItem]| items.get(first).map(|item| item.id);
        let returning = gallery.generations().get(self.returning(instrument));
        let returning = returning.and_then(|generation| dance(&generation.items));
        returning.is_some() && returning == dance(gallery.items())
    }

    /// The generation that was seen when it began, or the first one where another gallery has taken the place of that.
    fn returning(&self, instrument: &Instrument) -> usize {
        let seen = instrument.gallery().generations().get(self.before.1);
        let first = seen.and_then(|generation| generation.items.first()).map(|item| item.id);
        if first == self.first { self.before.1 } else { 0 }
    }

    /// Actions that end the programme, once the stage is left or shows another dance: gallery and knobs return to
    /// where they were when it began.
    pub fn end(&self, instrument: &Instrument) -> Vec<Action> {
        let (before, generation) = (&self.before.0, self.returning(instrument));
        let now = instrument.parameters().of_a_dance();
        let mut actions = Vec::new();
        let gallery = instrument.gallery();
        if gallery.current() != generation {
            actions.push(Action::GoTo { generation });
        }
        let form = before.form.filter(|_| before.form != now.form);
        let choir = before.choir.filter(|_| before.choir != now.choir);
        let harmonics = before.harmonics.filter(|_| before.harmonics != now.harmonics);
        actions.extend(form.map(|form| Action::SetForm { form }));
        actions.extend(choir.map(|choir| Action::SetChoir { choir }));
        actions.extend(harmonics.map(|harmonics| Action::SetHarmonics { harmonics }));
        let knobs = before.knobs.iter().filter(|(knob, value)| now.knobs.get(knob) != Some(value));
        actions.extend(knobs.map(|(&parameter, &value)| Action::Set { parameter, value }));
        let switches = before.switches.iter().filter(|(switch, on)| now.switches.get(switch) != Some(on));
        actions.extend(switches.map(|(&switch, &on)| Action::Switch { switch, on }));
        actions
    }

    /// Somebody has turned the gain since: it changes around that from now on.
    fn follow_gain(&mut self, instrument: &Instrument) {
        let now = instrument.parameters().get(Parameter::Gain);
        if let Some((_, share)) = self.set.filter(|(value, _)| *value != now) {
            (self.gain, self.set) = (now / share, Some((now, share)));
        }
    }

    /// The actions that put a turn on stage. The last two places of the gallery are used in turns, since the dance
    /// before it is still seen while it leaves. What waits to be next waits on; where it has one of these places, the place
    /// before them is used.
    fn actions(&mut self, turn: Turn, instrument: &Instrument) -> impl Iterator<Item = Action> + use<> {
        let items = instrument.gallery().items();
        let next = instrument.next_on_stage().map(|(id, _)| id);
        let next = items.iter().position(|known| Some(known.id) == next);
        let is_free = |place: &usize| *place != self.place && Some(*place) != next;
        let item = (0..items.len()).rfind(is_free).unwrap_or_default();
        self.place = item;
        let cue = next.map(|item| Action::CueUp { item });
        let mut preset = self.dances.get(turn.dance).cloned();
        if let Some(preset) = &mut preset {
            let own = preset.settings.clone();
            bring_back(&mut preset.settings, &self.named, &self.before.0);
            self.named = own;
            self.held.iter().for_each(|change| leave_out(change, &mut preset.settings));
        }
        let (low, high) = Parameter::Gain.range();
        let value = (self.gain * turn.gain).clamp(low, high);
        self.set = Some((value, turn.gain));
        let form = self.form.filter(|_| !holds_form(&self.held)).map(|form| Action::SetForm { form });
        // The show's own look suits the body, so the first turn has that; but not a sheet without its sand.
        let keeps_look = self.autopilot.is_at_first() && self.form.is_none();
        let look = self.looks.get(turn.look).filter(|_| !keeps_look);
        let look = look.map(|look| Action::SetLook { look: (*look).to_owned() });
        preset.into_iter().flat_map(move |preset| {
            let take = Action::Take { item, preset: Box::new(preset) };
            let gain = Action::Set { parameter: Parameter::Gain, value };
            let perform = Action::Perform { item };
            let dance = [take].into_iter().chain(form.clone()).chain([gain, perform]);
            dance.chain(look.clone()).chain(cue.clone())
        })
    }
}

/// What the `last` dance said and `settings` do not stands where it stood `before` all of them.
fn bring_back(settings: &mut Settings, last: &Settings, before: &Settings) {
    settings.form = settings.form.or(last.form.and(before.form));
    settings.choir = settings.choir.or(last.choir.and(before.choir));
    settings.harmonics = settings.harmonics.or(last.harmonics.and(before.harmonics));
    for knob in last.knobs.keys() {
        if let Some(value) = before.knobs.get(knob) {
            settings.knobs.entry(*knob).or_insert(*value);
        }
    }
    for switch in last.switches.keys() {
        if let Some(on) = before.switches.get(switch) {
            settings.switches.entry(*switch).or_insert(*on);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_music::{Choir, GalleryShape, Moment, Switch, Timbre};
    use chladni_view::Effect;

    #[test]
    fn whatever_dances_on_a_sheet_leaves_its_plane() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap().on_sheet(true);
        for i in 0..20 {
            for action in programme.step(f64::from(i), true, &instrument) {
                instrument.apply(Moment { at_secs: f64::from(i), at_beat: 0.0 }, action).unwrap();
            }
            assert_eq!(instrument.parameters().form, Form::Modal);
        }
    }

    /// The name of the next dance, once it is on stage.
    fn turn(programme: &mut Programme, instrument: &mut Instrument, at_secs: f64) -> Option<String> {
        let mut name = None;
        for action in programme.step(at_secs, true, instrument) {
            if let Action::Take { preset, .. } = &action {
                name = Some(preset.name.clone());
            }
            instrument.apply(Moment { at_secs, at_beat: 0.0 }, action).unwrap();
        }
        name
    }

    #[test]
    fn what_one_dance_sets_stays_with_it() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        let mut kept = instrument.preset(&instrument.gallery().items()[0], Vec::new());
        kept.name = "kept".into();
        kept.settings.harmonics = Some(8);
        kept.settings.knobs.insert(Parameter::Limit, 0.05);
        let limit = instrument.parameters().get(Parameter::Limit);
        let mut programme = Programme::new(&instrument, vec![kept], 0.0, 0).unwrap();
        let mut came = 0;
        for i in 0..60 {
            let name = turn(&mut programme, &mut instrument, f64::from(i)).unwrap();
            let (harmonics, now) =
                (instrument.parameters().harmonics, instrument.parameters().get(Parameter::Limit));
            if name == "kept" {
                came += 1;
                assert_eq!((harmonics, now), (Some(8), 0.05));
            } else {
                assert_eq!((harmonics, now), (None, limit), "{name}, turn {i}");
            }
        }
        assert!(came > 0);
    }

    #[test]
    fn a_gain_that_is_turned_meanwhile_is_the_one_around_which_it_changes() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
        turn(&mut programme, &mut instrument, 0.0);
        let turned = Action::Set { parameter: Parameter::Gain, value: 3.0 };
        instrument.apply(Moment { at_secs: 0.5, at_beat: 0.0 }, turned).unwrap();
        for i in 1..20 {
            turn(&mut programme, &mut instrument, f64::from(i));
            let gain = instrument.parameters().get(Parameter::Gain);
            assert!((1.99..=4.51).contains(&gain), "{gain} in turn {i}");
        }
    }

    #[test]
    fn it_ends_before_a_dance_of_the_gallery_that_returns_comes_on_stage() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
        for i in 0..2 {
            for action in programme.step(f64::from(i), true, &instrument) {
                instrument.apply(Moment { at_secs: f64::from(i), at_beat: 0.0 }, action).unwrap();
            }
        }
        // The last two places have dances of its own.
        let ends_before = |first| programme.ends_before(&Action::PerformGallery { first }, &instrument);
        assert_eq!([0, 3, 4, 5, 6].map(ends_before), [true, true, false, false, false]);
        assert!(!programme.ends_before(&Action::Perform { item: 0 }, &instrument));
    }

    #[test]
    fn it_ends_where_another_gallery_began() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        instrument.apply(Moment::default(), Action::Mutate { item: 0, amount: 0.1 }).unwrap();
        let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
        instrument.apply(Moment::default(), Action::NewGallery { seed: 2, size: 6 }).unwrap();
        let items = instrument.gallery().items().to_vec();
        for i in 0..3 {
            turn(&mut programme, &mut instrument, f64::from(i));
        }
        assert_ne!(instrument.gallery().items(), items);
        for action in programme.end(&instrument) {
            instrument.apply(Moment::default(), action).unwrap();
        }
        assert_eq!(instrument.gallery().items(), items);
    }

    #[test]
    fn what_waits_to_be_next_waits_on_and_is_not_interrupted_once_it_comes() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        // In the places of the programme's own dances, too.
        for item in [2, 3, 4, 5] {
            let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
            let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
            turn(&mut programme, &mut instrument, 0.0);
            let waiting = instrument.gallery().items()[item].id;
            instrument.apply(Moment::default(), Action::CueUp { item }).unwrap();
            let mut hear = |instrument: &mut Instrument, at_secs| {
                let bar = BarLine { at_secs, secs: 2.0, energy: 0.5, begins_section: true };
                let actions = programme.hear(&[bar], at_secs, instrument);
                let count = actions.len();
                for (at_secs, action) in actions {
                    instrument.apply(Moment { at_secs, at_beat: 2.0 * at_secs }, action).unwrap();
                }
                (count > 0, programme.holds())
            };
            assert_eq!(hear(&mut instrument, 30.0), (true, false));
            assert_eq!(instrument.next_on_stage(), Some((waiting, 0.0)), "place {item}");
            instrument.apply(Moment::default(), Action::Crossfade { share: 0.4 }).unwrap();
            assert_eq!(hear(&mut instrument, 60.0), (false, false));
            assert_eq!(instrument.next_on_stage(), Some((waiting, 0.4)));
            instrument.apply(Moment::default(), Action::Crossfade { share: 0.0 }).unwrap();
            for at_secs in [90.0, 120.0] {
                assert_eq!(hear(&mut instrument, at_secs), (true, false));
                assert_eq!(instrument.next_on_stage(), Some((waiting, 0.0)), "place {item}");
            }
        }
    }

    #[test]
    fn what_is_held_stays_whatever_dances() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        for is_flat in [false, true] {
            let mut instrument = Instrument::new(1, 6, shape.clone()).unwrap();
            let mut held = vec![
                Action::SetForm { form: Form::Filter },
                Action::SetChoir { choir: Choir::Symmetric },
                Action::Set { parameter: Parameter::Decay, value: 0.123 },
                Action::Switch { switch: Switch::OwnMu, on: false },
                Action::Set { parameter: Parameter::StereoMu, value: 0.25 },
            ];
            held.extend(Action::for_timbre(&Timbre::NAMED[0].1));
            for action in held.clone() {
                instrument.apply(Moment::default(), action).unwrap();
            }
            let before = instrument.parameters().clone();
            let programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
            let mut programme = programme.on_sheet(is_flat).keeping(held.clone());
            for i in 0..20 {
                for action in programme.step(f64::from(i), true, &instrument) {
                    instrument.apply(Moment { at_secs: f64::from(i), at_beat: 0.0 }, action).unwrap();
                }
                // Doing them again changes nothing.
                let parameters = instrument.parameters().clone();
                for action in held.clone() {
                    instrument.apply(Moment::default(), action).unwrap();
                }
                assert_eq!(*instrument.parameters(), parameters, "turn {i}");
                assert_eq!((parameters.form, parameters.choir), (before.form, before.choir));
            }
        }
    }

    #[test]
    fn the_first_turn_has_the_look_there_is_and_a_chosen_one_stays() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let instrument = Instrument::new(1, 6, shape).unwrap();
        for keeps in [false, true] {
            let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap().keeping_look(keeps);
            let mut changes_look = |forward: bool| {
                let actions = programme.step(0.0, forward, &instrument);
                assert!(actions.iter().any(|action| matches!(action, Action::Perform { .. })));
                actions.iter().any(|action| matches!(action, Action::SetLook { .. }))
            };
            // The first turn has the show's own look, also when it comes back.
            assert_eq!([true, true, false].map(&mut changes_look), [false, !keeps, false]);
        }
    }

    #[test]
    fn the_look_of_the_opening_is_known_in_any_colors_and_with_any_effects() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let instrument = Instrument::new(1, 6, shape).unwrap();
        let finish = Look::EMBER.finish.without(Effect::Trails);
        for (is_flat, look) in [
            (false, Look::EMBER),
            (false, Look { own_colors: true, finish, ..Look::EMBER }),
            (true, Look::EMBER),
        ] {
            let programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
            let mut programme = programme.on_sheet(is_flat).opening_in(&look);
            programme.step(0.0, true, &instrument);
            let first = programme.autopilot.shown().unwrap().look;
            // What is drawn on a sheet is another one.
            assert_eq!(programme.looks[first] == "ember", !is_flat);
        }
    }

    #[test]
    fn its_actions_can_be_done_and_no_dance_follows_itself() {
        let shape = GalleryShape { eigenvalues: (0..64).map(f64::from).collect(), bands: 32 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        for action in [
            Action::SetForm { form: Form::Modal },
            Action::Set { parameter: Parameter::Gain, value: 1.3 },
            Action::Set { parameter: Parameter::Detail, value: 0.4 },
        ] {
            instrument.apply(Moment::default(), action).unwrap();
        }
        let parameters = instrument.parameters().clone();
        let items = instrument.gallery().items().to_vec();
        let mut programme = Programme::new(&instrument, Vec::new(), 0.0, 0).unwrap();
        let mut last = None;
        for i in 0..60 {
            let at_secs = f64::from(i) * 20.0;
            let bar = BarLine { at_secs, secs: 2.0, energy: 0.5, begins_section: true };
            let actions = programme.hear(&[bar], at_secs, &instrument);
            assert_eq!(actions.len(), if i == 0 { 3 } else { 4 });
            for (at_secs, action) in actions {
                instrument.apply(Moment { at_secs, at_beat: 2.0 * at_secs }, action).unwrap();
            }
            let scene = instrument.scene(2.0 * at_secs).unwrap();
            assert_ne!(last.replace(scene.to), Some(scene.to));
            // The first has the show's own look.
            assert_eq!(instrument.look().is_some(), i > 0);
        }
        // Off the stage the show's own look is back, and gallery and knobs are as they were.
        instrument.apply(Moment::default(), Action::LeaveStage).unwrap();
        assert_eq!(instrument.look(), None);
        assert_ne!(*instrument.parameters(), parameters);
        for action in programme.end(&instrument) {
            instrument.apply(Moment::default(), action).unwrap();
        }
        assert_eq!(*instrument.parameters(), parameters);
        assert_eq!(instrument.gallery().items(), items);
        assert_eq!(programme.end(&instrument), []);
    }
}
