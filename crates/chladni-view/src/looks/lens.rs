//! Looks through a near lens with a wide opening: little of the shape is in focus.

use super::*;

impl Look {
    /// A wet leaf in the morning, very near: all out of focus is soft, and drops of light come off moving parts.
    pub const DEW: Self = Self {
        material: Material {
            roughness: 0.14,
            softness: 0.55,
            iridescence: 0.1,
            edge: [70, 110, 80],
            ..Material::BARE
        },
        answer: answer_from(0.12, Palette::Moss, 0.2, 0.0, 0.7, 0.03),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.8, 0.8, 0.66]),
                lamp(RIGHT, [0.16, 0.3, 0.26]),
                lamp(BEHIND, [0.8, 0.95, 0.55]),
            ],
            sky: [0.22, 0.3, 0.28],
            ground: [0.06, 0.1, 0.05],
            shadow: 0.7,
            strips: 0.6,
            horizon: [0.2, 0.24, 0.14],
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([150, 178, 120], [34, 62, 50]),
        finish: Finish { blur: 0.6, bloom: 0.4, bloom_from: 0.76, vignette: 0.4, ..Finish::NOTHING },
        response: Response { glow: 0.03, light: 0.55, halo: 0.5, ..Self::AURORA.response },
    };
}
