//! One named number per vertex: how masks are read and written.

use crate::appearance::{linear_from_srgb, srgb_from_linear};
use crate::{Format, TriMesh};

/// Names of a color's four channels.
pub const COLOR_CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];

/// Whether colors in files of this format are in linear light; the others are encoded as sRGB.
fn is_linear(format: Format) -> bool {
    matches!(format, Format::Gltf | Format::Glb)
}

impl TriMesh {
    /// The names that [`channel`](Self::channel) knows.
    pub fn channels(&self) -> impl Iterator<Item = &str> {
        let colors = self.appearance.colors.iter().flat_map(|_| COLOR_CHANNELS);
        self.appearance.attributes.iter().map(|attribute| &*attribute.name).chain(colors)
    }

    /// A number of each of the n vertices: the attribute called `name`, or that channel of the colors, in [0, 1] and
    /// encoded as in a file of this `format`, so that half of an 8-bit color is a half. `None` where there is neither.
    pub fn channel(&self, name: &str, format: Format) -> Option<Vec<f64>> {
        if let Some(attribute) = self.appearance.attributes.iter().find(|attribute| attribute.name == name) {
            return Some(attribute.values.clone());
        }
        let channel = COLOR_CHANNELS.iter().position(|channel| *channel == name)?;
        let encoded = |c: f64| if channel == 3 || is_linear(format) { c } else { srgb_from_linear(c) };
        let colors = self.appearance.colors.as_ref()?;
        Some(colors.iter().map(|color| encoded(f64::from(color[channel]))).collect())
    }

    /// Colors every vertex gray, so that [`channel`](Self::channel) gives `values` back: one for each vertex, in [0, 1].
    /// Every format keeps these colors, also beside textures.
    pub fn set_gray(&mut self, values: &[f64], format: Format) {
        let gray = |x: &f64| if is_linear(format) { *x } else { linear_from_srgb(*x) } as f32;
        self.appearance.colors = Some(values.iter().map(gray).map(|gray| [gray, gray, gray, 1.0]).collect());
        self.appearance.colors_tint = true;
    }
}

#[cfg(test)]
mod tests {
    use crate::{Attribute, Format, read_mesh, samples::icosphere, write_mesh};

    #[test]
    fn a_gray_mesh_gives_its_numbers_back_from_every_format_with_colors() {
        let mut mesh = icosphere(1);
        let values: Vec<f64> = (0..mesh.positions.len()).map(|v| f64::from(v as u8 % 11) / 10.0).collect();
        for (format, off) in [(Format::Ply, 0.5 / 255.0 + 1e-6), (Format::Glb, 1e-7), (Format::Obj, 1e-6)] {
            mesh.set_gray(&values, format);
            let back = read_mesh(&write_mesh(&mesh, format).unwrap(), format).unwrap().mesh;
            for name in ["red", "green", "blue"] {
                let found = back.channel(name, format).unwrap();
                assert!(found.iter().zip(&values).all(|(a, b)| (a - b).abs() <= off), "{format} {name}");
            }
            assert!(back.channel("alpha", format).unwrap().iter().all(|a| *a == 1.0));
            assert_eq!(back.channel("weight", format), None);
        }
    }

    #[test]
    fn a_ply_keeps_its_numbers_by_name_and_an_8_bit_color_is_a_share_of_255() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                    property float nx\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float weight\n\
                    property list uchar int ring\nproperty int group\nelement face 1\nproperty list uchar int vertex_indices\n\
                    end_header\n0 0 0 1 51 0 0 0.25 1 7 2\n1 0 0 1 102 0 0 0.1 0 -3\n0 1 0 1 255 0 0 1 0 0\n3 0 1 2\n";
        let mesh = read_mesh(text.as_bytes(), Format::Ply).unwrap().mesh;
        assert_eq!(mesh.channels().collect::<Vec<_>>(), ["weight", "group", "red", "green", "blue", "alpha"]);
        assert_eq!(mesh.channel("weight", Format::Ply).unwrap(), [0.25, 0.1, 1.0]);
        let red = mesh.channel("red", Format::Ply).unwrap();
        assert!(red.iter().zip([0.2, 0.4, 1.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{red:?}");
        let back = read_mesh(&write_mesh(&mesh, Format::Ply).unwrap(), Format::Ply).unwrap().mesh;
        assert_eq!(back, mesh);
        let mut short = mesh.clone();
        short.appearance.attributes[0].values.pop();
        assert!(write_mesh(&short, Format::Ply).is_err());
        let mut named = mesh;
        named.appearance.attributes[0] = Attribute { name: "two words".into(), values: vec![0.0; 3] };
        assert!(write_mesh(&named, Format::Ply).is_err());
    }
}
