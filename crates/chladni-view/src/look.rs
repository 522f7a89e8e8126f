//! The look of a whole scene: material, palette, light, ground and finish, and how they answer to music.

use crate::style::luminance;
use crate::{Answer, Background, Finish, Lights, Material};

/// All that makes a picture beside the shapes and the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The material of the shapes.
    pub material: Material,
    /// How movement colors them; none leaves the material's own color. Its lengths are shares of the farthest
    /// that a shape may go: see [`scaled`](Self::scaled).
    pub answer: Option<Answer>,
    /// Whether shapes that bring colors or a texture show those in the place of both.
    pub own_colors: bool,
    /// The lights.
    pub lights: Lights,
    /// The background and the floor.
    pub background: Background,
    /// Effects on the finished picture.
    pub finish: Finish,
    /// The effect of music on all of it.
    pub response: Response,
}

/// How a look answers to a [`Mood`]; all 0 is not at all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// How much of the palette goes by in a beat, there and back.
    pub flow: f32,
    /// How much of the palette lies between dull and shrill sound.
    pub timbre: f32,
    /// How much of the palette lies between a sound that both channels share and one that they do not.
    pub sides: f32,
    /// Turns of the palette per turn of the circle of fifths: a whole number, so that colors do not jump.
    pub key: f32,
    /// Glow added at full level in both channels.
    pub glow: f32,
    /// How much of the light comes with the level, in [0, 1]: with that of the left channel in the left of the
    /// picture.
    pub light: f32,
    /// How much of the background's light comes with the level, in [0, 1], in the same way.
    pub halo: f32,
    /// How much of the colors' strength comes with the level of both channels, in [0, 1].
    pub saturation: f32,
    /// Rim light added on a beat, as a share of it.
    pub rim: f32,
}

/// The sound that a look answers to. Each in [0, 1] except `beats`, which only grows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mood {
    /// How loud it is left and right.
    pub levels: [f32; 2],
    /// How shrill.
    pub timbre: f32,
    /// How much of it the two channels do not share.
    pub sides: f32,
    /// Where on the circle of fifths it is, in turns.
    pub key_turns: f32,
    /// Beats so far, with the phase as the fraction.
    pub beats: f64,
    /// How sure the beat is.
    pub certainty: f32,
    /// 1 on a beat, fading until the next.
    pub accent: f32,
}

