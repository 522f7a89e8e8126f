//! The stage, and how the beat moves it: pure functions of the number of beats so far.

mod turns;

use chladni_breeding::ItemId;

use crate::gallery::GalleryItem;
use crate::{Parameter, Parameters, Switch};

/// The number of beats so far, with the phase as the fraction, and the tracker's confidence, in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beat {
    /// Number of beats so far; the fraction is the phase within the current one.
    pub count: f64,
    /// 0 moves nothing, 1 fully.
    pub confidence: f32,
}

impl Beat {
    /// The beat at `secs` of a song whose beats fall at `beats_secs` (ascending): the first one is number 1.
    /// Beyond the known beats their spacing continues, and confidence fades within two beats.
    pub fn among(beats_secs: &[f64], confidence: f32, secs: f64) -> Self {
        let [first, .., last] = *beats_secs else { return Self::default() };
        let next = beats_secs.partition_point(|&b| b <= secs);
        let count = beats_secs.len();
        let spacing = |a: f64, b: f64| (b - a).max(1e-3);
        if next == 0 {
            let ahead = (first - secs) / spacing(first, beats_secs[1]);
            return Self {
                count: (1.0 - ahead).max(0.0),
                confidence: if ahead < 1.0 { confidence } else { 0.0 },
            };
        }
        if next == count {
            let gone = (secs - last) / spacing(beats_secs[count - 2], last);
            let fading = (2.0 - gone).clamp(0.0, 1.0) as f32;
            return Self { count: count as f64 + gone, confidence: confidence * fading };
        }
        let (from, to) = (beats_secs[next - 1], beats_secs[next]);
        Self { count: next as f64 + (secs - from) / spacing(from, to), confidence }
    }
}

/// The scene at one moment: a cross-fade in which `to` has `weight` and `from` the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// The outgoing item; the same as `to` outside a transition.
    pub from: ItemId,
    /// The incoming item.
    pub to: ItemId,
    /// In [0, 1], smooth at both ends.
    pub weight: f32,
}

/// A fader this far is at its end.
const FADED: f32 = 0.996;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shown {
    Item(ItemId),
    /// The dances of a list in turn, from this place on.
    InTurn(List, usize),
}

/// Dances that follow each other on stage where the beat steps.
#[derive(Clone, Copy, Debug, PartialEq)]
enum List {
    /// The favorites, as they are now.
    Favorites,
    /// The gallery, as it was when it came on stage.
    Gallery,
}

/// The stage: at most one item, or the favorites or the gallery in turn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stage {
    shown: Option<Shown>,
    /// The gallery that is shown in turn, in its order; else empty.
    gallery: Vec<ItemId>,
    since_beat: f64,
    before: Option<ItemId>,
    /// The beats that the one shown takes to come, where a setting has changed since; else what the knobs say.
    comes_within: Option<f64>,
    /// The next item, and where the fader stood when it was chosen.
    next: Option<(ItemId, f32)>,
    /// Where it stands, in [0, 1]. It goes to the other end and, for the one after, back again.
    fader: f32,
}

impl Stage {
    /// Whether something is on stage.
    pub fn is_empty(&self) -> bool {
        self.shown.is_none()
    }

    /// Whether a gallery is shown, whose dances follow each other where the beat steps.
    pub(crate) fn shows_gallery(&self) -> bool {
        !self.gallery.is_empty()
    }

    /// The items that it names besides favorites in turn: the one shown, the one before it and the next one, and a
    /// gallery that is shown in turn.
    pub(crate) fn items(&self) -> impl Iterator<Item = ItemId> {
        let shown = match self.shown {
            Some(Shown::Item(id)) => Some(id),
            Some(Shown::InTurn(..)) | None => None,
        };
        let named = [shown, self.before, self.next.map(|(id, _)| id)];
        named.into_iter().flatten().chain(self.gallery.iter().copied())
    }

    pub(crate) fn show_item(
        &mut self,
        id: ItemId,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) {
        self.enter(Shown::Item(id), beat, favorites, parameters);
    }

    pub(crate) fn show_favorites(
        &mut self,
        first: usize,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) {
        self.enter(Shown::InTurn(List::Favorites, first), beat, favorites, parameters);
    }

