//! Geomview OFF, ascii and binary.

use super::draft::{Draft, coordinate, full_channel, is_texture_point, vertex_index};
use super::text::{Lines, number, quoted, words};
use crate::CornerUvs;
use crate::error::Fault;
use crate::format::{OffVertex, off_keyword};
use crate::read::Mended;

/// Reads `[ST][C][N]OFF` with comments anywhere, and `OFF BINARY` in either byte order (the
/// format says big-endian, the programs that write it do not). Normals and face colors are
/// left out.
pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut lines = Lines::new(bytes, Some(b'#'), false);
    let mut joined = Vec::new();
    let header = lines.next(&mut joined).unwrap_or_default();
    let word = words(header).next().unwrap_or_default();
    let Some((vertex, keyword_length)) = off_keyword(word) else {
        return Err(Fault::line(lines.number(), format!("{} where 'OFF' should stand", quoted(word))));
    };
    if vertex.homogeneous || vertex.any_dimension {
        return Err(Fault::line(lines.number(), "only OFF files of three dimensions are read"));
    }
    let after = header[keyword_length..].trim_ascii();
    if after.starts_with(b"BINARY") {
        let body = bytes.iter().position(|&b| b == b'\n').map_or(bytes.len(), |end| end + 1);
        return read_binary(bytes, body, vertex);
    }
    read_ascii(after, lines, vertex)
}

fn read_ascii(after: &[u8], mut lines: Lines<'_>, vertex: OffVertex) -> Result<Draft, Fault> {
    let (mut first, mut joined) = (Vec::new(), Vec::new());
    let counts = match after {
        b"" => lines.next(&mut first).unwrap_or_default(),
        counts => counts,
    };
    let line = lines.number();
    let mut counts = words(counts);
    let mut count = |what| number::<usize>(counts.next().unwrap_or_default(), line, what);
    let (vertices, faces) = (count("the number of vertices")?, count("the number of faces")?);

    let mut draft = Draft::default();
    let mut colors = Vec::new();
    for v in 0..vertices {
        let Some(text) = lines.next(&mut joined) else {
            let reason = format!("the file ends after {v} of {vertices} vertices");
            return Err(Fault::line(lines.number(), reason));
        };
        let line = lines.number();
        let mut parts = words(text);
        let mut next = |what| number::<f64>(parts.next().unwrap_or_default(), line, what);
        let mut position = [0.0; 3];
        for p in &mut position {
            *p = coordinate(next("a coordinate")?, |reason| Fault::line(line, reason))?;
        }
        draft.positions.push(position);
        if vertex.normal {
            for _ in 0..3 {
                next("a normal")?;
            }
        }
        let mut rest = Vec::new();
        for word in parts.take(6) {
            rest.push(number::<f64>(word, line, "a color or texture coordinate")?);
        }
        let uv = if vertex.texture { rest.split_off(rest.len().saturating_sub(2)) } else { Vec::new() };
        if let [u, v] = uv[..] {
            draft.uvs.push([u, v]);
        }
        if vertex.color {
            let channel = |i: usize| rest.get(i).copied();
            let [r, g, b] = [0, 1, 2].map(|i| channel(i).unwrap_or(f64::NAN));
            colors.push([r, g, b, channel(3).unwrap_or(f64::MAX)]);
        }
    }
    let has_uvs =
        vertex.texture && draft.uvs.len() == vertices && draft.uvs.iter().all(|uv| is_texture_point(*uv));
    if vertex.texture && !has_uvs {
        draft.mended.push(Mended::Uvs(vertices));
    }
    read_ascii_faces(&mut draft, &mut lines, faces, has_uvs)?;
    if vertex.color {
        let full = full_channel(colors.iter().flatten());
        draft.set_srgb_colors(colors, [full; 4]);
    }
    Ok(draft)
}

fn read_ascii_faces(draft: &mut Draft, lines: &mut Lines<'_>, faces: usize, uvs: bool) -> Result<(), Fault> {
    let mut joined = Vec::new();
    for f in 0..faces {
        let Some(text) = lines.next(&mut joined) else {
            let reason = format!("the file ends after {f} of {faces} faces");
            return Err(Fault::line(lines.number(), reason));
        };
        let line = lines.number();
        let mut parts = words(text);
        let corners: usize = number(parts.next().unwrap_or_default(), line, "a number of corners")?;
        for _ in 0..corners {
            let index = number(parts.next().unwrap_or_default(), line, "a vertex index")?;
            let v = vertex_index(index, draft.positions.len(), |reason| Fault::line(line, reason))?;
            draft.corners.push(v);
            draft.corner_uvs.push(if uvs { v } else { CornerUvs::NONE });
        }
        draft.end_face();
    }
    Ok(())
}

fn read_binary(bytes: &[u8], body: usize, vertex: OffVertex) -> Result<Draft, Fault> {
    if vertex.texture || vertex.color || vertex.normal {
        return Err(Fault::byte(
            0,
            "binary OFF is read without colors, normals and texture coordinates only",
        ));
    }
    // Byte order and whether faces have colors can only be found by trying which combination matches the
    // file's length.
    let variants = [(true, false), (false, false), (true, true), (false, true)];
    let mut first_fault = None;
    for (little_endian, colors) in variants {
        let mut binary = Binary { bytes, at: body, little_endian };
        match binary.mesh(colors) {
            Ok(draft) if binary.at == bytes.len() => return Ok(draft),
            Ok(_) => {
                let reason = "the file goes on after the last face";
                first_fault.get_or_insert(Fault::byte(binary.at, reason));
            }
            Err(fault) => {
                first_fault.get_or_insert(fault);
            }
        }
    }
    Err(first_fault.unwrap_or_else(|| Fault::byte(body, "no data")))
}

struct Binary<'a> {
    bytes: &'a [u8],
    at: usize,
    little_endian: bool,
}

impl Binary<'_> {
    fn word(&mut self, what: &str) -> Result<[u8; 4], Fault> {
        let word = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<4>());
        let Some(mut word) = word.copied() else {
            return Err(Fault::byte(self.bytes.len(), format!("the file ends where {what} should follow")));
        };
        self.at += 4;
        if !self.little_endian {
            word.reverse();
        }
        Ok(word)
    }

    fn count(&mut self, what: &str) -> Result<usize, Fault> {
        let count = u32::from_le_bytes(self.word(what)?) as usize;
        // Each counted thing takes at least one word.
        if count > (self.bytes.len() - self.at) / 4 {
            return Err(Fault::byte(self.at - 4, format!("{what} is {count}, more than the file can hold")));
        }
        Ok(count)
    }

    fn mesh(&mut self, colors: bool) -> Result<Draft, Fault> {
        let mut draft = Draft::default();
        let vertices = self.count("the number of vertices")?;
        let faces = self.count("the number of faces")?;
        self.word("the number of edges")?;
        for _ in 0..vertices {
            let mut position = [0.0; 3];
            for p in &mut position {
                let at = self.at;
                let x = f32::from_le_bytes(self.word("a coordinate")?);
                *p = coordinate(f64::from(x), |reason| Fault::byte(at, reason))?;
            }
            draft.positions.push(position);
        }
        for _ in 0..faces {
            for _ in 0..self.count("the number of corners")? {
                let at = self.at;
                let index = i64::from(u32::from_le_bytes(self.word("a vertex index")?));
                draft.corners.push(vertex_index(index, vertices, |reason| Fault::byte(at, reason))?);
            }
            draft.end_face();
            if colors {
                for _ in 0..self.count("the number of color channels")? {
                    self.word("a color")?;
                }
            }
        }
        Ok(draft)
    }
}
