//! The camera that chooses its shots: a pure function of the bars gone by and of a seed.
//!
//! Bars come in one after the other, so that a song that is known as a whole and one that is being heard are filmed
//! by the same rule: a shot is planned when it begins, and depends on nothing that comes later.

/// The beginning of a bar, as the music has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BarLine {
    /// When it begins.
    pub at_secs: f64,
    /// How long it is, or is expected to be.
    pub secs: f64,
    /// How much goes on, in [0, 1].
    pub energy: f32,
    /// A section of the song begins with it.
    pub begins_section: bool,
}

/// From where a shape is seen, relative to the viewer's own place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Framing {
    /// How far it is turned about the vertical; positive moves the viewer to the right.
    pub yaw_rad: f32,
    /// How far it is raised.
    pub pitch_rad: f32,
    /// 0: the whole figure, as far as it fills the picture; 1: as near as a picture may be.
    pub closeness: f32,
    /// 0: the middle of the figure is looked at; 1: the part that moves most.
    pub toward_part: f32,
    /// 0: all of a figure is seen, however slim; 1: the lower part of a slim one is left out, so that the rest is larger.
    pub crop: f32,
}

impl Framing {
    /// A share of the way to another one: 0 stays, 1 arrives.
    pub fn toward(self, to: Self, share: f32) -> Self {
        let mix = |from: f32, to: f32| from + share * (to - from);
        Self {
            yaw_rad: mix(self.yaw_rad, to.yaw_rad),
            pitch_rad: mix(self.pitch_rad, to.pitch_rad),
            closeness: mix(self.closeness, to.closeness),
            toward_part: mix(self.toward_part, to.toward_part),
            crop: mix(self.crop, to.crop),
        }
    }
}

/// A kind of shot: its names are those of the film trade.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The figure from the front.
    Front,
    /// Around the figure, from one side to the other.
    Orbit,
    PushIn,
    PullOut,
    /// From below the horizon.
    LowAngle,
    FromAbove,
    /// Near the part that moves most.
    Close,
}

const KINDS: [Kind; 7] =
    [Kind::Front, Kind::Orbit, Kind::PushIn, Kind::PullOut, Kind::LowAngle, Kind::FromAbove, Kind::Close];

/// Below this energy the camera keeps its shot; above the other it cuts sooner, and more often than it glides.
const CALM: f32 = 0.35;
const LIVELY: f32 = 0.65;
/// No shot is planned shorter than this.
const SHORTEST_SECS: f64 = 3.6;
/// The most bars that a shot lasts in a calm passage.
const LONGEST_CALM_BARS: u32 = 24;
/// Shots that are remembered, besides those that are being seen.
const REMEMBERED: usize = 2;

/// One shot, planned when it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shot {
    at_secs: f64,
    /// How long it is meant to last.
    secs: f64,
    /// How long the glide into it lasts; 0 is a cut.
    glide_secs: f64,
    kind: Kind,
    /// To the right or to the left, 1 or -1.
    side: f32,
    /// In [0, 1]: how far it goes.
    reach: f32,
}

impl Shot {
    fn at(&self, secs: f64) -> Framing {
        let x = ((secs - self.at_secs) / self.secs.max(1e-3)).max(0.0);
        // Past its planned end a shot comes to rest.
        let gone = if x < 1.0 { x } else { 1.0 + 0.4 * (1.0 - ((1.0 - x) / 0.4).exp()) } as f32;
        let (side, reach) = (self.side, self.reach);
        let drift = side * (gone - 0.5);
        let away = (1.0 - gone).max(0.0);
        let [yaw_rad, pitch_rad, closeness, toward_part, crop] = match self.kind {
            Kind::Front => [0.16 * drift, 0.0, 0.0, 0.0, 0.0],
            Kind::Orbit => [(0.7 + 0.5 * reach) * drift, 0.08 * reach, 0.0, 0.0, 1.0],
            Kind::PushIn => [0.25 * side + 0.2 * drift, 0.02, 0.55 * gone, 0.3 * gone, gone],
            Kind::PullOut => [0.3 * drift - 0.2 * side, 0.06, 0.55 * away, 0.3 * away, away],
            Kind::LowAngle => [0.3 * side + 0.35 * drift, -0.36 - 0.1 * reach, 0.0, 0.0, 0.5],
            Kind::FromAbove => [0.5 * drift, 0.5 + 0.25 * reach, 0.0, 0.0, 0.5],
            Kind::Close => [0.35 * side + 0.3 * drift, 0.04, 0.65, 0.9, 1.0],
        };
        Framing { yaw_rad, pitch_rad, closeness: closeness.clamp(0.0, 1.0), toward_part, crop: crop.min(1.0) }
    }
}

