//! One mapping compiled for one dancer: sound in, coefficients out, every frame.

use std::ops::Range;
use std::sync::Arc;

use chladni_synth::{Coefficients, Item, Term};

use crate::dancer::Reach;
use crate::mapping::{EVENING, busiest};
use crate::playing::STEEPNESS;
use crate::probes::Limits;
use crate::stereo::Ear;
use crate::{Bands, Choir, Class, Dancer, Form, Mapping, MusicError, Playing};

/// A typical level of music in most bands.
const EVEN: f32 = 0.12;
/// The largest lift, so that a mapping that hardly moves the shape still hardly moves it.
const MOST_LIFT: f32 = 16.0;

/// Harmonics that some band drives, one or several in unison.
#[derive(Clone, Copy, Debug)]
struct Voiced {
    first: u32,
    end: u32,
    first_driver: u32,
    end_driver: u32,
    antisymmetric: bool,
}

impl Voiced {
    fn harmonics(&self) -> Range<usize> {
        self.first as usize..self.end as usize
    }
}

/// A band ω that drives harmonics.
#[derive(Clone, Copy, Debug)]
struct DrivingBand {
    /// The first of them.
    first: u32,
    band: u32,
    /// gain · M · a(t(ω)).
    strength: f32,
    /// The resonator tone of the harmonic to which the band is mapped.
    tone: u8,
}

/// One mapping, compiled for a dancer, a number of bands and a way of playing.
///
/// Evaluating costs #ω additions and one pass over the harmonics in use.
#[derive(Clone, Debug)]
pub struct Player {
    voiced: Vec<Voiced>,
    /// See [`harmonics_wanted`](Self::harmonics_wanted).
    wanted: u32,
    /// Ordered by the harmonics that they drive.
    drivers: Vec<DrivingBand>,
    band_count: usize,
    stereo_mu: f32,
    playing: Playing,
    /// Harmonics that are limited together.
    groups: Vec<Vec<u32>>,
    dancer: Arc<Dancer>,
    scratch: Vec<[f32; 3]>,
}

impl Player {
    /// Compiles `mapping` for `bands` sound bands.
    ///
    /// # Errors
    /// The mapping is invalid, or `playing` is out of its ranges.
    pub fn new(
        mapping: &Mapping,
        dancer: &Arc<Dancer>,
        bands: usize,
        playing: Playing,
    ) -> Result<Self, MusicError> {
        mapping.validate()?;
        playing.validate()?;
        let lift = Self::lift(mapping, dancer, bands, playing)?;
        Ok(Self::compiled(mapping, dancer, bands, playing, lift))
    }

    /// The factor, 1 or more, for a mapping that spreads its sound thinly or sends it to one place: with it,
    /// a soft sound in every band uses half of the limits. As in the calibration, muting is ignored. So are the knobs of
    /// strength, which it would undo.
    fn lift(
        mapping: &Mapping,
        dancer: &Arc<Dancer>,
        bands: usize,
        playing: Playing,
    ) -> Result<f32, MusicError> {
        let Playing { gain, calibration, .. } = Playing::default();
        let playing =
            Playing { gain, calibration, choir: Choir::All, harmonics: None, detail: 1.0, ..playing };
        let even_mapping = Mapping { gain: mapping.even_gain(), ..mapping.clone() };
        let mut all = Self::compiled(&even_mapping, dancer, bands, playing, 1.0);
        let even = vec![EVEN; bands];
        let mut item = all.item();
        let heard =
            Bands { left: &even, right: &even, mid: &even, side: &even, side_gain: 1.0, ringing: None };
        let reach = all.play(&heard, &mut item)?;
        Ok(if reach > 0.0 { (0.5 / reach).clamp(1.0, MOST_LIFT) } else { 1.0 })
    }

