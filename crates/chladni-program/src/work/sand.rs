//! Sand on the dance that is on stage, or on each dance of a gallery, at any time of a show.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_music::{Ensemble, Instrument, Mapping, Parameter, SAND_STEP_SECS, Sand, Settings, Switch, Tray};
use chladni_synth::Item;
use chladni_view::{Grain, Grains, Look};
use rayon::prelude::*;

use super::{Error, Hearing};

/// Color of the grains on dark surfaces, sRGB.
const LIGHT: [u8; 3] = [240, 220, 178];
/// Their color on light ones.
const DARK: [u8; 3] = [38, 30, 24];
/// Relative luminance of a surface with which both colors contrast alike.
const MIDDLE: f32 = 0.17;
/// A film that begins in the middle of a show begins with sand poured this long before.
pub const BEFORE_SECS: f64 = 5.0;
/// The most steps that are caught up; after a longer wait the sand goes on from now.
const MOST_STEPS: i64 = 120;

/// A shape on which sand may lie. It steps at fixed times of the show, by the sound of that time, so that window
/// and film show the same grains at any frame rate.
pub struct SandTable {
    body: Body,
    /// Made when it is needed first.
    tray: Option<Arc<Tray>>,
    /// On each item that is seen.
    sands: Vec<Sand>,
    /// How often it had been swept when it was poured.
    sweeps: u32,
    /// The next step, counted from the beginning of the show.
    next: i64,
    /// The first step from which on the show is seen.
    begins: i64,
    /// The most steps that are caught up: at the beginning of a film those before it.
    most_steps: i64,
    /// The grains to draw on each item, and their size.
    grains: Vec<Vec<Grain>>,
    radius: f32,
}

impl SandTable {
    /// A shape without sand, for a show that is seen from `begins_secs` on.
    pub fn new(body: Body, begins_secs: f64) -> Self {
        let next = ((begins_secs - BEFORE_SECS).max(0.0) / SAND_STEP_SECS).ceil() as i64;
        let begins = (begins_secs / SAND_STEP_SECS).ceil() as i64;
        let (sands, grains, most_steps) = (Vec::new(), Vec::new(), (begins - next).max(MOST_STEPS));
        Self { body, tray: None, sands, sweeps: 0, next, begins, most_steps, grains, radius: 0.0 }
    }

    /// The shape.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// The time of the next step, where it is not after `at_secs`.
    pub fn due(&mut self, at_secs: f64) -> Option<f64> {
        let last = (at_secs / SAND_STEP_SECS + 1e-6).floor() as i64;
        // A show that begins anew goes back in time, and its sand is poured again.
        if self.next > last + 1 {
            self.sands.clear();
            self.next = last;
        }
        self.next = self.next.max(last - self.most_steps);
        // Not before: a film may ask step by step.
        if self.next >= self.begins {
            self.most_steps = MOST_STEPS;
        }
        (self.next <= last).then_some(self.next as f64 * SAND_STEP_SECS)
    }

    /// Does all steps up to a time of the show, as long as the sound is known; by a `solo` where that is heard in place of
    /// the instrument's own dances.
    ///
    /// # Errors
    /// Those of hearing and playing.
    pub fn follow(
        &mut self,
        hearing: &mut Hearing,
        ensemble: &mut Ensemble,
        instrument: &Instrument,
        solo: Option<&(Mapping, Settings)>,
        until_secs: f64,
    ) -> Result<(), Error> {
        while let Some(at_secs) = self.due(until_secs) {
            if !instrument.parameters().is_on(Switch::Sand) {
                self.step(&[], instrument);
                continue;
            }
            let Some(heard) = hearing.hear(at_secs)? else { break };
            let items = match solo {
                Some((mapping, settings)) => {
                    ensemble.audition(instrument, (mapping, settings), &heard.bands, heard.beat)
                }
                None => ensemble.play(instrument, &heard.bands, heard.beat),
            }?;
            self.step(items, instrument);
        }
        Ok(())
    }

