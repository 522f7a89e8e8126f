//! What makes a whole scene: material, palette, light, ground and finish, and how they answer to music.

use crate::{Answer, Background, Finish, Lights, Material};

/// All that makes a picture beside the shapes and the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// What shapes are made of.
    pub material: Material,
    /// How movement colours them; none leaves the material's own colour. Its lengths are shares of the farthest
    /// that a shape may go: see [`scaled`](Self::scaled).
    pub answer: Option<Answer>,
    /// What shines.
    pub lights: Lights,
    /// What is behind and below.
    pub background: Background,
    /// What is done to the finished picture.
    pub finish: Finish,
    /// What music does to all of it.
    pub response: Response,
}

/// How a look answers to a [`Mood`]; all 0 is not at all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// How much of the palette goes by in a beat, there and back.
    pub flow: f32,
    /// How much of the palette lies between dull and shrill sound.
    pub timbre: f32,
    /// How much of the palette lies between what both channels share and what they do not.
    pub sides: f32,
    /// What full level adds to the glow.
    pub glow: f32,
    /// How much of the light comes with the level, in [0, 1].
    pub light: f32,
    /// How much of the background's light comes with the level, in [0, 1].
    pub halo: f32,
    /// How much of the colours' strength comes with the level, in [0, 1].
    pub saturation: f32,
    /// What a beat adds to the rim light, as a share of it.
    pub rim: f32,
}

/// What is heard, for a look to answer to. Each in [0, 1] but `beats`, which only grows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mood {
    /// How loud it is.
    pub level: f32,
    /// How shrill.
    pub timbre: f32,
    /// How much of it the two channels do not share.
    pub sides: f32,
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

    /// This look for shapes that may go as far as `farthest`, in the coordinates of their items.
    pub fn scaled(mut self, farthest: f32) -> Self {
        let unit = 1.0 / farthest.max(1e-6);
        if let Some(answer) = &mut self.answer {
            let Answer { swing, travel, glow, .. } = *answer;
            (answer.swing, answer.travel, answer.glow) = (unit * swing, unit * travel, unit * glow);
        }
        self
    }

    /// This look while that is heard. It depends on nothing else, so that a film shows what a window did.
    pub fn answering(mut self, mood: &Mood) -> Self {
        let Response { flow, timbre, sides, glow, light, halo, saturation, rim } = self.response;
        let with_level = |share: f32| 1.0 - share * (1.0 - mood.level);
        if let Some(answer) = &mut self.answer {
            // There and back, so that a beat that is lost or found makes no jump.
            let gone = 1.0 - ((f64::from(flow) * mood.beats).rem_euclid(2.0) - 1.0).abs() as f32;
            answer.offset += mood.certainty * gone + timbre * mood.timbre + sides * mood.sides;
            answer.saturation *= with_level(saturation);
        }
        self.material.glow += glow * mood.level * f32::from(u8::from(self.answer.is_some()));
        self.lights.exposure *= with_level(light);
        self.lights.lights[2].color = self.lights.lights[2].color.map(|c| c * (1.0 + rim * mood.accent));
        let Background { center, corner, .. } = &mut self.background;
        for (center, corner) in center.iter_mut().zip(corner) {
            let (from, to) = (f32::from(*corner), f32::from(*center));
            *center = (from + (to - from) * with_level(halo)).round() as u8;
        }
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
    fn light_and_color_grow_with_the_level_and_nothing_jumps() {
        for (name, look) in Look::PRESETS {
            let at = |level: f32| look.answering(&Mood { level, ..Mood::default() });
            let (silent, loud) = (at(0.0), at(1.0));
            assert!(silent.lights.exposure <= loud.lights.exposure, "{name}");
            assert_eq!(loud.lights.exposure, look.lights.exposure, "{name}");
            assert_eq!(loud.background, look.background, "{name}");
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
