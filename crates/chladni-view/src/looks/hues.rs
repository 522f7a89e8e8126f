//! Looks whose colors run along the shape, and around or there and back.

use super::*;

impl Look {
    /// Lines of light at equal heights of the shape's own wave, as on a map.
    pub const CONTOUR: Self = Self {
        material: Material { roughness: 0.35, glow: 0.9, edge: [10, 60, 110], ..Material::BARE },
        answer: answer(Palette::Contour, 7.0, 0.0, 1.5, 0.4),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.25, 0.5, 0.6]),
                lamp(RIGHT, [0.4, 0.1, 0.5]),
                lamp(BEHIND, [0.3, 0.5, 0.9]),
            ],
            sky: [0.05, 0.07, 0.1],
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([6, 44, 78], [3, 6, 12]),
        finish: Finish {
            bloom: 1.1,
            bloom_from: 0.4,
            vignette: 0.3,
            trail_secs: 0.15,
            trail_growth: 0.15,
            ..Finish::NOTHING
        },
        response: Response { flow: 0.5, timbre: 0.5, sides: 0.0, glow: 0.5, ..Self::AURORA.response },
    };

    /// All hues, in bands that follow the shape and wander with the beat.
    pub const PRISM: Self = Self {
        material: Material {
            roughness: 0.3,
            softness: 0.35,
            glow: 0.1,
            edge: [60, 60, 90],
            ..Material::BARE
        },
        answer: answer(Palette::Prism, 2.4, 0.0, 0.6, 0.12),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.9, 0.9, 0.9]),
                lamp(RIGHT, [0.25, 0.25, 0.35]),
                lamp(BEHIND, [0.7, 0.7, 0.8]),
            ],
            sky: [0.12, 0.12, 0.15],
            ground: [0.06, 0.05, 0.07],
            shadow: 0.75,
            strips: 0.5,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([54, 54, 74], [8, 8, 11]),
        finish: Finish { bloom: 0.4, bloom_from: 0.62, vignette: 0.35, ..Finish::NOTHING },
        response: Response { flow: 0.25, timbre: 0.2, key: 2.0, saturation: 0.4, ..Self::AURORA.response },
    };

    /// Evening: indigo where it sinks, gold where it rises, and light that drifts apart.
    pub const DUSK: Self = Self {
        material: Material {
            roughness: 0.4,
            softness: 0.6,
            glow: 0.16,
            edge: [150, 40, 120],
            ..Material::BARE
        },
        answer: answer_from(0.28, Palette::Dusk, 0.3, 0.35, 0.0, 0.3),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.95, 0.55, 0.3]),
                lamp(RIGHT, [0.2, 0.15, 0.6]),
                lamp(BEHIND, [1.2, 0.4, 0.5]),
            ],
            sky: [0.14, 0.08, 0.2],
            ground: [0.1, 0.04, 0.08],
            shadow: 0.6,
            horizon: [0.5, 0.2, 0.15],
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            gradient: Gradient::Upright,
            ..Background::between([150, 56, 62], [22, 14, 52])
        },
        finish: Finish {
            bloom: 0.8,
            bloom_from: 0.58,
            vignette: 0.4,
            trail_secs: 0.2,
            trail_growth: 0.35,
            ..Finish::NOTHING
        },
        response: Response { flow: 0.03, timbre: 0.15, halo: 0.35, ..Self::AURORA.response },
    };

    /// Chladni's figures: resting places are white, and the two sides of them differ.
    pub const NODES: Self = Self {
        material: Material { roughness: 0.55, softness: 0.2, glow: 0.14, ..Material::BARE },
        answer: answer_from(0.5, Palette::Nodes, 0.0, 1.4, 0.0, 0.0),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [1.0, 1.0, 0.96]),
                lamp(RIGHT, [0.2, 0.22, 0.26]),
                lamp(BEHIND, [0.6, 0.6, 0.66]),
            ],
            sky: [0.2, 0.21, 0.23],
            ground: [0.08, 0.07, 0.08],
            shadow: 0.7,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([40, 38, 46], 0.7),
            ..Background::between([52, 48, 60], [16, 14, 20])
        },
        finish: Finish { bloom: 0.25, bloom_from: 0.7, vignette: 0.3, ..Finish::NOTHING },
        response: Response { light: 0.3, halo: 0.4, rim: 0.6, ..Self::PLAIN.response },
    };
}