    fn compiled(mapping: &Mapping, dancer: &Arc<Dancer>, bands: usize, playing: Playing, lift: f32) -> Self {
        let k_count = dancer.harmonics();
        let amplification = mapping.amplification_on(k_count);
        let answers = |k: u32| (k, amplification[k as usize]);
        let mut driven: Vec<(u32, f32)> = mapping.targets(bands, k_count).into_iter().map(answers).collect();
        let spread = awaken(&mut driven, dancer, playing.form);
        let in_use = playing.harmonics.map_or(k_count, |k| (k as usize).min(k_count));
        let calibrated = calibrate(&driven, dancer, playing);
        let gain = spread * mapping.gain_on(bands);
        let mut drivers = Vec::with_capacity(2 * bands);
        for (band, (k, answer)) in (0..).zip(driven) {
            let octave = dancer.octave(dancer.unison(k).start);
            let strength = lift * playing.gain * gain * calibrated[octave] * answer;
            let tone = playing.timbre.map_or(0, |timbre| dancer.tone(&timbre, dancer.unison(k).start));
            // In the modal form a band also drives the harmonic's partner of the other class.
            let driven = match playing.form {
                Form::Filter | Form::HalfMask => [Some(dancer.unison(k).start), None],
                Form::Modal => [Some(k), dancer.swing.partner(k)],
            };
            drivers.extend(driven.into_iter().flatten().map(|first| DrivingBand {
                first,
                band,
                strength,
                tone,
            }));
        }
        drivers.retain(|driver| driver.strength != 0.0);
        drivers.sort_by_key(|driver| (driver.first, driver.band));
        let mut voiced: Vec<Voiced> = Vec::new();
        for (i, &DrivingBand { first, .. }) in drivers.iter().enumerate() {
            match voiced.last_mut() {
                Some(last) if last.first == first => last.end_driver = i as u32 + 1,
                _ => voiced.push(Voiced {
                    first,
                    end: if playing.form == Form::Modal { first + 1 } else { dancer.unison(first).end },
                    first_driver: i as u32,
                    end_driver: i as u32 + 1,
                    antisymmetric: dancer.classes[first as usize] == Class::Antisymmetric,
                }),
            }
        }
        voiced.retain(|v| playing.choir.admits(dancer.classes[v.first as usize]));
        let wanted = voiced.iter().map(|v| v.end).max().unwrap_or(0);
        voiced.retain(|v| v.end as usize <= in_use);
        let groups = grouped(&voiced, dancer, playing.form);
        Self {
            voiced,
            wanted,
            drivers,
            band_count: bands,
            stereo_mu: playing.stereo_mu.unwrap_or(mapping.stereo_mu),
            playing,
            groups,
            dancer: dancer.clone(),
            scratch: Vec::with_capacity(4 * dancer.probes.count()),
        }
    }

    /// How many harmonics its mapping uses, counted up to the highest, if all may sound.
    pub(crate) fn harmonics_wanted(&self) -> u32 {
        self.wanted
    }

    /// How many terms its items have.
    pub fn terms(&self) -> usize {
        self.playing.form.terms()
    }

    /// An item at rest, with room for all that [`play`](Self::play) writes.
    pub fn item(&self) -> Item {
        let k = self.dancer.harmonics();
        let term = |coefficients, mask| Term { coefficients, residual: None, residual_gain: 0.0, mask };
        let mut terms = match self.playing.form {
            Form::Filter => vec![term(Coefficients::Vector(vec![[0.0; 3]; k]), None)],
            Form::Modal => {
                vec![term(Coefficients::Normal(vec![0.0; k]), Some(self.dancer.swelling.clone()))]
            }
            Form::HalfMask => {
                let sides = &self.dancer.sides;
                [&sides.left, &sides.right]
                    .map(|mask| term(Coefficients::Vector(vec![[0.0; 3]; k]), Some(mask.clone())))
                    .into()
            }
        };
        if self.playing.form != Form::Modal && self.playing.detail != 1.0 {
            for term in &mut terms {
                term.residual = Some(self.dancer.residual.clone());
                term.residual_gain = self.playing.detail - 1.0;
            }
        }
        Item { terms }
    }

