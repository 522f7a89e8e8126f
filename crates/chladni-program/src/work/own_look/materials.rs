//! The picture that a mesh's materials make.

use std::collections::HashMap;

use chladni_mesh::{Material, Texture, TriMesh, linear_from_srgb, srgb_from_linear};
use chladni_view::{Picture, ViewError, srgb_bytes};

use super::atlas::Atlas;
use crate::work::{Warning, Watcher};

/// So many materials are shown, faces with others in white.
const MOST_MATERIALS: usize = 1024;

/// The picture of the materials of `mesh`, which is called `name`, and where the corners of its triangles lie on it, v
/// upward. `None` where no face has a texture and all have one color, or vertices have colors of their own
/// ([`vertex_colors`]). Warns of what cannot be shown.
pub fn picture_of_materials(
    name: &str,
    mesh: &TriMesh,
    watcher: &impl Watcher,
) -> Option<(Vec<[[f32; 2]; 3]>, Picture)> {
    let uvs = mesh.triangle_uvs();
    let (mut drawn, mut of_triangle) = drawn(mesh, uvs.is_some());
    if drawn.len() > MOST_MATERIALS {
        let message = format!("has {} materials; {MOST_MATERIALS} are shown, others in white", drawn.len());
        watcher.warn(Warning::of(name, message));
        drawn.truncate(MOST_MATERIALS);
        of_triangle.iter_mut().for_each(|of| *of = (*of).min(MOST_MATERIALS));
        drawn.push(Drawn::PLAIN);
    }
    let mut textures = Textures { name, watcher, sizes: HashMap::new(), pictures: HashMap::new() };
    let sizes: Vec<Option<[u32; 2]>> = drawn.iter().map(|one| textures.size(one)).collect();
    if sizes.iter().all(Option::is_none)
        && (has_vertex_colors(mesh) || drawn.iter().all(|one| one.color == drawn[0].color))
    {
        return None;
    }
    let mut uvs = uvs.unwrap_or_else(|| vec![[[0.5; 2]; 3]; of_triangle.len()]);
    if let [one] = drawn[..] {
        return Some((uvs, tinted(textures.picture(&one, u32::MAX)?, one.color)));
    }
    let sizes: Vec<[u32; 2]> = sizes.into_iter().map(|size| size.unwrap_or([1, 1])).collect();
    let atlas = Atlas::of(&sizes, &of_triangle, &mut uvs);
    let mut pictures = Vec::with_capacity(drawn.len());
    for (i, one) in drawn.iter().enumerate() {
        watcher.task().check().ok()?;
        let picture = textures.picture(one, atlas.side(i));
        pictures.push(picture.map_or_else(|| one.plain(), |picture| tinted(picture, one.color)));
    }
    if atlas.is_coarse {
        let message = "has large or often repeated textures; the view shows them smaller, exports keep all";
        watcher.warn(Warning::of(name, message));
    }
    let picture = atlas.lay_out(&pictures, &of_triangle, &mut uvs);
    Some((uvs, picture))
}

/// Whether vertices have colors of their own. White that is multiplied with materials is none.
fn has_vertex_colors(mesh: &TriMesh) -> bool {
    let look = &mesh.appearance;
    let is_white = |&[r, g, b, _]: &[f32; 4]| [r, g, b] == [1.0; 3];
    look.colors.as_ref().is_some_and(|colors| !(look.colors_tint && colors.iter().all(is_white)))
}

/// The linear-light colors of the vertices of `mesh`, where they have their own. Where they tint, as in glTF, they are
/// multiplied with the color of the first triangle's material at each vertex.
pub fn vertex_colors(mesh: &TriMesh) -> Option<Vec<[f32; 4]>> {
    let look = &mesh.appearance;
    let mut colors = look.colors.as_ref().filter(|_| has_vertex_colors(mesh))?.clone();
    if look.colors_tint && !look.face_materials.is_empty() {
        let mut is_tinted = vec![false; colors.len()];
        for (triangle, material) in mesh.triangles.iter().zip(mesh.triangle_materials()) {
            let material = material.and_then(|index| look.materials.get(index as usize));
            let factor = material.map_or([1.0; 4], |material| material.base_color);
            for vertex in triangle.map(|vertex| vertex as usize) {
                if !std::mem::replace(&mut is_tinted[vertex], true) {
                    colors[vertex].iter_mut().zip(factor).for_each(|(channel, factor)| *channel *= factor);
                }
            }
        }
    }
    Some(colors)
}

/// How a material is drawn.
#[derive(Clone, Copy)]
struct Drawn<'a> {
    texture: Option<&'a Texture>,
    /// In linear light.
    color: [f32; 3],
}

impl<'a> Drawn<'a> {
    /// As faces without a material.
    const PLAIN: Drawn<'static> = Drawn { texture: None, color: [1.0; 3] };

    fn of(material: &'a Material, has_uvs: bool) -> Self {
        let [r, g, b, _] = material.base_color;
        Self { texture: material.read_texture().filter(|_| has_uvs), color: [r, g, b] }
    }

