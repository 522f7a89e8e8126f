//! A glTF file's buffers and the accessors into them.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::beside::{Beside, plain_uri};
use super::gltf_json::{Accessor, Root};
use crate::error::Fault;

/// An accessor without data holds zeros; at most this many of up to four components are accepted.
const MOST_ZEROS: usize = 1 << 24;

pub(crate) struct Buffers<'a> {
    root: &'a Root,
    /// Buffers of one uri share their bytes.
    data: Vec<Arc<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    pub fn open(root: &'a Root, binary: Option<&'a [u8]>, beside: &Beside<'_>) -> Result<Self, Fault> {
        let mut data: Vec<Arc<Cow<'a, [u8]>>> = Vec::new();
        let mut by_uri: HashMap<Cow<'_, str>, usize> = HashMap::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let at = || format!("buffers[{i}]");
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => match by_uri.insert(plain_uri(uri), i) {
                    Some(same) => data[same].clone(),
                    None => {
                        let bytes = Self::uri(uri, beside).map_err(|reason| Fault::part(at(), reason))?;
                        Arc::new(Cow::Owned(bytes))
                    }
                },
                (None, Some(binary)) if i == 0 => Arc::new(Cow::Borrowed(binary)),
                (None, _) => return Err(Fault::part(at(), "has neither a uri nor a binary chunk")),
            };
            if bytes.len() < buffer.byte_length {
                let reason = format!("has {} of {} bytes", bytes.len(), buffer.byte_length);
                return Err(Fault::part(at(), reason));
            }
            data.push(bytes);
        }
        Ok(Self { root, data })
    }

    /// The bytes of all buffers; those of one uri are the same slice.
    pub fn all(&self) -> impl Iterator<Item = &[u8]> {
        self.data.iter().map(|data| &***data)
    }

    /// The number of bytes of all buffers, those of one uri counted once.
    pub fn length(&self) -> usize {
        let mut known = HashSet::new();
        self.all().filter(|data| known.insert(data.as_ptr())).map(<[u8]>::len).sum()
    }

    /// The bytes behind a `data:` URI or of a file beside.
    pub fn uri(uri: &str, beside: &Beside<'_>) -> Result<Vec<u8>, String> {
        let Some(data) = uri.strip_prefix("data:") else {
            let name = plain_uri(uri);
            return beside(&name).map_err(|reason| format!("{name}: {reason}"));
        };
        match data.split_once(";base64,") {
            Some((_, text)) => base64_decoded(text).ok_or_else(|| "its data URI is not valid base64".into()),
            None => Err("its data URI is not base64".into()),
        }
    }

    /// The bytes of a buffer view and its stride.
    pub fn view(&self, index: usize) -> Result<(&[u8], Option<usize>), Fault> {
        let at = || format!("bufferViews[{index}]");
        let Some(view) = self.root.buffer_views.get(index) else {
            return Err(Fault::part(at(), "there is no such buffer view"));
        };
        let end = view.byte_offset.checked_add(view.byte_length);
        let data =
            self.data.get(view.buffer).zip(end).and_then(|(data, end)| data.get(view.byte_offset..end));
        data.map(|data| (data, view.byte_stride))
            .ok_or_else(|| Fault::part(at(), "reaches beyond its buffer"))
    }

    /// All components of an accessor, and how many make one element.
    fn values(&self, index: usize, used_by: &str) -> Result<(Vec<f64>, usize), Fault> {
        let at = || format!("{used_by}, accessors[{index}]");
        let Some(accessor) = self.root.accessors.get(index) else {
            return Err(Fault::part(at(), "there is no such accessor"));
        };
        let components = match accessor.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            kind => return Err(Fault::part(at(), format!("type {kind} has no use here"))),
        };
        let component = Component::of(accessor).ok_or_else(|| Fault::part(at(), "unknown component type"))?;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let (data, stride) = self.view(view)?;
                let stride = stride.unwrap_or(components * component.size);
                component
                    .read(data, accessor.byte_offset, stride, accessor.count, components)
                    .ok_or_else(|| Fault::part(at(), "reaches beyond its buffer view"))?
            }
            None if accessor.count <= MOST_ZEROS / components.div_ceil(4) => {
                vec![0.0; accessor.count * components]
            }
            None => return Err(Fault::part(at(), format!("{} elements without data", accessor.count))),
        };
        if let Some(sparse) = &accessor.sparse {
            let index_type =
                Component { normalized: false, ..component.with_size(sparse.indices.component_type) };
            let (data, _) = self.view(sparse.indices.buffer_view)?;
            let places = index_type.read(data, sparse.indices.byte_offset, index_type.size, sparse.count, 1);
            let (data, _) = self.view(sparse.values.buffer_view)?;
            let size = components * component.size;
            let changed = component.read(data, sparse.values.byte_offset, size, sparse.count, components);
            let (Some(places), Some(changed)) = (places, changed) else {
                return Err(Fault::part(at(), "its sparse part reaches beyond its buffer view"));
            };
            for (place, change) in places.iter().zip(changed.chunks_exact(components)) {
                let start = (*place as usize).saturating_mul(components);
                match values.get_mut(start..start.saturating_add(components)) {
                    Some(element) => element.copy_from_slice(change),
                    None => {
                        return Err(Fault::part(at(), "its sparse part names an element that is not there"));
                    }
                }
            }
        }
        Ok((values, components))
    }

    /// The elements of an accessor of scalars.
    pub fn scalars(&self, index: usize, used_by: &str) -> Result<Vec<f64>, Fault> {
        Ok(self.vectors::<1>(index, used_by)?.into_iter().map(|[x]| x).collect())
    }

    /// The elements of an accessor of N components.
    pub fn vectors<const N: usize>(&self, index: usize, used_by: &str) -> Result<Vec<[f64; N]>, Fault> {
        let (values, components) = self.values(index, used_by)?;
        if components != N {
            let reason = format!("has {components} components per element where {N} are needed");
            return Err(Fault::part(format!("{used_by}, accessors[{index}]"), reason));
        }
        Ok(values.as_chunks().0.to_vec())
    }

    /// The elements of an accessor of RGB or RGBA.
    pub fn colors(&self, index: usize, used_by: &str) -> Result<Vec<[f64; 4]>, Fault> {
        let (values, components) = self.values(index, used_by)?;
        let color = |c: &[f64]| [c[0], c[1], c[2], c.get(3).copied().unwrap_or(1.0)];
        match components {
            3 | 4 => Ok(values.chunks_exact(components).map(color).collect()),
            _ => Err(Fault::part(format!("{used_by}, accessors[{index}]"), "is no color")),
        }
    }
}

