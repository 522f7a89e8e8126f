//! Looks by name: scenes whose material, palette, light, ground and finish were made for each other.

mod lens;
mod vibration;

use crate::look::Response;
use crate::{
    Answer, Background, Curve, Finish, Floor, Gradient, Light, Lights, Look, Material, NodalLines, Palette,
};

const fn lamp(direction: [f32; 3], color: [f32; 3]) -> Light {
    Light { direction, color }
}

const LEFT: [f32; 3] = [-0.8, 0.5, 0.45];
const RIGHT: [f32; 3] = [0.85, 0.15, 0.35];
const ABOVE: [f32; 3] = [-0.2, 0.95, 0.3];
const BEHIND: [f32; 3] = [0.35, 0.55, -0.8];

/// A palette of full strength, to be changed.
const fn answer(palette: Palette, span: f32, swing: f32, travel: f32, glow: f32) -> Option<Answer> {
    answer_from(0.0, palette, span, swing, travel, glow)
}

/// As [`answer`], from another place of the palette.
const fn answer_from(
    offset: f32,
    palette: Palette,
    span: f32,
    swing: f32,
    travel: f32,
    glow: f32,
) -> Option<Answer> {
    Some(Answer { palette, offset, span, swing, travel, glow, ..Answer::MOVED })
}

/// A palette from `offset` on that nothing moves yet.
const fn answer_of(palette: Palette, offset: f32) -> Answer {
    Answer { palette, offset, travel: 0.0, ..Answer::MOVED }
}

/// Light and halo that answer to the level, and a rim to the beat.
const fn lit_by(light: f32, halo: f32) -> Response {
    Response { light, halo, rim: 0.6, ..Look::PLAIN.response }
}

/// A glow behind the shape.
const fn halo(center: [u8; 3], corner: [u8; 3]) -> Background {
    Background { gradient: Gradient::Halo, ..Background::between(center, corner) }
}

/// A floor that is put under the shape later.
const fn floor(color: [u8; 3], shadow: f32) -> Option<Floor> {
    Some(Floor { color, shadow, at: [0.0; 3], radius: 0.0 })
}

impl Look {
    /// Mother-of-pearl in two colors of light on black: no palette, no finish.
    pub const PLAIN: Self = Self {
        material: Material::PEARL,
        answer: None,
        lights: Lights::STAGE,
        background: Background::NIGHT,
        finish: Finish::NOTHING,
        response: Response {
            flow: 0.0,
            timbre: 0.0,
            sides: 0.0,
            key: 0.0,
            glow: 0.0,
            light: 0.0,
            halo: 0.0,
            saturation: 0.0,
            rim: 0.0,
        },
    };