    /// Writes the effect of the sound into `item`, which [`item`](Self::item) of a player of the
    /// same form and dancer made. Returns the share of the limit that the movement reached
    /// before it was softened. Nothing is allocated.
    ///
    /// # Errors
    /// Bands of another number than the mapping was compiled for, or an item of another number of terms or
    /// harmonics.
    pub fn play(&mut self, bands: &Bands<'_>, item: &mut Item) -> Result<f32, MusicError> {
        self.check(bands)?;
        let terms = self.terms();
        if item.terms.len() != terms {
            return Err(MusicError::Size { what: "terms", found: item.terms.len(), expected: terms });
        }
        let ear = Ear::new(bands, &self.playing, self.stereo_mu);
        for (side, term) in item.terms.iter_mut().enumerate() {
            if term.residual.is_some() {
                term.residual_gain = self.playing.detail - 1.0;
            }
            match &mut term.coefficients {
                Coefficients::Vector(c) => {
                    fit(c, self.dancer.harmonics())?;
                    c.fill([0.0; 3]);
                    for v in &self.voiced {
                        let gain = match (self.playing.form, side) {
                            // The first term stays the left half, whichever channel it hears.
                            (Form::HalfMask, side) if (side == 0) != self.playing.flip_sides => {
                                self.sum(v, |b, tone| ear.left(b, tone))
                            }
                            (Form::HalfMask, _) => self.sum(v, |b, tone| ear.right(b, tone)),
                            _ if v.antisymmetric => self.sum(v, |b, tone| ear.antisymmetric(b, tone)),
                            _ => self.sum(v, |b, tone| ear.symmetric(b, tone)),
                        };
                        for k in v.harmonics() {
                            c[k] = self.dancer.spectrum[k].map(|x| gain * x);
                        }
                    }
                }
                Coefficients::Normal(c) => {
                    fit(c, self.dancer.harmonics())?;
                    c.fill(0.0);
                    for v in &self.voiced {
                        let gain = match v.antisymmetric {
                            true => self.sum(v, |b, tone| ear.swing(b, tone)),
                            false => self.sum(v, |b, tone| ear.level(b, tone)),
                        };
                        c[v.first as usize] = self.dancer.swing.sign(v.first) * gain;
                    }
                }
            }
        }
        Ok(self.soften(item))
    }

    /// Adds to `out` what an item of this player does at the probes, as shares of the limits.
    pub(crate) fn feel(&mut self, item: &Item, out: &mut Vec<f32>) {
        let limits = self.limits();
        self.dancer.probes.feel(item, limits, &mut self.scratch, out);
    }

    /// The sum of the drivers' levels, by band and tone.
    fn sum(&self, v: &Voiced, f: impl Fn(usize, u8) -> f32) -> f32 {
        let drivers = &self.drivers[v.first_driver as usize..v.end_driver as usize];
        drivers.iter().map(|d| d.strength * f(d.band as usize, d.tone)).sum()
    }

    /// Scales the item so that no probe exceeds the limit of displacement or of steepness.
    fn soften(&mut self, item: &mut Item) -> f32 {
        let limits = self.limits();
        let classes = (self.playing.form == Form::Modal).then_some(&self.dancer.classes[..]);
        self.dancer.probes.soften(item, &self.groups, classes, limits, &mut self.scratch)
    }

    fn limits(&self) -> Limits {
        Limits {
            displacement: self.playing.limit * self.dancer.box_diagonal,
            steepness: self.playing.limit * STEEPNESS,
        }
    }

    fn check(&self, bands: &Bands<'_>) -> Result<(), MusicError> {
        for (what, band) in [
            ("left bands", bands.left),
            ("right bands", bands.right),
            ("mid bands", bands.mid),
            ("side bands", bands.side),
        ] {
            if band.len() != self.band_count {
                return Err(MusicError::Size { what, found: band.len(), expected: self.band_count });
            }
        }
        Ok(())
    }
}

/// Whether harmonic k moves the shape in a form, by more than rounding: one that does not stays at rest.
fn moves(k: u32, dancer: &Dancer, form: Form) -> bool {
    dancer.reach(form, k).displacement > 1e-6 * dancer.box_diagonal
}

/// Symmetry leaves many harmonics of a ball or a ring at rest where they filter the shape. Where a mapping drives only such
/// ones, its bands drive the nearest that move. Each band comes with its harmonic, and how strongly that answers. Returns
/// the factor of the gain for bands that share a harmonic from now on ([`Mapping::even_gain`]).
fn awaken(driven: &mut [(u32, f32)], dancer: &Dancer, form: Form) -> f32 {
    if driven.iter().any(|(k, answer)| *answer != 0.0 && moves(*k, dancer, form)) {
        return 1.0;
    }
    let before = busiest(driven.iter().copied());
    let moving: Vec<u32> = (0..dancer.harmonics() as u32).filter(|k| moves(*k, dancer, form)).collect();
    for (k, _) in driven.iter_mut() {
        let above = moving.partition_point(|other| *other < *k);
        let around = [above.checked_sub(1), Some(above)].into_iter().flatten().filter_map(|i| moving.get(i));
        *k = around.copied().min_by_key(|other| other.abs_diff(*k)).unwrap_or(*k);
    }
    (busiest(driven.iter().copied()) / before).powf(EVENING)
}