/// The shots that can be called by hand, by name.
pub const SHOTS: [&str; 7] = ["front", "orbit", "push-in", "pull-out", "low-angle", "from-above", "close"];
/// How long a shot that is called is meant to last.
const CALLED_SECS: f64 = 12.0;

impl Framing {
    /// The framing of shot `shot` of [`SHOTS`], given the seconds since it was called; the first one for a number
    /// beyond.
    pub fn of_shot(shot: usize, gone_secs: f64) -> Self {
        let kind = KINDS.get(shot).copied().unwrap_or(Kind::Front);
        let shot = Shot { at_secs: 0.0, secs: CALLED_SECS, glide_secs: 0.0, kind, side: 1.0, reach: 0.5 };
        shot.at(gone_secs.max(0.0))
    }
}

/// Chooses the shots of one song, or of live sound.
#[derive(Clone, Debug, PartialEq)]
pub struct Director {
    seed: u64,
    /// How many there were so far.
    count: u64,
    shots: Vec<Shot>,
    bars: u32,
    planned_bars: u32,
    /// Whether all shots are kept, for a song in which one may go back.
    keeps_all: bool,
}

impl Director {
    /// For bars that come in while they are heard, from `at_secs` of their time on.
    pub fn live(seed: u64, at_secs: f64) -> Self {
        let opening = Shot { at_secs, secs: 30.0, glide_secs: 0.0, kind: Kind::Front, side: 1.0, reach: 0.0 };
        Self { seed, count: 0, shots: vec![opening], bars: 0, planned_bars: 0, keeps_all: false }
    }

    /// For a song, in which one may go back: all shots are kept.
    pub fn of_song(seed: u64, at_secs: f64) -> Self {
        Self { keeps_all: true, ..Self::live(seed, at_secs) }
    }

    /// Another one for live sound, with the same seed.
    #[must_use]
    pub fn anew(&self, at_secs: f64) -> Self {
        Self::live(self.seed, at_secs)
    }

    /// Draws the shots that begin from now on by another seed.
    pub fn set_seed(&mut self, seed: u64) {
        self.seed = seed;
    }

    /// A bar begins: perhaps another shot does, too.
    pub fn hear(&mut self, bar: BarLine) {
        self.bars += 1;
        let calm = bar.energy < CALM;
        let is_over = if calm { self.bars > LONGEST_CALM_BARS } else { self.bars > self.planned_bars };
        if self.count > 0 && !bar.begins_section && !is_over {
            return;
        }
        let draw = |n: u64| crate::stage::hash(self.seed, 16 * self.count + n);
        let bar_secs = bar.secs.max(0.2);
        let least = (SHORTEST_SECS / bar_secs).ceil().max(1.0) as u32;
        let wanted = if calm {
            8
        } else if bar.energy < LIVELY {
            4
        } else {
            2
        };
        self.planned_bars = wanted.max(least.next_power_of_two());
        let opening = self.shots.first().filter(|_| self.count == 0);
        if opening.is_some_and(|opening| bar.at_secs - opening.at_secs < SHORTEST_SECS) {
            // It would be gone at once: it lasts as long as the shot that would follow it.
            (self.count, self.bars) = (1, 1);
            return;
        }
        let cuts = bar.begins_section || draw(0) % 4 < if bar.energy < LIVELY { 1 } else { 3 };
        // A glide from far away would be a swing of the camera.
        let glide_secs = if self.count == 0 || cuts { 0.0 } else { bar_secs.max(1.5) };
        let shot = Shot {
            at_secs: bar.at_secs,
            secs: f64::from(self.planned_bars) * bar_secs,
            glide_secs,
            kind: self.kind(bar.energy, draw(1)),
            side: if draw(2).is_multiple_of(2) { 1.0 } else { -1.0 },
            reach: (draw(3) >> 40) as f32 / (1u64 << 24) as f32,
        };
        self.shots.push(shot);
        if !self.keeps_all && self.shots.len() > REMEMBERED {
            self.shots.remove(0);
        }
        self.count += 1;
        self.bars = 1;
    }

    /// A kind that suits the energy, and is not that of the last two shots.
    fn kind(&self, energy: f32, draw: u64) -> Kind {
        let recent = || self.shots.iter().rev().take(2).map(|shot| shot.kind);
        let weight = |kind: Kind| -> u64 {
            let [calm, usual, lively] = match kind {
                Kind::Front => [2, 2, 1],
                Kind::Orbit => [4, 4, 3],
                Kind::PushIn => [3, 3, 2],
                Kind::PullOut => [2, 2, 2],
                Kind::LowAngle => [0, 2, 4],
                Kind::FromAbove => [1, 2, 2],
                Kind::Close => [0, 2, 4],
            };
            let suits = if energy < CALM {
                calm
            } else if energy < LIVELY {
                usual
            } else {
                lively
            };
            if recent().any(|recent| recent == kind) { 0 } else { suits }
        };
        let drawn = crate::stage::drawn(KINDS.into_iter().map(weight), draw);
        drawn.map_or(Kind::Front, |kind| KINDS[kind])
    }