    /// Does one step with these `items`, which share the grains.
    pub fn step(&mut self, items: &[Item], instrument: &Instrument) {
        self.next += 1;
        let parameters = instrument.parameters();
        if items.is_empty() || !parameters.is_on(Switch::Sand) {
            return self.sands.clear();
        }
        let sweeps = instrument.sweeps();
        let count = (parameters.get(Parameter::Grains) / items.len() as f32).round().max(1.0) as usize;
        let tray = self.tray.get_or_insert_with(|| Arc::new(Tray::new(&self.body)));
        let lies = self.sands.len() == items.len() && self.sands.iter().all(|sand| sand.count() == count);
        if !lies || self.sweeps != sweeps {
            let seed = instrument.seed().wrapping_add(sweeps.into());
            // Of one item the first; of others other ones.
            let pour = |item: u64| Sand::pour(Arc::clone(tray), count, seed.wrapping_add(item << 32));
            self.sands = (0..items.len() as u64).map(pour).collect();
        }
        self.sweeps = sweeps;
        self.radius = parameters.get(Parameter::GrainSize) * tray.box_diagonal();
        let share = parameters.get(Parameter::Gain) * parameters.get(Parameter::Calibration);
        let full = share * tray.box_diagonal();
        self.sands.par_iter_mut().zip(items).for_each(|(sand, item)| sand.step(item, full));
    }

    /// The grains to draw now on each item, in a color that stands out in this look; empty where there is no sand. The look
    /// should be that of the show, not as it answers to the sound: else grains could change their color while it plays.
    pub fn drawn(&mut self, look: &Look) -> Vec<Grains<'_>> {
        if self.sands.is_empty() {
            self.grains.clear();
            return Vec::new();
        }
        let color = color_on(look);
        let grain = |grain: chladni_music::Grain| {
            let chladni_music::Grain { corners, weights, lift } = grain;
            Grain { corners, weights, lift }
        };
        self.grains.resize_with(self.sands.len(), Vec::new);
        for (grains, sand) in self.grains.iter_mut().zip(&self.sands) {
            sand.grains().map(grain).collect_into_vec(grains);
        }
        let of = |grains| Grains { grains, radius: self.radius, color };
        self.grains.iter().map(|grains| of(&grains[..])).collect()
    }

    /// A number that changes whenever the grains do.
    pub fn version(&self) -> u64 {
        let mixed = |all: u64, sand: &Sand| all.rotate_left(5) ^ sand.version();
        let radius = u64::from(self.radius.to_bits()) << 32;
        self.sands.iter().fold(0, mixed) ^ if self.sands.is_empty() { 0 } else { radius }
    }
}

/// The color of grains that stands out in a look.
fn color_on(look: &Look) -> [u8; 3] {
    if look.surface_luminance() > MIDDLE { DARK } else { LIGHT }
}

#[cfg(test)]
mod tests {
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::{Orientation, samples};
    use chladni_music::{Action, Dancer, GalleryShape, Moment, Stretch, Symmetry, experiment};
    use chladni_sound::sample_tune;
    use chladni_task::Task;
    use chladni_view::Material;

    use super::*;
    use crate::work::KnownSong;

    fn stage() -> (Body, Arc<Dancer>, Instrument) {
        let mesh = samples::sample("plate").unwrap();
        let body = Body::build(&mesh, &BasisSettings::new(24), &Task::new()).unwrap();
        let symmetry = Symmetry::of(&body, &Task::new()).unwrap();
        let body = symmetry.rotated(&body);
        let dancer = Arc::new(Dancer::new(&body, &symmetry.classes, &Orientation::Y_UP).unwrap());
        let shape = GalleryShape { eigenvalues: dancer.eigenvalues.clone(), bands: 128 };
        let mut instrument = Instrument::new(1, 6, shape).unwrap();
        for action in experiment(&dancer.eigenvalues, &dancer.classes, 128) {
            instrument.apply(Moment::default(), action).unwrap();
        }
        instrument
            .apply(Moment::default(), Action::Set { parameter: Parameter::Grains, value: 2000.0 })
            .unwrap();
        (body, dancer, instrument)
    }

    fn hearing(instrument: &Instrument) -> Hearing {
        let mut hearing = Hearing::default();
        hearing.know(0, KnownSong::new(Arc::new(sample_tune())).unwrap());
        hearing.tune(0.0, instrument.parameters());
        hearing
            .begin(Stretch {
                at_secs: 0.0,
                song: Some(0),
                song_secs: 2.0,
                playing: true,
                crossfade_secs: 0.0,
            })
            .unwrap();
        hearing
    }

    #[test]
    fn grains_stand_out_in_every_look() {
        let luminance = |color| {
            let material = Material { color, ..Material::CLAY };
            Look { material, answer: None, ..Look::PLAIN }.surface_luminance()
        };
        for (name, look) in Look::PRESETS {
            let (grains, surface) = (luminance(color_on(&look)), look.surface_luminance());
            // As WCAG 2.2 defines it.
            let contrast = (grains.max(surface) + 0.05) / (grains.min(surface) + 0.05);
            assert!(contrast > 4.0, "{name}: {contrast}");
        }
    }

