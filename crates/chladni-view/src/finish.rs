//! Effects on a finished picture: depth of field, glow around bright places, trails, a darker rim, grain.

use bytemuck::{Pod, Zeroable};

/// Effects on the whole picture, in the order in which they are laid over it. All 0 is nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finish {
    /// How soft everything out of focus is, in [0, 1]: the opening of the lens, as a share of the camera's
    /// [reach](crate::Camera::reach). With 0 everything is sharp.
    pub blur: f32,
    /// Where the focus is: from the camera's target towards the viewer, as a share of its reach, in [−1, 1]. A fifth of
    /// the reach on either side is as sharp.
    pub focus: f32,
    /// Whether the blur stays in a look that takes its place.
    pub keeps_blur: bool,
    /// Trails: how long light stays visible, in seconds until a third of it is left; 0 for no trails.
    pub trail_secs: f32,
    /// How fast trails grow from the middle, in sizes per second; below 0 they shrink.
    pub trail_growth: f32,
    /// How much light spreads from bright places, in [0, 2].
    pub bloom: f32,
    /// From which brightness on, in [0, 1).
    pub bloom_from: f32,
    /// How much darker the corners are, in [0, 1].
    pub vignette: f32,
    /// How much each pixel differs by chance, in [0, 1]. Changes 24 times a second.
    pub grain: f32,
    /// Which effects, in the order of [`Effect::NAMED`], were left out of it, and stay so in a look that takes its place.
    pub left_out: [bool; 4],
}

/// An effect that can be left out of a finish; depth of field has a strength that can be chosen instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Light that stays visible for a while.
    Trails,
    /// Light that spreads from bright places.
    Glow,
    /// Darker corners.
    Corners,
    /// Noise.
    Grain,
}

impl Effect {
    /// Names and effects, for menus and the command line.
    pub const NAMED: [(&'static str, Self); 4] =
        [("trails", Self::Trails), ("glow", Self::Glow), ("corners", Self::Corners), ("grain", Self::Grain)];

    /// The effect called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.into_iter().find(|(known, _)| *known == name).map(|(_, effect)| effect)
    }
}

impl Finish {
    /// No effect; a blur that is added is focused on the front of the shape.
    pub const NOTHING: Self = Self {
        blur: 0.0,
        focus: 0.25,
        keeps_blur: false,
        trail_secs: 0.0,
        trail_growth: 0.0,
        bloom: 0.0,
        bloom_from: 0.0,
        vignette: 0.0,
        grain: 0.0,
        left_out: [false; 4],
    };

    fn amount(&mut self, effect: Effect) -> &mut f32 {
        match effect {
            Effect::Trails => &mut self.trail_secs,
            Effect::Glow => &mut self.bloom,
            Effect::Corners => &mut self.vignette,
            Effect::Grain => &mut self.grain,
        }
    }

    /// Whether the picture has this effect.
    pub fn has(mut self, effect: Effect) -> bool {
        *self.amount(effect) > 0.0
    }

    /// The same with this effect left out.
    #[must_use]
    pub fn without(mut self, effect: Effect) -> Self {
        *self.amount(effect) = 0.0;
        self.left_out[effect as usize] = true;
        self
    }

    /// The same with all of these left out.
    #[must_use]
    pub fn without_all(self, left_out: [bool; 4]) -> Self {
        let all = Effect::NAMED.into_iter().map(|(_, effect)| effect);
        all.filter(|effect| left_out[*effect as usize]).fold(self, Self::without)
    }

    /// Without the effects that read other pixels than the one they change: these cost most.
    pub fn without_glow(self) -> Self {
        Self { blur: 0.0, trail_secs: 0.0, bloom: 0.0, ..self }
    }

    /// Whether the picture stays as it is.
    pub fn is_nothing(&self) -> bool {
        let Self { blur, trail_secs, bloom, vignette, grain, .. } = *self;
        [blur, trail_secs, bloom, vignette, grain].iter().all(|share| *share <= 0.0)
    }

