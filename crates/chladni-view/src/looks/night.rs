//! Looks that shine in the dark.

use super::*;

impl Look {
    /// Northern lights: moving parts turn from night blue to green and yellow, and glow.
    pub const AURORA: Self = Self {
        material: Material {
            roughness: 0.32,
            softness: 0.5,
            glow: 0.02,
            edge: [40, 90, 190],
            ..Material::BARE
        },
        answer: answer(Palette::Aurora, 0.4, 0.0, 0.55, 0.1),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.75, 0.95, 1.1]),
                lamp(RIGHT, [0.75, 0.18, 0.7]),
                lamp(BEHIND, [0.35, 0.85, 1.3]),
            ],
            sky: [0.14, 0.2, 0.34],
            ground: [0.12, 0.03, 0.14],
            shadow: 0.7,
            horizon: [0.1, 0.3, 0.35],
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([15, 36, 80], [5, 6, 20]),
        finish: Finish { bloom: 0.7, bloom_from: 0.65, vignette: 0.35, ..Finish::NOTHING },
        response: Response {
            flow: 0.04,
            timbre: 0.2,
            sides: 0.1,
            key: 0.0,
            glow: 0.18,
            light: 0.6,
            halo: 0.9,
            saturation: 0.0,
            rim: 0.7,
        },
    };

    /// Coal under which embers glow wherever it moves.
    pub const EMBER: Self = Self {
        material: Material {
            roughness: 0.6,
            softness: 0.1,
            glow: 0.02,
            edge: [120, 24, 6],
            ..Material::BARE
        },
        answer: answer_from(0.15, Palette::Ember, 0.1, 0.0, 0.8, 0.6),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.8, 0.54, 0.42]),
                lamp([0.5, -0.8, 0.4], [1.12, 0.32, 0.06]),
                lamp(BEHIND, [1.56, 0.6, 0.18]),
            ],
            sky: [0.06, 0.05, 0.06],
            ground: [0.16, 0.05, 0.015],
            shadow: 0.7,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([92, 30, 8], [9, 5, 5]),
        finish: Finish {
            bloom: 0.9,
            bloom_from: 0.75,
            vignette: 0.4,
            trail_secs: 0.12,
            trail_growth: 0.12,
            ..Finish::NOTHING
        },
        response: Response {
            glow: 0.12,
            light: 0.6,
            halo: 0.95,
            timbre: 0.15,
            rim: 1.0,
            ..Self::AURORA.response
        },
    };

    /// The deep sea: dark skin whose edges and movements shine by themselves.
    pub const ABYSS: Self = Self {
        material: Material {
            roughness: 0.24,
            softness: 0.7,
            glow: 0.03,
            edge: [40, 190, 220],
            ..Material::BARE
        },
        answer: answer_from(0.18, Palette::Abyss, 0.15, 0.0, 0.6, 0.2),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(ABOVE, [0.3, 0.68, 0.84]),
                lamp(RIGHT, [0.04, 0.13, 0.38]),
                lamp(BEHIND, [0.17, 0.68, 0.85]),
            ],
            sky: [0.07, 0.21, 0.29],
            ground: [0.0, 0.015, 0.05],
            shadow: 0.6,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            gradient: Gradient::Upright,
            ..Background::between([1, 5, 20], [6, 62, 92])
        },
        finish: Finish { bloom: 1.0, bloom_from: 0.75, vignette: 0.45, ..Finish::NOTHING },
        response: Response { glow: 0.12, sides: 0.15, light: 0.5, ..Self::AURORA.response },
    };

    /// Two signs of light on glossy black, and their trails.
    pub const NEON: Self = Self {
        material: Material {
            roughness: 0.2,
            softness: 0.0,
            glow: 0.3,
            edge: [255, 30, 160],
            ..Material::BARE
        },
        answer: answer(Palette::Neon, 0.8, 0.0, 0.4, 0.25),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.05, 0.65, 0.95]),
                lamp(RIGHT, [1.1, 0.08, 0.7]),
                lamp(BEHIND, [0.6, 0.2, 1.3]),
            ],
            sky: [0.03, 0.03, 0.1],
            ground: [0.1, 0.0, 0.08],
            shadow: 0.5,
            horizon: [0.9, 0.1, 0.7],
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([84, 10, 110], [6, 3, 16]),
        finish: Finish {
            bloom: 0.8,
            bloom_from: 0.55,
            vignette: 0.35,
            trail_secs: 0.22,
            trail_growth: 0.25,
            ..Finish::NOTHING
        },
        response: Response { flow: 0.125, glow: 0.2, ..Self::AURORA.response },
    };
}