impl Look {
    /// The look called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::PRESETS.iter().find(|(known, _)| *known == name).map(|(_, look)| *look)
    }

    /// This look in the place of another one. A viewer's wishes for all looks stay: a shape's own colors, the effects that
    /// are left out, and a blur that is [kept](Finish::keeps_blur).
    pub fn in_place_of(self, other: &Self) -> Self {
        let mut finish = self.finish.without_all(other.finish.left_out);
        if other.finish.keeps_blur {
            (finish.blur, finish.keeps_blur) = (other.finish.blur, true);
        }
        Self { own_colors: other.own_colors, finish, ..self }
    }

    /// This look for shapes that may go as far as `farthest`, in the coordinates of their items.
    pub fn scaled(mut self, farthest: f32) -> Self {
        let unit = 1.0 / farthest.max(1e-6);
        if let Some(answer) = &mut self.answer {
            let Answer { swing, travel, haste, glow, spark, .. } = *answer;
            (answer.swing, answer.travel, answer.haste) = (unit * swing, unit * travel, unit * haste);
            (answer.glow, answer.spark, answer.farthest) = (unit * glow, unit * spark, 1.0 / unit);
        }
        self
    }

    /// This look from a camera that is turned by `yaw_rad` from the front: what is lit is the side of the shape that
    /// a channel moves, wherever in the picture it is. Seen edge on, both sides have the mean of their light.
    pub fn seen_from(mut self, yaw_rad: f32) -> Self {
        let own = 0.5 + 0.5 * yaw_rad.cos();
        let mix = |near: f32, far: f32| own * near + (1.0 - own) * far;
        let turned = |[left, right]: [f32; 2]| [mix(left, right), mix(right, left)];
        self.lights.exposure = turned(self.lights.exposure);
        self.background.strength = turned(self.background.strength);
        self
    }

    /// Relative luminance (WCAG 2.2), in [0, 1], of a flat surface at rest in white light: of the material's color, or the
    /// mean of the palette's colors along the shape. The shape's [own colors](Self::own_colors) do not count.
    pub fn surface_luminance(&self) -> f32 {
        const PLACES: usize = 64;
        let Some(Answer { palette, offset, span, .. }) = self.answer else {
            return luminance(self.material.color);
        };
        let along = (0..PLACES).map(|i| i as f32 / (PLACES - 1) as f32);
        let all = along.map(|along| luminance(palette.color(palette.place(offset + span * along))));
        all.sum::<f32>() / PLACES as f32
    }

    /// Whether it colors by speed, for which figures need their [lag](crate::Figure::lag).
    pub fn feels_speed(&self) -> bool {
        self.answer.is_some_and(|answer| answer.feels_speed())
    }

    /// This look while that is heard. It depends on nothing else, so that a film shows what a window did.
    pub fn answering(mut self, mood: &Mood) -> Self {
        let Response { flow, timbre, sides, key, glow, light, halo, saturation, rim } = self.response;
        let with_level = |share: f32, level: f32| 1.0 - share * (1.0 - level);
        let sided = |share: f32| mood.levels.map(|level| with_level(share, level));
        // Light that has no place must not tell of one channel alone.
        let level = (mood.levels[0] * mood.levels[1]).sqrt();
        if let Some(answer) = &mut self.answer {
            // There and back, so that a beat that is lost or found makes no jump.
            let gone = 1.0 - ((f64::from(flow) * mood.beats).rem_euclid(2.0) - 1.0).abs() as f32;
            answer.offset += mood.certainty * gone + timbre * mood.timbre + sides * mood.sides;
            answer.offset += key * answer.palette.period() * mood.key_turns;
            answer.saturation *= with_level(saturation, level);
        }
        self.material.glow += glow * level * f32::from(u8::from(self.answer.is_some()));
        let exposure = &mut self.lights.exposure;
        *exposure = std::array::from_fn(|side| exposure[side] * sided(light)[side]);
        self.lights.lights[2].color = self.lights.lights[2].color.map(|c| c * (1.0 + rim * mood.accent));
        // In steps that nobody sees: a background that did not change is not painted again.
        self.background.strength = sided(halo).map(|strength| (strength * 255.0).round() / 255.0);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_have_names_of_their_own_and_differ() {
        for (i, (name, look)) in Look::PRESETS.iter().enumerate() {
            assert_eq!(Look::named(name), Some(*look));
            assert!(Look::PRESETS[..i].iter().all(|(other, as_well)| other != name && as_well != look));
        }
    }

    #[test]
    fn a_surface_is_as_light_as_its_palette_or_else_its_material() {
        let near = |look: Look, luminance: f32| {
            let found = look.surface_luminance();
            assert!((found - luminance).abs() < 0.01, "{found} instead of {luminance}");
        };
        near(Look { material: Material { color: [255; 3], ..Look::PLAIN.material }, ..Look::PLAIN }, 1.0);
        near(Look { material: Material { color: [0; 3], ..Look::PLAIN.material }, ..Look::PLAIN }, 0.0);
        // The palette's end, from where its colors run back.
        near(Look::PORCELAIN, luminance(crate::Palette::Orchid.color(1.0)));
        let beyond = Look::PORCELAIN.answer.map(|answer| Answer { offset: 1.75, ..answer });
        near(Look { answer: beyond, ..Look::PORCELAIN }, luminance(crate::Palette::Orchid.color(0.25)));
    }

    #[test]
    fn lamps_show_the_form_of_dark_looks_where_it_is_loud() {
        let loud = Mood { levels: [1.0; 2], ..Mood::default() };
        for look in [Look::AURORA, Look::EMBER, Look::ABYSS, Look::NEON] {
            let look = look.answering(&loud);
            // Glow has no shadows: if it outshone the lamps, the form would be lost.
            let own = look.material.glow + look.answer.unwrap().glow;
            let lamps = |c: usize| look.lights.lights.iter().map(|lamp| lamp.color[c]).sum::<f32>();
            assert!(3.0 * own < (0..3).map(lamps).fold(0.0, f32::max), "{look:?}");
        }
    }

    #[test]
    fn light_is_on_the_side_that_sounds_and_turns_with_the_shape() {
        let look = Look::AURORA.answering(&Mood { levels: [1.0, 0.0], ..Mood::default() });
        let sides = |look: &Look| [look.lights.exposure, look.background.strength];
        let [[bright, dim], [strong, weak]] = sides(&look);
        assert!(bright > 1.5 * dim && strong > 1.5 * weak, "{look:?}");
        assert_eq!(bright, Look::AURORA.lights.exposure[0]);
        assert_eq!(sides(&look.seen_from(0.0)), sides(&look));
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
        let behind = sides(&look.seen_from(std::f32::consts::PI));
        assert!(near(behind[0][0], dim) && near(behind[0][1], bright) && near(behind[1][1], strong));
        let [light, _] = sides(&look.seen_from(std::f32::consts::FRAC_PI_2));
        assert!(near(light[0], light[1]) && near(light[0], 0.5 * (bright + dim)));
        for (name, look) in Look::PRESETS {
            let both = look.answering(&Mood { levels: [0.4; 2], ..Mood::default() });
            assert_eq!(both.lights.exposure[0], both.lights.exposure[1], "{name}");
            assert_eq!(both.background.strength[0], both.background.strength[1], "{name}");
        }
    }

    #[test]
    fn light_and_color_grow_with_the_level_and_nothing_jumps() {
        for (name, look) in Look::PRESETS {
            let at = |level: f32| look.answering(&Mood { levels: [level; 2], ..Mood::default() });
            let (silent, loud) = (at(0.0), at(1.0));
            assert!(silent.lights.exposure <= loud.lights.exposure, "{name}");
            // Plain answers to nothing. A quarter of the light is seen on calm songs, too.
            assert!(name == "plain" || silent.lights.exposure[0] <= 0.75 * loud.lights.exposure[0], "{name}");
            assert_eq!(loud.lights.exposure, look.lights.exposure, "{name}");
            assert_eq!(loud.background, look.background, "{name}");
            let place = |key_turns| {
                let answer = look.answering(&Mood { key_turns, ..Mood::default() }).answer?;
                Some(answer.offset.rem_euclid(answer.palette.period()))
            };
            if let (Some(first), Some(last)) = (place(0.0), place(1.0)) {
                let around = (last - first).abs();
                assert!(
                    around < 1e-5 || (2.0 - around).abs() < 1e-5 || (1.0 - around).abs() < 1e-5,
                    "{name}"
                );
            }
            for beats in [0.0, 7.9, 1e6] {
                let at = |beats| {
                    let mood = Mood { beats, certainty: 1.0, ..Mood::default() };
                    look.answering(&mood).answer.map(|a| a.offset)
                };
                if let (Some(a), Some(b)) = (at(beats), at(beats + 0.01)) {
                    assert!((b - a).abs() < 0.01, "{name}: {a} to {b}");
                }
            }
        }
    }
}
