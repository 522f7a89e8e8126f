//! Looks that answer to how the shape vibrates: its speed, its phase, its bends, and where it stands still.

use super::*;

impl Look {
    /// Black steel from which speed strikes sparks: blows shine before they are seen to move anything.
    pub const SPARK: Self = Self {
        material: Material { roughness: 0.34, metal: 0.35, edge: [20, 50, 110], ..Material::BARE },
        answer: Some(Answer { travel: 0.15, haste: 1.5, spark: 0.6, ..answer_of(Palette::Abyss, 0.26) }),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [1.12, 1.28, 1.5]),
                lamp(RIGHT, [0.26, 0.32, 0.88]),
                lamp(BEHIND, [1.17, 0.65, 0.33]),
            ],
            sky: [0.15, 0.2, 0.3],
            ground: [0.08, 0.03, 0.02],
            shadow: 0.6,
            horizon: [0.16, 0.26, 0.42],
            strips: 0.35,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([34, 40, 62], [6, 7, 12]),
        finish: Finish {
            bloom: 1.0,
            bloom_from: 0.55,
            vignette: 0.4,
            trail_secs: 0.1,
            trail_growth: 0.1,
            ..Finish::NOTHING
        },
        response: Response { flow: 0.0, timbre: 0.1, sides: 0.0, glow: 0.0, ..Self::AURORA.response },
    };

    /// Opal: each place runs through all hues once in a vibration, and its neighbor beyond a still line is half a
    /// circle away.
    pub const OPAL: Self = Self {
        material: Material {
            roughness: 0.22,
            softness: 0.5,
            iridescence: 0.35,
            glow: 0.12,
            edge: [70, 70, 110],
            ..Material::BARE
        },
        answer: Some(Answer { span: 0.3, phase: 1.0, ..answer_of(Palette::Prism, 0.5) }),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.85, 0.84, 0.8]),
                lamp(RIGHT, [0.2, 0.24, 0.42]),
                lamp(BEHIND, [0.6, 0.65, 0.9]),
            ],
            sky: [0.14, 0.15, 0.2],
            ground: [0.07, 0.06, 0.09],
            shadow: 0.7,
            strips: 0.6,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([58, 62, 88], [10, 10, 18]),
        finish: Finish { bloom: 0.45, bloom_from: 0.66, vignette: 0.35, ..Finish::NOTHING },
        response: Response { key: 1.0, saturation: 0.5, glow: 0.1, ..lit_by(0.5, 0.85) },
    };

    /// Old bronze: green in its hollows, polished on its ridges.
    pub const PATINA: Self = Self {
        material: Material { roughness: 0.38, metal: 0.75, softness: 0.1, ..Material::BARE },
        answer: Some(Answer { crease: 0.36, travel: 0.14, ..answer_of(Palette::Patina, 0.4) }),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [1.25, 1.1, 0.9]),
                lamp(RIGHT, [0.16, 0.26, 0.28]),
                lamp(BEHIND, [0.9, 0.8, 0.6]),
            ],
            sky: [0.24, 0.27, 0.28],
            ground: [0.09, 0.075, 0.06],
            shadow: 0.7,
            horizon: [0.4, 0.36, 0.3],
            strips: 0.6,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            floor: floor([66, 62, 56], 0.8),
            ..Background::between([92, 98, 96], [24, 28, 30])
        },
        finish: Finish { bloom: 0.35, bloom_from: 0.72, vignette: 0.4, ..Finish::NOTHING },
        response: Response { rim: 0.8, ..lit_by(0.4, 0.5) },
    };

    /// Chladni's figures, drawn in light on night-blue glass: the lines along which nothing moves now.
    pub const FIGURES: Self = Self {
        material: Material {
            roughness: 0.2,
            softness: 0.3,
            glow: 0.05,
            edge: [30, 60, 130],
            ..Material::BARE
        },
        answer: Some(Answer {
            travel: 0.5,
            lines: NodalLines { color: [255, 236, 196], opacity: 0.95, width: 1.3 },
            ..answer_of(Palette::Abyss, 0.16)
        }),
        own_colors: false,
        lights: Lights {
            lights: [
                lamp(LEFT, [0.95, 1.04, 1.25]),
                lamp(RIGHT, [0.18, 0.22, 0.65]),
                lamp(BEHIND, [0.7, 1.05, 1.6]),
            ],
            sky: [0.15, 0.2, 0.32],
            ground: [0.05, 0.05, 0.13],
            shadow: 0.6,
            strips: 0.3,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([34, 48, 86], [6, 8, 18]),
        finish: Finish { bloom: 0.8, bloom_from: 0.62, vignette: 0.35, ..Finish::NOTHING },
        response: Response { timbre: 0.15, ..lit_by(0.4, 0.8) },
    };
}
