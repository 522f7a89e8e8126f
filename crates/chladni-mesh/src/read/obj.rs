//! Wavefront OBJ.

use super::beside::Beside;
use super::draft::{Draft, coordinate, full_channel, is_texture_point, vertex_index};
use super::mtl;
use super::text::{Lines, number, text_after, words};
use crate::CornerUvs;
use crate::error::Fault;
use crate::read::Mended;

/// Colors of vertices in ZBrush's files, behind a comment's sign: in the order of the vertices, eight hexadecimal digits
/// each, mask, red, green and blue.
const POLYPAINT: &[u8] = b"#MRGB";

/// Reads `v` (with colors), `vt`, `f` with positive or negative indices, `usemtl`, `mtllib` and lines joined
/// by a backslash. Vertices keep the order of the file, regardless of materials and groups. Normals, groups,
/// lines, points and free-form surfaces are left out.
pub(crate) fn read(bytes: &[u8], beside: &Beside<'_>) -> Result<Draft, Fault> {
    let mut obj = Obj::default();
    let mut joined = Vec::new();
    let mut lines = Lines::new(bytes, Some(b'#'), true).keeping(POLYPAINT);
    while let Some([line, whole]) = lines.next_and_whole(&mut joined) {
        let mut parts = words(line);
        let keyword = parts.next().unwrap_or_default();
        // Names may hold blanks and number signs.
        let rest = || text_after(whole, keyword);
        match keyword {
            b"v" => obj.vertex(parts, lines.number())?,
            b"vt" => obj.texture_vertex(parts, lines.number())?,
            b"f" => obj.face(parts, lines.number())?,
            b"usemtl" => obj.material = Some(obj.draft.material(&rest())),
            b"mtllib" => obj.libraries.push(rest()),
            POLYPAINT => obj.polypaint.extend(parts.flat_map(|word| word.chunks_exact(8)).map_while(painted)),
            b"curv" | b"curv2" | b"surf" => obj.free_form += 1,
            _ => {}
        }
    }
    obj.finish(beside)
}

#[derive(Default)]
struct Obj {
    draft: Draft,
    /// NaN where a vertex has none.
    colors: Vec<[f64; 4]>,
    has_colors: bool,
    polypaint: Vec<[f64; 4]>,
    material: Option<u32>,
    libraries: Vec<String>,
    free_form: usize,
    /// The line of each face, for errors about indices, which may point forward.
    face_lines: Vec<u32>,
    /// A corner's indices as written, made absolute: vertex and texture coordinates.
    written: Vec<(i64, Option<i64>)>,
}

impl Obj {
    fn vertex<'a>(&mut self, parts: impl Iterator<Item = &'a [u8]>, line: usize) -> Result<(), Fault> {
        let mut values = [f64::NAN; 6];
        let mut count = 0;
        for word in parts.take(6) {
            values[count] = number(word, line, "a coordinate")?;
            count += 1;
        }
        if count < 3 {
            return Err(Fault::line(line, "a vertex needs three coordinates"));
        }
        let mut position = [0.0; 3];
        for (p, &x) in position.iter_mut().zip(&values) {
            *p = coordinate(x, |reason| Fault::line(line, reason))?;
        }
        self.draft.positions.push(position);
        self.has_colors |= count == 6;
        self.colors.push(if count == 6 { [values[3], values[4], values[5], 1.0] } else { [f64::NAN; 4] });
        Ok(())
    }

    fn texture_vertex<'a>(
        &mut self,
        mut parts: impl Iterator<Item = &'a [u8]>,
        line: usize,
    ) -> Result<(), Fault> {
        let mut next = |missing: Result<f64, Fault>| match parts.next() {
            Some(word) => number(word, line, "a texture coordinate"),
            None => missing,
        };
        let u = next(Err(Fault::line(line, "a texture vertex needs a coordinate")))?;
        let v = next(Ok(0.0))?;
        self.draft.uvs.push([u, v]);
        Ok(())
    }

    fn face<'a>(&mut self, parts: impl Iterator<Item = &'a [u8]>, line: usize) -> Result<(), Fault> {
        let absolute = |index: i64, count: usize| match index {
            0 => Err(Fault::line(line, "indices count from 1, not 0")),
            1.. => Ok(index - 1),
            _ => match count as i64 + index {
                i if i >= 0 => Ok(i),
                _ => Err(Fault::line(line, format!("relative index {index} reaches before the first"))),
            },
        };
        for part in parts {
            let mut indices = part.split(|&b| b == b'/');
            let v = number(indices.next().unwrap_or_default(), line, "a vertex index")?;
            let v = absolute(v, self.draft.positions.len())?;
            let vt = match indices.next() {
                Some(word) if !word.is_empty() => {
                    let vt = number(word, line, "a texture vertex index")?;
                    Some(absolute(vt, self.draft.uvs.len())?)
                }
                _ => None,
            };
            self.written.push((v, vt));
            self.draft.corners.push(u32::try_from(v).unwrap_or(u32::MAX));
            self.draft.corner_uvs.push(CornerUvs::NONE);
        }
        if self.draft.end_face() {
            self.draft.face_materials.push(self.material);
            self.face_lines.push(u32::try_from(line).unwrap_or(u32::MAX));
        } else {
            self.written.truncate(self.draft.corners.len());
        }
        Ok(())
    }

    fn finish(mut self, beside: &Beside<'_>) -> Result<Draft, Fault> {
        let mut draft = self.draft;
        let mut bad_uvs = 0;
        for f in 0..draft.face_count() {
            let line = self.face_lines[f] as usize;
            for corner in draft.face_corners(f) {
                let (v, vt) = self.written[corner];
                let fault = |_| {
                    let count = draft.positions.len();
                    Fault::line(
                        line,
                        format!("vertex index {} is out of range (there are {count} vertices)", v + 1),
                    )
                };
                vertex_index(v, draft.positions.len(), fault)?;
                let Some(vt) = vt else { continue };
                let point = usize::try_from(vt).ok().and_then(|vt| draft.uvs.get(vt));
                match point {
                    Some(p) if is_texture_point(*p) => draft.corner_uvs[corner] = vt as u32,
                    _ => bad_uvs += 1,
                }
            }
        }
        if bad_uvs > 0 {
            draft.mended.push(Mended::Uvs(bad_uvs));
        }
        if self.has_colors {
            let full = full_channel(self.colors.iter().flatten());
            draft.set_srgb_colors(std::mem::take(&mut self.colors), [full, full, full, 1.0]);
        } else if self.polypaint.len() == draft.positions.len() {
            draft.set_srgb_colors(std::mem::take(&mut self.polypaint), [255.0, 255.0, 255.0, 1.0]);
        } else if !self.polypaint.is_empty() {
            draft.mended.push(Mended::LeftOut("painted colors of another number of vertices".into()));
        }
        if draft.face_materials.iter().all(Option::is_none) {
            draft.face_materials.clear();
        }
        if self.free_form > 0 {
            draft.mended.push(Mended::LeftOut(format!("{} free-form curves and surfaces", self.free_form)));
        }
        mtl::read_into(&mut draft, &self.libraries, beside);
        Ok(draft)
    }
}

/// The color of a vertex.
fn painted(digits: &[u8]) -> Option<[f64; 4]> {
    let value = u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
    let [_, r, g, b] = value.to_be_bytes().map(f64::from);
    Some([r, g, b, 1.0])
}