    /// Two that agree in this are drawn in one way.
    fn key(&self) -> (Option<*const u8>, [u32; 3]) {
        (self.texture.map(|texture| texture.bytes.as_ptr()), self.color.map(f32::to_bits))
    }

    /// A pixel of its color.
    fn plain(&self) -> Picture {
        let [r, g, b] = self.color;
        Picture::filled(1, 1, srgb_bytes([r, g, b, 1.0]))
    }
}

/// What the triangles of `mesh` are drawn in, and for each triangle its index there.
fn drawn(mesh: &TriMesh, has_uvs: bool) -> (Vec<Drawn<'_>>, Vec<usize>) {
    let look = &mesh.appearance;
    if look.face_materials.is_empty() {
        // Nothing says so, but a texture is meant for something.
        let first = look.materials.iter().find(|material| material.read_texture().is_some());
        let drawn = first.map_or(Drawn::PLAIN, |material| Drawn::of(material, has_uvs));
        return (vec![drawn], vec![0; mesh.triangles.len()]);
    }
    let (mut drawn, mut known) = (Vec::new(), HashMap::new());
    let of_triangle = mesh.triangle_materials().into_iter().map(|index| {
        let material = index.and_then(|index| look.materials.get(index as usize));
        let one = material.map_or(Drawn::PLAIN, |material| Drawn::of(material, has_uvs));
        *known.entry(one.key()).or_insert_with(|| {
            drawn.push(one);
            drawn.len() - 1
        })
    });
    let of_triangle = of_triangle.collect();
    (drawn, of_triangle)
}

/// Textures that several materials may have, each of which is read once.
struct Textures<'a, W> {
    name: &'a str,
    watcher: &'a W,
    /// By where their bytes lie.
    sizes: HashMap<*const u8, Option<[u32; 2]>>,
    /// By that and their longest side.
    pictures: HashMap<(*const u8, u32), Option<Picture>>,
}

impl<W: Watcher> Textures<'_, W> {
    /// The size of what is drawn; `None` without a texture that can be shown.
    fn size(&mut self, drawn: &Drawn<'_>) -> Option<[u32; 2]> {
        let texture = drawn.texture?;
        let (name, watcher) = (self.name, self.watcher);
        let read = || shown(name, texture, Picture::size_of(&texture.bytes), watcher);
        *self.sizes.entry(texture.bytes.as_ptr()).or_insert_with(read)
    }

    /// The texture in its own colors, made smaller where its longest side has more than `side` pixels.
    fn picture(&mut self, drawn: &Drawn<'_>, side: u32) -> Option<Picture> {
        self.size(drawn)?;
        let texture = drawn.texture?;
        let (name, watcher) = (self.name, self.watcher);
        let read = || {
            let picture = shown(name, texture, Picture::decode(&texture.bytes), watcher)?;
            Some(picture.thumbnail(side))
        };
        self.pictures.entry((texture.bytes.as_ptr(), side)).or_insert_with(read).clone()
    }
}

/// What was read of a texture, or a warning.
fn shown<T>(name: &str, texture: &Texture, read: Result<T, ViewError>, watcher: &impl Watcher) -> Option<T> {
    read.inspect_err(|error| {
        let message = format!("the texture {} cannot be shown: {error}", texture.name);
        watcher.warn(Warning::of(name, message));
    })
    .ok()
}

