//! Looks under lamps: metal, velvet, old film.

use super::*;

impl Look {
    /// Liquid metal that mirrors a studio of bright lines.
    pub const CHROME: Self = Self {
        material: Material { color: [232, 236, 244], roughness: 0.1, metal: 1.0, ..Material::BARE },
        lights: Lights {
            lights: [
                lamp(LEFT, [0.75, 0.72, 0.7]),
                lamp(RIGHT, [0.15, 0.3, 0.8]),
                lamp(BEHIND, [1.1, 0.45, 0.2]),
            ],
            sky: [0.1, 0.14, 0.22],
            ground: [0.03, 0.02, 0.03],
            shadow: 0.4,
            horizon: [0.9, 0.42, 0.25],
            strips: 0.8,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([30, 34, 44], 0.85),
            ..Background::between([58, 66, 84], [10, 11, 16])
        },
        finish: Finish { bloom: 0.5, bloom_from: 0.72, vignette: 0.4, ..Finish::NOTHING },
        response: Response { light: 0.6, halo: 0.8, rim: 0.9, ..Self::PLAIN.response },
        ..Self::PLAIN
    };

    /// Gold that melts, on dark red.
    pub const GOLD: Self = Self {
        material: Material { roughness: 0.22, metal: 1.0, glow: 0.03, ..Material::BARE },
        answer: answer_from(0.62, Palette::Gold, 0.1, 0.0, 0.35, 0.1),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.9, 0.78, 0.6]),
                lamp(RIGHT, [0.7, 0.2, 0.12]),
                lamp(BEHIND, [0.8, 0.45, 0.2]),
            ],
            sky: [0.16, 0.12, 0.09],
            ground: [0.14, 0.025, 0.02],
            shadow: 0.5,
            horizon: [0.8, 0.3, 0.12],
            strips: 0.6,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([56, 14, 14], 0.8),
            ..Background::between([92, 16, 18], [18, 3, 6])
        },
        finish: Finish { bloom: 0.5, bloom_from: 0.68, vignette: 0.4, ..Finish::NOTHING },
        response: Response {
            timbre: 0.1,
            sides: 0.0,
            flow: 0.0,
            glow: 0.04,
            light: 0.45,
            ..Self::AURORA.response
        },
    };

    /// Red velvet before a theatre's lamps.
    pub const VELVET: Self = Self {
        material: Material { roughness: 0.9, softness: 0.3, edge: [255, 92, 84], ..Material::BARE },
        answer: answer_from(0.35, Palette::Ember, 0.0, 0.0, 0.18, 0.0),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(ABOVE, [2.7, 2.0, 1.6]),
                lamp(RIGHT, [0.38, 0.09, 0.38]),
                lamp(BEHIND, [2.5, 1.25, 1.0]),
            ],
            sky: [0.1, 0.05, 0.06],
            ground: [0.05, 0.01, 0.02],
            shadow: 0.8,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([70, 30, 22], 0.85),
            ..Background::between([58, 12, 30], [10, 3, 8])
        },
        finish: Finish { bloom: 0.4, bloom_from: 0.6, vignette: 0.45, ..Finish::NOTHING },
        response: Response { timbre: 0.08, light: 0.6, halo: 0.7, rim: 1.2, ..Self::PLAIN.response },
    };

    /// Old film: one hard light, deep shadow, grain.
    pub const NOIR: Self = Self {
        material: Material { color: [176, 176, 176], roughness: 0.36, softness: 0.1, ..Material::BARE },
        lights: Lights {
            lights: [
                lamp([-0.92, 0.5, 0.1], [1.9, 1.9, 1.9]),
                lamp(RIGHT, [0.015; 3]),
                lamp([0.9, 0.3, -0.55], [1.3, 1.3, 1.3]),
            ],
            sky: [0.03; 3],
            ground: [0.01; 3],
            shadow: 0.95,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([58, 58, 58], 0.9),
            ..Background::between([74, 74, 74], [6, 6, 6])
        },
        finish: Finish { bloom: 0.35, bloom_from: 0.75, vignette: 0.55, grain: 0.035, ..Finish::NOTHING },
        response: Response { light: 0.45, halo: 0.7, rim: 0.8, ..Self::PLAIN.response },
        ..Self::PLAIN
    };
}