    /// How the shape is framed at a time.
    pub fn at(&self, secs: f64) -> Framing {
        let begun = self.shots.partition_point(|shot| shot.at_secs <= secs).max(1);
        let Some(shot) = self.shots.get(begun - 1) else { return Framing::default() };
        let framing = shot.at(secs);
        let before = begun.checked_sub(2).and_then(|before| self.shots.get(before));
        match before {
            Some(before) if secs < shot.at_secs + shot.glide_secs => {
                let x = ((secs - shot.at_secs) / shot.glide_secs).clamp(0.0, 1.0) as f32;
                before.at(secs).toward(framing, crate::stage::smooth(x))
            }
            _ => framing,
        }
    }

    /// When the picture is cut, ascending.
    pub fn cuts(&self) -> impl Iterator<Item = f64> {
        self.shots.iter().skip(1).filter(|shot| shot.glide_secs == 0.0).map(|shot| shot.at_secs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_song(seed: u64, bars: Vec<BarLine>) -> Director {
        let mut director = Director::of_song(seed, 0.0);
        bars.into_iter().for_each(|bar| director.hear(bar));
        director
    }

    fn bars(energy: impl Fn(usize) -> f32) -> Vec<BarLine> {
        let bar = |i: usize| BarLine {
            at_secs: 0.5 + 2.0 * i as f64,
            secs: 2.0,
            energy: energy(i),
            begins_section: i.is_multiple_of(16),
        };
        (0..96).map(bar).collect()
    }

    #[test]
    fn it_cuts_on_bar_lines_only_and_glides_between() {
        for seed in 0..20 {
            let director = of_song(seed, bars(|i| i as f32 / 96.0));
            let cuts: Vec<f64> = director.cuts().collect();
            assert!(cuts.len() > 8, "{cuts:?}");
            assert!(cuts.iter().all(|cut| ((cut - 0.5) / 2.0).fract() == 0.0));
            let step = 1.0 / 60.0;
            for i in 0..(190.0 / step) as u32 {
                let (from, to) = (f64::from(i) * step, f64::from(i + 1) * step);
                if cuts.iter().any(|cut| *cut > from - 1e-9 && *cut <= to + 1e-9) {
                    continue;
                }
                let (a, b) = (director.at(from), director.at(to));
                let most = [a.yaw_rad - b.yaw_rad, a.pitch_rad - b.pitch_rad, a.closeness - b.closeness]
                    .into_iter()
                    .fold(0.0f32, |most, step| most.max(step.abs()));
                assert!(most < 0.025, "seed {seed} at {from}: {most}");
            }
        }
    }

    #[test]
    fn it_holds_while_it_is_quiet_and_two_shots_are_never_alike() {
        let shots = |energy: f32| of_song(7, bars(|_| energy)).shots;
        let (quiet, loud) = (shots(0.1), shots(0.9));
        assert!(quiet.len() * 3 < loud.len(), "{} {}", quiet.len(), loud.len());
        assert!(loud.windows(2).all(|pair| pair[0].kind != pair[1].kind));
        let secs = loud.windows(2).skip(1).map(|pair| pair[1].at_secs - pair[0].at_secs);
        assert!(secs.fold(f64::INFINITY, f64::min) >= SHORTEST_SECS);
    }

    #[test]
    fn the_opening_shot_is_not_cut_short() {
        for at_secs in [0.009, 0.5, 3.5] {
            let bar = |i: usize| BarLine {
                at_secs: at_secs + 2.0 * i as f64,
                secs: 2.0,
                energy: 0.9,
                begins_section: i == 0,
            };
            let next = of_song(1, (0..8).map(bar).collect()).shots[1].at_secs;
            assert!((SHORTEST_SECS..8.0).contains(&next), "a bar at {at_secs}, the next shot at {next}");
        }
    }

    #[test]
    fn whoever_hears_the_bars_one_by_one_sees_the_same() {
        let bars = bars(|i| [0.2, 0.5, 0.9][i / 8 % 3]);
        let whole = of_song(3, bars.clone());
        let mut live = Director::live(3, 0.0);
        let mut next = bars.into_iter().peekable();
        for i in 0..9000 {
            let at_secs = f64::from(i) / 50.0;
            while let Some(bar) = next.next_if(|bar| bar.at_secs <= at_secs) {
                live.hear(bar);
            }
            assert_eq!(live.at(at_secs), whole.at(at_secs), "{at_secs}");
        }
    }
}
