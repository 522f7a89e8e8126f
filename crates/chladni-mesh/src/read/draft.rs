//! The mesh that a reader builds, and the checks that all formats share.

use std::collections::{BTreeMap, HashMap};

use crate::appearance::linear_from_srgb;
use crate::error::Fault;
use crate::read::{Loaded, Mended};
use crate::surface::{Triangulation, triangulation};
use crate::{Appearance, Attribute, CornerUvs, Format, Material, MeshError, Rows, TriMesh};

/// Coordinates beyond this have areas whose squares overflow.
pub(crate) const GREATEST_COORDINATE: f64 = 1e75;

/// Checks one coordinate; the error says which line or byte it is in through `at`.
pub(crate) fn coordinate(x: f64, at: impl FnOnce(String) -> Fault) -> Result<f64, Fault> {
    if x.abs() <= GREATEST_COORDINATE {
        return Ok(x);
    }
    Err(at(if x.is_finite() {
        format!("coordinate {x:e} is too large")
    } else {
        format!("coordinate is {x}")
    }))
}

/// Whether texture coordinates are some that every format holds: GLB has them as `f32`.
pub(crate) fn is_texture_point(uv: [f64; 2]) -> bool {
    uv.iter().all(|x| x.abs() <= f64::from(f32::MAX))
}

/// Checks one vertex index against the number of vertices.
pub(crate) fn vertex_index(
    index: i64,
    vertices: usize,
    at: impl FnOnce(String) -> Fault,
) -> Result<u32, Fault> {
    match u32::try_from(index) {
        Ok(v) if (v as usize) < vertices => Ok(v),
        _ => Err(at(format!("vertex index {index} is out of range (there are {vertices} vertices)"))),
    }
}

/// The value of a full channel in text or as a float: 255 where some exceed 1 and all are whole numbers, otherwise 1, which
/// a program may pass by a little. Channels that are no numbers, or as great as numbers are, say nothing.
pub(crate) fn full_channel<'a>(channels: impl Iterator<Item = &'a f64>) -> f64 {
    let mut above = false;
    let whole = channels.filter(|c| c.abs() < f64::MAX).all(|c| {
        above |= *c > 1.0;
        c.fract() == 0.0
    });
    if above && whole { 255.0 } else { 1.0 }
}

/// A mesh in the making. Faces may have any number of corners.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub positions: Vec<[f64; 3]>,
    /// As many as positions, or none.
    pub colors: Vec<[f32; 4]>,
    pub colors_tint: bool,
    pub corners: Vec<u32>,
    /// As many as corners, or none.
    pub corner_uvs: Vec<u32>,
    pub uvs: Vec<[f64; 2]>,
    ends: Vec<u32>,
    pub materials: Vec<Material>,
    named: HashMap<String, u32>,
    /// As many as faces, or none.
    pub face_materials: Vec<Option<u32>>,
    pub attributes: Vec<Attribute>,
    pub mended: Vec<Mended>,
    dropped_faces: usize,
    has_polygons: bool,
}

impl Draft {
    /// Whether this many vertices and corners can be counted in 32 bits.
    fn countable(&self) -> Result<(), Fault> {
        let limit = u32::MAX as usize / 4;
        let too_many = self.positions.len() >= limit || self.corners.len() >= limit;
        if too_many {
            Err(Fault::part("whole file", "more than a billion vertices or corners"))
        } else {
            Ok(())
        }
    }

    /// Ends a face, which consists of the entries pushed to `corners` (and `corner_uvs`) since the last end. A
    /// face of one or two corners is dropped. Returns whether it was kept.
    pub fn end_face(&mut self) -> bool {
        let start = self.ends.last().map_or(0, |&end| end as usize);
        let count = self.corners.len() - start;
        if count < 3 {
            self.corners.truncate(start);
            self.corner_uvs.truncate(start);
            self.dropped_faces += 1;
            return false;
        }
        self.has_polygons |= count > 3;
        self.ends.push(self.corners.len() as u32);
        true
    }

    pub fn face_count(&self) -> usize {
        self.ends.len()
    }

    /// Where the corners of face `f` lie.
    pub fn face_corners(&self, f: usize) -> std::ops::Range<usize> {
        let start = if f == 0 { 0 } else { self.ends[f - 1] as usize };
        start..self.ends[f] as usize
    }