    /// The numbers for a picture of this size at `at_secs`; the last one was shown at `before_secs`.
    pub(crate) fn uniform(
        &self,
        [width, height]: [u32; 2],
        at_secs: f64,
        before_secs: Option<f64>,
    ) -> FinishUniform {
        let since_secs = before_secs.map_or(0.0, |before| at_secs - before);
        // There are no trails after a pause or a jump, or if no time has passed.
        let follows = since_secs > 0.0 && since_secs < LONGEST_SECS && self.trail_secs > 0.0;
        let fade = if follows { (FADE_PER_SEC * since_secs).max(LEAST_FADE) as f32 } else { 0.0 };
        let since_secs = since_secs as f32;
        let left = if follows { (-since_secs / self.trail_secs).exp() } else { 0.0 };
        let shrink = if follows { (-self.trail_growth * since_secs).exp() } else { 1.0 };
        FinishUniform {
            size: [width as f32, height as f32],
            trail: [left, shrink],
            bloom: [self.bloom.max(0.0), self.bloom_from.clamp(0.0, 0.99)],
            vignette: self.vignette.clamp(0.0, 1.0),
            grain: self.grain.clamp(0.0, 1.0),
            moment: (at_secs * 24.0).floor() as i64 as u32,
            step: step(height),
            fade,
            padding: 0,
        }
    }
}

/// Pictures farther apart than this leave no trails.
const LONGEST_SECS: f64 = 0.5;

/// Trails lose this many 255ths a second besides their share: a share of a small number is rounded to the same number, so
/// that they would never end.
const FADE_PER_SEC: f64 = 42.0;
/// And at least this many a picture, of which rounding leaves one.
const LEAST_FADE: f64 = 0.51;

/// How many pixels wide a pixel of the small picture is, on which light spreads and which has about 180 rows.
pub(crate) fn step(height: u32) -> u32 {
    (height / 180).max(1)
}

/// A finish, as `finish.wgsl` describes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct FinishUniform {
    pub(crate) size: [f32; 2],
    /// Share of the last picture that is left, and the part of its size that is seen.
    pub(crate) trail: [f32; 2],
    /// Strength and threshold.
    pub(crate) bloom: [f32; 2],
    pub(crate) vignette: f32,
    pub(crate) grain: f32,
    pub(crate) moment: u32,
    pub(crate) step: u32,
    /// The 255ths that trails lose besides, in this picture.
    pub(crate) fade: f32,
    pub(crate) padding: u32,
}

/// How light spreads along a row of the small picture: a Gaussian with a deviation of two pixels.
pub(crate) const SPREAD: [f32; 5] = [0.2042, 0.1802, 0.1238, 0.0663, 0.0276];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_spreads_is_neither_more_nor_less() {
        let all = SPREAD[0] + 2.0 * SPREAD[1..].iter().sum::<f32>();
        assert!((all - 1.0).abs() < 1e-6, "{all}");
    }

    #[test]
    fn each_effect_can_be_left_out_alone() {
        let finish =
            Finish { trail_secs: 0.2, bloom: 0.8, vignette: 0.5, grain: 0.1, blur: 0.6, ..Finish::NOTHING };
        let left_out =
            |effect| Finish { left_out: Effect::NAMED.map(|(_, known)| known == effect), ..finish };
        for (expected, effect) in [
            (Finish { trail_secs: 0.0, ..left_out(Effect::Trails) }, Effect::Trails),
            (Finish { bloom: 0.0, ..left_out(Effect::Glow) }, Effect::Glow),
            (Finish { vignette: 0.0, ..left_out(Effect::Corners) }, Effect::Corners),
            (Finish { grain: 0.0, ..left_out(Effect::Grain) }, Effect::Grain),
        ] {
            let rest = finish.without(effect);
            assert_eq!(rest, expected);
            assert!(finish.has(effect) && !rest.has(effect));
            assert_eq!(finish.without_all(rest.left_out), rest);
        }
        let all = Effect::NAMED.into_iter().fold(finish, |rest, (_, effect)| rest.without(effect));
        assert!(Finish { blur: 0.0, ..all }.is_nothing());
        assert!(Effect::NAMED.iter().all(|(name, effect)| Effect::named(name) == Some(*effect)));
    }

    #[test]
    fn trails_last_as_long_at_every_frame_rate_and_none_follows_a_pause() {
        let finish = Finish { trail_secs: 0.2, trail_growth: 0.3, ..Finish::NOTHING };
        let left = |fps: u32| {
            let frames = (0..fps / 5).map(|i| f64::from(i) / f64::from(fps));
            let all =
                frames.map(|secs| finish.uniform([4, 4], secs + 1.0 / f64::from(fps), Some(secs)).trail);
            all.fold([1.0, 1.0], |a, b| [a[0] * b[0], a[1] * b[1]])
        };
        for fps in [10, 30, 60] {
            let [light, size] = left(fps);
            assert!((light - (-1.0f32).exp()).abs() < 1e-3, "{fps}: {light}");
            assert!((size - (-0.06f32).exp()).abs() < 1e-3, "{fps}: {size}");
        }
        // What they lose besides is the same in a second as well, and at 60 pictures the number that it always was.
        let fade = |fps: u32| finish.uniform([4, 4], 7.0 + 1.0 / f64::from(fps), Some(7.0)).fade;
        assert_eq!((fade(60), fade(240)), (0.7, 0.51));
        for fps in [10, 24, 30, 60] {
            assert!((fps as f32 * fade(fps) - 42.0).abs() < 1e-3, "{fps}: {}", fade(fps));
        }
        for before in [None, Some(1.0), Some(2.0), Some(0.2)] {
            assert_eq!(finish.uniform([4, 4], 1.0, before).trail, [0.0, 1.0], "{before:?}");
        }
    }
}