    /// Shows the items of a gallery in turn, beginning with the one at the place `first`.
    pub(crate) fn show_gallery(
        &mut self,
        items: Vec<ItemId>,
        first: usize,
        beat: f64,
        favorites: &[GalleryItem],
        parameters: &Parameters,
    ) {
        self.enter(Shown::InTurn(List::Gallery, first), beat, favorites, parameters);
        self.gallery = items;
    }

    /// Brings the next one on stage.
    pub(crate) fn go(&mut self, id: ItemId, beat: f64, favorites: &[GalleryItem], parameters: &Parameters) {
        self.enter(self.once_come(id), beat, favorites, parameters);
    }

    pub(crate) fn clear(&mut self) {
        *self = Self { fader: self.fader, next: self.next, ..Self::default() };
    }

    /// The next item, and how far the fader has brought it on stage, in [0, 1].
    pub fn next(&self) -> Option<(ItemId, f32)> {
        let (id, from) = self.next?;
        let way = if from < 0.5 { 1.0 - from } else { -from };
        Some((id, ((self.fader - from) / way).clamp(0.0, 1.0)))
    }

    /// Where the fader stands, in [0, 1].
    pub fn fader(&self) -> f32 {
        self.fader
    }

    pub(crate) fn cue_up(&mut self, id: ItemId) {
        self.next = Some((id, self.fader));
    }

    /// Whether the fader stands at `share` already, and brings nothing on stage there.
    pub(crate) fn rests_at(&self, share: f32) -> bool {
        self.fader.to_bits() == share.to_bits() && self.next().is_none_or(|(_, come)| come < FADED)
    }

    /// Moves the fader; at its end the next one is on stage.
    pub(crate) fn fade(&mut self, to: f32, beat: f64) {
        self.fader = to.clamp(0.0, 1.0);
        if let Some((id, share)) = self.next()
            && share >= FADED
            && self.shown.is_some()
        {
            self.put(self.once_come(id), beat);
            (self.before, self.next) = (None, None);
        }
    }

    /// What is shown once the next one has come. A gallery in turn goes on from it, where it has it.
    fn once_come(&self, id: ItemId) -> Shown {
        let place = self.gallery.iter().position(|known| *known == id);
        place.map_or(Shown::Item(id), |place| Shown::InTurn(List::Gallery, place))
    }

    fn put(&mut self, shown: Shown, beat: f64) {
        if !matches!(shown, Shown::InTurn(List::Gallery, _)) {
            self.gallery.clear();
        }
        (self.shown, self.since_beat, self.comes_within) = (Some(shown), beat, None);
    }

    fn enter(&mut self, shown: Shown, beat: f64, favorites: &[GalleryItem], parameters: &Parameters) {
        self.before =
            self.scene(beat, favorites, parameters).map(|s| if s.weight < 0.5 { s.from } else { s.to });
        self.put(shown, beat);
        self.next = None;
    }

    /// The scene after `beat` beats; `None` where the stage is empty.
    pub fn scene(&self, beat: f64, favorites: &[GalleryItem], parameters: &Parameters) -> Option<Scene> {
        let scene = self.by_beats(beat, favorites, parameters)?;
        match self.next() {
            Some((to, share)) if share > 0.0 => {
                let from = if scene.weight < 0.5 { scene.from } else { scene.to };
                Some(Scene { from, to, weight: if from == to { 1.0 } else { smooth(share) } })
            }
            _ => Some(scene),
        }
    }

    /// The beats that the dance shown takes to come; where others follow it, it is whole before the next one comes.
    fn transition_beats(&self, parameters: &Parameters) -> f64 {
        let steps = matches!(self.shown, Some(Shown::InTurn(..))) && parameters.is_on(Switch::BeatSteps);
        let most = if steps { turns::beats_per_step(parameters) } else { f64::INFINITY };
        let by_knob = || f64::from(parameters.get(Parameter::TransitionBeats));
        self.comes_within.unwrap_or_else(by_knob).min(most)
    }

    /// A dance that has begun to come goes on as it began, whatever `parameters` become, and what has left stays away.
    pub(crate) fn keep_transition(&mut self, beat: f64, favorites: &[GalleryItem], parameters: &Parameters) {
        match self.in_turn(beat, favorites, parameters) {
            Some((stage, _)) => *self = stage,
            None => self.comes_within = Some(self.transition_beats(parameters)),
        }
    }

