//! Materials of glTF, and their pictures.

use std::collections::HashMap;
use std::sync::Arc;

use chladni_task::percent_decoded;

use super::Scene;
use crate::read::Mended;
use crate::read::beside::Beside;
use crate::read::gltf_buffers::Buffers;
use crate::read::gltf_json::Material as JsonMaterial;
use crate::read::mtl::is_picture;
use crate::{Material, Texture};

/// The pictures read so far, by where they are from, since many images may share one.
type Pictures<'a> = HashMap<Source<'a>, Arc<[u8]>>;

/// The bytes of an image.
#[derive(PartialEq, Eq, Hash)]
enum Source<'a> {
    View(usize),
    Uri(&'a str),
}

/// The longest name of a picture that is kept, in characters: each material that shows it has the name, too.
const LONGEST_NAME: usize = 1000;

impl<'a> Scene<'a> {
    pub(super) fn materials(&mut self, beside: &Beside<'_>) {
        let mut pictures = HashMap::new();
        for material in &self.root.materials {
            let pbr = material.pbr_metallic_roughness.as_ref();
            let factor = pbr.and_then(|pbr| pbr.base_color_factor).unwrap_or([1.0; 4]);
            let base_color = factor.map(|c| if c.is_finite() { c.clamp(0.0, 1.0) as f32 } else { 1.0 });
            let base_color_texture = self.texture(material, &mut pictures, beside);
            let name = &material.name;
            self.draft.materials.push(Material { base_color, base_color_texture, ..Material::named(name) });
        }
    }

    fn texture(
        &mut self,
        material: &JsonMaterial,
        pictures: &mut Pictures<'a>,
        beside: &Beside<'_>,
    ) -> Option<Texture> {
        let index = material.pbr_metallic_roughness.as_ref()?.base_color_texture.as_ref()?.index;
        let source = self.root.textures.get(index).and_then(|texture| texture.source);
        let Some((source, image)) = source.and_then(|source| Some((source, self.root.images.get(source)?)))
        else {
            let reason = "there is no such image".to_owned();
            self.draft.mended.push(Mended::MissingFile(format!("texture {index}"), reason));
            return None;
        };
        let name = match (&image.name, &image.uri) {
            (_, Some(uri)) if !uri.starts_with("data:") => percent_decoded(uri),
            (Some(name), _) => name.clone(),
            _ => format!("image {source}"),
        };
        let name: String = name.chars().take(LONGEST_NAME).collect();
        let from = match image.buffer_view {
            Some(view) => Source::View(view),
            None => Source::Uri(image.uri.as_deref().unwrap_or_default()),
        };
        if let Some(known) = pictures.get(&from) {
            return Some(Texture { name, bytes: known.clone() });
        }
        let bytes = match from {
            Source::View(view) => {
                self.buffers.view(view).map(|(data, _)| data.into()).map_err(|fault| fault.reason)
            }
            Source::Uri(uri) => Buffers::uri(uri, beside).map(Arc::from),
        };
        let picture = bytes.and_then(|bytes: Arc<[u8]>| {
            if is_picture(&bytes) { Ok(bytes) } else { Err("it is neither PNG nor JPEG".to_owned()) }
        });
        let bytes = picture.unwrap_or_else(|reason| {
            self.draft.mended.push(Mended::MissingFile(name.clone(), reason));
            Arc::default()
        });
        pictures.insert(from, bytes.clone());
        Some(Texture { name, bytes })
    }
}
