//! Materials of glTF, and their pictures.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use chladni_task::percent_decoded;

use super::Scene;
use crate::read::Mended;
use crate::read::beside::{Beside, plain_uri};
use crate::read::gltf_buffers::Buffers;
use crate::read::gltf_json::{AlphaMode as JsonAlphaMode, Material as JsonMaterial, TextureSource};
use crate::read::mtl::checked_picture;
use crate::{AlphaMode, Material, Texture};

/// The pictures read so far, by where they are from, since many images may share one.
struct Pictures<'a> {
    known: HashMap<Source<'a>, Arc<[u8]>>,
    /// How many bytes may still come from the buffers: overlapping views could ask for any amount of memory.
    left: usize,
}

/// The bytes of an image.
#[derive(PartialEq, Eq, Hash)]
enum Source<'a> {
    /// Where in memory a buffer view lies, and its length: many views may be of the same bytes.
    View(*const u8, usize),
    /// A view that is not there.
    NoView(usize),
    Uri(Cow<'a, str>),
}

/// The longest name of a picture that is kept, in characters: each material that shows it has the name, too.
const LONGEST_NAME: usize = 1000;

impl<'a> Scene<'a> {
    pub(super) fn materials(&mut self, beside: &Beside<'_>) {
        let mut pictures = Pictures { known: HashMap::new(), left: self.buffers.length() };
        for material in &self.root.materials {
            let pbr = material.pbr_metallic_roughness.as_ref();
            let factor = pbr.and_then(|pbr| pbr.base_color_factor).unwrap_or([1.0; 4]);
            let mut base_color = factor.map(|c| if c.is_finite() { c.clamp(0.0, 1.0) as f32 } else { 1.0 });
            let alpha_mode = match material.alpha_mode {
                Some(JsonAlphaMode::Mask) => {
                    let cutoff = material.alpha_cutoff.filter(|cutoff| cutoff.is_finite() && *cutoff >= 0.0);
                    AlphaMode::Mask { cutoff: cutoff.unwrap_or(0.5) }
                }
                Some(JsonAlphaMode::Blend) => AlphaMode::Blend,
                Some(JsonAlphaMode::Opaque) | None => {
                    // Alpha means nothing then.
                    base_color[3] = 1.0;
                    AlphaMode::Usual
                }
            };
            let base_color_texture = self.texture(material, &mut pictures, beside);
            let named = Material::named(&material.name);
            self.draft.materials.push(Material { base_color, base_color_texture, alpha_mode, ..named });
        }
    }

    fn texture(
        &mut self,
        material: &JsonMaterial,
        pictures: &mut Pictures<'a>,
        beside: &Beside<'_>,
    ) -> Option<Texture> {
        let index = material.pbr_metallic_roughness.as_ref()?.base_color_texture.as_ref()?.index;
        let source = self.root.textures.get(index).and_then(TextureSource::image);
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
        let uri = image.uri.as_deref().unwrap_or_default();
        let view = image.buffer_view.map(|view| (view, self.buffers.view(view)));
        let from = match &view {
            Some((_, Ok((data, _)))) => Source::View(data.as_ptr(), data.len()),
            Some((view, Err(_))) => Source::NoView(*view),
            None => Source::Uri(plain_uri(uri)),
        };
        if let Some(known) = pictures.known.get(&from) {
            return Some(Texture { name, bytes: known.clone() });
        }
        let picture: Result<Arc<[u8]>, String> = match view {
            Some((_, view)) => view.map_err(|fault| fault.reason).and_then(|(data, _)| {
                let left = pictures.left.checked_sub(checked_picture(data)?.len());
                pictures.left = left.ok_or("it shares its bytes with other pictures")?;
                Ok(Arc::from(data))
            }),
            None => Buffers::uri(uri, beside).and_then(|bytes| checked_picture(&bytes).map(Arc::from)),
        };
        let bytes = picture.unwrap_or_else(|reason| {
            self.draft.mended.push(Mended::MissingFile(name.clone(), reason));
            Arc::default()
        });
        pictures.known.insert(from, bytes.clone());
        Some(Texture { name, bytes })
    }
}
