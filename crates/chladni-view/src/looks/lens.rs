//! Looks through a lens that is near and wide open: little of the shape is in focus.

use super::*;

impl Look {
    /// A wet leaf in the morning, very near: what is not in focus is soft, and drops of light come off what moves.
    pub const DEW: Self = Self {
        material: Material {
            roughness: 0.14,
            softness: 0.55,
            iridescence: 0.1,
            edge: [70, 110, 80],
            ..Material::BARE
        },
        answer: answer_from(0.35, Palette::Moss, 0.35, 0.0, 0.55, 0.12),
        lights: Lights {
            lights: [
                lamp(LEFT, [1.0, 0.98, 0.86]),
                lamp(RIGHT, [0.16, 0.3, 0.26]),
                lamp(BEHIND, [0.95, 1.0, 0.75]),
            ],
            sky: [0.34, 0.42, 0.4],
            ground: [0.12, 0.16, 0.08],
            shadow: 0.7,
            strips: 0.6,
            horizon: [0.2, 0.24, 0.14],
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([150, 178, 120], [34, 62, 50]),
        finish: Finish { blur: 0.6, bloom: 0.45, bloom_from: 0.7, vignette: 0.4, ..Finish::NOTHING },
        response: Response { light: 0.4, halo: 0.4, ..Self::AURORA.response },
    };
}