/// `picture` times the color of its material, in linear light. Black, which some programs write beside a picture, changes
/// nothing.
fn tinted(mut picture: Picture, color: [f32; 3]) -> Picture {
    if color == [1.0; 3] || color == [0.0; 3] {
        return picture;
    }
    let shades = color.map(|factor| {
        std::array::from_fn::<u8, 256, _>(|byte| {
            let linear = linear_from_srgb(byte as f64 / 255.0) * f64::from(factor);
            (srgb_from_linear(linear) * 255.0).round() as u8
        })
    });
    for pixel in picture.rgba.as_chunks_mut::<4>().0 {
        for (channel, shades) in pixel.iter_mut().zip(&shades) {
            *channel = shades[usize::from(*channel)];
        }
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::super::{middle, pixel_at};
    use super::*;
    use crate::work::Aside;
    use chladni_mesh::{CornerUvs, samples};
    use chladni_task::Task;

    fn texture(bytes: Vec<u8>) -> Option<Texture> {
        Some(Texture { name: "skin.png".into(), bytes: bytes.into() })
    }

    fn material(base_color: [f32; 4], base_color_texture: Option<Texture>) -> Material {
        Material { base_color, base_color_texture, ..Material::named("skin") }
    }

    /// A ball of four materials: one whose file was not read, an image, and two without, of which one is black. Every corner lies in
    /// the left half of the image.
    fn dressed() -> TriMesh {
        let mut mesh = samples::icosphere(1);
        let skin = Picture { width: 2, height: 1, rgba: vec![255, 188, 0, 255, 0, 0, 255, 128] };
        let corners = vec![0; 3 * mesh.triangles.len()];
        mesh.appearance.uvs = Some(CornerUvs { points: vec![[0.25, 0.5]], corners });
        mesh.appearance.materials = vec![
            material([0.0, 0.0, 1.0, 1.0], texture(Vec::new())),
            material([1.0, 0.5, 0.0, 0.25], texture(skin.to_png().unwrap())),
            material([0.0, 1.0, 0.0, 1.0], None),
            material([0.0, 0.0, 0.0, 1.0], None),
        ];
        mesh.appearance.face_materials = vec![Some(1); mesh.triangles.len()];
        mesh
    }

    #[test]
    fn a_texture_alone_has_its_materials_color() {
        let mesh = dressed();
        let task = Task::new();
        let aside = Aside::new(&task);
        let (uvs, picture) = picture_of_materials("ball", &mesh, &aside).unwrap();
        assert_eq!(picture.rgba, [255, 137, 0, 255, 0, 0, 0, 128]);
        assert_eq!(Some(uvs), mesh.triangle_uvs());
        assert!(aside.warnings().is_empty());
    }

    #[test]
    fn every_face_has_the_look_of_its_material() {
        let mut mesh = dressed();
        mesh.appearance.face_materials[3..8].copy_from_slice(&[Some(2), Some(3), None, Some(0), Some(2)]);
        let task = Task::new();
        let aside = Aside::new(&task);
        let (uvs, picture) = picture_of_materials("ball", &mesh, &aside).unwrap();
        for (t, material) in mesh.triangle_materials().into_iter().enumerate() {
            let expected = match material {
                None => [255; 4],
                Some(0) => [0, 0, 255, 255],
                Some(1) => [255, 137, 0, 255],
                Some(2) => [0, 255, 0, 255],
                _ => [0, 0, 0, 255],
            };
            assert_eq!(pixel_at(&picture, middle(uvs[t])), expected, "triangle {t}");
        }
        assert!(aside.warnings().is_empty());
    }

    #[test]
    fn one_color_is_no_look_and_those_of_vertices_come_first() {
        let mut mesh = dressed();
        let task = Task::new();
        let aside = Aside::new(&task);
        mesh.appearance.uvs = None;
        assert!(picture_of_materials("ball", &mesh, &aside).is_none(), "a texture without places on it");
        mesh.appearance.face_materials[7] = Some(2);
        assert!(picture_of_materials("ball", &mesh, &aside).is_some());
        mesh.appearance.colors = Some(vec![[1.0; 4]; mesh.positions.len()]);
        assert!(picture_of_materials("ball", &mesh, &aside).is_none());
        assert_eq!(vertex_colors(&mesh), mesh.appearance.colors);
        // White that is only a factor, as in glTF, is no color.
        mesh.appearance.colors_tint = true;
        assert!(picture_of_materials("ball", &mesh, &aside).is_some() && vertex_colors(&mesh).is_none());
        assert!(aside.warnings().is_empty());
    }

    #[test]
    fn vertex_colors_that_tint_are_multiplied_with_materials() {
        let mut mesh = dressed();
        mesh.appearance.uvs = None;
        mesh.appearance.face_materials[0] = None;
        mesh.appearance.colors = Some(vec![[0.5, 0.5, 0.5, 1.0]; mesh.positions.len()]);
        mesh.appearance.colors_tint = true;
        let colors = vertex_colors(&mesh).unwrap();
        // The first triangle has no material; that of the others is (1, 0.5, 0), of opacity 1/4.
        for (v, color) in (0..).zip(colors) {
            let bare = mesh.triangles[0].contains(&v);
            assert_eq!(color, if bare { [0.5, 0.5, 0.5, 1.0] } else { [0.5, 0.25, 0.0, 0.25] });
        }
    }

    #[test]
    fn of_very_many_materials_the_first_are_shown() {
        let mut mesh = samples::icosphere(3);
        let color = |i: usize| [(i % 256) as f32 / 255.0, (i / 256) as f32 / 255.0, 0.0, 1.0];
        mesh.appearance.materials = (0..mesh.triangles.len()).map(|i| material(color(i), None)).collect();
        mesh.appearance.face_materials = (0..mesh.triangles.len() as u32).map(Some).collect();
        let task = Task::new();
        let aside = Aside::new(&task);
        let (uvs, picture) = picture_of_materials("ball", &mesh, &aside).unwrap();
        let seen = |t: usize| pixel_at(&picture, middle(uvs[t]));
        assert_eq!(seen(MOST_MATERIALS), [255; 4]);
        assert!(seen(MOST_MATERIALS - 1)[2] == 0 && seen(0) == [0, 0, 0, 255]);
        let warnings = aside.warnings();
        assert!(
            warnings.len() == 1 && warnings[0].to_string().contains("has 1280 materials"),
            "{warnings:?}"
        );
    }
}
