//! Materials, lights and backgrounds: a small studio.

use std::sync::LazyLock;

/// Linear light of an sRGB-encoded channel, both in [0, 1] (IEC 61966-2-1).
pub(crate) fn decoded(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`decoded`].
pub(crate) fn encoded(c: f32) -> f32 {
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// A linear-light RGB color of an sRGB one, each channel in [0, 1].
pub(crate) fn linear(color: [u8; 3]) -> [f32; 3] {
    color.map(|c| decoded(f32::from(c) / 255.0))
}

/// Relative luminance of an sRGB color, in [0, 1].
pub(crate) fn luminance(color: [u8; 3]) -> f32 {
    brightness(linear(color))
}

/// Relative luminance of a linear-light color (WCAG 2.2).
pub(crate) fn brightness([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Linear light of each of the 256 steps of an sRGB channel.
pub(crate) static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| decoded(i as f32 / 255.0)));

/// Eight bits a channel, RGB as sRGB, of a linear-light RGBA color; channels outside [0, 1] are clipped.
pub fn srgb_bytes([r, g, b, alpha]: [f32; 4]) -> [u8; 4] {
    let byte = |c: f32| (c * 255.0).round() as u8;
    let [r, g, b] = [r, g, b].map(|c| byte(encoded(c.clamp(0.0, 1.0))));
    [r, g, b, byte(alpha.clamp(0.0, 1.0))]
}

/// How a surface answers to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Own color, sRGB.
    pub color: [u8; 3],
    /// 0 is a mirror, 1 is chalk.
    pub roughness: f32,
    /// Share of metal: colored reflections and no diffuse light, in [0, 1].
    pub metal: f32,
    /// How far light bleeds around the terminator (wax, skin, porcelain), in [0, 1].
    pub softness: f32,
    /// Colors that turn with the angle of view (mother-of-pearl), in [0, 1].
    pub iridescence: f32,
    /// Share of its own color that shines without any light, at least 0.
    pub glow: f32,
    /// The light where the surface turns away from the viewer (velvet, deep-sea skin), sRGB; black is none.
    pub edge: [u8; 3],
}

impl Default for Material {
    fn default() -> Self {
        Self::CLAY
    }
}

impl Material {
    /// Half-matte gray, to be changed.
    pub(crate) const BARE: Self = Self {
        color: [128; 3],
        roughness: 0.5,
        metal: 0.0,
        softness: 0.0,
        iridescence: 0.0,
        glow: 0.0,
        edge: [0; 3],
    };
    /// Warm modeling clay: every form readable.
    pub const CLAY: Self = Self { color: [201, 172, 150], roughness: 0.62, softness: 0.25, ..Self::BARE };
    /// Glazed white porcelain.
    pub const PORCELAIN: Self =
        Self { color: [224, 221, 215], roughness: 0.24, softness: 0.45, ..Self::BARE };
    /// Cast bronze.
    pub const BRONZE: Self = Self { color: [201, 146, 96], roughness: 0.34, metal: 1.0, ..Self::BARE };
    /// Mother-of-pearl.
    pub const PEARL: Self = Self {
        color: [226, 222, 226],
        roughness: 0.3,
        metal: 0.15,
        softness: 0.35,
        iridescence: 0.75,
        ..Self::BARE
    };
    /// Matte dark rubber: the rim light draws it.
    pub const DARK: Self = Self { color: [52, 55, 62], roughness: 0.55, softness: 0.1, ..Self::BARE };
    /// Names and presets, for menus and the command line.
    pub const PRESETS: [(&'static str, Self); 5] = [
        ("clay", Self::CLAY),
        ("porcelain", Self::PORCELAIN),
        ("bronze", Self::BRONZE),
        ("pearl", Self::PEARL),
        ("dark", Self::DARK),
    ];

    /// The preset called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::PRESETS.iter().find(|(known, _)| *known == name).map(|(_, material)| *material)
    }
}