    /// Northern lights: what moves turns from night blue to green and yellow, and glows.
    pub const AURORA: Self = Self {
        material: Material {
            roughness: 0.32,
            softness: 0.5,
            glow: 0.02,
            edge: [40, 90, 190],
            ..Material::BARE
        },
        answer: answer(Palette::Aurora, 0.4, 0.0, 0.55, 0.1),
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
        answer: answer(Palette::Ember, 0.1, 0.0, 0.8, 1.1),
        lights: Lights {
            lights: [
                lamp(LEFT, [0.5, 0.34, 0.26]),
                lamp([0.5, -0.8, 0.4], [0.7, 0.2, 0.04]),
                lamp(BEHIND, [1.3, 0.5, 0.15]),
            ],
            sky: [0.04, 0.035, 0.04],
            ground: [0.16, 0.05, 0.015],
            shadow: 0.7,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: halo([92, 30, 8], [9, 5, 5]),
        finish: Finish {
            bloom: 0.9,
            bloom_from: 0.55,
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
        answer: answer(Palette::Abyss, 0.15, 0.0, 0.6, 0.45),
        lights: Lights {
            lights: [
                lamp(ABOVE, [0.22, 0.5, 0.62]),
                lamp(RIGHT, [0.03, 0.1, 0.28]),
                lamp(BEHIND, [0.15, 0.6, 0.75]),
            ],
            sky: [0.05, 0.16, 0.22],
            ground: [0.0, 0.015, 0.05],
            shadow: 0.6,
            curve: Curve::Filmic,
            ..Lights::BARE
        },
        background: Background {
            gradient: Gradient::Upright,
            ..Background::between([1, 5, 20], [6, 62, 92])
        },
        finish: Finish { bloom: 1.0, bloom_from: 0.58, vignette: 0.45, ..Finish::NOTHING },
        response: Response { glow: 0.12, sides: 0.15, ..Self::AURORA.response },
    };

    /// Two signs of light on glossy black, and a trail of what was.
    pub const NEON: Self = Self {
        material: Material {
            roughness: 0.2,
            softness: 0.0,
            glow: 0.3,
            edge: [255, 30, 160],
            ..Material::BARE
        },
        answer: answer(Palette::Neon, 0.8, 0.0, 0.4, 0.25),
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

    /// Lines of light at equal heights of the shape's own wave, as on a map.
    pub const CONTOUR: Self = Self {
        material: Material { roughness: 0.35, glow: 0.9, edge: [10, 60, 110], ..Material::BARE },
        answer: answer(Palette::Contour, 7.0, 0.0, 1.5, 0.4),
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

    /// White porcelain by a window; movement blushes.
    pub const PORCELAIN: Self = Self {
        material: Material { roughness: 0.18, softness: 0.4, ..Material::BARE },
        answer: answer_from(1.0, Palette::Orchid, 0.0, 0.0, 0.3, 0.0),
        lights: Lights {
            lights: [
                lamp(LEFT, [1.0, 0.95, 0.86]),
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
        response: Response { timbre: 0.0, light: 0.12, halo: 0.15, rim: 0.5, ..Self::PLAIN.response },
    };

    /// Sugar in all pale colors, in daylight.
    pub const CANDY: Self = Self {
        material: Material { roughness: 0.26, softness: 0.6, glow: 0.08, ..Material::BARE },
        answer: answer(Palette::Candy, 1.6, 0.0, 0.6, 0.1),
        lights: Lights {
            lights: [
                lamp(LEFT, [0.85, 0.8, 0.74]),
                lamp(RIGHT, [0.3, 0.24, 0.4]),
                lamp(BEHIND, [0.5, 0.5, 0.6]),
            ],
            sky: [0.36, 0.38, 0.46],
            ground: [0.3, 0.2, 0.24],
            shadow: 0.6,
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
            flow: 0.1,
            timbre: 0.15,
            key: 1.0,
            light: 0.12,
            halo: 0.15,
            ..Self::PLAIN.response
        },
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

    /// Chladni's figures: what stands still is white, and the sides of it differ.
    pub const NODES: Self = Self {
        material: Material { roughness: 0.55, softness: 0.2, glow: 0.14, ..Material::BARE },
        answer: answer_from(0.5, Palette::Nodes, 0.0, 1.4, 0.0, 0.0),
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

    /// Young leaves in morning light.
    pub const MOSS: Self = Self {
        material: Material {
            roughness: 0.5,
            softness: 0.8,
            glow: 0.02,
            edge: [120, 150, 40],
            ..Material::BARE
        },
        answer: answer_from(0.35, Palette::Moss, 0.35, 0.0, 0.5, 0.0),
        lights: Lights {
            lights: [
                lamp([-0.7, 0.55, 0.5], [0.9, 0.8, 0.52]),
                lamp(RIGHT, [0.1, 0.2, 0.2]),
                lamp(BEHIND, [0.95, 0.9, 0.45]),
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
            light: 0.15,
            halo: 0.15,
            ..Self::AURORA.response
        },
    };

    /// Red velvet before a theatre's lamps.
    pub const VELVET: Self = Self {
        material: Material {
            color: [150, 10, 34],
            roughness: 0.9,
            softness: 0.3,
            edge: [255, 92, 84],
            ..Material::BARE
        },
        lights: Lights {
            lights: [
                lamp(ABOVE, [1.8, 1.35, 1.05]),
                lamp(RIGHT, [0.25, 0.06, 0.25]),
                lamp(BEHIND, [1.8, 0.9, 0.7]),
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
        response: Response { light: 0.6, halo: 0.6, rim: 1.2, ..Self::PLAIN.response },
        ..Self::PLAIN
    };

    /// Two inks on paper.
    pub const PRINT: Self = Self {
        material: Material { roughness: 1.0, softness: 0.0, glow: 0.25, ..Material::BARE },
        answer: answer_from(0.3, Palette::Dusk, 0.35, 0.3, 0.0, 0.0),
        lights: Lights {
            lights: [lamp(LEFT, [0.9; 3]), lamp(RIGHT, [0.05; 3]), lamp(BEHIND, [0.2; 3])],
            sky: [0.3; 3],
            ground: [0.1; 3],
            shadow: 0.85,
            ..Lights::BARE
        },
        background: Background::between([244, 238, 222], [236, 228, 208]),
        finish: Finish { grain: 0.05, ..Finish::NOTHING },
        response: Response { timbre: 0.1, ..Self::PLAIN.response },
    };

    /// Names and looks, for menus and the command line.
    pub const PRESETS: [(&'static str, Self); 22] = [
        ("aurora", Self::AURORA),
        ("ember", Self::EMBER),
        ("abyss", Self::ABYSS),
        ("neon", Self::NEON),
        ("contour", Self::CONTOUR),
        ("prism", Self::PRISM),
        ("dusk", Self::DUSK),
        ("nodes", Self::NODES),
        ("chrome", Self::CHROME),
        ("gold", Self::GOLD),
        ("velvet", Self::VELVET),
        ("noir", Self::NOIR),
        ("porcelain", Self::PORCELAIN),
        ("candy", Self::CANDY),
        ("moss", Self::MOSS),
        ("print", Self::PRINT),
        ("spark", Self::SPARK),
        ("opal", Self::OPAL),
        ("patina", Self::PATINA),
        ("figures", Self::FIGURES),
        ("dew", Self::DEW),
        ("plain", Self::PLAIN),
    ];
}