/// A component type and how to read it.
#[derive(Clone, Copy)]
struct Component {
    kind: u32,
    size: usize,
    normalized: bool,
}

impl Component {
    fn of(accessor: &Accessor) -> Option<Self> {
        let kind = accessor.component_type;
        let sized = Self { kind, size: 0, normalized: accessor.normalized }.with_size(kind);
        (sized.size > 0).then_some(sized)
    }

    fn with_size(self, kind: u32) -> Self {
        let size = match kind {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            _ => 0,
        };
        Self { kind, size, normalized: self.normalized && kind != 5125 }
    }

    fn value(self, raw: &[u8]) -> f64 {
        let mut bytes = [0; 4];
        bytes[..raw.len().min(4)].copy_from_slice(&raw[..raw.len().min(4)]);
        let [a, b, ..] = bytes;
        let (value, full) = match self.kind {
            5120 => (f64::from(a as i8), 127.0),
            5121 => (f64::from(a), 255.0),
            5122 => (f64::from(i16::from_le_bytes([a, b])), 32767.0),
            5123 => (f64::from(u16::from_le_bytes([a, b])), 65535.0),
            5125 => (f64::from(u32::from_le_bytes(bytes)), 1.0),
            _ => (f64::from(f32::from_le_bytes(bytes)), 1.0),
        };
        if self.normalized { (value / full).max(-1.0) } else { value }
    }

    /// `None` where the elements reach beyond `data` or overlap each other.
    fn read(
        self,
        data: &[u8],
        offset: usize,
        stride: usize,
        count: usize,
        components: usize,
    ) -> Option<Vec<f64>> {
        let element = components * self.size;
        if count == 0 {
            return Some(Vec::new());
        }
        if stride < element || self.size == 0 {
            return None;
        }
        let end = (count - 1).checked_mul(stride)?.checked_add(element)?.checked_add(offset)?;
        let used = data.get(offset..end)?;
        let elements = used.chunks(stride).flat_map(|e| e[..element].chunks_exact(self.size));
        Some(elements.map(|raw| self.value(raw)).collect())
    }
}

fn base64_decoded(text: &str) -> Option<Vec<u8>> {
    let mut decoded = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut held) = (0_u32, 0);
    for byte in text.trim_end_matches('=').bytes() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            decoded.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    Some(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_many_buffers_name_is_read_once() {
        let root = r#"{"buffers":[{"byteLength":3,"uri":"a"},{"byteLength":1,"uri":"b"},{"byteLength":2,"uri":"./%61"}]}"#;
        let root: Root = serde_json::from_str(root).unwrap();
        let read = std::cell::RefCell::new(Vec::new());
        let beside = |name: &str| {
            read.borrow_mut().push(name.to_owned());
            Ok(name.repeat(3).into_bytes())
        };
        let Ok(buffers) = Buffers::open(&root, None, &beside) else { panic!("they are all there") };
        assert_eq!(buffers.all().collect::<Vec<_>>(), [b"aaa", b"bbb", b"aaa"]);
        assert_eq!(*read.borrow(), ["a", "b"]);
    }

    #[test]
    fn base64_decodes() {
        assert_eq!(base64_decoded("Q2hsYWRuaQ==").as_deref(), Some(&b"Chladni"[..]));
        assert_eq!(base64_decoded("Q2hs YWRuaQ"), None);
    }
}
