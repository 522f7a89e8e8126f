//! The autopilot: another dance and another look where a section of the music begins.

use crate::BarLine;
use crate::stage::hash;

/// A dance is not repeated within this time, unless all others are as recent.
pub const REPEAT_SECS: f64 = 600.0;
/// The shortest time that a dance lasts: at 15 s, 41 dances fill [`REPEAT_SECS`], which counts from their end.
const SHORTEST_SECS: f64 = 15.0;
/// Where no section begins, a group of four bars does after this time.
const LONG_SECS: f64 = 20.0;
const GROUP: u32 = 4;

/// A dance that may be chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// How much more often it is chosen than one of weight 1.
    pub weight: u32,
    /// The energy of the music that it suits, in [0, 1].
    pub suits: f32,
}

impl Candidate {
    /// How much more often a favorite comes.
    pub const FAVORITE: u32 = 4;

    /// By the words that a preset is found by: calm and lively name the energy that it suits.
    pub fn tagged(tags: &[String], weight: u32) -> Self {
        let has = |word: &str| tags.iter().any(|tag| tag == word);
        Self {
            weight,
            suits: if has("calm") {
                0.2
            } else if has("lively") {
                0.85
            } else {
                0.5
            },
        }
    }
}

/// The dance and the look from one bar on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// Which candidate dances.
    pub dance: usize,
    /// Which look it has.
    pub look: usize,
    /// How strongly it moves: more where more goes on.
    pub gain: f32,
}

/// Chooses turns bar by bar, from a seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Autopilot {
    seed: u64,
    candidates: Vec<Candidate>,
    looks: usize,
    /// The look of the first turn, where that is given.
    opening: Option<usize>,
    /// When each danced last.
    danced_secs: Vec<Option<f64>>,
    /// All turns, and the one that is shown.
    turns: Vec<Turn>,
    shown: usize,
    since_secs: f64,
    bars: u32,
    energy: f32,
    holds: bool,
}

impl Autopilot {
    /// Among `candidates` and a number of looks.
    pub fn new(seed: u64, candidates: Vec<Candidate>, looks: usize) -> Self {
        Self {
            seed,
            danced_secs: vec![None; candidates.len()],
            candidates,
            looks: looks.max(1),
            opening: None,
            turns: Vec::new(),
            shown: 0,
            since_secs: 0.0,
            bars: 0,
            energy: 0.5,
            holds: false,
        }
    }

    /// The first turn has this look; `None` where it is drawn, too.
    #[must_use]
    pub fn opening_in(self, look: Option<usize>) -> Self {
        Self { opening: look, ..self }
    }

    /// The current choice; `None` before the first bar.
    pub fn shown(&self) -> Option<Turn> {
        self.turns.get(self.shown).copied()
    }

    /// Whether the first of all turns is shown, or none yet.
    pub fn is_at_first(&self) -> bool {
        self.shown == 0
    }

    /// Whether it keeps the current dance and look.
    pub fn holds(&self) -> bool {
        self.holds
    }

    /// Keeps the current dance and look, or goes on.
    pub fn hold(&mut self, on: bool) {
        self.holds = on;
    }

    /// A bar begins; returns the turn that begins with it, if one does.
    pub fn hear(&mut self, bar: BarLine) -> Option<Turn> {
        self.bars += 1;
        self.energy = bar.energy;
        let gone_secs = bar.at_secs - self.since_secs;
        let in_groups = gone_secs >= LONG_SECS && self.bars % GROUP == 1;
        let due = self.turns.is_empty() || (bar.begins_section && gone_secs >= SHORTEST_SECS) || in_groups;
        if !due || self.holds {
            return None;
        }
        self.leave(bar.at_secs);
        let turn = self.turn(bar.at_secs);
        // This bar is the first of its group.
        self.bars = 1;
        turn
    }

