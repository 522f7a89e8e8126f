//! The colours that a shape brings along: per vertex, or an image.

use chladni_harmonics::Body;
use chladni_mesh::TriMesh;
use chladni_view::Picture;

/// How the file says that the shape looks.
#[derive(Debug)]
pub enum OwnLook {
    /// A linear-light colour for each of the N operator vertices.
    Colors(Vec<[u8; 4]>),
    /// An image, and where its corners lie on each triangle's.
    Image {
        /// Three a triangle, v upward.
        corner_uvs: Vec<[f32; 2]>,
        /// The pixels.
        picture: Picture,
    },
}

impl OwnLook {
    /// The look of `mesh`, from which `body` was built; `None` where the file has none. Adds to
    /// `warnings` what cannot be shown.
    pub fn of(mesh: &TriMesh, body: &Body, warnings: &mut Vec<String>) -> Option<Self> {
        let textures = mesh.appearance.materials.iter().filter(|m| m.base_color_texture.is_some()).count();
        if let (Some(texture), Some(uvs)) = (mesh.base_color_texture(), mesh.triangle_uvs())
            && !texture.bytes.is_empty()
        {
            if textures > 1 {
                warnings.push(format!(
                    "The shape has {textures} textures; the view shows the first, exports keep all."
                ));
            }
            match Picture::decode(&texture.bytes) {
                Ok(picture) => return Some(Self::Image { corner_uvs: uvs.concat(), picture }),
                Err(error) => warnings.push(format!("The texture {} cannot be shown: {error}", texture.name)),
            }
        }
        let colors = mesh.appearance.colors.as_ref()?;
        let mut bytes = vec![[255; 4]; body.positions.len()];
        for (color, vertex) in colors.iter().zip(&body.operator_vertex) {
            if let Some(at) = vertex.and_then(|vertex| bytes.get_mut(vertex as usize)) {
                *at = color.map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8);
            }
        }
        Some(Self::Colors(bytes))
    }
}