    #[test]
    fn the_same_grains_lie_there_at_any_frame_rate_until_they_are_swept() {
        let (body, dancer, mut instrument) = stage();
        let run = |instrument: &Instrument, fps: u32| {
            let (mut hearing, mut ensemble) = (hearing(instrument), Ensemble::new(Arc::clone(&dancer)));
            let mut table = SandTable::new(body.clone(), 0.0);
            for frame in 0..=2 * fps {
                let at_secs = f64::from(frame) / f64::from(fps);
                table.follow(&mut hearing, &mut ensemble, instrument, None, at_secs).unwrap();
                hearing.hear(at_secs).unwrap();
            }
            (table.drawn(&Look::AURORA)[0].grains.to_vec(), table)
        };
        let (often, mut table) = run(&instrument, 50);
        assert_eq!(often.len(), 2000);
        assert_eq!(often, run(&instrument, 24).0);
        let (version, before) = (table.version(), often);
        instrument.apply(Moment::default(), Action::Sweep).unwrap();
        let (mut hearing, mut ensemble) = (hearing(&instrument), Ensemble::new(dancer));
        table.follow(&mut hearing, &mut ensemble, &instrument, None, 2.1).unwrap();
        assert!(table.version() != version && table.drawn(&Look::AURORA)[0].grains != before);
        instrument.apply(Moment::default(), Action::Switch { switch: Switch::Sand, on: false }).unwrap();
        table.follow(&mut hearing, &mut ensemble, &instrument, None, 2.2).unwrap();
        assert!(table.drawn(&Look::AURORA).is_empty());
    }

    #[test]
    fn a_show_that_begins_anew_has_the_same_sand_again() {
        let (body, dancer, instrument) = stage();
        let mut table = SandTable::new(body, 0.0);
        let mut dance = |until_secs: f64| {
            let (mut hearing, mut ensemble) = (hearing(&instrument), Ensemble::new(Arc::clone(&dancer)));
            for step in 0..=20 {
                let at_secs = until_secs * f64::from(step) / 20.0;
                table.follow(&mut hearing, &mut ensemble, &instrument, None, at_secs).unwrap();
            }
            table.drawn(&Look::AURORA)[0].grains.to_vec()
        };
        let first = dance(0.5);
        assert_ne!(dance(2.0), first);
        assert_eq!(dance(0.5), first);
    }

    #[test]
    fn a_film_from_the_middle_begins_with_sand_of_five_seconds_and_then_goes_on_as_the_window() {
        let (body, _, instrument) = stage();
        let mut table = SandTable::new(body.clone(), 60.0);
        assert_eq!(table.due(60.0), Some(55.0));
        // The film does each step in a show that has come to its time.
        table.step(&[], &instrument);
        assert_eq!(table.due(55.0), None);
        assert!(table.due(60.0).is_some_and(|secs| (55.01..55.02).contains(&secs)));
        while table.due(60.0).is_some() {
            table.step(&[], &instrument);
        }
        // A wait is not caught up in full.
        assert!(table.due(70.0).is_some_and(|secs| (67.9..68.1).contains(&secs)));
        assert_eq!(SandTable::new(body, 1.0).due(1.0), Some(0.0));
    }

    #[test]
    fn each_dance_of_a_gallery_has_its_own_part_of_the_grains() {
        let (body, dancer, mut instrument) = stage();
        instrument.apply(Moment::default(), Action::LeaveStage).unwrap();
        let (mut hearing, mut ensemble) = (hearing(&instrument), Ensemble::new(dancer));
        let mut table = SandTable::new(body, 0.0);
        table.follow(&mut hearing, &mut ensemble, &instrument, None, 2.0).unwrap();
        let drawn = table.drawn(&Look::AURORA);
        assert_eq!(drawn.len(), instrument.gallery().items().len());
        let each = (2000.0 / drawn.len() as f32).round() as usize;
        assert!(drawn.iter().all(|sand| sand.grains.len() == each));
        assert!(drawn[1..].iter().all(|sand| sand.grains != drawn[0].grains));
        // A close-up of one of them has all.
        let genome = &instrument.gallery().items()[3].genome;
        let solo = (genome.clone(), Settings::default());
        table.follow(&mut hearing, &mut ensemble, &instrument, Some(&solo), 2.1).unwrap();
        let drawn = table.drawn(&Look::AURORA);
        assert_eq!((drawn.len(), drawn[0].grains.len()), (1, 2000));
    }
}
