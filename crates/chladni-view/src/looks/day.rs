//! Looks in daylight, on light grounds.

use super::*;

impl Look {
    /// White porcelain by a window; movement blushes.
    pub const PORCELAIN: Self = Self {
        material: Material { roughness: 0.18, softness: 0.4, ..Material::BARE },
        answer: answer_from(1.0, Palette::Orchid, 0.0, 0.0, 0.7, 0.0),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [1.08, 1.03, 0.93]),
                lamp(RIGHT, [0.14, 0.2, 0.32]),
                lamp(BEHIND, [0.4, 0.45, 0.55]),
            ],
            sky: [0.3, 0.33, 0.38],
            ground: [0.18, 0.14, 0.12],
            shadow: 0.75,
            strips: 0.7,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([222, 208, 196], 0.55),
            ..Background::between([240, 230, 220], [196, 180, 172])
        },
        finish: Finish { vignette: 0.12, ..Finish::NOTHING },
        response: Response { timbre: 0.0, light: 0.35, halo: 0.3, rim: 0.8, ..Self::PLAIN.response },
    };

    /// Sugar in all pale colors, in daylight.
    pub const CANDY: Self = Self {
        material: Material { roughness: 0.26, softness: 0.6, glow: 0.08, ..Material::BARE },
        answer: answer(Palette::Candy, 1.6, 0.0, 0.9, 0.1),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [1.02, 0.96, 0.89]),
                lamp(RIGHT, [0.3, 0.24, 0.4]),
                lamp(BEHIND, [0.5, 0.5, 0.6]),
            ],
            sky: [0.25, 0.27, 0.32],
            ground: [0.3, 0.2, 0.24],
            shadow: 0.75,
            strips: 0.4,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([236, 190, 208], 0.4),
            gradient: Gradient::Upright,
            ..Background::between([250, 214, 222], [150, 190, 236])
        },
        finish: Finish { vignette: 0.1, ..Finish::NOTHING },
        response: Response {
            flow: 0.2,
            timbre: 0.3,
            key: 1.0,
            light: 0.35,
            halo: 0.4,
            ..Self::PLAIN.response
        },
    };

    /// Young leaves in morning light.
    pub const MOSS: Self = Self {
        material: Material {
            roughness: 0.5,
            softness: 0.8,
            glow: 0.02,
            edge: [120, 150, 40],
            ..Material::BARE
        },
        answer: answer_from(0.35, Palette::Moss, 0.35, 0.0, 0.7, 0.0),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp([-0.7, 0.55, 0.5], [0.99, 0.88, 0.57]),
                lamp(RIGHT, [0.1, 0.2, 0.2]),
                lamp(BEHIND, [1.04, 0.99, 0.5]),
            ],
            sky: [0.2, 0.27, 0.26],
            ground: [0.1, 0.11, 0.04],
            shadow: 0.75,
            ..Lights::BARE
        },
        background: Background {
            gradient: Gradient::Upright,
            floor: floor([112, 128, 66], 0.6),
            ..Background::between([232, 226, 164], [128, 176, 160])
        },
        finish: Finish { bloom: 0.25, bloom_from: 0.8, vignette: 0.2, ..Finish::NOTHING },
        response: Response {
            flow: 0.0,
            timbre: 0.2,
            glow: 0.02,
            light: 0.4,
            halo: 0.28,
            rim: 0.9,
            ..Self::AURORA.response
        },
    };

    /// Two inks on paper.
    pub const PRINT: Self = Self {
        material: Material { roughness: 1.0, softness: 0.0, glow: 0.25, ..Material::BARE },
        answer: answer_from(0.3, Palette::Dusk, 0.35, 0.4, 0.0, 0.0),
        own_colors: false,
        lights: Lights {
            lights: [lamp(LEFT, [0.9; 3]), lamp(RIGHT, [0.05; 3]), lamp(BEHIND, [0.2; 3])],
            sky: [0.3; 3],
            ground: [0.1; 3],
            shadow: 0.85,
            ..Lights::BARE
        },
        background: Background::between([244, 238, 222], [236, 228, 208]),
        finish: Finish { grain: 0.05, ..Finish::NOTHING },
        response: Response { timbre: 0.15, light: 0.3, ..Self::PLAIN.response },
    };
}