    /// The next turn at once, or the one before; it may come on any beat, because somebody asked for it.
    pub fn step(&mut self, at_secs: f64, forward: bool) -> Option<Turn> {
        self.leave(at_secs);
        if forward && self.shown + 1 >= self.turns.len() {
            return self.turn(at_secs);
        }
        self.shown = if forward { self.shown + 1 } else { self.shown.checked_sub(1)? };
        self.begin(at_secs)
    }

    /// The dance that is shown leaves only now, however long it was held.
    fn leave(&mut self, at_secs: f64) {
        if let Some(shown) = self.shown()
            && let Some(danced_secs) = self.danced_secs.get_mut(shown.dance)
        {
            *danced_secs = Some(at_secs);
        }
    }

    fn turn(&mut self, at_secs: f64) -> Option<Turn> {
        let count = self.turns.len() as u64;
        let dance = self.choose(at_secs, hash(self.seed, 4 * count))?;
        let opening = self.opening.filter(|_| self.turns.is_empty());
        let look = opening.unwrap_or_else(|| self.choose_look(hash(self.seed, 4 * count + 1)));
        self.turns.push(Turn { dance, look, gain: 0.8 + 0.4 * self.energy.clamp(0.0, 1.0) });
        self.shown = self.turns.len() - 1;
        self.begin(at_secs)
    }

    fn begin(&mut self, at_secs: f64) -> Option<Turn> {
        let turn = self.shown()?;
        (self.since_secs, self.bars) = (at_secs, 0);
        *self.danced_secs.get_mut(turn.dance)? = Some(at_secs);
        Some(turn)
    }

    /// Never the same look twice in a row: neither as that which is shown, nor as that of the last turn, which comes
    /// next after a step back.
    fn choose_look(&self, draw: u64) -> usize {
        let before = [self.shown(), self.turns.last().copied()].map(|turn| turn.map(|turn| turn.look));
        let without = |looks: &[Option<usize>]| -> Vec<usize> {
            (0..self.looks).filter(|look| !looks.contains(&Some(*look))).collect()
        };
        // Two looks can only take turns, and one has no other.
        let others = [&before[..], &before[..1]].into_iter().map(without).find(|others| !others.is_empty());
        let others = others.unwrap_or_else(|| without(&[]));
        others.get((draw % others.len().max(1) as u64) as usize).copied().unwrap_or(0)
    }

