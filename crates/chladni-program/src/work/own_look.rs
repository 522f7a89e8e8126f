//! A shape's own colors: per vertex, or an image.

mod atlas;
mod materials;

use chladni_harmonics::Body;
use chladni_mesh::surface::places;
use chladni_mesh::{Proxy, TriMesh, linear_from_srgb};
use chladni_view::{Device, Paint, Picture, Skin, Topology, VertexPaint, ViewError, srgb_bytes};

use self::materials::{picture_of_materials, vertex_colors};
use super::{Subject, Watcher};

/// How the file says that the shape looks.
#[derive(Debug)]
pub enum OwnLook {
    /// An sRGB color for each of the N operator vertices.
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
        if let Some((uvs, picture)) = picture_of_materials(name, mesh, watcher) {
            return Some(Self::Image { corner_uvs: uvs.concat(), picture });
        }
        Some(Self::at_vertices(&vertex_colors(mesh)?, body))
    }

    /// The same of a shape as it is worked on. A proxy has no materials: its vertices have the colors that the whole
    /// shape's has there.
    pub fn of_subject(name: &str, subject: &Subject, body: &Body, watcher: &impl Watcher) -> Option<Self> {
        match texture_colors(name, subject, watcher) {
            Some(colors) => Some(Self::at_vertices(&colors, body)),
            None => Self::of(name, &subject.mesh, body, watcher),
        }
    }

    /// Its linear-light colors, as a picture's shape takes them; `None` for an image.
    pub fn colors(&self) -> Option<Vec<[f32; 4]>> {
        match self {
            Self::Colors(bytes) => Some(bytes.iter().copied().map(linear).collect()),
            Self::Image { .. } => None,
        }
    }

    /// Its image and where corners lie on that, as a picture's shape takes them; `None` for colors.
    pub fn image(&self) -> Option<(&Picture, &[[f32; 2]])> {
        match self {
            Self::Colors(_) => None,
            Self::Image { corner_uvs, picture } => Some((picture, &corner_uvs[..])),
        }
    }

    /// The `colors` of a file's vertices.
    fn at_vertices(colors: &[[f32; 4]], body: &Body) -> Self {
        let bytes = colors.iter().map(|color| srgb_bytes(*color));
        Self::Colors(body.on_operator_vertices(bytes, [255; 4]))
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

/// For each vertex of a proxy the linear-light color that the materials of the whole shape, which is called `name`, have
/// there; `None` without a proxy or such materials. Warns of what cannot be shown.
pub fn texture_colors(name: &str, subject: &Subject, watcher: &impl Watcher) -> Option<Vec<[f32; 4]>> {
    let proxy = subject.proxy.as_ref()?;
    let whole = proxy.whole();
    if let Some((uvs, picture)) = picture_of_materials(name, whole, watcher) {
        return Some(sampled(proxy, &uvs, &picture));
    }
    // The proxy has colors that do not tint itself.
    if !whole.appearance.colors_tint {
        return None;
    }
    let colors = vertex_colors(whole)?;
    proxy.whole_vertex().iter().map(|vertex| colors.get(*vertex as usize).copied()).collect()
}

/// The linear-light color of `picture` at each vertex of `proxy`; `uvs` are those of the whole shape's triangles.
fn sampled(proxy: &Proxy, uvs: &[[[f32; 2]; 3]], picture: &Picture) -> Vec<[f32; 4]> {
    let whole = proxy.whole();
    // By place: where several vertices coincide, the one that the proxy kept may be in no triangle and so have no texture
    // coordinates of its own.
    let place = places(&whole.positions);
    let mut uv_of = vec![[0.0; 2]; place.len()];
    for (vertex, uv) in whole.triangles.as_flattened().iter().zip(uvs.as_flattened()) {
        uv_of[place[*vertex as usize] as usize] = *uv;
    }
    let at = |vertex: &u32| linear(pixel_at(picture, uv_of[place[*vertex as usize] as usize]));
    proxy.whole_vertex().iter().map(at).collect()
}

/// The pixel at `(u, v)`, v upward; beyond its edges the picture is repeated.
fn pixel_at(picture: &Picture, uv: [f32; 2]) -> [u8; 4] {
    let [u, v] = uv.map(|x| if (0.0..=1.0).contains(&x) { x } else { x.rem_euclid(1.0) });
    let index = |share: f32, side: u32| ((share * side as f32) as u32).min(side.saturating_sub(1));
    let pixel = picture.pixel(index(u, picture.width), index(1.0 - v, picture.height));
    pixel.unwrap_or([255; 4])
}

fn linear([r, g, b, alpha]: [u8; 4]) -> [f32; 4] {
    let [r, g, b] = [r, g, b].map(|channel| linear_from_srgb(f64::from(channel) / 255.0) as f32);
    [r, g, b, f32::from(alpha) / 255.0]
}

/// The middle of a triangle.
#[cfg(test)]
fn middle(corners: [[f32; 2]; 3]) -> [f32; 2] {
    [0, 1].map(|axis| corners.iter().map(|uv| uv[axis]).sum::<f32>() / 3.0)
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
    /// Those of `look`; an image that is too large for the device is made smaller.
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
    use chladni_caricature::{Project, ProxyKey, Resolution, ShapeSource};
    use chladni_harmonics::BasisSettings;
    use chladni_mesh::{CornerUvs, Material, Texture, samples};
    use chladni_task::Task;

    #[test]
    fn colors_go_to_their_vertices_and_a_damaged_texture_is_told() {
        let mut mesh = samples::icosphere(1);
        let n = mesh.positions.len();
        let body = Body::build(&mesh, &BasisSettings::new(4), &Task::new()).unwrap();
        let task = Task::new();
        let aside = Aside::new(&task);
        assert!(OwnLook::of("shape", &mesh, &body, &aside).is_none());

        // The file's own eight bits, dark ones, too, come out as they were.
        let byte = |v: usize| (v * 255 / n) as u8;
        let light = |byte: u8| linear_from_srgb(f64::from(byte) / 255.0) as f32;
        let color = |v: usize| [light(byte(v)), light(3), 2.0, 0.5];
        mesh.appearance.colors = Some((0..n).map(color).collect());
        let Some(OwnLook::Colors(bytes)) = OwnLook::of("shape", &mesh, &body, &aside) else { panic!() };
        for (v, operator) in body.operator_vertex.iter().enumerate() {
            assert_eq!(bytes[operator.unwrap() as usize], [byte(v), 3, 255, 128]);
        }

        let texture = Texture { name: "skin.png".into(), bytes: (*b"no picture").into() };
        let corners = vec![0; 3 * mesh.triangles.len()];
        mesh.appearance.uvs = Some(CornerUvs { points: vec![[0.5, 0.5]], corners });
        mesh.appearance.materials =
            vec![Material { base_color_texture: Some(texture), ..Material::named("skin") }];
        assert!(matches!(OwnLook::of("shape", &mesh, &body, &aside), Some(OwnLook::Colors(_))));
        let warnings = aside.warnings();
        assert!(warnings.len() == 1 && warnings[0].to_string().contains("skin.png"), "{warnings:?}");
    }

    #[test]
    fn the_vertices_of_a_proxy_have_the_colors_of_the_whole_shapes_texture() {
        let mut mesh = samples::icosphere(3);
        let half = |p: &[f64; 3]| [if p[0] < 0.0 { 0.25 } else { 0.75 }, 0.5];
        let points = mesh.positions.iter().map(half).collect();
        mesh.appearance.uvs = Some(CornerUvs { points, corners: mesh.triangles.as_flattened().to_vec() });
        let skin = Picture { width: 2, height: 1, rgba: vec![255, 0, 0, 255, 0, 0, 255, 255] };
        let texture = Texture { name: "skin.png".into(), bytes: skin.to_png().unwrap().into() };
        mesh.appearance.materials =
            vec![Material { base_color_texture: Some(texture), ..Material::named("skin") }];
        let mut project = Project::new(ShapeSource::Sample("ball".into()), 4);
        project.resolution = Resolution::Proxy(ProxyKey { vertices: 200, fingerprint: None });
        let task = Task::new();
        let aside = Aside::new(&task);
        let subject = Subject::of_mesh(mesh, &mut project, &aside).unwrap();
        let body = Body::build(&subject.mesh, &BasisSettings::new(4), &task).unwrap();
        let Some(OwnLook::Colors(colors)) = OwnLook::of_subject("ball", &subject, &body, &aside) else {
            panic!()
        };
        assert!(subject.proxy.is_some() && colors.len() == body.positions.len());
        for (place, vertex) in subject.mesh.positions.iter().zip(&body.operator_vertex) {
            let expected = if place[0] < 0.0 { [255, 0, 0, 255] } else { [0, 0, 255, 255] };
            assert_eq!(colors[vertex.unwrap() as usize], expected);
        }
    }
}
