//! From a small mesh to the frames of a dance, whatever its geometry, its knobs and the sound.

use std::sync::Arc;

use chladni_harmonics::Body;
use chladni_mesh::{Estimate, Known, Orientation};
use chladni_music::{
    Action, Bands, Beat, Choir, Dancer, Ensemble, Form, GalleryShape, Instrument, Moment, Parameter,
    Resonators, Ringing, Switch, Symmetry, SymmetrySettings,
};
use chladni_synth::{CpuSynthesizer, FrameSettings, SynthModel, Synthesizer};
use chladni_task::Task;

use crate::pipeline::{Geometry, body_of};
use crate::random::Random;

/// A small mesh, and its dance.
#[derive(Debug)]
pub struct Dance {
    geometry: Geometry,
    harmonics: u8,
    score: Score,
}

impl Dance {
    /// One at random.
    pub fn random(random: &mut Random) -> Self {
        let geometry = Geometry::random(random);
        Self { geometry, harmonics: random.byte() % 40, score: Score::random(random) }
    }
}

/// The knobs of a dance, and what it hears.
#[derive(Debug)]
pub(crate) struct Score {
    seed: u8,
    form: u8,
    choir: u8,
    /// Knobs, and shares of their ranges.
    knobs: Vec<[u8; 2]>,
    switches: Vec<(u8, bool)>,
    bands: u8,
    /// For each frame the levels of the left and the right channel.
    sound: Vec<[u8; 2]>,
}

impl Score {
    /// One at random.
    pub fn random(random: &mut Random) -> Self {
        Self {
            seed: random.byte(),
            form: random.byte(),
            choir: random.byte(),
            knobs: (0..random.below(20)).map(|_| [random.byte(), random.byte()]).collect(),
            switches: (0..random.below(8)).map(|_| (random.byte(), random.below(2) == 0)).collect(),
            bands: random.byte(),
            sound: (0..random.below(20)).map(|_| [random.byte(), random.byte()]).collect(),
        }
    }

    fn actions(&self) -> impl Iterator<Item = Action> {
        let forms = [Form::Filter, Form::Modal, Form::HalfMask];
        let choirs = [Choir::All, Choir::Symmetric, Choir::Antisymmetric];
        let knobs = self.knobs.iter().map(|[knob, share]| {
            let parameter = Parameter::ALL[usize::from(*knob) % Parameter::ALL.len()];
            Action::Set { parameter, value: parameter.at_share(f32::from(*share) / 255.0) }
        });
        let switches = self.switches.iter().map(|(switch, on)| Action::Switch {
            switch: Switch::ALL[usize::from(*switch) % Switch::ALL.len()],
            on: *on,
        });
        let form = Action::SetForm { form: forms[usize::from(self.form) % 3] };
        let choir = Action::SetChoir { choir: choirs[usize::from(self.choir) % 3] };
        knobs.chain(switches).chain([form, choir])
    }
}

/// Lets a shape dance, with all knobs where they are set.
pub fn dance(dance: Dance) {
    let Some(mesh) = dance.geometry.mesh() else { return };
    let Some(body) = body_of(&mesh, dance.harmonics) else { return };
    let stands = Estimate::of(&mesh, Known::default(), &Task::new()).expect("nobody cancels").orientation;
    perform(&dance.score, &body, &stands, &SymmetrySettings::default());
}

/// Lets `body`, which `stands` so, dance by `score`.
pub(crate) fn perform(score: &Score, body: &Body, stands: &Orientation, symmetry: &SymmetrySettings) {
    let Ok(symmetry) = Symmetry::with(body, symmetry, &Task::new()) else { return };
    let dancer = Dancer::new(body, &symmetry.classes, stands).expect("one class for each harmonic");
    let bands = usize::from(score.bands % 40).max(1);
    let shape = GalleryShape { eigenvalues: body.basis.eigenvalues.clone(), bands };
    let Ok(mut instrument) = Instrument::new(score.seed.into(), 6, shape) else { return };
    for action in score.actions() {
        instrument.apply(Moment::default(), action).expect("within its range");
    }
    let mut ensemble = Ensemble::new(Arc::new(dancer));
    let Ok(model) = SynthModel::new(body) else { return };
    let mut synthesizer = CpuSynthesizer::new(model);
    let (mut resonators, mut bank) = (None, Levels::default());
    for (frame, levels) in score.sound.iter().enumerate() {
        bank.set(*levels, bands);
        let timbre = instrument.parameters().timbre();
        Resonators::follow(&mut resonators, timbre.as_ref(), bands);
        if let Some(resonators) = &mut resonators {
            resonators.hear(&bank.heard(None), 1.0 / 30.0);
            resonators.ring(1.0 / 60.0);
        }
        let ringing = resonators.as_ref().map(Resonators::ringing);
        let beat = Beat { count: frame as f64 / 4.0, confidence: 1.0 };
        let items = ensemble.play(&instrument, &bank.heard(ringing), beat).expect("bands as compiled");
        synthesizer.synthesize(items, &FrameSettings::default()).expect("items fit the model");
        let all = synthesizer.all_positions().iter().chain(synthesizer.all_normals());
        assert!(all.flatten().all(|x| x.is_finite()), "a dance has coordinates");
    }
}

/// The bands of one frame.
#[derive(Default)]
struct Levels {
    left: Vec<f32>,
    right: Vec<f32>,
    mid: Vec<f32>,
    side: Vec<f32>,
}

impl Levels {
    const SIDE_GAIN: f32 = 2.0;

    /// Every band with its own share of the channel's level.
    fn set(&mut self, levels: [u8; 2], bands: usize) {
        let [left, right] = levels.map(|level| {
            (0..bands).map(|band| f32::from(level.rotate_left(band as u32 % 8)) / 255.0).collect::<Vec<_>>()
        });
        self.mid = left.iter().zip(&right).map(|(l, r)| 0.5 * (l + r)).collect();
        self.side = left.iter().zip(&right).map(|(l, r)| Self::SIDE_GAIN * 0.5 * (l - r).abs()).collect();
        (self.left, self.right) = (left, right);
    }

    fn heard<'a>(&'a self, ringing: Option<&'a Ringing>) -> Bands<'a> {
        let Self { left, right, mid, side } = self;
        Bands { left, right, mid, side, side_gain: Self::SIDE_GAIN, ringing }
    }
}
