//! A shape's own colors: per vertex, or an image.

use chladni_harmonics::Body;
use chladni_mesh::TriMesh;
use chladni_view::{Device, Paint, Picture, Skin, Topology, VertexPaint, ViewError};

use super::{Warning, Watcher};

/// How the file says that the shape looks.
#[derive(Debug)]
pub enum OwnLook {
    /// A linear-light color for each of the N operator vertices.
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
    /// The look of `mesh`, which is called `name` and from which `body` was built; `None` where the file has
    /// none. Warns of parts that cannot be shown.
    pub fn of(name: &str, mesh: &TriMesh, body: &Body, watcher: &impl Watcher) -> Option<Self> {
        let textures = mesh.appearance.materials.iter().filter(|m| m.base_color_texture.is_some()).count();
        if let (Some(texture), Some(uvs)) = (mesh.base_color_texture(), mesh.triangle_uvs())
            && !texture.bytes.is_empty()
        {
            if textures > 1 {
                let message = format!("has {textures} textures; the view shows the first, exports keep all");
                watcher.warn(Warning::of(name, message));
            }
            match Picture::decode(&texture.bytes) {
                Ok(picture) => return Some(Self::Image { corner_uvs: uvs.concat(), picture }),
                Err(error) => {
                    let message = format!("the texture {} cannot be shown: {error}", texture.name);
                    watcher.warn(Warning::of(name, message));
                }
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

    /// The `triangles` of a shape of so many vertices on a device, with their places in its image where it has one.
    ///
    /// # Errors
    /// Triangles that do not fit the vertices or the device.
    pub fn topology(
        own: Option<&Self>,
        device: &Device,
        vertices: usize,
        triangles: &[[u32; 3]],
    ) -> Result<Topology, ViewError> {
        match own {
            Some(Self::Image { corner_uvs, .. }) => {
                Topology::with_uvs(device, vertices, triangles, corner_uvs)
            }
            _ => Topology::new(device, vertices, triangles),
        }
    }
}

/// A shape's own colors on the device that draws it.
#[derive(Clone, Debug)]
pub enum OwnPaint {
    /// One color a vertex.
    Colors(VertexPaint),
    /// An image.
    Image(Skin),
}

impl OwnPaint {
    /// Those of `look`.
    ///
    /// # Errors
    /// Colors that the device cannot hold.
    pub fn on(device: &Device, look: &OwnLook) -> Result<Self, ViewError> {
        Ok(match look {
            OwnLook::Colors(colors) => {
                let paint = VertexPaint::new(device, colors.len());
                paint.write_colors(device, colors)?;
                Self::Colors(paint)
            }
            OwnLook::Image { picture, .. } => {
                Self::Image(Skin::new(device, picture.width, picture.height, &picture.rgba)?)
            }
        })
    }

    /// As the renderer takes it.
    pub fn paint(&self) -> Paint<'_> {
        match self {
            Self::Colors(colors) => Paint::Colors(colors),
            Self::Image(skin) => Paint::Skin(skin),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Aside;
    use super::*;
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::{Material, Texture, samples};
    use chladni_task::Task;

    #[test]
    fn colors_go_to_their_vertices_and_a_damaged_texture_is_told() {
        let mut mesh = samples::icosphere(1);
        let n = mesh.positions.len();
        let body = Body::build(&mesh, &BasisSettings::new(4), &Task::new()).unwrap();
        let task = Task::new();
        let aside = Aside::new(&task);
        assert!(OwnLook::of("shape", &mesh, &body, &aside).is_none());

        let color = |v: usize| [v as f32 / n as f32, 0.5, 2.0, 1.0];
        mesh.appearance.colors = Some((0..n).map(color).collect());
        let Some(OwnLook::Colors(bytes)) = OwnLook::of("shape", &mesh, &body, &aside) else { panic!() };
        for (v, operator) in body.operator_vertex.iter().enumerate() {
            let expected = [(255.0 * v as f32 / n as f32).round() as u8, 128, 255, 255];
            assert_eq!(bytes[operator.unwrap() as usize], expected);
        }

        let texture = Texture { name: "skin.png".into(), bytes: (*b"no picture").into() };
        let corners = vec![0; 3 * mesh.triangles.len()];
        mesh.appearance.uvs = Some(chladni_mesh::CornerUvs { points: vec![[0.5, 0.5]], corners });
        mesh.appearance.materials =
            vec![Material { base_color_texture: Some(texture), ..Material::named("skin") }];
        assert!(matches!(OwnLook::of("shape", &mesh, &body, &aside), Some(OwnLook::Colors(_))));
        let warnings = aside.warnings();
        assert!(warnings.len() == 1 && warnings[0].to_string().contains("skin.png"), "{warnings:?}");
    }
}