    fn by_beats(&self, beat: f64, favorites: &[GalleryItem], parameters: &Parameters) -> Option<Scene> {
        let gone = (beat - self.since_beat).max(0.0);
        let entering = |to: ItemId| {
            let from = self.before.unwrap_or(to);
            let weight = if from == to { 1.0 } else { ease(gone, self.transition_beats(parameters)) };
            Scene { from, to, weight }
        };
        match self.shown? {
            Shown::Item(id) => Some(entering(id)),
            Shown::InTurn(list, first) => {
                let count = self.count(list, favorites);
                if count == 0 {
                    return None;
                }
                let at = |step: usize| self.at(list, turns::index(first, step, count), favorites);
                let per_step = turns::beats_per_step(parameters);
                let step = turns::steps(gone, parameters);
                if step < 1.0 {
                    return at(0).map(entering);
                }
                let from = at(step as usize - 1)?;
                let to = at(step as usize)?;
                let transition = f64::from(parameters.get(Parameter::TransitionBeats));
                let weight = ease(gone - step * per_step, transition.min(per_step));
                Some(Scene { from, to, weight: if from == to { 1.0 } else { weight } })
            }
        }
    }
}

/// The effect of the beat on the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Turn of the model about the vertical, in radians.
    pub turn_rad: f32,
    /// Turn of the lights about the vertical, in radians.
    pub light_turn_rad: f32,
    /// Factor on the lights' intensity, before the flash limiter; at least 1.
    pub light_gain: f32,
}

/// The reaction to a beat. At each beat a random draw decides whether the model or the lights move (as in the
/// paper); the movement takes half a beat and ends at rest. `seed_of` gives the seed by which a beat is drawn.
pub fn react(beat: Beat, seed_of: impl Fn(u64) -> u64, parameters: &Parameters) -> Reaction {
    let n = beat.count.max(0.0).floor();
    let phase = (beat.count.max(0.0) - n) as f32;
    let sure = if beat.confidence.is_finite() { beat.confidence.clamp(0.0, 1.0) } else { 0.0 };
    let ease = ease(f64::from(phase), 0.5);
    let swing = |kind: u64| {
        let (old, new) = (pose(&seed_of, n as u64, kind), pose(&seed_of, (n as u64).saturating_add(1), kind));
        sure * (old + ease * (new - old))
    };
    let on = |switch, value| if parameters.is_on(switch) { value } else { 0.0 };
    Reaction {
        turn_rad: on(Switch::BeatTurns, parameters.get(Parameter::TurnRad) * swing(0)),
        light_turn_rad: on(Switch::BeatLights, parameters.get(Parameter::LightSwingRad) * swing(1)),
        light_gain: 1.0
            + on(Switch::BeatLights, parameters.get(Parameter::LightPulse) * sure * (1.0 - phase).powi(2)),
    }
}

/// The position of the model (kind 0) or the lights (kind 1) before beat `n`, in [−1, 1]: a new one at each
/// beat that was drawn for this kind, kept until the next such beat.
fn pose(seed_of: &impl Fn(u64) -> u64, n: u64, kind: u64) -> f32 {
    for beat in (n.saturating_sub(32)..n).rev() {
        let draw = hash(seed_of(beat), beat);
        if draw & 1 == kind {
            // Sides alternate with the beat, so that the movement stays visible.
            let size = 0.3 + 0.7 * ((draw >> 40) as f32 / (1u64 << 24) as f32);
            return if beat % 2 == 0 { size } else { -size };
        }
    }
    0.0
}

/// Random bits that are a function of seed and number alone.
pub(crate) fn hash(seed: u64, n: u64) -> u64 {
    mixed(seed.wrapping_add(n.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// SplitMix64's finalizer (Steele, Lea and Flood 2014).
pub(crate) fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// 0 at `gone` = 0, 1 from `duration` on, smooth in between.
fn ease(gone: f64, duration: f64) -> f32 {
    if gone >= duration {
        return 1.0;
    }
    smooth((gone / duration).max(0.0) as f32)
}

/// Which of `weights` a random number draws, each as often as it weighs; none where all are 0.
pub(crate) fn drawn(weights: impl Iterator<Item = u64> + Clone, draw: u64) -> Option<usize> {
    let mut left = draw % weights.clone().sum::<u64>().max(1);
    weights.enumerate().find_map(|(i, weight)| {
        let is_it = left < weight;
        left = left.saturating_sub(weight);
        is_it.then_some(i)
    })
}

/// From 0 to 1 with rest at both ends, for x in [0, 1].
pub fn smooth(x: f32) -> f32 {
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests;
