//! How a show looks, and from where it is seen.

use serde::{Deserialize, Serialize};

/// The look of a dance, by names: a whole scene, and replacements for its parts. An empty name keeps the scene's own
/// part; an empty `look` is the plain scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Looks {
    /// The whole scene.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub look: String,
    /// The colors of the movement; `own` are those that the shape brings.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub palette: String,
    /// The material of the shapes.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub material: String,
    /// The lights on them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub lights: String,
    /// The background.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub background: String,
    /// The file of a picture that stands behind them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub picture: String,
    /// The file of a panorama that shines on them.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub panorama: String,
    /// Depth of field: softness out of focus, in percent of the most; `None` is the scene's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blur_percent: Option<u8>,
    /// The effects on the finished picture that are left out of any scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
}

/// The viewpoint, before the beat turns the shape. The default shows the whole shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Viewpoint {
    /// About the vertical; positive moves the viewer to the right.
    pub yaw_rad: f32,
    /// Above the horizon.
    pub pitch_rad: f32,
    /// The distance, in multiples of the smallest one that shows the whole shape.
    pub distance: f32,
    /// How far the picture is shifted to the right and downward, in heights of a cell.
    pub shift: [f32; 2],
}

impl Viewpoint {
    /// Whether it is finite and within bounds, as that of a file may not be.
    pub(super) fn is_sound(&self) -> bool {
        let [right, down] = self.shift;
        [self.yaw_rad, self.pitch_rad, right, down].iter().all(|x| x.abs() <= 1e3)
            && (1e-3..=1e3).contains(&self.distance)
    }
}

impl Default for Viewpoint {
    fn default() -> Self {
        Self { yaw_rad: 0.0, pitch_rad: 0.14, distance: 1.0, shift: [0.0; 2] }
    }
}
