//! Where a material moves texture coordinates: the extension `KHR_texture_transform`.

use std::hash::{Hash, Hasher};

use crate::read::gltf_json::TextureInfo;

impl TextureInfo {
    /// The number of its set of texture coordinates.
    pub(super) fn set(&self) -> usize {
        let transform = self.extensions.as_ref().and_then(|extensions| extensions.transform.as_ref());
        transform.and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }
}

/// The rows of an affine map of the plane.
#[derive(Clone, Copy)]
pub(super) struct Affine([[f64; 3]; 2]);

impl Affine {
    /// That of `texture`, if it has one.
    pub fn of(texture: &TextureInfo) -> Option<Self> {
        let transform = texture.extensions.as_ref()?.transform.as_ref()?;
        let ([u, v], [along_u, along_v]) = (transform.offset, transform.scale);
        // Counterclockwise, where v runs downward.
        let (sin, cos) = transform.rotation.sin_cos();
        Some(Self([[cos * along_u, sin * along_v, u], [-sin * along_u, cos * along_v, v]]))
    }

    pub fn of_point(self, [u, v]: [f64; 2]) -> [f64; 2] {
        self.0.map(|[along_u, along_v, offset]| along_u * u + along_v * v + offset)
    }

    fn bits(&self) -> [[u64; 3]; 2] {
        self.0.map(|row| row.map(f64::to_bits))
    }
}

/// Maps are the same where all their numbers are, bit for bit.
impl PartialEq for Affine {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for Affine {}

impl Hash for Affine {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.bits().hash(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the extension: the lower left quarter of the picture, turned clockwise by 90°.
    #[test]
    fn a_quarter_of_a_picture_is_turned() {
        let texture = r#"{"index": 0, "extensions": {"KHR_texture_transform":
            {"offset": [0, 1], "rotation": 1.57079632679, "scale": [0.5, 0.5], "texCoord": 3}}}"#;
        let texture: TextureInfo = serde_json::from_str(texture).unwrap();
        let transform = Affine::of(&texture).unwrap();
        for (from, to) in [([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [0.0, 0.5]), ([1.0, 1.0], [0.5, 0.5])] {
            let moved = transform.of_point(from);
            assert!((0..2).all(|i| (moved[i] - to[i]).abs() < 1e-9), "{from:?} to {moved:?}");
        }
        assert_eq!(texture.set(), 3);
        let plain: TextureInfo = serde_json::from_str(r#"{"index": 0, "extensions": {}}"#).unwrap();
        assert!(Affine::of(&plain).is_none() && plain.set() == 0);
    }
}