/// A distant light. Directions are the viewer's: x right, y up, z towards the viewer, so that
/// the light stays put while the shape turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Towards the light; any length but zero.
    pub direction: [f32; 3],
    /// Linear-light RGB; 1 lights a white wall facing it fully.
    pub color: [f32; 3],
}

/// Three lights, and light from all sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lights {
    /// Key, fill and rim.
    pub lights: [Light; 3],
    /// Linear-light RGB from above.
    pub sky: [f32; 3],
    /// Linear-light RGB from below.
    pub ground: [f32; 3],
    /// Multiplies all light: in the picture's left and right, one passing into the other across its middle.
    pub exposure: [f32; 2],
    /// How dark the key light's shadows are, in [0, 1]; 0 draws none and saves a pass.
    pub shadow: f32,
    /// Linear-light RGB of a bright line all around at the height of the eye, which surfaces mirror.
    pub horizon: [f32; 3],
    /// Two upright softboxes to the left and right, which surfaces mirror; 1 is as bright as a white wall.
    pub strips: f32,
    /// How light becomes the numbers of a picture.
    pub curve: Curve,
}

/// From linear light to the range of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// Khronos PBR Neutral (2024): colors below the shoulder stay true.
    #[default]
    Neutral,
    /// As film: more contrast, and bright colors turn to white (Narkowicz' fit of the ACES curve, 2015).
    Filmic,
}

impl Default for Lights {
    fn default() -> Self {
        Self::STUDIO
    }
}

impl Lights {
    /// One lamp from the upper left, to be changed.
    pub(crate) const BARE: Self = Self {
        lights: [
            Light { direction: [-0.55, 0.65, 0.62], color: [1.0; 3] },
            Light { direction: [0.85, 0.1, 0.5], color: [0.0; 3] },
            Light { direction: [0.45, 0.55, -0.75], color: [0.0; 3] },
        ],
        sky: [0.0; 3],
        ground: [0.0; 3],
        exposure: [1.0; 2],
        shadow: 0.0,
        horizon: [0.0; 3],
        strips: 0.0,
        curve: Curve::Neutral,
    };
    /// Neutral studio: a large key from the upper left, a cool fill, a rim from behind.
    pub const STUDIO: Self = Self {
        lights: [
            Light { direction: [-0.55, 0.65, 0.62], color: [1.08, 1.02, 0.94] },
            Light { direction: [0.85, 0.1, 0.5], color: [0.13, 0.16, 0.2] },
            Light { direction: [0.45, 0.55, -0.75], color: [0.6, 0.62, 0.66] },
        ],
        sky: [0.23, 0.25, 0.28],
        ground: [0.085, 0.075, 0.065],
        shadow: 0.8,
        ..Self::BARE
    };
    /// An overcast day: little shadow, for reading colors and maps.
    pub const SOFT: Self = Self {
        lights: [
            Light { direction: [-0.3, 0.7, 0.65], color: [0.5, 0.5, 0.5] },
            Light { direction: [0.6, 0.2, 0.75], color: [0.22, 0.22, 0.23] },
            Light { direction: [0.0, 0.6, -0.8], color: [0.2, 0.2, 0.2] },
        ],
        sky: [0.48, 0.49, 0.51],
        ground: [0.27, 0.265, 0.26],
        ..Self::BARE
    };
    /// One hard key from the side, deep shadow, strong rim.
    pub const DRAMATIC: Self = Self {
        lights: [
            Light { direction: [-0.9, 0.45, 0.3], color: [1.25, 1.15, 1.0] },
            Light { direction: [0.8, -0.2, 0.4], color: [0.03, 0.04, 0.06] },
            Light { direction: [0.7, 0.35, -0.65], color: [0.75, 0.85, 1.05] },
        ],
        sky: [0.08, 0.09, 0.11],
        ground: [0.03, 0.03, 0.03],
        shadow: 0.9,
        ..Self::BARE
    };
    /// Two colors from either side, for the stage.
    pub const STAGE: Self = Self {
        lights: [
            Light { direction: [-0.8, 0.4, 0.42], color: [1.05, 0.62, 0.38] },
            Light { direction: [0.85, 0.15, 0.35], color: [0.28, 0.42, 0.95] },
            Light { direction: [0.0, 0.7, -0.7], color: [0.75, 0.6, 0.85] },
        ],
        sky: [0.13, 0.12, 0.17],
        ground: [0.06, 0.05, 0.08],
        shadow: 0.7,
        ..Self::BARE
    };
    /// Names and presets, for menus and the command line.
    pub const PRESETS: [(&'static str, Self); 4] = [
        ("studio", Self::STUDIO),
        ("soft", Self::SOFT),
        ("dramatic", Self::DRAMATIC),
        ("stage", Self::STAGE),
    ];

    /// The preset called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::PRESETS.iter().find(|(known, _)| *known == name).map(|(_, lights)| *lights)
    }