    fn choose(&self, at_secs: f64, draw: u64) -> Option<usize> {
        let rested = |dance: &usize| {
            self.danced_secs[*dance].is_none_or(|danced_secs| at_secs - danced_secs >= REPEAT_SECS)
        };
        let free: Vec<usize> = (0..self.candidates.len()).filter(rested).collect();
        if free.is_empty() {
            let last = |dance: &usize| self.danced_secs[*dance].unwrap_or(f64::MIN);
            return (0..self.candidates.len()).min_by(|a, b| last(a).total_cmp(&last(b)));
        }
        let weight = |dance: &usize| {
            let Candidate { weight, suits } = self.candidates[*dance];
            let off = (suits - self.energy).abs();
            u64::from(weight.max(1))
                * (if off < 0.3 {
                    6
                } else if off < 0.5 {
                    2
                } else {
                    1
                })
        };
        let drawn = crate::stage::drawn(free.iter().map(weight), draw);
        drawn.and_then(|i| free.get(i)).or(free.first()).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(i: usize) -> BarLine {
        let energy = [0.2, 0.5, 0.9][i / 32 % 3];
        BarLine { at_secs: 2.0 * i as f64, secs: 2.0, energy, begins_section: i.is_multiple_of(8) }
    }

    fn candidates() -> Vec<Candidate> {
        let suits = [0.2, 0.5, 0.85];
        (0..44).map(|i| Candidate { weight: if i < 3 { 4 } else { 1 }, suits: suits[i % 3] }).collect()
    }

    #[test]
    fn nothing_comes_back_within_ten_minutes_and_favorites_come_more_often() {
        let mut counts = vec![0; 44];
        for seed in 0..10 {
            let mut autopilot = Autopilot::new(seed, candidates(), 6);
            let mut last: Vec<Option<f64>> = vec![None; 44];
            let mut look = None;
            for i in 0..5400 {
                let Some(turn) = autopilot.hear(bar(i)) else { continue };
                let at_secs = bar(i).at_secs;
                if let Some(before) = last[turn.dance].replace(at_secs) {
                    assert!(at_secs - before >= REPEAT_SECS, "{} after {}", turn.dance, at_secs - before);
                }
                assert_ne!(look.replace(turn.look), Some(turn.look));
                assert!(turn.look < 6 && (0.8..=1.2).contains(&turn.gain));
                counts[turn.dance] += 1;
            }
        }
        let favorite = counts[..3].iter().sum::<u32>() as f32 / 3.0;
        let other = counts[3..].iter().sum::<u32>() as f32 / 41.0;
        assert!(favorite > 1.1 * other, "{favorite} {other}");
        assert!(counts.iter().all(|count| *count > 10), "{counts:?}");
    }

    #[test]
    fn after_a_step_back_the_next_look_is_neither_that_shown_nor_the_last() {
        for (looks, seed) in [1, 2, 3, 6].into_iter().flat_map(|looks| (0..40).map(move |seed| (looks, seed)))
        {
            let mut autopilot = Autopilot::new(seed, candidates(), looks);
            let turns: Vec<Turn> = (0..80).filter_map(|i| autopilot.hear(bar(i))).collect();
            let back = (0..3).filter_map(|i| autopilot.step(160.0 + f64::from(i), false)).last().unwrap();
            let next = (81..120).find_map(|i| autopilot.hear(bar(i))).unwrap();
            assert!(looks == 1 || next.look != back.look, "seed {seed}: {looks} looks");
            assert!(looks < 3 || turns.last().unwrap().look != next.look, "seed {seed}: {looks} looks");
        }
    }

    #[test]
    fn the_look_of_the_opening_does_not_follow_itself() {
        for seed in 0..60 {
            let mut autopilot = Autopilot::new(seed, candidates(), 6).opening_in(Some(4));
            let looks: Vec<usize> = (0..40).filter_map(|i| Some(autopilot.hear(bar(i))?.look)).collect();
            assert!(looks.len() > 1 && looks[0] == 4 && looks[1] != 4, "seed {seed}: {looks:?}");
        }
    }

    #[test]
    fn it_turns_on_bar_lines_holds_and_can_be_overruled() {
        let mut autopilot = Autopilot::new(1, candidates(), 6);
        assert!(autopilot.shown().is_none() && autopilot.step(0.0, false).is_none());
        let first = autopilot.hear(bar(0)).unwrap();
        assert!((1..8).all(|i| autopilot.hear(bar(i)).is_none()));
        let second = autopilot.hear(bar(8)).unwrap();
        assert_ne!(first.dance, second.dance);
        autopilot.hold(true);
        assert!((9..200).all(|i| autopilot.hear(bar(i)).is_none()));
        assert_eq!(autopilot.step(401.0, false), Some(first));
        assert_eq!(autopilot.step(402.0, true), Some(second));
        let third = autopilot.step(403.0, true).unwrap();
        assert!(third.dance != second.dance && autopilot.shown() == Some(third));
        autopilot.hold(false);
        assert!(autopilot.hear(bar(202)).is_none() && autopilot.hear(bar(216)).is_some());
        // Without a section four bars are a group.
        let plain = |i: usize| BarLine { begins_section: false, ..bar(i) };
        let turns = (217..400).filter(|i| autopilot.hear(plain(*i)).is_some()).count();
        assert!((12..=18).contains(&turns), "{turns}");
        let mut steady = Autopilot::new(1, candidates(), 6);
        let turns: Vec<usize> = (0..60).filter(|i| steady.hear(plain(*i)).is_some()).collect();
        assert_eq!(turns, [0, 12, 24, 36, 48], "bars of {} s", bar(1).secs);
        assert!(Autopilot::new(1, Vec::new(), 0).hear(bar(0)).is_none());
    }
}
