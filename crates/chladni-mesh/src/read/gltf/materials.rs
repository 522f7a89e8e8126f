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

impl Scene<'_> {
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
        pictures: &mut HashMap<usize, Texture>,
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
        // Many materials may share one picture.
        if let Some(known) = pictures.get(&source) {
            return Some(known.clone());
        }
        let name = match (&image.name, &image.uri) {
            (_, Some(uri)) if !uri.starts_with("data:") => percent_decoded(uri),
            (Some(name), _) => name.clone(),
            _ => format!("image {source}"),
        };
        let bytes = match image.buffer_view {
            Some(view) => {
                self.buffers.view(view).map(|(data, _)| data.to_vec()).map_err(|fault| fault.reason)
            }
            None => Buffers::uri(image.uri.as_deref().unwrap_or_default(), beside),
        };
        let picture = bytes.and_then(|bytes| {
            if is_picture(&bytes) {
                Ok(Arc::from(bytes))
            } else {
                Err("it is neither PNG nor JPEG".to_owned())
            }
        });
        let bytes = picture.unwrap_or_else(|reason| {
            self.draft.mended.push(Mended::MissingFile(name.clone(), reason));
            Arc::default()
        });
        let texture = Texture { name, bytes };
        pictures.insert(source, texture.clone());
        Some(texture)
    }
}
