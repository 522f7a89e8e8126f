//! Stereolithography, ascii and binary. Corners at exactly equal positions become one vertex.

use std::collections::HashMap;

use super::draft::{Draft, coordinate};
use super::text::{Words, number, quoted};
use crate::error::Fault;
use crate::format::is_binary_stl;
use crate::read::Mended;

/// Reads a binary STL (whatever its header says, if its length fits) or an ascii one with any
/// number of solids. Normals, names and attribute bytes are left out.
pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let solid = text.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // A truncated binary file may begin with "solid" too, but text never contains zeros.
    if is_binary_stl(bytes) || !solid || bytes.iter().take(512).any(|&b| b == 0) {
        read_binary(bytes)
    } else {
        read_ascii(text)
    }
}

#[derive(Default)]
struct Corners {
    draft: Draft,
    vertex: HashMap<[u64; 3], u32>,
}

impl Corners {
    fn push(&mut self, position: [f64; 3]) {
        let key = position.map(|x| (x + 0.0).to_bits());
        let next = self.draft.positions.len() as u32;
        let v = *self.vertex.entry(key).or_insert(next);
        if v == next {
            self.draft.positions.push(position);
        }
        self.draft.corners.push(v);
    }
}

fn read_binary(bytes: &[u8]) -> Result<Draft, Fault> {
    let Some((header, body)) = bytes.split_at_checked(84) else {
        return Err(Fault::byte(bytes.len(), "neither ascii ('solid') nor long enough for a binary header"));
    };
    let count = header[80..].iter().rev().fold(0_usize, |count, &b| count << 8 | usize::from(b));
    let there = body.len() / 50;
    if there < count {
        let reason = format!("the file ends after {there} of {count} triangles (or is no STL)");
        return Err(Fault::byte(bytes.len(), reason));
    }
    let mut corners = Corners::default();
    for (t, facet) in body.chunks_exact(50).take(count).enumerate() {
        for corner in 0..3 {
            let mut position = [0.0; 3];
            for (i, p) in position.iter_mut().enumerate() {
                let start = 12 + 12 * corner + 4 * i;
                let word = facet[start..].first_chunk::<4>().copied().unwrap_or_default();
                let x = f64::from(f32::from_le_bytes(word));
                *p = coordinate(x, |reason| Fault::byte(84 + 50 * t + start, reason))?;
            }
            corners.push(position);
        }
        corners.draft.end_face();
    }
    let trailing = body.len() - 50 * count;
    if trailing > 0 {
        corners.draft.mended.push(Mended::TrailingBytes(trailing));
    }
    Ok(corners.draft)
}

fn read_ascii(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut corners = Corners::default();
    let mut words = Words::new(bytes, 1, None);
    let mut in_solid = false;
    let mut pushed = 0;
    while let Some(word) = words.next() {
        let line = words.line();
        // No keyword is longer.
        let mut lower = [0_u8; 8];
        let keyword = lower.get_mut(..word.len()).map_or(word, |lower| {
            lower.copy_from_slice(word);
            lower.make_ascii_lowercase();
            &*lower
        });
        match keyword {
            b"solid" | b"endsolid" => {
                in_solid = keyword == b"solid";
                // A name of any number of words follows.
                words.end_line();
            }
            b"vertex" => {
                let mut position = [0.0; 3];
                for p in &mut position {
                    let x = words.number("a coordinate")?;
                    *p = coordinate(x, |reason| Fault::line(words.line(), reason))?;
                }
                corners.push(position);
                pushed += 1;
            }
            b"endloop" => {
                if pushed < 3 {
                    return Err(Fault::line(line, "a facet needs three corners"));
                }
                corners.draft.end_face();
                pushed = 0;
            }
            b"normal" => {
                for _ in 0..3 {
                    // The normal is ignored, even if invalid.
                    let word = words.next().unwrap_or_default();
                    number::<f64>(word, words.line(), "a normal")?;
                }
            }
            b"facet" | b"outer" | b"loop" | b"endfacet" => {}
            _ => return Err(Fault::line(line, format!("{} is no word of STL", quoted(word)))),
        }
    }
    if in_solid || pushed > 0 {
        return Err(Fault::line(words.line(), "the file ends before 'endsolid'"));
    }
    Ok(corners.draft)
}
