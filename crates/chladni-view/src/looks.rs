//! Looks by name: scenes whose material, palette, light, ground and finish were made for each other.

mod day;
mod hues;
mod lamps;
mod lens;
mod night;
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
        own_colors: false,
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