/// M for each octave of harmonics: with it, a full-scale band that drives one of them at the mapping's
/// largest amplification moves it by the calibrated share of the box, or by the matching steepness,
/// whichever comes first. Choir and harmonics in use are ignored, so that muting some does not make the
/// rest louder.
fn calibrate(driven: &[(u32, f32)], dancer: &Dancer, playing: Playing) -> Vec<f32> {
    let wanted = Reach {
        displacement: playing.calibration * dancer.box_diagonal,
        steepness: playing.calibration * STEEPNESS,
    };
    let mut octaves: Vec<f32> = Vec::new();
    let mut loudest = 0.0f32;
    for &(k, answer) in driven.iter().filter(|(k, answer)| *answer != 0.0 && moves(*k, dancer, playing.form))
    {
        let reach = dancer.reach(playing.form, k);
        let octave = dancer.octave(dancer.unison(k).start);
        octaves.resize(octaves.len().max(octave + 1), f32::INFINITY);
        let steep = if reach.steepness > 0.0 { wanted.steepness / reach.steepness } else { f32::INFINITY };
        octaves[octave] = octaves[octave].min(wanted.displacement / reach.displacement).min(steep);
        loudest = loudest.max(answer.abs());
    }
    octaves.resize(dancer.octave(dancer.harmonics() as u32 - 1) + 1, f32::INFINITY);
    octaves.into_iter().map(|m| if m.is_finite() { m / loudest } else { 0.0 }).collect()
}

/// Harmonics of one octave are limited together, antisymmetric ones apart from the others. In the modal form
/// they are limited together, because a swing to one side is a sum of both.
fn grouped(voiced: &[Voiced], dancer: &Dancer, form: Form) -> Vec<Vec<u32>> {
    let mut groups: Vec<Vec<u32>> = Vec::new();
    for v in voiced {
        let group = match form {
            Form::Modal => dancer.octave(v.first),
            Form::Filter | Form::HalfMask => 2 * dancer.octave(v.first) + usize::from(v.antisymmetric),
        };
        groups.resize(groups.len().max(group + 1), Vec::new());
        groups[group].extend(v.first..v.end);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

fn fit<T>(coefficients: &[T], harmonics: usize) -> Result<(), MusicError> {
    if coefficients.len() == harmonics {
        return Ok(());
    }
    Err(MusicError::Size { what: "coefficients", found: coefficients.len(), expected: harmonics })
}

/// Moves `item` toward `other`, made by a player of the same form and dancer: weight 0 keeps it, 1 replaces
/// it. This is how one mapping morphs into another on stage.
///
/// # Errors
/// Items of another form or dancer.
pub fn blend(item: &mut Item, other: &Item, weight: f32) -> Result<(), MusicError> {
    if item.terms.len() != other.terms.len() {
        return Err(MusicError::Size { what: "terms", found: other.terms.len(), expected: item.terms.len() });
    }
    let mix = |a: f32, b: f32| a + weight * (b - a);
    for (a, b) in item.terms.iter_mut().zip(&other.terms) {
        a.residual_gain = mix(a.residual_gain, b.residual_gain);
        match (&mut a.coefficients, &b.coefficients) {
            (Coefficients::Vector(a), Coefficients::Vector(b)) => {
                fit(b, a.len())?;
                for (a, b) in a.iter_mut().zip(b) {
                    *a = std::array::from_fn(|i| mix(a[i], b[i]));
                }
            }
            (Coefficients::Normal(a), Coefficients::Normal(b)) => {
                fit(b, a.len())?;
                a.iter_mut().zip(b).for_each(|(a, b)| *a = mix(*a, *b));
            }
            _ => return Err(MusicError::Size { what: "terms of the same form", found: 0, expected: 1 }),
        }
    }
    Ok(())
}