    /// The triangles of a strip, every second one flipped; a negative index starts a new strip.
    pub fn push_strip(
        &mut self,
        strip: impl Iterator<Item = Result<Option<u32>, Fault>>,
    ) -> Result<(), Fault> {
        let mut last = [0; 2];
        let mut length = 0_usize;
        for vertex in strip {
            let Some(v) = vertex? else {
                length = 0;
                continue;
            };
            if length >= 2 {
                let [a, b] = last;
                self.corners.extend(if length.is_multiple_of(2) { [a, b, v] } else { [b, a, v] });
                self.end_face();
            }
            last = [last[1], v];
            length += 1;
        }
        Ok(())
    }

    /// Sets colors given sRGB-encoded in [0, `full`], and mends those that are not numbers.
    pub fn set_srgb_colors(&mut self, colors: Vec<[f64; 4]>, full: [f64; 4]) {
        let mut mended = 0;
        let linear = |color: [f64; 4]| {
            if color.iter().any(|c| !c.is_finite()) {
                mended += 1;
                return [1.0; 4];
            }
            std::array::from_fn(|i| {
                let c = (color[i] / full[i]).clamp(0.0, 1.0);
                (if i < 3 { linear_from_srgb(c) } else { c }) as f32
            })
        };
        self.colors = colors.into_iter().map(linear).collect();
        if mended > 0 {
            self.mended.push(Mended::Colors(mended));
        }
    }

    /// The material called `name`, made where it is not there yet.
    pub fn material(&mut self, name: &str) -> u32 {
        if let Some(&known) = self.named.get(name) {
            return known;
        }
        let index = self.materials.len() as u32;
        self.named.insert(name.to_owned(), index);
        self.materials.push(Material::named(name));
        index
    }

    /// The material called `name` if [`material`](Self::material) has made it.
    pub fn known_material(&self, name: &str) -> Option<usize> {
        self.named.get(name).map(|&index| index as usize)
    }

    /// Gives each material the name that `renamed` has for it; those of one name become one.
    pub fn rename_materials(&mut self, renamed: impl Fn(&str) -> String) {
        self.named.clear();
        let former = std::mem::take(&mut self.materials);
        let now: Vec<u32> = former.iter().map(|material| self.material(&renamed(&material.name))).collect();
        for material in self.face_materials.iter_mut().flatten() {
            *material = now[*material as usize];
        }
    }

    /// The finished mesh; `format` is named in errors.
    pub fn finish(mut self, format: Format) -> Result<Loaded, MeshError> {
        if self.dropped_faces > 0 {
            self.mended.push(Mended::ShortFaces(self.dropped_faces));
        }
        if self.ends.is_empty() {
            return Err(MeshError::NoFace(format));
        }
        self.countable().map_err(|Fault { at, reason }| MeshError::Malformed { format, at, reason })?;
        // Only now: readers tell an unusable point, which corners may share, by its value.
        for point in self.uvs.iter_mut().filter(|point| !is_texture_point(**point)) {
            *point = [0.0; 2];
        }
        let mut triangles = Vec::with_capacity(self.corners.len().saturating_sub(2 * self.ends.len()));
        let (mut divided, mut folded) = (BTreeMap::new(), 0);
        let mut start = 0;
        for (&end, f) in self.ends.iter().zip(0_u32..) {
            let face = &self.corners[start as usize..end as usize];
            let found = triangulation(&self.positions, face);
            folded += usize::from(found == Triangulation::FoldedFan);
            if let Triangulation::Corners(corners) = found {
                triangles.extend(corners.iter().map(|triangle| triangle.map(|c| face[c as usize])));
                divided.insert(f, corners);
            } else {
                triangles.extend((2..face.len()).map(|i| [face[0], face[i - 1], face[i]]));
            }
            start = end;
        }
        if folded > 0 {
            self.mended.push(Mended::FoldedFans(folded));
        }
        let polygons = self.has_polygons.then(|| {
            let starts = std::iter::once(0).chain(self.ends.iter().copied()).collect();
            Rows { starts, items: self.corners }
        });
        let has_uvs = self.corner_uvs.iter().any(|&uv| uv != CornerUvs::NONE);
        let uvs = has_uvs.then_some(CornerUvs { points: self.uvs, corners: self.corner_uvs });
        let appearance = Appearance {
            polygons,
            divided,
            colors: (!self.colors.is_empty()).then_some(self.colors),
            colors_tint: self.colors_tint,
            uvs,
            materials: self.materials,
            face_materials: self.face_materials,
            attributes: self.attributes,
        };
        let mesh = TriMesh { positions: self.positions, triangles, appearance };
        Ok(Loaded { mesh, mended: self.mended, stored_positions: None })
    }
}