    /// These lights turned by `yaw_rad` about the viewer's vertical.
    pub fn turned(mut self, yaw_rad: f32) -> Self {
        let (sin, cos) = yaw_rad.sin_cos();
        for light in &mut self.lights {
            let [x, y, z] = light.direction;
            light.direction = [x * cos + z * sin, y, z * cos - x * sin];
        }
        self
    }
}

/// The background, sRGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// Color in the middle of the picture.
    pub center: [u8; 3],
    /// Color in the corners.
    pub corner: [u8; 3],
    /// How much of the middle's color there is, in [0, 1], in the picture's left and right.
    pub strength: [f32; 2],
    /// 1 is opaque; 0 leaves only the shape, for pictures with alpha.
    pub opacity: f32,
    /// Which way the colors run.
    pub gradient: Gradient,
    /// The floor below the shape, seen in perspective only.
    pub floor: Option<Floor>,
}

/// Which way a background's two colors run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gradient {
    /// From the middle to the corners.
    #[default]
    Round,
    /// From the bottom (the middle's color) to the top (the corners').
    Upright,
    /// A glow behind the shape, gone well before the edges.
    Halo,
}

/// A floor that fades into the background, with a soft shadow under the shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Its color in the light, sRGB.
    pub color: [u8; 3],
    /// How dark the shadow is, in [0, 1].
    pub shadow: f32,
    /// The point of the scene below the shape's middle.
    pub at: [f32; 3],
    /// Half the shape's width; the shadow is as large.
    pub radius: f32,
}

impl Default for Background {
    fn default() -> Self {
        Self::PAPER
    }
}

impl Background {
    /// Warm light gray.
    pub const PAPER: Self = Self::between([238, 236, 232], [203, 200, 195]);
    /// Dark blue-gray, as a modeling program's viewport.
    pub const SLATE: Self = Self::between([64, 69, 78], [32, 35, 41]);
    /// Almost black, for the stage.
    pub const NIGHT: Self = Self::between([24, 23, 32], [6, 6, 10]);
    /// Plain white, for print.
    pub const WHITE: Self = Self::between([255; 3], [255; 3]);
    /// Nothing: the picture has alpha.
    pub const TRANSPARENT: Self = Self { opacity: 0.0, ..Self::between([0; 3], [0; 3]) };
    /// Names and presets, for menus and the command line.
    pub const PRESETS: [(&'static str, Self); 5] = [
        ("paper", Self::PAPER),
        ("slate", Self::SLATE),
        ("night", Self::NIGHT),
        ("white", Self::WHITE),
        ("transparent", Self::TRANSPARENT),
    ];

    /// The preset called `name`.
    pub fn named(name: &str) -> Option<Self> {
        Self::PRESETS.iter().find(|(known, _)| *known == name).map(|(_, background)| *background)
    }

    /// One color.
    pub fn plain(color: [u8; 3]) -> Self {
        Self::between(color, color)
    }

    /// Opaque, from the color of the middle to that of the corners.
    pub const fn between(center: [u8; 3], corner: [u8; 3]) -> Self {
        Self { center, corner, strength: [1.0; 2], opacity: 1.0, gradient: Gradient::Round, floor: None }
    }
}
